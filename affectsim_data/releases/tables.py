"""Tables of a release in its Parquet files, read through a store and checked."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.releases.stores import Store
from affectsim_data.schemas import SCHEMAS, TableName, check_table

__all__ = ["open_parquet", "read_table"]


def open_parquet(store: Store, table: TableName, name: str, **options: Any) -> pq.ParquetFile:
    """A file of a release, whose bytes and columns are those promised.

    Args:
        store: Gives the files.
        table: What the file is part of.
        name: Its path in the release.
        options: Passed on to `pyarrow.parquet.ParquetFile`.

    Raises:
        IntegrityError: Its bytes are not what the manifest promises.
        ValueError: Not a Parquet file, or not of this table.
    """
    payload = pa.py_buffer(store.read(name))
    try:
        file = pq.ParquetFile(pa.BufferReader(payload), **options)
        # With options the reader changes types; the contract is about what is stored.
        schema = pq.read_schema(pa.BufferReader(payload)) if options else file.schema_arrow
    except (pa.ArrowInvalid, OSError) as error:
        raise ValueError(f"{name}: not a Parquet file: {error}") from error
    check_table(schema, table, file=name)
    return file


def read_table(
    store: Store,
    table: TableName,
    name: str,
    *,
    columns: Sequence[str] | None = None,
    **options: Any,
) -> pa.Table:
    """The rows of a file of a release.

    Args:
        store: Gives the files.
        table: What the file is part of.
        name: Its path in the release.
        columns: Which; those of the contract if not given.
        options: Passed on to `pyarrow.parquet.ParquetFile`.

    Raises:
        IntegrityError: Its bytes are not what the manifest promises.
        ValueError: Not a Parquet file, not of this table, or of another number of rows.
    """
    wanted = SCHEMAS[table].names if columns is None else list(columns)
    with open_parquet(store, table, name, **options) as file:
        # Shards are small: threads would cost more than they save.
        found = file.read(columns=wanted, use_threads=False)
    if found.num_rows != store.manifest.files[name].rows:
        raise ValueError(
            f"{name}: the manifest says {store.manifest.files[name].rows} rows, "
            f"the file holds {found.num_rows}"
        )
    return found.select(wanted)
