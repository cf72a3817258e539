"""What one look shows of the map's fine grid: cells that are hit, and cells that rays pass."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = [
    "FINE_CELLS",
    "FINE_M",
    "HALF_M",
    "FineCells",
    "Window",
    "fine_cells",
    "fine_flat",
    "passed_flags",
]

BoolArray = NDArray[np.bool_]
FineCells: TypeAlias = tuple[NDArray[np.int32], NDArray[np.int32]]
"""Rows and columns of cells of the fine grid."""

HALF_M = 20.0
"""The map reaches this far from where the robot started."""
FINE_M = 0.05
"""Side of a cell."""
FINE_CELLS = round(2 * HALF_M / FINE_M)
"""Cells along a side of the grid."""
_CARVE_STEP_M = 0.04
"""Between the points of a ray that are looked at: less than a cell."""


@dataclasses.dataclass(frozen=True)
class Window:
    """A part of the fine grid, and all that one look touches."""

    top: int
    left: int
    height: int
    width: int

    @classmethod
    def around(cls, *cells: FineCells) -> Window:
        """The least one that holds all these cells."""
        top = min(int(rows.min()) for rows, _ in cells)
        left = min(int(columns.min()) for _, columns in cells)
        bottom = max(int(rows.max()) for rows, _ in cells)
        right = max(int(columns.max()) for _, columns in cells)
        return cls(top, left, bottom - top + 1, right - left + 1)

    @property
    def part(self) -> tuple[slice, slice]:
        """Its rows and columns in the grid."""
        return (
            slice(self.top, self.top + self.height),
            slice(self.left, self.left + self.width),
        )

    def flags(self, cells: FineCells, choices: Iterable[BoolArray]) -> list[BoolArray]:
        """For every choice of the cells, where those chosen lie, `(height, width)`.

        Args:
            cells: Of which those chosen are in the window.
            choices: As many as cells, or the first rows of them.
        """
        rows, columns = cells
        places = (rows - self.top) * self.width + (columns - self.left)
        found = []
        for chosen in choices:
            flags = np.zeros(self.height * self.width, bool)
            flags[places[: len(chosen)][chosen]] = True
            found.append(flags.reshape(self.height, self.width))
        return found


def passed_flags(
    here: FloatArray,
    rays: FloatArray,
    reaches: tuple[NDArray[np.float32], ...],
    starts: tuple[float, ...],
    window: Window,
) -> list[BoolArray]:
    """Where rays pass between two depths, for each of several such pairs.

    Args:
        here: Where the rays begin, `(2,)`.
        rays: One metre of depth long, `(columns, 2)`.
        reaches: To where, metres, `(columns,)` each; a ray of depth 0 or less passes nothing.
        starts: From where, metres.
        window: Holds all of these rays.
    """
    limits = [float(reach.max(initial=0.0)) for reach in reaches]
    steps = [np.arange(0.0, max(limit, _CARVE_STEP_M), _CARVE_STEP_M) for limit in limits]
    cells = fine_cells(here, rays, max(steps, key=len)[:, None])
    chosen = (
        (depths[:, None] >= start) & (depths[:, None] < reach)
        for depths, reach, start in zip(steps, reaches, starts, strict=True)
    )
    return window.flags(cells, chosen)


def fine_cells(here: FloatArray, rays: FloatArray, depth: NDArray[np.floating]) -> FineCells:
    """Row and column of the fine cells at depths `(..., columns)` along rays."""
    column, row = (
        ((here[axis] + depth * rays[:, axis] + HALF_M) * (1.0 / FINE_M)).astype(np.int32)
        for axis in (0, 1)
    )
    return np.clip(row, 0, FINE_CELLS - 1), np.clip(column, 0, FINE_CELLS - 1)


def fine_flat(points: FloatArray) -> NDArray[np.intp]:
    """Places of points `(..., 2)` in the flat fine grid, `(...)`; clipped to its edge."""
    cells = ((points + HALF_M) * (1.0 / FINE_M)).astype(np.intp)
    np.clip(cells, 0, FINE_CELLS - 1, out=cells)
    return np.asarray(cells[..., 1] * FINE_CELLS + cells[..., 0])
