"""Matched sets: motions of one performer that differ in emotion and may share a placement."""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Collection, Sequence

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

from affectsim_data.builders.measuring import Performance
from affectsim_data.motions import EMOTIONS, Emotion, Motion

__all__ = ["MatchedSet", "connected_sets", "matched_sets"]


@dataclasses.dataclass(frozen=True)
class MatchedSet:
    """The same performer, action and take under several emotions."""

    key: str
    """Stable name, emotion-free."""
    action: str
    performer_id: str
    motion_ids: tuple[str, ...]
    """At most one of each emotion, in label order."""
    group_ids: tuple[str, ...]
    """Source performances they come from, one each."""

    def __len__(self) -> int:
        """Motions."""
        return len(self.motion_ids)

    def only(self, places: Sequence[int]) -> MatchedSet:
        """The same with some of its motions, in their order."""
        kept = sorted(places)
        return dataclasses.replace(
            self,
            motion_ids=tuple(self.motion_ids[place] for place in kept),
            group_ids=tuple(self.group_ids[place] for place in kept),
        )


def matched_sets(
    performances: Sequence[Performance],
    actions: Collection[str],
    *,
    emotions: Collection[Emotion] = EMOTIONS,
    where: str,
) -> list[MatchedSet]:
    """The matched sets of some actions, in the order of their keys.

    Motions match by performer, partner, action and take. Where an emotion has several of these,
    they match by what was performed, as far as several emotions show it, and else by their order.

    Args:
        performances: All there are, in any order.
        actions: Which of them to match.
        emotions: Others are left out.
        where: Start of error messages: recipe and entry.

    Raises:
        ValueError: There is no motion of an action in any of the emotions.
    """
    able = [one for one in performances if one.motion.emotion in emotions]
    have = sorted({one.motion.action for one in able})
    for action in actions:
        if action not in have:
            raise ValueError(
                f"{where} wants action {action!r}, but there is no motion of it; "
                f"there is: {', '.join(have) or 'none'}"
            )
    takes: dict[tuple[str, str, str, str], list[Motion]] = defaultdict(list)
    for one in sorted(able, key=lambda one: one.motion.motion_id):
        motion, partner = one.motion, f"with {one.partner[0].performer_id}" if one.partner else ""
        if motion.action in actions:
            takes[motion.action, motion.performer_id, partner, f"take{motion.take}"].append(motion)
    sets = [
        MatchedSet(
            key="/".join(filter(None, (action, performer_id, partner, what, take))),
            action=action,
            performer_id=performer_id,
            motion_ids=tuple(motion.motion_id for motion in matched),
            group_ids=tuple(motion.group_id for motion in matched),
        )
        for (action, performer_id, partner, take), members in takes.items()
        for what, matched in _matched(members)
    ]
    return sorted(sets, key=lambda one: one.key)


def _matched(motions: Sequence[Motion]) -> list[tuple[str, list[Motion]]]:
    """Motions of one performer, action and take, matched; each match with a name of its own."""
    emotions = [motion.emotion for motion in motions]
    if len(set(emotions)) == len(emotions):
        return [("", _in_label_order(motions))]
    shown = defaultdict(set)
    for motion in motions:
        shown[motion.performance].add(motion.emotion)
    rows: dict[str, dict[str, list[Motion]]] = defaultdict(lambda: defaultdict(list))
    for motion in motions:
        shared = len(shown[motion.performance]) > 1
        rows[motion.performance if shared else ""][motion.emotion].append(motion)
    return [
        (
            "/".join(filter(None, (what, f"match{rank}" if rank else ""))),
            _in_label_order([same[rank] for same in by_emotion.values() if rank < len(same)]),
        )
        for what, by_emotion in rows.items()
        for rank in range(max(map(len, by_emotion.values())))
    ]


def _in_label_order(motions: Sequence[Motion]) -> list[Motion]:
    return sorted(motions, key=lambda one: EMOTIONS.index(one.emotion))


def connected_sets(sets: Sequence[MatchedSet]) -> list[list[MatchedSet]]:
    """Sets parted into those that share source performances, directly or through others."""
    pairs = [(place, group) for place, one in enumerate(sets) for group in one.group_ids]
    groups = {group: len(sets) + n for n, group in enumerate(sorted({g for _, g in pairs}))}
    rows = np.array([place for place, _ in pairs], np.intp)
    columns = np.array([groups[group] for _, group in pairs], np.intp)
    size = len(sets) + len(groups)
    graph = coo_matrix((np.ones(len(pairs)), (rows, columns)), shape=(size, size))
    parts: dict[int, list[MatchedSet]] = defaultdict(list)
    for one, part in zip(sets, connected_components(graph, directed=False)[1], strict=False):
        parts[int(part)].append(one)
    return list(parts.values())
