"""A piece at its place, and the places along a wall."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Literal

import numpy as np

from affectsim_data.builders.homes.parts import Part
from affectsim_data.builders.homes.pieces import Furniture, LocalSeat
from affectsim_data.builders.homes.plans import Rect, Wall
from affectsim_data.poses import FloatArray

__all__ = [
    "BEFORE_WALL_M", "KNEE_ROOM_M", "Placed", "Support", "placed_before", "wall_middles",
    "wall_places", "wall_rects",
]  # fmt: skip

Support = Literal["floor", "wall", "ceiling", "piece"]
"""What bears a piece."""
KNEE_ROOM_M = 0.55
_KNEE_WIDTH_M = 0.44
BEFORE_WALL_M = 0.02
"""Between a wall and the back of what stands against it: the baseboard."""


@dataclasses.dataclass(frozen=True)
class Placed:
    """Furniture at its place."""

    piece: Furniture
    x: float
    z: float
    yaw: float
    """Radians, 0 faces +Z."""
    y: float = 0.0
    """Height of its underside."""
    support: Support = "floor"
    room_id: str = ""

    def rect(self) -> Rect:
        """Its bounds on the floor."""
        c, s = abs(np.cos(self.yaw)), abs(np.sin(self.yaw))
        half_x = float(c * self.piece.width + s * self.piece.depth) / 2.0
        half_z = float(s * self.piece.width + c * self.piece.depth) / 2.0
        return (self.x - half_x, self.z - half_z, self.x + half_x, self.z + half_z)

    def footprint(self) -> list[Rect]:
        """Bounds of what it takes of the floor, one or more rectangles."""
        rects = []
        for x0, z0, x1, z1 in self.piece.footprint:
            corners = [self.world(x, z) for x in (x0, x1) for z in (z0, z1)]
            xs, zs = zip(*corners, strict=True)
            rects.append((min(xs), min(zs), max(xs), max(zs)))
        return rects or [self.rect()]

    def world(self, x: float, z: float) -> tuple[float, float]:
        """World `(x, z)` of a point of the piece."""
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        return (self.x + c * x + s * z, self.z - s * x + c * z)

    def beside(self, piece: Furniture, x: float, z: float, *, turn: float = 0.0) -> Placed:
        """Another piece with its middle at a point of this one, turned against it."""
        at = self.world(x, z)
        return Placed(piece, at[0], at[1], self.yaw + turn)

    def before(self, start: float, end: float, *, width: float, x: float = 0.0) -> Rect:
        """Bounds of a strip in front of the piece, from `start` to `end` along its +Z."""
        corners = [self.world(x + dx, z) for dx in (-width / 2, width / 2) for z in (start, end)]
        xs, zs = zip(*corners, strict=True)
        return (min(xs), min(zs), max(xs), max(zs))

    def knees(self, seat: LocalSeat) -> Rect:
        """Floor that the knees and feet of a sitter need."""
        sitter = self.beside(self.piece, seat.position[0], seat.position[2], turn=seat.yaw)
        return sitter.before(seat.edge, seat.edge + KNEE_ROOM_M, width=_KNEE_WIDTH_M)

    def parts(self) -> list[Part]:
        """Its parts in the world."""
        return [part.moved(self.x, self.y, self.z, yaw=self.yaw) for part in self.piece.parts]

    @functools.cached_property
    def top_y(self) -> float:
        """Of the highest thing of it, metres."""
        return self.y + max(float(part.positions[:, 1].max()) for part in self.piece.parts)


def placed_before(wall: Wall, piece: Furniture, u: float, *, out: float = BEFORE_WALL_M) -> Placed:
    """A piece with its back to a wall, `u` metres along and `out` metres before it."""
    x, _, z = wall.point(u, 0.0, piece.depth / 2.0 + out)
    return Placed(piece, float(x), float(z), wall.yaw)


def wall_places(wall: Wall, piece: Furniture, *, step: float) -> tuple[FloatArray, FloatArray]:
    """Places for a piece's middle: metres from the middle of a wall, and along it, `(n,)` each."""
    reach = (wall.length - piece.width) / 2.0 - BEFORE_WALL_M
    if reach < 0.0:
        return np.zeros(0), np.zeros(0)
    shifts = np.linspace(-reach, reach, int(2.0 * reach / step) + 2)
    return shifts, wall.length / 2.0 + shifts


def wall_rects(wall: Wall, piece: Furniture, middles: FloatArray) -> FloatArray:
    """Bounds on the floor of a piece with its back to a wall at places, `(n, 4)`."""
    half = (np.abs(wall.along) * piece.width + np.abs(wall.normal) * piece.depth)[[0, 2]] / 2.0
    plane = middles[:, [0, 2]]
    return np.concatenate([plane - half, plane + half], axis=1)


def wall_middles(wall: Wall, piece: Furniture, us: FloatArray) -> FloatArray:
    """Middles of a piece with its back to a wall at places along it, `(n, 3)`."""
    out = piece.depth / 2.0 + BEFORE_WALL_M
    middles: FloatArray = wall.point(0.0, 0.0, out) + us[:, None] * wall.along
    return middles
