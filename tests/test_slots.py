"""Slots: every cell gets its number of episodes, matched sets stay together, no split shares any.

The laws hold for whatever was performed and asked for; hypothesis makes up both.
"""

from __future__ import annotations

import dataclasses
from collections import Counter, defaultdict
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inventories import planned, still

from affectsim_data.builders.compositions import read_compositions
from affectsim_data.builders.matching import connected_sets, matched_sets
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.slots import Slot, make_slots, planned_counts
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.schemas import CHALLENGES, SPLITS

ACTIONS = ("simple_walk", "sit_down", "knock_door")
PERFORMERS = {"train": 2, "validation": 1, "test": 1}


def by_motion(performances: list[Performance]) -> dict[str, Motion]:
    return {one.motion.motion_id: one.motion for one in performances}


def cells(slots: list[Slot]) -> Counter[tuple[Any, ...]]:
    """Episodes by split, challenge and action."""
    counts: Counter[tuple[Any, ...]] = Counter()
    for slot in slots:
        counts[slot.split, slot.challenge, slot.action] += len(slot.motion_ids)
    return counts


def used(slots: list[Slot], split: str) -> set[str]:
    return {one for slot in slots if slot.split == split for one in slot.motion_ids}


def inventory(
    performers: int = 4, takes: int = 2, actions: tuple[str, ...] = ACTIONS
) -> list[Performance]:
    return [
        still(f"p{number}", action, emotion, take=take)
        for number in range(performers)
        for action in actions
        for take in range(takes)
        for emotion in EMOTIONS
    ]


def grounded(**changes: Any) -> dict[str, Any]:
    entry: dict[str, Any] = {"family": "action_grounded", "actions": list(ACTIONS)}
    entry |= {"split_by": "performer", "performers": PERFORMERS}
    return entry | changes


def observed(**changes: Any) -> dict[str, Any]:
    entry = {"family": "observation_controlled", "actions": ["scenario"]}
    entry |= {"challenges": list(CHALLENGES), "split_by": "performance"}
    return entry | {"motions": {"train": 20, "validation": 7, "test": 5}} | changes


@st.composite
def plans(draw: st.DrawFn) -> tuple[Recipe, list[Performance]]:
    """Something to be composed from motions of which some are missing."""
    controlled = draw(st.booleans())
    actions = ("scenario",) if controlled else ACTIONS
    everything = inventory(5, draw(st.integers(2, 4)), actions)
    lost = draw(st.sets(st.integers(0, len(everything) - 1), max_size=8))
    there = [one for place, one in enumerate(everything) if place not in lost]
    names = CHALLENGES if controlled else ACTIONS
    shares = {name: draw(st.integers(1, 4)) for name in names}
    changes: dict[str, Any] = {
        "challenges" if controlled else "actions": shares,
        "episodes": {split: draw(st.integers(0, 150)) for split in SPLITS},
    }
    if not controlled:
        changes["performers"] = {"train": 3, "validation": ["p1"], "test": 1}
    entry = observed(**changes) if controlled else grounded(**changes)
    return dataclasses.replace(planned(entry), seed=draw(st.integers(0, 99))), there


@settings(max_examples=30)
@given(plans())
def test_every_cell_gets_its_share_of_the_episodes(
    plan: tuple[Recipe, list[Performance]],
) -> None:
    recipe, there = plan
    (composition,) = recipe.compositions
    assert composition.episodes is not None
    counts = cells(make_slots(recipe, there))
    for split, total in composition.episodes.items():
        asked = {
            (split, challenge, action): total * first * second
            for challenge, first in composition.challenges.items()
            for action, second in composition.actions.items()
        }
        assert sum(counts[cell] for cell in asked) == total
        assert all(abs(counts[cell] - exact) < 1.0 for cell, exact in asked.items())


@settings(max_examples=30)
@given(plans())
def test_emotions_of_a_cell_differ_by_incomplete_slots_alone(
    plan: tuple[Recipe, list[Performance]],
) -> None:
    recipe, there = plan
    slots = make_slots(recipe, there)
    emotion_of = {name: motion.emotion for name, motion in by_motion(there).items()}
    emotions: dict[Any, Counter[str]] = defaultdict(Counter)
    for (*cell, emotion), count in planned_counts(slots, emotion_of).items():
        emotions[tuple(cell)][emotion] = count
    incomplete = Counter(
        (slot.split, slot.family, slot.challenge, slot.action)
        for slot in slots
        if len(slot.motion_ids) < len(EMOTIONS)
    )
    for cell, counts in emotions.items():
        numbers = [counts[emotion] for emotion in EMOTIONS]
        assert max(numbers) - min(numbers) <= incomplete[cell]


@settings(max_examples=30)
@given(plans())
def test_a_slot_differs_in_emotion_alone_and_splits_share_nothing(
    plan: tuple[Recipe, list[Performance]],
) -> None:
    recipe, there = plan
    motions = by_motion(there)
    split_of: dict[Any, str] = {}
    slots = make_slots(recipe, there)
    assert len({slot.key for slot in slots}) == len(slots)
    for slot in slots:
        members = [motions[name] for name in slot.motion_ids]
        assert len({(one.performer_id, one.action, one.take) for one in members}) == 1
        assert len({one.emotion for one in members}) == len(members)
        assert not any(emotion in slot.key for emotion in EMOTIONS)
        one = members[0]
        grounded = slot.family == "action_grounded"
        owner = one.performer_id if grounded else (one.performer_id, one.take)
        assert split_of.setdefault(owner, slot.split) == slot.split


@settings(max_examples=20)
@given(plans(), st.randoms())
def test_order_of_performances_changes_nothing(
    plan: tuple[Recipe, list[Performance]], random: Any
) -> None:
    recipe, there = plan
    shuffled = random.sample(there, len(there))
    assert make_slots(recipe, shuffled) == make_slots(recipe, there)


def test_seed_draws_performers_and_motions() -> None:
    there = inventory()
    recipe = planned(grounded())
    drawn = {
        frozenset(used(make_slots(dataclasses.replace(recipe, seed=seed), there), "test"))
        for seed in range(12)
    }
    assert len(drawn) == 4


@settings(max_examples=30)
@given(
    st.lists(st.integers(0, 44), min_size=3, max_size=3).filter(lambda one: sum(one) <= 45),
    st.sets(st.integers(0, 59), max_size=5),
)
def test_every_split_uses_exactly_the_motions_asked_for(counts: list[int], lost: set[int]) -> None:
    there = inventory(4, 3, ("scenario",))
    there = [one for place, one in enumerate(there) if place not in lost]
    wanted = dict(zip(SPLITS, counts, strict=True))
    slots = make_slots(planned(observed(motions=wanted, repeats=2)), there)
    assert {split: len(used(slots, split)) for split in SPLITS} == wanted
    sets_in = {
        split: {slot.key.rpartition("/")[0] for slot in slots if slot.split == split}
        for split in SPLITS
    }
    assert not sets_in["train"] & (sets_in["validation"] | sets_in["test"])
    assert not sets_in["validation"] & sets_in["test"]


def test_matched_sets_are_taken_whole_as_far_as_the_number_allows() -> None:
    there = inventory(4, 3, ("scenario",))[1:]
    recipe = planned(observed(motions={"train": 32, "validation": 10, "test": 4}))
    slots = make_slots(recipe, there)
    sizes = {
        split: sorted(
            {
                slot.motion_ids: len(slot.motion_ids) for slot in slots if slot.split == split
            }.values()
        )
        for split in SPLITS
    }
    # The set that lost a motion serves where four are wanted.
    assert sizes == {"train": [2, 5, 5, 5, 5, 5, 5], "validation": [5, 5], "test": [4]}


def test_motions_are_drawn_from_every_action_in_turn() -> None:
    entry = grounded(motions={"train": 30, "validation": 15, "test": 15})
    slots = make_slots(planned(entry), inventory(takes=3))
    for split in SPLITS:
        sets = {slot.motion_ids: slot.action for slot in slots if slot.split == split}
        assert len(set(Counter(sets.values()).values())) == 1
        assert len(sets) == (6 if split == "train" else 3)


def test_repeats_place_every_motion_so_often_in_every_challenge() -> None:
    there = [
        still("p0", "interaction", e, take=t, partner_id="p1") for t in (0, 1, 2) for e in EMOTIONS
    ]
    entry: dict[str, Any] = {"family": "dyadic", "actions": ["interaction"]}
    entry |= {"split_by": "performance"}
    entry |= {"motions": {"train": 5, "validation": 3, "test": 4}, "repeats": 30}
    slots = make_slots(planned(entry), there)
    counts = Counter(name for slot in slots for name in slot.motion_ids)
    assert len(counts) == 12
    assert set(counts.values()) == {30}
    assert {slot.placement for slot in slots} == {"pair"}


# Matching.


def names_of(performances: list[Performance], action: str) -> list[list[str]]:
    sets = matched_sets(performances, [action], where="test.toml")
    return [list(one.motion_ids) for one in sets]


def test_somebody_who_does_another_thing_in_one_emotion_still_matches() -> None:
    """A restrained performer does an everyday scenario; so do others, under another emotion."""
    doing = {"angry": "threaten", "fearful": "wait", "happy": "dance", "neutral": "wait"}
    there = [still("p0", "scenario", e, performance=doing.get(e, "mourn")) for e in EMOTIONS]
    assert names_of(there, "scenario") == [[one.motion.motion_id for one in there]]


def test_what_several_emotions_show_in_a_take_is_matched_with_itself() -> None:
    there = [
        still("p0", "scenario", emotion, performance=what, take=1)
        for what in ("one", "two")
        for emotion in EMOTIONS
    ]
    there += [still("p0", "scenario", "sad", performance=what, take=1) for what in ("x", "y")]
    sets = matched_sets(there, ["scenario"], where="test.toml")
    assert [one.key for one in sets] == [
        "scenario/p0/match1/take1",
        "scenario/p0/one/take1",
        "scenario/p0/take1",
        "scenario/p0/two/take1",
    ]
    assert [len(one.motion_ids) for one in sets] == [1, 5, 1, 5]


def test_interactions_match_with_the_same_partner() -> None:
    there = [
        still("p0", "interaction", emotion, partner_id=partner)
        for partner in ("p1", "p2")
        for emotion in EMOTIONS
        if (partner, emotion) != ("p1", "angry")
    ]
    assert [len(one) for one in names_of(there, "interaction")] == [4, 5]


def test_versions_of_one_source_performance_stay_in_one_split() -> None:
    there = [
        still("p0", "scenario", e, take=version, performance=f"s{number}", group_id=f"{e}{number}")
        for number in range(6)
        for version in range(3)
        for e in EMOTIONS
    ]
    sources = connected_sets(matched_sets(there, ["scenario"], where="test.toml"))
    assert sorted(len(source) for source in sources) == [3] * 6
    recipe = planned(observed(motions={"train": 31, "validation": 15, "test": 9}))
    motions = by_motion(there)
    split_of: dict[str, str] = {}
    for slot in make_slots(recipe, there):
        for name in slot.motion_ids:
            group = motions[name].group_id
            assert split_of.setdefault(group, slot.split) == slot.split


def test_emotions_can_be_counted_one_by_one() -> None:
    entries = [
        grounded(emotions=[emotion], episodes={"train": 10 * n, "validation": 0, "test": 5})
        for n, emotion in enumerate(EMOTIONS, 1)
    ]
    by_name = {"train": ["p0", "p1"], "validation": ["p2"], "test": ["p3"]}
    there = inventory()
    recipe = planned(*[entry | {"performers": by_name} for entry in entries])
    emotion_of = {name: motion.emotion for name, motion in by_motion(there).items()}
    counts: Counter[tuple[str, str]] = Counter()
    for (split, *_, emotion), count in planned_counts(
        make_slots(recipe, there), emotion_of
    ).items():
        counts[split, emotion] += count
    assert counts == {("train", e): 10 * n for n, e in enumerate(EMOTIONS, 1)} | {
        ("test", e): 5 for e in EMOTIONS
    }


def test_split_by_action_shares_out_among_the_actions_of_a_split() -> None:
    splits = {"by": "action", "train": ["simple_walk", "sit_down"], "test": ["knock_door"]}
    entry: dict[str, Any] = {"family": "observation_controlled", "challenges": ["rear_view"]}
    entry |= {"actions": {"simple_walk": 3, "sit_down": 1, "knock_door": 4}}
    recipe = planned(entry | {"episodes": {"train": 40, "test": 7}}, splits=splits)
    assert cells(make_slots(recipe, inventory())) == {
        ("train", "rear_view", "simple_walk"): 30,
        ("train", "rear_view", "sit_down"): 10,
        ("test", "rear_view", "knock_door"): 7,
    }


# What is refused.


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        (
            grounded(actions=["juggle"]),
            r"test\.toml: \[\[compose\]\] 1 wants action 'juggle', but there is no motion of it; "
            r"there is: knock_door, scenario, simple_walk, sit_down",
        ),
        (
            grounded(performers={"train": 2, "validation": 1, "test": 3}),
            r"\[\[compose\]\] 1 wants 3 performers for test, but of 4 only 1 are left",
        ),
        (
            grounded(performers={"train": ["p0", "p1"], "test": 1}),
            r"\[\[compose\]\] 1 names no split for performer 'p[23]'; add it to train",
        ),
        (
            observed(motions={"train": 20, "validation": 18, "test": 9}),
            r"\[\[compose\]\] 1 wants 20 motions for train, but there are only 13",
        ),
        (
            observed(
                split_by="performer",
                performers=PERFORMERS | {"train": 3, "test": 0},
                motions={"train": 5, "validation": 5},
                episodes={"train": 5, "test": 8},
            ),
            r"\[\[compose\]\] 1 wants 2 episodes of action 'scenario' for test, "
            r"but no motion of it is in that split",
        ),
        (
            grounded(split_by="performance", motions={"train": 30, "validation": 30, "test": 30}),
            r"\[\[compose\]\] 1 puts performer 'p\d' into \w+, .* no two splits may share one",
        ),
    ],
)
def test_what_cannot_be_is_refused(entry: dict[str, Any], message: str) -> None:
    there = inventory(actions=(*ACTIONS, "scenario"))
    with pytest.raises(ValueError, match=message):
        make_slots(planned(entry), there)


def test_two_entries_that_split_one_performance_differently_are_refused() -> None:
    by_name = {"train": ["p0"], "validation": ["p1", "p2"], "test": ["p3"]}
    first = observed(split_by="performer", performers=by_name)
    first.pop("motions")
    second = first | {"performers": by_name | {"train": ["p3"], "test": ["p0"]}}
    with pytest.raises(ValueError, match=r"2 puts performance '.*' into train, .* 1 into test"):
        make_slots(planned(first, second), inventory(actions=("scenario",)))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"repeats": 0}, r"repeats must be a whole number from 1, got 0"),
        ({"repeats": 2, "episodes": {"train": 3}}, r"both repeats and episodes; keep one"),
        ({"emotions": ["angry", "proud"]}, r"emotions must be some of angry, .*got \['angry', 'pr"),
        (
            {"emotions": []},
            r"emotions must be some of angry, fearful, happy, neutral, sad, got \[\]",
        ),
        ({"actions": []}, r"actions must be names, each once, got \[\]"),
        ({"actions": ["walk", "walk"]}, r"actions must be names, each once"),
        ({"actions": {"walk": -1}}, r"names with shares above 0, got \{'walk': -1\}"),
        ({"episodes": {"train": 2.5}}, r"episodes train must be a whole number from 0, got 2\.5"),
        ({"episodes": {"tests": 2}}, r"episodes knows no 'tests'; is it 'test'\?"),
        ({"challenges": ["rear_view"]}, r"challenges are for observation_controlled"),
        ({"performers": {"train": ["p0"], "test": ["p0"]}}, r"names 'p0' more than once"),
        ({"performers": {"train": "p0"}}, r"train must be names or how many, got 'p0'"),
        ({"split_by": "performance"}, r"split_by performance needs motions"),
        ({"split_by": "scene"}, r"split_by must be one of performer, .*got 'scene'"),
        ({"repeat": 2}, r"\[\[compose\]\] 1 knows no 'repeat'; is it 'repeats'\?"),
    ],
)
def test_malformed_entries_are_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_compositions([grounded(**changes)], None, where="test.toml")


def test_rng_is_not_shared_between_entries() -> None:
    """What one entry asks for does not change what another gets."""
    alone = planned(observed())
    two = planned(observed(), grounded(performers={"train": 2, "validation": 1, "test": 1}))
    there = inventory(actions=(*ACTIONS, "scenario"))
    first = make_slots(alone, there)
    assert [slot for slot in make_slots(two, there) if slot.challenge] == first


@pytest.mark.parametrize("pairs", [1, 3])
def test_an_inventory_without_motions_to_spare_is_used_to_the_last(pairs: int) -> None:
    """Four takes of five emotions by few pairs: 12, 5 and 3 sequences, and none is lost."""
    performances = [
        still(f"p{pair}", "interaction", emotion, take=take, partner_id="q")
        for pair in range(pairs)
        for take in range(4)
        for emotion in EMOTIONS
    ]
    total = len(performances)
    counts = {"train": total - 8, "validation": 5, "test": 3}
    entry = {
        "family": "dyadic",
        "actions": ["interaction"],
        "split_by": "performance",
        "motions": counts,
        "episodes": counts,
    }
    slots = make_slots(planned(entry), performances)
    used = [motion_id for slot in slots for motion_id in slot.motion_ids]
    assert sorted(used) == sorted(one.motion.motion_id for one in performances)
