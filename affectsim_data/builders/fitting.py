"""Counts of a recipe cut down to the motions there are, for builds that may leave things out.

Nothing is filled up from elsewhere: whoever lacks a tenth of the motions gets a tenth of the
episodes less, the largest split gives most, and the cells say how many are missing.
"""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from affectsim_data.builders.compositions import Composition, SplitRule
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.slots import CellKey, make_slots
from affectsim_data.motions import Motion
from affectsim_data.schemas import SPLITS, Split

__all__ = ["fitted", "with_unmet"]

_MOST_LOST = 64
"""Motions given up because sources of several may not be parted between splits."""


def fitted(recipe: Recipe, performances: Sequence[Performance]) -> tuple[Recipe, tuple[str, ...]]:
    """The recipe with counts that the performances can serve, and a line for each that shrank.

    Raises:
        ValueError: No `[[compose]]` has a motion; or one fails for another reason than a count.
    """
    kept: list[Composition] = []
    lines = []
    for number, asked in enumerate(recipe.compositions, 1):
        motions = [one.motion for one in performances]
        motions = [m for m in motions if m.action in asked.actions and m.emotion in asked.emotions]
        where = f"[[compose]] {number}, {asked.family}"
        if not motions:
            lines.append(f"{where}: left out, there is no motion for it")
            continue
        less = _fitted(recipe, asked, motions, performances)
        kept.append(less)
        if less != asked:
            lines.append(f"{where}: {_told(asked, less)}")
    if not kept:
        raise ValueError(f"{recipe.path}: there is no motion for any [[compose]]")
    return dataclasses.replace(recipe, compositions=tuple(kept)), tuple(lines)


def with_unmet(
    rows: Sequence[Mapping[str, Any]], asked: Recipe, built: Recipe
) -> list[dict[str, Any]]:
    """Rows of the cells table, with what the recipe asks for and a fitted one no longer plans.

    Args:
        rows: Of the fitted recipe.
        asked: The recipe as it was.
        built: The same, fitted.
    """
    unmet = _planned(asked) - _planned(built)
    names = ("split", "family", "challenge", "action", "emotion")
    cells = {tuple(row[name] for name in names): dict(row) for row in rows}
    for cell, count in unmet.items():
        empty = dict(zip(names, cell, strict=True)) | {"planned": 0, "composed": 0}
        row = cells.setdefault(cell, empty)
        row["planned"] += count
        row["binding_constraint"] = row.get("binding_constraint") or "motions"
    return [cells[cell] for cell in sorted(cells, key=lambda one: tuple(map(str, one)))]


def _fitted(
    recipe: Recipe,
    asked: Composition,
    motions: Sequence[Motion],
    performances: Sequence[Performance],
) -> Composition:
    """One entry, cut down: actions, performers and motions that are there, episodes in their ratio.

    Sources of several motions may not be parted, so that fewer can be had than there are.
    """
    there = {motion.action for motion in motions}
    actions = {action: share for action, share in asked.actions.items() if action in there}
    total = sum(actions.values())
    rule = _fitted_rule(asked.split_rule, {motion.performer_id for motion in motions})
    less = dataclasses.replace(
        asked,
        actions={action: share / total for action, share in actions.items()} if total else {},
        split_rule=rule,
    )
    error = ValueError("")
    for lost in range(_MOST_LOST):
        if asked.motions is not None:
            counts = _reduced(asked.motions, len(motions) - lost)
            less = dataclasses.replace(less, motions=counts)
        less = dataclasses.replace(less, episodes=_fitted_episodes(asked, less, total))
        try:
            make_slots(dataclasses.replace(recipe, compositions=(less,)), performances)
        except ValueError as problem:
            error = problem
            if asked.motions is None:
                break
        else:
            return less
    raise error


def _fitted_rule(rule: SplitRule, names: set[str]) -> SplitRule:
    """The rule with as many performers as there are."""
    wanted = {split: count for split, count in rule.members.items() if isinstance(count, int)}
    if rule.by != "performer" or not wanted:
        return rule
    named = {name for one in rule.members.values() if not isinstance(one, int) for name in one}
    counts = _reduced(wanted, len(names - named))
    return dataclasses.replace(rule, members={**rule.members, **counts})


def _reduced(wanted: Mapping[Split, int], there: int) -> dict[Split, int]:
    """Counts that sum to at most what is there: the largest gives, one after the other."""
    counts = dict(wanted)
    for _ in range(sum(counts.values()) - max(there, 0)):
        counts[max(counts, key=lambda split: counts[split])] -= 1
    return counts


def _fitted_episodes(
    asked: Composition, less: Composition, share: float
) -> Mapping[Split, int] | None:
    """Episodes in the least ratio of what is left: actions, performers, motions."""
    if asked.episodes is None:
        return None
    members = asked.split_rule.members, less.split_rule.members
    numbers = [(asked.motions or {}, less.motions or {}), members]
    episodes = {}
    for split, count in asked.episodes.items():
        ratios = [share]
        for before, after in numbers:
            was, is_now = before.get(split), after.get(split)
            if isinstance(was, int) and isinstance(is_now, int) and was:
                ratios.append(is_now / was)
        episodes[split] = math.floor(count * min(*ratios, 1.0) + 1e-9)
    return episodes


def _planned(recipe: Recipe) -> Counter[CellKey]:
    """Episodes by cell as the counts of a recipe have them, emotions in equal parts."""
    cells: Counter[CellKey] = Counter()
    for one in recipe.compositions:
        parts = list(itertools.product(one.actions, one.challenges, one.emotions))
        shares = [
            one.actions[action] * one.challenges[c] / len(one.emotions) for action, c, _ in parts
        ]
        for split in SPLITS:
            total = _episodes(one, split)
            ends = [round(total * share) for share in itertools.accumulate(shares, initial=0.0)]
            for (action, challenge, emotion), (start, end) in zip(
                parts, itertools.pairwise(ends), strict=True
            ):
                cells[split, one.family, challenge, action, emotion] += end - start
    return cells


def _episodes(one: Composition, split: Split) -> int:
    """Of a split; none where only the motions that there are say how many."""
    if one.episodes is not None:
        return one.episodes[split]
    if one.motions is None:
        return 0
    return one.motions[split] * one.repeats * len(one.challenges)


def _told(asked: Composition, less: Composition) -> str:
    """What became of the counts, in a line."""
    told = []
    if gone := sorted(set(asked.actions) - set(less.actions)):
        told.append(f"no motion of {', '.join(gone)}")
    pairs = [
        (asked.split_rule.members, less.split_rule.members, "performers"),
        (asked.motions or {}, less.motions or {}, "motions"),
        (asked.episodes or {}, less.episodes or {}, "episodes"),
    ]
    for before, after, what in pairs:
        told += [
            f"{after[split]} of {before[split]} {what} for {split}"
            for split in SPLITS
            if before.get(split) != after.get(split)
        ]
    return ", ".join(told)
