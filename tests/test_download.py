"""`affectsim download`: what lands is verified, resumable, and a release only when it is whole."""

from __future__ import annotations

import _thread
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hub_commands import Client, client_environment
from hub_server import COMMIT, REPO_ID, Hub, serve_hub
from small_release import write_release
from tqdm import tqdm

from affectsim_data.cli import main
from affectsim_data.releases import MANIFEST_NAME, Release, open_release, writing
from affectsim_data.releases import transfers as transfers_module
from affectsim_data.releases.downloading import Download, download_to_folder
from affectsim_data.releases.file_locks import opened, try_lock
from affectsim_data.releases.planning import files_of, select
from affectsim_data.releases.selection import held_rows
from affectsim_data.releases.stores import FolderStore
from affectsim_data.releases.transfers import Progress, transfer

ADDRESS = f"hf://datasets/{REPO_ID}"
PINNED = f"{ADDRESS}@{COMMIT}"
SCENE, MOTION = "scenes/scenes-00001-of-00002.parquet", "motions/motions-00004-of-00007.parquet"


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small release with every episode in a shard of its own, and a card."""
    out = tmp_path_factory.mktemp("source") / "small"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writing, "_EPISODES_PER_SHARD", 1)
        write_release(out)
    (out / "README.md").write_text("# small\n")
    return out


@pytest.fixture
def source_copy(source: Path, tmp_path: Path) -> Path:
    """A copy a test may break."""
    return Path(shutil.copytree(source, tmp_path / "source"))


def fetch(source: Path, out: Path, **part: Any) -> Download:
    """Downloads a part of a folder."""
    release = Release(FolderStore(source))
    return download_to_folder(release, FolderStore(source), select(release, **part), out, jobs=2)


def tree(root: Path) -> dict[str, bytes]:
    """Contents of all files below a folder, by path."""
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for path in root.rglob("*")
        if path.is_file()
    }


def test_a_whole_download_is_the_release_byte_for_byte(source: Path, tmp_path: Path) -> None:
    done = fetch(source, tmp_path / "new" / "copy")
    assert tree(tmp_path / "new" / "copy") == tree(source)
    assert done.manifest.partial_of is None
    assert len(done.names) == 20


def test_a_split_is_a_release_of_its_own(source: Path, tmp_path: Path) -> None:
    fetch(source, tmp_path / "part", splits=["test"])
    whole, part = Release(FolderStore(source)), Release(FolderStore(tmp_path / "part"))
    assert part.episode_table("test").equals(whole.episode_table("test"))
    for row in range(2):
        world = part.world(part.episode("test", row))
        assert world.scene.scene_id == whole.episode("test", row).scene_id
    names = {*part.manifest.files, MANIFEST_NAME, "README.md"}
    assert set(tree(tmp_path / "part")) == names
    assert set(part.manifest.files) == set(files_of(whole, select(whole, splits=["test"])))


def test_a_partial_manifest_says_what_it_is(source: Path, tmp_path: Path) -> None:
    fetch(source, tmp_path / "part", splits=["test"], scene_ids=["crate_room"])
    manifest = FolderStore(tmp_path / "part").manifest
    assert json.loads((tmp_path / "part" / MANIFEST_NAME).read_text())["partial_of"] == {
        "uri": str(source.resolve()),
        "manifest_sha256": FolderStore(source).manifest.sha256,
        "scene_ids": {"test": ["crate_room"]},
        "splits": ["train", "validation", "test"],
        "first_rows": {"episodes/test-00001-of-00002.parquet": 1},
    }
    assert manifest.scene_ids("test") == frozenset({"crate_room"})
    assert manifest.first_rows("test") == {"episodes/test-00001-of-00002.parquet": 1}
    whole = FolderStore(source).manifest
    assert whole.scene_ids("test") is None
    assert list(whole.first_rows("test").values()) == [0, 1]


def test_a_split_that_is_not_here_is_named_with_the_way_to_it(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "part"
    fetch(source, part, splits=["test"])
    assert main(["plan", str(part), "--split", "train"]) == 1
    assert (
        f"{part}: this copy holds only split test; `affectsim download {source.resolve()} "
        f"--split train --out {part}` adds split train"
    ) in capsys.readouterr().err


def test_more_is_added_until_it_is_the_release(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "part"
    fetch(source, out, splits=["test"], scene_ids=["crate_room"])
    fetch(source, out, splits=["train"])
    done = fetch(source, out, splits=["test"], scene_ids=["empty_room"])
    assert done.manifest.partial_of is not None
    assert done.manifest.partial_of.describe() == "split train, 2 scenes of split test"
    fetch(source, out, splits=["test"])
    assert FolderStore(out).manifest.scene_ids("test") is None
    fetch(source, out)
    assert tree(out) == tree(source)


def test_a_part_of_a_part_names_the_whole(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "part"
    fetch(source, part, splits=["test"], scene_ids=["crate_room"])
    fetch(source, part, splits=["train"])
    fetch(part, tmp_path / "same")
    assert tree(tmp_path / "same") == tree(part)
    fetch(part, tmp_path / "less", splits=["test"])
    fetch(source, tmp_path / "direct", splits=["test"], scene_ids=["crate_room"])
    assert tree(tmp_path / "less") == tree(tmp_path / "direct")
    assert main(["plan", str(part), "--split", "test", "--scenes", "empty_room"]) == 1
    assert "is in empty_room; scenes with episodes: crate_room" in capsys.readouterr().err
    with pytest.raises(FileExistsError, match=f"files that .* lacks; download from {source}"):
        fetch(tmp_path / "less", part)


def test_a_part_of_a_split_holds_its_episodes(source: Path, tmp_path: Path) -> None:
    fetch(source, tmp_path / "part", splits=["test"], scene_ids=["crate_room"])
    whole, part = Release(FolderStore(source)), Release(FolderStore(tmp_path / "part"))
    assert held_rows(part, "test").tolist() == [1]
    episode = part.episode("test", 1)
    assert episode == whole.episode("test", 1)
    assert [person.motion.motion_id for person in part.world(episode).people] == [
        "sway_sad",
        "circle_angry",
    ]
    with pytest.raises(ValueError, match=r"this copy holds only 1 scene of split test; `affectsim"):
        part.episode_index("train")


def test_damage_is_mended(source: Path, tmp_path: Path) -> None:
    out = tmp_path / "copy"
    fetch(source, out)
    (out / SCENE).unlink()
    (out / MOTION).write_bytes((out / MOTION).read_bytes()[:-1] + b"?")
    kept = (out / "index/test-00000-of-00001.parquet").stat().st_mtime_ns
    fetch(source, out)
    assert tree(out) == tree(source)
    assert (out / "index/test-00000-of-00001.parquet").stat().st_mtime_ns == kept


_KILLED = """
import os, signal, sys
from pathlib import Path
from affectsim_data.releases import MANIFEST_NAME, Release
from affectsim_data.releases.downloading import download_to_folder
from affectsim_data.releases.planning import select
from affectsim_data.releases.selection import held_rows
from affectsim_data.releases.stores import FolderStore

source, out = map(Path, sys.argv[1:3])
store = FolderStore(source)
release, replace = Release(store), os.replace
for last in range(30):
    child = os.fork()
    if child == 0:
        calls = iter(range(last))
        def killing(*paths):
            if next(calls, None) is None:
                os.kill(os.getpid(), signal.SIGKILL)
            replace(*paths)
        os.replace = killing
        place = out / str(last) if "anew" in sys.argv else out / "same"
        try:
            download_to_folder(release, store, select(release), place, jobs=2)
        finally:
            os._exit(0)
    _, status = os.waitpid(child, 0)
    place = out / str(last) if "anew" in sys.argv else out / "same"
    whole = (place / MANIFEST_NAME).exists()
    print(last, os.WIFSIGNALED(status), whole, len(list(place.glob("*/*.parquet"))))
    if not os.WIFSIGNALED(status):
        break
"""


@pytest.mark.parametrize("mode", ["anew", "again"])
def test_a_killed_download_is_gone_on_with(source: Path, tmp_path: Path, mode: str) -> None:
    command = [sys.executable, "-c", _KILLED, str(source), str(tmp_path), mode]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=100)
    rows = [line.split() for line in done.stdout.splitlines()]
    assert rows[-1][1:] == ["False", "True", "20"]
    assert all(row[1:3] == ["True", "False"] for row in rows[:-1]), "half of it is no release"
    counts = [int(row[3]) for row in rows]
    assert counts == sorted(counts), "what was verified is kept"
    assert counts[1] == 0
    assert max(counts[:-1]) == 20
    for out in tmp_path.iterdir():
        fetch(source, out)
        assert tree(out) == tree(source)


def test_an_unfinished_download_does_not_open(source_copy: Path, tmp_path: Path) -> None:
    (source_copy / SCENE).write_bytes(b"nonsense")
    with pytest.raises(ConnectionError, match="1 of 20 files could not be had"):
        fetch(source_copy, tmp_path / "out")
    with pytest.raises(FileNotFoundError, match=r"no MANIFEST\.json"):
        open_release(tmp_path / "out")


def test_all_failures_are_told(source_copy: Path, tmp_path: Path) -> None:
    for name in (SCENE, MOTION):
        (source_copy / name).write_bytes(b"nonsense")
    with pytest.raises(ConnectionError) as caught:
        fetch(source_copy, tmp_path / "out")
    first, *lines = str(caught.value).splitlines()
    assert first == "2 of 20 files could not be had:"
    assert [line.split(": expected")[0].strip() for line in lines] == [
        f"{source_copy}/{name}" for name in (MOTION, SCENE)
    ]
    assert len(list((tmp_path / "out").glob("*/*.parquet"))) == 18


def test_other_things_are_left_alone(source: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(FileExistsError, match="exists and is no release; choose another --out"):
        fetch(source, tmp_path)
    with pytest.raises(FileExistsError, match=r"thesis\.tex: is a file; choose another --out"):
        fetch(source, tmp_path / "thesis.tex")
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize("whole", [True, False])
def test_versions_are_not_mixed(source: Path, tmp_path: Path, whole: bool) -> None:
    write_release(tmp_path / "other", seed=8)
    part = {} if whole else {"splits": ["test"]}
    fetch(tmp_path / "other", tmp_path / "out", **part)
    before = tree(tmp_path / "out")
    held = "the release 'small'" if whole else str(tmp_path / "other")
    with pytest.raises(FileExistsError, match=f"out: holds {held}, which is not the same as"):
        fetch(source, tmp_path / "out", splits=["test"])
    assert tree(tmp_path / "out") == before


def test_an_unfinished_download_of_another_version_is_left_alone(
    source: Path, source_copy: Path, tmp_path: Path
) -> None:
    write_release(source_copy, seed=8, overwrite=True)
    (source_copy / SCENE).write_bytes(b"nonsense")
    with pytest.raises(ConnectionError):
        fetch(source_copy, tmp_path / "out")
    with pytest.raises(FileExistsError, match=f"holds {source_copy}, which is not the same as"):
        fetch(source, tmp_path / "out")


def test_two_downloads_do_not_share_a_folder(source: Path, tmp_path: Path) -> None:
    fetch(source, tmp_path / "out", splits=["test"])
    with opened(tmp_path / "out" / ".download.lock", os.O_RDWR | os.O_CREAT) as fd:
        assert try_lock(fd)
        with pytest.raises(FileExistsError, match="another download into it is running"):
            fetch(source, tmp_path / "out")


def test_a_full_disk_is_noticed_before_anything_is_fetched(
    source: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fetch(source, tmp_path / "out", splits=["test"])
    before = tree(tmp_path / "out")
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    monkeypatch.setattr(shutil, "disk_usage", lambda path: usage)
    with pytest.raises(ValueError, match=r"out: \d+\.\d kB to fetch, only 1.0 kB are free there"):
        fetch(source, tmp_path / "out")
    assert tree(tmp_path / "out") == before
    fetch(source, tmp_path / "out", splits=["test"])  # needs nothing


def test_a_folder_without_out_has_nothing_to_fetch(
    source: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["download", str(source)]) == 1
    assert "is a folder, there is nothing to fetch; --out FOLDER copies it" in (
        capsys.readouterr().err
    )


def test_download_says_what_is_there(
    source: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["download", str(source), "--split", "test", "--out", str(out)]) == 0
    text = capsys.readouterr()
    size = sum(entry.bytes for entry in FolderStore(out).manifest.files.values()) / 1000
    assert text.out.splitlines() == [
        f"{out}: 10 files, {size:.1f} kB, all verified",
        f"  split test of {source.resolve()}",
    ]
    assert "small: fetching: 100%" in text.err


# What runs in many threads


def test_one_failure_hides_no_other() -> None:
    def work(name: str, progress: Progress) -> None:
        progress(5)
        if name in ("b", "d"):
            raise ConnectionError(f"{name} failed")

    failures = transfer(dict.fromkeys("abcdef", 10), work, jobs=3, label="test")
    assert {name: str(error) for name, error in failures.items()} == {
        "b": "b failed",
        "d": "d failed",
    }


def test_when_all_fails_the_rest_is_not_tried() -> None:
    tried = []

    def work(name: str, progress: Progress) -> None:
        tried.append(name)
        raise ConnectionError(f"{name} failed")

    names = [f"{number:04d}" for number in range(1000)]
    failures = transfer(dict.fromkeys(names, 1), work, jobs=2, label="test")
    assert sorted(failures) == names
    assert 32 <= len(tried) < 100
    assert "not tried, as so many before it failed" in str(failures["0999"])


def test_a_bug_is_not_taken_for_a_broken_file() -> None:
    def work(name: str, progress: Progress) -> None:
        raise TypeError("a bug")

    with pytest.raises(TypeError, match="a bug"):
        transfer({"a": 1, "b": 1}, work, jobs=2, label="test")
    with pytest.raises(ValueError, match="jobs must be at least 1, got 0"):
        transfer({"a": 1}, work, jobs=0, label="test")


def test_the_bar_ends_at_all_bytes(monkeypatch: pytest.MonkeyPatch) -> None:
    bars: list[Any] = []

    class Recorded(tqdm):  # type: ignore[misc]  # tqdm has no types
        def __init__(self, *args: Any, **options: Any) -> None:
            super().__init__(*args, **options)
            bars.append(self)

    monkeypatch.setattr(transfers_module, "tqdm", Recorded)

    def work(name: str, progress: Progress) -> None:
        for _ in range({"resumed": 1, "whole": 2, "twice": 4, "broken": 1}[name]):
            progress(50)
        if name == "broken":
            raise ValueError("broken")

    sizes = dict.fromkeys(("resumed", "whole", "twice", "broken"), 100)
    transfer(sizes, work, jobs=1, label="test")
    assert (bars[0].n, bars[0].total) == (300, 400)


def test_an_interrupt_ends_work_under_way(
    source: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    waiting, ended = threading.Event(), threading.Event()
    read = FolderStore.read

    def endless(self: FolderStore, name: str) -> bytes:
        if name == SCENE:
            waiting.set()
            assert ended.wait(30)
        elif name.startswith("index/validation"):
            assert waiting.wait(30)
            _thread.interrupt_main()
            ended.set()
        return read(self, name)

    monkeypatch.setattr(FolderStore, "read", endless)
    command = ["download", str(source), "--out", str(tmp_path / "out"), "--jobs", "20"]
    # A shell that starts us in the background has us ignore interrupts.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert main(command) == 130
    finally:
        signal.signal(signal.SIGINT, before)
    error = capsys.readouterr().err
    assert "interrupted; what is verified is kept, run the same command to go on" in error
    assert not (tmp_path / "out" / MANIFEST_NAME).exists()
    monkeypatch.undo()
    assert main(command) == 0
    assert tree(tmp_path / "out") == tree(source)


# From the Hub


@pytest.fixture
def hub(source: Path, tmp_path: Path) -> Iterator[Hub]:
    """A Hub that serves a copy of the release."""
    root = Path(shutil.copytree(source, tmp_path / "repository"))
    with serve_hub(root) as server:
        yield server


def test_a_part_is_planned_fetched_and_read_offline(hub: Hub, tmp_path: Path) -> None:
    part = ["--split", "test", "--scenes", "crate_room"]
    with Client(hub, tmp_path) as client:
        _, text, _ = client.run("plan", ADDRESS, *part, "--json")
        before = json.loads(text)
        assert before["uri"] == PINNED
        assert (before["total"]["files"], before["total"]["fetch_files"]) == (7, 6)
        status, text, error = client.run("download", ADDRESS, *part)
        assert (status, text.splitlines()[1]) == (0, f"  {PINNED}"), error
        assert re.match(r"cache: 7 files, [\d.]+ kB, all verified", text)
        _, text, _ = client.run("plan", ADDRESS, *part, "--json")
        assert json.loads(text)["total"]["fetch_bytes"] == 0
    hub.requests.clear()
    with Client(hub, tmp_path, HF_HUB_OFFLINE="1") as client:
        assert client.run("download", PINNED, *part)[0] == 0
        status, _, error = client.run("download", PINNED)
        assert status == 1
        assert "of 20 files could not be had; run the same command again" in error
    assert hub.requests == []


def test_a_folder_from_the_hub_is_the_release(hub: Hub, source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    with Client(hub, tmp_path) as client:
        client.run("download", ADDRESS, "--split", "validation", "--out", out)
        assert FolderStore(out).manifest.partial_of is not None
        assert FolderStore(out).manifest.partial_of.uri == PINNED  # type: ignore[union-attr]
        hub.requests.clear()
        status, text, error = client.run("download", ADDRESS, "--out", out)
        assert (status, text.splitlines()[-1]) == (0, f"  {PINNED}"), error
    assert not {"index/validation-00000-of-00001.parquet", SCENE} & set(hub.fetched())
    assert tree(out) == tree(source)


def test_broken_files_are_told_and_the_rest_is_kept(hub: Hub, source: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    for name in (SCENE, MOTION):
        hub.replaced[name] = [b"nonsense"]
    with Client(hub, tmp_path) as client:
        status, _, error = client.run("download", ADDRESS, "--out", out)
        assert status == 1
        assert "affectsim: 2 of 20 files could not be had" in error
        size = (source / SCENE).stat().st_size
        assert f"{PINNED}/{SCENE}: expected {size} bytes, got truncated: 8 bytes" in error
        assert f"{PINNED}/{MOTION}: expected" in error
        assert not (out / MANIFEST_NAME).exists()
        hub.replaced.clear()
        hub.requests.clear()
        assert client.run("download", ADDRESS, "--out", out)[0] == 0
    assert {name for name in hub.fetched() if "/" in name} == {SCENE, MOTION}
    assert tree(out) == tree(source)


def test_what_the_cache_cannot_hold_is_refused_before_it_is_fetched(
    hub: Hub, tmp_path: Path
) -> None:
    with Client(hub, tmp_path, AFFECTSIM_CACHE_LIMIT="100kB") as client:
        _, text, _ = client.run("plan", ADDRESS)
        assert "the local cache holds at most 100.0 kB" in text
        assert "give `affectsim download` an --out" in text
        hub.requests.clear()
        status, _, error = client.run("download", ADDRESS)
        assert status == 1
        assert re.search(
            r"selection is 2\d\d\.\d kB, the local cache holds at most 100.0 kB", error
        )
        assert "set AFFECTSIM_CACHE_LIMIT, choose less by --split or --scenes" in error
        assert client.run("download", ADDRESS, "--split", "test", "--scenes", "crate_room")[0] == 0
    assert SCENE in hub.fetched()
    assert "scenes/scenes-00000-of-00002.parquet" not in hub.fetched()


_KILLED_AT_RANDOM = """
import os, random, signal, sys, time
from pathlib import Path
import affectsim_data.releases.downloading, huggingface_hub.file_download
from affectsim_data.cli import main

address, folder = sys.argv[1], Path(sys.argv[2])
rng = random.Random(3)
number = 0
for _ in range(20):
    child = os.fork()
    if child == 0:
        try:
            main(["download", address, "--jobs", "2", "--out", str(folder / str(number))])
        finally:
            os._exit(0)
    time.sleep(rng.uniform(0.0, 0.5))
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    number += (folder / str(number) / "MANIFEST.json").exists()
sys.exit(main(["download", address, "--out", str(folder / str(number))]))
"""


def test_a_download_from_the_hub_is_gone_on_with_wherever_it_was_killed(
    hub: Hub, source: Path, tmp_path: Path
) -> None:
    hub.bytes_per_s = 300_000.0
    sizes = [len(content) for content in tree(source).values()]
    command = [sys.executable, "-c", _KILLED_AT_RANDOM, PINNED, str(tmp_path / "out")]
    settings = client_environment(hub, tmp_path)
    done = subprocess.run(command, env=settings, capture_output=True, text=True, timeout=200)
    assert done.returncode == 0, done.stderr
    copies = list((tmp_path / "out").iterdir())
    assert all(tree(copy) == tree(source) for copy in copies)
    # What had come was not fetched again, but for the two files on their way at each kill.
    assert hub.bytes_sent <= sum(sizes) * len(copies) + 20 * 2 * max(sizes)
