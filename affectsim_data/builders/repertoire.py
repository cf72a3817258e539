"""The performances of a release, small enough to be sent to every worker."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.builders.measuring import Performance
from affectsim_data.motions import Motion

__all__ = ["Repertoire"]

_FIELDS = (
    *("motion_id", "performer_id", "group_id", "emotion", "action", "fps"),
    *("performance", "take", "source", "licence"),
)


class Repertoire(Mapping[str, Performance]):
    """Performances by the target's motion id, made when they are asked for, then kept.

    Held as float32, of which motions as releases store them lose nothing; without what only undoes
    a motion's loop.
    """

    def __init__(self, performances: Sequence[Performance]) -> None:
        self._avatars: list[Avatar] = []
        self._parts = {
            one.motion.motion_id: [
                self._packed(*person)
                for person in ((one.motion, one.avatar), one.partner)
                if person is not None
            ]
            for one in performances
        }
        self._made: dict[str, Performance] = {}

    def _packed(self, motion: Motion, avatar: Avatar) -> tuple[dict[str, Any], int]:
        if not any(known is avatar for known in self._avatars):
            self._avatars.append(avatar)
        place = next(i for i, known in enumerate(self._avatars) if known is avatar)
        fields = {name: getattr(motion, name) for name in _FIELDS}
        for name in ("root_translation", "joint_rotations"):
            fields[name] = getattr(motion, name).astype(np.float32)
        return fields, place

    def _person(self, fields: Mapping[str, Any], place: int) -> tuple[Motion, Avatar]:
        arrays = {
            name: fields[name].astype(np.float64)
            for name in ("root_translation", "joint_rotations")
        }
        return Motion(**{**fields, **arrays}), self._avatars[place]

    def __getitem__(self, motion_id: str) -> Performance:
        if motion_id not in self._made:
            target, *partner = (self._person(*part) for part in self._parts[motion_id])
            self._made[motion_id] = Performance(*target, partner[0] if partner else None)
        return self._made[motion_id]

    def __iter__(self) -> Iterator[str]:
        return iter(self._parts)

    def __len__(self) -> int:
        return len(self._parts)

    def __getstate__(self) -> dict[str, Any]:
        """What another process needs; it makes performances of its own."""
        return {**self.__dict__, "_made": {}}
