"""Parquet, as pandas, Polars or Arrow write it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from affectsim_data.evaluation.tables.files import (
    MAX_FILE_BYTES,
    MAX_ROWS,
    Columns,
    TableFile,
    converted,
)

__all__ = ["read_parquet"]

_MAX_VALUES_PER_ROW = 16


def read_parquet(path: Path, columns: Columns) -> TableFile:
    """A table in Parquet; columns of a pandas index are none of its own.

    Raises:
        ValueError: No such table is in it, or it would unfold beyond all bounds.
    """
    try:
        with pq.ParquetFile(path) as file:
            names = file.schema_arrow.names
            _check_size(file.metadata)
        chosen = columns.choose(names)
        # A file of one short word a million times stays small as a dictionary.
        words = [
            in_file
            for name, in_file in chosen.items()
            if columns.schema.field(name).type == pa.string()
        ]
        with pq.ParquetFile(path, read_dictionary=words) as file:
            table = file.read(columns=list(chosen.values()))
        table.validate(full=True)  # among the rest, that text is UTF-8
        found = {name: table.column(in_file) for name, in_file in chosen.items()}
        _check_unfolded(found)
        good, bad = converted(found, columns)
    except (pa.ArrowException, OSError) as error:
        raise ValueError(f"cannot be read as Parquet: {error}") from None
    return TableFile(
        path=path,
        columns=good,
        bad_values=bad,
        unknown=tuple(name for name in names if name not in columns.known),
        rows=np.arange(1, table.num_rows + 1),
    )


def _check_size(metadata: pq.FileMetaData) -> None:
    if metadata.num_rows > MAX_ROWS:
        raise ValueError(f"a file has at most {MAX_ROWS:,} rows, got {metadata.num_rows:,}")
    groups = [metadata.row_group(number) for number in range(metadata.num_row_groups)]
    unfolded = sum(group.total_byte_size for group in groups)
    if unfolded > MAX_FILE_BYTES:
        raise ValueError(f"unfolds to {unfolded:,} bytes; at most {MAX_FILE_BYTES:,} are read")
    most = max(
        (group.column(place).num_values for group in groups for place in range(group.num_columns)),
        default=0,
    )
    if most > _MAX_VALUES_PER_ROW * max(1, metadata.num_rows):
        raise ValueError(f"a column holds {most:,} values in {metadata.num_rows:,} rows")


def _check_unfolded(found: dict[str, pa.ChunkedArray]) -> None:
    """Texts that are short as a dictionary may be long as texts."""
    for name, column in found.items():
        if not pa.types.is_dictionary(column.type):
            continue
        total = 0
        for chunk in column.chunks:
            sizes = pc.binary_length(chunk.dictionary).fill_null(0).to_numpy(zero_copy_only=False)
            codes = chunk.indices.fill_null(len(sizes)).to_numpy(zero_copy_only=False)
            total += int(np.append(sizes.astype(np.int64), 0)[codes].sum())
        if total > MAX_FILE_BYTES:
            raise ValueError(f"{name} unfolds to {total:,} bytes; at most {MAX_FILE_BYTES:,}")
