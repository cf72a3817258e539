"""Cheapest ways over a grid of cells, each of which has a cost."""

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
_SLACK = 1.02
"""A straight line may cost this much more than the chain of cells it stands for."""


class Travel:
    """All cheapest ways from one cell, over 8-connected cells."""

    def __init__(self, costs: FloatArray, start: tuple[int, int], cell_m: float) -> None:
        """Measures the ways.

        Args:
            costs: Of a metre in each cell, at least 1, `inf` where nobody can stand,
                `(rows, columns)`.
            start: Row and column; the nearest cell to stand on counts if it is not one.
            cell_m: Side of a cell, metres.
        """
        self._costs, self._cell_m = costs, cell_m
        travelable: NDArray[np.bool_] = np.asarray(np.isfinite(costs))
        self._corner, part = _bounded(travelable)
        self._cells = np.argwhere(part) + self._corner
        self._numbers = np.full(part.shape, -1, np.int32)
        self._numbers[part] = np.arange(len(self._cells))
        self.distances: FloatArray = np.full(costs.shape, np.inf)
        """Cost of the way to each cell; metres where each costs 1."""
        self._reached = np.zeros(len(self._cells), bool)
        self._before: NDArray[np.int32] | None = None
        begin = self._snapped(start, np.ones(len(self._cells), bool))
        if begin is None:
            return
        lengths, before = dijkstra(
            self._graph(), directed=False, indices=begin, return_predecessors=True
        )
        self._before = before
        self._reached = np.isfinite(lengths)
        self.distances[self._cells[:, 0], self._cells[:, 1]] = lengths

    def path(self, goal: ArrayLike) -> NDArray[np.intp] | None:
        """Cells where the way to a goal `(2,)` bends, with both ends, `(n, 2)`; `None` for no way.

        A goal that cannot be reached is replaced by the nearest cell within 0.5 m that can.
        """
        if self._before is None:
            return None
        row, column = (int(value) for value in np.asarray(goal))
        number = self._snapped((row, column), self._reached)
        if number is None:
            return None
        chain = [number]
        while self._before[chain[-1]] >= 0:
            chain.append(int(self._before[chain[-1]]))
        return self._pulled(self._cells[chain[::-1]])

    def _pulled(self, cells: NDArray[np.intp]) -> NDArray[np.intp]:
        """Only the bends that are needed: the string pulled tight, where that costs no more."""
        spent = self.distances[cells[:, 0], cells[:, 1]]
        kept, at = [0], 0
        while at < len(cells) - 1:
            ahead = len(cells) - 1
            while ahead > at + 1:
                most = _SLACK * float(spent[ahead] - spent[at])
                if self._straight(cells[at], cells[ahead]) <= most:
                    break
                ahead -= max(1, (ahead - at) // 8)
            at = max(ahead, at + 1)
            kept.append(at)
        if len(kept) == 1:
            kept.append(0)
        return cells[kept]

    def _straight(self, start: NDArray[np.intp], end: NDArray[np.intp]) -> float:
        """Cost of a straight line, `inf` if some cell along it cannot be stood on."""
        steps = 2 * int(np.abs(end - start).max()) + 1
        along = np.linspace(0.0, 1.0, steps)[:, None]
        line = np.rint(start + along * (end - start)).astype(np.intp)
        mean = float(self._costs[line[:, 0], line[:, 1]].mean())
        return mean * self._cell_m * math.dist(start, end)

    def _snapped(self, cell: tuple[int, int], among: NDArray[np.bool_]) -> int | None:
        """Number of the nearest of some cells within half a metre, `None` if there is none."""
        row, column = cell[0] - self._corner[0], cell[1] - self._corner[1]
        rows, columns = len(self._numbers), len(self._numbers.T)
        if 0 <= row < rows and 0 <= column < columns:
            number = int(self._numbers[row, column])
            if number >= 0 and among[number]:
                return number
        away = ((self._cells - np.array(cell)) ** 2).sum(axis=1).astype(np.float64)
        away[~among] = np.inf
        if not len(away) or away.min() > (_SNAP_M / self._cell_m) ** 2:
            return None
        return int(away.argmin())

    def _graph(self) -> csr_array:
        """Costs between neighbours; no corner of what cannot be stood on is cut."""
        costs = self._costs[self._cells[:, 0], self._cells[:, 1]]
        numbers = self._numbers
        starts, ends, lengths = [], [], []
        for down, right, factor in _NEIGHBOURS:
            one, two = _pairs(numbers, down, right)
            joined = (one >= 0) & (two >= 0)
            if down and right:
                beside, below = _corners(numbers, right)
                joined &= (beside >= 0) & (below >= 0)
            starts.append(one[joined])
            ends.append(two[joined])
            lengths.append(0.5 * factor * self._cell_m * (costs[starts[-1]] + costs[ends[-1]]))
        count = len(self._cells)
        return csr_array(
            (np.concatenate(lengths), (np.concatenate(starts), np.concatenate(ends))),
            shape=(count, count),
        )


def _bounded(grid: NDArray[np.bool_]) -> tuple[tuple[int, int], NDArray[np.bool_]]:
    """The least part of a grid that holds all its cells, and the row and column it begins at."""
    rows, columns = np.flatnonzero(grid.any(axis=1)), np.flatnonzero(grid.any(axis=0))
    if not len(rows):
        return (0, 0), grid[:0, :0]
    top, left = int(rows[0]), int(columns[0])
    return (top, left), grid[top : int(rows[-1]) + 1, left : int(columns[-1]) + 1]


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
