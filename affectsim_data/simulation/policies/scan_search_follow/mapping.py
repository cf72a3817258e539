"""The robot's map of the home: what it has seen, and ways over it.

Points are `(x, z)` in the robot's starting frame, as `Observation.position`: +X right, -Z ahead.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.carving import FINE_M, HALF_M
from affectsim_data.simulation.policies.scan_search_follow.costing import floor_costs
from affectsim_data.simulation.policies.scan_search_follow.evidence import (
    CELL_M,
    CELLS,
    Evidence,
    cells_of,
)
from affectsim_data.simulation.policies.scan_search_follow.travelling import Travel
from affectsim_data.simulation.running import Observation

__all__ = ["PERSON_M", "Frontier", "OccupancyMap"]

BoolArray = NDArray[np.bool_]

_BLOCKED_M, _WARY_M = 0.11, 0.7
"""So far around what cut a move short nobody stands, and floor that was not seen costs more."""
_BESIDE_M = 0.45
_STOOD_M, _STOOD_COST = 0.15, 2.0
"""The robot fits where it stood, whatever the map says; this far around."""
PERSON_M, _PERSON_NEAR_M, _PERSON_COST = 0.65, 0.95, 3.0
"""So near to a person the robot does not go: their 0.5 m, and how far they may come meanwhile. And
so near it rather does not, nor to where they walk."""
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


class OccupancyMap(Evidence):
    """What is known of the home, and where the robot can go."""

    def __init__(self) -> None:
        super().__init__()
        self._stood = np.zeros((CELLS, CELLS), bool)
        self._beside = np.zeros((CELLS, CELLS), bool)
        self._blocked = np.zeros((CELLS, CELLS), bool)
        self._wary = np.zeros((CELLS, CELLS), bool)
        self.people_xz: tuple[FloatArray, ...] = ()
        """Where people are now, `(2,)` each."""
        self._standing: tuple[FloatArray, ...] = ()
        self._trodden: tuple[FloatArray, ...] = ()
        self._room: NDArray[np.float32] | None = None
        self._costs: FloatArray | None = None
        self._travels: dict[tuple[int, int], Travel] = {}

    def add(self, observation: Observation, people: BoolArray | None = None) -> None:
        """Takes in one depth image; `people` as of `Evidence.add`."""
        here = observation.position[[0, 2]]
        self._stood[_around(here, _STOOD_M)] = True
        self._beside[_around(here, _BESIDE_M)] = True
        super().add(observation, people)
        self._room = None
        self._forget_costs()

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

    def keep_from(
        self, people_xz: Iterable[FloatArray], trodden_xz: Iterable[FloatArray] = ()
    ) -> None:
        """Has ways keep from where people, `(2,)` each, are now; replaces those it kept from.

        Ways go round places `trodden_xz` where somebody walks to and fro if they can. Where that
        one is right now does not count: they will be gone.
        """
        self._forget_costs()
        self.people_xz, self._trodden = tuple(people_xz), tuple(trodden_xz)
        walk = np.array(self._trodden).reshape(-1, 2)
        self._standing = tuple(
            one for one in self.people_xz if not (np.hypot(*(walk - one).T) < PERSON_M).any()
        )

    def costs(self) -> FloatArray:
        """What a metre of way costs in each cell: 1 where there is room, `inf` for no way.

        Where the robot has stood it can stand again; beyond where a move was cut short it cannot.
        """
        if self._costs is None:
            costs = np.full((CELLS, CELLS), np.inf)
            window = self.window()
            evidence = self.fine_window()
            costs[window] = floor_costs(
                evidence,
                self.fine_part(self.over),
                self._fine_room().reshape(evidence.shape).mean(axis=(1, 3)),
                beside=self._beside[window],
                wary=self._wary[window],
            )
            costs[self._stood] = np.minimum(costs[self._stood], _STOOD_COST)
            costs[self._blocked] = np.inf
            near = np.zeros((CELLS, CELLS), bool)
            for place in self.people_xz + self._trodden:
                near[_around(place, _PERSON_NEAR_M)] = True
            costs[near] *= _PERSON_COST
            for place in self._standing:
                costs[_around(place, PERSON_M)] = np.inf
            self._costs = costs
        return self._costs

    def room(self, points_xz: ArrayLike) -> FloatArray:
        """Metres from points `(..., 2)` to the nearest thing known, `(...)`; some where none is."""
        rows, columns = self.window()
        points = np.asarray(points_xz, np.float64)
        fine = np.floor((points + HALF_M) / FINE_M).astype(np.intp)
        room = self._fine_room()
        row = np.clip(fine[..., 1] - 2 * rows.start, 0, room.shape[0] - 1)
        column = np.clip(fine[..., 0] - 2 * columns.start, 0, room.shape[1] - 1)
        return np.asarray(room[row, column], np.float64)

    def _fine_room(self) -> NDArray[np.float32]:
        """Metres to the nearest thing, of the fine cells of the window."""
        if self._room is None:
            blocks = self.fine_window()
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
        known = self.fine_window()
        occupied = (known > 0).any(axis=(1, 3))
        free = (known < 0).any(axis=(1, 3)) & ~occupied
        unseen = (known == 0) & ~self.fine_part(self.over)
        unknown = (unseen.sum(axis=(1, 3)) >= 3).astype(np.uint8)
        edge = free & (cv2.dilate(unknown, np.ones((3, 3), np.uint8)) > 0)
        if not edge.any():
            return []
        _, labels = cv2.connectedComponents(edge.astype(np.uint8), connectivity=8)
        rows, columns = np.nonzero(labels)
        which = labels[rows, columns]
        corner = [side.start for side in self.window()]
        cells = np.stack([rows, columns], axis=1)[np.argsort(which, kind="stable")] + corner
        ends = np.cumsum(np.bincount(which)[1:])
        found = []
        for part in np.split(cells, ends[:-1]):
            if len(part) >= _MIN_FRONTIER_CELLS:
                off = ((part - part.mean(axis=0)) ** 2).sum(axis=1)
                centre = self.points(part[off.argmin()])
                found.append(Frontier(part, centre, CELL_M * len(part)))
        return sorted(found, key=lambda one: -one.size)

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

    def _travel(self, xz: ArrayLike) -> Travel:
        row, column = self.cells(xz).tolist()
        key = (row, column)
        if key not in self._travels:
            self._travels[key] = Travel(self.costs(), key, CELL_M)
        return self._travels[key]


def _around(place_xz: FloatArray, reach_m: float) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Rows and columns of the cells with their middle that near to a place, and of its own."""
    row, column = cells_of(place_xz).tolist()
    reach = math.ceil(reach_m / CELL_M)
    rows = np.arange(max(row - reach, 0), min(row + reach + 1, CELLS))
    columns = np.arange(max(column - reach, 0), min(column + reach + 1, CELLS))
    x, z = ((cells + 0.5) * CELL_M - HALF_M for cells in (columns, rows))
    near = np.hypot(x - place_xz[0], (z - place_xz[1])[:, None]) <= reach_m
    near |= (rows == row)[:, None] & (columns == column)
    down, along = np.nonzero(near)
    return rows[down], columns[along]
