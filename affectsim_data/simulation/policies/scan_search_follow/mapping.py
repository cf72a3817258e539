"""What the robot has seen of the home: an occupancy map from depth, and ways over it.

Points are `(x, z)` in the robot's starting frame, as `Observation.position`: +X right, -Z ahead.
Evidence is kept in cells of 5 cm; ways, frontiers and all grids given out have cells of 10 cm.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import TypeVar

import cv2
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
from affectsim_data.simulation.policies.scan_search_follow.costing import floor_costs
from affectsim_data.simulation.policies.scan_search_follow.travelling import Travel
from affectsim_data.simulation.running import Observation

__all__ = ["CELL_M", "Frontier", "OccupancyMap"]

BoolArray = NDArray[np.bool_]
_Cell = TypeVar("_Cell", bound=np.generic)

CELL_M = 0.1
"""Side of a cell of the grids given out."""
_CELLS = round(2 * HALF_M / CELL_M)
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
_BLOCKED_M, _WARY_M = 0.11, 0.7
"""So far around what cut a move short nobody stands, and floor that was not seen costs more."""
_BESIDE_M = 0.45
_STOOD_M, _STOOD_COST = 0.15, 2.0
"""The robot fits where it stood, whatever the map says; this far around."""
_PERSON_M, _PERSON_NEAR_M, _PERSON_COST = 0.65, 0.95, 3.0
"""So near to a person the robot does not go: their 0.5 m, and how far they may come meanwhile. And
so near it rather does not."""
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
        shape = (FINE_CELLS, FINE_CELLS)
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
        self._wary = np.zeros((_CELLS, _CELLS), bool)
        self._people: tuple[FloatArray, ...] = ()
        self._room: NDArray[np.float32] | None = None
        self._costs: FloatArray | None = None
        self._travels: dict[tuple[int, int], Travel] = {}
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
        return _cells(np.asarray(points_xz, np.float64))

    def points(self, cells: ArrayLike) -> FloatArray:
        """Middle of cells, row and column `(..., 2)`: points `(..., 2)`."""
        return (np.asarray(cells, np.float64)[..., ::-1] + 0.5) * CELL_M - HALF_M

    def add(self, observation: Observation, people: BoolArray | None = None) -> None:
        """Takes in one depth image.

        Args:
            observation: What the robot sees, and from where.
            people: Pixels that belong to people, `(height, width)`: they are no furniture.
        """
        self._room = None
        self._forget_costs()
        here = observation.position[[0, 2]]
        self._stood[_around(here, _STOOD_M)] = True
        self._beside[_around(here, _BESIDE_M)] = True
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
        self._over[window.part] |= over
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
        over = self._over.reshape(-1)[fine_flat(points)]
        return np.asarray(self.unknown(points) & ~over)

    def block(self, places_xz: ArrayLike) -> None:
        """Notes that the robot cannot stand at places `(n, 2)`: a move there was cut short."""
        self._forget_costs()
        for place in np.atleast_2d(np.asarray(places_xz, np.float64)):
            self._blocked[_around(place, _BLOCKED_M)] = True
            self._wary[_around(place, _WARY_M)] = True

    def forget_blocks(self) -> None:
        """Forgets what cut moves short: where no way is left, one of them may do after all."""
        self._forget_costs()
        self._blocked[:] = False

    def keep_from(self, people_xz: Iterable[FloatArray]) -> None:
        """Has ways keep from where people, `(2,)` each, are now; replaces those it kept from."""
        self._forget_costs()
        self._people = tuple(people_xz)

    def costs(self) -> FloatArray:
        """What a metre of way costs in each cell: 1 where there is room, `inf` for no way.

        Where the robot has stood it can stand again; beyond where a move was cut short it cannot.
        """
        if self._costs is None:
            costs = np.full((_CELLS, _CELLS), np.inf)
            window = self._window()
            evidence = self._fine_window()
            costs[window] = floor_costs(
                evidence,
                self._fine_part(self._over),
                self._fine_room().reshape(evidence.shape).mean(axis=(1, 3)),
                beside=self._beside[window],
                wary=self._wary[window],
            )
            costs[self._stood] = np.minimum(costs[self._stood], _STOOD_COST)
            costs[self._blocked] = np.inf
            for place in self._people:
                costs[_around(place, _PERSON_NEAR_M)] *= _PERSON_COST
                costs[_around(place, _PERSON_M)] = np.inf
            self._costs = costs
        return self._costs

    def room(self, points_xz: ArrayLike) -> FloatArray:
        """Metres from points `(..., 2)` to the nearest thing known, `(...)`; some where none is."""
        rows, columns = self._window()
        points = np.asarray(points_xz, np.float64)
        fine = np.floor((points + HALF_M) / FINE_M).astype(np.intp)
        room = self._fine_room()
        row = np.clip(fine[..., 1] - 2 * rows.start, 0, room.shape[0] - 1)
        column = np.clip(fine[..., 0] - 2 * columns.start, 0, room.shape[1] - 1)
        return np.asarray(room[row, column], np.float64)

    def _fine_room(self) -> NDArray[np.float32]:
        """Metres to the nearest thing, of the fine cells of the window."""
        if self._room is None:
            blocks = self._fine_window()
            fine = blocks.reshape(2 * blocks.shape[0], 2 * blocks.shape[2])
            clear = (fine <= 0).astype(np.uint8)
            away = cv2.distanceTransform(clear, cv2.DIST_L2, cv2.DIST_MASK_5)
            self._room = np.asarray(away * np.float32(FINE_M), np.float32)
        return self._room

    def _forget_costs(self) -> None:
        self._costs = None
        self._travels.clear()

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
        steps = max(int(np.ceil(length.max(initial=0.0) / FINE_M)), 1)
        along = (np.arange(steps) + 0.5) / steps
        points = starts[..., None, :] + along[:, None] * away[..., None, :]
        counts = along * length[..., None] < length[..., None] - end_gap_m
        blocked = (self._sight.reshape(-1)[fine_flat(points)] > 0) & counts
        return np.asarray(~blocked.any(axis=-1))

    def distances_from(self, xz: ArrayLike) -> FloatArray:
        """What the way from a point `(2,)` to every cell costs, `inf` where none is known."""
        return self._travel(xz).distances

    def path(self, xz: ArrayLike, goal_xz: ArrayLike) -> FloatArray | None:
        """The cheapest way between two points, `(n, 2)`, or `None` where none is known.

        The goal may lie up to half a metre off the floor a robot can stand on; the way then ends
        at the nearest cell that can be reached.
        """
        bends = self._travel(xz).path(self.cells(goal_xz))
        if bends is None:
            return None
        points = self.points(bends)
        points[0] = np.asarray(xz, np.float64)
        return points

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

    def _travel(self, xz: ArrayLike) -> Travel:
        row, column = self.cells(xz).tolist()
        key = (row, column)
        if key not in self._travels:
            self._travels[key] = Travel(self.costs(), key, CELL_M)
        return self._travels[key]

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


def _cells(points: FloatArray) -> NDArray[np.intp]:
    cells = np.floor((points[..., ::-1] + HALF_M) / CELL_M).astype(np.intp)
    return np.clip(cells, 0, _CELLS - 1)


def _around(place_xz: FloatArray, reach_m: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the cells with their middle that near to a place, and of its own."""
    row, column = _cells(place_xz).tolist()
    reach = math.ceil(reach_m / CELL_M)
    rows = np.arange(max(row - reach, 0), min(row + reach + 1, _CELLS))
    columns = np.arange(max(column - reach, 0), min(column + reach + 1, _CELLS))
    x, z = ((cells + 0.5) * CELL_M - HALF_M for cells in (columns, rows))
    near = np.hypot(x - place_xz[0], (z - place_xz[1])[:, None]) <= reach_m
    near |= (rows == row)[:, None] & (columns == column)
    down, along = np.nonzero(near)
    return rows[down], columns[along]
