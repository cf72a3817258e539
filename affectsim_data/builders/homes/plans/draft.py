"""A plan in the making: rooms to which openings, open leaves and floor to leave free are added."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

from affectsim_data.builders.homes.plans.layout import Layout
from affectsim_data.builders.homes.plans.model import HomePlan, Opening, Rect, RoomPlan, overlaps
from affectsim_data.builders.homes.purposes import Purpose

__all__ = ["DOOR_FREE_M", "NoPlaceError", "PlanDraft"]

DOOR_FREE_M = 0.9
"""Depth of the floor before a doorway that stays free."""
_BESIDE_M = 0.1
"""Floor beside a doorway that stays free; its casing lies there."""


class NoPlaceError(Exception):
    """A layout has no place for something that every home has."""


class PlanDraft:
    """Rooms by number; everything added to one keeps clear of what it already has."""

    def __init__(
        self, purposes: Sequence[Purpose], layout: Layout, *, ceiling_y: float, door_top: float
    ) -> None:
        self.layout = layout
        self.door_top = door_top
        names = _room_ids(purposes)
        self.rooms = {
            number: RoomPlan(
                names[number], purposes[number], *_inner(layout, number), ceiling_y=ceiling_y
            )
            for number in sorted(layout.cells)
        }

    def add(
        self, number: int, opening: Opening, *, blocked: Sequence[Rect] = (),
        clear: Sequence[Rect] = (),
    ) -> None:  # fmt: skip
        """Adds an opening with the floor its leaf takes and the floor to leave free before it."""
        room = self.rooms[number]
        self.rooms[number] = dataclasses.replace(
            room,
            openings=(*room.openings, opening),
            blocked=(*room.blocked, *blocked),
            clear=(*room.clear, *clear),
        )

    def keep_clear(self, number: int, rect: Rect) -> None:
        """Lets nothing be put on some floor."""
        room = self.rooms[number]
        self.rooms[number] = dataclasses.replace(room, clear=(*room.clear, rect))

    def zones(self, number: int) -> list[Rect]:
        """Floor before the doorways and doors of a room."""
        room = self.rooms[number]
        return [self.zone(number, opening) for opening in room.openings if opening.kind != "window"]

    def zone(self, number: int, opening: Opening) -> Rect:
        """Floor before an opening of a room."""
        low, high = opening.span
        wall = self.rooms[number].wall(opening.side)
        return wall.rect((low - _BESIDE_M, high + _BESIDE_M), DOOR_FREE_M)

    def meets(self, number: int, rect: Rect, *, leaves: bool = True, zones: bool = False) -> bool:
        """Whether floor of a room holds an open leaf, or lies before a door."""
        found = [*self.rooms[number].blocked] if leaves else []
        found += self.zones(number) if zones else []
        return any(overlaps(rect, other) for other in found)

    def finished(self, living: int) -> HomePlan:
        """The plan, its living room first."""
        rest = [room for number, room in self.rooms.items() if number != living]
        return HomePlan((self.rooms[living], *rest))


def _inner(layout: Layout, number: int) -> Rect:
    x0, z0, x1, z1 = (round(value, 3) for value in layout.inner(number))
    return (x0, z0, x1, z1)


def _room_ids(purposes: Sequence[Purpose]) -> list[str]:
    """The purpose, with a number where several rooms share it."""
    names = []
    for number, purpose in enumerate(purposes):
        before = list(purposes[:number]).count(purpose)
        names.append(f"{purpose}_{before + 1}" if purposes.count(purpose) > 1 else purpose)
    return names
