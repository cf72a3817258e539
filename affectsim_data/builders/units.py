"""Results of a build's units as files: a Parquet table in a table's contract, and JSON beside it.

What a unit made (motions, a scene, episodes) are rows of the very table a release has; what else is
to be known of it, such as what screening said, is a JSON document in the metadata of the file.
"""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import cattrs
import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.motions import Motion
from affectsim_data.releases.rows import motion_row, read_motion
from affectsim_data.schemas import SCHEMAS, TableName

__all__ = ["Rows", "pack_unit", "unpack_unit"]

_DOCUMENT = b"affectsim"


@dataclasses.dataclass(frozen=True)
class Rows:
    """Rows of a table of a release, as an Arrow table in its contract."""

    table: TableName
    arrow: pa.Table

    @classmethod
    def of(cls, table: TableName, rows: list[dict[str, Any]]) -> Rows:
        """Rows given one by one."""
        return cls(table, pa.Table.from_pylist(rows, schema=SCHEMAS[table]))


def pack_unit(result: Any) -> bytes:
    """The file of a result: of dataclasses of plain values, with `Rows` of one table or `Motion`s
    wherever they like."""
    parts: list[Rows] = []
    converter = _converter()

    def put(rows: Rows) -> dict[str, Any]:
        start = sum(part.arrow.num_rows for part in parts)
        parts.append(rows)
        return {"table": rows.table, "start": start, "count": rows.arrow.num_rows}

    converter.register_unstructure_hook(Rows, put)
    converter.register_unstructure_hook(Motion, lambda one: put(_motion_rows(one)))
    document = json.dumps(converter.unstructure(result))
    table = pa.concat_tables([part.arrow for part in parts]) if parts else pa.table({})
    metadata = {**(table.schema.metadata or {}), _DOCUMENT: document.encode()}
    stream = io.BytesIO()
    pq.write_table(table.replace_schema_metadata(metadata), stream, compression="zstd")
    return stream.getvalue()


def unpack_unit(payload: bytes, kind: Any) -> Any:
    """The result of a file.

    Args:
        payload: The file.
        kind: Type of the result: a dataclass, or a union of some.
    """
    table = pq.read_table(pa.BufferReader(payload), use_threads=False)
    document = table.schema.metadata[_DOCUMENT]
    table = table.replace_schema_metadata()
    converter = _converter()

    def get(place: Mapping[str, Any], _: type) -> Rows:
        name: TableName = place["table"]
        arrow = table.slice(place["start"], place["count"])
        return Rows(name, arrow.cast(SCHEMAS[name]))

    def get_motion(place: Mapping[str, Any], _: type) -> Motion:
        (row,) = table.slice(place["start"], 1).to_pylist()
        return read_motion(row, f"motion {row['motion_id']!r}")

    converter.register_structure_hook(Rows, get)
    converter.register_structure_hook(Motion, get_motion)
    return converter.structure(json.loads(document), kind)


def _motion_rows(motion: Motion) -> Rows:
    return Rows.of("motions", [motion_row(motion)])


def _converter() -> cattrs.Converter:
    converter = cattrs.Converter()
    converter.register_unstructure_hook(Path, str)
    converter.register_structure_hook(Path, lambda text, _: Path(text))
    return converter
