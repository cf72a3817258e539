"""Several files of a table, read as one; problems of all of them are gathered."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.tables.csv_files import read_csv
from affectsim_data.evaluation.tables.files import (
    MAX_FILE_BYTES,
    MAX_TEXT_BYTES,
    Columns,
    TableFile,
)
from affectsim_data.evaluation.tables.jsonl_files import read_jsonl
from affectsim_data.evaluation.tables.parquet_files import read_parquet
from affectsim_data.evaluation.tables.problems import Places, Problems, row_name

__all__ = ["SUFFIXES", "ReadTable", "entries_where", "read_table_files"]

_READERS: dict[str, Callable[[Path, Columns], TableFile]] = {
    ".parquet": read_parquet,
    ".csv": read_csv,
    ".jsonl": read_jsonl,
}
SUFFIXES = tuple(_READERS)
"""Endings of files, in lower case; they say how a file is read and written."""


@dataclasses.dataclass(frozen=True)
class ReadTable:
    """Files of a table as one table, and where its entries come from."""

    table: pa.Table
    """Columns of the contract, null where a file has none of them or a value was a problem."""
    places: Places
    """Files and rows."""
    notes: tuple[str, ...]
    """Columns that were passed over."""
    problems: Problems
    """What is wrong so far."""
    bad_values: Mapping[str, NDArray[np.int64]]
    """Entries by column whose values were a problem."""

    def bad_entries(self, *names: str) -> NDArray[np.int64]:
        """Entries that had a problem in one of these columns; no second one is wanted for it."""
        found = [self.bad_values[name] for name in names if name in self.bad_values]
        return np.unique(np.concatenate([np.zeros(0, np.int64), *found]))


def read_table_files(paths: Sequence[Path], columns: Columns) -> ReadTable:
    """Reads files by their suffix and checks what holds for any table: types, nulls, sizes.

    Raises:
        ValueError: No file is given.
    """
    if not paths:
        raise ValueError(f"no file of {columns.table} is given")
    problems = Problems(columns.table)
    files = [
        file
        for path in _distinct([Path(path) for path in paths], problems)
        if (file := _read_file(path, columns, problems)) is not None
    ]
    counts = [len(file.rows) for file in files]
    places = Places(
        files=tuple(file.path for file in files),
        starts=np.cumsum([0, *counts], dtype=np.int64),
        rows=np.concatenate([np.zeros(0, np.int64), *(file.rows for file in files)]),
        find_lines=tuple(file.find_lines for file in files),
    )
    tables = [_full_table(file, columns.schema) for file in files]
    table = pa.concat_tables([_nullable(columns.schema).empty_table(), *tables])
    bad = _tell_bad_values(files, places, problems)
    _check_nulls(table, columns, places, bad, problems)
    _check_sizes(table, places, problems)
    return ReadTable(table, places, tuple(_unknown_columns(files)), problems, bad)


def entries_where(mask: pa.ChunkedArray) -> NDArray[np.int64]:
    """Entries at which a mask holds; null is false."""
    held: NDArray[np.bool_] = mask.fill_null(False).to_numpy().astype(bool)
    return np.flatnonzero(held)


def _distinct(paths: Sequence[Path], problems: Problems) -> list[Path]:
    """The files, each once; a file given again would double every row."""
    seen: dict[Path, Path] = {}
    for path in paths:
        key = path.resolve()
        if key in seen:
            problems.add("files given twice", f"{path}: the same as {seen[key]}")
        seen.setdefault(key, path)
    return list(seen.values())


def _read_file(path: Path, columns: Columns, problems: Problems) -> TableFile | None:
    try:
        file = _open_file(path, columns)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else error
        problems.add("files that cannot be read", f"{path}: {reason}")
        return None
    if not len(file.rows) and not file.broken:
        problems.add("files without rows", f"{path}: holds columns and no row")
    for row, why in file.broken:
        problems.add("rows that cannot be read", f"{row_name(path, row, file.find_lines)}: {why}")
    return file


def _open_file(path: Path, columns: Columns) -> TableFile:
    reader = _READERS.get(path.suffix.lower())
    if reader is None:
        raise ValueError(f"must end with {', '.join(SUFFIXES[:-1])} or {SUFFIXES[-1]}")
    size = path.stat().st_size
    if not path.is_file():
        raise ValueError("is no file")
    if size > MAX_FILE_BYTES:
        raise ValueError(f"a file has at most {MAX_FILE_BYTES:,} bytes, got {size:,}; split it")
    return reader(path, columns)


def _nullable(schema: pa.Schema) -> pa.Schema:
    return pa.schema([pa.field(field.name, field.type) for field in schema])


def _full_table(file: TableFile, schema: pa.Schema) -> pa.Table:
    count = len(file.rows)
    columns = [
        file.columns.get(field.name, pa.chunked_array([pa.nulls(count, field.type)]))
        for field in schema
    ]
    return pa.table(columns, schema=_nullable(schema))


def _tell_bad_values(
    files: Sequence[TableFile], places: Places, problems: Problems
) -> dict[str, NDArray[np.int64]]:
    """Adds values that could not be taken; returns their entries by column."""
    found: dict[str, list[int]] = {}
    for file, start in zip(files, places.starts, strict=False):
        for name, bad in file.bad_values.items():
            reasons = {int(start) + entry: why for entry, why in bad}
            entries = list(reasons)
            problems.add_entries(f"{name} of the wrong kind", entries, places, reasons.__getitem__)
            found[name] = found.get(name, []) + entries
    return {name: np.array(entries, np.int64) for name, entries in found.items()}


def _check_nulls(
    table: pa.Table,
    columns: Columns,
    places: Places,
    bad: dict[str, NDArray[np.int64]],
    problems: Problems,
) -> None:
    """Values that must be there and are not, or that are empty texts."""
    for field in columns.schema:
        if field.nullable:
            continue
        column = table.column(field.name)
        is_absent = pc.is_null(column)
        if field.type == pa.string():
            is_absent = pc.or_(is_absent, pc.equal(column, "").fill_null(False))
        absent = np.setdiff1d(entries_where(is_absent), bad.get(field.name, np.zeros(0, np.int64)))
        problems.add_entries(
            f"{field.name} is missing", absent, places, lambda _: "expected a value, got none"
        )


def _check_sizes(table: pa.Table, places: Places, problems: Problems) -> None:
    for field in table.schema:
        if field.type != pa.string():
            continue
        sizes = pc.binary_length(table.column(field.name))
        large = entries_where(pc.greater(sizes, MAX_TEXT_BYTES))
        problems.add_entries(
            f"{field.name} is too long",
            large,
            places,
            functools.partial(_oversize, sizes),
        )


def _oversize(sizes: pa.ChunkedArray, entry: int) -> str:
    return f"at most {MAX_TEXT_BYTES:,} bytes, got {sizes[entry].as_py():,}"


def _unknown_columns(files: Sequence[TableFile]) -> list[str]:
    """A note per column that means nothing here, with the files that have it."""
    found: dict[str, list[str]] = {}
    for file in files:
        for name in file.unknown:
            found.setdefault(name, []).append(str(file.path.name))
    notes = []
    for name, names in found.items():
        where = names[0] if len(names) == 1 else f"{names[0]} and {len(names) - 1} more"
        notes.append(f"column {name!r} of {where} is not of the contract and was passed over")
    return notes
