"""What the motions of a release are like: counts, descriptors per emotion, who differs how much."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from tqdm import tqdm

from affectsim_data.inspection.variance import variance_components
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.motions.descriptors import (
    MAIN_DESCRIPTORS,
    WalkKinematics,
    descriptor_table,
    walk_kinematics,
)
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release

__all__ = [
    "GAIT_COLUMNS",
    "descriptor_label",
    "motion_descriptors",
    "motion_summary",
    "motion_summary_lines",
]

GAIT_COLUMNS: tuple[str, ...] = tuple(
    f"walk_{field.name}" for field in dataclasses.fields(WalkKinematics)
)
"""Columns of `motion_descriptors` that only walks have; null for all else."""
_UNITS = {"_m_s3": "m/s3", "_m_s2": "m/s2", "_m_s": "m/s", "_deg": "deg", "_steps_min": "/min"}
_LABEL, _CELL = 30, 15


def motion_descriptors(release: Release, *, progress: bool = True) -> pa.Table:
    """Descriptors of all motions of a release, one row each, and the gait of those that walk.

    Columns are those of `descriptor_table` and `GAIT_COLUMNS`.

    Args:
        release: Where the motions are; they are read one after the other.
        progress: Whether to show a bar.

    Raises:
        ValueError: A motion has no descriptors, or is called a walk and does not walk.
    """
    names = release.asset_ids("motions")
    bar = tqdm(names, desc="motions", unit="motion", disable=not progress)
    gaits: list[dict[str, float | None]] = []

    def read(name: str) -> Motion:
        motion = release.motion(name)
        gaits.append(_gait(motion))
        return motion

    table = descriptor_table(read(name) for name in bar)
    columns = pa.Table.from_pylist(gaits, pa.schema([(c, pa.float64()) for c in GAIT_COLUMNS]))
    for name in GAIT_COLUMNS:
        table = table.append_column(name, columns.column(name))
    return table


def motion_summary(source: Release | pa.Table) -> dict[str, Any]:
    """Counts, means and deviations of the main descriptors, and components of their variance.

    Everything is plain numbers and texts, fit for JSON. `emotions` and `actions` each say how many
    motions and performers there are, how long they last, and for each of `MAIN_DESCRIPTORS` its
    `mean` and `sd`; `gait` says the same of walks, per emotion. `variance` says per descriptor how
    much emotions and performers differ within an action, see `variance_components`.

    Args:
        source: A release, or what `motion_descriptors` gave for it.

    Raises:
        ValueError: A motion has no descriptors.
    """
    table = motion_descriptors(source) if isinstance(source, Release) else source
    emotions = np.array(table.column("emotion").to_pylist())
    actions = np.array(table.column("action").to_pylist())
    performers = np.array(table.column("performer_id").to_pylist())
    values = _values(table, MAIN_DESCRIPTORS)
    gait = _values(table, GAIT_COLUMNS)
    found: dict[str, Any] = {
        "motions": table.num_rows,
        "performers": len(set(performers)),
        "emotions": {},
        "actions": {},
        "gait": {},
    }
    for emotion in (one for one in EMOTIONS if one in emotions):
        rows = emotions == emotion
        found["emotions"][emotion] = _group(table, rows, values, counted="action")
        walks = rows & np.isfinite(gait[:, 0])
        if walks.any():
            found["gait"][emotion] = _moments(GAIT_COLUMNS, gait[walks])
    for action in sorted(set(actions)):
        rows = actions == action
        found["actions"][action] = _group(table, rows, values, counted="emotion")
    components = variance_components(values, emotions, performers, actions)
    found["variance"] = {
        name: {key: _number(column[place]) for key, column in components.items()}
        for place, name in enumerate(MAIN_DESCRIPTORS)
    }
    return found


def motion_summary_lines(summary: dict[str, Any]) -> list[str]:
    """The summary as lines for a terminal, at most 120 characters wide."""
    groups = summary["emotions"]
    lines = [f"{summary['motions']} motions by {summary['performers']} performers", ""]
    lines.append(_line("", [*groups, "perf./emotion"]))
    lines.append(_line("motions", [str(group["motions"]) for group in groups.values()]))
    lines.append(_line("performers", [str(group["performers"]) for group in groups.values()]))
    lines.append(_line("duration, s", [_cell(group["duration_s"]) for group in groups.values()]))
    for name in MAIN_DESCRIPTORS:
        ratio = summary["variance"][name]["performer_to_emotion"]
        cells = [_cell(group["descriptors"][name]) for group in groups.values()]
        lines.append(
            _line(descriptor_label(name), [*cells, "-" if ratio is None else f"{ratio:.2f}"])
        )
    if summary["gait"]:
        lines += ["", _line("walks", list(summary["gait"]))]
        for name in GAIT_COLUMNS:
            cells = [_cell(group[name]) for group in summary["gait"].values()]
            lines.append(_line(descriptor_label(name.removeprefix("walk_")), cells))
    lines += ["", _line("motions by action", list(groups))]
    for action, group in summary["actions"].items():
        lines.append(_line(action, [str(group["emotion"].get(one, 0)) for one in groups]))
    return [
        *lines,
        "",
        "mean ± standard deviation; perf./emotion: how much performers of an action differ, as a "
        "share of how much emotions do",
    ]


def _gait(motion: Motion) -> dict[str, float | None]:
    if "walk" not in motion.action:
        return dict.fromkeys(GAIT_COLUMNS)
    gait = dataclasses.asdict(walk_kinematics(motion))
    return {f"walk_{name}": value for name, value in gait.items()}


def _values(table: pa.Table, names: Sequence[str]) -> FloatArray:
    """Columns as `(num_motions, len(names))`; null becomes nan."""
    return np.stack([table.column(name).to_numpy() for name in names], axis=1).astype(np.float64)


def _group(
    table: pa.Table, rows: NDArray[np.bool_], values: FloatArray, *, counted: str
) -> dict[str, Any]:
    part = table.filter(pa.array(rows))
    durations = part.column("duration_s").to_numpy()
    return {
        "motions": part.num_rows,
        "performers": len(set(part.column("performer_id").to_pylist())),
        counted: dict(sorted(Counter(part.column(counted).to_pylist()).items())),
        "duration_s": _moments(("duration_s",), durations[:, None])["duration_s"],
        "descriptors": _moments(MAIN_DESCRIPTORS, values[rows]),
    }


def _moments(names: Sequence[str], values: FloatArray) -> dict[str, dict[str, float | None]]:
    mean = values.mean(axis=0)
    spread = values.std(axis=0, ddof=1) if len(values) > 1 else np.full(len(mean), np.nan)
    return {
        name: {"mean": _number(mean[place]), "sd": _number(spread[place])}
        for place, name in enumerate(names)
    }


def _number(value: float) -> float | None:
    """JSON has no nan."""
    return float(value) if np.isfinite(value) else None


def descriptor_label(name: str) -> str:
    """The name of a mean descriptor for readers, with its unit.

    Examples:
        >>> descriptor_label("hands_jerk_mean_m_s3")
        'hands jerk, m/s3'
    """
    for ending, unit in (*_UNITS.items(), ("_m", "m"), ("", "share")):
        if name.endswith(ending):
            words = name[: len(name) - len(ending)].removesuffix("_mean")
            return f"{words.replace('_', ' ')}, {unit}"
    raise AssertionError(name)


def _cell(entry: dict[str, float | None]) -> str:
    mean, spread = entry["mean"], entry["sd"]
    if mean is None:
        return "-"
    digits = 3 if abs(mean) < 1.0 else 2 if abs(mean) < 10.0 else 1
    return f"{mean:.{digits}f}" + ("" if spread is None else f" ±{spread:.{digits}f}")


def _line(label: str, cells: Sequence[str]) -> str:
    return (label.ljust(_LABEL) + "".join(cell.rjust(_CELL) for cell in cells)).rstrip()
