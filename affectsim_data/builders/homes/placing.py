"""Where furniture may stand: nothing overlaps, doors and seats are free, a robot gets through."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Sequence
from typing import Literal

import numpy as np

from affectsim_data.builders.homes.pieces import Furniture, LocalSeat
from affectsim_data.builders.homes.placed import (
    BEFORE_WALL_M,
    Placed,
    placed_before,
    wall_middles,
    wall_places,
    wall_rects,
)
from affectsim_data.builders.homes.plans import Opening, Rect, RoomPlan, Wall, overlaps
from affectsim_data.builders.homes.textiles import CURTAIN_DEPTH, CURTAIN_WIDTH, RUG_Y
from affectsim_data.builders.homes.ways import Ways
from affectsim_data.poses import FloatArray

__all__ = ["Placed", "RoomFloor"]

Prefer = Literal["corner", "center", "any"]

_DOOR_FREE_M = 0.9
_CASING_M = 0.1
_STEP_M = 0.12
_TRIES = 10
"""Places whose ways are looked at before a piece is given up."""
_REACH_SEAT_M = 0.55
_CLOTH_Y = 0.03
"""Of the lower edge of curtains."""
_CLOTH_OUT, _ROD_OUT = 0.085, 0.002
"""Before the wall: cloth passes before a window sill, the rod's holders end at the wall."""
_ROBOT_HEIGHT_M = 1.6
"""Only what hangs higher is never in a robot's way."""


class RoomFloor:
    """The floor of one room while it is being furnished."""

    def __init__(self, room: RoomPlan, *, rng: np.random.Generator) -> None:
        self.room = room
        self.rng = rng
        self.placed: list[Placed] = []
        self.ways = Ways(room)
        self._solid: list[Rect] = list(room.blocked)
        self._doors: list[Rect] = [*room.clear, *room.blocked]
        self._free: list[Rect] = []
        self._hung: dict[str, list[tuple[float, float, float, float]]] = {}
        for opening in room.openings:
            if opening.kind != "window":
                self._doors.append(_door_rect(room.wall(opening.side), opening))

    def obstruct(self, rects: Iterable[Rect]) -> None:
        """Takes floor that is no piece's."""
        rects = list(rects)
        self._solid += rects
        self.ways.take(rects)

    def keep_free(self, *rects: Rect) -> None:
        """Lets nothing be placed there."""
        self._free += rects

    def fits(self, *group: Placed) -> bool:
        """Whether pieces overlap nothing there is, keep doors and seats free and leave ways."""
        room = self.room
        for placed in group:
            x0, z0, x1, z1 = rect = placed.rect()
            edge = BEFORE_WALL_M - 1e-6
            if x0 < room.x0 + edge or z0 < room.z0 + edge:
                return False
            if x1 > room.x1 - edge or z1 > room.z1 - edge:
                return False
            taken = (*self._solid, *self._doors, *self._free)
            if any(overlaps(rect, other) for other in taken):
                return False
            seats = placed.piece.seats
            if seats and not any(self._is_free(placed.knees(seat)) for seat in seats):
                return False
        return self.ways.stay_open([rect for placed in group for rect in placed.footprint()])

    def _is_free(self, rect: Rect) -> bool:
        room = self.room
        inside = (
            rect[0] >= room.x0 and rect[1] >= room.z0 and rect[2] <= room.x1 and rect[3] <= room.z1
        )
        return inside and not any(overlaps(rect, other) for other in self._solid)

    def put(self, *group: Placed) -> bool:
        """Places pieces together if they fit; they may overlap one another's boxes."""
        if not self.fits(*group):
            return False
        self._take(group)
        return True

    def _take(self, group: Sequence[Placed]) -> None:
        self.placed += group
        self._solid += [placed.rect() for placed in group]
        self.ways.take([rect for placed in group for rect in placed.footprint()])
        for placed in group:
            self._free += [
                knees
                for knees in (placed.knees(seat) for seat in placed.piece.seats)
                if self._is_free(knees)
            ]

    def put_first(self, groups: Iterable[Sequence[Placed]], *, tries: int = 14) -> bool:
        """Places the first of several groups that fits; gives up after `tries` with no way."""
        for group in groups:
            if tries == 0:
                return False
            if self._collides(group):
                continue
            if self.put(*group):
                return True
            tries -= 1
        return False

    def _collides(self, group: Sequence[Placed]) -> bool:
        rects = np.array([placed.rect() for placed in group])
        return bool(self._blocked(rects).any())

    def _blocked(self, rects: FloatArray, *, gap: float = 0.0) -> np.ndarray:
        """Which rectangles `(n, 4)` lie outside of the room or on taken or kept floor, `(n,)`."""
        room, edge = self.room, BEFORE_WALL_M - 1e-6
        low, high = rects[:, :2], rects[:, 2:]
        outside = (low < np.array([room.x0, room.z0]) + edge).any(axis=1)
        outside |= (high > np.array([room.x1, room.z1]) - edge).any(axis=1)
        taken = np.array([*self._solid, *self._doors, *self._free]).reshape(-1, 4)
        hit = (low[:, None] < taken[None, :, 2:] + gap) & (taken[None, :, :2] < high[:, None] + gap)
        return np.asarray(outside | np.asarray(hit.all(axis=2)).any(axis=1), np.bool_)

    def at_wall(
        self, piece: Furniture, *, front: float = 0.0, prefer: Prefer = "any",
        sides: tuple[str, ...] | None = None, near: tuple[float, float] | None = None,
        windows: bool = False,
    ) -> Placed | None:  # fmt: skip
        """Places a piece with its back to a wall, or returns none if there is no place.

        Args:
            piece: Furniture.
            front: Metres before it to keep free.
            prefer: Which part of a wall to try first.
            sides: Walls to try; all by default.
            near: Point `(x, z)` to be close to, metres.
            windows: Whether it may stand before a window it hides.
        """
        options: list[tuple[float, Placed]] = []
        for wall in self.room.walls():
            if sides is None or wall.side in sides:
                options += self._along(wall, piece, prefer, near, windows=windows)
        options.sort(key=lambda option: option[0])
        tries = _TRIES
        for _, placed in options:
            strip = placed.before(piece.depth / 2, piece.depth / 2 + front, width=piece.width)
            if front and not self._is_free(strip):
                continue
            if tries == 0:
                return None
            tries -= 1
            if self.put(placed):
                if front:
                    self._free.append(strip)
                return placed
        return None

    def _along(
        self, wall: Wall, piece: Furniture, prefer: Prefer, near: tuple[float, float] | None,
        *, windows: bool,
    ) -> list[tuple[float, Placed]]:  # fmt: skip
        """Free places along a wall with their costs."""
        shifts, us = wall_places(wall, piece, step=_STEP_M)
        middles = wall_middles(wall, piece, us)
        blocked = self._blocked(wall_rects(wall, piece, middles))
        if not windows:
            blocked |= self._hides_window(piece, wall, us)
        away = np.abs(shifts)
        costs = {"corner": away.max(initial=0.0) - away, "center": away, "any": 0.0 * us}[prefer]
        if near is not None:
            costs = costs + np.hypot(middles[:, 0] - near[0], middles[:, 2] - near[1])
        costs = costs + self.rng.uniform(0.0, 0.3, len(us))
        return [
            (float(costs[k]), Placed(piece, float(middles[k, 0]), float(middles[k, 2]), wall.yaw))
            for k in np.flatnonzero(~blocked)
        ]

    def open_along(self, wall: Wall, piece: Furniture, us: FloatArray) -> FloatArray:
        """Those of the places along a wall where the piece itself would overlap nothing."""
        middles = wall_middles(wall, piece, us)
        open_us: FloatArray = us[~self._blocked(wall_rects(wall, piece, middles))]
        return open_us

    def open_at(
        self, piece: Furniture, xs: FloatArray, zs: FloatArray, turned: FloatArray
    ) -> FloatArray:
        """Which places, turned by a quarter or not, the piece itself would overlap nothing."""
        half_x = np.where(turned > 0.5, piece.depth, piece.width) / 2.0
        half_z = np.where(turned > 0.5, piece.width, piece.depth) / 2.0
        rects = np.stack([xs - half_x, zs - half_z, xs + half_x, zs + half_z], axis=1)
        return ~self._blocked(rects)

    def _hides_window(self, piece: Furniture, wall: Wall, us: FloatArray) -> np.ndarray:
        hides = np.zeros(len(us), bool)
        for opening in self.room.openings_in(wall.side):
            if opening.kind == "window" and piece.height > opening.bottom - 0.04:
                reach = (opening.width + piece.width) / 2.0 + 0.02
                hides |= np.abs(wall.u_of(opening.middle) - us) < reach
        return hides

    def hides_window(self, piece: Furniture, wall: Wall, u: float) -> bool:
        """Whether a piece at `u` of a wall stands before a window and is higher than its sill."""
        return bool(self._hides_window(piece, wall, np.array([u]))[0])

    def replace(self, old: Placed, new: Furniture) -> Placed:
        """The same place with another piece of the same size."""
        placed = dataclasses.replace(old, piece=new)
        self.placed[next(k for k, other in enumerate(self.placed) if other is old)] = placed
        return placed

    def on_top(self, base: Placed, piece: Furniture, *, turn: float = 0.0) -> bool:
        """Puts a piece on the top of another if it has one that is large enough."""
        for top in base.piece.tops:
            if piece.width <= top.width + 0.02 and piece.depth <= top.depth + 0.02:
                placed = base.beside(piece, top.x, top.z, turn=turn)
                self.placed.append(dataclasses.replace(placed, y=base.y + top.y, support="piece"))
                return True
        return False

    def lay(self, rug: Furniture, x: float, z: float, yaw: float = 0.0) -> bool:
        """Lays a rug where nothing stands half on it; what stands on it is lifted onto it."""
        flat = Placed(rug, x, z, yaw)
        x0, z0, x1, z1 = rect = flat.rect()
        room, held = self.room, []
        if x0 < room.x0 + 0.05 or z0 < room.z0 + 0.05 or x1 > room.x1 - 0.05 or z1 > room.z1 - 0.05:
            return False
        if any(overlaps(rect, other) for other in self._doors):
            return False
        for index, placed in enumerate(self.placed):
            if placed.support in ("wall", "ceiling"):
                continue
            a0, b0, a1, b1 = other = placed.rect()
            if not overlaps(rect, other):
                continue
            if a0 < x0 + 0.02 or b0 < z0 + 0.02 or a1 > x1 - 0.02 or b1 > z1 - 0.02:
                return False
            if placed.piece.category == "rug":
                return False
            held.append(index)
        for index in held:
            lifted = self.placed[index]
            self.placed[index] = dataclasses.replace(lifted, y=lifted.y + RUG_Y)
        self.placed.append(flat)
        return True

    def hang(
        self, wall: Wall, piece: Furniture, u: float, y: float, *, gap: float = 0.06,
        solid: bool = False,
    ) -> bool:  # fmt: skip
        """Hangs a piece on a wall, its underside at `y`, if nothing is in its way."""
        if not self.can_hang(wall, (piece.width, piece.depth, piece.height), u, y, gap=gap):
            return False
        placed = placed_before(wall, piece, u, out=0.002)
        placed = dataclasses.replace(placed, y=y, support="wall")
        if solid:
            rect = placed.rect()
            taken = (*self._doors, *self._free, *self._solid)
            if any(overlaps(rect, other) for other in taken):
                return False
        if y < _ROBOT_HEIGHT_M:
            if not self.ways.stay_open([placed.rect()]):
                return False
            self.ways.take([placed.rect()])
        if solid:
            self._solid.append(placed.rect())
        ends = (u - piece.width / 2.0, u + piece.width / 2.0)
        self._hung.setdefault(wall.side, []).append((ends[0], y, ends[1], y + piece.height))
        self.placed.append(placed)
        return True

    def can_hang(
        self, wall: Wall, size: tuple[float, float, float], u: float, y: float, *, gap: float
    ) -> bool:
        """Whether nothing is in the way of a piece of a width, depth and height on a wall."""
        start, end, high = u - size[0] / 2.0, u + size[0] / 2.0, y + size[2]
        if start < 0.05 or end > wall.length - 0.05 or high > self.room.ceiling_y - 0.05:
            return False
        for opening in self.room.openings_in(wall.side):
            if abs(wall.u_of(opening.middle) - u) < (opening.width + size[0]) / 2.0 + _CASING_M:
                return False
        for u0, y0, u1, y1 in self._hung.get(wall.side, []):
            if start < u1 + gap and u0 < end + gap and y < y1 + gap and y0 < high + gap:
                return False
        a, b = wall.point(start - 0.03), wall.point(end + 0.03, 0.0, size[1] + 0.03)
        near = (min(a[0], b[0]), min(a[2], b[2]), max(a[0], b[0]), max(a[2], b[2]))
        return not any(
            overlaps(near, other.rect()) and other.top_y > y - 0.04
            for other in self.placed
            if other.support in ("floor", "piece") and other.piece.category != "rug"
        )

    def drape(
        self, opening: Opening, wing: Callable[[float], Furniture],
        rod: Callable[[float], Furniture],
    ) -> bool:  # fmt: skip
        """Hangs curtains at a window if both have room beside or before it.

        Args:
            opening: The window.
            wing: Makes a drawn-back curtain of a height, metres.
            rod: Makes a rod of a length, metres.
        """
        wall = self.room.wall(opening.side)
        u = wall.u_of(opening.middle)
        rod_y = min(opening.top + 0.12, self.room.ceiling_y - 0.08)
        half = CURTAIN_WIDTH / 2.0 + 0.02
        for width in (opening.width + 2.0 * CURTAIN_WIDTH + 0.04, opening.width + 0.16):
            shift, reach = (width - CURTAIN_WIDTH) / 2.0, width / 2.0 + 0.07
            middles = (opening.middle - shift, opening.middle + shift)
            wings = [wall.rect((at - half, at + half), CURTAIN_DEPTH) for at in middles]
            if min(u, wall.length - u) - reach < CURTAIN_DEPTH or shift < half:
                continue
            taken = (*self._doors, *self._solid)
            if any(overlaps(one, other) for one in wings for other in taken):
                continue
            if self._opens_within(wall, opening, u - reach, u + reach):
                continue
            if not self.ways.stay_open(wings):
                continue
            for at in middles:
                cloth = placed_before(wall, wing(rod_y - _CLOTH_Y), wall.u_of(at), out=_CLOTH_OUT)
                self.placed.append(dataclasses.replace(cloth, y=_CLOTH_Y, support="wall"))
            bar = placed_before(wall, rod(2.0 * reach - 0.04), u, out=_ROD_OUT)
            self.placed.append(dataclasses.replace(bar, y=rod_y, support="wall"))
            self.obstruct(wings)
            self._hung.setdefault(wall.side, []).append((u - reach, 0.0, u + reach, rod_y + 0.1))
            return True
        return False

    def _opens_within(self, wall: Wall, own: Opening, start: float, end: float) -> bool:
        return any(
            opening is not own
            and abs(wall.u_of(opening.middle) - (start + end) / 2.0)
            < (opening.width + end - start) / 2.0 + _CASING_M
            for opening in self.room.openings_in(wall.side)
        )

    def drop_from_ceiling(self, piece: Furniture, x: float, z: float) -> None:
        """Hangs a piece from the ceiling."""
        y = self.room.ceiling_y - piece.height
        self.placed.append(Placed(piece, x, z, 0.0, y=y, support="ceiling"))

    def finish(self) -> list[Placed]:
        """Everything in the room; seats that cannot be used are seats no more."""
        done = []
        for placed in self.placed:
            usable = tuple(seat for seat in placed.piece.seats if self._usable(placed, seat))
            piece = placed.piece
            if len(usable) < len(piece.seats):
                piece = dataclasses.replace(piece, seats=usable)
            done.append(dataclasses.replace(placed, piece=piece, room_id=self.room.room_id))
        return done

    def _usable(self, placed: Placed, seat: LocalSeat) -> bool:
        own = placed.rect()
        knees = placed.knees(seat)
        room = self.room
        if knees[0] < room.x0 or knees[1] < room.z0 or knees[2] > room.x1 or knees[3] > room.z1:
            return False
        if any(overlaps(knees, other) for other in self._solid if other != own):
            return False
        x, z = (knees[0] + knees[2]) / 2.0, (knees[1] + knees[3]) / 2.0
        return self.ways.reaches(x, z, within=_REACH_SEAT_M)


def _door_rect(wall: Wall, opening: Opening) -> Rect:
    half = opening.width / 2.0 + 0.08
    return wall.rect((opening.middle - half, opening.middle + half), _DOOR_FREE_M)
