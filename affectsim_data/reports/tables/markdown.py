"""Tables as GitHub's Markdown; names from data are text and nothing else."""

from __future__ import annotations

import re

from affectsim_data.cards import markdown
from affectsim_data.reports.tables.model import Cell, Column, Row, Table
from affectsim_data.reports.tables.texts import cell_text, interval_text, mark_text, one_line, shown

__all__ = ["markdown_name", "markdown_table", "markdown_text"]

_LINKED = re.compile(r"://|www\.|(^|\W)@|@[\w-]+\.", re.IGNORECASE)
"""What GitHub makes a link or a mention of without being asked."""


def markdown_text(text: str) -> str:
    """A line of text from data that Markdown shows as it is, whatever its length."""
    line = one_line(text)
    return markdown.code_span(line) if _LINKED.search(line) else markdown.plain(line)


def markdown_name(text: str) -> str:
    r"""The same of a name, which is shortened.

    Examples:
        >>> markdown_name("a|b"), markdown_name("https://example.org")
        ('a\\|b', '`https://example.org`')
    """
    return markdown_text(shown(text))


def markdown_table(table: Table, *, level: int = 3) -> str:
    """A table under its title, with caption and footnotes.

    Args:
        table: What to write.
        level: Of the heading.
    """
    header = [_title(column) for column in table.columns]
    rows = [_row(row, table) for row in table.rows]
    parts = [
        f"{'#' * level} {table.title}",
        table.caption,
        markdown.table(header, rows, left=table.num_keys),
    ]
    remarks = [f"{mark_text(mark)} {text}" for mark, text in table.footnotes]
    remarks += [markdown_text(note) for note in table.notes]
    if remarks:
        parts.append("  \n".join(remarks))
    return "\n\n".join(parts)


def _title(column: Column) -> str:
    title = markdown_name(column.title) if column.from_data else column.title
    return f"{title}<br>{column.detail}" if column.detail else title


def _row(row: Row, table: Table) -> list[str]:
    if row.role == "heading":
        name = markdown_name(str(row.cells[0].value))
        return [f"**{name}**", *[""] * (len(table.columns) - 1)]
    return [_cell(cell, column, row) for cell, column in zip(row.cells, table.columns, strict=True)]


def _cell(cell: Cell, column: Column, row: Row) -> str:
    if isinstance(cell.value, str):
        name = markdown_name(cell.value)
        return f"*{name}*" if row.role in ("mean", "reference") and name else name
    number = cell_text(cell, column) + mark_text(cell.mark)
    number = f"**{number}**" if cell.best else number
    return f"{number} {interval_text(cell, column)}".strip()
