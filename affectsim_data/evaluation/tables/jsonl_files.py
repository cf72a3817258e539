"""JSONL: a JSON object a line, UTF-8; blank lines are passed over, NaN is no JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import pyarrow as pa

from affectsim_data.evaluation.tables.columns import BadValues, values_column
from affectsim_data.evaluation.tables.files import Columns, TableFile

__all__ = ["read_jsonl"]

_MAX_LINE_BYTES = 8 << 20
_ROWS_AT_ONCE = 1 << 16
_UTF8_MARK = b"\xef\xbb\xbf"


def read_jsonl(path: Path, columns: Columns) -> TableFile:
    """A table in JSONL; a key that is absent is null, lines that are no objects are broken.

    Raises:
        ValueError: No such table is in it.
    """
    gathered = _Gathered(columns)
    rows, lines, broken = [], [], []
    for line_number, line in _lines(path):
        lines.append(line_number)
        try:
            gathered.add(_parse(line))
            rows.append(len(lines))
        except ValueError as error:
            broken.append((len(lines), str(error)))
    if not lines:
        raise ValueError("is empty; expected a JSON object a line")
    found, bad = gathered.finish()
    if rows:
        chosen = columns.choose(list(gathered.keys))
        found = {name: found[in_file] for name, in_file in chosen.items()}
        bad = {name: bad[in_file] for name, in_file in chosen.items()}
    line_numbers = np.array(lines, np.int64)
    return TableFile(
        path=path,
        columns=found if rows else {},
        bad_values=bad if rows else {},
        unknown=tuple(name for name in gathered.keys if name not in columns.known),
        rows=np.array(rows, np.int64),
        broken=tuple(broken),
        find_lines=lambda: line_numbers,
    )


class _Gathered:
    """Values of rows as they come, turned into columns some thousand at a time."""

    def __init__(self, columns: Columns) -> None:
        self.keys: dict[str, None] = {}
        self._types = {
            name: columns.schema.field(columns.contract_name(name)).type for name in columns.known
        }
        self._waiting: dict[str, list[Any]] = {name: [] for name in columns.known}
        self._done: dict[str, list[pa.Array]] = {name: [] for name in columns.known}
        self._bad: dict[str, BadValues] = {name: [] for name in columns.known}
        self._num_waiting = self._num_done = 0

    def add(self, row: dict[str, Any]) -> None:
        self.keys.update(dict.fromkeys(row))
        for name, values in self._waiting.items():
            values.append(row.get(name))
        self._num_waiting += 1
        if self._num_waiting == _ROWS_AT_ONCE:
            self._flush()

    def finish(self) -> tuple[dict[str, pa.ChunkedArray], dict[str, BadValues]]:
        self._flush()
        columns = {
            name: pa.chunked_array(chunks, self._types[name]) for name, chunks in self._done.items()
        }
        return columns, self._bad

    def _flush(self) -> None:
        for name, values in self._waiting.items():
            column, bad = values_column(values, self._types[name])
            self._done[name] += column.chunks
            self._bad[name] += [(self._num_done + entry, why) for entry, why in bad]
            values.clear()
        self._num_done += self._num_waiting
        self._num_waiting = 0


def _lines(path: Path) -> Iterator[tuple[int, bytes]]:
    """Lines that are not blank, with their numbers from 1."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            stripped = (line.removeprefix(_UTF8_MARK) if number == 1 else line).strip()
            if stripped:
                yield number, stripped


def _parse(line: bytes) -> dict[str, Any]:
    """The object a line holds; raises ValueError with the reason if it holds none."""
    if len(line) > _MAX_LINE_BYTES:
        raise ValueError(f"a line has at most {_MAX_LINE_BYTES:,} bytes, got {len(line):,}")
    try:
        row = json.loads(
            line.decode("utf-8"), object_pairs_hook=_object, parse_constant=_no_constant
        )
    except UnicodeDecodeError:
        raise ValueError("must be text in UTF-8") from None
    except json.JSONDecodeError as error:
        raise ValueError(f"is no JSON: {error.msg}, at character {error.pos + 1}") from None
    except RecursionError:
        raise ValueError("is nested too deeply") from None
    if not isinstance(row, dict):
        raise ValueError("expected a JSON object: {...}")
    return row


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    row = dict(pairs)
    if len(row) < len(pairs):
        names = [name for name, _ in pairs]
        twice = sorted({name for name in names if names.count(name) > 1})
        raise ValueError(f"keys are there twice: {', '.join(map(repr, twice))}")
    return row


def _no_constant(name: str) -> NoReturn:
    raise ValueError(f"{name} is no JSON; expected a number or null")
