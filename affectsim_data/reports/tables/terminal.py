"""Tables in a terminal: they fit its width, and nothing in them steers it."""

from __future__ import annotations

import dataclasses
import itertools
import textwrap
from collections.abc import Sequence

from rich import box
from rich.cells import cell_len
from rich.console import Console
from rich.padding import Padding
from rich.table import Table as RichTable
from rich.text import Text

from affectsim_data.reports.tables.model import Cell, Column, Row, Table
from affectsim_data.reports.tables.texts import cell_text, interval_text, mark_text, one_line, shown

__all__ = ["print_table"]

_GAP = 2
"""Characters between columns."""
_MAX_KEY = 44
"""Width of a column that names rows; longer names are folded."""
_INDENT = 2
"""Of names below a heading."""
_STYLES = {"entry": "", "heading": "bold", "mean": "italic", "reference": "italic"}


@dataclasses.dataclass(frozen=True)
class _Layout:
    """How a table is laid into a width."""

    stacked: bool
    """Whether intervals stand below their numbers."""
    parts: tuple[tuple[int, ...], ...]
    """Columns of each part, without those that name rows."""
    widths: tuple[int, ...]
    """Of all columns."""


def print_table(table: Table, console: Console, *, max_rows: int | None = None) -> None:
    """Prints a table with its caption and footnotes.

    Where it is too wide, intervals go below their numbers; where that is not enough, it is printed
    in parts that all begin with the names of the rows.

    Args:
        table: What to print.
        console: Where.
        max_rows: Rows after which it stops and says how many are left.
    """
    printed, remark = _told_once(dataclasses.replace(table, rows=table.rows[:max_rows]))
    printed = _with_headings(printed)
    layout = _laid_out(printed, console.width)
    console.print()
    console.print(Text(table.title, style="bold"))
    console.print(Text(table.caption, style="dim"))
    if remark:
        console.print(Text(remark, style="dim"))
    for part in layout.parts:
        console.print()
        console.print(_part(printed, layout, part))
    lines = [f"{mark_text(mark)} {text}" for mark, text in printed.footnotes]
    lines += map(one_line, table.notes)
    rest = len(table.rows) - len(table.rows[:max_rows])
    if rest:
        lines.append(f"{rest:,} more rows; `affectsim report` writes them all")
    for line in lines:
        console.print(Text(line, style="dim"))


def _told_once(table: Table) -> tuple[Table, str]:
    """The table without the second of its names if that is always the same, which is told."""
    names = {row.cells[1].value for row in table.rows if row.role == "entry"}
    if table.num_keys != 2 or len(names) != 1 or len(table.rows) < 2:
        return table, ""
    rows = tuple(
        dataclasses.replace(row, cells=(row.cells[0], *row.cells[2:])) for row in table.rows
    )
    columns = (table.columns[0], *table.columns[2:])
    remark = f"{table.columns[1].title}: {shown(str(names.pop()))}"
    return dataclasses.replace(table, columns=columns, rows=rows, num_keys=1), remark


def _with_headings(table: Table) -> Table:
    """The table with its first column as headings, where several rows after another share it."""
    names = [row.cells[0].value for row in table.rows]
    repeats = any(one == other for one, other in itertools.pairwise(names))
    if table.num_keys < 2 or not repeats or _headings(table):
        return table
    rows: list[Row] = []
    before = None
    for row in table.rows:
        first, second, *others = row.cells
        if second.value is None:  # such as chance, which is no entry of a group
            rows.append(Row((first, *others), row.role))
            continue
        if first.value != before:
            rows.append(Row((first,), "heading"))
            before = first.value
        rows.append(dataclasses.replace(row, cells=(second, *others)))
    columns, keys = table.columns[1:], table.num_keys - 1
    return dataclasses.replace(table, columns=columns, rows=tuple(rows), num_keys=keys)


def _laid_out(table: Table, width: int) -> _Layout:
    keys, places = table.num_keys, range(len(table.columns))
    least = [min(_word_width(table, place), _MAX_KEY // 2) for place in range(keys)]
    for stacked in (False, True):
        widths = [_width(table, place, stacked=stacked) for place in places]
        gaps = _GAP * (len(widths) - 1)
        widths[:keys] = _narrowed(widths[:keys], least, width - sum(widths[keys:]) - gaps)
        if sum(widths) + gaps <= width:
            return _Layout(stacked, (tuple(places[keys:]),), tuple(widths))
    widths[:keys] = _narrowed(
        [_width(table, place, stacked=True) for place in range(keys)], least, width * 2 // 5
    )
    room = width - sum(widths[:keys]) - _GAP * keys
    return _Layout(True, _packed(places[keys:], widths, room), tuple(widths))


def _narrowed(widths: Sequence[int], least: Sequence[int], room: int) -> list[int]:
    """Widths that fit the room, as far as none gets less than its least."""
    narrow = list(widths)
    while sum(narrow) > room:
        spare = [width - floor for width, floor in zip(narrow, least, strict=True)]
        if max(spare) <= 0:
            break
        narrow[spare.index(max(spare))] -= 1
    return narrow


def _packed(places: Sequence[int], widths: Sequence[int], room: int) -> tuple[tuple[int, ...], ...]:
    """Columns in parts that fit the room, at least one in each."""
    parts: list[list[int]] = [[]]
    used = 0
    for place in places:
        if parts[-1] and used + widths[place] + _GAP > room + _GAP:
            parts.append([])
            used = 0
        parts[-1].append(place)
        used += widths[place] + _GAP
    return tuple(map(tuple, parts))


def _width(table: Table, place: int, *, stacked: bool) -> int:
    """Width of the widest cell; titles are wrapped at words."""
    column = table.columns[place]
    texts = [*shown(column.title).split(" "), *column.detail.split(" ")]
    for row in table.entries:
        texts += _lines(row.cells[place], table, place, stacked=stacked)
    if place < table.num_keys:
        indent = _INDENT if place == 0 and _headings(table) else 0
        headings = _headings(table) if place == 0 else []
        width = max([indent + max(map(cell_len, texts)), *map(cell_len, headings)])
        return min(width, _MAX_KEY)
    return max(map(cell_len, texts))


def _word_width(table: Table, place: int) -> int:
    """Width of the longest word of a column that names rows."""
    texts = [table.columns[place].title, table.columns[place].detail]
    texts += _headings(table) if place == 0 else []
    texts += [cell_text(row.cells[place], table.columns[place]) for row in table.entries]
    return max(cell_len(word) for text in texts for word in ["", *text.split()])


def _headings(table: Table) -> list[str]:
    return [shown(str(row.cells[0].value)) for row in table.rows if row.role == "heading"]


def _part(table: Table, layout: _Layout, part: Sequence[int]) -> RichTable:
    """The names of the rows and some of the other columns."""
    places = [*range(table.num_keys), *part]
    # The box has a character between columns, the padding gives the other.
    printed = RichTable(
        box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, _GAP - 1, 0, 0)
    )
    for place in places:
        column, width = table.columns[place], layout.widths[place]
        is_text = column.kind == "text"
        printed.add_column(
            _title(column, width),
            width=width,
            justify="left" if is_text else "right",
            overflow="fold",
        )
    below = bool(_headings(table))
    for row in table.rows:
        if row.role == "heading":
            name = Text(shown(str(row.cells[0].value)), style=_STYLES["heading"])
            printed.add_row(name, *[""] * (len(places) - 1))
        else:
            name, *cells = [_text(row.cells[place], table, place, layout) for place in places]
            inner = Padding(name, (0, 0, 0, _INDENT if row.role == "entry" and below else 0))
            printed.add_row(inner, *cells, style=_STYLES[row.role])
    return printed


def _title(column: Column, width: int) -> Text:
    title = Text("\n".join(textwrap.wrap(shown(column.title), width)), style="bold")
    if column.detail:
        detail = "\n".join(textwrap.wrap(column.detail, width))
        title.append(f"\n{detail}", style="not bold dim")
    return title


def _text(cell: Cell, table: Table, place: int, layout: _Layout) -> Text:
    number, *interval = _lines(cell, table, place, stacked=layout.stacked)
    text = Text(number, style="bold" if cell.best else "")
    for line in interval:
        text.append(f"\n{line}", style="not bold dim")
    return text


def _lines(cell: Cell, table: Table, place: int, *, stacked: bool) -> list[str]:
    """A number and its interval in one line or two; aligned with those that bear marks."""
    column = table.columns[place]
    text = cell_text(cell, column) + mark_text(cell.mark)
    if column.kind == "text":
        return [text]
    if text and not cell.mark and any(row.cells[place].mark for row in table.entries):
        text += " "
    interval = interval_text(cell, column)
    if not interval:
        return [text]
    return [text, interval] if stacked else [f"{text} {interval}"]
