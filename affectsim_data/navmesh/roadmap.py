"""Exact shortest ways on an island: a visibility graph over the corners ways can bend around."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import IntArray
from affectsim_data.poses import FloatArray

__all__ = ["Roadmap", "Sight"]


@dataclasses.dataclass(frozen=True, eq=False)
class Sight:
    """The corners one point sees and a shortest way from it can bend around."""

    corner: IntArray
    """Indices into the roadmap, `(n,)`."""
    distance: FloatArray
    """Metres, `(n,)`."""


@dataclasses.dataclass(frozen=True, eq=False)
class Roadmap:
    """All shortest ways between the reflex corners of an island.

    Ways are shortest on the plan; their lengths are measured between the bends in 3-D.
    """

    island: Island
    corners: FloatArray
    """Reflex corners on the floor, metres, `(n, 3)`."""
    distance: FloatArray
    """Geodesic distances between them, metres, `(n, n)`."""
    came_from: NDArray[np.int32]
    """The corner before `j` on the way from `i`, negative where that is `i` itself, `(n, n)`."""

    @classmethod
    def on(cls, island: Island) -> Roadmap:
        """Builds the graph; quadratic in the number of reflex corners."""
        walls = island.walls
        plan = walls.start[walls.reflex]
        corners = island.on_floor(plan)
        tangent = walls.tangent(plan)
        wanted = np.triu(tangent & tangent.T, 1)
        visible = walls.visible_corners(plan, wanted)
        one, two = np.nonzero(visible)
        length = np.linalg.norm(corners[one] - corners[two], axis=1)
        graph = coo_array((length, (one, two)), shape=visible.shape).tocsr()
        distance, came_from = dijkstra(graph, directed=False, return_predecessors=True)
        return cls(island, corners, distance, came_from)

    def sights(self, points: FloatArray) -> list[Sight]:
        """What each point of the island, `(n, 3)`, sees."""
        walls, plan = self.island.walls, points[:, [0, 2]]
        visible = walls.visible_corners(plan, walls.tangent(plan))
        seen = [np.flatnonzero(row) for row in visible]
        return [
            Sight(corner, np.linalg.norm(self.corners[corner] - point, axis=1))
            for corner, point in zip(seen, points, strict=True)
        ]

    def corner_distances(self, sight: Sight) -> FloatArray:
        """Geodesic distance from a point to every corner, metres, `(n,)`."""
        ways = sight.distance[:, None] + self.distance[sight.corner]
        shortest: FloatArray = np.min(ways, axis=0, initial=np.inf)
        return shortest

    def through(self, start: Sight, end: Sight) -> tuple[float, int, int]:
        """Shortest way over corners: its length, its first and its last corner.

        The length is `inf` and the corners are -1 if there is no corner to go over.
        """
        if not len(start.corner) or not len(end.corner):
            return np.inf, -1, -1
        ways = start.distance[:, None] + self.distance[np.ix_(start.corner, end.corner)]
        ways = ways + end.distance
        best = int(np.argmin(ways))
        first, last = divmod(best, len(end.corner))
        return float(ways.flat[best]), int(start.corner[first]), int(end.corner[last])

    def corner_chain(self, first: int, last: int) -> FloatArray:
        """Corners of the shortest way from corner `first` to `last`, `(n, 3)`."""
        chain = [last]
        while chain[-1] != first:
            chain.append(int(self.came_from[first, chain[-1]]))
        return self.corners[chain[::-1]]
