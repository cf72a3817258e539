"""Slots of a release: which matched motions share a placement, and how many episodes a cell gets.

A *matched set* holds one motion of the same performer, action and take under each emotion. Every
slot is one placement for one matched set, so that nothing but the motion depends on the emotion; a
*cell* is the episodes of one split, family, challenge, action and emotion.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from affectsim_data.builders.compositions import Composition, PlacementKind
from affectsim_data.builders.matching import MatchedSet, matched_sets
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.splitting import some_of, split_sets
from affectsim_data.schemas import Challenge, Family, Split

__all__ = ["CellKey", "Slot", "make_slots", "planned_counts"]

CellKey = tuple[Split, Family, Challenge | None, str, str]
"""Split, family, challenge, action, emotion."""


@dataclasses.dataclass(frozen=True)
class Slot:
    """One placement to be found, and the motions that will share it."""

    key: str
    """Stable name: seeds the slot's random numbers, names it in reports; emotion-free."""
    split: Split
    family: Family
    challenge: Challenge | None
    action: str
    placement: PlacementKind
    motion_ids: tuple[str, ...]
    """The targets' motions, which differ in emotion."""


def make_slots(recipe: Recipe, performances: Sequence[Performance]) -> list[Slot]:
    """The slots a recipe asks for, in a fixed order that the order of performances cannot change.

    With `episodes` in a `[[compose]]` every cell of split, challenge and action gets exactly its
    share of them: matched sets take placements in turn, and the last slot takes as many of its
    motions as are still asked for.

    Raises:
        ValueError: There is no motion of an action, or too few performers or motions; or two
            splits would share a performer, performance or interaction.
    """
    slots: list[Slot] = []
    turns: Counter[str] = Counter()
    split_of: dict[str, tuple[Split, int]] = {}
    for number, composition in enumerate(recipe.compositions, 1):
        where = f"{recipe.path}: [[compose]] {number}"
        sets = matched_sets(
            performances, composition.actions, emotions=composition.emotions, where=where
        )
        rng = np.random.default_rng([recipe.seed, 5, number])
        for split, members in split_sets(sets, composition, rng, where=where).items():
            for group in sorted({name for one in members for name in _groups(one, composition)}):
                other, entry = split_of.setdefault(group, (split, number))
                if other != split:
                    raise ValueError(
                        f"{where} puts {group} into {split}, [[compose]] {entry} into {other}; "
                        "no two splits may share one: split both entries alike, by performer"
                    )
            slots += _slots_of(members, composition, split, rng, turns, where=where)
    return slots


def planned_counts(slots: Sequence[Slot], emotion_of: Mapping[str, str]) -> dict[CellKey, int]:
    """Episodes by cell; `emotion_of` gives the emotion of a motion."""
    cells: Counter[CellKey] = Counter()
    for slot in slots:
        for motion_id in slot.motion_ids:
            cell = (slot.split, slot.family, slot.challenge, slot.action, emotion_of[motion_id])
            cells[cell] += 1
    return dict(cells)


def _groups(one: MatchedSet, composition: Composition) -> set[str]:
    """What no two splits may share, named for an error message."""
    if composition.family == "action_grounded":
        return {f"performer {one.performer_id!r}"}
    return {f"performance {group_id!r}" for group_id in one.group_ids}


def _slots_of(
    sets: Sequence[MatchedSet],
    composition: Composition,
    split: Split,
    rng: np.random.Generator,
    turns: Counter[str],
    *,
    where: str,
) -> list[Slot]:
    """Slots of a split, cell by cell; `turns` counts the slots of a matched set and challenge."""
    slots: list[Slot] = []
    for (action, challenge), count in _cell_counts(sets, composition, split).items():
        members = [one for one in sets if one.action == action]
        if count and not members:
            raise ValueError(
                f"{where} wants {count} episodes of action {action!r} for {split}, "
                "but no motion of it is in that split"
            )
        for one, motion_ids in _turns(members, composition, count, rng):
            stem = f"{one.key}/{challenge or composition.family}"
            slots.append(
                Slot(
                    f"{stem}/{turns[stem]}",
                    split,
                    composition.family,
                    challenge,
                    action,
                    composition.placement_of(action),
                    motion_ids,
                )
            )
            turns[stem] += 1
    return slots


def _cell_counts(
    sets: Sequence[MatchedSet], composition: Composition, split: Split
) -> dict[tuple[str, Challenge | None], int | None]:
    """How many episodes each action and challenge gets; `None` for `repeats` of every motion."""
    actions = composition.actions
    if composition.split_rule.by == "action":
        there = {one.action for one in sets}
        actions = {one: share for one, share in actions.items() if one in there} or actions
    cells = list(itertools.product(actions, composition.challenges))
    if composition.episodes is None:
        return dict.fromkeys(cells)
    total = sum(actions.values())
    shares = [actions[a] * composition.challenges[c] / total for a, c in cells]
    return dict(zip(cells, _apportioned(composition.episodes[split], shares), strict=True))


def _turns(
    sets: Sequence[MatchedSet],
    composition: Composition,
    count: int | None,
    rng: np.random.Generator,
) -> Iterator[tuple[MatchedSet, tuple[str, ...]]]:
    """Set and motions of the slots of a cell with `count` episodes."""
    if count is None:
        for one in sets:
            yield from itertools.repeat((one, one.motion_ids), composition.repeats)
        return
    # Another order for every cell: the sets that get one placement more are not always the same.
    order = [sets[place] for place in rng.permutation(len(sets))]
    for one in itertools.cycle(order):
        if count <= 0:
            return
        chosen = some_of(one.motion_ids, count, rng)
        yield one, chosen
        count -= len(chosen)


def _apportioned(total: int, shares: Sequence[float]) -> list[int]:
    """Whole numbers that sum to the total and are nearest to its shares, by largest remainders."""
    exact = [total * share for share in shares]
    counts = [math.floor(value + 1e-9) for value in exact]
    order = sorted(range(len(exact)), key=lambda place: (counts[place] - exact[place], place))
    for place in order[: total - sum(counts)]:
        counts[place] += 1
    return counts


def slot_seed(recipe_seed: int, slot: Slot) -> list[int]:
    """What seeds a slot's random numbers: the recipe's seed and the slot's name alone."""
    return [recipe_seed, zlib.crc32(slot.key.encode())]
