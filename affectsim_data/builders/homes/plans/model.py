"""What a floor plan says: rectangular rooms and the openings in their walls."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np

from affectsim_data.builders.homes.purposes import Purpose
from affectsim_data.poses import FloatArray

__all__ = [
    "CEILING_Y", "SIDES", "WALL_THICKNESS", "HomePlan", "Leaf", "Opening", "Rect",
    "RoomPlan", "Side", "Wall", "overlaps",
]  # fmt: skip

WALL_THICKNESS = 0.14
CEILING_Y = 2.6
"""Usual height of ceilings; a plan has its own, `RoomPlan.ceiling_y`."""

Side = Literal["left", "right", "back", "front"]
"""Walls of a room at its least x, greatest x, least z and greatest z."""
SIDES: tuple[Side, ...] = ("left", "right", "back", "front")
Rect = tuple[float, float, float, float]
"""Least x and z, greatest x and z, metres."""


def overlaps(a: Rect, b: Rect, *, gap: float = 0.0) -> bool:
    """Whether two rectangles come closer than `gap`."""
    return (
        a[0] < b[2] + gap and b[0] < a[2] + gap and a[1] < b[3] + gap and b[1] < a[3] + gap
    )  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Leaf:
    """A door leaf, which turns into the room whose opening has it."""

    hinge: Literal["low", "high"]
    """End of the opening it turns about: at the lesser or the greater world x or z."""
    angle_deg: float = 0.0
    """How far it stands open."""


@dataclasses.dataclass(frozen=True)
class Opening:
    """A doorway, window or closed door in one wall of a room."""

    kind: Literal["doorway", "window", "door"]
    side: Side
    middle: float
    """Along the wall: world x or z, metres."""
    width: float
    bottom: float
    top: float
    curtains: bool = False
    leaf: Leaf | None = None
    """Of a doorway or door; of the two openings of a doorway only one has it."""
    to_room: str = ""
    """The room a doorway leads to."""

    @property
    def span(self) -> tuple[float, float]:
        """Both ends along the wall, world x or z, metres."""
        return (self.middle - self.width / 2.0, self.middle + self.width / 2.0)

    @property
    def is_wide(self) -> bool:
        """Whether it is an open passage between two parts of a large room, without a door."""
        return self.kind == "doorway" and self.width > 1.5


@dataclasses.dataclass(frozen=True)
class Wall:
    """The inner face of one wall; `along` runs to the right of somebody who looks at it."""

    side: Side
    origin: FloatArray
    """Its end where `along` starts, on the floor, `(3,)`."""
    along: FloatArray
    """Unit, `(3,)`."""
    normal: FloatArray
    """Unit, into the room, `(3,)`."""
    length: float

    def point(self, u: float, y: float = 0.0, out: float = 0.0) -> FloatArray:
        """World point `u` metres along, at height `y`, `out` metres into the room, `(3,)`."""
        return self.origin + u * self.along + out * self.normal + (0.0, y, 0.0)

    def u_of(self, place: float) -> float:
        """Metres along the wall of a world x or z."""
        axis = 0 if abs(self.along[0]) > 0.5 else 2
        return float((place - self.origin[axis]) * self.along[axis])

    def rect(self, span: tuple[float, float], depth: float) -> Rect:
        """Floor before a span of the wall, both ends as world x or z, `depth` metres deep."""
        a, b = self.point(self.u_of(span[0])), self.point(self.u_of(span[1]), 0.0, depth)
        return (
            float(min(a[0], b[0])), float(min(a[2], b[2])),
            float(max(a[0], b[0])), float(max(a[2], b[2])),
        )  # fmt: skip

    @property
    def yaw(self) -> float:
        """Of something that stands with its back to the wall, radians."""
        return float(np.arctan2(self.normal[0], self.normal[2]))


@dataclasses.dataclass(frozen=True)
class RoomPlan:
    """An empty rectangular room."""

    room_id: str
    purpose: Purpose
    x0: float
    z0: float
    x1: float
    z1: float
    openings: tuple[Opening, ...] = ()
    blocked: tuple[Rect, ...] = ()
    """Floor that open door leaves take: least x and z, greatest x and z, metres."""
    clear: tuple[Rect, ...] = ()
    """Floor on which nothing may be put."""
    ceiling_y: float = CEILING_Y
    """Height of its ceiling, metres."""

    @property
    def area_m2(self) -> float:
        """Of its floor."""
        return (self.x1 - self.x0) * (self.z1 - self.z0)

    def walls(self) -> tuple[Wall, ...]:
        """Left, right, back and front."""
        width, depth = self.x1 - self.x0, self.z1 - self.z0
        x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
        return (
            Wall("left", np.array([self.x0, 0.0, self.z1]), -z, x, depth),
            Wall("right", np.array([self.x1, 0.0, self.z0]), z, -x, depth),
            Wall("back", np.array([self.x0, 0.0, self.z0]), x, z, width),
            Wall("front", np.array([self.x1, 0.0, self.z1]), -x, -z, width),
        )

    def wall(self, side: Side) -> Wall:
        """One of them."""
        return next(wall for wall in self.walls() if wall.side == side)

    def span(self, side: Side) -> tuple[float, float]:
        """Both ends of a wall, world x or z, metres."""
        return (self.z0, self.z1) if side in ("left", "right") else (self.x0, self.x1)

    def openings_in(self, side: Side) -> tuple[Opening, ...]:
        """What is in one wall."""
        return tuple(opening for opening in self.openings if opening.side == side)


@dataclasses.dataclass(frozen=True)
class HomePlan:
    """All the rooms; the first is the living room."""

    rooms: tuple[RoomPlan, ...]

    @property
    def living(self) -> RoomPlan:
        """The largest room."""
        return self.rooms[0]

    @property
    def ceiling_y(self) -> float:
        """Height of its ceilings, metres."""
        return self.rooms[0].ceiling_y

    @property
    def area_m2(self) -> float:
        """Floor of all rooms."""
        return sum(room.area_m2 for room in self.rooms)

    def room(self, room_id: str) -> RoomPlan:
        """One of them."""
        return next(room for room in self.rooms if room.room_id == room_id)
