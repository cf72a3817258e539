"""CSV: comma, double quotes, UTF-8 with or without mark, lines ended either way.

A cell left empty is null, a quoted empty cell is an empty text. Line breaks may stand in quotes.
"""

from __future__ import annotations

import codecs
import csv
import functools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv
from numpy.typing import NDArray

from affectsim_data.evaluation.tables.files import Columns, TableFile, converted
from affectsim_data.evaluation.tables.problems import quoted

__all__ = ["read_csv"]

_MAX_ROW_BYTES = 64 << 20
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")
_QUOTE, _NEWLINE, _RETURN = 0x22, 0x0A, 0x0D
_PIECE = 1 << 24


def read_csv(path: Path, columns: Columns) -> TableFile:
    """A table in CSV; rows with too many or too few cells are told as broken.

    Raises:
        ValueError: No such table is in it.
    """
    header = _header(path)
    chosen = columns.choose(header)
    _check_text(path)
    broken: list[tuple[int, str]] = []

    def skip(row: pyarrow.csv.InvalidRow) -> str:
        expected, got = row.expected_columns, row.actual_columns
        # Rows count from 1, and pyarrow counts the header among them.
        broken.append((row.number - 1, f"expected {expected} cells as in line 1, got {got}"))
        return "skip"

    try:
        table = pyarrow.csv.read_csv(
            path,
            # Only one thread knows the numbers of rows.
            read_options=pyarrow.csv.ReadOptions(
                use_threads=False, block_size=min(path.stat().st_size + 1, _MAX_ROW_BYTES)
            ),
            parse_options=pyarrow.csv.ParseOptions(
                newlines_in_values=True, invalid_row_handler=skip
            ),
            convert_options=pyarrow.csv.ConvertOptions(
                include_columns=list(chosen.values()),
                column_types=dict.fromkeys(chosen.values(), pa.string()),
                null_values=[""],
                strings_can_be_null=True,
                quoted_strings_can_be_null=False,
            ),
        )
    except pa.ArrowInvalid as error:
        raise ValueError(f"cannot be read as CSV: {error}") from None
    found = {name: table.column(in_file) for name, in_file in chosen.items()}
    good, bad = converted(found, columns)
    num_rows = table.num_rows + len(broken)
    is_broken = np.zeros(num_rows, bool)
    is_broken[[row - 1 for row, _ in broken]] = True
    return TableFile(
        path=path,
        columns=good,
        bad_values=bad,
        unknown=tuple(name for name in header if name not in columns.known),
        rows=np.flatnonzero(~is_broken) + 1,
        broken=tuple(broken),
        find_lines=_line_finder(path, num_rows),
    )


def _header(path: Path) -> list[str]:
    with path.open("rb") as file:
        if file.read(2) in _UTF16_MARKS:
            raise ValueError("is in UTF-16; save it in UTF-8")
    # Bytes that are no UTF-8 are told with their line, later.
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        try:
            header = next((row for row in csv.reader(file) if row), None)
        except csv.Error as error:
            raise ValueError(f"cannot be read as CSV: line 1: {error}") from None
    if header is None:
        raise ValueError("is empty; the first line names the columns")
    return header


def _check_text(path: Path) -> None:
    """Raises ValueError for what pyarrow would pass over in silence: rows with bytes that are no
    UTF-8, and those that a quote which is never closed swallows."""
    num_quotes = 0
    decoder = codecs.getincrementaldecoder("utf-8")()
    with path.open("rb") as file:
        try:
            while piece := file.read(_PIECE):
                num_quotes += piece.count(_QUOTE)
                decoder.decode(piece)
            decoder.decode(b"", final=True)
        except UnicodeDecodeError:
            raise ValueError(f"{_no_utf8(path)}; save the file in UTF-8") from None
    if num_quotes % 2:
        raise ValueError(
            f"cannot be read as CSV: {num_quotes} quotation marks, an odd number, so that a quote "
            'is never closed; a cell with a quotation mark is quoted, the mark doubled: "5"" tall"'
        )


def _no_utf8(path: Path) -> str:
    """Names the first line that is no UTF-8."""
    with path.open("rb") as file:
        for number, line in enumerate(file, start=1):
            try:
                line.decode("utf-8")
            except UnicodeDecodeError as error:
                start = max(0, error.start - 10)
                return f"line {number} is no text in UTF-8: ... {quoted(line[start : error.end])}"
    raise AssertionError("no line break is part of a character")


def _line_finder(path: Path, num_rows: int) -> Callable[[], NDArray[np.int64]]:
    """Finds lines when asked, since only messages want them; none if rows are not as expected."""

    @functools.cache
    def find() -> NDArray[np.int64]:
        lines = _record_lines(np.fromfile(path, np.uint8))[1:]
        return lines if len(lines) == num_rows else np.zeros(0, np.int64)

    return find


def _record_lines(data: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Line, from 1, at which each record begins that is not blank; the header is one."""
    follows = np.append(data[1:], np.uint8(0))
    line_ends = np.flatnonzero((data == _NEWLINE) | ((data == _RETURN) & (follows != _NEWLINE)))
    in_quotes = np.bitwise_xor.accumulate((data == _QUOTE).astype(np.uint8))
    ends = line_ends[in_quotes[line_ends] == 0]
    starts = np.concatenate([[0], ends + 1])
    sizes = np.append(ends, len(data)) - starts
    is_blank = (sizes == 0) | ((sizes == 1) & (data[np.minimum(starts, len(data) - 1)] == _RETURN))
    lines: NDArray[np.int64] = np.searchsorted(line_ends, starts[~is_blank]) + 1
    return lines
