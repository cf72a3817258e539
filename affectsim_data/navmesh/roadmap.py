"""Exact shortest ways on an island: a visibility graph over the corners ways can bend around."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import IntArray
from affectsim_data.poses import FloatArray

__all__ = ["Roadmap", "Sight", "SightTable"]

# All pairs of more corners than this would take gigabytes.
MAX_CORNERS = 6000
SIGHTS_KEPT = 64


@dataclasses.dataclass(frozen=True, eq=False)
class Sight:
    """The corners one point sees and a shortest way from it can bend around."""

    plan: FloatArray
    """The point `(x, z)`, `(2,)`."""
    corner: IntArray
    """Indices into the roadmap, `(n,)`."""
    distance: FloatArray
    """On the plan, metres, `(n,)`."""


@dataclasses.dataclass(frozen=True, eq=False)
class SightTable:
    """The sights of many points, one after another."""

    point: IntArray
    """Which point, in order, `(k,)`."""
    corner: IntArray
    """Index into the roadmap, `(k,)`."""
    distance: FloatArray
    """On the plan, metres, `(k,)`."""


@dataclasses.dataclass(frozen=True, eq=False)
class Roadmap:
    """All shortest ways between the reflex corners of an island.

    Ways are shortest on the plan; the floor under them gives their length.
    """

    island: Island
    corners: FloatArray
    """Reflex corners `(x, z)`, metres, `(n, 2)`."""
    distance: FloatArray
    """Lengths on the plan between them, metres, `(n, n)`."""
    length: FloatArray
    """Lengths along the floor of these ways, metres, `(n, n)`."""
    came_from: NDArray[np.int32]
    """The corner before `j` on the way from `i`, negative where that is `i` itself, `(n, n)`."""

    @classmethod
    def on(cls, island: Island) -> Roadmap:
        """Builds the graph; quadratic in the number of reflex corners.

        Raises:
            ValueError: There are too many corners.
        """
        walls = island.walls
        corners = walls.start[walls.reflex]
        if len(corners) > MAX_CORNERS:
            raise ValueError(
                f"an island of {island.polygon.area:.0f} m2 has {len(corners)} corners that stick "
                f"out, more than {MAX_CORNERS}; cut the mesh, or use a larger cell_size"
            )
        tangent = walls.tangent(corners)
        wanted = np.triu(tangent & tangent.T, 1)
        visible = island.sight.visible_corners(corners, wanted)
        one, two = np.nonzero(visible)
        leg = np.hypot(*(corners[one] - corners[two]).T)
        graph = coo_array((leg, (one, two)), shape=visible.shape).tocsr()
        distance, came_from = dijkstra(graph, directed=False, return_predecessors=True)
        length = distance
        if not island.is_level:
            rise = np.zeros_like(distance)
            rise[one, two] = island.floor_lengths(corners[one], corners[two]) - leg
            rise = np.maximum(rise, rise.T)
            length = distance + _along_ways(rise, came_from)
        return cls(island, corners, distance, length, came_from)

    @functools.cached_property
    def _kept(self) -> dict[tuple[float, float], Sight]:
        return {}

    def sight(self, x: float, z: float) -> Sight:
        """What a point of the island sees; the last few are kept."""
        found = self._kept.get((x, z))
        if found is None:
            corner = self.island.sight.from_point(x, z)
            plan = np.array([x, z])
            found = Sight(plan, corner, np.hypot(*(self.corners[corner] - plan).T))
            if len(self._kept) >= SIGHTS_KEPT:
                self._kept.clear()
            self._kept[x, z] = found
        return found

    def sight_table(self, plan: FloatArray) -> SightTable:
        """What each point of the island, `(n, 2)`, sees."""
        visible = self.island.sight.visible_corners(plan, self.island.walls.tangent(plan))
        point, corner = np.nonzero(visible)
        return SightTable(point, corner, np.hypot(*(self.corners[corner] - plan[point]).T))

    def corner_distances(self, sight: Sight) -> tuple[FloatArray, IntArray]:
        """Distance on the plan from a point to every corner, metres, and the first bend, `(n,)`.

        Where there is no way the distance is `inf` and the bend means nothing.
        """
        if not len(sight.corner):
            return np.full(len(self.corners), np.inf), np.zeros(len(self.corners), np.int64)
        ways = sight.distance[:, None] + self.distance[sight.corner]
        first = np.argmin(ways, axis=0)
        return ways[first, np.arange(len(self.corners))], sight.corner[first]

    def through(self, start: Sight, end: Sight) -> tuple[float, int, int]:
        """Shortest way over corners: its length, its first and its last corner.

        The length is `inf` and the corners are -1 if there is no corner to go over.
        """
        if not len(start.corner) or not len(end.corner):
            return np.inf, -1, -1
        ways = self.distance[start.corner[:, None], end.corner]
        ways += start.distance[:, None]
        ways += end.distance
        best = int(ways.argmin())
        one, two = divmod(best, len(end.corner))
        first, last = int(start.corner[one]), int(end.corner[two])
        if self.island.is_level:
            return float(ways.flat[best]), first, last
        return self.length_between(start.plan, first, last, end.plan), first, last

    def length_between(self, start: FloatArray, first: int, last: int, end: FloatArray) -> float:
        """Length along the floor from a point `(2,)` over two corners to another, metres."""
        legs = self.island.floor_lengths(
            np.stack([start, self.corners[last]]), np.stack([self.corners[first], end])
        )
        return float(legs[0] + self.length[first, last] + legs[1])

    def corner_chain(self, first: int, last: int) -> FloatArray:
        """Corners `(x, z)` of the shortest way from corner `first` to `last`, `(n, 2)`."""
        chain = [last]
        while chain[-1] != first:
            chain.append(int(self.came_from[first, chain[-1]]))
        return self.corners[chain[::-1]]


def _along_ways(rise: FloatArray, came_from: NDArray[np.int32]) -> FloatArray:
    """Sums a value of legs, `(n, n)`, over the ways of a shortest-way matrix, `(n, n)`.

    Pointers are doubled, so the work grows with the logarithm of the number of bends.
    """
    row = np.arange(len(rise))[:, None]
    before = came_from.astype(np.int64)
    has_leg = before >= 0
    before = np.where(has_leg, before, row)
    total = np.where(has_leg, rise[before, np.arange(len(rise))], 0.0)
    while np.any(before != row):
        total = total + total[row, before]
        before = before[row, before]
    return total
