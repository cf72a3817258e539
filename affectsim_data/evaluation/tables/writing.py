"""Prediction and trajectory tables written as the contract has them, whole or not at all."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.csv
import pyarrow.parquet as pq

from affectsim_data.evaluation.tables.problems import quoted
from affectsim_data.evaluation.tables.reading import SUFFIXES
from affectsim_data.schemas import SCHEMAS, TableName

__all__ = ["write_predictions", "write_trajectories"]

_ROWS_AT_ONCE = 1 << 16


def write_predictions(rows: Iterable[Mapping[str, Any]] | pa.Table, path: Path) -> int:
    """Writes a prediction table, Parquet, CSV or JSONL by suffix; returns its rows.

    The file is there whole or, whatever happens, as it was before. In CSV scores are JSON text,
    null is an empty cell and an empty text a quoted one.

    Args:
        rows: With the columns of `SCHEMAS["predictions"]`; those that may be null may be absent.
        path: Where to.

    Raises:
        ValueError: Another suffix, a column that is not of the contract, or a value that is not of
            its kind.
    """
    return _write("predictions", rows, path)


def write_trajectories(rows: Iterable[Mapping[str, Any]] | pa.Table, path: Path) -> int:
    """The same for a trajectory table, `SCHEMAS["trajectories"]`."""
    return _write("trajectories", rows, path)


def _write(name: TableName, rows: Iterable[Mapping[str, Any]] | pa.Table, path: Path) -> int:
    writer = _WRITERS.get(path.suffix.lower())
    if writer is None:
        raise ValueError(f"{path}: must end with {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    table = _table(name, rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    # The process is in its name: two of them that write the same file do not mix.
    staging = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with staging.open("wb") as file:
            writer(table, file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(staging, path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            staging.unlink()
    return int(table.num_rows)


def _table(name: TableName, rows: Iterable[Mapping[str, Any]] | pa.Table) -> pa.Table:
    schema = SCHEMAS[name]
    if isinstance(rows, pa.Table):
        _check_names(name, rows.schema.names, "the table")
        absent = [field for field in schema if field.name not in rows.schema.names]
        for field in absent:
            rows = rows.append_column(field, pa.nulls(rows.num_rows, field.type))
        table = rows.select(schema.names).cast(schema)
    else:
        table = pa.concat_tables([schema.empty_table(), *_batches(name, rows)])
    _check_finite(table)
    return table


def _batches(name: TableName, rows: Iterable[Mapping[str, Any]]) -> Iterable[pa.Table]:
    schema, batch = SCHEMAS[name], []
    for number, row in enumerate(rows, start=1):
        _check_names(name, row.keys(), f"row {number}")
        needed = [field.name for field in schema if not field.nullable]
        absent = [one for one in needed if row.get(one) is None]
        if absent:
            raise ValueError(f"row {number}: {name} need {', '.join(absent)}, got {quoted(row)}")
        batch.append(row)
        if len(batch) == _ROWS_AT_ONCE:
            yield _batch(schema, batch)
            batch = []
    yield _batch(schema, batch)


def _batch(schema: pa.Schema, rows: list[Mapping[str, Any]]) -> pa.Table:
    try:
        return pa.Table.from_pylist(rows, schema=schema)
    except (pa.ArrowException, UnicodeEncodeError) as error:
        raise ValueError(f"a value is not of its column's kind: {error}") from None


def _check_names(name: TableName, names: Iterable[str], where: str) -> None:
    schema = SCHEMAS[name]
    there = set(names)
    unknown = sorted(there - set(schema.names))
    if unknown:
        raise ValueError(
            f"{where}: {name} have no column {', '.join(unknown)}; "
            f"there are {', '.join(schema.names)}"
        )
    missing = [field.name for field in schema if not field.nullable and field.name not in there]
    if missing:
        raise ValueError(f"{where}: {name} need {', '.join(missing)}")


def _check_finite(table: pa.Table) -> None:
    """Raises ValueError for NaN and infinity, which no reader would take."""
    for field in table.schema:
        column = table.column(field.name)
        if pa.types.is_list(field.type):
            column = pc.list_flatten(column)
        if pa.types.is_floating(column.type):
            strange = column.filter(pc.invert(pc.is_finite(column)))
            if len(strange.drop_null()):
                raise ValueError(f"{field.name} must be finite, got {strange[0].as_py()}")


def _write_parquet(table: pa.Table, file: Any) -> None:
    pq.write_table(table, file, compression="zstd")


def _write_csv(table: pa.Table, file: Any) -> None:
    for place, field in enumerate(table.schema):
        if pa.types.is_list(field.type):
            texts = [
                None if scores is None else json.dumps([_rounded(score) for score in scores])
                for scores in table.column(place).to_pylist()
            ]
            table = table.set_column(place, field.name, pa.array(texts, pa.string()))
    pyarrow.csv.write_csv(table, file)


def _write_jsonl(table: pa.Table, file: Any) -> None:
    for batch in table.to_batches(max_chunksize=_ROWS_AT_ONCE):
        for row in batch.to_pylist():
            if row.get("scores") is not None:
                row["scores"] = [_rounded(score) for score in row["scores"]]
            file.write(json.dumps(row, ensure_ascii=False, allow_nan=False).encode() + b"\n")


def _rounded(score: float | None) -> float | None:
    """The number of fewest digits that is the same as float32."""
    return None if score is None else float(str(np.float32(score)))


_WRITERS: dict[str, Callable[[pa.Table, Any], None]] = {
    ".parquet": _write_parquet,
    ".csv": _write_csv,
    ".jsonl": _write_jsonl,
}
