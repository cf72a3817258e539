"""Whether a robot still gets through a room while it is being furnished."""

from __future__ import annotations

import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.plans import Rect, RoomPlan

__all__ = ["Ways"]

_CELL_M = 0.05
_HALF_WAYS_M = (0.38, 0.345, 0.31)
"""Ways between doors are at least twice as wide as the first of these that the room allows."""
_ROBOT_M = 0.30
_POCKET_M2 = 0.03
"""Largest area of places for the robot's middle that may be cut off from the doors."""
_BEFORE_DOOR_M, _AROUND_M = 0.5, 0.2

Mask = NDArray[np.uint8]


class Ways:
    """The free floor of a room as a grid, and the ways from door to door over it."""

    def __init__(self, room: RoomPlan) -> None:
        self._x0, self._z0 = room.x0, room.z0
        rows = math.ceil((room.z1 - room.z0) / _CELL_M) + 2
        columns = math.ceil((room.x1 - room.x0) / _CELL_M) + 2
        # One taken cell all around stands for the walls.
        self._free: Mask = np.zeros((rows, columns), np.uint8)
        self._free[1:-1, 1:-1] = 1
        self._paint(self._free, room.blocked)
        self._doors = self._door_cells(room)
        self._half_way, self._joined, self._pockets = 0.0, 0, 0.0
        # Where even the empty room has narrow ways, they are kept as wide as they are.
        for self._half_way in _HALF_WAYS_M:
            self._joined, self._pockets = self._state(self._free)
            if self._joined == len(self._doors):
                break

    def _door_cells(self, room: RoomPlan) -> list[tuple[int, int]]:
        """The most open cell before every door."""
        clearance, reach = self._clearance(self._free), round(_AROUND_M / _CELL_M)
        cells = []
        for opening in room.openings:
            if opening.kind == "window":
                continue
            wall = room.wall(opening.side)
            x, _, z = wall.point(wall.u_of(opening.middle), 0.0, _BEFORE_DOOR_M)
            row, column = self._cell(float(x), float(z))
            top, left = max(row - reach, 0), max(column - reach, 0)
            window = clearance[top : row + reach + 1, left : column + reach + 1]
            best = np.unravel_index(int(window.argmax()), window.shape)
            cells.append((top + int(best[0]), left + int(best[1])))
        return cells

    def take(self, rects: Iterable[Rect]) -> None:
        """Takes floor for good."""
        self._paint(self._free, rects)

    def stay_open(self, rects: Iterable[Rect]) -> bool:
        """Whether, with these taken too, all doors stay joined and no free floor is cut off."""
        free = self._free.copy()
        self._paint(free, rects)
        joined, pockets = self._state(free)
        return joined >= self._joined and pockets <= self._pockets + _POCKET_M2

    def reaches(self, x: float, z: float, *, within: float) -> bool:
        """Whether the robot gets from the doors to a place within a distance of a point."""
        main, _ = self._main(self._clearance(self._free))
        away = cv2.distanceTransform(1 - main, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        row, column = self._cell(x, z)
        return bool(away[row, column] * _CELL_M <= within)

    def _state(self, free: Mask) -> tuple[int, float]:
        """How many doors are joined by wide ways, and the area of pockets, m2."""
        clearance = self._clearance(free)
        labels = _components(clearance - _CELL_M / 2.0 >= self._half_way)
        at_doors = [int(labels[cell]) for cell in self._doors]
        joined = max((at_doors.count(label) for label in set(at_doors) - {0}), default=0)
        main, fits = self._main(clearance)
        near = cv2.dilate(main, np.ones((5, 5), np.uint8))
        stray = (fits == 1) & (np.asarray(near) == 0)
        return joined, float(stray.sum()) * _CELL_M**2

    def _main(self, clearance: NDArray[np.float32]) -> tuple[Mask, Mask]:
        """Where the robot's middle gets from the doors, and wherever it would fit."""
        fits = (clearance >= _ROBOT_M + 0.01).astype(np.uint8)
        labels = _components(clearance - _CELL_M / 2.0 >= _ROBOT_M + 0.01)
        wanted = {int(labels[cell]) for cell in self._doors} - {0}
        if not wanted:
            sizes = np.bincount(labels.ravel())
            sizes[0] = 0
            wanted = {int(sizes.argmax())} if sizes.any() else set()
        return np.isin(labels, list(wanted)).astype(np.uint8), fits

    def _clearance(self, free: Mask) -> NDArray[np.float32]:
        """Metres from the middle of each cell to that of the nearest taken one."""
        distance = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return np.asarray(distance * np.float32(_CELL_M), np.float32)

    def _paint(self, free: Mask, rects: Iterable[Rect]) -> None:
        for x0, z0, x1, z1 in rects:
            first, last = self._cell(x0 + 1e-6, z0 + 1e-6), self._cell(x1 - 1e-6, z1 - 1e-6)
            free[first[0] : last[0] + 1, first[1] : last[1] + 1] = 0

    def _cell(self, x: float, z: float) -> tuple[int, int]:
        rows, columns = self._free.shape
        row, column = int((z - self._z0) / _CELL_M) + 1, int((x - self._x0) / _CELL_M) + 1
        return (min(max(row, 0), rows - 1), min(max(column, 0), columns - 1))


def _components(mask: NDArray[np.bool_]) -> NDArray[np.int32]:
    _, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    return np.asarray(labels, np.int32)
