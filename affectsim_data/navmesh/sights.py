"""Which corners a point of an island sees: what shortest ways from it can bend around.

Many points at once compare each edge only with the corners in the angle it covers. One point alone
compares all corners with all edges: fewer, simpler operations, faster below a thousand corners.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.navmesh.walls import ON_WALL_M, PAIRS_PER_CHUNK, TANGENT_M, Walls, cross
from affectsim_data.poses import FloatArray

__all__ = ["CornerSight"]

TURN = 2.0 * np.pi
# Spacing of sort keys that put one source's angles, which lie in [-pi, 3 pi], after another's.
KEY_STRIDE = 16.0
# Angles an edge covers are widened by this before the exact test; radians.
ANGLE_SLACK = 1e-5
# Beyond this many pairs of corner and edge, one point is treated like many.
MAX_PAIRS = 1 << 21


@dataclasses.dataclass(frozen=True, eq=False)
class CornerSight:
    """Lines of sight between points of an island and its reflex corners."""

    walls: Walls
    """Of the island."""

    def from_point(self, x: float, z: float) -> IntArray:
        """Which reflex corners a shortest way from a point can bend around next, `(k,)`."""
        walls = self.walls
        if len(walls.reflex) * len(walls.start) > MAX_PAIRS:
            source = np.array([[x, z]])
            return np.flatnonzero(self.visible_corners(source, walls.tangent(source))[0])
        table, w = self._table, walls.columns
        to_x, to_z = table.x - x, table.z - z
        way_x, way_z = to_x[table.reflex], to_z[table.reflex]
        reach = np.hypot(way_x, way_z)
        slack = TANGENT_M * reach
        into = way_z * table.in_x - way_x * table.in_z
        out = way_x * table.out_z - way_z * table.out_x
        tangent = (np.minimum(into, out) >= -slack) | (np.maximum(into, out) <= slack)
        corner = walls.corner_here(x, z)
        if corner >= 0:
            way = np.stack([way_x, way_z], axis=1)
            tangent &= walls.leaves_freely(np.full(len(way), corner), way)
        wanted = np.flatnonzero(tangent)
        way_x, way_z, reach = way_x[wanted, None], way_z[wanted, None], reach[wanted, None]
        side = way_x * to_z - way_z * to_x
        stops = side[:, :-1] < reach * table.start_reach
        stops &= side[:, 1:] >= reach * table.end_reach
        stops &= table.behind[wanted]
        facing = np.zeros(len(table.x) - 1, bool)
        facing[table.edge] = w.dx * (z - w.az) - w.dz * (x - w.ax) > -w.slack
        if corner >= 0:
            facing[table.edge[[corner, walls.previous[corner]]]] = False
        seen: IntArray = wanted[~np.any(stops & facing, axis=1)]
        return seen

    @functools.cached_property
    def _table(self) -> _Table:
        return _Table.of(self.walls)

    def visible_corners(self, sources: FloatArray, wanted: BoolArray) -> BoolArray:
        """Which wanted reflex corners are in sight, `(n, num_reflex)`.

        Args:
            sources: Points of the island, `(n, 2)`.
            wanted: Corners to look at, from `tangent`, `(n, num_reflex)`.
        """
        visible = np.zeros_like(wanted)
        corner = self.walls.corner_at(sources)
        rows = max(1, PAIRS_PER_CHUNK // len(self.walls.start))
        for low in range(0, len(sources), rows):
            part = slice(low, low + rows)
            visible[part] = self._visible(sources[part], wanted[part], corner[part])
        return visible

    def _visible(
        self, sources: FloatArray, wanted: BoolArray, source_corner: IntArray
    ) -> BoolArray:
        """Compares each edge only with the targets in the angle it covers."""
        row, column = np.nonzero(wanted)
        target = self.walls.start[self.walls.reflex[column]]
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
        stops = self.walls.stops(sources[source[pair]].T, target[candidate].T, edge[pair])
        hidden = (source_corner[row] >= 0) & ~self.walls.leaves_freely(source_corner[row], way)
        hidden[candidate[stops]] = True
        visible = np.zeros_like(wanted)
        visible[row[~hidden], column[~hidden]] = True
        return visible

    def _facing(
        self, sources: FloatArray, source_corner: IntArray
    ) -> tuple[IntArray, IntArray, FloatArray, FloatArray]:
        """Source, edge, and the range of angles of every edge whose free side a source sees."""
        to_start = self.walls.start - sources[:, None]
        to_end = to_start[:, self.walls.following]
        facing = cross(to_start, to_end) > -ON_WALL_M * self.walls.length
        self.walls.clear_own_walls(facing, source_corner)
        angle = np.arctan2(to_start[..., 1], to_start[..., 0])
        width = np.mod(angle[:, self.walls.following] - angle, TURN)
        # Seen edge on, from its own line beyond an end, noise can turn 0 into a full turn.
        source, edge = np.nonzero(facing & (width < 0.75 * TURN))
        low = angle[source, edge]
        return source, edge, low, low + width[source, edge]


@dataclasses.dataclass(frozen=True, eq=False)
class _Table:
    """Corners in the order of their rings, each ring closed by its first corner.

    Edge `i` goes from column `i` to column `i + 1`; edges from one ring to the next are never
    facing anybody.
    """

    x: FloatArray
    z: FloatArray
    reflex: IntArray
    """Column of each reflex corner, `(num_reflex,)`."""
    edge: IntArray
    """Column of each edge of the walls, `(num_edges,)`."""
    in_x: FloatArray
    """Along the edge before each reflex corner, `(num_reflex,)`."""
    in_z: FloatArray
    out_x: FloatArray
    """Along the edge after it."""
    out_z: FloatArray
    start_reach: FloatArray
    end_reach: FloatArray
    behind: BoolArray
    """Which reflex corners lie behind which edges, `(num_reflex, num_columns - 1)`."""

    @classmethod
    def of(cls, walls: Walls) -> _Table:
        w, count = walls.columns, len(walls.start)
        # A ring ends where the next corner is not the next in order.
        last = walls.following != np.arange(count) + 1
        edge = np.arange(count) + np.concatenate([[0], np.cumsum(last)[:-1]])
        num_columns = count + int(last.sum())
        x, z = np.empty(num_columns), np.empty(num_columns)
        x[edge], z[edge] = w.ax, w.az
        x[edge[last] + 1], z[edge[last] + 1] = w.bx[last], w.bz[last]
        reach = np.zeros((2, num_columns - 1))
        reach[0, edge], reach[1, edge] = w.start_reach, w.end_reach
        behind = np.zeros((len(walls.reflex), num_columns - 1), bool)
        target = walls.start[walls.reflex].T[..., None]
        behind[:, edge] = w.dx * (target[1] - w.az) - w.dz * (target[0] - w.ax) < -w.slack
        before, after = walls.previous[walls.reflex], walls.reflex
        return cls(
            *(x, z, edge[walls.reflex], edge),
            *(w.dx[before], w.dz[before], w.dx[after], w.dz[after]),
            *(reach[0], reach[1], behind),
        )
