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
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.builders.compositions import Composition, PlacementKind
from affectsim_data.builders.matching import MatchedSet, connected_sets, matched_sets
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe
from affectsim_data.schemas import SPLITS, Challenge, Family, Split

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
    """The slots a recipe asks for, in a fixed order.

    With `episodes` in a `[[compose]]` every cell of split, challenge and action gets exactly its
    share of them: matched sets take placements in turn, and the last slot takes as many of its
    motions as are still asked for.

    Raises:
        ValueError: There is no motion of an action, or too few performers or motions.
    """
    slots: list[Slot] = []
    for number, composition in enumerate(recipe.compositions):
        where = f"{recipe.path}: [[compose]] {number + 1}"
        sets = matched_sets(performances, composition.actions, where=where)
        rng = np.random.default_rng([recipe.seed, 5, number])
        for split, members in _split_sets(sets, composition, rng, where=where).items():
            slots += _slots_of(members, composition, split, rng)
    repeated = [key for key, count in Counter(slot.key for slot in slots).items() if count > 1]
    if repeated:
        raise ValueError(f"{recipe.path}: [[compose]] entries ask twice for {repeated[0]!r}")
    return slots


def planned_counts(slots: Sequence[Slot], emotion_of: Mapping[str, str]) -> dict[CellKey, int]:
    """Episodes by cell; `emotion_of` gives the emotion of a motion."""
    cells: Counter[CellKey] = Counter()
    for slot in slots:
        for motion_id in slot.motion_ids:
            cell = (slot.split, slot.family, slot.challenge, slot.action, emotion_of[motion_id])
            cells[cell] += 1
    return dict(cells)


def _slots_of(
    sets: Sequence[MatchedSet], composition: Composition, split: Split, rng: np.random.Generator
) -> list[Slot]:
    """Slots of a split: cell by cell, the matched sets in turn."""
    slots: list[Slot] = []
    cells = list(itertools.product(composition.actions.items(), composition.challenges.items()))
    shares = [action_share * share for (_, action_share), (_, share) in cells]
    wanted: Sequence[int | None] = [None] * len(cells)
    if composition.episodes is not None:
        wanted = _apportioned(composition.episodes[split], shares)
    for ((action, _), (challenge, _)), count in zip(cells, wanted, strict=True):
        members = [one for one in sets if one.action == action]
        for turn, one, motion_ids in _turns(members, composition, count, rng):
            key = "/".join((one.key, challenge or composition.family, str(turn)))
            slots.append(
                Slot(
                    key,
                    split,
                    composition.family,
                    challenge,
                    action,
                    composition.placement_of(action),
                    motion_ids,
                )
            )
    return slots


def _turns(
    sets: Sequence[MatchedSet],
    composition: Composition,
    count: int | None,
    rng: np.random.Generator,
) -> list[tuple[int, MatchedSet, tuple[str, ...]]]:
    """Turn, set and motions of the slots of a cell with `count` episodes."""
    if not sets:
        return []
    if count is None:
        return [(turn, one, one.motion_ids) for one in sets for turn in range(composition.repeats)]
    slots: list[tuple[int, MatchedSet, tuple[str, ...]]] = []
    # Another order for every cell: the sets that get one placement more are not always the same.
    order = [sets[place] for place in rng.permutation(len(sets))]
    for turn in itertools.count():
        for one in order:
            if count <= 0:
                return slots
            chosen = one.motion_ids
            if count < len(chosen):
                kept = sorted(rng.permutation(len(chosen))[:count])
                chosen = tuple(chosen[place] for place in kept)
            slots.append((turn, one, chosen))
            count -= len(chosen)
    raise AssertionError("unreachable")


def _apportioned(total: int, shares: Sequence[float]) -> list[int]:
    """Whole numbers that sum to the total and are nearest to its shares, by largest remainders."""
    exact = [total * share for share in shares]
    counts = [math.floor(value + 1e-9) for value in exact]
    order = sorted(range(len(exact)), key=lambda place: (counts[place] - exact[place], place))
    for place in order[: total - sum(counts)]:
        counts[place] += 1
    return counts


def _split_sets(
    sets: Sequence[MatchedSet], composition: Composition, rng: np.random.Generator, *, where: str
) -> dict[Split, list[MatchedSet]]:
    """The matched sets of each split."""
    rule = composition.split_rule
    if rule.by == "performance":
        return _fill_motions(dict.fromkeys(SPLITS, sets), composition, rng, where=where)
    names = sorted({one.performer_id if rule.by == "performer" else one.action for one in sets})
    split_of = _split_of_names(names, composition, rng, where=where)
    parted: dict[Split, list[MatchedSet]] = {split: [] for split in SPLITS}
    for one in sets:
        parted[split_of[one.performer_id if rule.by == "performer" else one.action]].append(one)
    if composition.motions is None:
        return parted
    return _fill_motions(parted, composition, rng, where=where)


def _split_of_names(
    names: Sequence[str], composition: Composition, rng: np.random.Generator, *, where: str
) -> dict[str, Split]:
    rule = composition.split_rule
    left = [names[place] for place in rng.permutation(len(names))]
    split_of: dict[str, Split] = {}
    for split in SPLITS:
        members = rule.members.get(split, ())
        if isinstance(members, int):
            if members > len(left):
                raise ValueError(
                    f"{where} wants {members} {rule.by}s for {split}, but of "
                    f"{len(names)} only {len(left)} are left"
                )
            chosen, left = left[:members], left[members:]
        else:
            chosen = list(members)
        split_of |= dict.fromkeys(chosen, split)
    for name in names:
        if name not in split_of:
            raise ValueError(
                f"{where} names no split for {rule.by} {name!r}; "
                "add it to train, validation or test"
            )
    return split_of


def _fill_motions(
    parted: Mapping[Split, Sequence[MatchedSet]],
    composition: Composition,
    rng: np.random.Generator,
    *,
    where: str,
) -> dict[Split, list[MatchedSet]]:
    """As many motions for each split as asked for; sets of one source stay in one split.

    The smallest split chooses first, so that what a source has too much is lost where it matters
    least.
    """
    assert composition.motions is not None
    wanted = composition.motions
    used: set[str] = set()
    filled: dict[Split, list[MatchedSet]] = {split: [] for split in SPLITS}
    for split in sorted(SPLITS, key=lambda one: wanted[one]):
        left = wanted[split]
        sources = connected_sets(parted[split])
        for place in rng.permutation(len(sources)):
            source = sources[place]
            if left <= 0 or source[0].key in used:
                continue
            # None of a source that is used in part may go to another split.
            used |= {one.key for one in source}
            for one in source:
                if left <= 0:
                    break
                kept = min(left, len(one.motion_ids))
                chosen = sorted(rng.permutation(len(one.motion_ids))[:kept])
                motion_ids = tuple(one.motion_ids[index] for index in chosen)
                filled[split].append(dataclasses.replace(one, motion_ids=motion_ids))
                left -= kept
        if left > 0:
            raise ValueError(
                f"{where} wants {wanted[split]} motions for {split}, but there are "
                f"only {wanted[split] - left}"
            )
    return {split: sorted(members, key=lambda one: one.key) for split, members in filled.items()}


def slot_seed(recipe_seed: int, slot: Slot) -> list[int]:
    """What seeds a slot's random numbers: the recipe's seed and the slot's name alone."""
    return [recipe_seed, zlib.crc32(slot.key.encode())]
