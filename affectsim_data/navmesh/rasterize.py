"""Triangles to solid spans: which heights of each grid column a mesh fills.

The first half of Recast's voxel pipeline (Mononen 2009) in NumPy. Columns are conservative: every
column a triangle touches is filled, over the exact range of heights the triangle has there.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = ["Grid", "Spans", "rasterize", "unit_normals"]

# Limits of time and memory: about 100 x 100 m at 0.05 m, and minutes of work.
MAX_COLUMNS = 1 << 22
MAX_LEVELS = 1 << 18
MAX_PAIRS = 1 << 28
MAX_TOUCHES_HELD = 1 << 21
PAIRS_PER_CHUNK = 1 << 16
# A face on the border of two columns belongs to the one it bounds from outside: faces are drawn
# back against their normals by this many cells, more than float noise.
DRAWN_BACK_CELLS = 1e-4

IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


@dataclasses.dataclass(frozen=True)
class Grid:
    """Columns over the floor plan, counted from the lowest corner of the mesh."""

    origin: FloatArray
    """Lowest corner, metres, `(3,)`."""
    width: int
    """Columns along x."""
    depth: int
    """Columns along z."""
    cell_size: float
    """Side of a column, metres."""
    cell_height: float
    """Height of a level, metres."""

    @classmethod
    def around(cls, vertices: FloatArray, *, cell_size: float, cell_height: float) -> Grid:
        """The grid that covers `vertices`, `(n, 3)`.

        Raises:
            ValueError: The mesh is too large for columns of this size.
        """
        low, high = vertices.min(axis=0), vertices.max(axis=0)
        width, depth = np.maximum(1, np.floor((high - low)[[0, 2]] / cell_size + 0.5))
        if width * depth > MAX_COLUMNS or (high - low)[1] / cell_height >= MAX_LEVELS - 2:
            size = " x ".join(f"{side:.0f}" for side in high - low)
            raise ValueError(
                f"a mesh of {size} m needs {width * depth:.3g} columns of {cell_size} m, the limit "
                f"is {MAX_COLUMNS}; check that its unit is the metre, cut it, or use a larger "
                "cell_size"
            )
        return cls(low, int(width), int(depth), cell_size, cell_height)


@dataclasses.dataclass(frozen=True)
class Spans:
    """Solid runs of levels, sorted by column, then from below; runs of a column never touch."""

    column: IntArray
    """`z * width + x`, `(num_spans,)`."""
    bottom: IntArray
    """First level, `(num_spans,)`."""
    top: IntArray
    """One above the last level, `(num_spans,)`."""
    walkable: BoolArray
    """Whether a surface flat enough to walk on tops it, `(num_spans,)`."""
    surface_y: FloatArray
    """Height of that surface in the middle of the column, metres, `(num_spans,)`."""


def unit_normals(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Outward normals of triangles, `(m, 3)`; zero where a triangle has no area."""
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    unit: FloatArray = normal / np.where(length > 0.0, length, 1.0)
    return unit


def rasterize(
    vertices: FloatArray, faces: IntArray, grid: Grid, *, max_climb: int, min_normal_y: float
) -> Spans:
    """Solid spans of a mesh.

    Args:
        vertices: Metres, Y up, `(n, 3)`.
        faces: Triangles, counter-clockwise from outside, `(m, 3)`.
        grid: Columns, as from `Grid.around`.
        max_climb: Levels a walkable surface may lie below the top of its span.
        min_normal_y: Least upward part of the unit normal of a walkable triangle.
    """
    plan_scale = np.array([grid.cell_size, 1.0, grid.cell_size])
    corners = (vertices[faces] - grid.origin) / plan_scale
    normal = unit_normals(vertices, faces)
    corners -= DRAWN_BACK_CELLS * normal[:, None] * [1.0, 0.0, 1.0]
    walkable = normal[:, 1] > min_normal_y
    touches = _all_touches(corners, walkable, grid)
    column, bottom, top = touches["column"], touches["bottom"], touches["top"]
    span_column, span_bottom, span_top = _merge(column, bottom, top)
    flat = np.flatnonzero(touches["walkable"])
    key = span_column * MAX_LEVELS + span_bottom
    span = np.searchsorted(key, column[flat] * MAX_LEVELS + bottom[flat], side="right") - 1
    on_top = top[flat] >= span_top[span] - max_climb
    highest = np.full(len(span_top), -np.inf)
    np.maximum.at(highest, span[on_top], touches["middle"][flat][on_top])
    stands = np.isfinite(highest)
    surface_y = np.where(stands, highest, span_top * grid.cell_height) + grid.origin[1]
    return Spans(span_column, span_bottom, span_top, stands, surface_y)


def _all_touches(corners: FloatArray, walkable: BoolArray, grid: Grid) -> NDArray[np.void]:
    """Touches of all triangles; of a dense mesh those that differ, so that memory is bounded."""
    parts: list[NDArray[np.void]] = []
    held, limit = 0, MAX_TOUCHES_HELD
    for chunk in _chunks(corners, grid):
        parts.append(_touched(chunk, corners, walkable, grid))
        held += len(parts[-1])
        if held > limit:
            parts = [_distinct(np.concatenate(parts))]
            held = len(parts[0])
            limit = max(limit, 2 * held)
    return np.concatenate(parts)


def _distinct(touches: NDArray[np.void]) -> NDArray[np.void]:
    """Touches that fill the same levels of a column become one, at the highest of their middles."""
    levels = touches["column"] * MAX_LEVELS + touches["bottom"]
    size = 2 * (touches["top"] - touches["bottom"]) + touches["walkable"]
    order = np.lexsort((-touches["middle"], size, levels))
    levels, size = levels[order], size[order]
    first = np.ones(len(order), bool)
    first[1:] = (levels[1:] != levels[:-1]) | (size[1:] != size[:-1])
    return touches[order[first]]


def _merge(
    column: IntArray, bottom: IntArray, top: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Union of runs per column; touching runs become one."""
    order = np.argsort(column * MAX_LEVELS + bottom)
    start = (column * MAX_LEVELS + bottom)[order]
    reach = np.maximum.accumulate((column * MAX_LEVELS + top)[order])
    first = np.concatenate([[True], start[1:] > reach[:-1]])
    last = np.concatenate([first[1:], [True]])
    return start[first] // MAX_LEVELS, start[first] % MAX_LEVELS, reach[last] % MAX_LEVELS


_TOUCH = np.dtype(
    [("column", "i8"), ("bottom", "i8"), ("top", "i8"), ("walkable", "i8"), ("middle", "f8")]
)


@dataclasses.dataclass(frozen=True)
class _Chunk:
    """Triangles with the block of columns around each."""

    triangle: IntArray
    low: IntArray
    """First column `(x, z)`, `(n, 2)`."""
    size: IntArray
    """Columns along `(x, z)`, `(n, 2)`."""


def _chunks(corners: FloatArray, grid: Grid) -> Iterator[_Chunk]:
    plan = corners[:, :, [0, 2]]
    limit = np.array([grid.width - 1, grid.depth - 1])
    low = np.clip(np.floor(plan.min(axis=1)), 0, limit).astype(np.int64)
    high = np.clip(np.floor(plan.max(axis=1)), 0, limit).astype(np.int64)
    size = high - low + 1
    count = size.prod(axis=1)
    if count.sum() > MAX_PAIRS:
        raise ValueError(
            f"{len(corners)} triangles lie over {count.sum():.3g} columns of {grid.cell_size} m, "
            f"the limit is {MAX_PAIRS}; decimate the mesh, or use a larger cell_size"
        )
    single = np.flatnonzero(count == 1)
    for first in range(0, len(single), PAIRS_PER_CHUNK):
        part = single[first : first + PAIRS_PER_CHUNK]
        yield _Chunk(part, low[part], size[part])
    many = np.flatnonzero(count > 1)
    triangle, band_low, band_size = _bands(many, low[many], size[many])
    group = np.cumsum(band_size.prod(axis=1)) // PAIRS_PER_CHUNK
    for part in np.split(np.arange(len(triangle)), np.flatnonzero(np.diff(group)) + 1):
        yield _Chunk(triangle[part], band_low[part], band_size[part])


def _bands(
    triangle: IntArray, low: IntArray, size: IntArray
) -> tuple[IntArray, IntArray, IntArray]:
    """Cuts blocks of columns into bands of rows, so that none is larger than a chunk."""
    rows = np.maximum(PAIRS_PER_CHUNK // size[:, 0], 1)
    count = -(-size[:, 1] // rows)
    block = np.repeat(np.arange(len(triangle)), count)
    skipped = (np.arange(len(block)) - (np.cumsum(count) - count)[block]) * rows[block]
    band_low, band_size = low[block], size[block]
    band_low[:, 1] += skipped
    band_size[:, 1] = np.minimum(rows[block], size[block, 1] - skipped)
    return triangle[block], band_low, band_size


def _touched(
    chunk: _Chunk, corners: FloatArray, walkable: BoolArray, grid: Grid
) -> NDArray[np.void]:
    """What the triangles of a chunk fill: column, first level, one above the last, and height."""
    count = chunk.size.prod(axis=1)
    member = np.repeat(np.arange(len(count)), count)
    offset = np.arange(len(member)) - np.repeat(np.cumsum(count) - count, count)
    row, step = np.divmod(offset, chunk.size[member, 0])
    x, z = chunk.low[member, 0] + step, chunk.low[member, 1] + row
    triangle = corners[chunk.triangle]
    if np.all(count == 1):
        low, high = triangle[:, :, 1].min(axis=1), triangle[:, :, 1].max(axis=1)
    else:
        low, high = _height_range(triangle, member, x.astype(np.float64), z.astype(np.float64))
    slope_x, slope_z, _ = _planes(triangle)
    middle = (
        triangle[member, 0, 1]
        + slope_x[member] * (x + 0.5 - triangle[member, 0, 0])
        + slope_z[member] * (z + 0.5 - triangle[member, 0, 2])
    )
    hit = np.flatnonzero(low <= high)
    low, high = low[hit], high[hit]
    touches = np.empty(len(hit), _TOUCH)
    touches["column"] = z[hit] * grid.width + x[hit]
    bottom = np.maximum(0, np.floor(low / grid.cell_height)).astype(np.int64)
    touches["bottom"] = bottom
    touches["top"] = np.maximum(bottom + 1, np.ceil(high / grid.cell_height - 1e-9))
    touches["walkable"] = walkable[chunk.triangle[member[hit]]]
    touches["middle"] = np.minimum(np.maximum(middle[hit], low), high)
    return touches


def _planes(triangle: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Slopes along x and z, and twice the signed area on the plan, 0 for an upright triangle."""
    first, second = triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0]
    area = first[:, 0] * second[:, 2] - first[:, 2] * second[:, 0]
    area = np.where(np.abs(area) < 1e-9, 0.0, area)
    inverse = np.divide(1.0, area, out=np.zeros_like(area), where=area != 0.0)
    slope_x = (first[:, 1] * second[:, 2] - first[:, 2] * second[:, 1]) * inverse
    slope_z = (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]) * inverse
    return slope_x, slope_z, area


def _height_range(
    triangle: FloatArray, member: IntArray, x: FloatArray, z: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Exact heights of triangles inside columns; lowest above highest where they miss.

    A triangle cut by a column is a convex polygon. Its corners are ends of the triangle's edges
    cut by the column, and corners of the column inside the triangle.
    """
    low, high = np.full(len(member), np.inf), np.full(len(member), -np.inf)
    slope_x, slope_z, area = _planes(triangle)
    sign, sides = np.sign(area), []
    for corner in range(3):
        a, b = triangle[:, corner], triangle[:, (corner + 1) % 3]
        (ax, ay, az), (dx, dy, dz) = a.T, (b - a).T
        enter_x, leave_x = _slab(ax, dx, x, member)
        enter_z, leave_z = _slab(az, dz, z, member)
        enter = np.maximum(np.maximum(enter_x, enter_z), 0.0)
        leave = np.minimum(np.minimum(leave_x, leave_z), 1.0)
        inside = enter <= leave
        start, change = ay[member], dy[member]
        ends = (start + enter * change, start + leave * change)
        low = np.where(inside, np.minimum(low, np.minimum(*ends)), low)
        high = np.where(inside, np.maximum(high, np.maximum(*ends)), high)
        along_x, along_z = (-sign * dz)[member], (sign * dx)[member]
        base = (sign * (az * -dx + ax * dz))[member]
        sides.append((base + along_x * x + along_z * z, along_x, along_z))
    upright = (area == 0.0)[member]
    base = (
        triangle[member, 0, 1]
        + slope_x[member] * (x - triangle[member, 0, 0])
        + slope_z[member] * (z - triangle[member, 0, 2])
    )
    for step_x, step_z in ((0, 0), (1, 0), (0, 1), (1, 1)):
        covered = ~upright
        for side, along_x, along_z in sides:
            covered &= side + step_x * along_x + step_z * along_z >= 0.0
        height = base + step_x * slope_x[member] + step_z * slope_z[member]
        low = np.where(covered, np.minimum(low, height), low)
        high = np.where(covered, np.maximum(high, height), high)
    return low, high


def _slab(
    start: FloatArray, change: FloatArray, cell: FloatArray, member: IntArray
) -> tuple[FloatArray, FloatArray]:
    """Where lines enter and leave `[cell, cell + 1]`, as shares of `change`.

    `member` says which line each cell is cut with.
    """
    inverse = 1.0 / np.where(np.abs(change) < 1e-12, 1e-12, change)
    inverse = inverse[member]
    near = (cell - start[member]) * inverse
    far = near + inverse
    return np.minimum(near, far), np.maximum(near, far)
