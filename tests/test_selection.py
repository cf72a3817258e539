"""Selecting episodes: filters against plain Python, identifiers, fingerprints, refusals."""

from __future__ import annotations

import dataclasses
import operator
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from varied_release import COUNTS, RemoteStore, varied_rows, write_varied_release

from affectsim_data import AffectSimDataset
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import MANIFEST_NAME, Release, open_release
from affectsim_data.releases.filters import Comparison, parse_where
from affectsim_data.releases.partial import Partial
from affectsim_data.releases.selection import select_rows, selection_fingerprint
from affectsim_data.schemas import CHALLENGES

ROWS = varied_rows("train")
IDS = [row["episode_id"] for row in ROWS]
SAD_OR_ANGRY: list[Comparison] = [("emotion", "in", ["sad", "angry"])]
FAR: list[Comparison] = [("initial_distance_m", ">=", 4.0)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("varied") / "release"
    write_varied_release(out)
    return out


@pytest.fixture(scope="module")
def varied(folder: Path) -> Release:
    return open_release(folder)


# Filters mean what they say.

_RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
_VALUES: dict[str, st.SearchStrategy[Any]] = {
    "emotion": st.sampled_from(EMOTIONS),
    "challenge": st.sampled_from(CHALLENGES),
    "scene_id": st.sampled_from(["empty_room", "crate_room", "attic"]),
    "initial_distance_m": st.sampled_from([1.0, 2, 4.0, 6, 6.5]),
    "d_star_3m": st.floats(0.0, 3.0),
    "seed": st.integers(0, 3),
}


@st.composite
def comparisons(draw: st.DrawFn) -> Comparison:
    column = draw(st.sampled_from(list(_VALUES)))
    relation = draw(st.sampled_from([*_RELATIONS, "in", "not in"]))
    if relation in ("in", "not in"):
        return column, relation, draw(st.lists(_VALUES[column], min_size=1, max_size=3))
    if (
        column in ("challenge", "d_star_3m")
        and relation in ("=", "==", "!=")
        and draw(st.booleans())
    ):
        return column, relation, None
    return column, relation, draw(_VALUES[column])


def holds(row: dict[str, Any], column: str, relation: str, value: Any) -> bool:
    found = row[column]
    if relation == "in":
        return found in value
    if relation == "not in":
        return found not in value
    if value is None:
        return (found is None) == (relation != "!=")
    return found is not None and _RELATIONS[relation](found, value)


@settings(max_examples=150)
@given(st.lists(st.lists(comparisons(), min_size=1, max_size=3), min_size=1, max_size=2))
def test_filters_agree_with_plain_python(folder: Path, groups: list[list[Comparison]]) -> None:
    expected = [
        place
        for place, row in enumerate(ROWS)
        if any(all(holds(row, *one) for one in group) for group in groups)
    ]
    release = open_release(folder)
    if expected:
        assert select_rows(release, "train", filter=groups).tolist() == expected
    else:
        with pytest.raises(ValueError, match="no episode of split 'train' matches filter"):
            select_rows(release, "train", filter=groups)


def test_one_list_means_all_and_lists_of_lists_mean_any(varied: Release) -> None:
    both = select_rows(varied, "train", filter=[*SAD_OR_ANGRY, *FAR])
    either = select_rows(varied, "train", filter=[SAD_OR_ANGRY, FAR])
    one, other = (set(select_rows(varied, "train", filter=f).tolist()) for f in (SAD_OR_ANGRY, FAR))
    assert set(both.tolist()) == one & other
    assert set(either.tolist()) == one | other


def test_columns_of_the_index_need_no_other_file(folder: Path) -> None:
    store = RemoteStore(folder)
    select_rows(Release(store), "train", filter=SAD_OR_ANGRY)
    assert store.read_names == store.manifest.table_files("index", "train")


def test_measurements_are_read_from_the_episodes_of_the_split_only(folder: Path) -> None:
    store = RemoteStore(folder)
    select_rows(Release(store), "train", filter=FAR)
    files = store.manifest.table_files("episodes", "train")
    assert store.read_names == files
    assert store.prefetched == [files]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ([("emotoin", "==", "sad")], r"no column 'emotoin'; there are episode_id, .*emotion"),
        ([("reference_trajectory", "==", b"")], r"no column 'reference_trajectory'"),
        ([("emotion", "~", "sad")], r"'~', 'sad'\): operator must be one of =, ==, .*not in"),
        ([("emotion", "==", 3)], r"emotion is text, got 3"),
        ([("emotion", "==", None)], r"emotion is text, got None"),
        ([("initial_distance_m", ">", "3")], r"initial_distance_m is a number, got '3'"),
        ([("initial_distance_m", ">", True)], r"initial_distance_m is a number, got True"),
        ([("d_star_3m", ">", None)], r"d_star_3m is a number, got None"),
        ([("emotion", "in", "sad")], r"'in' takes a list of values"),
        ([("emotion", "in", [])], r"'in' takes a list of values"),
        ([("emotion", "in", ["sad", 3])], r"emotion is text, got 3"),
        ([], r"filter must be a list of \(column, operator, value\)"),
        ({"emotion": "sad"}, r"filter must be a list of .*got \{'emotion': 'sad'\}"),
        ("emotion=sad", r"filter must be a list of .*got 'emotion=sad'"),
        ([[("emotion", "==", "sad")], []], r"expected lists of comparisons, got \[\]"),
        ([("emotion", "==")], r"expected \(column, operator, value\), got \('emotion', '=='\)"),
        ([["emotion", "==", "sad"]], r"expected \(column, operator, value\), got 'emotion'"),
    ],
)
def test_malformed_filters_are_refused(folder: Path, wrong: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        AffectSimDataset(folder, split="train", filter=wrong)


@pytest.mark.parametrize(
    ("nothing", "message"),
    [
        ([("emotion", "==", "sadd")], r"'sadd'\)\]; there are emotion: angry, fearful, happy, "),
        ([("initial_distance_m", ">", 9)], r"there are initial_distance_m: 2 to 6"),
        ([("challenge", "==", "x")], r"challenge: far_visible, .*rear_view, null"),
        ([("episode_id", "==", "x")], r"varied/train-0009, \.\.\. \(300 in all\)"),
    ],
)
def test_a_filter_that_nothing_matches_says_what_there_is(
    folder: Path, nothing: list[Comparison], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        AffectSimDataset(folder, split="train", filter=nothing)


# On the command line.


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("emotion=sad", ("emotion", "==", "sad")),
        ("emotion == sad", ("emotion", "==", "sad")),
        ("emotion!=sad, angry", ("emotion", "not in", ["sad", "angry"])),
        ("initial_distance_m>=3", ("initial_distance_m", ">=", 3.0)),
        ("initial_bearing_deg<-1e1", ("initial_bearing_deg", "<", -10.0)),
        ("seed=7", ("seed", "==", 7)),
        ("challenge=none", ("challenge", "==", None)),
        ("challenge=none,rear_view", ("challenge", "in", [None, "rear_view"])),
        ("source=a=b", ("source", "==", "a=b")),
    ],
)
def test_where_texts(text: str, expected: Comparison) -> None:
    assert parse_where([text]) == [expected]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("emotion", r"'emotion': expected COLUMN, one of = != < <= > >="),
        ("emotion=", r"expected COLUMN"),
        ("=sad", r"expected COLUMN"),
        ("emotions=sad", r"no column 'emotions'; there are"),
        ("initial_distance_m>=far", r"initial_distance_m is a number, got 'far'"),
        ("seed=7.5", r"seed is a whole number, got '7.5'"),
        ("initial_distance_m>3,4", r"> takes one value, got 2"),
        ("emotion=sad,,", r"'emotion=sad,,': a value is missing between commas"),
        ("challenge<none", r"challenge is text, got None"),
    ],
)
def test_malformed_where_texts_are_refused(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        parse_where([text])


# By identifier.


def test_episodes_come_in_the_order_asked_for(folder: Path) -> None:
    wanted = [IDS[5], IDS[299], IDS[0]]
    dataset = AffectSimDataset(folder, split="train", episodes=wanted)
    assert [dataset.episode(i).episode_id for i in range(3)] == wanted
    assert dataset.rows.tolist() == [5, 299, 0]


def test_excluded_episodes_are_gone_and_the_rest_keeps_its_order(folder: Path) -> None:
    dataset = AffectSimDataset(folder, split="train", exclude=[IDS[7], IDS[2]])
    assert dataset.rows.tolist() == [i for i in range(300) if i not in (2, 7)]


def test_filter_episodes_and_exclude_all_hold(folder: Path) -> None:
    sad = [i for i, row in enumerate(ROWS) if row["emotion"] == "sad"]
    wanted = [*sad[:3][::-1], next(i for i, row in enumerate(ROWS) if row["emotion"] == "angry")]
    dataset = AffectSimDataset(
        folder,
        split="train",
        filter=[("emotion", "==", "sad")],
        episodes=[IDS[i] for i in wanted],
        exclude=[IDS[sad[1]]],
    )
    assert dataset.rows.tolist() == [sad[2], sad[0]]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"episodes": [IDS[0], "no/1"]}, r"episodes: 1 of 2 are not in split 'train' .*: 'no/1'"),
        ({"episodes": [f"no/{i}" for i in range(12)]}, r"12 of 12 .*'no/0', .*'no/9', \.\.\.$"),
        ({"episodes": ["varied/test-0000"]}, r"whose ids look like 'varied/train-0000': 'varied/t"),
        ({"episodes": [IDS[3], IDS[4], IDS[3]]}, r"episodes: 1 are named twice: 'varied/train-000"),
        ({"episodes": IDS[0]}, r"episodes must be a list of episode ids, got 'varied/"),
        ({"episodes": [3]}, r"episodes must be a list of episode ids, got \[3\]"),
        ({"episodes": []}, r"leave no episode of the 300 in split 'train'"),
        ({"exclude": ["no/1"]}, r"exclude: 1 of 1 are not in split 'train'"),
        ({"exclude": IDS}, r"leave no episode of the 300 in split 'train'"),
    ],
)
def test_identifiers_that_cannot_be_meant_are_refused(
    folder: Path, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        AffectSimDataset(folder, split="train", **options)


# What identifies a selection.


def test_the_same_episodes_in_the_same_order_have_one_fingerprint(folder: Path) -> None:
    sad = [i for i, row in enumerate(ROWS) if row["emotion"] == "sad"]
    others = [row["episode_id"] for row in ROWS if row["emotion"] != "sad"]
    whole = AffectSimDataset(folder, split="train")
    ways = [
        AffectSimDataset(folder, split="train", filter=[("emotion", "==", "sad")]),
        AffectSimDataset(folder, split="train", filter=[[("emotion", "in", ("sad",))]]),
        AffectSimDataset(folder, split="train", episodes=[IDS[i] for i in sad]),
        AffectSimDataset(folder, split="train", exclude=others),
        AffectSimDataset(folder, split="train", condition="p_mon", clip="full").subset(sad),
        whole.subset([row["emotion"] == "sad" for row in ROWS]),
        whole.subset(slice(None)).subset(np.array(sad)),
    ]
    assert len({one.fingerprint for one in ways}) == 1
    assert whole.subset(slice(None)).fingerprint == whole.fingerprint != ways[0].fingerprint
    assert int(whole.fingerprint, 16) < 16**64


def test_other_episodes_orders_splits_and_contents_have_others(
    folder: Path, varied: Release, tmp_path: Path
) -> None:
    write_varied_release(tmp_path / "other", seed=8)
    other = open_release(tmp_path / "other")
    found = [
        selection_fingerprint(varied, "train", [0, 1]),
        selection_fingerprint(varied, "train", [1, 0]),
        selection_fingerprint(varied, "train", [0, 2]),
        selection_fingerprint(varied, "train", [0]),
        selection_fingerprint(varied, "test", [0, 1]),
        selection_fingerprint(other, "train", [0, 1]),
    ]
    assert len(set(found)) == len(found)


def test_a_copy_elsewhere_has_the_same_fingerprint(folder: Path) -> None:
    far = AffectSimDataset(Release(RemoteStore(folder)), split="train")
    assert far.source != str(folder)
    assert far.fingerprint == AffectSimDataset(folder, split="train").fingerprint


# Partial copies.


@pytest.fixture
def partial(folder: Path, tmp_path: Path) -> Release:
    """The first shard of the training split and one of two rooms."""
    store = RemoteStore(folder)
    shard = store.manifest.table_files("episodes", "train")[0]
    files = {
        name: entry
        for name, entry in store.manifest.files.items()
        if name == shard or not name.startswith(("episodes", "index/test", "index/val"))
    }
    part = Partial(
        uri="hf://datasets/org/varied@0123456",
        manifest_sha256=store.manifest.sha256,
        scene_ids={"train": ("crate_room",)},
        splits=("train", "validation", "test"),
        first_rows={shard: 0},
    )
    store.manifest = dataclasses.replace(store.manifest, files=files, partial_of=part)
    return Release(store)


def test_a_partial_copy_has_the_episodes_of_its_scenes(folder: Path, partial: Release) -> None:
    expected = [i for i, row in enumerate(ROWS[:256]) if row["scene_id"] == "crate_room"]
    dataset = AffectSimDataset(partial, split="train")
    assert dataset.rows.tolist() == expected
    assert [dataset.episode(i).episode_id for i in (0, -1)] == [IDS[expected[i]] for i in (0, -1)]
    far = AffectSimDataset(partial, split="train", filter=FAR)
    assert far.rows.tolist() == [i for i in expected if ROWS[i]["initial_distance_m"] >= 4.0]
    same = AffectSimDataset(folder, split="train", episodes=[IDS[i] for i in far.rows])
    assert far.fingerprint == same.fingerprint


def test_a_partial_copy_says_what_it_lacks(partial: Release) -> None:
    with pytest.raises(ValueError, match=r"holds only 1 scene of split train; .*--split test"):
        AffectSimDataset(partial, split="test")
    with pytest.raises(FileNotFoundError, match=r"episode 260 of split 'train' is not in this "):
        partial.episode("train", 260)
    empty_room = next(row["episode_id"] for row in ROWS if row["scene_id"] == "empty_room")
    with pytest.raises(ValueError, match="episodes: 1 of 1 are not in split 'train'"):
        AffectSimDataset(partial, split="train", episodes=[empty_room])


# Travelling.


def test_a_dataset_travels_without_its_index(folder: Path) -> None:
    dataset = AffectSimDataset(folder, split="train", filter=FAR)
    empty = len(pickle.dumps(dataset.release))
    assert dataset.scene_codes.sum() >= 0, "computed, and not to travel"
    dataset.episode(0)
    payload = pickle.dumps(dataset)
    assert len(payload) < empty + 4 * len(dataset) + 2_000
    back = pickle.loads(payload)
    assert back.rows.tolist() == dataset.rows.tolist()
    assert back.fingerprint == dataset.fingerprint
    assert [back.episode(i).episode_id for i in (0, -1)] == [
        dataset.episode(i).episode_id for i in (0, -1)
    ]


def test_every_row_is_read_as_it_was_written(varied: Release) -> None:
    for split, count in COUNTS.items():
        for place in range(count):
            row = varied.episode(split, place).to_row()
            written = {**varied_rows(split)[place], "initial_distance_m": row["initial_distance_m"]}
            assert row == {**written, "schema_version": row["schema_version"]}


def test_the_manifest_is_all_a_release_is_opened_by(folder: Path) -> None:
    store = RemoteStore(folder)
    dataset = AffectSimDataset(Release(store), split="train")
    assert len(dataset) == 300
    assert dataset.fingerprint
    assert store.read_names == []
    assert (folder / MANIFEST_NAME).is_file()
