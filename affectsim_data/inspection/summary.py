"""Counts of a release or of a selection from it, at a glance or as JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter, matching, values_there_are
from affectsim_data.releases.selection import held_rows, selection_fingerprint
from affectsim_data.schemas import SCHEMAS, SPLITS

if TYPE_CHECKING:
    from affectsim_data.loaders import AffectSimDataset

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


def release_summary(
    source: Release | AffectSimDataset,
    *,
    split: str | None = None,
    filter: Filter | None = None,
) -> dict[str, Any]:
    """Counts per split, family, challenge, action, emotion, scene; means of what was measured.

    `selection` says by split how many episodes were counted of how many there are, and their
    fingerprint: that of the dataset with the same split and filter.

    Args:
        source: A release, or a dataset: then of its episodes, and the other arguments stay away.
        split: Only this one; all that are there if not given.
        filter: Only episodes that match, see `affectsim_data.releases.filters`.

    Raises:
        ValueError: No such split; a malformed filter, or one that nothing matches.
    """
    if isinstance(source, Release):
        release, chosen = source, _chosen(source, split, filter)
    elif split is None and filter is None:
        release, chosen = source.release, {source.split: source.rows}
    else:
        raise ValueError("a dataset has its split and filter; give these only with a release")
    manifest = release.manifest
    table = _columns(release, chosen)
    counts: dict[str, dict[str, int]] = {
        "split": {name: len(rows) for name, rows in chosen.items()}
    }
    for column in _COUNTED:
        values = Counter(value or "none" for value in table.column(column).to_pylist())
        counts[column] = dict(sorted(values.items()))
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
        "selection": {
            name: {
                "selected": len(rows),
                "of": release.num_episodes(name),
                "fingerprint": selection_fingerprint(release, name, rows),
            }
            for name, rows in chosen.items()
        },
        "episodes": counts,
        "measured": {column: _mean(table.column(column)) for column in _MEASURED},
    }


def _chosen(
    release: Release, split: str | None, filter: Filter | None
) -> dict[str, NDArray[np.int64]]:
    """Places of the episodes that are meant, by split; splits without any are left out."""
    there = [one for one in SPLITS if release.manifest.num_rows("index", one)]
    splits: Sequence[str] = there if split is None else [split]
    chosen = {one: held_rows(release, one) for one in splits}
    if filter is not None:
        chosen = {one: rows[matching(release, one, filter)[rows]] for one, rows in chosen.items()}
        if not any(len(rows) for rows in chosen.values()):
            raise ValueError(
                f"{release.uri}: no episode of {', '.join(splits)} matches filter {filter!r}; "
                f"there are {values_there_are(release, splits, filter)}"
            )
    return {one: rows for one, rows in chosen.items() if len(rows)}


def _columns(release: Release, chosen: dict[str, NDArray[np.int64]]) -> pa.Table:
    """What is counted and measured of the episodes at these places, by split."""
    names = [*_COUNTED, *_MEASURED]
    tables = [pa.schema([SCHEMAS["episodes"].field(name) for name in names]).empty_table()]
    for split, rows in chosen.items():
        table = release.episode_table(split, names)
        # In a partial copy the table lacks rows of the split.
        tables.append(table.take(np.searchsorted(release.split_table(split).held_rows, rows)))
    return pa.concat_tables(tables)


def _mean(column: pa.ChunkedArray) -> dict[str, Any]:
    values = column.drop_null().to_numpy()
    return {"mean": float(values.mean()) if len(values) else None, "n": len(values)}


def summary_lines(summary: dict[str, Any]) -> list[str]:
    """The summary as lines for a terminal."""
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
    for split, entry in summary["selection"].items():
        share = f"{entry['selected']} of {entry['of']} episodes"
        lines.append(f"  {split:12} {share}, fingerprint {entry['fingerprint'][:16]}")
    for column, counts in summary["episodes"].items():
        listed = ", ".join(f"{value} {count}" for value, count in counts.items())
        lines.append(f"  {column:12} {listed}")
    for column, entry in summary["measured"].items():
        mean = "none" if entry["mean"] is None else f"{entry['mean']:.2f}"
        lines.append(f"  {column:20} mean {mean} over {entry['n']}")
    return lines
