"""Releases with one thing wrong: rows changed in memory, or in the files with hashes mended."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.builders.validation.catalogue import CHECKS
from affectsim_data.builders.validation.challenges import signed_bearings_deg
from affectsim_data.builders.validation.findings import Measure, gather
from affectsim_data.builders.validation.part import Part
from affectsim_data.builders.validation.shares import seen
from affectsim_data.builders.validation.tables import Columns, Tables
from affectsim_data.episodes import RING_DISTANCES_M
from affectsim_data.schemas import SCHEMAS, TableName

__all__ = ["failed", "with_rows", "with_table", "rewrite_file", "Row", "restored", "changed_part"]

Row = dict[str, Any]


def failed(measures: Iterable[Measure]) -> set[str]:
    """Names of the checks that do not hold."""
    listed = list(measures)
    names = {measure.check for measure in listed}
    return {
        name
        for name in names
        if not gather(CHECKS[name], [one for one in listed if one.check == name]).holds
    }


def _columns(table: TableName, rows: list[Row]) -> Columns:
    return Columns(pa.Table.from_pylist(rows, schema=SCHEMAS[table]))


def with_rows(tables: Tables, change: Callable[[list[Row]], None]) -> Tables:
    """The tables with other episodes, and the index that goes with them."""
    rows = tables.episodes.table.to_pylist()
    change(rows)
    index = [{name: row[name] for name in SCHEMAS["index"].names} for row in rows]
    return dataclasses.replace(
        tables, episodes=_columns("episodes", rows), index=_columns("index", index)
    )


def with_table(tables: Tables, table: TableName, change: Callable[[list[Row]], None]) -> Tables:
    """The tables with other rows of the index or the cells."""
    rows = getattr(tables, table).table.to_pylist()
    change(rows)
    columns: dict[str, Any] = {table: _columns(table, rows)}
    return dataclasses.replace(tables, **columns)


def changed_part(part: Part, change: Callable[[Row], None], *, restore: bool = True) -> Part:
    """The part with its first episode alone, changed; what is stored of views fits the change."""
    row = part.episodes.table.slice(0, 1).to_pylist()[0]
    change(row)
    changed = dataclasses.replace(part, episodes=_columns("episodes", [row]))
    return restored(changed) if restore else changed


def restored(part: Part) -> Part:
    """The part with distances, bearings, shares and d* as they are where everybody is now."""
    rows = part.episodes.table.to_pylist()
    distance = np.linalg.norm(part.start - part.anchor, axis=1)
    bearing = signed_bearings_deg(part)
    for place, row in enumerate(rows):
        row["initial_distance_m"] = float(distance[place])
        row["initial_bearing_deg"] = float(bearing[place])
        for view in ("init", "ref", "mon"):
            row[f"visible_share_{view}"] = float(seen(part, view).share[place])
        for ring in RING_DISTANCES_M:
            row |= _ring(part, place, ring)
    return dataclasses.replace(part, episodes=_columns("episodes", rows))


def _ring(part: Part, place: int, ring: int) -> Row:
    try:
        length = part.navmesh.ring_distance(part.start[place], part.anchor[place], float(ring))
    except ValueError:  # the change under test put the start off the navmesh
        return {}
    reason = "empty" if math.isnan(length) else "unreachable"
    there = math.isfinite(length)
    return {
        f"d_star_{ring}m": length if there else None,
        f"d_star_{ring}m_null": None if there else reason,
    }


def rewrite_file(folder: Path, name: str, change: Callable[[Row], None]) -> None:
    """Changes the first row of a file of a release and mends its entry in the manifest."""
    path, manifest = folder / name, folder / "MANIFEST.json"
    table = pq.read_table(path)
    rows = table.to_pylist()
    change(rows[0])
    pq.write_table(pa.Table.from_pylist(rows, schema=table.schema), path)
    document = json.loads(manifest.read_text(encoding="utf-8"))
    payload = path.read_bytes()
    document["files"][name] |= {
        "bytes": len(payload),
        "sha256": hashlib.sha256(payload).hexdigest(),
    }
    manifest.write_text(json.dumps(document), encoding="utf-8")
