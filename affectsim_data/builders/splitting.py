"""Which motions go to which split: by performer, by performance or by action."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.builders.compositions import Composition, SplitRule
from affectsim_data.builders.matching import MatchedSet, connected_sets
from affectsim_data.schemas import SPLITS, Split

__all__ = ["some_of", "split_sets"]


def split_sets(
    sets: Sequence[MatchedSet], composition: Composition, rng: np.random.Generator, *, where: str
) -> dict[Split, list[MatchedSet]]:
    """The matched sets of each split; no two splits get the same performer or performance.

    Args:
        sets: All there are.
        composition: Says by what they are split, and how many motions a split gets.
        rng: Draws performers and motions where the recipe gives numbers and not names.
        where: Start of error messages: recipe and entry.

    Raises:
        ValueError: There are too few performers or motions, or one belongs to no split.
    """
    rule = composition.split_rule
    parted: dict[Split, list[MatchedSet]] = {split: [] for split in SPLITS}
    if rule.by == "performance":
        parted = {split: list(sets) for split in SPLITS}
    else:
        split_of = _split_of_names(sorted({_owner(one, rule) for one in sets}), rule, rng, where)
        for one in sets:
            parted[split_of[_owner(one, rule)]].append(one)
    if composition.motions is None:
        return parted
    return _fill_motions(parted, composition.motions, rng, where=where)


def _owner(one: MatchedSet, rule: SplitRule) -> str:
    return one.action if rule.by == "action" else one.performer_id


def _split_of_names(
    names: Sequence[str], rule: SplitRule, rng: np.random.Generator, where: str
) -> dict[str, Split]:
    """Who belongs to which split: those who are named there, others as many as asked for."""
    named = {
        name: split
        for split, members in rule.members.items()
        if not isinstance(members, int)
        for name in members
    }
    free = [name for name in names if name not in named]
    left = [free[place] for place in rng.permutation(len(free))]
    for split, members in rule.members.items():
        if isinstance(members, int):
            if members > len(left):
                raise ValueError(
                    f"{where} wants {members} {rule.by}s for {split}, but of "
                    f"{len(names)} only {len(left)} are left"
                )
            named |= dict.fromkeys(left[:members], split)
            left = left[members:]
    if left:
        raise ValueError(
            f"{where} names no split for {rule.by} {min(left)!r}; "
            "add it to train, validation or test"
        )
    return named


def _fill_motions(
    parted: Mapping[Split, Sequence[MatchedSet]],
    wanted: Mapping[Split, int],
    rng: np.random.Generator,
    *,
    where: str,
) -> dict[Split, list[MatchedSet]]:
    """As many motions for each split as asked for; no performance is in two splits.

    Sources that fit are taken whole, then one in part. What is left of that is used only where
    there are no motions to spare. The smallest split chooses first, so that what is lost is lost
    where it matters least.
    """
    filled = _filled(parted, wanted, rng, spare=True)
    if any(_count(filled[split]) < wanted[split] for split in SPLITS):
        filled = _filled(parted, wanted, rng, spare=False)
    for split in SPLITS:
        if (count := _count(filled[split])) < wanted[split]:
            raise ValueError(
                f"{where} wants {wanted[split]} motions for {split}, but there are only {count}"
            )
    return {split: sorted(members, key=lambda one: one.key) for split, members in filled.items()}


def _filled(
    parted: Mapping[Split, Sequence[MatchedSet]],
    wanted: Mapping[Split, int],
    rng: np.random.Generator,
    *,
    spare: bool,
) -> dict[Split, list[MatchedSet]]:
    """The same, as far as it goes; `spare` leaves what a source used in part has left."""
    used: set[str] = set()
    filled: dict[Split, list[MatchedSet]] = {split: [] for split in SPLITS}
    for split in sorted(SPLITS, key=lambda one: wanted[one]):
        free = [_without(one, used) for one in parted[split]]
        taken, left, too_large = filled[split], wanted[split], []
        for source in _in_turn(connected_sets([one for one in free if len(one)]), rng):
            if _count(source) <= left:
                taken += source
                left -= _count(source)
            else:
                too_large.append(source)
        touched = [*taken]
        for source in too_large if left else ():
            part = _part_of(source, left, rng)
            taken += part
            touched += source if spare else part
            left -= _count(part)
            if not left:
                break
        used |= {group for one in touched for group in one.group_ids}
    return filled


def _count(sets: Sequence[MatchedSet]) -> int:
    return sum(map(len, sets))


def _without(one: MatchedSet, used: set[str]) -> MatchedSet:
    """The set without motions of some performances."""
    return one.only([place for place, group in enumerate(one.group_ids) if group not in used])


def _part_of(source: Sequence[MatchedSet], most: int, rng: np.random.Generator) -> list[MatchedSet]:
    """Whole performances of a source, by chance, as many motions as wanted; if none fits, some
    motions of one."""
    motions = [(group, index) for index, one in enumerate(source) for group in one.group_ids]
    sizes = Counter(group for group, _ in motions)
    groups = sorted(sizes)
    kept: set[str] = set()
    for place in rng.permutation(len(groups)):
        if sizes[groups[place]] <= most - sum(sizes[group] for group in kept):
            kept.add(groups[place])
    if not kept:
        members = _only_groups(source, {groups[int(rng.integers(len(groups)))]})
        return [members[0].only(range(most))] if len(members[0]) >= most else members[:1]
    return _only_groups(source, kept)


def _only_groups(source: Sequence[MatchedSet], kept: set[str]) -> list[MatchedSet]:
    parts = [
        one.only([place for place, group in enumerate(one.group_ids) if group in kept])
        for one in source
    ]
    return [one for one in parts if len(one)]


def _in_turn(
    sources: Sequence[list[MatchedSet]], rng: np.random.Generator
) -> list[list[MatchedSet]]:
    """Sources in random order: first those with every emotion, and of every action in turn."""
    most = max((len(one.motion_ids) for source in sources for one in source), default=0)
    ranks: Counter[str] = Counter()
    ranked = []
    for place in rng.permutation(len(sources)):
        source = sources[place]
        lacks = any(len(one.motion_ids) < most for one in source)
        ranked.append((lacks, ranks[source[0].action], source))
        ranks[source[0].action] += 1
    return [source for *_, source in sorted(ranked, key=lambda one: one[:2])]


def some_of(motion_ids: tuple[str, ...], most: int, rng: np.random.Generator) -> tuple[str, ...]:
    """All of them or, where they are more, as many as wanted by chance, in their order."""
    if len(motion_ids) <= most:
        return motion_ids
    return tuple(motion_ids[place] for place in sorted(rng.permutation(len(motion_ids))[:most]))
