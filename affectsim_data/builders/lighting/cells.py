"""A coarse grid over points that tells which of them a light may reach, before any is asked."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from affectsim_data.builders.lighting.rays import Array32, LightRays

__all__ = ["Cells"]

_CELL_M = 0.8
_MOST_CELLS = 64
"""Along an axis; in wider places the cells grow."""
_PROBES = 8
"""Points of a cell that are asked for all of it."""


class Cells:
    """Points `(n, 3)` sorted into the boxes of a grid."""

    def __init__(self, points: Array32) -> None:
        low = points.min(axis=0)
        extent = points.max(axis=0) - low
        size = np.maximum(extent / _MOST_CELLS, np.float32(_CELL_M))
        place = ((points - low) / size).astype(np.int64)
        self._shape = tuple(int(n) for n in place.max(axis=0) + 1)
        self._cell = np.ravel_multi_index(tuple(place.T), self._shape)
        order = np.argsort(self._cell, kind="stable")
        starts = np.flatnonzero(np.diff(self._cell[order], prepend=-1))
        counts = np.diff(np.append(starts, len(order)))
        # Probes spread over each cell's points; small cells are asked twice for the same one.
        spread = (np.arange(_PROBES)[None, :] * counts[:, None]) // _PROBES
        probes = order[starts[:, None] + spread]
        self._owners = np.repeat(self._cell[order][starts], _PROBES)
        self._probes = np.ascontiguousarray(points[probes.reshape(-1)])

    def seeing(self, targets: Array32, rays: LightRays) -> NDArray[np.intp]:
        """Indices of the points in cells of which a probe sees one of the targets `(k, 3)`, and in
        the cells around those."""
        seen = np.zeros(self._shape, bool)
        for target in targets:
            seen.reshape(-1)[self._owners[~rays.hidden(self._probes, target)]] = True
        wide = ndimage.binary_dilation(seen, np.ones((3, 3, 3), bool))
        return np.flatnonzero(wide.reshape(-1)[self._cell])
