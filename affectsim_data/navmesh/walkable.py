"""Solid spans to islands: connected cells where an agent of given size can stand.

The second half of Recast's voxel pipeline: filters (low-hanging steps, ledges, headroom), links
between neighbours, and erosion by the agent's radius with Recast's 2-3 chamfer distance. A
Euclidean distance would open gaps that Recast closes.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from affectsim_data.navmesh.rasterize import BoolArray, Grid, IntArray, Spans
from affectsim_data.poses import FloatArray

__all__ = ["Agent", "Cells", "walkable_cells"]

SKY = 1 << 30


@dataclasses.dataclass(frozen=True)
class Agent:
    """Size of an agent, in cells and levels."""

    radius: int
    """Cells."""
    height: int
    """Levels."""
    climb: int
    """Levels."""


@dataclasses.dataclass(frozen=True)
class Cells:
    """Floor an agent's middle can stand on, split into connected islands, largest first."""

    x: IntArray
    """Column along x, `(num_cells,)`."""
    z: IntArray
    """Column along z, `(num_cells,)`."""
    y: FloatArray
    """Height of the floor, metres, `(num_cells,)`."""
    island: IntArray
    """Island of each cell, counted from 0, `(num_cells,)`."""


@dataclasses.dataclass(frozen=True)
class _Gaps:
    """Free runs of levels with headroom, sorted by column, then from below.

    Columns here have a border of one around the grid, so that every column has neighbours.
    """

    column: IntArray
    floor: IntArray
    ceiling: IntArray
    walkable: BoolArray
    y: FloatArray
    first: IntArray
    """First gap of each column, `(num_columns + 1,)`."""
    stride: int
    """Columns in a row."""

    @property
    def steps(self) -> tuple[int, int, int, int]:
        """Column offsets of the four neighbours, in order around a cell."""
        return (1, self.stride, -1, -self.stride)


def walkable_cells(spans: Spans, grid: Grid, agent: Agent, *, min_island_cells: int) -> Cells:
    """Cells where an agent fits, without islands smaller than `min_island_cells`.

    There may be none; storeys of one island may overlap, which `Cells` shows as repeated columns.
    """
    gaps = _gaps(spans, grid, agent)
    stand = np.flatnonzero(gaps.walkable & (gaps.ceiling - gaps.floor > agent.height))
    stand = stand[~_is_ledge(gaps, stand, agent)]
    links = _links(gaps, stand, agent)
    kept = _wall_distance(links, agent.radius) >= 2 * agent.radius
    island = _islands(links, kept, min_island_cells)
    chosen = island >= 0
    z, x = np.divmod(gaps.column[stand[chosen]], gaps.stride)
    return Cells(x - 1, z - 1, gaps.y[stand[chosen]], island[chosen])


def _gaps(spans: Spans, grid: Grid, agent: Agent) -> _Gaps:
    stride = grid.width + 2
    num_columns = stride * (grid.depth + 2)
    z, x = np.divmod(spans.column, grid.width)
    column = (z + 1) * stride + x + 1
    same_column = column[1:] == column[:-1]
    above = np.append(np.where(same_column, spans.bottom[1:], SKY), SKY)
    # A step just above a walkable surface, such as a kerb, can be climbed.
    near = same_column & (spans.top[1:] - spans.top[:-1] <= agent.climb)
    walkable = spans.walkable.copy()
    walkable[1:] |= near & spans.walkable[:-1]
    # Below the lowest span, and where there is none, lies a void one falls into.
    void_ceiling = np.full(num_columns, SKY)
    lowest = np.concatenate([[True], ~same_column])
    void_ceiling[column[lowest]] = spans.bottom[lowest]
    floor = np.concatenate([np.full(num_columns, -agent.climb), spans.top])
    ceiling = np.concatenate([void_ceiling, above])
    everything = np.concatenate([np.arange(num_columns), column])
    stands = np.concatenate([np.zeros(num_columns, bool), walkable])
    y = np.concatenate([np.zeros(num_columns), spans.surface_y])
    room = np.flatnonzero(ceiling - floor >= agent.height)
    room = room[np.argsort(everything[room], kind="stable")]
    count = np.bincount(everything[room], minlength=num_columns)
    first = np.concatenate([[0], np.cumsum(count)])
    return _Gaps(everything[room], floor[room], ceiling[room], stands[room], y[room], first, stride)


def _is_ledge(gaps: _Gaps, stand: IntArray, agent: Agent) -> BoolArray:
    """Whether a neighbour drops by more than a step, or the slope over it is too steep."""
    floor, ceiling, column = gaps.floor[stand], gaps.ceiling[stand], gaps.column[stand]
    drop = np.zeros(len(stand), np.int64)
    lowest, highest = drop.copy(), drop.copy()
    for step in gaps.steps:
        start, end = gaps.first[column + step], gaps.first[column + step + 1]
        for k in range(int(np.max(end - start, initial=0))):
            other = np.minimum(start + k, len(gaps.floor) - 1)
            shared = np.minimum(ceiling, gaps.ceiling[other]) - np.maximum(floor, gaps.floor[other])
            passable = (start + k < end) & (shared > agent.height)
            rise = np.where(passable, gaps.floor[other] - floor, 0)
            drop = np.minimum(drop, rise)
            near = np.where(np.abs(rise) <= agent.climb, rise, 0)
            lowest, highest = np.minimum(lowest, near), np.maximum(highest, near)
    ledge: BoolArray = (drop < -agent.climb) | (highest - lowest > agent.climb)
    return ledge


def _links(gaps: _Gaps, stand: IntArray, agent: Agent) -> IntArray:
    """Neighbours one can step to, `(4, n)`, as indices into `stand`; `n` where there is none."""
    count = len(stand)
    number = np.full(len(gaps.floor) + 1, count)
    number[stand] = np.arange(count)
    floor, ceiling, column = gaps.floor[stand], gaps.ceiling[stand], gaps.column[stand]
    links = np.full((4, count), count)
    for direction, step in enumerate(gaps.steps):
        start, end = gaps.first[column + step], gaps.first[column + step + 1]
        for k in range(int(np.max(end - start, initial=0))):
            other = np.where(start + k < end, start + k, len(gaps.floor))
            there = np.minimum(other, len(gaps.floor) - 1)
            shared = np.minimum(ceiling, gaps.ceiling[there]) - np.maximum(floor, gaps.floor[there])
            near = np.abs(gaps.floor[there] - floor) <= agent.climb
            fits = near & (shared >= agent.height) & (links[direction] == count)
            links[direction] = np.where(fits, number[other], links[direction])
    return links


def _wall_distance(links: IntArray, radius: int) -> IntArray:
    """Chamfer distance to the nearest cell beside a wall, exact below `2 * radius`, `(n,)`.

    Straight steps cost 2, diagonal ones 3.
    """
    count = links.shape[1]
    far = 4 * radius + 4
    distance = np.append(np.where(np.any(links == count, axis=0), 0, far), far)
    padded = np.concatenate([links, np.full((4, 1), count)], axis=1)
    diagonals = [padded[(d + 1) % 4][padded[d]] for d in range(4)]
    for _ in range(radius):
        best = distance
        for direction in range(4):
            best = np.minimum(best, distance[padded[direction]] + 2)
            best = np.minimum(best, distance[diagonals[direction]] + 3)
        distance = best
    return distance[:count]


def _islands(links: IntArray, kept: BoolArray, min_cells: int) -> IntArray:
    """Island of each cell, largest first, `(n,)`; -1 where eroded or too small an island."""
    count = links.shape[1]
    kept_padded = np.append(kept, False)
    direction, source = np.nonzero((links < count) & kept_padded[links] & kept)
    target = links[direction, source]
    ones = np.ones(len(source), np.int8)
    graph = coo_array((ones, (source, target)), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    size = np.bincount(label[kept], minlength=int(label.max(initial=-1)) + 1)
    by_size = np.argsort(-size, kind="stable")
    rank = np.full(len(size), -1)
    large = by_size[size[by_size] >= max(min_cells, 1)]
    rank[large] = np.arange(len(large))
    island: IntArray = np.where(kept, rank[label] if len(rank) else -1, -1).astype(np.int64)
    return island
