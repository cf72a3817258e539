"""Releases on disk: what is written is read, the same bytes every time, all or nothing."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_release import (
    CAMERA,
    LICENCE,
    ROBOT,
    limb_avatar,
    small_avatars,
    small_episodes,
    small_motions,
    small_navmeshes,
    small_rows,
    small_scenes,
    write_release,
)

from affectsim_data.releases import Release, ReleaseWriter, builtin, open_release
from affectsim_data.releases import writing as writing_module
from affectsim_data.releases.rows import avatar_row


def tree(folder: Path) -> dict[str, bytes]:
    """All files of a folder, hidden ones too, by relative path."""
    paths = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


# What is written is read.


def test_episodes_are_read_as_written(small: Release) -> None:
    before = small_episodes()
    after = [small.episode(split, i) for split in ("train", "validation", "test") for i in (0, 1)]
    assert [e.to_row() for e in after] == [e.to_row() for e in before]


def test_motions_are_read_as_written(small: Release) -> None:
    for motion_id, before in small_motions().items():
        after = small.motion(motion_id)
        np.testing.assert_array_equal(after.root_translation, before.root_translation)
        np.testing.assert_array_equal(after.joint_rotations, before.joint_rotations)
        for field in ("motion_id", "performer_id", "group_id", "emotion", "action", "fps"):
            assert getattr(after, field) == getattr(before, field)
        assert (after.source, after.licence) == (before.source, before.licence)


def test_scenes_navmeshes_and_avatars_are_read_as_written(small: Release) -> None:
    for scene_id, scene in small_scenes().items():
        assert small.scene(scene_id).to_glb() == scene.to_glb()
        navmesh = small_navmeshes()[scene_id]
        assert small.navmesh(scene_id).to_bytes() == navmesh.to_bytes()
    for avatar_id, avatar in small_avatars().items():
        assert small.avatar(avatar_id).to_glb() == avatar.to_glb()


def test_assets_are_listed_and_kept(small: Release) -> None:
    assert small.asset_ids("motions") == list(small_motions())
    assert small.asset_ids("scenes") == list(small_scenes())
    assert small.scene("empty_room") is small.scene("empty_room")


def test_worlds_hold_what_their_episode_names(small: Release) -> None:
    episode = small.find_episode("small/5")
    assert episode.family == "dyadic"
    world = small.world(episode)
    assert world.scene.scene_id == "crate_room"
    assert [p.motion.motion_id for p in world.people] == ["sway_sad", "circle_angry"]
    assert world.target.motion.motion_id == "sway_sad"
    assert world.camera.to_json() == CAMERA.to_json()
    assert world.robot == ROBOT
    np.testing.assert_allclose(world.people[1].T_world_performance[:3, 3], [1.2, 0.0, 2.0])


def test_the_manifest_counts_rows(small: Release) -> None:
    assert small.manifest.num_rows("episodes") == 6
    assert small.manifest.num_rows("episodes", "test") == 2
    assert small.manifest.num_rows("motions") == 7
    assert small.manifest.licences == (LICENCE,)


def test_every_asset_has_a_file_of_its_own_and_the_manifest_says_which(small: Release) -> None:
    for table, ids in (("motions", small_motions()), ("scenes", small_scenes())):
        keys = [small.manifest.files[name].keys for name in small.manifest.table_files(table)]
        assert keys == [(asset_id,) for asset_id in ids]


def test_episodes_come_in_shards_and_their_index_in_one_piece(tmp_path: Path) -> None:
    rows = small_rows()
    many = [{**rows["episodes"][i % 2], "episode_id": f"e{i}"} for i in range(600)]
    write_release(tmp_path / "r", rows={**rows, "episodes": many})
    release = open_release(tmp_path / "r")
    names = release.manifest.table_files("episodes", "train")
    assert [release.manifest.files[name].rows for name in names] == [256, 256, 88]
    for place in (0, 255, 256, 511, 599):
        assert release.episode("train", place).episode_id == f"e{place}"
    assert release.find_episode("e300").episode_id == "e300"
    assert len(release.manifest.table_files("index", "train")) == 1
    index = release.episode_index("train").to_pydict()
    table = release.episode_table("train").select(list(index)).to_pydict()
    assert index == table


def test_the_files_of_episodes_are_those_that_drawing_reads(small: Release) -> None:
    split, place = "test", 1  # the dyad
    episode = small.episode(split, place)
    files = small.episode_files(split, [place])
    keys = [key for name in files for key in small.manifest.files[name].keys]
    expected = {episode.scene_id}
    expected |= {p.motion_id for p in episode.participants}
    expected |= {p.avatar_id for p in episode.participants}
    assert sorted(keys) == sorted(expected)
    assert files[0] == "episodes/test-00000-of-00001.parquet"
    assert len(files) == 1 + len(expected)


# The same rows, the same bytes.


def test_a_second_writing_gives_the_same_bytes(small_release_path: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"
    done = subprocess.run(
        [sys.executable, "-m", "small_release", str(again)], check=False, timeout=60
    )
    assert done.returncode == 0
    assert tree(again) == tree(small_release_path)


def test_assets_share_files_where_there_are_very_many(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writing_module, "_MAX_ASSET_SHARDS", 4)
    write_release(tmp_path / "r")
    release = open_release(tmp_path / "r")
    names = release.manifest.table_files("motions")
    assert names == [f"motions/motions-{i:05d}-of-00004.parquet" for i in range(4)]
    assert [release.manifest.files[name].rows for name in names] == [2, 2, 2, 1]
    assert release.asset_ids("motions") == list(small_motions())
    for motion_id, motion in small_motions().items():
        assert release.motion(motion_id).action == motion.action


def test_tables_split_into_shards_by_size(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = small_rows()
    size = len(rows["motions"][0]["joint_rotations"])
    monkeypatch.setattr(writing_module, "_MAX_ASSET_SHARDS", 1)
    monkeypatch.setattr(writing_module, "MAX_SHARD_BYTES", int(2.5 * size))
    write_release(tmp_path / "r", rows=rows)
    release = open_release(tmp_path / "r")
    names = release.manifest.table_files("motions")
    assert [release.manifest.files[name].rows for name in names] == [2, 2, 2, 1]
    assert release.motion("circle_angry").action == "simple_walk"


def test_a_row_larger_than_a_shard_gets_one_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writing_module, "MAX_SHARD_BYTES", 10)
    write_release(tmp_path / "r")
    assert len(open_release(tmp_path / "r").manifest.table_files("scenes")) == 2


# All or nothing.


def write_and_fail(out: Path) -> None:
    """Writes a table where `out` stands or will stand, sees nothing change there, and gives up."""
    before = tree(out)
    with ReleaseWriter(out, overwrite=True) as writer:
        writer.add_table("motions", small_rows()["motions"])
        assert tree(out) == before
        raise ZeroDivisionError


def test_an_error_while_writing_leaves_nothing_behind(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        write_and_fail(tmp_path / "r")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"height": 1.7}, r"avatars 'plain': unknown columns \['height'\]"),
        ({"height_m": None}, r"avatars 'plain': .* missing or null \['height_m'\]"),
    ],
)
def test_rows_off_the_contract_are_not_written(
    change: dict[str, Any], message: str, tmp_path: Path
) -> None:
    row = {**avatar_row(limb_avatar("plain")), **change}
    with pytest.raises(ValueError, match=message), ReleaseWriter(tmp_path / "r") as writer:
        writer.add_table("avatars", [row])
    assert list(tmp_path.iterdir()) == []


def test_a_release_is_not_overwritten_unasked(release_copy: Path) -> None:
    before = tree(release_copy)
    with pytest.raises(FileExistsError, match=r"holds a release already; add --overwrite"):
        write_release(release_copy)
    assert tree(release_copy) == before


@pytest.mark.parametrize("overwrite", [False, True])
def test_other_folders_are_never_overwritten(tmp_path: Path, overwrite: bool) -> None:
    precious = tmp_path / "thesis"
    precious.mkdir()
    (precious / "chapter.tex").write_text("text")
    with pytest.raises(FileExistsError, match="exists and is no release; choose another --out"):
        write_release(precious, overwrite=overwrite)
    assert tree(tmp_path) == {"thesis/chapter.tex": b"text"}


def test_a_file_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "notes").write_text("text")
    with pytest.raises(FileExistsError, match="exists and is no release"):
        write_release(tmp_path / "notes", overwrite=True)


def test_an_empty_folder_may_be_filled(tmp_path: Path) -> None:
    (tmp_path / "r").mkdir()
    write_release(tmp_path / "r")
    assert len(open_release(tmp_path / "r").episode_table("test")) == 2


def test_overwriting_keeps_the_old_release_until_the_new_one_is_whole(release_copy: Path) -> None:
    before = tree(release_copy)
    with pytest.raises(ZeroDivisionError):
        write_and_fail(release_copy)
    assert tree(release_copy) == before
    write_release(release_copy, overwrite=True, seed=8)
    assert open_release(release_copy).manifest.seed == 8
    assert [path.name for path in release_copy.parent.iterdir()] == [release_copy.name], (
        "nothing left beside it"
    )


def test_the_old_release_comes_back_if_the_new_one_cannot_be_moved(
    release_copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, replace = tree(release_copy), os.replace

    def refuse(source: Path, target: Path) -> None:
        if source.name.endswith(".partial"):
            raise OSError("disk on fire")
        replace(source, target)

    monkeypatch.setattr(os, "replace", refuse)
    with pytest.raises(OSError, match="disk on fire"):
        write_release(release_copy, overwrite=True, seed=8)
    assert tree(release_copy) == before


_SLOW_WRITER = """
import sys, time
from pathlib import Path
import small_release
from affectsim_data.releases import writing
fsync = writing._sync
def slow(path):
    print("syncing", flush=True)
    time.sleep(0.2)
    fsync(path)
writing._sync = slow
small_release.write_release(Path(sys.argv[1]), overwrite="--overwrite" in sys.argv)
"""


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_killed_writer_leaves_no_half_release_and_a_new_run_ends_alike(
    overwrite: bool, small_release_path: Path, tmp_path: Path
) -> None:
    out = tmp_path / "r"
    if overwrite:
        write_release(out, seed=1)
    before = tree(out)
    flags = ["--overwrite"] if overwrite else []
    process = subprocess.Popen(
        [sys.executable, "-c", _SLOW_WRITER, str(out), *flags], stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "syncing\n", "the shards are written, the move is to come"
    process.send_signal(signal.SIGKILL)
    process.wait(timeout=30)
    process.stdout.close()
    assert tree(out) == before
    assert out.exists() == overwrite
    write_release(out, overwrite=overwrite)
    assert tree(out) == tree(small_release_path)
    assert [path.name for path in tmp_path.iterdir()] == ["r"], "nothing left beside it"


# Elsewhere.


def test_a_release_travels_to_a_worker_without_what_it_read(small_release_path: Path) -> None:
    release = open_release(small_release_path)
    release.scene("empty_room")
    release.episode_table("train")
    payload = pickle.dumps(release)
    assert len(payload) < 10_000
    script = (
        "import pickle, sys; release = pickle.load(sys.stdin.buffer);"
        "print(release.episode('test', 1).episode_id, release.motion('sway_sad').num_frames)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], input=payload, capture_output=True, check=True, timeout=60
    )
    assert done.stdout.split() == [b"small/5", b"60"]


def test_a_folder_named_like_a_builtin_release_wins(
    release_copy: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    release_copy.rename(release_copy.parent / "mini")
    monkeypatch.chdir(release_copy.parent)
    assert open_release("mini").manifest.name == "small"


def test_builtin_releases_are_built_once_into_the_cache(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("AFFECTSIM_CACHE", str(tmp_path))
    built = []

    def build(name: str, folder: Path) -> None:
        built.append(name)
        write_release(folder)

    monkeypatch.setattr(builtin, "_build", build)
    assert open_release().manifest.name == open_release("mini").manifest.name == "small"
    assert built == ["mini"]


def test_the_cache_folder_follows_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AFFECTSIM_CACHE", "/a")
    assert builtin.cache_folder() == Path("/a")
    monkeypatch.delenv("AFFECTSIM_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", "/b")
    assert builtin.cache_folder() == Path("/b/affectsim")
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    assert builtin.cache_folder() == Path("~/.cache/affectsim").expanduser()


def test_reading_an_episode_costs_little(small: Release) -> None:
    small.episode("test", 0)
    start = time.perf_counter()
    for _ in range(20):
        small.episode("test", 0)
    assert (time.perf_counter() - start) / 20 < 0.02


def test_open_releases_are_shared_while_in_use_and_reopened_when_changed(
    small_release_path: Path, tmp_path: Path
) -> None:
    first = open_release(small_release_path)
    assert open_release(small_release_path) is first
    scene = first.asset_ids("scenes")[0]
    assert open_release(small_release_path).scene(scene) is first.scene(scene)

    write_release(tmp_path / "own")
    old = open_release(tmp_path / "own")
    write_release(tmp_path / "own", splits=("train",), overwrite=True)
    new = open_release(tmp_path / "own")
    assert new is not old
    assert new.manifest.num_rows("episodes", "test") == 0
