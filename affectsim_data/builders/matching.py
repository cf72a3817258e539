"""Matched sets: motions of one performer that differ in emotion and may share a placement."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence

from affectsim_data.builders.measuring import Performance
from affectsim_data.motions import EMOTIONS, Motion

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
    group_ids: frozenset[str]
    """Source performances they come from."""


def matched_sets(
    performances: Sequence[Performance], actions: Collection[str], *, where: str
) -> list[MatchedSet]:
    """The matched sets of some actions, in the order of their keys.

    Motions match by performer, action, take and, where several emotions show the same, what was
    performed; what is left over is matched by its order.

    Raises:
        ValueError: There is no motion of an action.
    """
    motions = [one.motion for one in performances]
    have = sorted({motion.action for motion in motions})
    for action in actions:
        if action not in have:
            raise ValueError(
                f"{where} wants action {action!r}, but there is no motion of it; "
                f"there is: {', '.join(have)}"
            )
    members: dict[tuple[str, str, str, str], dict[str, list[Motion]]] = {}
    shared = _shared_performances(motions)
    for motion in sorted(motions, key=lambda one: one.motion_id):
        if motion.action in actions:
            what = motion.performance if motion.performance in shared else ""
            key = (motion.action, motion.performer_id, what, f"take{motion.take}")
            members.setdefault(key, {}).setdefault(motion.emotion, []).append(motion)
    sets = []
    for key, by_emotion in sorted(members.items()):
        for rank in range(max(map(len, by_emotion.values()))):
            matched = [by_emotion[e][rank] for e in EMOTIONS if len(by_emotion.get(e, ())) > rank]
            sets.append(
                MatchedSet(
                    key="/".join((*filter(None, key), *([str(rank)] if rank else []))),
                    action=key[0],
                    performer_id=key[1],
                    motion_ids=tuple(motion.motion_id for motion in matched),
                    group_ids=frozenset(motion.group_id for motion in matched),
                )
            )
    return sets


def _shared_performances(motions: Sequence[Motion]) -> set[str]:
    """Names of what was performed in more than one emotion."""
    shown: dict[str, set[str]] = {}
    for motion in motions:
        shown.setdefault(motion.performance, set()).add(motion.emotion)
    return {name for name, emotions in shown.items() if len(emotions) > 1}


def connected_sets(sets: Sequence[MatchedSet]) -> list[list[MatchedSet]]:
    """Sets parted into those that share source performances, directly or through others."""
    parent = list(range(len(sets)))

    def root(place: int) -> int:
        while parent[place] != place:
            parent[place] = parent[parent[place]]
            place = parent[place]
        return place

    owner: dict[str, int] = {}
    for place, one in enumerate(sets):
        for group_id in sorted(one.group_ids):
            parent[root(place)] = root(owner.setdefault(group_id, place))
    parts: dict[int, list[MatchedSet]] = {}
    for place, one in enumerate(sets):
        parts.setdefault(root(place), []).append(one)
    return list(parts.values())
