"""Whether every file is what the manifest and the schemas promise."""

from __future__ import annotations

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.errors import IntegrityError
from affectsim_data.releases.stores import Store
from affectsim_data.schemas import ASSET_TABLES, SCHEMAS, check_table

__all__ = ["check_files"]


def check_files(store: Store) -> list[Measure]:
    """Size, hash, columns, rows and identifiers of every file of a release."""
    names = list(store.manifest.files)
    store.prefetch(names)
    notes = [_problem(store, name) for name in names]
    return [Measure.of("files", names, [float(bool(note)) for note in notes], high=0, notes=notes)]


def _problem(store: Store, name: str) -> str:
    """What is wrong with a file; empty if nothing is."""
    entry, folder = store.manifest.files[name], name.partition("/")[0]
    try:
        payload = store.read(name)
    except (IntegrityError, OSError) as error:
        return str(error)
    table = next((table for table in SCHEMAS if table == folder), None)
    if table is None:
        return f"of no table; tables are {', '.join(SCHEMAS)}"
    try:
        with pq.ParquetFile(pa.BufferReader(payload)) as file:
            check_table(file.schema_arrow, table, file=name)
            if file.metadata.num_rows != entry.rows:
                return f"the manifest says {entry.rows} rows, it holds {file.metadata.num_rows}"
            if table not in ASSET_TABLES:
                return ""
            keys = file.read([SCHEMAS[table].names[0]]).column(0).to_pylist()
    except (pa.ArrowInvalid, ValueError, OSError) as error:
        return str(error)
    if tuple(keys) != entry.keys:
        return f"the manifest names {list(entry.keys)[:3]}, it holds {keys[:3]}"
    return ""
