"""Splits by scene, and by scene and group: made of the stored ones, read like them everywhere."""

from __future__ import annotations

import collections
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from small_release import write_release
from varied_release import RemoteStore
from wide_release import wide_rows

from affectsim_data import AffectSimDataset
from affectsim_data.cli import main
from affectsim_data.inspection.summary import release_summary
from affectsim_data.loaders import EpisodeStream, concatenate, data_loader
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.downloading import download_to_folder
from affectsim_data.releases.joined_splits import splits_there
from affectsim_data.releases.planning import files_of, make_plan, select
from affectsim_data.releases.selection import select_rows
from affectsim_data.releases.splits import SPLIT_BYS, SplitBy
from affectsim_data.releases.stores import FolderStore
from affectsim_data.schemas import SPLITS

SCENE_SPLITS = ("train", "train", "train", "train", "validation", "test")
"""Of the rooms, by number."""


def rows_of(scene_splits: tuple[str, ...] = SCENE_SPLITS) -> dict[str, list[dict[str, Any]]]:
    counts = {"train": 600, "validation": 30, "test": 40}
    rows = wide_rows(num_scenes=len(scene_splits), counts=counts)  # type: ignore[arg-type]
    words = {row["scene_id"]: word for row, word in zip(rows["scenes"], scene_splits, strict=True)}
    for row in rows["episodes"]:
        row["scene_split"] = words[row["scene_id"]]
    return rows


@pytest.fixture(scope="module")
def rows() -> list[dict[str, Any]]:
    return rows_of()["episodes"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("split_by") / "release"
    write_release(out, rows=rows_of())
    return out


@pytest.fixture(scope="module")
def release(folder: Path) -> Release:
    return open_release(folder)


def expected_rows(rows: list[dict[str, Any]], split: str, split_by: str) -> list[dict[str, Any]]:
    """The rows of a split in plain Python; they are in stored order."""
    columns = {"group": ["split"], "scene": ["scene_split"], "both": ["split", "scene_split"]}
    return [row for row in rows if all(row[column] == split for column in columns[split_by])]


def described(source: Path | Release, **options: Any) -> AffectSimDataset:
    """A dataset that draws nothing."""
    return AffectSimDataset(source, images=False, condition="p_init", **options)


# What is in them.


@pytest.mark.parametrize("split_by", SPLIT_BYS)
@pytest.mark.parametrize("split", SPLITS)
def test_a_split_has_its_episodes_in_stored_order(
    release: Release, rows: list[dict[str, Any]], split: str, split_by: SplitBy
) -> None:
    expected = expected_rows(rows, split, split_by)
    dataset = described(release, split=split, split_by=split_by)
    assert [dataset.episode(i).episode_id for i in range(len(dataset))] == [
        row["episode_id"] for row in expected
    ]
    table = release.split_table(split, split_by)
    for column in ("episode_id", "scene_id", "split", "emotion"):
        assert table.index.column(column).to_pylist() == [row[column] for row in expected]
    assert table.table(["phase_s"]).column("phase_s").to_pylist() == [
        row["phase_s"] for row in expected
    ]


def test_splits_by_scene_share_no_scene_and_have_every_episode_once(
    release: Release, rows: list[dict[str, Any]]
) -> None:
    tables = [release.split_table(split, "scene").index for split in SPLITS]
    scenes = [set(table.column("scene_id").to_pylist()) for table in tables]
    assert sum(map(len, scenes)) == len(set.union(*scenes)) == len(SCENE_SPLITS)
    ids = [name for table in tables for name in table.column("episode_id").to_pylist()]
    assert sorted(ids) == sorted(row["episode_id"] for row in rows)


def test_the_split_by_both_shares_neither_scene_nor_performer(release: Release) -> None:
    tables = [release.split_table(split, "both").index for split in SPLITS]
    for column in ("scene_id", "performer_id"):
        found = [set(table.column(column).to_pylist()) for table in tables]
        assert sum(map(len, found)) == len(set.union(*found))


def test_every_kind_of_split_has_its_own_fingerprint(folder: Path, release: Release) -> None:
    kinds = [(split, split_by) for split in SPLITS for split_by in SPLIT_BYS]
    prints = [described(release, split=one, split_by=by).fingerprint for one, by in kinds]
    assert len(set(prints)) == len(kinds)
    again = Release(FolderStore(folder))
    assert [described(again, split=one, split_by=by).fingerprint for one, by in kinds] == prints


# Everything else goes through them.


def test_filters_names_and_parts_choose_among_them(
    release: Release, rows: list[dict[str, Any]]
) -> None:
    expected = expected_rows(rows, "test", "scene")
    ids = [row["episode_id"] for row in expected]
    sad = [("emotion", "==", "sad")]
    near = [("initial_distance_m", "<", 1.3)]  # not in the index
    chosen = described(release, split="test", split_by="scene", filter=[*sad, *near])
    assert chosen.rows.tolist() == [
        place
        for place, row in enumerate(expected)
        if row["emotion"] == "sad" and row["initial_distance_m"] < 1.3
    ]
    assert 0 < len(chosen) < len(ids)
    named = described(release, split="test", split_by="scene", episodes=[ids[-1], ids[0]])
    assert named.rows.tolist() == [len(ids) - 1, 0]
    rest = described(release, split="test", split_by="scene", exclude=ids[1:])
    assert rest.episode(0).episode_id == ids[0]
    part = described(release, split="test", split_by="scene").subset([3, 1])
    assert [part.episode(i).episode_id for i in (0, 1)] == [ids[3], ids[1]]
    other = next(row["episode_id"] for row in rows if row["scene_split"] == "train")
    with pytest.raises(ValueError, match=r"1 of 1 are not in split 'test' by scene of .*release"):
        described(release, split="test", split_by="scene", episodes=[other])
    with pytest.raises(ValueError, match="no episode of split 'test' by scene matches filter"):
        described(release, split="test", split_by="scene", filter=[("emotion", "==", "bored")])
    with pytest.raises(IndexError, match="this part of split 'test' by scene has 2 episodes"):
        part.episode(2)


def test_scenes_are_those_of_the_episodes(release: Release, rows: list[dict[str, Any]]) -> None:
    dataset = described(release, split="test", split_by="scene")
    assert {dataset.scene_ids[code] for code in dataset.scene_codes} == {"room_005"}


def test_loaders_streams_and_resumes_see_the_same_order(folder: Path) -> None:
    dataset = described(folder, split="test", split_by="scene").subset(slice(20))
    options: dict[str, Any] = {"batch_size": 6, "shuffle": "scenes", "seed": 3}
    whole = [name for batch in data_loader(dataset, **options) for name in batch["episode_id"]]
    assert sorted(whole) == sorted(dataset.episode(i).episode_id for i in range(len(dataset)))
    streamed = [name for batch in EpisodeStream(dataset, **options) for name in batch["episode_id"]]
    assert streamed == whole
    loader = data_loader(dataset, **options)
    iterator = iter(loader)
    taken = [name for _ in range(2) for name in next(iterator)["episode_id"]]
    token = json.loads(json.dumps(loader.state_dict()))
    rest = data_loader(pickle.loads(pickle.dumps(dataset)), **options, resume=token)
    assert taken + [name for batch in rest for name in batch["episode_id"]] == whole
    by_group = described(folder, split="test").subset(slice(20))
    with pytest.raises(ValueError, match="resume with the same release, split and selection"):
        data_loader(by_group, **options, resume=token)


def test_concatenated_splits_are_one_after_the_other(release: Release) -> None:
    parts = [described(release, split=split, split_by="scene") for split in ("test", "validation")]
    both = concatenate(parts)
    assert len(both) == sum(map(len, parts))
    assert both.episode(len(parts[0])).episode_id == parts[1].episode(0).episode_id


def test_far_releases_are_asked_for_the_files_of_these_episodes(folder: Path) -> None:
    store = RemoteStore(folder)
    dataset = described(Release(store), split="test", split_by="scene")
    assert store.read_names == [f"index/{split}-00000-of-00001.parquet" for split in SPLITS]
    dataset.prefetch([len(dataset) - 1, 0])
    (files,) = store.prefetched
    shards = [name for name in files if name.startswith("episodes/")]
    assert shards[0].startswith("episodes/test-")
    assert shards[1].startswith("episodes/train-")
    scenes = [name for name in files if name.startswith("scenes/")]
    assert scenes == ["scenes/scenes-00005-of-00006.parquet"]


# Copies of a part.


def fetched(source: Path, out: Path, **choice: Any) -> Release:
    release = open_release(source)
    selection = select(release, **choice)
    download_to_folder(release, FolderStore(source), selection, out)
    return open_release(out)


def test_a_copy_of_a_split_by_scene_is_that_split(folder: Path, tmp_path: Path) -> None:
    part = fetched(folder, tmp_path / "part", splits=["test"], split_by="scene")
    assert part.manifest.num_rows("scenes") == 1
    whole = described(folder, split="test", split_by="scene")
    copy = described(part, split="test", split_by="scene")
    assert copy.fingerprint == whole.fingerprint
    for place in (0, -1):
        assert copy[place]["T_world_camera"].tolist() == whole[place]["T_world_camera"].tolist()
    with pytest.raises(
        ValueError,
        match=r"part: this copy holds only 1 scene of split train, .*; `affectsim download .* "
        r"--split-by scene --split train --out .*part` adds split train by scene",
    ):
        described(part, split="train", split_by="scene")
    grown = fetched(folder, tmp_path / "part", splits=["train"], split_by="scene")
    assert len(described(grown, split="train", split_by="scene")) == len(
        described(folder, split="train", split_by="scene")
    )
    assert len(described(grown, split="test", split_by="scene")) == len(whole)


def test_a_copy_of_a_split_by_group_lacks_those_by_scene(folder: Path, tmp_path: Path) -> None:
    part = fetched(folder, tmp_path / "part", splits=["test"])
    with pytest.raises(ValueError, match=r"holds only split test; .*--split-by scene --split test"):
        described(part, split="test", split_by="scene")
    with pytest.raises(ValueError, match=r"--split-by both --split train .*by group and scene"):
        described(part, split="train", split_by="both")
    both = described(part, split="test", split_by="both")
    assert both.fingerprint == described(folder, split="test", split_by="both").fingerprint


def test_a_copy_of_the_split_by_both_has_only_its_files(folder: Path, tmp_path: Path) -> None:
    part = fetched(folder, tmp_path / "part", splits=["test"], split_by="both")
    assert part.manifest.num_rows("scenes") == 1
    assert not part.manifest.table_files("index", "train")
    whole = described(folder, split="test", split_by="both")
    assert described(part, split="test", split_by="both").fingerprint == whole.fingerprint


def test_plans_are_of_scenes(release: Release, folder: Path) -> None:
    selection = select(release, splits=["test", "validation"], split_by="scene")
    assert selection.splits == SPLITS
    assert selection.scene_ids == ("room_004", "room_005")
    assert select(release, split_by="scene") == select(release)
    one = select(release, splits=["train"], split_by="scene", scene_ids=["room_002"])
    assert one.scene_ids == ("room_002",)
    plan = make_plan(release, FolderStore(folder), one)
    assert plan.tables["scenes"].files == 1
    assert set(files_of(release, one)) < set(release.manifest.files)
    with pytest.raises(ValueError, match=r"no episode of split 'test' by scene is in room_002; "):
        select(release, splits=["test"], split_by="scene", scene_ids=["room_002"])
    with pytest.raises(ValueError, match="both takes one split at a time, got train, test"):
        select(release, splits=["train", "test"], split_by="both")


# Words, and releases with too few scenes.


def test_wrong_words_are_named(release: Release) -> None:
    with pytest.raises(ValueError, match="split_by must be one of group, scene, both, got 'room'"):
        described(release, split_by="room")
    with pytest.raises(ValueError, match="split must be one of train, validation, test, got 'dev'"):
        described(release, split="dev", split_by="scene")
    with pytest.raises(ValueError, match="split_by must be one of"):
        select_rows(release, "test", split_by="home")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="split_by must be one of"):
        splits_there(release, "home")  # type: ignore[arg-type]


def test_a_release_of_two_scenes_has_no_test_split_by_scene(tmp_path: Path) -> None:
    write_release(tmp_path / "two", rows=rows_of(("train", "train")))
    release = open_release(tmp_path / "two")
    assert splits_there(release, "scene") == ("train",)
    with pytest.raises(
        ValueError,
        match=r"split 'test' by scene is empty; episodes by scene: {'train': 670, 'validation': 0, "
        r"'test': 0}; 2 scenes are too few, it takes 3",
    ):
        described(release, split="test", split_by="scene")
    with pytest.raises(ValueError, match=r"of split 'test' by group by scene: {'train': 40"):
        described(release, split="test", split_by="both")


def test_a_release_without_a_split_by_group_has_none_by_both(tmp_path: Path) -> None:
    rows = rows_of(("train", "validation", "test"))
    rows["episodes"] = [row for row in rows["episodes"] if row["split"] == "train"]
    write_release(tmp_path / "train", rows=rows, splits=["train"])
    release = open_release(tmp_path / "train")
    assert splits_there(release, "scene") == SPLITS
    assert splits_there(release, "both") == ("train",)
    with pytest.raises(ValueError, match="split 'test' by group and scene is empty"):
        described(release, split="test", split_by="both")


# Summaries and commands.


@pytest.mark.parametrize("split_by", SPLIT_BYS)
def test_summaries_count_by_the_split_asked_for(
    release: Release, rows: list[dict[str, Any]], split_by: SplitBy
) -> None:
    summary = release_summary(release, split_by=split_by)
    for split in SPLITS:
        expected = expected_rows(rows, split, split_by)
        dataset = described(release, split=split, split_by=split_by)
        entry = {"selected": len(expected), "of": len(expected), "fingerprint": dataset.fingerprint}
        assert summary["selection"][split] == entry
        emotions = collections.Counter(row["emotion"] for row in expected)
        found = summary["statistics"]["balance"]["split"][split]
        assert {emotion: count for emotion, count in found.items() if count} == emotions
    of_dataset = release_summary(described(release, split="test", split_by=split_by))
    assert of_dataset == release_summary(release, split="test", split_by=split_by)


def test_commands_take_the_kind_of_split(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["info", str(folder), "--split-by", "both", "--split", "test"]) == 0
    text = capsys.readouterr().out
    assert "split by group and scene" in text
    assert f"{len(described(folder, split='test', split_by='both'))} of " in text
    options = ["--split-by", "scene", "--split", "test"]
    assert main(["plan", str(folder), *options, "--json"]) == 0
    plan = json.loads(capsys.readouterr().out)
    assert plan["scene_ids"] == ["room_005"]
    assert main(["download", str(folder), *options, "--out", str(tmp_path / "part")]) == 0
    assert "1 scene of split train" in capsys.readouterr().out
    assert main(["info", str(tmp_path / "part"), "--split-by", "scene"]) == 0
    assert "split by scene" in capsys.readouterr().out
    assert main(["plan", str(folder), "--split-by", "home"]) == 1
    assert "split_by must be one of group, scene, both, got 'home'" in capsys.readouterr().err


def test_places_are_those_of_the_whole_split_in_a_copy(folder: Path, tmp_path: Path) -> None:
    part = fetched(
        folder, tmp_path / "part", splits=["train"], split_by="scene", scene_ids=["room_001"]
    )
    copy = described(part, split="train", split_by="scene")
    whole = described(
        folder, split="train", split_by="scene", filter=[("scene_id", "==", "room_001")]
    )
    np.testing.assert_array_equal(copy.rows, whole.rows)
    assert copy.fingerprint == whole.fingerprint
    table = part.split_table("train", "scene")
    missing = np.setdiff1d(np.arange(table.num_episodes), table.held_rows)
    with pytest.raises(FileNotFoundError, match="is not in this partial copy"):
        table.episode(int(missing[0]))
