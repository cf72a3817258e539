"""The screening report: one row per motion and check, as a Parquet file and as a table to print."""

from __future__ import annotations

import collections
import math
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.builders.screening.findings import Finding
from affectsim_data.motions.motion import Motion

__all__ = ["REPORT_SCHEMA", "ScreenReport"]

_READ = "read"
_COLUMNS: tuple[tuple[str, pa.DataType, bool, str], ...] = (
    ("motion_id", pa.string(), True, "The motion; null for a file that could not be read"),
    ("source", pa.string(), False, "Corpus and file it came from"),
    ("performer", pa.string(), True, "Who performed; null for a file that could not be read"),
    ("action", pa.string(), True, "What is done; null for a file that could not be read"),
    ("emotion", pa.string(), True, "The label; null for a file that could not be read"),
    ("check", pa.string(), False, "A table of builders/screening.toml, or `read`"),
    ("value", pa.float64(), True, "What was measured, in `unit`; null where it was not"),
    ("limit", pa.float64(), True, "Largest value that passes, in `unit`; null for `read`"),
    ("unit", pa.string(), False, "Of value and limit: m, s, deg, share (of 1) or sigma"),
    ("passed", pa.bool_(), False, "Whether the motion passes this check"),
    ("frame", pa.int64(), True, "First frame, in the source if that was checked; null for none"),
    ("time_s", pa.float64(), True, "Time of that frame from the start, seconds; null for none"),
    ("joint", pa.string(), True, "Body joint it concerns; null for the whole body"),
    ("reason", pa.string(), False, "Why, in a sentence"),
)  # fmt: skip
REPORT_SCHEMA: pa.Schema = pa.schema(
    [
        pa.field(name, kind, nullable=nullable, metadata={"description": description})
        for name, kind, nullable, description in _COLUMNS
    ]
)
"""Columns of the report, each with a description."""


class ScreenReport:
    """What screening said of every motion, and which files could not be read."""

    def __init__(self) -> None:
        self._motions: dict[str, Mapping[str, str]] = {}
        self._findings: dict[str, list[Finding]] = {}
        self._failures: list[tuple[str, str]] = []

    def add(self, motion: Motion, findings: Iterable[Finding]) -> None:
        """Takes in what `screen_motion` said of a motion.

        Raises:
            ValueError: The motion is in the report already.
        """
        if motion.motion_id in self._motions:
            raise ValueError(f"motion {motion.motion_id!r} is in the screening report already")
        self._motions[motion.motion_id] = {
            "motion_id": motion.motion_id,
            "source": motion.source,
            "performer": motion.performer_id,
            "action": motion.action,
            "emotion": motion.emotion,
        }
        self._findings[motion.motion_id] = list(findings)

    def add_outliers(self, findings: Mapping[str, Iterable[Finding]]) -> None:
        """Takes in what `screen_outliers` said, by motion id.

        Raises:
            KeyError: A motion is not in the report.
        """
        for motion_id, more in findings.items():
            self._findings[motion_id].extend(more)

    def add_failure(self, relative_path: str, reason: str) -> None:
        """Takes in a file that could not be read, and why."""
        self._failures.append((relative_path, reason))

    @property
    def rejected(self) -> frozenset[str]:
        """Ids of the motions that fail a check."""
        return frozenset(i for i in self._findings if self.failed(i))

    @property
    def num_motions(self) -> int:
        """Motions screened, without the files that could not be read."""
        return len(self._motions)

    def failed(self, motion_id: str) -> tuple[Finding, ...]:
        """What a motion fails.

        Raises:
            KeyError: The motion is not in the report.
        """
        return tuple(finding for finding in self._findings[motion_id] if not finding.passed)

    def rows(self) -> list[dict[str, Any]]:
        """One row per motion and check, in the order of `REPORT_SCHEMA`; then unreadable files."""
        rows = [
            {**self._motions[motion_id], **_finding_row(finding)}
            for motion_id, findings in self._findings.items()
            for finding in findings
        ]
        return rows + [_failure_row(path, reason) for path, reason in self._failures]

    def write_report(self, path: Path | str) -> None:
        """Writes the report as Parquet, whole or not at all.

        Raises:
            OSError: The file cannot be written.
        """
        path = Path(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        half = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        try:
            pq.write_table(pa.Table.from_pylist(self.rows(), REPORT_SCHEMA), half)
            os.replace(half, path)
        finally:
            half.unlink(missing_ok=True)

    def summary_lines(self) -> list[str]:
        """A table: of how many motions each check was made, and how many it rejects."""
        checked: collections.Counter[str] = collections.Counter()
        rejects: collections.Counter[str] = collections.Counter()
        order: dict[str, None] = {}
        for findings in self._findings.values():
            for finding in findings:
                order[finding.check] = None
                checked[finding.check] += not math.isnan(finding.value)
                rejects[finding.check] += not finding.passed
        files = len(self._motions) + len(self._failures)
        lines = [f"{'check':<20}{'rejected':>10}{'of':>8}{'share':>9}"]
        if self._failures:
            lines.append(_line(_READ, len(self._failures), files))
        lines += [_line(check, rejects[check], checked[check]) for check in order]
        lines.append(_line("any", len(self.rejected), len(self._motions)))
        lines += [f"unreadable: {path}: {reason}" for path, reason in self._failures]
        return lines


def _line(check: str, rejected: int, total: int) -> str:
    share = f"{100.0 * rejected / total:.1f} %" if total else "-"
    return f"{check:<20}{rejected:>10}{total:>8}{share:>9}"


def _finding_row(finding: Finding) -> dict[str, Any]:
    return {
        "check": finding.check,
        "value": None if math.isnan(finding.value) else finding.value,
        "limit": finding.limit,
        "unit": finding.unit,
        "passed": finding.passed,
        "frame": finding.frame if finding.frame >= 0 else None,
        "time_s": None if math.isnan(finding.time_s) else finding.time_s,
        "joint": finding.joint or None,
        "reason": finding.reason,
    }


def _failure_row(path: str, reason: str) -> dict[str, Any]:
    empty = dict.fromkeys(REPORT_SCHEMA.names)
    return empty | {
        "source": path,
        "check": _READ,
        "unit": "",
        "passed": False,
        "reason": reason,
    }
