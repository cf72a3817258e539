"""Where furniture may stand: nothing overlaps, doors and seats are free, a robot gets through."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np
from scipy import ndimage

from affectsim_data.builders.homes.decor import CURTAIN_WIDTH
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.plans import Opening, RoomPlan, Wall

__all__ = ["Placed", "Rect", "RoomFloor"]

Rect = tuple[float, float, float, float]
"""Least x and z, greatest x and z, metres."""

_GRID_M = 0.08
_HALF_WAY_M = 0.41
"""Free ways are at least twice as wide: a robot of radius 0.30 m passes with a margin."""
_DOOR_FREE_M = 0.9
_KNEE_ROOM_M = 0.55
_BEFORE_WALL_M = 0.02
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

    def rect(self) -> Rect:
        """Its bounds on the floor."""
        c, s = abs(np.cos(self.yaw)), abs(np.sin(self.yaw))
        half_x = float(c * self.piece.width + s * self.piece.depth) / 2.0
        half_z = float(s * self.piece.width + c * self.piece.depth) / 2.0
        return (self.x - half_x, self.z - half_z, self.x + half_x, self.z + half_z)

    def world(self, x: float, z: float) -> tuple[float, float]:
        """World `(x, z)` of a point of the piece."""
        c, s = float(np.cos(self.yaw)), float(np.sin(self.yaw))
        return (self.x + c * x + s * z, self.z - s * x + c * z)

    def before(self, start: float, end: float, *, x: float = 0.0, width: float) -> Rect:
        """Bounds of a strip in front of the piece, from `start` to `end` along its +Z."""
        corners = [self.world(x + dx, z) for dx in (-width / 2, width / 2) for z in (start, end)]
        xs, zs = zip(*corners, strict=True)
        return (min(xs), min(zs), max(xs), max(zs))


def overlaps(a: Rect, b: Rect, *, gap: float = 0.0) -> bool:
    """Whether two rectangles come closer than `gap`."""
    return (
        a[0] < b[2] + gap and b[0] < a[2] + gap and a[1] < b[3] + gap and b[1] < a[3] + gap
    )  # fmt: skip


class RoomFloor:
    """The floor of one room while it is being furnished."""

    def __init__(self, room: RoomPlan) -> None:
        self.room = room
        self.placed: list[Placed] = []
        self._obstacles: list[Rect] = list(room.blocked)
        self._kept_free: list[Rect] = list(room.clear)
        self._doors: list[tuple[float, float]] = []
        for opening in room.openings:
            if opening.curtains:
                self._obstacles += _curtain_rects(room.wall(opening.side), opening)
            if opening.kind != "window":
                wall = room.wall(opening.side)
                self._kept_free.append(_door_rect(wall, opening))
                x, _, z = wall.point(wall.u_of(opening.middle), 0.0, 0.5)
                self._doors.append((float(x), float(z)))

    def keep_free(self, rect: Rect) -> None:
        """Lets nothing be placed there."""
        self._kept_free.append(rect)

    def fits(self, placed: Placed, *, gap: float = 0.0) -> bool:
        """Whether a piece overlaps nothing, keeps doors and seats free and leaves ways open."""
        rect, room = placed.rect(), self.room
        inside = (
            rect[0] >= room.x0 and rect[1] >= room.z0 and rect[2] <= room.x1 and rect[3] <= room.z1
        )
        if not inside or any(overlaps(rect, other, gap=gap) for other in self._obstacles):
            return False
        if any(overlaps(rect, other) for other in self._kept_free):
            return False
        knees = _knee_rects(placed)
        if any(overlaps(knee, other) for knee in knees for other in self._obstacles):
            return False
        return self._passable(rect)

    def put(self, placed: Placed, *, gap: float = 0.0) -> Placed:
        """Places a piece.

        Raises:
            ValueError: It does not fit there.
        """
        if not self.fits(placed, gap=gap):
            rect = tuple(round(value, 2) for value in placed.rect())
            raise ValueError(f"room {self.room.room_id!r}: no free place at {rect}")
        self._take(placed)
        return placed

    def lay(self, piece: Furniture, x: float, z: float, yaw: float = 0.0) -> None:
        """Places what does not block: a rug."""
        self.placed.append(Placed(piece, x, z, yaw))

    def put_under(self, placed: Placed) -> None:
        """Places what may overlap its neighbour, such as a chair tucked under a table."""
        self._take(placed)

    def _take(self, placed: Placed) -> None:
        self.placed.append(placed)
        self._obstacles.append(placed.rect())
        self._kept_free += _knee_rects(placed)

    def put_at_wall(
        self, piece: Furniture, *, rng: np.random.Generator, front: float = 0.0,
        prefer: Literal["corner", "center", "any"] = "any", sides: tuple[str, ...] | None = None,
    ) -> Placed | None:  # fmt: skip
        """Places a piece with its back to a wall, or returns none if there is no place.

        Args:
            piece: Furniture.
            rng: Orders places that are equally good.
            front: Metres before it to keep free.
            prefer: Which part of a wall to try first.
            sides: Walls to try; all by default.
        """
        options = []
        for wall in self.room.walls():
            if sides is not None and wall.side not in sides:
                continue
            reach = (wall.length - piece.width) / 2.0 - 0.02
            for shift in np.arange(-reach, reach + 1e-9, 0.12):
                u = wall.length / 2.0 + float(shift)
                cost = {"corner": reach - abs(shift), "center": abs(shift), "any": 0.0}[prefer]
                options.append((cost + float(rng.uniform(0.0, 0.3)), wall, u))
        for _, wall, u in sorted(options, key=lambda option: option[0]):
            x, _, z = wall.point(u, 0.0, piece.depth / 2.0 + _BEFORE_WALL_M)
            placed = Placed(piece, float(x), float(z), wall.yaw)
            if self._hides_window(placed, wall, u) or not self.fits(placed):
                continue
            strip = placed.before(piece.depth / 2, piece.depth / 2 + front, width=piece.width)
            if front and any(overlaps(strip, other) for other in self._obstacles):
                continue
            self._take(placed)
            if front:
                self._kept_free.append(strip)
            return placed
        return None

    def _hides_window(self, placed: Placed, wall: Wall, u: float) -> bool:
        return any(
            opening.kind == "window"
            and placed.piece.height > opening.bottom - 0.03
            and abs(wall.u_of(opening.middle) - u) < (opening.width + placed.piece.width) / 2.0
            for opening in self.room.openings_in(wall.side)
        )

    def _passable(self, extra: Rect) -> bool:
        """Whether all doors and kept places stay connected by wide ways once `extra` is taken."""
        room = self.room
        columns = int(np.ceil((room.x1 - room.x0) / _GRID_M))
        rows = int(np.ceil((room.z1 - room.z0) / _GRID_M))
        # One blocked cell all around stands for the walls.
        free = np.zeros((rows + 2, columns + 2), bool)
        free[1:-1, 1:-1] = True
        for x0, z0, x1, z1 in (*self._obstacles, extra):
            first, last = self._cell(x0, z0), self._cell(x1, z1)
            free[max(first[0], 0) : last[0] + 1, max(first[1], 0) : last[1] + 1] = False
        clearance = ndimage.distance_transform_edt(free) * _GRID_M
        labels, _ = ndimage.label(clearance >= _HALF_WAY_M)
        at_doors = {int(labels[self._cell(x, z)]) for x, z in self._doors}
        return len(at_doors) == 1 and 0 not in at_doors

    def _cell(self, x: float, z: float) -> tuple[int, int]:
        return (
            int((z - self.room.z0) / _GRID_M) + 1,
            int((x - self.room.x0) / _GRID_M) + 1,
        )

    def free_wall(self, wall: Wall, u: float, width: float) -> bool:
        """Whether a picture of a width can hang at `u`: no opening, nothing tall before it."""
        for opening in self.room.openings_in(wall.side):
            reach = (opening.width + width) / 2.0 + (CURTAIN_WIDTH + 0.1)
            if abs(wall.u_of(opening.middle) - u) < reach:
                return False
        a, b = wall.point(u - width / 2.0, 0.0, 0.0), wall.point(u + width / 2.0, 0.0, 0.12)
        strip = (min(a[0], b[0]), min(a[2], b[2]), max(a[0], b[0]), max(a[2], b[2]))
        return not any(
            placed.piece.height > 1.05 and overlaps(strip, placed.rect(), gap=0.05)
            for placed in self.placed
        )


def _knee_rects(placed: Placed) -> list[Rect]:
    front = placed.piece.depth / 2.0
    return [
        placed.before(front, front + _KNEE_ROOM_M, x=seat.position[0], width=0.44)
        for seat in placed.piece.seats
    ]


def _door_rect(wall: Wall, opening: Opening) -> Rect:
    u, half = wall.u_of(opening.middle), opening.width / 2.0 + 0.08
    a, b = wall.point(u - half), wall.point(u + half, 0.0, _DOOR_FREE_M)
    return (min(a[0], b[0]), min(a[2], b[2]), max(a[0], b[0]), max(a[2], b[2]))


def _curtain_rects(wall: Wall, opening: Opening) -> list[Rect]:
    rects = []
    for sign in (-1.0, 1.0):
        u = wall.u_of(opening.middle) + sign * (opening.width / 2.0 + 0.62 * CURTAIN_WIDTH)
        a = wall.point(u - CURTAIN_WIDTH / 2.0)
        b = wall.point(u + CURTAIN_WIDTH / 2.0, 0.0, 0.14)
        rects.append((min(a[0], b[0]), min(a[2], b[2]), max(a[0], b[0]), max(a[2], b[2])))
    return rects
