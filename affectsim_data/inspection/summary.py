"""Counts of a release: what is in it, at a glance or as JSON."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from affectsim_data.releases import Release
from affectsim_data.schemas import SPLITS

__all__ = ["release_summary", "summary_lines"]

_COUNTED = ("family", "challenge", "action", "emotion", "scene_id")
_MEASURED = (
    "initial_distance_m",
    "visible_share_init",
    "visible_share_ref",
    "visible_share_mon",
    "d_star_1m",
    "d_star_3m",
    "d_star_5m",
)


def release_summary(release: Release) -> dict[str, Any]:
    """Counts per split, family, challenge, action, emotion, scene; means of what was measured."""
    manifest = release.manifest
    splits = [split for split in SPLITS if manifest.num_rows("episodes", split)]
    tables = {split: release.episode_table(split) for split in splits}
    counts: dict[str, dict[str, int]] = {"split": {s: t.num_rows for s, t in tables.items()}}
    for column in _COUNTED:
        values = [v for t in tables.values() for v in t.column(column).to_pylist()]
        counts[column] = dict(sorted(Counter(value or "none" for value in values).items()))
    means = {}
    for column in _MEASURED:
        parts = [table.column(column).drop_null().to_numpy() for table in tables.values()]
        joined = np.concatenate(parts) if parts else np.zeros(0)
        means[column] = {"mean": float(joined.mean()) if len(joined) else None, "n": len(joined)}
    assets = {table: manifest.num_rows(table) for table in ("motions", "scenes", "avatars")}
    return {
        "name": manifest.name,
        "uri": release.uri,
        "schema_version": manifest.schema_version,
        "code_version": manifest.code_version,
        "bytes": sum(entry.bytes for entry in manifest.files.values()),
        "licences": list(manifest.licences),
        "assets": assets,
        "episodes": counts,
        "measured": means,
    }


def summary_lines(summary: dict[str, Any]) -> list[str]:
    """The summary as lines for a terminal."""
    size = summary["bytes"] / 1e6
    assets = ", ".join(f"{count} {name}" for name, count in summary["assets"].items())
    lines = [
        f"{summary['name']} ({summary['uri']})",
        f"  {size:.1f} MB, {assets}; schema {summary['schema_version']}",
        f"  licences: {', '.join(summary['licences'])}",
    ]
    for column, counts in summary["episodes"].items():
        listed = ", ".join(f"{value} {count}" for value, count in counts.items())
        lines.append(f"  {column:12} {listed}")
    for column, entry in summary["measured"].items():
        mean = "none" if entry["mean"] is None else f"{entry['mean']:.2f}"
        lines.append(f"  {column:20} mean {mean} over {entry['n']}")
    return lines
