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
from affectsim_data.navmesh.walls import ON_WALL_M, Walls
from affectsim_data.poses import FloatArray

__all__ = ["Island", "islands_from_cells"]

# Recast's largest deviation of a simplified outline from the cells, in cells.
SIMPLIFY_CELLS = 1.3
HEIGHT_STEP_M = 0.001


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
    def _edge_tree(self) -> shapely.STRtree:
        return shapely.STRtree(
            shapely.linestrings(np.stack([self.walls.start, self.walls.end], axis=1))
        )

    @functools.cached_property
    def median_y(self) -> float:
        """Median height of its floor, metres."""
        return self.base_y + HEIGHT_STEP_M * float(np.median(self.heights))

    def height_at(self, plan: FloatArray) -> FloatArray:
        """Height of the floor, metres, `(n,)`, interpolated at `(x, z)`, `(n, 2)`."""
        depth, width = self.heights.shape
        place = (plan - np.array(self.height_origin)) / self.cell_size - 0.5
        place = np.clip(place, 0.0, [width - 1.0, depth - 1.0])
        low = np.minimum(place.astype(np.int64), [max(width - 2, 0), max(depth - 2, 0)])
        share_x, share_z = (place - low).T
        x, z = low.T
        x1, z1 = np.minimum(x + 1, width - 1), np.minimum(z + 1, depth - 1)
        near = (1.0 - share_x) * self.heights[z, x] + share_x * self.heights[z, x1]
        far = (1.0 - share_x) * self.heights[z1, x] + share_x * self.heights[z1, x1]
        height: FloatArray = self.base_y + HEIGHT_STEP_M * ((1.0 - share_z) * near + share_z * far)
        return height

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

    def wall_distance(self, plan: FloatArray) -> FloatArray:
        """Distance to the nearest wall, metres, `(n,)`, of `(x, z)`, `(n, 2)`."""
        _, distance = self._edge_tree.query_nearest(
            shapely.points(plan), all_matches=False, return_distance=True
        )
        return np.asarray(distance, np.float64)

    def random_plan_points(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points uniform over the area, `(count, 2)`."""
        x0, z0, x1, z1 = self.polygon.bounds
        found = np.empty((0, 2))
        while len(found) < count:
            # Each round draws a fixed share more than is missing, so that few rounds are needed.
            tries = 16 + int(1.5 * (count - len(found)))
            points = rng.uniform((x0, z0), (x1, z1), (tries, 2))
            inside = shapely.contains_xy(self.polygon, points[:, 0], points[:, 1])
            found = np.concatenate([found, points[inside]])
        return found[:count]


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
