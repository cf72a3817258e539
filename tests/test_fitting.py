"""Counts cut down to what there is: in proportion, told, and missing in the cells."""

from __future__ import annotations

import dataclasses
import itertools
from collections import Counter
from typing import Any

import pytest
from inventories import still

from affectsim_data.builders.cells import cell_rows
from affectsim_data.builders.compositions import read_compositions
from affectsim_data.builders.fitting import fitted, with_unmet
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.slots import make_slots
from affectsim_data.motions import EMOTIONS

GROUNDED = {
    "family": "action_grounded",
    "actions": ["simple_walk", "knock_door"],
    "split_by": "performer",
    "performers": {"train": 4, "validation": 1, "test": 1},
    "episodes": {"train": 80, "validation": 20, "test": 20},
}
CONTROLLED = {
    "family": "observation_controlled",
    "actions": ["scenario"],
    "challenges": ["far_visible", "rear_view"],
    "split_by": "performance",
    "motions": {"train": 20, "validation": 5, "test": 5},
    "episodes": {"train": 200, "validation": 50, "test": 50},
}


def asking(*entries: dict[str, Any]) -> Recipe:
    compositions = read_compositions(list(entries), None, where="tiny")
    return dataclasses.replace(read_recipe("mini"), compositions=compositions)


def people(count: int, *actions: str) -> list[Performance]:
    """Everybody shows every action in every emotion."""
    return [
        still(f"p{number}", action, emotion)
        for number, action, emotion in itertools.product(range(count), actions, EMOTIONS)
    ]


def rows_of(recipe: Recipe, performances: list[Performance]) -> list[dict[str, Any]]:
    emotion_of = {one.motion.motion_id: one.motion.emotion for one in performances}
    return cell_rows(make_slots(recipe, performances), emotion_of, [])


def test_what_is_complete_stays_as_it_is() -> None:
    recipe = asking(GROUNDED, CONTROLLED)
    performances = people(6, "simple_walk", "knock_door", "scenario")
    assert fitted(recipe, performances) == (recipe, ())
    rows = rows_of(recipe, performances)
    assert with_unmet(rows, recipe, recipe) == rows


def test_fewer_performers_give_fewer_episodes_where_there_are_most() -> None:
    recipe = asking(GROUNDED)
    performances = people(5, "simple_walk", "knock_door")
    less, lines = fitted(recipe, performances)
    assert lines == (
        "[[compose]] 1, action_grounded: 3 of 4 performers for train, 60 of 80 episodes for train",
    )
    rows = with_unmet(rows_of(less, performances), recipe, less)
    planned: Counter[str] = Counter()
    for row in rows:
        planned[row["split"]] += row["planned"]
        assert (row["binding_constraint"] == "motions") == (row["composed"] < row["planned"])
    assert planned == {"train": 80, "validation": 20, "test": 20}
    assert sum(row["composed"] for row in rows) == 100


def test_an_action_that_lacks_is_not_made_up_for_by_others() -> None:
    recipe = asking(GROUNDED)
    performances = people(6, "simple_walk")
    less, lines = fitted(recipe, performances)
    assert "no motion of knock_door" in lines[0]
    rows = with_unmet(rows_of(less, performances), recipe, less)
    missing = [row for row in rows if row["action"] == "knock_door"]
    assert {(row["split"], row["emotion"]) for row in missing} == set(
        itertools.product(("train", "validation", "test"), EMOTIONS)
    )
    assert sum(row["planned"] for row in missing) == 60
    assert all(row["composed"] == 0 for row in missing)


def test_motions_that_lack_are_taken_from_the_largest_split() -> None:
    recipe = asking(CONTROLLED)
    performances = people(5, "scenario")
    less, lines = fitted(recipe, performances)
    assert less.compositions[0].motions == {"train": 15, "validation": 5, "test": 5}
    assert less.compositions[0].episodes == {"train": 150, "validation": 50, "test": 50}
    assert lines[0].endswith("15 of 20 motions for train, 150 of 200 episodes for train")


def test_families_without_any_motion_are_left_out() -> None:
    recipe = asking(GROUNDED, CONTROLLED)
    less, lines = fitted(recipe, people(6, "scenario"))
    assert [one.family for one in less.compositions] == ["observation_controlled"]
    assert lines == ("[[compose]] 1, action_grounded: left out, there is no motion for it",)
    with pytest.raises(ValueError, match=r"there is no motion for any \[\[compose\]\]"):
        fitted(recipe, people(6, "interaction"))
