"""Counts and statistics of a release or of a selection from it, as one document."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.inspection.statistics import (
    cell_counts,
    chosen_episodes,
    episode_statistics,
    measured_values,
)
from affectsim_data.inspection.statistics_lines import statistics_lines
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter, matching, values_there_are
from affectsim_data.releases.joined_splits import splits_there
from affectsim_data.releases.selection import held_rows, selection_fingerprint
from affectsim_data.releases.splits import SplitBy

if TYPE_CHECKING:
    from affectsim_data.loaders import AffectSimDataset

__all__ = ["chosen_rows", "release_summary", "summary_lines"]

_COUNTED = ("split", "family", "challenge", "action", "emotion", "scene_id")


def release_summary(
    source: Release | AffectSimDataset,
    *,
    split: str | None = None,
    split_by: SplitBy = "group",
    filter: Filter | None = None,
) -> dict[str, Any]:
    """What a release holds; counts, balance and distributions of its episodes.

    `selection` says by split how many episodes were counted of how many there are, and their
    fingerprint: that of the dataset with the same split and filter. `episodes` counts them by
    column, `measured` has means over all of them, and `statistics` is that of
    `affectsim_data.inspection.statistics.episode_statistics`. `cells` says what the recipe asked
    for, of whole splits by group; it is `None` for other selections.

    Args:
        source: A release, or a dataset: then of its episodes, and the other arguments stay away.
        split: Only this one; all that are there if not given.
        split_by: What no two splits share, see `Release.split_table`.
        filter: Only episodes that match, see `affectsim_data.releases.filters`.

    Raises:
        ValueError: No such split; a malformed filter, or one that nothing matches.
    """
    if isinstance(source, Release):
        release = source
        chosen = chosen_rows(release, split=split, split_by=split_by, filter=filter)
    elif split is None and filter is None and split_by == "group":
        release, chosen, split_by = source.release, {source.split: source.rows}, source.split_by
    else:
        raise ValueError("a dataset has its split and filter; give these only with a release")
    table = chosen_episodes(release, chosen, split_by=split_by)
    whole = all(len(rows) == release.num_episodes(one) for one, rows in chosen.items())
    return {
        **_release_itself(release),
        "split_by": split_by,
        "selection": {
            name: {
                "selected": len(rows),
                "of": release.split_table(name, split_by).num_episodes,
                "fingerprint": selection_fingerprint(release, name, rows, split_by=split_by),
            }
            for name, rows in chosen.items()
        },
        "episodes": {column: _counts(table, column) for column in _COUNTED},
        "measured": {name: _mean(values) for name, values in measured_values(table).items()},
        "statistics": episode_statistics(table),
        "cells": cell_counts(release, list(chosen)) if split_by == "group" and whole else None,
    }


def _release_itself(release: Release) -> dict[str, Any]:
    manifest = release.manifest
    return {
        "name": manifest.name,
        "uri": release.uri,
        "schema_version": manifest.schema_version,
        "code_version": manifest.code_version,
        "bytes": sum(entry.bytes for entry in manifest.files.values()),
        "licences": list(manifest.licences),
        "redistribution": manifest.redistribution,
        "partial": manifest.partial_of.describe() if manifest.partial_of else None,
        "assets": {name: manifest.num_rows(name) for name in ("motions", "scenes", "avatars")},
    }


def chosen_rows(
    release: Release,
    *,
    split: str | None = None,
    split_by: SplitBy = "group",
    filter: Filter | None = None,
) -> dict[str, NDArray[np.int64]]:
    """Places of the episodes that are meant, by split; splits without any are left out.

    Raises:
        ValueError: No such split; a malformed filter, or one that nothing matches.
    """
    splits = list(splits_there(release, split_by)) if split is None else [split]
    chosen = {one: held_rows(release, one, split_by) for one in splits}
    if filter is not None:
        tables = {one: release.split_table(one, split_by) for one in splits}
        chosen = {one: rows[matching(tables[one], filter)[rows]] for one, rows in chosen.items()}
        if not any(len(rows) for rows in chosen.values()):
            raise ValueError(
                f"{release.uri}: no episode of {', '.join(splits)} matches filter {filter!r}; "
                f"there are {values_there_are(list(tables.values()), filter)}"
            )
    return {one: rows for one, rows in chosen.items() if len(rows)}


def _counts(table: pa.Table, column: str) -> dict[str, int]:
    counts = Counter(value or "none" for value in table.column(column).to_pylist())
    return dict(counts if column == "split" else sorted(counts.items()))


def _mean(values: NDArray[np.float64]) -> dict[str, Any]:
    there = values[np.isfinite(values)]
    return {"mean": float(there.mean()) if len(there) else None, "n": len(there)}


def summary_lines(summary: dict[str, Any]) -> list[str]:
    """The summary as lines for a terminal, at most 120 characters wide but for lists of names."""
    size = summary["bytes"] / 1e6
    assets = ", ".join(f"{count} {name}" for name, count in summary["assets"].items())
    lines = [
        f"{summary['name']} ({summary['uri']})",
        f"  {size:.1f} MB, {assets}; schema {summary['schema_version']}",
        f"  licences: {', '.join(summary['licences'])}",
    ]
    if not summary["redistribution"]:
        lines.append("  may not be passed on; share the recipe")
    if summary["partial"]:
        lines.append(f"  a copy of a part: {summary['partial']}")
    if not summary["selection"]:
        return [*lines, "  no episodes; --scenes describes its scenes"]
    if summary["split_by"] != "group":
        lines.append(f"  split by {_SPLIT_WORDS[summary['split_by']]}")
    for split, entry in summary["selection"].items():
        share = f"{entry['selected']} of {entry['of']} episodes"
        lines.append(f"  {split:12} {share}, fingerprint {entry['fingerprint'][:16]}")
    return [*lines, *statistics_lines(summary["statistics"], summary["cells"])]


_SPLIT_WORDS = {
    "scene": "scene: no two splits share one, performers may be in several",
    "both": "group and scene: the episodes that are in the same split by either",
}
