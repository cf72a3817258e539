"""One model of a table, whoever writes it: what a number is stays apart from how it is printed."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Mapping
from typing import Literal

from affectsim_data.evaluation.results import Estimate

__all__ = ["FOOTNOTES", "Cell", "Column", "ColumnKind", "Mark", "Role", "Row", "Table", "number"]

ColumnKind = Literal["text", "count", "percent", "points", "ratio", "metres", "milliseconds", "p"]
"""`percent` and `points` (signed differences) hold shares in [0, 1] and [-1, 1]."""
Interval = Literal["none", "kept", "shown"]
"""Whether cells carry intervals; kept ones only tables of raw numbers show."""
Role = Literal["entry", "heading", "mean", "reference"]
Mark = Literal["", "†", "a", "b", "c", "d", "e", "f", "g"]
"""What a cell says beside its number; letters say why there is none."""

FOOTNOTES: Mapping[Mark, str] = {
    "†": "not shown to be better than chance: the interval reaches down to it, or there is none",
    "a": "no predictions under a condition that this needs",
    "b": "undefined: P-Ref is not better than P-Init",
    "c": "undefined: no episode to compute it from",
    "d": "not reported by the paper",
    "e": "the gap may be zero, so that its ratio with the gain is not bounded",
    "f": "needs the trajectories of the policy",
    "g": "not told in the table of predictions",
}


@dataclasses.dataclass(frozen=True)
class Column:
    """What a column holds, and how its numbers are printed."""

    name: str
    """In tables of raw numbers: lower case, words joined by `_`."""
    title: str
    kind: ColumnKind = "text"
    detail: str = ""
    """Second line of the title."""
    digits: int = 1
    """Decimals of what is printed."""
    interval: Interval = "none"
    from_data: bool = False
    """Whether the title comes from data, not from us."""


@dataclasses.dataclass(frozen=True)
class Cell:
    """A value with its interval; NaN is undefined, and `None` leaves the place blank."""

    value: str | float | int | None = None
    low: float = math.nan
    high: float = math.nan
    mark: Mark = ""
    best: bool = False
    """Printed bold."""

    @property
    def is_undefined(self) -> bool:
        """Whether there should be a number and is none."""
        return isinstance(self.value, float) and math.isnan(self.value)


@dataclasses.dataclass(frozen=True)
class Row:
    """A line of a table; a heading has one cell, which spans all columns."""

    cells: tuple[Cell, ...]
    role: Role = "entry"


@dataclasses.dataclass(frozen=True)
class Table:
    """A table of a report."""

    name: str
    """Stem of its files; ours, never from data."""
    title: str
    caption: str
    columns: tuple[Column, ...]
    rows: tuple[Row, ...]
    notes: tuple[str, ...] = ()
    """What a reader must know beyond the footnotes."""
    num_keys: int = 1
    """How many of the first columns say what a row is about."""
    topic: str = ""
    """What it belongs to, the same for tables that stand together."""

    def __post_init__(self) -> None:
        for row in self.rows:
            expected = 1 if row.role == "heading" else len(self.columns)
            if len(row.cells) != expected:
                raise ValueError(
                    f"table {self.name}: a row of role {row.role} must have {expected} cells, "
                    f"got {len(row.cells)}"
                )

    @property
    def footnotes(self) -> tuple[tuple[Mark, str], ...]:
        """The marks its cells bear, with what they mean."""
        borne = {cell.mark for row in self.rows for cell in row.cells}
        return tuple((mark, text) for mark, text in FOOTNOTES.items() if mark in borne)

    @property
    def entries(self) -> Iterator[Row]:
        """Its rows without the headings."""
        return (row for row in self.rows if row.role != "heading")


def number(estimate: Estimate | None, *, why: Mark = "c", best: bool = False) -> Cell:
    """The cell of an estimate.

    Args:
        estimate: `None` for one that is not there for want of predictions.
        why: Mark of a number that is undefined.
        best: Whether it is printed bold.
    """
    if estimate is None:
        return Cell(math.nan, mark="a")
    mark: Mark = why if math.isnan(estimate.value) else ""
    return Cell(estimate.value, estimate.low, estimate.high, mark, best)
