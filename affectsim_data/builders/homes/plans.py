"""Floor plans: rectangular rooms, the openings in their walls, and the light that comes in.

The living area has its corner at the origin and reaches to +x and +z. Rooms beyond its far-x wall
and beyond its near-z wall open into it; its other two walls are outside walls with windows.
"""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np

from affectsim_data.builders.homes.recipes import HomeRecipe
from affectsim_data.poses import FloatArray

__all__ = [
    "CEILING_Y", "DOOR_HEIGHT", "WALL_THICKNESS", "HomePlan", "Leaf", "Opening", "RoomPlan", "Side",
    "Wall", "divider_x", "plan_home",
]  # fmt: skip

WALL_THICKNESS = 0.14
CEILING_Y = 2.6
DOOR_HEIGHT = 2.05
_DOORWAY_WIDTH = 0.95
_LEAF_WIDTH = 0.88

Side = Literal["left", "right", "back", "front"]
"""Walls of a room at its least x, greatest x, least z and greatest z."""


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

    @property
    def span(self) -> tuple[float, float]:
        """Both ends along the wall, world x or z, metres."""
        return (self.middle - self.width / 2.0, self.middle + self.width / 2.0)


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

    @property
    def yaw(self) -> float:
        """Of something that stands with its back to the wall, radians."""
        return float(np.arctan2(self.normal[0], self.normal[2]))


@dataclasses.dataclass(frozen=True)
class RoomPlan:
    """An empty rectangular room."""

    room_id: str
    purpose: str
    x0: float
    z0: float
    x1: float
    z1: float
    openings: tuple[Opening, ...] = ()
    blocked: tuple[tuple[float, float, float, float], ...] = ()
    """Floor that open door leaves take: least x and z, greatest x and z, metres."""
    clear: tuple[tuple[float, float, float, float], ...] = ()
    """Floor on which nothing may be put."""

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

    def openings_in(self, side: Side) -> tuple[Opening, ...]:
        """What is in one wall."""
        return tuple(opening for opening in self.openings if opening.side == side)


@dataclasses.dataclass(frozen=True)
class HomePlan:
    """All the rooms; the first is the living area."""

    rooms: tuple[RoomPlan, ...]

    @property
    def living(self) -> RoomPlan:
        """The large open room."""
        return self.rooms[0]


def plan_home(recipe: HomeRecipe, *, rng: np.random.Generator) -> HomePlan:
    """Rooms, doorways, windows and closed doors of a recipe; `rng` moves inner walls and doors."""
    width, depth = recipe.living
    openings = _living_windows(recipe)
    rooms: list[RoomPlan] = []
    if recipe.back is not None:
        z0 = -WALL_THICKNESS - recipe.back.depth
        for purpose, x0, x1 in _shares(recipe.back.rooms, width, rng):
            middle = _doorway_place(x0, x1, rng)
            openings.append(_doorway("back", middle))
            outside = _side_openings(purpose, "back", x0, x1)
            inner = (_doorway("front", middle), *outside)
            rooms.append(RoomPlan(purpose, purpose, x0, z0, x1, -WALL_THICKNESS, inner))
    if recipe.right is not None:
        x0, x1 = width + WALL_THICKNESS, width + WALL_THICKNESS + recipe.right.depth
        for purpose, z0, z1 in _shares(recipe.right.rooms, depth, rng):
            # Away from the far-z wall, where the living area has its dining table or kitchen.
            middle = z0 + float(rng.uniform(0.65, 0.75))
            openings.append(_doorway("right", middle))
            outside = _side_openings(purpose, "right", z0, z1)
            inner = (_doorway("left", middle), *outside)
            rooms.append(RoomPlan(purpose, purpose, x0, z0, x1, z1, inner))
    if not any(room.purpose == "hall" for room in rooms):
        openings.append(_door("left", 0.75))
    if recipe.back is None:
        openings.append(_door("back", width - 1.3))
    living = RoomPlan("living", "living", 0.0, 0.0, width, depth, tuple(openings))
    return HomePlan((living, *rooms))


def _shares(
    purposes: tuple[str, ...], length: float, rng: np.random.Generator
) -> list[tuple[str, float, float]]:
    """Purpose and both ends of every room of a strip; bedrooms get more, halls less."""
    weights = np.array([{"bedroom": 1.25, "hall": 0.75}.get(name, 1.0) for name in purposes])
    weights = weights * rng.uniform(0.95, 1.05, len(weights))
    free = length - WALL_THICKNESS * (len(purposes) - 1)
    sizes = np.round(free * weights / weights.sum(), 2)
    sizes[-1] = free - sizes[:-1].sum()
    ends = np.cumsum(sizes) + WALL_THICKNESS * np.arange(len(purposes))
    return [
        (name, float(end - size), float(end))
        for name, size, end in zip(purposes, sizes, ends, strict=True)
    ]


def _doorway_place(start: float, end: float, rng: np.random.Generator) -> float:
    """Near one end of the shared wall, so that the rest of it stays free for furniture."""
    near = 0.75 + float(rng.uniform(0.0, 0.2))
    return start + near if rng.random() < 0.5 else end - near


def _doorway(side: Side, middle: float) -> Opening:
    return Opening("doorway", side, middle, _DOORWAY_WIDTH, 0.0, DOOR_HEIGHT)


def _door(side: Side, middle: float) -> Opening:
    return Opening("door", side, middle, _LEAF_WIDTH, 0.0, DOOR_HEIGHT)


def divider_x(recipe: HomeRecipe) -> float:
    """Where the divider stands across the living area; it leaves room for a kitchen or a table."""
    width = recipe.living[0]
    return width - 2.5 if recipe.divider == "island" else 0.58 * width


def _living_windows(recipe: HomeRecipe) -> list[Opening]:
    """One window on either side of the divider, one beside the television."""
    width, depth = recipe.living
    across = divider_x(recipe)
    right = (across + width) / 2.0
    kitchen = recipe.divider == "island"
    return [
        _window("left", depth - 1.15, 1.2),
        _window("front", 0.52 * across, 2.0),
        _window("front", right, 1.1, bottom=1.1, curtains=False)
        if kitchen
        else _window("front", right, min(2.0, width - across - 1.5)),
    ]


def _window(
    side: Side, middle: float, width: float, *, bottom: float = 0.75, curtains: bool = True
) -> Opening:
    return Opening("window", side, middle, width, bottom, 2.2, curtains)


def _side_openings(purpose: str, side: Side, start: float, end: float) -> list[Opening]:
    """Outside wall of a side room: a window; the entrance in a hall, a closet in a bedroom."""
    length = end - start
    if purpose == "hall":
        return [_door(side, (start + end) / 2.0)]
    if purpose == "kitchen":
        return [_window(side, (start + end) / 2.0, 1.2, bottom=1.1, curtains=False)]
    if purpose == "bedroom" and length > 3.4:
        return [_window(side, start + 0.36 * length, 1.4, bottom=0.85), _door(side, end - 0.65)]
    return [_window(side, (start + end) / 2.0, 1.3, bottom=0.85)]
