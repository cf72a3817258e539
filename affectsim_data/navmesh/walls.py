"""Straight lines against the walls of an island: what they block, and where they stop a move.

All tests use signed areas of the stored corners, so that two edges agree on which side of a line
their common corner lies. A line that only touches a corner may count as blocked: the way over that
corner has the same length.
"""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from scipy.spatial import KDTree

from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.poses import FloatArray

__all__ = ["ON_WALL_M", "Columns", "Walls"]

# Closer than this a point lies on the wall, metres; far above float64 noise, far below a cell.
ON_WALL_M = 1e-7
# Slack of the side of a corner's neighbours where a way bends around it; metres.
TANGENT_M = 1e-9
PAIRS_PER_CHUNK = 1 << 19

PlanPoint = tuple[float, float] | FloatArray


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Signed area between plan vectors, `(..., 2)`; positive if `b` is left of `a`."""
    area: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return area


@dataclasses.dataclass(frozen=True, eq=False)
class Columns:
    """Edges from `a` to `b`, one array per coordinate: fast against a single point."""

    ax: FloatArray
    az: FloatArray
    bx: FloatArray
    bz: FloatArray
    dx: FloatArray
    dz: FloatArray
    length: FloatArray
    """Metres, `(num_edges,)` like all."""
    slack: FloatArray
    """Signed areas this small count as on the edge's line."""
    start_reach: FloatArray
    """How far an edge reaches beyond its start; metres off the line of sight."""
    end_reach: FloatArray
    """How far beyond its end; negative."""

    def taken(self, edge: IntArray) -> Columns:
        """Some of the edges."""
        return Columns(*(getattr(self, field.name)[edge] for field in dataclasses.fields(self)))


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

    @functools.cached_property
    def columns(self) -> Columns:
        """Its edges as one array per coordinate."""
        start, end = np.ascontiguousarray(self.start.T), np.ascontiguousarray(self.end.T)
        along = end - start
        follows = self.is_reflex[self.following]
        return Columns(
            *(start[0], start[1], end[0], end[1], along[0], along[1]),
            length=self.length,
            slack=ON_WALL_M * self.length,
            start_reach=np.where(self.is_reflex, 0.0, 2.0 * ON_WALL_M),
            end_reach=np.where(follows, 0.0, -2.0 * ON_WALL_M),
        )

    def project(self, plan: FloatArray, edge: IntArray) -> FloatArray:
        """Point of one edge each nearest to `(x, z)`, `(n, 2)`."""
        a, b = self.start[edge], self.end[edge]
        share = np.sum((plan - a) * (b - a), axis=1) / self.length[edge] ** 2
        share = np.clip(share, 0.0, 1.0)[:, None]
        # This form gives the corners themselves at 0 and 1.
        projected: FloatArray = (1.0 - share) * a + share * b
        return projected

    def nearest(self, x: float, z: float) -> tuple[float, float, float]:
        """The point `(x, z)` of the walls nearest to a point, and its distance, metres."""
        w = self.columns
        share = ((x - w.ax) * w.dx + (z - w.az) * w.dz) / (w.length * w.length)
        share = np.minimum(np.maximum(share, 0.0), 1.0)
        rest = 1.0 - share
        to_x, to_z = rest * w.ax + share * w.bx, rest * w.az + share * w.bz
        distance2 = (to_x - x) ** 2 + (to_z - z) ** 2
        edge = int(np.argmin(distance2))
        return float(to_x[edge]), float(to_z[edge]), math.sqrt(float(distance2[edge]))

    def tangent(self, sources: FloatArray) -> BoolArray:
        """Whether a shortest way from `sources`, `(n, 2)`, can bend at reflex corners, `(n, m)`.

        It can where both walls of the corner lie on one side of the line.
        """
        corner = self.start[self.reflex]
        line = corner - sources[:, None]
        return self.bends(np.arange(len(self.reflex)), line)

    def bends(self, reflex: IntArray, line: FloatArray) -> BoolArray:
        """Whether a shortest way along `line`, `(..., n, 2)`, can bend at reflex corners, `(n,)`.

        Args:
            reflex: Which of the reflex corners, `(n,)`.
            line: Along the way, from or to the corner.
        """
        w, corner = self.columns, self.reflex[reflex]
        before = self.previous[corner]
        x, z = line[..., 0], line[..., 1]
        slack = TANGENT_M * np.hypot(x, z)
        into = z * w.dx[before] - x * w.dz[before]
        out = x * w.dz[corner] - z * w.dx[corner]
        tangent: BoolArray = (np.minimum(into, out) >= -slack) | (np.maximum(into, out) <= slack)
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

    def blocked(
        self, sources: FloatArray, targets: FloatArray, corner: IntArray | None = None
    ) -> BoolArray:
        """Whether a wall lies between points `(x, z)`, `(n, 2)` each, `(n,)`.

        Args:
            sources: On the island.
            targets: Anywhere; one off the island is blocked.
            corner: As `corner_at` of the sources, where it is known.
        """
        corner = self.corner_at(sources) if corner is None else corner
        blocked = (corner >= 0) & ~self.leaves_freely(corner, targets - sources)
        rows = max(1, PAIRS_PER_CHUNK // len(self.start))
        for low in range(0, len(sources), rows):
            part = slice(low, low + rows)
            # Copies, because steps over interleaved coordinates are slow.
            start, end = (np.ascontiguousarray(p[part].T) for p in (sources, targets))
            stops = self.stops(start[..., None], end[..., None])
            self.clear_own_walls(stops, corner[part])
            blocked[part] |= np.any(stops, axis=1)
        return blocked

    def clear_own_walls(self, table: BoolArray, corner: IntArray) -> None:
        """Clears the walls that meet at the source of each row, `(n, num_edges)`, in place."""
        row = np.flatnonzero(corner >= 0)
        table[row, corner[row]] = False
        table[row, self.previous[corner[row]]] = False

    def stops(
        self, source: PlanPoint, target: PlanPoint, edge: IntArray | None = None
    ) -> BoolArray:
        """Whether edges stop a way that starts on their free side and ends behind them.

        Args:
            source: x and z, numbers or arrays, broadcast against the edges.
            target: Alike.
            edge: Which edges; all of them if not given.
        """
        w = self.columns if edge is None else self.columns.taken(edge)
        (x, z), (to_x, to_z) = source, target
        way_x, way_z = to_x - x, to_z - z
        # In a corner that does not stick out there is no way past an edge's end, so there edges
        # reach a little further: nothing slips out where a line of sight meets the very corner.
        reach = np.hypot(way_x, way_z)
        stops: BoolArray = way_x * (w.az - z) - way_z * (w.ax - x) < w.start_reach * reach
        stops &= way_x * (w.bz - z) - way_z * (w.bx - x) >= w.end_reach * reach
        stops &= w.dx * (z - w.az) - w.dz * (x - w.ax) > -w.slack
        stops &= w.dx * (to_z - w.az) - w.dz * (to_x - w.ax) < -w.slack
        return stops

    def first_hit(self, x: float, z: float, to_x: float, to_z: float) -> float:
        """Share of the way from `(x, z)` on the island to another point before a wall."""
        edge = self._hits(x, z, to_x, to_z)
        if edge is None:
            return 0.0
        if not len(edge):
            return 1.0
        w = self.columns
        here = w.dx[edge] * (z - w.az[edge]) - w.dz[edge] * (x - w.ax[edge])
        there = w.dx[edge] * (to_z - w.az[edge]) - w.dz[edge] * (to_x - w.ax[edge])
        share = here / np.where(here > there, here - there, 1.0)
        return min(max(float(share.min()), 0.0), 1.0)

    def blocks(
        self, x: float, z: float, to_x: float, to_z: float, edge: IntArray | None = None
    ) -> bool:
        """`blocked` for one way, by some edges or by all."""
        hits = self._hits(x, z, to_x, to_z, edge)
        return hits is None or len(hits) > 0

    def _hits(
        self, x: float, z: float, to_x: float, to_z: float, edge: IntArray | None = None
    ) -> IntArray | None:
        """Edges that stop a way; `None` if it leaves the corner it starts from into a wall."""
        hit = np.flatnonzero(self.stops((x, z), (to_x, to_z), edge))
        hit = hit if edge is None else edge[hit]
        corner = self.corner_here(x, z)
        if corner >= 0:
            if not self.leaves_freely(np.array([corner]), np.array([[to_x - x, to_z - z]]))[0]:
                return None
            hit = hit[(hit != corner) & (hit != self.previous[corner])]
        return hit

    def corner_here(self, x: float, z: float) -> int:
        """Corner the point `(x, z)` lies on, -1 for none."""
        w = self.columns
        distance2 = (w.ax - x) ** 2 + (w.az - z) ** 2
        corner = int(np.argmin(distance2))
        return corner if distance2[corner] <= ON_WALL_M**2 else -1
