"""What a build has to tell: what is missing and why, and pictures of what screening rejected."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import get_args

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.avatars import Avatar
from affectsim_data.builders.building import BuildReport
from affectsim_data.builders.casting import Cast
from affectsim_data.builders.imports import ImportStatus
from affectsim_data.content import content_path

__all__ = ["build_lines", "cost_lines", "picture_rejected", "write_scene_report"]

_BODY = "ben"
"""Whom rejected motions are shown on."""
_STATUSES: tuple[ImportStatus, ...] = get_args(ImportStatus)
_NAMES_SHOWN = 12
_REPORT_SCHEMA = pa.schema(
    [(name, pa.string()) for name in ("scene_id", "status", "kind", "name")]
    + [("count", pa.int64())]
    + [(name, pa.string()) for name in ("reason", "asked_by", "source")]
)


def cost_lines(report: BuildReport) -> list[str]:
    """A table, indented, of what each stage made and cost."""
    lines = [f"  {'stage':10}{'units':>8}{'kept':>8}{'seconds':>10}{'units/s':>10}{'memory':>10}"]
    for one in report.costs:
        rate = f"{one.units_per_s:.1f}" if one.units else "-"
        memory = f"{one.peak_bytes / 2**30:.2f} GB" if one.peak_bytes else "-"
        lines.append(
            f"  {one.name:10}{one.units:8}{one.resumed:8}{one.seconds:10.1f}{rate:>10}{memory:>10}"
        )
    return lines


def build_lines(report: BuildReport) -> list[str]:
    """What is not in the release, indented lines; none if all the recipe asked for is there."""
    lines = [
        f"  {one.planned - one.composed} of {one.planned} not placed: "
        f"{one.split}, {one.challenge or one.family}, {one.action}, {one.emotion}: "
        f"{one.binding_constraint}"
        for one in report.shortfalls
    ]
    cast = report.cast
    if cast.left_out:
        lines.append(f"  {cast.left_out}")
    lines += [f"  not read: {failure.reason}" for failure in cast.failures]
    lines += [
        f"  rejected: {motion.motion_id}: {finding.check}: {finding.reason}"
        for motion in cast.rejected
        for finding in cast.screening.failed(motion.motion_id)
    ]
    lines += [f"  scene left out: {one.scene_id}: {one.reason}" for one in report.failed_scenes]
    return lines + _imported_lines(report)


def _imported_lines(report: BuildReport) -> list[str]:
    """A table of imported scenes, then what was missing or skipped, most often first."""
    imported = [one.imported for one in report.scenes if one.imported is not None]
    if not imported:
        return []
    lines = [f"  {'scene':32} {'found':>7} {'missing':>7} {'skipped':>7} {'ignored':>7} triangles"]
    for one in imported:
        counts = " ".join(f"{one.total(status):7}" for status in _STATUSES)
        lines.append(f"  {one.scene_id:32} {counts} {one.triangles:9,}")
    lacking = Counter(
        (entry.status, entry.kind, entry.name, entry.reason)
        for one in imported
        for entry in one.entries
        if entry.status in ("missing", "skipped")
    )
    for (status, kind, name, reason), count in lacking.most_common(_NAMES_SHOWN):
        why = f" ({reason})" if reason else ""
        lines.append(f"  {status} in {count} scenes: {kind} {name}{why}")
    if len(lacking) > _NAMES_SHOWN:
        lines.append(f"  and {len(lacking) - _NAMES_SHOWN} more; --scene-report has them all")
    return lines


def write_scene_report(report: BuildReport, path: Path) -> int:
    """Writes what became of the things of imported scenes and how scenes were baked, as Parquet.

    Returns:
        Rows.
    """
    rows = [row for one in report.scenes if one.imported for row in one.imported.to_rows()]
    for one in report.scenes:
        baked = one.baked.to_json()
        for moment in ("before", "after"):
            rows += [
                {"scene_id": one.scene_id, "status": moment, "kind": "baked", "name": name,
                 "count": count}
                for name, count in baked[moment].items()
            ]  # fmt: skip
    path.parent.mkdir(parents=True, exist_ok=True)
    pq.write_table(pa.Table.from_pylist(rows, schema=_REPORT_SCHEMA), path)
    return len(rows)


def picture_rejected(cast: Cast, folder: Path) -> list[Path]:
    """A picture per rejected motion in a folder; no folder if there is none."""
    if not cast.rejected:
        return []
    from affectsim_data.inspection.screening_pictures import rejected_pictures
    from affectsim_data.render import open_renderer

    path = content_path("builders", f"avatars/{_BODY}.glb")
    avatar = Avatar.from_glb(path.read_bytes(), name=str(path))
    rejected = [(motion, cast.screening.failed(motion.motion_id)) for motion in cast.rejected]
    return rejected_pictures(rejected, avatar, open_renderer(), folder)
