"""`affectsim plan`: which files a part of a release needs, and how many of them are here."""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import json
from collections.abc import Callable
from pathlib import Path

import pytest
from small_release import small_rows, write_release

from affectsim_data.cli import main
from affectsim_data.releases import MANIFEST_NAME, FileEntry, Manifest, Release, writing
from affectsim_data.releases.planning import Selection, files_of, make_plan, select
from affectsim_data.releases.stores import FolderStore
from affectsim_data.schemas import SPLITS

CRATE_TEST_FILES = [
    "avatars/avatars-00000-of-00002.parquet",
    "avatars/avatars-00001-of-00002.parquet",
    "episodes/test-00001-of-00002.parquet",
    "index/test-00000-of-00001.parquet",
    "motions/motions-00004-of-00007.parquet",
    "motions/motions-00006-of-00007.parquet",
    "scenes/scenes-00001-of-00002.parquet",
]
"""The dyad of the test split: its shard, its room, two bodies, `sway_sad` and `circle_angry`."""


@pytest.fixture(scope="module")
def sharded_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small release with every episode in a shard of its own."""
    out = tmp_path_factory.mktemp("sharded") / "small"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(writing, "_EPISODES_PER_SHARD", 1)
        write_release(out)
    return out


@pytest.fixture(scope="module")
def sharded(sharded_path: Path) -> Release:
    return Release(FolderStore(sharded_path))


def add_file(root: Path, name: str) -> None:
    """Puts one more file into a release and its manifest."""
    path = root / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes(name.encode())
    manifest = Manifest.from_path(root / MANIFEST_NAME, name="manifest")
    entry = FileEntry(len(name), hashlib.sha256(name.encode()).hexdigest(), 1)
    files = dict(sorted({**manifest.files, name: entry}.items()))
    text = dataclasses.replace(manifest, files=files).to_json()
    (root / MANIFEST_NAME).write_text(text, encoding="utf-8")


def test_everything_is_every_file(sharded: Release) -> None:
    assert files_of(sharded, select(sharded)) == list(sharded.manifest.files)
    assert files_of(sharded, select(sharded, tables=())) == list(sharded.manifest.files)


def test_a_scene_of_a_split_is_what_its_episodes_need(sharded: Release) -> None:
    selection = select(sharded, splits=["test"], scene_ids=["crate_room"])
    assert selection == Selection(("test",), ("crate_room",))
    assert files_of(sharded, selection) == CRATE_TEST_FILES


@pytest.mark.parametrize("split", SPLITS)
def test_the_scenes_of_a_split_together_are_the_split(sharded: Release, split: str) -> None:
    rooms = sharded.asset_ids("scenes")
    parts = [
        set(files_of(sharded, select(sharded, splits=[split], scene_ids=[room]))) for room in rooms
    ]
    assert set[str]().union(*parts) == set(files_of(sharded, select(sharded, splits=[split])))
    shards = [{name for name in part if name.startswith("episodes/")} for part in parts]
    assert all(not first & second for first, second in itertools.combinations(shards, 2))


def test_names_are_taken_once_and_in_order(sharded: Release) -> None:
    selection = select(
        sharded, splits=["test", "train", "test"], scene_ids=["empty_room", "crate_room"] * 2
    )
    assert selection.splits == ("train", "test")
    assert selection.scene_ids == ("crate_room", "empty_room")


def test_splits_without_an_episode_in_the_scenes_are_left_out(tmp_path: Path) -> None:
    rows = small_rows()
    rows["episodes"] = [
        row
        for row in rows["episodes"]
        if row["split"] != "train" or row["scene_id"] == "empty_room"
    ]
    write_release(tmp_path / "release", rows=rows)
    release = Release(FolderStore(tmp_path / "release"))
    assert select(release, scene_ids=["crate_room"]).splits == ("validation", "test")
    with pytest.raises(ValueError, match="no episode of train is in crate_room"):
        select(release, splits=["train", "test"], scene_ids=["crate_room"])


@pytest.mark.parametrize(
    ("splits", "tables", "extra"),
    [
        ([], None, ["baseline-test", "baseline-train-00000-of-00001", "notes"]),
        (["test"], None, ["baseline-test"]),
        (["train", "test"], ["trajectories"], ["baseline-test", "baseline-train-00000-of-00001"]),
        (["test"], [], []),
        (["validation"], None, []),
    ],
)
def test_trajectories_come_with_their_split(
    release_copy: Path, splits: list[str], tables: list[str] | None, extra: list[str]
) -> None:
    for stem in ("baseline-test", "baseline-train-00000-of-00001", "notes"):
        add_file(release_copy, f"trajectories/{stem}.parquet")
    release = Release(FolderStore(release_copy))
    found = files_of(release, select(release, splits=splits, tables=tables))
    assert [name for name in found if name.startswith("trajectories/")] == [
        f"trajectories/{stem}.parquet" for stem in extra
    ]


class HalfHere(FolderStore):
    """A store whose assets are far away."""

    def is_local(self, name: str) -> bool:
        return name.startswith(("index/", "episodes/"))


def test_a_plan_tells_what_is_here(sharded_path: Path) -> None:
    store = HalfHere(sharded_path)
    release = Release(store)
    plan = make_plan(release, store, select(release, splits=["test"], scene_ids=["crate_room"]))
    files = release.manifest.files
    assert list(plan.tables) == ["index", "episodes", "motions", "scenes", "avatars"]
    assert sum(share.files for share in plan.tables.values()) == len(CRATE_TEST_FILES)
    assert plan.total.bytes == sum(files[name].bytes for name in CRATE_TEST_FILES)
    assert plan.total.local_files == 2
    assert plan.tables["episodes"].local_bytes == files[CRATE_TEST_FILES[2]].bytes
    assert plan.total.to_json()["fetch_bytes"] == sum(
        files[name].bytes for name in CRATE_TEST_FILES if not store.is_local(name)
    )


def test_plan_prints_tables_or_json(sharded_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["plan", str(sharded_path), "--split", "test", "--scenes", "crate_room"]
    assert main([*arguments, "--condition", "p_ref", "--condition", "a_obs"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == f"{sharded_path}: split test, 1 scene: crate_room"
    assert lines[1].split() == ["table", "files", "size", "here", "to", "fetch", "size"]
    assert lines[-2].split()[:2] == ["total", "7"]
    assert lines[-1] == "  the local cache holds at most 32.0 GB"
    assert main([*arguments, "--json"]) == 0
    plan = json.loads(capsys.readouterr().out)
    assert plan["splits"] == ["test"]
    assert plan["scene_ids"] == ["crate_room"]
    assert plan["tables"]["motions"]["files"] == 2
    assert plan["total"]["fetch_files"] == 0
    assert plan["cache_limit_bytes"] == 32 * 10**9


def without_training(root: Path) -> None:
    write_release(root, splits=("test",), overwrite=True)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (None, ["--split", "dev"], "no split 'dev'; it has train, validation, test"),
        (without_training, ["--split", "train"], "no split 'train'; it has test"),
        (
            None,
            ["--scenes", "attic", "crate_room"],
            "no episode of train, validation, test is in attic; "
            "scenes with episodes: crate_room, empty_room",
        ),
        (
            None,
            ["--condition", "p_reff"],
            "condition must be one of a_obs, p_init, p_mon, p_ref, got 'p_reff'",
        ),
    ],
)
def test_unknown_names_are_refused_with_those_there_are(
    release_copy: Path,
    capsys: pytest.CaptureFixture[str],
    change: Callable[[Path], None] | None,
    options: list[str],
    message: str,
) -> None:
    if change is not None:
        change(release_copy)
    for command in ("plan", "download"):
        assert main([command, str(release_copy), *options]) == 1
        assert message in capsys.readouterr().err
