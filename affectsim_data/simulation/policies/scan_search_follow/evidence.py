"""What the robot has seen of the floor: evidence from depth for what is free and what is not.

Points are `(x, z)` in the robot's starting frame, as `Observation.position`: +X right, -Z ahead.
Evidence is kept in cells of 5 cm; all grids given out have cells of 10 cm.
"""

from __future__ import annotations

import math
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.carving import (
    FINE_CELLS,
    FINE_M,
    HALF_M,
    Window,
    fine_cells,
    fine_flat,
    passed_flags,
)
from affectsim_data.simulation.running import Observation

__all__ = ["CELLS", "CELL_M", "Evidence", "cells_of"]

BoolArray = NDArray[np.bool_]
_Cell = TypeVar("_Cell", bound=np.generic)

CELL_M = 0.1
"""Side of a cell of the grids given out."""
CELLS = round(2 * HALF_M / CELL_M)
"""Cells along a side of them."""
_REACH_M = 9.0
"""Depth is believed this far: beyond it a pixel row covers more than half a metre of floor."""
_FLOOR_M, _TOP_M, _SIGHT_M = 0.15, 1.5, 0.95
"""Heights: below the first is floor, above the second the robot fits under, and what reaches above
the third hides the upper body of who stands behind."""
_MAX_EVIDENCE = 4
"""Looks that evidence counts: as many as these undo it."""
_HIT, _MISS = 2, -1
_BLIND_M = 2.2
"""Down to here the floor lies below the image; rays that pass above it tell that nothing tall is
there."""
_LOW_M = 0.3
"""Things this low may stand unseen below rays that pass higher: no floor is known there."""


class Evidence:
    """A grid of 40 x 40 m around the start; cells are unknown, free or occupied."""

    def __init__(self) -> None:
        shape = (FINE_CELLS, FINE_CELLS)
        self._evidence = np.zeros(shape, np.int8)
        """Positive for occupied, negative for free, 0 for unknown."""
        self._sight = np.zeros(shape, np.int8)
        """The same for what is high enough to hide a person's upper body."""
        self._bounds = [CELLS // 2] * 4
        """First row and column, last row and column of the cells that hold all evidence."""
        self.over = np.zeros(shape, bool)
        """Where rays passed above floor that no look has shown."""
        self._rays: tuple[Camera, NDArray[np.float32], NDArray[np.float32]] | None = None

    @property
    def cell_m(self) -> float:
        """Side of a cell of the grids given out."""
        return CELL_M

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (along z) and columns (along x) of the grids given out."""
        return (CELLS, CELLS)

    def cells(self, points_xz: ArrayLike) -> NDArray[np.intp]:
        """Row and column of points `(..., 2)`, `(..., 2)`; points off the map count to its edge."""
        return cells_of(np.asarray(points_xz, np.float64))

    def points(self, cells: ArrayLike) -> FloatArray:
        """Middle of cells, row and column `(..., 2)`: points `(..., 2)`."""
        return (np.asarray(cells, np.float64)[..., ::-1] + 0.5) * CELL_M - HALF_M

    def add(self, observation: Observation, people: BoolArray | None = None) -> None:
        """Takes in one depth image.

        Args:
            observation: What the robot sees, and from where.
            people: Pixels that belong to people, `(height, width)`: they are no furniture.
        """
        here = observation.position[[0, 2]]
        across, down = self._pixel_rays(observation.camera)
        depth = observation.depth[1::2, 1::2]
        height = np.float32(observation.camera_height_m) - down[:, None] * depth
        believed = np.isfinite(depth) & (depth < _REACH_M)
        if people is not None:
            believed &= ~people[1::2, 1::2]
        floor = believed & (np.abs(height) < _FLOOR_M)
        solid = believed & (height >= _FLOOR_M) & (height < _TOP_M)
        turn = observation.yaw
        ahead = np.array([-math.sin(turn), -math.cos(turn)])
        right = np.array([math.cos(turn), -math.sin(turn)])
        rays = ahead + across[:, None] * right  # (columns, 2), one metre of depth long
        low_m = (observation.camera_height_m - _LOW_M) / float(down[-1])
        self._take_in(here, rays, depth, height, floor, solid, low_m)

    def _take_in(
        self,
        here: FloatArray,
        rays: FloatArray,
        depth: NDArray[np.float32],
        height: NDArray[np.float32],
        floor: BoolArray,
        solid: BoolArray,
        low_m: float,
    ) -> None:
        """Counts the evidence of one image; all arrays have a column per ray.

        From a depth of `low_m` metres on the image shows things of 0.3 m.
        """
        high = solid & (height >= _SIGHT_M)
        nearest = np.where(solid, depth, np.inf).min(axis=0)
        farthest = np.where(floor, depth, 0.0).max(axis=0)
        nearest_high = np.where(high, depth, np.inf).min(axis=0)
        # Down to the nearest thing in its column, and not beyond the floor that is seen, a ray
        # passes over free floor; nearer than `low_m` it only passes above.
        free_m = np.minimum(nearest - FINE_M, farthest)
        over_m = np.minimum(nearest - FINE_M, _BLIND_M)
        through_m = np.minimum(nearest_high - FINE_M, _REACH_M)
        hits = fine_cells(here, rays, np.where(floor | solid, depth, np.float32(0.0)))
        ends = np.maximum(np.maximum(free_m, over_m), np.maximum(through_m, 0.0))
        begin = fine_cells(here, rays[:1], np.zeros(1, np.float32))
        window = Window.around(begin, fine_cells(here, rays, ends), hits)
        occupied, tall, seen = window.flags(hits, (solid, high, floor))
        reaches, starts = (free_m, over_m, through_m), (low_m, 0.0, 0.0)
        passed, over, through = passed_flags(here, rays, reaches, starts, window)
        evidence, sight = self._evidence[window.part], self._sight[window.part]
        _count(evidence, seen & ~occupied, _MISS)
        _count(evidence, passed & (evidence <= 0), _MISS)
        _count(evidence, occupied, _HIT)
        _count(sight, through & ~tall, _MISS)
        _count(sight, tall, _HIT)
        self.over[window.part] |= over
        self._widen(window, occupied | seen | passed | over)

    def free(self, points_xz: ArrayLike) -> BoolArray:
        """Which points `(..., 2)` are known to be free floor, `(...)`."""
        return np.asarray(self._at(points_xz) < 0)

    def occupied(self, points_xz: ArrayLike) -> BoolArray:
        """Which points `(..., 2)` have something on them, up to 1.5 m high, `(...)`."""
        return np.asarray(self._at(points_xz) > 0)

    def unknown(self, points_xz: ArrayLike) -> BoolArray:
        """Which points `(..., 2)` nothing is known of, `(...)`."""
        return np.asarray(self._at(points_xz) == 0)

    def unseen(self, points_xz: ArrayLike) -> BoolArray:
        """Which points `(..., 2)` no look has shown, nor passed above, `(...)`."""
        points = np.asarray(points_xz, np.float64)
        over = self.over.reshape(-1)[fine_flat(points)]
        return np.asarray(self.unknown(points) & ~over)

    def line_of_sight(
        self, from_xz: ArrayLike, to_xz: ArrayLike, *, end_gap_m: float = 0.25
    ) -> BoolArray:
        """Whether nothing known hides the upper body of who stands at one point from the other.

        Args:
            from_xz: `(n, 2)`.
            to_xz: `(m, 2)`.
            end_gap_m: This much before the second point does not count: it is the body itself.

        Returns:
            `(n, m)`.
        """
        starts, ends = np.atleast_2d(from_xz)[:, None], np.atleast_2d(to_xz)[None]
        away = ends - starts
        length = np.hypot(away[..., 0], away[..., 1])
        steps = max(int(np.ceil(length.max(initial=0.0) / FINE_M)), 1)
        along = (np.arange(steps) + 0.5) / steps
        points = starts[..., None, :] + along[:, None] * away[..., None, :]
        counts = along * length[..., None] < length[..., None] - end_gap_m
        blocked = (self._sight.reshape(-1)[fine_flat(points)] > 0) & counts
        return np.asarray(~blocked.any(axis=-1))

    def _widen(self, window: Window, touched: BoolArray) -> None:
        """Notes where there is evidence."""
        rows, columns = (np.flatnonzero(touched.any(axis=axis)) for axis in (1, 0))
        if not len(rows):
            return
        top, left, bottom, right = self._bounds
        self._bounds = [
            min(top, (window.top + int(rows[0])) // 2),
            min(left, (window.left + int(columns[0])) // 2),
            max(bottom, (window.top + int(rows[-1])) // 2),
            max(right, (window.left + int(columns[-1])) // 2),
        ]

    def window(self) -> tuple[slice, slice]:
        """Rows and columns of the cells with evidence, and one more all round."""
        top, left, bottom, right = self._bounds
        return (
            slice(max(top - 1, 0), min(bottom + 2, CELLS)),
            slice(max(left - 1, 0), min(right + 2, CELLS)),
        )

    def fine_window(self) -> NDArray[np.int8]:
        """The evidence there, `(rows, 2, columns, 2)`."""
        return self.fine_part(self._evidence)

    def fine_part(self, grid: NDArray[_Cell]) -> NDArray[_Cell]:
        """What a fine grid holds there, `(rows, 2, columns, 2)`."""
        rows, columns = self.window()
        part = grid[2 * rows.start : 2 * rows.stop, 2 * columns.start : 2 * columns.stop]
        return part.reshape(part.shape[0] // 2, 2, part.shape[1] // 2, 2)

    def _at(self, points_xz: ArrayLike) -> NDArray[np.int8]:
        points = np.asarray(points_xz, np.float64)
        return self._evidence.reshape(-1)[fine_flat(points)]

    def _pixel_rays(self, camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Metres to the right and down per metre of depth, of every other pixel."""
        if self._rays is None or self._rays[0] != camera:
            K = camera.intrinsics
            across = (np.arange(1, camera.width, 2) + 0.5 - K[0, 2]) / K[0, 0]
            down = (np.arange(1, camera.height, 2) + 0.5 - K[1, 2]) / K[1, 1]
            self._rays = camera, across.astype(np.float32), down.astype(np.float32)
        return self._rays[1], self._rays[2]


def _count(grid: NDArray[np.int8], where: BoolArray, step: int) -> None:
    """Adds to the evidence of some cells of a part of the grid."""
    grid += where * np.int8(step)
    np.clip(grid, -_MAX_EVIDENCE, _MAX_EVIDENCE, out=grid)


def cells_of(points: FloatArray) -> NDArray[np.intp]:
    """Row and column of points `(..., 2)`, `(..., 2)`; points off the grid count to its edge."""
    cells = np.floor((points[..., ::-1] + HALF_M) / CELL_M).astype(np.intp)
    return np.clip(cells, 0, CELLS - 1)
