"""Concatenated datasets: the parts one after another, with one order, one fingerprint."""

from __future__ import annotations

import itertools
import pickle
from pathlib import Path
from typing import Any

import pytest
from varied_release import COUNTS, RemoteStore, varied_rows, write_varied_release

from affectsim_data import AffectSimDataset, Clip
from affectsim_data.loaders.concatenation import ConcatenatedDataset, concatenate
from affectsim_data.loaders.order import Episodes
from affectsim_data.loaders.places import Place
from affectsim_data.releases import Release

CLIP = Clip(num_frames=2, width=8, height=8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("varied") / "release"
    write_varied_release(out)
    return out


@pytest.fixture(scope="module")
def other_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("other") / "release"
    write_varied_release(out, seed=8)
    return out


def told(source: Path | Release, split: str, **options: Any) -> AffectSimDataset:
    return AffectSimDataset(source, split=split, images=False, clip=CLIP, **options)


def test_rows_are_those_of_the_parts_in_order(folder: Path) -> None:
    parts = [told(folder, "test"), told(folder, "validation", condition="p_init")]
    both = parts[0] + parts[1]
    expected = [row["episode_id"] for split in ("test", "validation") for row in varied_rows(split)]
    assert len(both) == len(expected) == COUNTS["test"] + COUNTS["validation"]
    assert [both.episode(i).episode_id for i in range(len(both))] == expected
    assert [one["episode_id"] for one in both.__getitems__(range(len(both)))] == expected
    assert both[-1]["episode_id"] == expected[-1]
    assert both.world(0).scene.scene_id == both.episode(0).scene_id
    assert [both[i]["condition"] for i in (7, 8)] == ["p_ref", "p_init"]
    assert isinstance(both, Episodes), "loaders take it"


def test_samples_say_their_place_in_the_whole(folder: Path) -> None:
    both = told(folder, "test") + told(folder, "validation")
    assert [both[i]["position"] for i in (3, 10, -1)] == [3, 10, 19]
    asked = both[Place(10, 4, 123, padding=True)]
    assert (asked["epoch"], asked["position"], asked["padding"]) == (4, 123, True)
    assert asked["episode_id"] == varied_rows("validation")[2]["episode_id"]


def test_however_it_is_put_together_it_is_the_same(folder: Path) -> None:
    a, b, c = (told(folder, split) for split in ("test", "validation", "train"))
    ways = [(a + b) + c, a + (b + c), concatenate([a, b, c]), concatenate([a + b, c])]
    assert len({one.fingerprint for one in ways}) == 1
    assert all(len(one.parts) == 3 for one in ways)


def test_other_parts_or_another_order_have_another_fingerprint(folder: Path) -> None:
    a, b = told(folder, "test"), told(folder, "validation")
    sets: list[Episodes] = [a, b, a + b, b + a, a + a, a + b + a, a.subset([0, 1]) + b]
    assert len({one.fingerprint for one in sets}) == len(sets)


def test_a_scene_has_one_code_whatever_part_it_is_in(folder: Path, other_folder: Path) -> None:
    parts = [told(folder, "test"), told(other_folder, "test"), told(folder, "validation")]
    whole = concatenate(parts)
    releases = [str(folder), str(other_folder), str(folder)]
    scenes = [
        (release, part.episode(i).scene_id)
        for release, part in zip(releases, parts, strict=True)
        for i in range(len(part))
    ]
    codes = whole.scene_codes.tolist()
    for one, other in itertools.combinations(range(len(whole)), 2):
        assert (codes[one] == codes[other]) == (scenes[one] == scenes[other])
    assert [whole.scene_ids[code] for code in codes] == [scene_id for _, scene_id in scenes]
    assert whole.source == f"{folder} + {other_folder}"


def test_files_ahead_are_asked_of_the_part_they_are_in(folder: Path) -> None:
    store, other = RemoteStore(folder), RemoteStore(folder)
    first, second = Release(store), Release(other)
    both = told(first, "test") + told(second, "validation")
    both.__getitems__([Place(9, 0, 0, ahead=(2, 8)), Place(1, 0, 1)])
    assert store.prefetched == [first.episode_files("test", [1, 2])]
    assert other.prefetched == [second.episode_files("validation", [1, 0])]


def test_it_travels_to_workers_with_releases_shared(folder: Path) -> None:
    release = Release(RemoteStore(folder))
    both = told(release, "test") + told(release, "validation")
    assert both.fingerprint
    assert len(both.scene_codes)
    back = pickle.loads(pickle.dumps(both))
    assert back.parts[0].release is back.parts[1].release
    assert back.fingerprint == both.fingerprint
    assert back[11]["episode_id"] == both[11]["episode_id"]


def test_what_cannot_be_joined_is_refused(folder: Path) -> None:
    with pytest.raises(ValueError, match="concatenate needs at least one dataset, got none"):
        concatenate([])
    with pytest.raises(ValueError, match="only AffectSimDatasets can be concatenated, got list"):
        concatenate([told(folder, "test"), [1]])
    both = ConcatenatedDataset([told(folder, "test"), told(folder, "validation")])
    with pytest.raises(IndexError, match="this concatenation has 20 episodes, got index 20"):
        both[20]
