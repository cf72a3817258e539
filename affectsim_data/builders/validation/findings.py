"""What a check measured, what failed, and how a release did in all."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.poses import FloatArray

__all__ = ["Check", "Failure", "Level", "Measure", "Outcome", "gather"]

Level = Literal["release", "asset", "episode"]
"""What the items of a check are."""


@dataclasses.dataclass(frozen=True)
class Check:
    """One thing that must hold, in words; limits come with what was measured."""

    name: str
    """Stable: reports and pictures are called by it."""
    group: str
    """Kind of check, for the table."""
    level: Level
    """What its items are."""
    unit: str
    """Of its values: `m`, `deg`, `share`, `s`, or what is counted."""
    counts: str
    """What its values are."""
    advice: str
    """What to do about a failure."""


@dataclasses.dataclass(frozen=True, eq=False)
class Measure:
    """Values of one check for some items, and between which limits they must lie."""

    check: str
    """Name of the check."""
    items: tuple[str, ...]
    """Episodes, assets or parts of the release."""
    values: FloatArray
    """`(n,)`; one that is not a number fails."""
    low: FloatArray
    """Least value that passes, `(n,)`; `-inf` where there is none."""
    high: FloatArray
    """Greatest value that passes, `(n,)`; `inf` where there is none."""
    notes: tuple[str, ...] = ()
    """What was found, a text per item; none if the value says it all."""

    @classmethod
    def of(
        cls,
        check: str,
        items: Iterable[str],
        values: ArrayLike,
        *,
        low: ArrayLike = -np.inf,
        high: ArrayLike = np.inf,
        notes: Sequence[str] = (),
    ) -> Measure:
        """Values against limits that are the same for all items or differ by item."""
        names = tuple(items)
        shape = (len(names),)
        each, least, most = (
            np.broadcast_to(np.asarray(array, np.float64), shape) for array in (values, low, high)
        )
        return cls(check, names, each, least, most, tuple(notes))

    @property
    def excess(self) -> FloatArray:
        """How far values are out of their limits, `(n,)`; not above 0 where they are not."""
        return np.maximum(self.low - self.values, self.values - self.high)

    @property
    def failed(self) -> NDArray[np.intp]:
        """Places of the items that fail."""
        return np.flatnonzero(~(self.excess <= 0.0))


@dataclasses.dataclass(frozen=True)
class Failure:
    """One item that does not hold."""

    check: str
    level: Level
    item: str
    value: float
    low: float
    high: float
    message: str
    """What was expected, what was found, what to do."""


@dataclasses.dataclass(frozen=True)
class Outcome:
    """How a check went over all its items."""

    check: Check
    checked: int
    """Items looked at."""
    failures: tuple[Failure, ...]
    worst: float
    """The value nearest to its limit or farthest beyond; `nan` if nothing was looked at."""
    worst_item: str
    """Where."""
    low: float
    """Least value that passes there."""
    high: float
    """Greatest value that passes there."""

    @property
    def limit(self) -> str:
        """Both in words: `at most 0.05`."""
        return _limit(self.low, self.high) if self.checked else ""

    @property
    def holds(self) -> bool:
        """Whether nothing failed."""
        return not self.failures


def gather(check: Check, measures: Sequence[Measure]) -> Outcome:
    """The outcome of a check from its measures, which may come scene by scene.

    Failures are in the order of the measures.
    """
    filled = [measure for measure in measures if measure.items]
    if not filled:
        return Outcome(check, 0, (), np.nan, "", np.nan, np.nan)
    excess = np.concatenate([measure.excess for measure in filled])
    place = int(np.argmax(np.where(np.isnan(excess), np.inf, excess)))
    failures = [_failure(check, one, int(i)) for one in filled for i in one.failed]
    for measure in filled:
        if place < len(measure.items):
            break
        place -= len(measure.items)
    return Outcome(
        check,
        checked=len(excess),
        failures=tuple(failures),
        worst=float(measure.values[place]),
        worst_item=measure.items[place],
        low=float(measure.low[place]),
        high=float(measure.high[place]),
    )


def _failure(check: Check, measure: Measure, place: int) -> Failure:
    value, low, high = (
        float(array[place]) for array in (measure.values, measure.low, measure.high)
    )
    unit = "" if check.unit == "share" else f" {check.unit}"
    message = f"{check.counts}: expected {_limit(low, high)}{unit}, got {value:.6g}"
    if measure.notes and measure.notes[place]:
        message += f" ({measure.notes[place]})"
    item = measure.items[place]
    return Failure(check.name, check.level, item, value, low, high, f"{message}; {check.advice}")


def _limit(low: float, high: float) -> str:
    if low == high:
        return f"{low:g}"
    if low == -np.inf:
        return f"at most {high:g}"
    return f"at least {low:g}" if high == np.inf else f"{low:g} to {high:g}"
