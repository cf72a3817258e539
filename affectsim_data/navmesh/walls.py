"""Straight lines against walls: what sees what on an island, and where a move is stopped.

All tests use signed areas of the stored corners, so that two edges agree on which side of a line
their common corner lies. A line that only touches a corner may count as blocked: the way over that
corner has the same length.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from scipy.spatial import KDTree

from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.poses import FloatArray

__all__ = ["ON_WALL_M", "Walls"]

# Closer than this a point lies on the wall, metres; far above float64 noise, far below a cell.
ON_WALL_M = 1e-7
# Slack of the side of a corner's neighbours where a way bends around it; metres.
TANGENT_M = 1e-9
TURN = 2.0 * np.pi
# Spacing of sort keys that put one source's angles, which lie in [-pi, 3 pi], after another's.
KEY_STRIDE = 16.0
# Angles an edge covers are widened by this before the exact test; radians.
ANGLE_SLACK = 1e-5
PAIRS_PER_CHUNK = 1 << 19


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Signed area between plan vectors, `(..., 2)`; positive if `b` is left of `a`."""
    area: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return area


@dataclasses.dataclass(frozen=True, eq=False)
class Walls:
    """Edges of an island. Edge `i` leaves corner `i`; the free side is on its left."""

    start: FloatArray
    """Corners `(x, z)`, metres, `(num_edges, 2)`."""
    end: FloatArray
    """The next corner of the ring, `(num_edges, 2)`."""
    previous: IntArray
    """Index of the corner before, `(num_edges,)`."""
    following: IntArray
    """Index of the corner after, `(num_edges,)`."""
    length: FloatArray
    """Metres, `(num_edges,)`."""
    is_reflex: BoolArray
    """Corners a shortest way can bend around, `(num_edges,)`."""
    reflex: IntArray
    """Their indices, `(num_reflex,)`."""

    @classmethod
    def from_rings(cls, rings: list[FloatArray]) -> Walls:
        """Edges of rings, `(n, 2)` each, that have the free side on their left."""
        start = np.concatenate(rings)
        sizes = [len(ring) for ring in rings]
        base = np.cumsum([0, *sizes[:-1]])
        following = np.concatenate(
            [b + np.roll(np.arange(n), -1) for b, n in zip(base, sizes, strict=True)]
        )
        previous = np.empty_like(following)
        previous[following] = np.arange(len(start))
        end = start[following]
        length = np.linalg.norm(end - start, axis=1)
        is_reflex = cross(start - start[previous], end - start) < 0.0
        return cls(start, end, previous, following, length, is_reflex, np.flatnonzero(is_reflex))

    @functools.cached_property
    def _corner_tree(self) -> KDTree:
        return KDTree(self.start)

    def project(self, plan: FloatArray, edge: IntArray) -> FloatArray:
        """Point of one edge each nearest to `(x, z)`, `(n, 2)`."""
        a, b = self.start[edge], self.end[edge]
        share = np.sum((plan - a) * (b - a), axis=1) / self.length[edge] ** 2
        share = np.clip(share, 0.0, 1.0)[:, None]
        # This form gives the corners themselves at 0 and 1.
        projected: FloatArray = (1.0 - share) * a + share * b
        return projected

    def tangent(self, sources: FloatArray) -> BoolArray:
        """Whether a shortest way from `sources`, `(n, 2)`, can bend at reflex corners, `(n, m)`.

        It can where both walls of the corner lie on one side of the line.
        """
        corner = self.start[self.reflex]
        line = corner - sources[:, None]
        slack = TANGENT_M * np.linalg.norm(line, axis=-1)
        before = cross(line, self.start[self.previous[self.reflex]] - corner)
        after = cross(line, self.end[self.reflex] - corner)
        tangent: BoolArray = (np.minimum(before, after) >= -slack) | (
            np.maximum(before, after) <= slack
        )
        return tangent

    def corner_at(self, plan: FloatArray) -> IntArray:
        """Corner each point `(x, z)`, `(n, 2)`, lies on, `(n,)`; -1 for none."""
        distance, corner = self._corner_tree.query(plan)
        found: IntArray = np.where(distance <= ON_WALL_M, corner, -1)
        return found

    def leaves_freely(self, corner: IntArray, way: FloatArray) -> BoolArray:
        """Whether `way`, `(..., 2)`, leaves a corner, `(...)`, to its free side or along a wall."""
        slack = -TANGENT_M * np.linalg.norm(way, axis=-1)
        before = self.start[corner] - self.start[self.previous[corner]]
        left = cross(before, way) >= slack * self.length[self.previous[corner]]
        right = cross(self.end[corner] - self.start[corner], way) >= slack * self.length[corner]
        freely: BoolArray = np.where(self.is_reflex[corner], left | right, left & right)
        return freely

    def blocked(self, sources: FloatArray, targets: FloatArray) -> BoolArray:
        """Whether a wall lies between points `(x, z)`, `(n, 2)` each, `(n,)`.

        The sources are on the island; a target off the island is blocked.
        """
        corner = self.corner_at(sources)
        blocked = (corner >= 0) & ~self.leaves_freely(corner, targets - sources)
        rows = max(1, PAIRS_PER_CHUNK // len(self.start))
        for low in range(0, len(sources), rows):
            part = slice(low, low + rows)
            stops = self._stops(sources[part, None], targets[part, None], slice(None))
            self._clear_own_walls(stops, corner[part])
            blocked[part] |= np.any(stops, axis=1)
        return blocked

    def _clear_own_walls(self, table: BoolArray, corner: IntArray) -> None:
        """Clears the walls that meet at the source of each row, `(n, num_edges)`, in place."""
        row = np.flatnonzero(corner >= 0)
        table[row, corner[row]] = False
        table[row, self.previous[corner[row]]] = False

    def _stops(self, source: FloatArray, target: FloatArray, edge: IntArray | slice) -> BoolArray:
        """Whether edges stop a way that starts on their free side and ends behind them."""
        a, b, length = self.start[edge], self.end[edge], self.length[edge]
        along, way = b - a, target - source
        leaves = (cross(along, source - a) > -ON_WALL_M * length) & (
            cross(along, target - a) < -ON_WALL_M * length
        )
        # In a corner that does not stick out there is no way past an edge's end, so there edges
        # reach a little further: nothing slips out where a line of sight meets the very corner.
        reach = 2.0 * ON_WALL_M * np.linalg.norm(way, axis=-1)
        end_is_reflex = self.is_reflex[self.following[edge]]
        to_start, to_end = cross(way, a - source), cross(way, b - source)
        crosses = (to_start < np.where(self.is_reflex[edge], 0.0, reach)) & (
            to_end >= np.where(end_is_reflex, 0.0, -reach)
        )
        stops: BoolArray = crosses & leaves
        return stops

    def visible_corners(self, sources: FloatArray, wanted: BoolArray) -> BoolArray:
        """Which wanted reflex corners are in sight, `(n, num_reflex)`.

        Args:
            sources: Points of the island, `(n, 2)`.
            wanted: Corners to look at, from `tangent`, `(n, num_reflex)`.
        """
        visible = np.zeros_like(wanted)
        corner = self.corner_at(sources)
        rows = max(1, PAIRS_PER_CHUNK // len(self.start))
        for low in range(0, len(sources), rows):
            part = slice(low, low + rows)
            visible[part] = self._visible(sources[part], wanted[part], corner[part])
        return visible

    def _visible(
        self, sources: FloatArray, wanted: BoolArray, source_corner: IntArray
    ) -> BoolArray:
        """Compares each edge only with the targets in the angle it covers."""
        row, column = np.nonzero(wanted)
        target = self.start[self.reflex[column]]
        way = target - sources[row]
        key = KEY_STRIDE * row + np.arctan2(way[:, 1], way[:, 0])
        order = np.argsort(np.concatenate([key, key + TURN]))
        keys = np.concatenate([key, key + TURN])[order]
        order %= max(len(key), 1)
        source, edge, low, high = self._facing(sources, source_corner)
        first = np.searchsorted(keys, KEY_STRIDE * source + low - ANGLE_SLACK)
        count = np.searchsorted(keys, KEY_STRIDE * source + high + ANGLE_SLACK) - first
        pair = np.repeat(np.arange(len(edge)), count)
        offset = np.arange(len(pair)) - np.repeat(np.cumsum(count) - count, count)
        candidate = order[first[pair] + offset]
        stops = self._stops(sources[source[pair]], target[candidate], edge[pair])
        hidden = (source_corner[row] >= 0) & ~self.leaves_freely(source_corner[row], way)
        hidden[candidate[stops]] = True
        visible = np.zeros_like(wanted)
        visible[row[~hidden], column[~hidden]] = True
        return visible

    def _facing(
        self, sources: FloatArray, source_corner: IntArray
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Source, edge, and the range of angles of every edge whose free side a source sees."""
        to_start = self.start - sources[:, None]
        to_end = to_start[:, self.following]
        facing = cross(to_start, to_end) > -ON_WALL_M * self.length
        self._clear_own_walls(facing, source_corner)
        angle = np.arctan2(to_start[..., 1], to_start[..., 0])
        width = np.mod(angle[:, self.following] - angle, TURN)
        # Seen edge on, from its own line beyond an end, noise can turn 0 into a full turn.
        source, edge = np.nonzero(facing & (width < 0.75 * TURN))
        low = angle[source, edge]
        return source, edge, low, low + width[source, edge]

    def first_hit(self, source: FloatArray, target: FloatArray) -> float:
        """Share of the way from `source` on the island to `target`, `(2,)`, before a wall."""
        along = self.end - self.start
        here, there = cross(along, source - self.start), cross(along, target - self.start)
        share = np.clip(here / np.where(here > there, here - there, 1.0), 0.0, 1.0)
        hit = self._stops(source, target, slice(None))
        corner = self.corner_at(source[None])
        if corner[0] >= 0:
            if not self.leaves_freely(corner, target - source)[0]:
                return 0.0
            self._clear_own_walls(hit[None], corner)
        return float(np.min(share[hit], initial=1.0))
