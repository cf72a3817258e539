"""Rows of a trajectory table by episode and step, and which of them can be no robot's."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.schemas import RobotAction

__all__ = ["NUMBERS", "POSITION", "RecordedRows"]

POSITION = ("position_x_m", "position_y_m", "position_z_m")
"""Columns of where the robot is."""
NUMBERS = ("time_s", *POSITION, "yaw_deg")
"""Columns that must be finite."""


@dataclasses.dataclass(frozen=True, eq=False)
class RecordedRows:
    """What one policy did in some episodes; `n` rows of `k` episodes."""

    table: pa.Table
    """The rows by episode and step, nothing null."""
    numbers: NDArray[np.int64]
    """Of each row in its file, from 1, `(n,)`."""
    episode_ids: tuple[str, ...]
    """Sorted."""
    starts: NDArray[np.intp]
    """First row of each episode, `(k,)`."""

    @classmethod
    def of(cls, table: pa.Table, numbers: NDArray[np.int64]) -> RecordedRows:
        """Sorts rows, which may be in any order.

        Args:
            table: At least the columns `episode_id` and `step`, without nulls.
            numbers: Of each row in its file.
        """
        ids = pc.unique(table.column("episode_id")).sort()
        codes = pc.index_in(table.column("episode_id"), value_set=ids).to_numpy()
        order = np.lexsort((table.column("step").to_numpy(), codes))
        starts = np.flatnonzero(np.diff(codes[order], prepend=-1) > 0)
        table = table.take(pa.array(order)).combine_chunks()
        return cls(table, numbers[order], tuple(ids.to_pylist()), starts)

    def __len__(self) -> int:
        return int(self.table.num_rows)

    @functools.cached_property
    def lengths(self) -> NDArray[np.intp]:
        """Rows of each episode, `(k,)`."""
        return np.diff(self.starts, append=len(self))

    @functools.cached_property
    def is_first(self) -> NDArray[np.bool_]:
        """Whether a row is the first of its episode, `(n,)`."""
        first = np.zeros(len(self), bool)
        first[self.starts] = True
        return first

    def column(self, name: str) -> NDArray[Any]:
        """Values of a column, `(n,)`."""
        values: NDArray[Any] = self.table.column(name).to_numpy()
        return values

    def owners(self, rows: NDArray[np.intp]) -> NDArray[np.intp]:
        """The places of the episodes that rows are of."""
        return np.searchsorted(self.starts, rows, side="right") - 1

    def says(self, name: str, word: str) -> NDArray[np.bool_]:
        """Whether a row says a word in a column, `(n,)`."""
        return np.asarray(pc.equal(self.table.column(name), word), bool)

    def does(self, action: RobotAction) -> NDArray[np.bool_]:
        """Whether a row is of an action, `(n,)`."""
        return self.says("action", action)

    def after_first(self, event: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Rows from the first on, in their episode, that is an event; all `(n,)`."""
        count: NDArray[np.int64] = np.cumsum(event)
        before = (count - event)[self.starts]
        return np.asarray(count > np.repeat(before, self.lengths), bool)

    def previous(self, values: NDArray[Any], first: Any) -> NDArray[Any]:
        """Values one step earlier, `(n, ...)`; `first` where there is none, one or one each."""
        earlier = np.roll(values, 1, axis=0)
        earlier[self.starts] = first
        return earlier

    @functools.cached_property
    def expected_steps(self) -> NDArray[np.int64]:
        """0, 1, ... for the first row whose step is another, `(n,)`."""
        steps = self.column("step").astype(np.int64)
        return np.asarray(self.previous(steps + 1, 0), np.int64)

    @functools.cached_property
    def wrong_step(self) -> NDArray[np.bool_]:
        """Rows that do not follow the row before, `(n,)`."""
        return np.asarray(self.column("step") != self.expected_steps, bool)

    def unknown(self, name: str, words: Sequence[str]) -> NDArray[np.bool_]:
        """Rows that say none of some words in a column, `(n,)`."""
        known = pc.is_in(self.table.column(name), value_set=pa.array(words))
        return np.asarray(pc.invert(known), bool)

    def not_finite(self, name: str) -> NDArray[np.bool_]:
        """Rows whose number is none, `(n,)`."""
        return np.asarray(~np.isfinite(self.column(name)), bool)
