"""`affectsim upload`: verified, in one commit, and what comes back is what was sent."""

from __future__ import annotations

import dataclasses
import json
import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from hub_commands import Client
from hub_server import COMMIT, REPO_ID
from hub_uploads import TOKEN, UploadHub, serve_uploads
from small_release import write_release

from affectsim_data.builders.corpus_recipe import load_recipe
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.cards import dataset_card
from affectsim_data.cli import main
from affectsim_data.content import content_path
from affectsim_data.releases import MANIFEST_NAME, open_release
from affectsim_data.releases.manifest import Source
from affectsim_data.releases.publishing import check_publishable
from affectsim_data.releases.stores import FolderStore

PLACE = f"hf://datasets/{REPO_ID}"
SCENE = "scenes/scenes-00001-of-00002.parquet"


@pytest.fixture
def hub(tmp_path: Path) -> Iterator[UploadHub]:
    """A Hub without a dataset."""
    with serve_uploads(tmp_path / "hub") as server:
        yield server


@pytest.fixture
def client(hub: UploadHub, tmp_path: Path) -> Iterator[Client]:
    """A user who may write."""
    with Client(hub, tmp_path / "home", HF_TOKEN=TOKEN) as process:
        yield process


def tree(root: Path) -> dict[str, bytes]:
    """Contents of all files below a folder, by path."""
    return {
        path.relative_to(root).as_posix(): path.read_bytes()
        for path in root.rglob("*")
        if path.is_file()
    }


def forbid_passing_on(root: Path, *sources: Source) -> None:
    """Makes it a release that may not be passed on, because of these sources."""
    entries = {"redistribution": False, "sources": [dataclasses.asdict(one) for one in sources]}
    document = json.loads((root / MANIFEST_NAME).read_text())
    (root / MANIFEST_NAME).write_text(json.dumps({**document, **entries}))


def test_what_was_uploaded_comes_back(
    hub: UploadHub, client: Client, release_copy: Path, tmp_path: Path
) -> None:
    status, text, error = client.run("upload", release_copy, REPO_ID, "--tag", "v1")
    assert status == 0, error
    assert text.splitlines() == [
        f"{PLACE}@{hub.head}: 17 files, the manifest and a card",
        f"  also {PLACE}@v1",
    ]
    assert hub.tags == {"v1": hub.head}
    assert not hub.private
    assert len(hub.commits) == 1
    assert hub.commits[0]["summary"] == "Release small, built by affectsim-data 0.0.0"
    assert hub.commits[0]["parentCommit"] == COMMIT
    files = FolderStore(release_copy).manifest.files
    assert set(hub.puts) == {entry.sha256 for entry in files.values()}
    status, text, error = client.run("download", f"{PLACE}@v1", "--out", tmp_path / "back")
    assert status == 0, error
    back = tree(tmp_path / "back")
    card = back.pop("README.md").decode()
    assert back == tree(release_copy)
    croissant = json.loads((hub.root / "croissant.json").read_text())
    assert croissant["url"] == f"https://huggingface.co/datasets/{REPO_ID}"
    hashes = {one["name"]: one["sha256"] for one in croissant["distribution"] if "sha256" in one}
    assert {name: hashes[name] for name in files} == {
        name: entry.sha256 for name, entry in files.items()
    }
    assert card == dataset_card(open_release(release_copy), place=f"{PLACE}@v1")
    assert card.startswith("---\npretty_name: small\n")
    assert f'AffectSimDataset("{PLACE}@v1", split="test"' in card


def test_a_newer_version_replaces_the_older_one(
    hub: UploadHub, client: Client, release_copy: Path, tmp_path: Path
) -> None:
    assert client.run("upload", release_copy, f"{PLACE}/")[0] == 0
    (hub.root / "figures").mkdir()
    (hub.root / "figures" / "motions.png").write_bytes(b"drawn by hand")
    first = hub.head
    status, text, _ = client.run("upload", release_copy, REPO_ID)
    assert (status, hub.head, len(hub.commits)) == (0, first, 1), "the same again is no commit"
    assert text.startswith(f"{PLACE}@{first}: 17 files")

    write_release(release_copy, splits=("train", "test"), overwrite=True)
    hub.puts.clear()
    status, text, _ = client.run("upload", release_copy, REPO_ID, "--message", "Without tuning")
    assert status == 0
    assert "; 2 files of an older version deleted" in text
    assert len(hub.commits) == 2
    assert hub.commits[1]["summary"] == "Without tuning"
    assert hub.commits[1]["parentCommit"] == first
    assert hub.commits[1]["deleted"] == [
        "episodes/validation-00000-of-00001.parquet",
        "index/validation-00000-of-00001.parquet",
    ]
    assert set(hub.commits[1]["added"]) == {*(MANIFEST_NAME, "README.md", "croissant.json")}
    assert hub.puts == [], "what is there is not sent again"
    assert (hub.root / "figures" / "motions.png").read_bytes() == b"drawn by hand"
    assert client.run("download", PLACE, "--out", tmp_path / "back")[0] == 0
    assert tree(tmp_path / "back").keys() - {"README.md"} == tree(release_copy).keys()


def test_an_upload_that_fails_changes_nothing(
    hub: UploadHub, client: Client, release_copy: Path
) -> None:
    hub.broken_puts = 1
    status, _, error = client.run("upload", release_copy, REPO_ID, "--tag", "v1")
    assert status == 1
    assert re.search(f"affectsim: {PLACE}: Error while uploading '.*parquet' to the Hub", error)
    assert (hub.head, hub.tags) == (COMMIT, {})
    hub.before_commit.append("Somebody was faster")
    status, _, error = client.run("upload", release_copy, REPO_ID, "--tag", "v1")
    assert status == 1
    assert "somebody else changed the dataset meanwhile; nothing was uploaded" in error
    assert not (hub.root / MANIFEST_NAME).exists()
    assert client.run("upload", release_copy, REPO_ID, "--tag", "v1")[0] == 0
    assert len(hub.puts) == len(set(hub.puts)) == 17, "what had come was kept"

    taken = hub.head
    hub.requests.clear()
    write_release(release_copy, seed=8, overwrite=True)
    status, _, error = client.run("upload", release_copy, REPO_ID, "--tag", "v1")
    assert status == 1
    assert f"the tag 'v1' is taken, by {taken}; a tag names one version for good" in error
    assert not [path for _, _, path in hub.requests if "preupload" in path or "lfs" in path]


def test_privacy_is_what_was_asked_for(hub: UploadHub, client: Client, release_copy: Path) -> None:
    forbid_passing_on(release_copy)
    status, _, error = client.run("upload", release_copy, REPO_ID, "--private")
    assert status == 0, error
    assert hub.private
    card = (hub.root / "README.md").read_text()
    assert "**This release may not be passed on.** Share its recipe" in card
    hub.private, hub.token = False, ""
    before = hub.head
    write_release(release_copy, seed=8, overwrite=True)
    status, _, error = client.run("upload", release_copy, REPO_ID, "--private")
    assert status == 1
    assert f"{PLACE}: exists and is public; make it private in its settings" in error
    assert hub.head == before


def test_a_card_of_ones_own_is_kept(hub: UploadHub, client: Client, release_copy: Path) -> None:
    own = "---\npretty_name: Ours\n---\nBuilt with love.\n"
    (release_copy / "README.md").write_text(own)
    status, text, error = client.run("upload", release_copy, REPO_ID)
    assert status == 0, error
    assert "the manifest and README.md as you wrote it" in text
    assert (hub.root / "README.md").read_text() == own
    (release_copy / "README.md").write_text("No front matter.\n")
    status, _, error = client.run("upload", release_copy, REPO_ID)
    assert status == 1
    assert "Invalid metadata in README.md" in error


def test_who_may_not_write_is_told_how_to(
    hub: UploadHub, client: Client, release_copy: Path, tmp_path: Path
) -> None:
    status, _, error = client.run("upload", release_copy, "someone/else")
    assert status == 1
    assert "hf://datasets/someone/else: the Hub refused the token (status 403)" in error
    assert "run `hf auth login` with one that may write there" in error
    with Client(hub, tmp_path / "stranger") as stranger:
        status, _, error = stranger.run("upload", release_copy, REPO_ID)
    assert (status, hub.exists) == (1, False)
    assert f"{PLACE}: uploading needs a token of the Hugging Face Hub; run `hf auth login`" in error
    with Client(hub, tmp_path / "offline", HF_TOKEN=TOKEN, HF_HUB_OFFLINE="1") as offline:
        status, _, error = offline.run("upload", release_copy, REPO_ID)
    assert (status, hub.exists) == (1, False)
    assert f"{PLACE}: HF_HUB_OFFLINE is set; unset it to upload" in error


def test_pictures_and_what_the_card_was_told_go_along(
    hub: UploadHub, client: Client, release_copy: Path
) -> None:
    told = ("--contact", "https://example.org/misuse", "--published", "2026-11-21")
    assert main(["card", str(release_copy), *told]) == 0
    local = tree(release_copy)
    assert client.run("upload", release_copy, REPO_ID)[0] == 0
    there = tree(hub.root)
    for name in ("emotions", "distances", "visibility"):
        assert there[f"assets/{name}.png"] == local[f"assets/{name}.png"]
    card, croissant = there["README.md"].decode(), json.loads(there["croissant.json"])
    assert "(assets/emotions.png)" in card
    assert "<https://example.org/misuse>" in card
    assert f'AffectSimDataset("{PLACE}"' in card
    assert croissant["datePublished"] == "2026-11-21"
    assert croissant["url"].endswith(REPO_ID)
    assert tree(release_copy) == local, "the folder is left as it was"


def test_croissant_of_ones_own_is_kept(hub: UploadHub, client: Client, release_copy: Path) -> None:
    (release_copy / "croissant.json").write_text('{"name": "ours"}')
    assert client.run("upload", release_copy, REPO_ID)[0] == 0
    assert (hub.root / "croissant.json").read_text() == '{"name": "ours"}'


# What is refused before the Hub is asked


def test_broken_files_are_told_and_nothing_is_uploaded(
    release_copy: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HF_TOKEN", TOKEN)
    size = (release_copy / SCENE).stat().st_size
    (release_copy / SCENE).write_bytes(b"nonsense")
    assert main(["upload", str(release_copy), REPO_ID]) == 1
    error = capsys.readouterr().err
    assert "1 of 17 files are not what the manifest says; nothing was uploaded:" in error
    assert f"{release_copy}/{SCENE}: expected {size} bytes, got truncated: 8 bytes" in error


def test_what_may_not_be_passed_on_is_not(
    release_copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    forbid_passing_on(release_copy)
    assert main(["upload", str(release_copy), REPO_ID]) == 1
    assert (
        f"{release_copy}: holds what may not be passed on: its recipe says so of all of it, "
        "licences CC0-1.0. Share its recipe, 'small', so that others build the release from their "
        "own copies, or add --private to keep it to yourself"
    ) in capsys.readouterr().err


def test_each_source_that_forbids_it_is_named_with_its_licence(
    release_copy: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    closed = Source("kdae", "motions", "LicenseRef-Closed", False, obtain="https://kdae.org.")
    silent = Source("attic", "scenes", "", False)
    free = Source("homes", "scenes", "CC0-1.0")
    forbid_passing_on(release_copy, closed, free, silent)
    assert main(["upload", str(release_copy), REPO_ID]) == 1
    assert (
        "may not be passed on: the motions of 'kdae', licence LicenseRef-Closed (to get it: "
        "https://kdae.org); the scenes of 'attic', licence not stated. Share its recipe"
    ) in capsys.readouterr().err


def test_a_source_that_forbids_it_is_enough(release_copy: Path) -> None:
    forbid_passing_on(release_copy, Source("kdae", "motions", "LicenseRef-Closed", False))
    text = (release_copy / MANIFEST_NAME).read_text()
    (release_copy / MANIFEST_NAME).write_text(
        text.replace('"redistribution": false, "sources"', '"redistribution": true, "sources"')
    )
    store = FolderStore(release_copy)
    assert store.manifest.redistribution
    with pytest.raises(ValueError, match="the motions of 'kdae', licence LicenseRef-Closed"):
        check_publishable(store, private=False)
    check_publishable(store, private=True)


def test_a_part_is_not_uploaded_as_the_whole(
    small_release_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    part = tmp_path / "part"
    assert main(["download", str(small_release_path), "--split", "test", "--out", str(part)]) == 0
    assert main(["upload", str(part), REPO_ID]) == 1
    assert (
        f"{part}: this copy holds only split test of {small_release_path}; upload the whole release"
    ) in capsys.readouterr().err


@pytest.mark.parametrize("repository", ["small", "a/b/c", "hf://models/a/b", "a/b@v1"])
def test_malformed_names_are_refused(
    release_copy: Path, capsys: pytest.CaptureFixture[str], repository: str
) -> None:
    assert main(["upload", str(release_copy), repository]) == 1
    assert f"'{repository}': expected ORG/NAME, a dataset on the Hub" in capsys.readouterr().err


def test_the_word_on_passing_on_is_kept(release_copy: Path, tmp_path: Path) -> None:
    assert "redistribution" not in (release_copy / MANIFEST_NAME).read_text()
    forbid_passing_on(release_copy)
    manifest = FolderStore(release_copy).manifest
    assert not manifest.redistribution
    assert '"redistribution": false' in manifest.to_json()
    assert (
        main(["download", str(release_copy), "--split", "test", "--out", str(tmp_path / "p")]) == 0
    )
    assert not FolderStore(tmp_path / "p").manifest.redistribution
    document = json.loads((release_copy / MANIFEST_NAME).read_text())
    (release_copy / MANIFEST_NAME).write_text(json.dumps({**document, "redistribution": "no"}))
    with pytest.raises(ValueError, match="redistribution must be true or false, got 'no'"):
        FolderStore(release_copy)


def test_the_word_on_passing_on_comes_from_the_corpus() -> None:
    assert not read_recipe("bandai_namco").redistribution
    assert read_recipe("mini").redistribution, "reads none"
    text = content_path("builders", "bandai_namco.toml").read_text(encoding="utf-8")
    corpus = {**tomllib.loads(text)["corpus"], "redistribution": "false"}
    with pytest.raises(ValueError, match="redistribution must be true or false, got 'false'"):
        load_recipe({**tomllib.loads(text), "corpus": corpus})
