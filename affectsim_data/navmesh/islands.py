"""An island of the navmesh: one connected polygon with holes, and the height of its floor."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import shapely
from numpy.typing import NDArray
from scipy import ndimage

from affectsim_data.navmesh.outlines import cell_outlines, simplify_rings
from affectsim_data.navmesh.rasterize import Grid, IntArray
from affectsim_data.navmesh.sights import CornerSight
from affectsim_data.navmesh.walls import ON_WALL_M, Walls
from affectsim_data.poses import FloatArray

__all__ = ["Island", "islands_from_cells"]

# Recast's largest deviation of a simplified outline from the cells, in cells.
SIMPLIFY_CELLS = 1.3
HEIGHT_STEP_M = 0.001
# Ways are measured along the floor in pieces of at most this length: longer than the ripple of a
# scanned floor or the tread of a stair, shorter than any ramp.
PIECE_M = 0.25


@dataclasses.dataclass(frozen=True, eq=False)
class Island:
    """Where the middle of an agent can go without leaving the floor, seen from above.

    The plan is `(x, z)`. Rings have the free side on their left: the outer one runs from +x to
    +z, holes the other way.
    """

    rings: tuple[NDArray[np.float32], ...]
    """Corners `(x, z)`, metres, `(n, 2)` each, the outer ring first."""
    heights: NDArray[np.int16]
    """Floor above `base_y` in the middle of cells, millimetres, `(depth, width)`; or `(1, 1)`."""
    height_origin: tuple[float, float]
    """Corner `(x, z)` of the first cell of `heights`, metres."""
    base_y: float
    """Metres."""
    cell_size: float
    """Side of a cell of `heights`, metres."""

    def __post_init__(self) -> None:
        if not self.polygon.is_valid or self.polygon.area <= 0.0:
            reason = shapely.is_valid_reason(self.polygon)
            raise ValueError(f"an island's rings must form a polygon with holes: {reason}")
        areas = [shapely.LinearRing(ring).is_ccw for ring in self.rings]
        if areas != [True] + [False] * (len(areas) - 1):
            raise ValueError("an island's outer ring must run from +x to +z, its holes against it")

    @functools.cached_property
    def polygon(self) -> shapely.Polygon:
        """The island on the plan, `(x, z)`, metres."""
        rings = [ring.astype(np.float64) for ring in self.rings]
        polygon = shapely.Polygon(rings[0], rings[1:])
        shapely.prepare(polygon)
        return polygon

    @functools.cached_property
    def walls(self) -> Walls:
        """The edges of its rings."""
        return Walls.from_rings([ring.astype(np.float64) for ring in self.rings])

    @functools.cached_property
    def sight(self) -> CornerSight:
        """Which of its corners its points see."""
        return CornerSight(self.walls)

    @functools.cached_property
    def low(self) -> tuple[float, float, float]:
        """Low corner of its box, metres."""
        x, z, _, _ = self.polygon.bounds
        return float(x), self.base_y + HEIGHT_STEP_M * float(self.heights.min()), float(z)

    @functools.cached_property
    def high(self) -> tuple[float, float, float]:
        """High corner of its box, metres."""
        _, _, x, z = self.polygon.bounds
        return float(x), self.base_y + HEIGHT_STEP_M * float(self.heights.max()), float(z)

    @functools.cached_property
    def rise(self) -> float:
        """Between its lowest and its highest floor, metres."""
        return self.high[1] - self.low[1]

    @functools.cached_property
    def is_level(self) -> bool:
        """Whether its floor has one height everywhere."""
        return bool(self.heights.min() == self.heights.max())

    @functools.cached_property
    def _edge_tree(self) -> shapely.STRtree:
        return shapely.STRtree(
            shapely.linestrings(np.stack([self.walls.start, self.walls.end], axis=1))
        )

    @functools.cached_property
    def median_y(self) -> float:
        """Median height of its floor, metres."""
        return self.base_y + HEIGHT_STEP_M * float(np.median(self.heights))

    @functools.cached_property
    def _heights_m(self) -> FloatArray:
        """Heights of cells, metres, row by row."""
        return (self.base_y + HEIGHT_STEP_M * self.heights.astype(np.float64)).reshape(-1)

    def height_at(self, plan: FloatArray) -> FloatArray:
        """Height of the floor, metres, `(n,)`, interpolated at `(x, z)`, `(n, 2)`."""
        if self.is_level:
            return np.full(len(plan), self.low[1])
        depth, width = self.heights.shape
        x = (plan[:, 0] - self.height_origin[0]) / self.cell_size - 0.5
        z = (plan[:, 1] - self.height_origin[1]) / self.cell_size - 0.5
        x = np.minimum(np.maximum(x, 0.0), width - 1.0)
        z = np.minimum(np.maximum(z, 0.0), depth - 1.0)
        column = np.minimum(x.astype(np.int64), max(width - 2, 0))
        row = np.minimum(z.astype(np.int64), max(depth - 2, 0))
        x, z = x - column, z - row
        first, heights = row * width + column, self._heights_m
        right, down = min(width - 1, 1), min(depth - 1, 1) * width
        near = (1.0 - x) * heights[first] + x * heights[first + right]
        far = (1.0 - x) * heights[first + down] + x * heights[first + down + right]
        height: FloatArray = (1.0 - z) * near + z * far
        return height

    def height_here(self, x: float, z: float) -> float:
        """`height_at` for one point, metres."""
        if self.is_level:
            return self.low[1]
        depth, width = self.heights.shape
        x = min(max((x - self.height_origin[0]) / self.cell_size - 0.5, 0.0), width - 1.0)
        z = min(max((z - self.height_origin[1]) / self.cell_size - 0.5, 0.0), depth - 1.0)
        column, row = min(int(x), max(width - 2, 0)), min(int(z), max(depth - 2, 0))
        x, z = x - column, z - row
        first, heights = row * width + column, self._heights_m
        right, down = min(width - 1, 1), min(depth - 1, 1) * width
        near = (1.0 - x) * heights[first] + x * heights[first + right]
        far = (1.0 - x) * heights[first + down] + x * heights[first + down + right]
        return float((1.0 - z) * near + z * far)

    def floor_lengths(self, starts: FloatArray, ends: FloatArray) -> FloatArray:
        """Lengths along the floor of straight lines on the plan, metres, `(n,)`.

        Args:
            starts: Points `(x, z)` of the island, `(n, 2)`.
            ends: Alike; the lines between them stay on the island.
        """
        length: FloatArray = np.hypot(*(ends - starts).T)
        if self.is_level or not len(length):
            return length
        line, point = self.profile(starts, ends)
        y = self.height_at(point)
        pieces = np.bincount(line) - 1
        within = np.flatnonzero(line[1:] == line[:-1])
        of = line[within]
        run = np.hypot((length / pieces)[of], y[within + 1] - y[within])
        return np.asarray(np.bincount(of, run, minlength=len(length)), np.float64)

    def floor_line(self, bends: FloatArray) -> FloatArray:
        """Points of the floor along a line `(x, z)`, `(n, 2)`: its bends and what rises between."""
        line, point = self.profile(bends[:-1], bends[1:])
        floor = self.on_floor(point)
        first = np.concatenate([[0], np.flatnonzero(np.diff(line)) + 1])
        last = np.append(first[1:] - 1, len(line) - 1)
        slope = (floor[last, 1] - floor[first, 1]) / (last - first)
        straight = floor[first[line], 1] + slope[line] * (np.arange(len(line)) - first[line])
        off = np.abs(floor[:, 1] - straight)
        bumpy = np.zeros(len(first), bool)
        np.logical_or.at(bumpy, line, off > 1e-9)
        kept = bumpy[line]
        kept[first] = False
        kept[0] = kept[last] = True
        return floor[kept]

    def profile(self, starts: FloatArray, ends: FloatArray) -> tuple[IntArray, FloatArray]:
        """Points along straight lines, ends included, at most `PIECE_M` apart.

        Returns:
            The line of each point, in order, `(k,)`, and the points `(x, z)`, `(k, 2)`.
        """
        length = np.hypot(*(ends - starts).T)
        pieces = np.maximum(np.ceil(length / PIECE_M - 1e-9), 1.0).astype(np.int64)
        line: IntArray = np.repeat(np.arange(len(pieces)), pieces + 1)
        first = np.cumsum(pieces + 1) - (pieces + 1)
        share = ((np.arange(len(line)) - first[line]) / pieces[line])[:, None]
        return line, (1.0 - share) * starts[line] + share * ends[line]

    def on_floor(self, plan: FloatArray) -> FloatArray:
        """Points of the floor, `(n, 3)`, at `(x, z)`, `(n, 2)`."""
        return np.stack([plan[:, 0], self.height_at(plan), plan[:, 1]], axis=1)

    def nearest(self, plan: FloatArray) -> FloatArray:
        """The points of the island nearest to `(x, z)`, `(n, 2)`; a point on it stays as it is."""
        nearest = plan.copy()
        outside = np.flatnonzero(~shapely.contains_xy(self.polygon, plan[:, 0], plan[:, 1]))
        if len(outside):
            away = plan[outside]
            edge = self._edge_tree.query_nearest(shapely.points(away), all_matches=False)[1]
            projected = self.walls.project(away, edge)
            off = np.linalg.norm(projected - away, axis=1) > ON_WALL_M
            nearest[outside[off]] = projected[off]
        return nearest

    def contains(self, x: float, z: float) -> bool:
        """Whether a point lies inside, not on a wall."""
        return bool(shapely.contains_xy(self.polygon, x, z))

    def nearest_here(self, x: float, z: float) -> tuple[float, float]:
        """`nearest` for one point."""
        if self.contains(x, z):
            return x, z
        to_x, to_z, distance = self.walls.nearest(x, z)
        return (to_x, to_z) if distance > ON_WALL_M else (x, z)

    def wall_distance(self, plan: FloatArray) -> FloatArray:
        """Distance to the nearest wall, metres, `(n,)`, of `(x, z)`, `(n, 2)`."""
        _, distance = self._edge_tree.query_nearest(
            shapely.points(plan), all_matches=False, return_distance=True
        )
        return np.asarray(distance, np.float64)


def islands_from_cells(
    x: IntArray, z: IntArray, y: FloatArray, island: IntArray, grid: Grid
) -> tuple[Island, ...]:
    """Islands of walkable cells; no two cells of one island may share a column.

    Args:
        x, z: Columns, `(n,)`.
        y: Heights, metres, `(n,)`.
        island: Island of each cell, from 0, `(n,)`.
        grid: The columns.
    """
    islands = []
    for number in range(int(island.max(initial=-1)) + 1):
        member = island == number
        low_x, low_z = int(x[member].min()), int(z[member].min())
        column, row = x[member] - low_x, z[member] - low_z
        mask = np.zeros((int(row.max()) + 1, int(column.max()) + 1), bool)
        mask[row, column] = True
        origin = grid.origin[[0, 2]] + grid.cell_size * np.array([low_x, low_z])
        base_y = float(np.round(np.median(y[member]), 6))
        heights = _height_grid(mask, row, column, y[member] - base_y)
        islands.append(
            Island(
                _rings(mask, origin, grid.cell_size),
                heights,
                (float(origin[0]), float(origin[1])),
                base_y,
                grid.cell_size,
            )
        )
    return tuple(islands)


def _height_grid(
    mask: NDArray[np.bool_], row: IntArray, column: IntArray, height: FloatArray
) -> NDArray[np.int16]:
    """Heights in millimetres; cells outside the island take the nearest inside."""
    steps = np.round(height / HEIGHT_STEP_M)
    if np.abs(steps).max() > np.iinfo(np.int16).max:
        raise ValueError(f"a walkable surface rises over {np.ptp(height):.1f} m; the limit is 32 m")
    if np.ptp(steps) == 0:
        return np.full((1, 1), steps[0], np.int16)
    grid = np.zeros(mask.shape, np.int16)
    grid[row, column] = steps
    nearest = ndimage.distance_transform_edt(~mask, return_distances=False, return_indices=True)
    filled: NDArray[np.int16] = grid[tuple(nearest)]
    return filled


def _rings(
    mask: NDArray[np.bool_], origin: FloatArray, cell_size: float
) -> tuple[NDArray[np.float32], ...]:
    outlines = cell_outlines(mask)
    for rings in (simplify_rings(outlines, tolerance=SIMPLIFY_CELLS), outlines):
        stored = tuple((origin + cell_size * ring).astype(np.float32) for ring in rings)
        if shapely.Polygon(stored[0], stored[1:]).is_valid:
            break
    return stored
