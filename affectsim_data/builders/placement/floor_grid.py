"""Room around points of the floor, from a grid: a quick answer for very many points."""

from __future__ import annotations

import dataclasses

import numpy as np
import shapely
from scipy import ndimage

from affectsim_data.navmesh.islands import Island
from affectsim_data.poses import FloatArray

__all__ = ["FloorGrid"]

_CELL_M = 0.05


@dataclasses.dataclass(frozen=True, eq=False)
class FloorGrid:
    """Distances to the edge of an island, right to about the size of a cell.

    For throwing out candidates by the ten thousand; those that are left are asked of the navmesh.
    """

    origin: FloatArray
    """Middle of the first cell, `(x, z)`, metres."""
    distance: FloatArray
    """To the edge, metres, one row for each z, 0 off the island, `(depth, width)`."""

    @classmethod
    def of_island(cls, island: Island) -> FloorGrid:
        """Of an island of a navmesh."""
        low_x, low_z, high_x, high_z = island.polygon.bounds
        # A cell more on each side: the outermost ones are off the island.
        x = np.arange(low_x - _CELL_M, high_x + 2.0 * _CELL_M, _CELL_M)
        z = np.arange(low_z - _CELL_M, high_z + 2.0 * _CELL_M, _CELL_M)
        inside = shapely.contains_xy(island.polygon, *np.meshgrid(x, z))
        distance = ndimage.distance_transform_edt(inside, sampling=_CELL_M)
        return cls(np.array([x[0], z[0]]), np.asarray(distance, np.float64))

    def around(self, points: FloatArray) -> FloatArray:
        """Distance from points `(..., 3)` to the edge, metres, `(...)`; 0 off the island."""
        column = np.rint((points[..., 0] - self.origin[0]) / _CELL_M).astype(np.intp)
        row = np.rint((points[..., 2] - self.origin[1]) / _CELL_M).astype(np.intp)
        depth, width = self.distance.shape
        on_grid = (column >= 0) & (column < width) & (row >= 0) & (row < depth)
        distance = self.distance[row.clip(0, depth - 1), column.clip(0, width - 1)]
        around: FloatArray = np.where(on_grid, distance, 0.0)
        return around
