"""What the robot has seen of the home: an occupancy map from depth, and ways over it.

Points are `(x, z)` in the robot's starting frame, as `Observation.position`: +X right, -Z ahead.
Evidence is kept in cells of 5 cm; ways, frontiers and all grids given out have cells of 10 cm.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.travelling import Travel
from affectsim_data.simulation.running import Observation

__all__ = ["CELL_M", "Frontier", "OccupancyMap"]

BoolArray = NDArray[np.bool_]
_Cell = TypeVar("_Cell", bound=np.generic)

CELL_M = 0.1
"""Side of a cell of the grids given out."""
HALF_M = 20.0
"""The map reaches this far from where the robot started."""
_FINE_M = 0.05
_FINE_CELLS = round(2 * HALF_M / _FINE_M)
_CELLS = round(2 * HALF_M / CELL_M)
_REACH_M = 9.0
"""Depth is believed this far: beyond it a pixel row covers more than half a metre of floor."""
_FLOOR_M, _TOP_M, _SIGHT_M = 0.15, 1.5, 0.95
"""Heights: below the first is floor, above the second the robot fits under, and what reaches above
the third hides the upper body of who stands behind."""
_CARVE_STEP_M = 0.04
_MAX_EVIDENCE = 4
"""Looks that evidence counts: as many as these undo it."""
_HIT, _MISS = 2, -1
_BLIND_M = 2.2
"""Down to here the floor lies below the image; rays that pass above it tell that nothing tall is
there."""
_BLOCKED_M = 0.11
_BESIDE_M, _SQUEEZE_M = 0.45, 0.2
_STOOD_M = 0.15
"""The robot fits where it stood, whatever the map says; this far around."""
_MIN_FRONTIER_CELLS = 3


@dataclasses.dataclass(frozen=True)
class Frontier:
    """A border between free floor and what has not been seen."""

    cells: NDArray[np.intp]
    """Free cells along it, row and column, `(n, 2)`."""
    centre_xz: FloatArray
    """The one of these cells nearest to their mean, metres, `(2,)`."""
    size: float
    """Length, metres."""


class OccupancyMap:
    """A map of 40 x 40 m around the start; cells are unknown, free or occupied."""

    def __init__(self) -> None:
        shape = (_FINE_CELLS, _FINE_CELLS)
        self._evidence = np.zeros(shape, np.int8)
        """Positive for occupied, negative for free, 0 for unknown."""
        self._sight = np.zeros(shape, np.int8)
        """The same for what is high enough to hide a person's upper body."""
        self._stood = np.zeros((_CELLS, _CELLS), bool)
        self._bounds = [_CELLS // 2] * 4
        """First row and column, last row and column of the cells that hold all evidence."""
        self._over = np.zeros(shape, bool)
        """Where rays passed above floor that no look has shown."""
        self._beside = np.zeros((_CELLS, _CELLS), bool)
        self._blocked = np.zeros((_CELLS, _CELLS), bool)
        self._travelable: dict[tuple[float, bool], BoolArray] = {}
        self._travels: dict[tuple[float, bool, int, int], Travel] = {}
        self._rays: tuple[Camera, NDArray[np.float32], NDArray[np.float32]] | None = None

    @property
    def cell_m(self) -> float:
        """Side of a cell of the grids given out."""
        return CELL_M

    @property
    def shape(self) -> tuple[int, int]:
        """Rows (along z) and columns (along x) of the grids given out."""
        return (_CELLS, _CELLS)

    def cells(self, points_xz: ArrayLike) -> NDArray[np.intp]:
        """Row and column of points `(..., 2)`, `(..., 2)`; points off the map count to its edge."""
        points = np.asarray(points_xz, np.float64)
        cells = np.floor((points[..., ::-1] + HALF_M) / CELL_M).astype(np.intp)
        return np.clip(cells, 0, _CELLS - 1)

    def points(self, cells: ArrayLike) -> FloatArray:
        """Middle of cells, row and column `(..., 2)`: points `(..., 2)`."""
        return (np.asarray(cells, np.float64)[..., ::-1] + 0.5) * CELL_M - HALF_M

    def add(self, observation: Observation, people: BoolArray | None = None) -> None:
        """Takes in one depth image.

        Args:
            observation: What the robot sees, and from where.
            people: Pixels that belong to people, `(height, width)`: they are no furniture.
        """
        self._travelable.clear()
        self._travels.clear()
        here = observation.position[[0, 2]]
        self._stood |= self._around(here, _STOOD_M)
        self._beside |= self._around(here, _BESIDE_M)
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
        self._take_in(here, rays, depth, height, floor, solid)

    def _take_in(
        self,
        here: FloatArray,
        rays: FloatArray,
        depth: NDArray[np.float32],
        height: NDArray[np.float32],
        floor: BoolArray,
        solid: BoolArray,
    ) -> None:
        """Counts the evidence of one image; all arrays have a column per ray."""
        occupied = _fine_indices(here, rays, depth, solid)
        tall = _fine_indices(here, rays, depth, solid & (height >= _SIGHT_M))
        seen = _fine_indices(here, rays, depth, floor)
        nearest = np.where(solid, depth, np.inf).min(axis=0)
        farthest = np.where(floor, depth, 0.0).max(axis=0)
        # Down to the nearest thing in its column, and not beyond the floor that is seen, a ray
        # passes over free floor; also where the floor right before the robot is below the image.
        passed = _passed_indices(here, rays, np.minimum(nearest - _FINE_M, farthest))
        over = _passed_indices(here, rays, np.minimum(nearest - _FINE_M, _BLIND_M))
        self._over.reshape(-1)[over] = True
        nearest_tall = np.where(solid & (height >= _SIGHT_M), depth, np.inf).min(axis=0)
        through = _passed_indices(here, rays, np.minimum(nearest_tall - _FINE_M, _REACH_M))
        free = np.setdiff1d(seen, occupied, assume_unique=True)
        _count(self._evidence, free, _MISS)
        flat = self._evidence.reshape(-1)
        _count(self._evidence, passed[flat[passed] <= 0], _MISS)
        _count(self._evidence, occupied, _HIT)
        self._widen(occupied, seen, passed, over)
        _count(self._sight, np.setdiff1d(through, tall, assume_unique=True), _MISS)
        _count(self._sight, tall, _HIT)

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
        over = self._over.reshape(-1)[_fine_flat(points)]
        return np.asarray(self.unknown(points) & ~over)

    def block(self, place_xz: ArrayLike) -> None:
        """Notes that the robot cannot stand at a place `(2,)`: a move there was cut short."""
        self._travelable.clear()
        self._travels.clear()
        self._blocked |= self._around(np.asarray(place_xz, np.float64), _BLOCKED_M)

    def travelable(self, radius: float = 0.3, *, daring: bool = False) -> BoolArray:
        """Cells where a robot of this radius, metres, can stand: free, and that far from things.

        Where it has stood it can stand again; where a move was cut short it cannot.

        Args:
            radius: Metres.
            daring: Whether floor counts as free that rays only passed above.
        """
        key = (radius, daring)
        if key not in self._travelable:
            blocks = self._fine_window()
            fine = blocks.reshape(2 * blocks.shape[0], 2 * blocks.shape[2])
            room = cv2.distanceTransform((fine <= 0).astype(np.uint8), cv2.DIST_L2, cv2.DIST_MASK_5)
            open_floor = fine < 0
            if daring:
                over = self._fine_part(self._over).reshape(fine.shape)
                open_floor |= (fine == 0) & over
            room_m = (open_floor * room * _FINE_M).reshape(blocks.shape).max(axis=(1, 3))
            # Close to where it stood the robot may squeeze through, or it could not get away.
            least_m = np.where(self._beside[self._window()], min(radius, _SQUEEZE_M), radius)
            grid = np.zeros((_CELLS, _CELLS), bool)
            grid[self._window()] = room_m > least_m
            self._travelable[key] = (grid & ~self._blocked) | self._stood
        return self._travelable[key]

    def frontiers(self) -> list[Frontier]:
        """Borders of the free floor with the unknown, the longest first."""
        known = self._fine_window()
        occupied = (known > 0).any(axis=(1, 3))
        free = (known < 0).any(axis=(1, 3)) & ~occupied
        unseen = (known == 0) & ~self._fine_part(self._over)
        unknown = (unseen.sum(axis=(1, 3)) >= 3).astype(np.uint8)
        edge = free & (cv2.dilate(unknown, np.ones((3, 3), np.uint8)) > 0)
        if not edge.any():
            return []
        _, labels = cv2.connectedComponents(edge.astype(np.uint8), connectivity=8)
        rows, columns = np.nonzero(labels)
        which = labels[rows, columns]
        corner = [side.start for side in self._window()]
        cells = np.stack([rows, columns], axis=1)[np.argsort(which, kind="stable")] + corner
        ends = np.cumsum(np.bincount(which)[1:])
        found = []
        for part in np.split(cells, ends[:-1]):
            if len(part) >= _MIN_FRONTIER_CELLS:
                off = ((part - part.mean(axis=0)) ** 2).sum(axis=1)
                centre = self.points(part[off.argmin()])
                found.append(Frontier(part, centre, CELL_M * len(part)))
        return sorted(found, key=lambda one: -one.size)

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
        steps = max(int(np.ceil(length.max(initial=0.0) / _FINE_M)), 1)
        along = (np.arange(steps) + 0.5) / steps
        points = starts[..., None, :] + along[:, None] * away[..., None, :]
        counts = along * length[..., None] < length[..., None] - end_gap_m
        blocked = (self._sight.reshape(-1)[_fine_flat(points)] > 0) & counts
        return np.asarray(~blocked.any(axis=-1))

    def distances_from(
        self, xz: ArrayLike, radius: float = 0.3, *, daring: bool = False
    ) -> FloatArray:
        """Metres of way from a point `(2,)` to every cell, `inf` where none is known."""
        return self._travel(xz, radius, daring).distances

    def path(
        self, xz: ArrayLike, goal_xz: ArrayLike, radius: float = 0.3, *, daring: bool = False
    ) -> FloatArray | None:
        """A short way between two points, `(n, 2)`, or `None` where none is known.

        The goal may lie up to half a metre off the floor a robot can stand on; the way then ends
        at the nearest cell that can be reached.
        """
        travel = self._travel(xz, radius, daring)
        bends = travel.path(self.cells(goal_xz))
        if bends is None:
            return None
        points = self.points(bends)
        points[0] = np.asarray(xz, np.float64)
        return points

    def _widen(self, *touched: NDArray[np.intp]) -> None:
        """Notes where there is evidence, by flat indices of fine cells."""
        for indices in touched:
            if len(indices):
                rows, columns = np.divmod(indices, _FINE_CELLS)
                low = (int(rows[0]) // 2, int(columns.min()) // 2)  # indices are sorted
                high = (int(rows[-1]) // 2, int(columns.max()) // 2)
                self._bounds[:2] = [min(pair) for pair in zip(self._bounds[:2], low, strict=True)]
                self._bounds[2:] = [max(pair) for pair in zip(self._bounds[2:], high, strict=True)]

    def _window(self) -> tuple[slice, slice]:
        """Rows and columns of the cells with evidence, and one more all round."""
        top, left, bottom, right = self._bounds
        return (
            slice(max(top - 1, 0), min(bottom + 2, _CELLS)),
            slice(max(left - 1, 0), min(right + 2, _CELLS)),
        )

    def _fine_window(self) -> NDArray[np.int8]:
        """The evidence there, `(rows, 2, columns, 2)`."""
        return self._fine_part(self._evidence)

    def _fine_part(self, grid: NDArray[_Cell]) -> NDArray[_Cell]:
        """What a fine grid holds there, `(rows, 2, columns, 2)`."""
        rows, columns = self._window()
        part = grid[2 * rows.start : 2 * rows.stop, 2 * columns.start : 2 * columns.stop]
        return part.reshape(part.shape[0] // 2, 2, part.shape[1] // 2, 2)

    def _travel(self, xz: ArrayLike, radius: float, daring: bool) -> Travel:
        row, column = self.cells(xz).tolist()
        key = (radius, daring, row, column)
        if key not in self._travels:
            grid = self.travelable(radius, daring=daring)
            self._travels[key] = Travel(grid, (row, column), CELL_M)
        return self._travels[key]

    def _at(self, points_xz: ArrayLike) -> NDArray[np.int8]:
        points = np.asarray(points_xz, np.float64)
        return self._evidence.reshape(-1)[_fine_flat(points)]

    def _around(self, place_xz: FloatArray, reach_m: float) -> BoolArray:
        """Cells with their middle that near to a place, `(rows, columns)`."""
        row, column = (int(value) for value in self.cells(place_xz))
        reach = math.ceil(reach_m / CELL_M)
        window = (
            slice(max(row - reach, 0), row + reach + 1),
            slice(max(column - reach, 0), column + reach + 1),
        )
        rows, columns = np.mgrid[window]
        away = self.points(np.stack([rows, columns], axis=-1)) - place_xz
        near = np.zeros((_CELLS, _CELLS), bool)
        near[window] = np.hypot(away[..., 0], away[..., 1]) <= reach_m
        near[row, column] = True
        return near

    def _pixel_rays(self, camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
        """Metres to the right and down per metre of depth, of every other pixel."""
        if self._rays is None or self._rays[0] != camera:
            K = camera.intrinsics
            across = (np.arange(1, camera.width, 2) + 0.5 - K[0, 2]) / K[0, 0]
            down = (np.arange(1, camera.height, 2) + 0.5 - K[1, 2]) / K[1, 1]
            self._rays = camera, across.astype(np.float32), down.astype(np.float32)
        return self._rays[1], self._rays[2]


def _fine_flat(points: FloatArray) -> NDArray[np.intp]:
    """Places of points `(..., 2)` in the flat fine grid, `(...)`; clipped to its edge."""
    cells = ((points + HALF_M) * (1.0 / _FINE_M)).astype(np.intp)
    np.clip(cells, 0, _FINE_CELLS - 1, out=cells)
    return np.asarray(cells[..., 1] * _FINE_CELLS + cells[..., 0])


def _fine_indices(
    here: FloatArray, rays: FloatArray, depth: NDArray[np.float32], chosen: BoolArray
) -> NDArray[np.intp]:
    """Fine cells of the chosen pixels, each once, sorted."""
    rows, columns = np.nonzero(chosen)
    points = here + depth[rows, columns, None] * rays[columns]
    return _once(_fine_flat(points))


def _passed_indices(here: FloatArray, rays: FloatArray, reach: FloatArray) -> NDArray[np.intp]:
    """Fine cells that rays pass down to a depth `(columns,)`, each once, sorted."""
    limit = float(reach.max(initial=0.0))
    depths = np.arange(0.0, max(limit, _CARVE_STEP_M), _CARVE_STEP_M)
    rows, columns = np.nonzero(depths[:, None] < reach)
    return _once(_fine_flat(here + depths[rows, None] * rays[columns]))


def _once(indices: NDArray[np.intp]) -> NDArray[np.intp]:
    """Each index once, sorted; faster than `np.unique` on a bounded range."""
    mark = np.zeros(_FINE_CELLS * _FINE_CELLS, bool)
    mark[indices] = True
    return np.flatnonzero(mark)


def _count(grid: NDArray[np.int8], indices: NDArray[np.intp], step: int) -> None:
    flat = grid.reshape(-1)
    flat[indices] = np.clip(flat[indices] + step, -_MAX_EVIDENCE, _MAX_EVIDENCE)
