"""The report of a validation: a table to print, a Parquet file, JSON."""

from __future__ import annotations

import dataclasses
import math
import os
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.builders.validation.catalogue import GROUPS
from affectsim_data.builders.validation.findings import Failure, Outcome

__all__ = ["REPORT_SCHEMA", "ValidationReport"]

_COLUMNS: tuple[tuple[str, pa.DataType, str], ...] = (
    ("kind", pa.string(), "`check`: a check over all its items; `failure`: one item that fails"),
    ("check", pa.string(), "Name of the check"),
    ("level", pa.string(), "What its items are: release, asset or episode"),
    ("item", pa.string(), "The item that fails; of a check the worst one, null if it has none"),
    ("value", pa.float64(), "What was measured there, in `unit`; null if nothing was"),
    ("low", pa.float64(), "Least value that passes; null for none"),
    ("high", pa.float64(), "Greatest value that passes; null for none"),
    ("unit", pa.string(), "Of value and limits"),
    ("checked", pa.int64(), "Items of the check; null for a failure"),
    ("failures", pa.int64(), "Of these, how many fail; null for a failure"),
    ("message", pa.string(), "What was expected, what was found, what to do"),
)
REPORT_SCHEMA: pa.Schema = pa.schema(
    [
        pa.field(name, kind, metadata={"description": description})
        for name, kind, description in _COLUMNS
    ]
)
"""Columns of the Parquet report."""
_SHOWN, _ITEM_WIDTH = 3, 40
_HEADER = ("check", "items", "failed", "worst", "limit", "where")


@dataclasses.dataclass(frozen=True)
class ValidationReport:
    """What validation said of a release."""

    uri: str
    """The release."""
    num_episodes: int
    outcomes: tuple[Outcome, ...]
    """Of all checks, in the order of the catalogue."""
    skipped: str = ""
    """Why most checks were not made; empty if they were."""

    @property
    def holds(self) -> bool:
        """Whether every check was made and holds."""
        return not self.skipped and all(outcome.holds for outcome in self.outcomes)

    @property
    def failures(self) -> tuple[Failure, ...]:
        """Of all checks, in order."""
        return tuple(failure for outcome in self.outcomes for failure in outcome.failures)

    def write(self, path: Path) -> int:
        """Writes the report as Parquet, whole or not at all; returns its rows."""
        rows = [_check_row(outcome) for outcome in self.outcomes]
        rows += [
            _failure_row(failure, outcome.check.unit)
            for outcome in self.outcomes
            for failure in outcome.failures
        ]
        path.parent.mkdir(parents=True, exist_ok=True)
        staging = path.with_name(f".{path.name}.partial")
        pq.write_table(pa.Table.from_pylist(rows, schema=REPORT_SCHEMA), staging)
        os.replace(staging, path)
        return len(rows)

    def to_json(self) -> dict[str, Any]:
        """The same as JSON can hold it."""
        return {
            "release": self.uri,
            "episodes": self.num_episodes,
            "holds": self.holds,
            "skipped": self.skipped,
            "checks": [_check_row(outcome) for outcome in self.outcomes],
            "failures": [
                _failure_row(failure, outcome.check.unit)
                for outcome in self.outcomes
                for failure in outcome.failures
            ],
        }

    def lines(self) -> list[str]:
        """A table of all checks, then the first failures of each."""
        lines = [f"{self.uri}: {self.num_episodes} episodes"]
        for group in GROUPS:
            members = [one for one in self.outcomes if one.check.group == group]
            if any(one.checked for one in members):
                lines += ["", group, *_table(members)]
        failed = [outcome for outcome in self.outcomes if not outcome.holds]
        for outcome in failed:
            lines += ["", f"{outcome.check.name}: {len(outcome.failures)} of {outcome.checked}"]
            lines += [f"  {one.item}: {one.message}" for one in outcome.failures[:_SHOWN]]
            if len(outcome.failures) > _SHOWN:
                lines.append(f"  ... and {len(outcome.failures) - _SHOWN} more")
        return [*lines, "", self._verdict(len(failed))]

    def _verdict(self, num_failed: int) -> str:
        if self.skipped:
            return f"not valid: {self.skipped}"
        count = sum(one.checked > 0 for one in self.outcomes)
        if num_failed:
            return f"not valid: {num_failed} of {count} checks fail"
        return f"valid: all {count} checks hold"


def _table(outcomes: list[Outcome]) -> list[str]:
    rows = [_HEADER, *(_cells(outcome) for outcome in outcomes)]
    widths = [max(len(row[column]) for row in rows) for column in range(len(_HEADER))]
    # Numbers to the right, words to the left.
    return [
        "  "
        + "  ".join(
            cell.rjust(width) if column in (1, 2, 3) else cell.ljust(width)
            for column, (cell, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def _cells(outcome: Outcome) -> tuple[str, ...]:
    check = outcome.check
    if not outcome.checked:
        return check.name, "0", "-", "-", "", ""
    where = outcome.worst_item
    if len(where) > _ITEM_WIDTH:
        where = f"...{where[-_ITEM_WIDTH + 3 :]}"
    unit = "" if check.unit == "share" else f" {check.unit}"
    worst = "nothing" if math.isnan(outcome.worst) else f"{outcome.worst:.4g}"
    failed = str(len(outcome.failures))
    return check.name, str(outcome.checked), failed, worst, outcome.limit + unit, where


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _check_row(outcome: Outcome) -> dict[str, Any]:
    check = outcome.check
    return {
        "kind": "check",
        "check": check.name,
        "level": check.level,
        "item": outcome.worst_item or None,
        "value": _number(outcome.worst),
        "low": _number(outcome.low),
        "high": _number(outcome.high),
        "unit": check.unit,
        "checked": outcome.checked,
        "failures": len(outcome.failures),
        "message": check.counts,
    }


def _failure_row(failure: Failure, unit: str) -> dict[str, Any]:
    return {
        "kind": "failure",
        "check": failure.check,
        "level": failure.level,
        "item": failure.item,
        "value": _number(failure.value),
        "low": _number(failure.low),
        "high": _number(failure.high),
        "unit": unit,
        "checked": None,
        "failures": None,
        "message": failure.message,
    }
