"""`full` plans the paper's inventory, and `small` a little one of the same make."""

from __future__ import annotations

import tomllib
from collections import Counter, defaultdict

import numpy as np
import pytest
from inventories import asked_for

from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.slots import Slot, make_slots, planned_counts
from affectsim_data.content import content_path
from affectsim_data.motions import EMOTIONS
from affectsim_data.schemas import CHALLENGES, FAMILIES, SPLITS

PAPER = {
    # The paper's table of splits: performers or motions, episodes of train, validation, test.
    "action_grounded": ((8, 2, 2), (11999, 3003, 2899)),
    "observation_controlled": ((669, 84, 84), (6643, 831, 832)),
    "dyadic": ((34, 7, 7), (1020, 210, 210)),
}
EVERYBODY = ("ada", "ben", "cleo", "dan", "ela", "finn", "gita", "hugo")
ACTIONS = {"simple_walk", "being_seated", "sit_down", "knock_door"}


def screened(recipe: Recipe, *, rejected: int) -> list[Performance]:
    """What a recipe asks for, without some that no screening would let pass."""
    there = asked_for(recipe)
    gone = set(np.random.default_rng(3).permutation(len(there))[:rejected])
    return [one for place, one in enumerate(there) if place not in gone]


@pytest.fixture(scope="module")
def full() -> Recipe:
    return read_recipe("full")


@pytest.fixture(scope="module")
def there(full: Recipe) -> list[Performance]:
    return screened(full, rejected=14)  # one in a hundred


@pytest.fixture(scope="module")
def slots(full: Recipe, there: list[Performance]) -> list[Slot]:
    return make_slots(full, there)


def test_splits_are_those_of_the_paper(slots: list[Slot], there: list[Performance]) -> None:
    performer = {one.motion.motion_id: one.motion.performer_id for one in there}
    for family, (members, episodes) in PAPER.items():
        for split, num_members, num_episodes in zip(SPLITS, members, episodes, strict=True):
            here = [slot for slot in slots if (slot.family, slot.split) == (family, split)]
            assert sum(len(slot.motion_ids) for slot in here) == num_episodes
            motions = {one for slot in here for one in slot.motion_ids}
            people = {performer[one] for one in motions}
            assert len(people if family == "action_grounded" else motions) == num_members


def test_inventory_is_that_of_the_paper(slots: list[Slot], there: list[Performance]) -> None:
    episodes = Counter(slot.family for slot in slots for _ in slot.motion_ids)
    assert episodes == {"action_grounded": 17901, "observation_controlled": 8306, "dyadic": 1440}
    assert episodes.total() == 27_647
    motions = {
        family: {m for s in slots if s.family == family for m in s.motion_ids}
        for family in FAMILIES
    }
    assert {family: len(used) for family, used in motions.items()} == {
        "action_grounded": 422,
        "observation_controlled": 837,
        "dyadic": 48,
    }
    per_sequence = Counter(m for s in slots if s.family == "dyadic" for m in s.motion_ids)
    assert set(per_sequence.values()) == {30}
    split_of: dict[str, str] = {}
    for slot in slots:
        for one in slot.motion_ids:
            assert split_of.setdefault(one, slot.split) == slot.split


def test_challenges_and_actions_share_alike(slots: list[Slot], there: list[Performance]) -> None:
    counts: dict[tuple[str, str], Counter[str]] = defaultdict(Counter)
    for slot in slots:
        counts[slot.split, slot.family][slot.challenge or slot.action] += len(slot.motion_ids)
    for split in SPLITS:
        challenges = counts[split, "observation_controlled"]
        assert set(challenges) == set(CHALLENGES)
        assert max(challenges.values()) - min(challenges.values()) <= 1
        actions = counts[split, "action_grounded"]
        assert set(actions) == ACTIONS
        assert max(actions.values()) - min(actions.values()) <= 1


def test_emotions_are_nearly_balanced(slots: list[Slot], there: list[Performance]) -> None:
    emotion_of = {one.motion.motion_id: one.motion.emotion for one in there}
    emotions: dict[str, Counter[str]] = defaultdict(Counter)
    for (split, *_, emotion), count in planned_counts(slots, emotion_of).items():
        emotions[split][emotion] += count
    for counts in emotions.values():
        even = counts.total() / len(EMOTIONS)
        assert all(abs(counts[emotion] - even) <= 0.06 * even for emotion in EMOTIONS)


def test_cast_and_scenes_are_as_many_as_the_paper_has(full: Recipe) -> None:
    homes = tomllib.loads(content_path("builders", "homes-full.toml").read_text(encoding="utf-8"))
    assert full.scenes.files == "homes-full"
    assert homes["set"]["count"] == 57
    assert full.avatar_ids == EVERYBODY
    solo, scenarios, pairs = full.document["performances"]
    assert len(solo["performers"]) == 12
    people = [*solo["performers"], *scenarios["performers"], *np.ravel(pairs["pairs"])]
    assert len(set(people)) == len(people)


def test_small_is_a_little_full(full: Recipe) -> None:
    recipe = read_recipe("small")
    # Nothing spare but in scenarios and interactions: five of each may fail.
    slots = make_slots(recipe, asked_for(recipe))
    assert sum(len(slot.motion_ids) for slot in slots) == 2000
    homes = tomllib.loads(content_path("builders", "homes-small.toml").read_text(encoding="utf-8"))
    assert homes["set"]["count"] == 12
    shares = Counter((str(slot.split), str(slot.family)) for slot in slots for _ in slot.motion_ids)
    for family, (_, episodes) in PAPER.items():
        for split, count in zip(SPLITS, episodes, strict=True):
            assert shares[split, family] / 2000 == pytest.approx(count / 27_647, abs=0.02)
    for one, other in zip(recipe.compositions, full.compositions, strict=True):
        assert (one.actions, one.challenges, one.split_rule.by) == (
            other.actions,
            other.challenges,
            other.split_rule.by,
        )
    assert (recipe.camera, recipe.robot, recipe.thresholds) == (
        full.camera,
        full.robot,
        full.thresholds,
    )
