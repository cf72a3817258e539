"""Tables of raw numbers as CSV, for programs and spreadsheets."""

from __future__ import annotations

import csv
import io
import math

from affectsim_data.reports.tables.model import Cell, Column, Table
from affectsim_data.reports.tables.texts import one_line

__all__ = ["csv_table", "csv_text_cell"]

_FORMULA = tuple("=+-@\uff1d\uff0b\uff0d\uff20")
"""What a spreadsheet takes a cell for a formula by, in both widths."""


def csv_text_cell(text: str) -> str:
    """Text from data as a spreadsheet shows it: one that would be a formula gets an apostrophe.

    Examples:
        >>> csv_text_cell("=1+1"), csv_text_cell("InternVL2.5")
        ("'=1+1", 'InternVL2.5')
    """
    line = one_line(text)
    return f"'{line}" if line.startswith(_FORMULA) else line


def csv_table(table: Table) -> str:
    """A table as CSV: shares in [0, 1] and full precision, intervals as columns of their own.

    Column `row` says whether a row is an entry, a mean or a reference; `group` whose heading it
    stands under, where there are any. What is undefined is empty.
    """
    with_groups = any(row.role == "heading" for row in table.rows)
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    names = [name for column in table.columns for name in _names(column)]
    writer.writerow(["row", *["group"] * with_groups, *names])
    group = ""
    for row in table.rows:
        if row.role == "heading":
            group = csv_text_cell(str(row.cells[0].value))
            continue
        values = [
            value
            for cell, column in zip(row.cells, table.columns, strict=True)
            for value in _values(cell, column)
        ]
        writer.writerow([row.role, *[group] * with_groups, *values])
    return text.getvalue()


def _names(column: Column) -> list[str]:
    if column.interval == "none":
        return [column.name]
    return [column.name, f"{column.name}_low", f"{column.name}_high"]


def _values(cell: Cell, column: Column) -> list[str]:
    values = [cell.value] if column.interval == "none" else [cell.value, cell.low, cell.high]
    return [_value(value) for value in values]


def _value(value: str | float | int | None) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return csv_text_cell(value) if isinstance(value, str) else repr(value)
