"""Releases that are broken on disk: what is wrong is named, with the file and the way out."""

from __future__ import annotations

import json
import math
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_release import small_motions, small_rows, write_release

from affectsim_data.errors import IntegrityError
from affectsim_data.releases import MANIFEST_NAME, Release, open_release
from affectsim_data.releases.manifest import sha256_of
from affectsim_data.schemas import SCHEMA_VERSION, array_columns

MOTIONS = "motions/motions-00004-of-00007.parquet"
TEST_EPISODES = "episodes/test-00000-of-00001.parquet"


def edit_manifest(release: Path, change: Callable[[dict[str, Any]], object]) -> None:
    """Rewrites the manifest of a release."""
    path = release / MANIFEST_NAME
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def test_nothing_there(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no release '.*/none': expected a folder .* mini"):
        open_release(tmp_path / "none")


def test_a_file_is_no_release(release_copy: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"MANIFEST\.json: no MANIFEST\.json"):
        open_release(release_copy / MANIFEST_NAME)


def test_a_folder_without_a_manifest_is_unfinished(release_copy: Path) -> None:
    (release_copy / MANIFEST_NAME).unlink()
    with pytest.raises(FileNotFoundError, match=r"no release or an unfinished one; .* build"):
        open_release(release_copy)


def test_missing_files_are_listed(release_copy: Path) -> None:
    (release_copy / MOTIONS).unlink()
    (release_copy / TEST_EPISODES).unlink()
    with pytest.raises(FileNotFoundError) as caught:
        open_release(release_copy)
    assert f"2 of 17 files of its manifest are missing: {TEST_EPISODES}, {MOTIONS};" in str(
        caught.value
    )


def test_a_truncated_shard_is_named_with_both_sizes(release_copy: Path) -> None:
    size = (release_copy / MOTIONS).stat().st_size
    with (release_copy / MOTIONS).open("r+b") as stream:
        stream.truncate(size - 100)
    release = open_release(release_copy)
    with pytest.raises(IntegrityError) as caught:
        release.motion("sway_sad")
    assert caught.value.file == f"{release_copy}/{MOTIONS}"
    assert caught.value.expected == f"{size} bytes"
    assert caught.value.got == f"truncated: {size - 100} bytes"
    assert "build or fetch the release again" in str(caught.value)


def test_one_flipped_byte_is_found_on_first_use(release_copy: Path) -> None:
    payload = bytearray((release_copy / TEST_EPISODES).read_bytes())
    payload[len(payload) // 2] ^= 1
    (release_copy / TEST_EPISODES).write_bytes(payload)
    release = open_release(release_copy)
    assert len(release.episode_table("train")) == 2, "other files are none the worse"
    with pytest.raises(IntegrityError, match=r"test-.*: expected SHA-256 .*, got SHA-256 "):
        release.episode_table("test")


def test_a_wrong_hash_in_the_manifest_is_found(release_copy: Path) -> None:
    edit_manifest(release_copy, lambda document: document["files"][MOTIONS].update(sha256="0" * 64))
    with pytest.raises(IntegrityError, match=f"{MOTIONS}: expected SHA-256 0000"):
        open_release(release_copy).motion("sway_sad")


def test_integrity_errors_survive_the_way_out_of_a_worker() -> None:
    error = IntegrityError("a/b", expected="1 byte", got="2 bytes", remedy="fetch it again")
    back = pickle.loads(pickle.dumps(error))
    assert str(back) == str(error) == "a/b: expected 1 byte, got 2 bytes; fetch it again"
    assert (back.file, back.expected, back.got) == ("a/b", "1 byte", "2 bytes")


@pytest.mark.parametrize(
    "text", [b"", b"{", b"\xff\xfe", b"[" * 200_000], ids=["empty", "cut", "binary", "deep"]
)
def test_a_manifest_that_is_not_json(release_copy: Path, text: bytes) -> None:
    (release_copy / MANIFEST_NAME).write_bytes(text)
    with pytest.raises(ValueError, match=r"release/MANIFEST\.json: not JSON .* build it again"):
        open_release(release_copy)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(format="other"), "\"format\" must be 'affectsim-release'"),
        (
            lambda d: d.update(schema_version="99.0"),
            r"schema_version '99\.0' cannot be read by this",
        ),
        (lambda d: d.pop("schema_version"), "schema_version None cannot be read"),
        (lambda d: d.pop("camera"), "field 'camera' is missing or malformed"),
        (lambda d: d.update(files=[]), "is missing or malformed"),
        (lambda d: d["files"].update({MOTIONS: None}), "is missing or malformed"),
        (lambda d: d["files"][MOTIONS].update(bytes="many"), "invalid literal"),
        (lambda d: d["files"][MOTIONS].update(bytes=math.inf), "infinity"),
        (lambda d: d["camera"].update(hfov_deg=200), "hfov must be between 0 and 180"),
        (lambda d: d.update(robot={"wheels": 3}), "is missing or malformed"),
        (lambda d: d["files"].update({"../x": {}}), r"path '\.\./x' leads out of the release"),
        (lambda d: d["files"].update({"a/../../x": {}}), "leads out of the release"),
        (lambda d: d["files"].update({"/etc/passwd": {}}), "path '/etc/passwd' leads out"),
        (lambda d: d["files"].update({"a\\..\\x": {}}), "leads out of the release"),
        (lambda d: d["files"].update({"": {}}), "path '' leads out of the release"),
    ],
)
def test_bad_manifests_are_refused_by_name(
    release_copy: Path, change: Callable[[dict[str, Any]], object], message: str
) -> None:
    edit_manifest(release_copy, change)
    with pytest.raises(ValueError, match=rf"release/MANIFEST\.json: .*{message}"):
        open_release(release_copy)


def test_a_manifest_that_is_a_list(release_copy: Path) -> None:
    (release_copy / MANIFEST_NAME).write_text("[]")
    with pytest.raises(ValueError, match="this is not a release manifest"):
        open_release(release_copy)


def test_a_newer_minor_version_is_read(release_copy: Path) -> None:
    newer = SCHEMA_VERSION.split(".")[0] + ".99"
    edit_manifest(
        release_copy, lambda document: document.update(schema_version=newer, novelty=True)
    )
    assert open_release(release_copy).manifest.schema_version == newer


def test_an_honest_file_that_is_not_parquet(release_copy: Path) -> None:
    (release_copy / MOTIONS).write_bytes(b"junk")
    digest = sha256_of(release_copy / MOTIONS)
    edit_manifest(release_copy, lambda d: d["files"][MOTIONS].update(bytes=4, sha256=digest))
    with pytest.raises(ValueError, match=f"{MOTIONS}: not a Parquet file"):
        open_release(release_copy).motion("sway_sad")


def test_an_unknown_split_is_refused(small: Release) -> None:
    with pytest.raises(ValueError, match="split must be one of train, validation, test, got 'dev'"):
        small.episode_table("dev")


@pytest.mark.parametrize("listed", [True, False])
def test_an_empty_split_says_where_the_episodes_are(tmp_path: Path, listed: bool) -> None:
    rows = small_rows()
    rows["episodes"] = [row for row in rows["episodes"] if row["split"] == "train"]
    write_release(
        tmp_path / "r", rows=rows, splits=("train", "validation", "test") if listed else ("train",)
    )
    release = open_release(tmp_path / "r")
    assert len(release.episode_table("train")) == 2
    with pytest.raises(ValueError, match=r"split 'test' is empty; episodes: {'train': 2, .*'test'"):
        release.episode_table("test")
    assert release.find_episode("small/1").episode_id == "small/1"


def test_unknown_identifiers_are_refused_with_the_release(small: Release) -> None:
    for get, table in (
        (small.motion, "motions"),
        (small.scene, "scenes"),
        (small.avatar, "avatars"),
    ):
        with pytest.raises(KeyError, match=rf"small: {table} has no 'nobody'"):
            get("nobody")
    with pytest.raises(KeyError, match=r"small: no episode 'nobody'"):
        small.find_episode("nobody")


def test_an_episode_that_names_a_missing_motion_is_named(tmp_path: Path) -> None:
    rows = small_rows()
    rows["motions"] = [row for row in rows["motions"] if row["motion_id"] != "sway_happy"]
    write_release(tmp_path / "r", rows=rows)
    release = open_release(tmp_path / "r")
    with pytest.raises(KeyError, match=r"episode 'small/4': .*motions has no 'sway_happy'"):
        release.world(release.find_episode("small/4"))


def test_a_motion_with_nan_is_refused_by_name(tmp_path: Path) -> None:
    rows = small_rows()
    bad = small_motions()["sway_sad"].root_translation.astype(np.float32)
    bad[7, 1] = np.nan
    for row in rows["motions"]:
        if row["motion_id"] == "sway_sad":
            row.update(array_columns("root_translation", bad))
    write_release(tmp_path / "r", rows=rows)
    release = open_release(tmp_path / "r")
    assert release.motion("sway_angry").num_frames == 60
    with pytest.raises(ValueError, match=r"motion 'sway_sad': root_translation must be finite"):
        release.motion("sway_sad")


def test_an_array_that_lies_is_refused_with_its_row(tmp_path: Path) -> None:
    rows = small_rows()
    rows["motions"][0]["joint_rotations_shape"] = [60, 22, 5]
    write_release(tmp_path / "r", rows=rows)
    with pytest.raises(ValueError, match=r"/r: motions 'sway_angry': joint_rotations with shape"):
        open_release(tmp_path / "r").motion("sway_angry")


def test_a_broken_glb_is_refused_with_its_row(tmp_path: Path) -> None:
    rows = small_rows()
    rows["scenes"][0]["glb"] = rows["scenes"][0]["glb"][:-8]
    write_release(tmp_path / "r", rows=rows)
    with pytest.raises(ValueError, match=r"/r: scenes 'empty_room': GLB header says"):
        open_release(tmp_path / "r").scene("empty_room")
