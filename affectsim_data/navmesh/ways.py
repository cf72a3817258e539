"""Lengths of many shortest ways on one island at once."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np

from affectsim_data.navmesh.rasterize import IntArray
from affectsim_data.navmesh.roadmap import Roadmap, SightTable
from affectsim_data.poses import FloatArray

__all__ = ["Reach", "pair_lengths", "reach_of"]

PAIRS_PER_CHUNK = 1 << 14
ENTRIES_PER_CHUNK = 1 << 21


@dataclasses.dataclass(frozen=True, eq=False)
class Reach:
    """Shortest ways from points to all corners of a roadmap."""

    plan: FloatArray
    """The points `(x, z)`, `(n, 2)`."""
    distance: FloatArray
    """On the plan, metres, `(n, num_corners)`; `inf` where there is no way."""
    first: IntArray
    """First bend, `(n, num_corners)`; means nothing where there is no way."""
    first_leg: FloatArray
    """Length along the floor to that bend, metres, `(n, num_corners)`."""

    def lengths(self, roadmap: Roadmap, point: IntArray, corner: IntArray) -> FloatArray:
        """Lengths along the floor from some points to some corners, metres, like `point`."""
        along: FloatArray = (
            self.first_leg[point, corner] + roadmap.length[self.first[point, corner], corner]
        )
        return along


def pair_lengths(
    roadmap: Roadmap, starts: FloatArray, ends: FloatArray, from_: IntArray, to: IntArray
) -> FloatArray:
    """Lengths along the floor of shortest ways between pairs of points, metres, `(k,)`.

    Args:
        roadmap: Of the island all points lie on.
        starts: Points `(x, z)`, `(n, 2)`.
        ends: Points `(x, z)`, `(m, 2)`.
        from_: Which start, `(k,)`.
        to: Which end, `(k,)`.
    """
    length = np.full(len(from_), np.inf)
    blocked = roadmap.island.walls.blocked(starts[from_], ends[to])
    straight = np.flatnonzero(~blocked)
    length[straight] = roadmap.island.floor_lengths(starts[from_[straight]], ends[to[straight]])
    hidden = np.flatnonzero(blocked)
    if not len(hidden) or not len(roadmap.corners):
        return length
    used, start_of = np.unique(from_[hidden], return_inverse=True)
    reach = reach_of(roadmap, starts[used])
    table = roadmap.sight_table(ends)
    last_leg = roadmap.island.floor_lengths(roadmap.corners[table.corner], ends[table.point])
    first_entry, num_entries = _runs(table, len(ends))
    for low in range(0, len(hidden), PAIRS_PER_CHUNK):
        part = slice(low, low + PAIRS_PER_CHUNK)
        pair, start, end = hidden[part], start_of[part], to[hidden[part]]
        entry, row = _spread(first_entry[end], num_entries[end])
        way = reach.distance[start[row], table.corner[entry]] + table.distance[entry]
        best, found = _first_smallest(way, row, len(pair))
        last = entry[best]
        along = reach.lengths(roadmap, start[found], table.corner[last]) + last_leg[last]
        length[pair[found]] = along
    return length


def reach_of(roadmap: Roadmap, plan: FloatArray) -> Reach:
    """Ways from points `(x, z)` of the island, `(n, 2)`, to every corner."""
    shape = (len(plan), len(roadmap.corners))
    distance, first = np.full(shape, np.inf), np.zeros(shape, np.int64)
    first_leg = np.zeros(shape)
    table = roadmap.sight_table(plan)
    leg = roadmap.island.floor_lengths(plan[table.point], roadmap.corners[table.corner])
    for part in _chunks(table, shape[1]):
        corner = table.corner[part]
        ways = table.distance[part, None] + roadmap.distance[corner]
        start = np.flatnonzero(np.diff(table.point[part], prepend=-1))
        point = table.point[part][start]
        shortest = np.minimum.reduceat(ways, start, axis=0)
        size = np.diff(np.append(start, len(corner)))
        index = np.arange(len(corner))[:, None]
        is_best = ways == np.repeat(shortest, size, axis=0)
        best = np.minimum.reduceat(np.where(is_best, index, len(corner)), start, axis=0)
        best = np.minimum(best, len(corner) - 1)
        distance[point], first[point] = shortest, corner[best]
        first_leg[point] = leg[part][best]
    return Reach(plan, distance, first, first_leg)


def _chunks(table: SightTable, num_corners: int) -> Iterator[slice]:
    """Runs of whole points of a table, small enough for a row of all corners per entry."""
    starts = np.flatnonzero(np.diff(table.point, prepend=-1))
    group = starts * num_corners // ENTRIES_PER_CHUNK
    bounds = [*starts[np.flatnonzero(np.diff(group, prepend=-1))].tolist(), len(table.point)]
    for low, high in itertools.pairwise(bounds):
        yield slice(low, high)


def _runs(table: SightTable, num_points: int) -> tuple[IntArray, IntArray]:
    """First entry and number of entries of every point."""
    count = np.bincount(table.point, minlength=num_points)
    return np.cumsum(count) - count, count


def _spread(first: IntArray, count: IntArray) -> tuple[IntArray, IntArray]:
    """Indices of runs one after another, and the run each belongs to."""
    row = np.repeat(np.arange(len(count)), count)
    return np.arange(len(row)) - (np.cumsum(count) - count)[row] + first[row], row


def _first_smallest(value: FloatArray, row: IntArray, num_rows: int) -> tuple[IntArray, IntArray]:
    """Index of the smallest finite value of each row that has one, and these rows."""
    smallest = np.full(num_rows, np.inf)
    start = np.flatnonzero(np.diff(row, prepend=-1))
    if len(start):
        smallest[row[start]] = np.minimum.reduceat(value, start)
    at = np.flatnonzero((value == smallest[row]) & np.isfinite(value))
    found, first = np.unique(row[at], return_index=True)
    return at[first], found
