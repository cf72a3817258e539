"""Shortest ways over a grid of cells."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from affectsim_data.poses import FloatArray

__all__ = ["Travel"]

_NEIGHBOURS = ((0, 1, 1.0), (1, 0, 1.0), (1, 1, math.sqrt(2.0)), (1, -1, math.sqrt(2.0)))
_SNAP_M = 0.5


class Travel:
    """All shortest ways from one cell, over 8-connected travelable cells."""

    def __init__(
        self, travelable: NDArray[np.bool_], start: tuple[int, int], cell_m: float
    ) -> None:
        """Measures the ways.

        Args:
            travelable: Which cells can be stood on, `(rows, columns)`.
            start: Row and column; the nearest travelable cell counts if it is not one.
            cell_m: Side of a cell, metres.
        """
        self._grid, self._cell_m = travelable, cell_m
        self._cells = np.argwhere(travelable)
        self._numbers = np.full(travelable.shape, -1, np.int32)
        self._numbers[travelable] = np.arange(len(self._cells))
        self.distances: FloatArray = np.full(travelable.shape, np.inf)
        self._before: NDArray[np.int32] | None = None
        begin = self._snapped(start, np.ones(len(self._cells), bool))
        if begin is None:
            return
        lengths, before = dijkstra(
            self._graph(), directed=False, indices=begin, return_predecessors=True
        )
        self._before = before
        self.distances[travelable] = lengths

    def path(self, goal: ArrayLike) -> NDArray[np.intp] | None:
        """Cells where the way to a goal `(2,)` bends, with both ends, `(n, 2)`; `None` for no way.

        A goal that cannot be reached is replaced by the nearest cell within 0.5 m that can.
        """
        if self._before is None:
            return None
        row, column = (int(value) for value in np.asarray(goal))
        reached = np.isfinite(self.distances[self._grid])
        number = self._snapped((row, column), reached)
        if number is None:
            return None
        chain = [number]
        while self._before[chain[-1]] >= 0:
            chain.append(int(self._before[chain[-1]]))
        return self._pulled(self._cells[chain[::-1]])

    def _pulled(self, cells: NDArray[np.intp]) -> NDArray[np.intp]:
        """Only the bends that are needed: the string pulled tight."""
        kept, at = [0], 0
        while at < len(cells) - 1:
            ahead = len(cells) - 1
            while ahead > at + 1 and not self._straight(cells[at], cells[ahead]):
                ahead -= max(1, (ahead - at) // 8)
            at = max(ahead, at + 1)
            kept.append(at)
        if len(kept) == 1:
            kept.append(0)
        return cells[kept]

    def _straight(self, start: NDArray[np.intp], end: NDArray[np.intp]) -> bool:
        """Whether every cell along a straight line can be stood on."""
        steps = 2 * int(np.abs(end - start).max()) + 1
        along = np.linspace(0.0, 1.0, steps)[:, None]
        line = np.rint(start + along * (end - start)).astype(np.intp)
        return bool(self._grid[line[:, 0], line[:, 1]].all())

    def _snapped(self, cell: tuple[int, int], among: NDArray[np.bool_]) -> int | None:
        """Number of the nearest of some cells within half a metre, `None` if there is none."""
        number = int(self._numbers[cell])
        if number >= 0 and among[number]:
            return number
        away = ((self._cells - np.array(cell)) ** 2).sum(axis=1).astype(np.float64)
        away[~among] = np.inf
        if not len(away) or away.min() > (_SNAP_M / self._cell_m) ** 2:
            return None
        return int(away.argmin())

    def _graph(self) -> csr_array:
        """Lengths between neighbours; no corner of what cannot be stood on is cut."""
        low, high = self._cells.min(axis=0), self._cells.max(axis=0) + 1
        numbers = self._numbers[low[0] : high[0], low[1] : high[1]]
        starts, ends, lengths = [], [], []
        for down, right, factor in _NEIGHBOURS:
            one, two = _pairs(numbers, down, right)
            joined = (one >= 0) & (two >= 0)
            if down and right:
                beside, below = _corners(numbers, right)
                joined &= (beside >= 0) & (below >= 0)
            starts.append(one[joined])
            ends.append(two[joined])
            lengths.append(np.full(int(joined.sum()), factor * self._cell_m))
        count = len(self._cells)
        return csr_array(
            (np.concatenate(lengths), (np.concatenate(starts), np.concatenate(ends))),
            shape=(count, count),
        )


def _pairs(
    numbers: NDArray[np.int32], down: int, right: int
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The numbers of every cell and of its neighbour, as two overlapping parts of the grid."""
    rows, columns = numbers.shape
    first, last = max(0, -right), columns - max(0, right)
    return (
        numbers[: rows - down, first:last],
        numbers[down:, first + right : last + right],
    )


def _corners(numbers: NDArray[np.int32], right: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The two cells that a diagonal step between `_pairs` passes between."""
    columns = numbers.shape[1]
    first, last = max(0, -right), columns - max(0, right)
    return numbers[:-1, first + right : last + right], numbers[1:, first:last]
