r"""Tables as LaTeX with booktabs; text from data cannot be a command.

Only ASCII and the accented letters of Western Europe come out as letters: others would stop
pdfLaTeX, so they are written as their code points.
"""

from __future__ import annotations

import unicodedata
from collections.abc import Sequence

from affectsim_data.reports.tables.model import Cell, Column, Row, Table
from affectsim_data.reports.tables.texts import (
    DASH,
    MINUS,
    cell_text,
    interval_text,
    one_line,
    shown,
)

__all__ = ["latex_table", "latex_text"]

_MAX_ROWS = 45
"""Longer tables are set over several pages."""
_COMMANDS = {
    "\\": r"\textbackslash{}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    '"': r"\textquotedblright{}",
    "'": r"\textquotesingle{}",
    "`": r"\textasciigrave{}",
    "[": "{[}",  # with the next two, an argument of the end of the line before
    "]": "{]}",
    "*": "{*}",
    "\N{HORIZONTAL ELLIPSIS}": r"\ldots{}",
    "\N{DAGGER}": r"$^{\dagger}$",
    "\N{INFINITY}": r"$\infty$",
    DASH: r"\textendash{}",
    MINUS: "$-$",
    **{letter: f"\\{letter}" for letter in "{}$&#%_"},
}
_LETTERS = frozenset("ÀÁÂÃÄÅÆÇÈÉÊËÌÍÎÏÑÒÓÔÕÖØÙÚÛÜÝßàáâãäåæçèéêëìíîïñòóôõöøùúûüýÿ")
"""What LaTeX sets in any of its encodings of fonts."""


def latex_text(text: str) -> str:
    r"""A line of text that LaTeX sets as it is.

    Examples:
        >>> print(latex_text(r"50 % of a_b \input{x}"))
        50 \% of a\_b \textbackslash{}input\{x\}
        >>> latex_text("a--b 中")
        'a-{}-b {[}U+4E2D{]}'
    """
    line = unicodedata.normalize("NFC", one_line(text))
    pieces = (
        letter
        if letter in _COMMANDS or letter.isascii() or letter in _LETTERS
        else f"[U+{ord(letter):04X}]"
        for letter in line
    )
    escaped = "".join(_COMMANDS.get(letter, letter) for piece in pieces for letter in piece)
    # Not joined into dashes and quotes.
    for pair in ("--", ",,"):
        while pair in escaped:
            escaped = escaped.replace(pair, f"{pair[0]}{{}}{pair[1]}")
    return escaped


def latex_table(table: Table) -> str:
    """A table as a float, or over several pages if it is long, with the packages it needs."""
    is_long = len(table.rows) > _MAX_ROWS
    alignment = "".join("l" if column.kind == "text" else "r" for column in table.columns)
    head = [*_titles(table.columns), r"\midrule"]
    body = [line for place, row in enumerate(table.rows) for line in _lines(table, row, place)]
    packages = rf"\usepackage{{booktabs}} \usepackage{{{'longtable' if is_long else 'graphicx'}}}"
    caption = rf"\caption{{{_caption(table)}}}"
    label = rf"\label{{tab:{table.name.replace('_', '-')}}}"
    if is_long:
        lines = [
            *[r"{\scriptsize", r"\setlength{\tabcolsep}{5pt}"],
            *[rf"\begin{{longtable}}{{{alignment}}}", rf"{caption}{label}\\", r"\toprule"],
            *[*head, r"\endfirsthead", r"\toprule", *head, r"\endhead"],
            *[*body, r"\bottomrule", r"\end{longtable}", "}"],
        ]
    else:
        lines = [
            *[r"\begin{table}[t]", r"\centering", r"\setlength{\belowcaptionskip}{4pt}"],
            *[caption, label, r"\footnotesize", r"\setlength{\tabcolsep}{5pt}"],
            # Made smaller if it is too wide, never larger.
            r"\resizebox{\ifdim\width>\linewidth\linewidth\else\width\fi}{!}{%",
            *[rf"\begin{{tabular}}{{{alignment}}}", r"\toprule", *head],
            *[*body, r"\bottomrule", r"\end{tabular}}", r"\end{table}"],
        ]
    return "\n".join([f"% {packages}", *lines, ""])


def _caption(table: Table) -> str:
    remarks = [f"{_mark(mark)} {latex_text(text)}." for mark, text in table.footnotes]
    # A caption has no optional argument, so no fragile command in it needs protection.
    return " ".join([latex_text(table.caption), *remarks, *map(latex_text, table.notes)])


def _titles(columns: Sequence[Column]) -> list[str]:
    """One line of titles, and one of details if any column has them."""
    titles = [
        _aligned(column, rf"\textbf{{{latex_text(shown(column.title))}}}") for column in columns
    ]
    lines = [" & ".join(titles) + r" \\"]
    if any(column.detail for column in columns):
        details = [
            _aligned(column, rf"\scriptsize {latex_text(column.detail)}") if column.detail else ""
            for column in columns
        ]
        lines.append(" & ".join(details) + r" \\")
    return lines


def _aligned(column: Column, text: str) -> str:
    return text if column.kind == "text" else rf"\multicolumn{{1}}{{c}}{{{text}}}"


def _lines(table: Table, row: Row, place: int) -> list[str]:
    """A row, with space or a rule before it where another part begins."""
    before = table.rows[place - 1] if place else None
    starts = before is not None and before.role != row.role and row.role != "entry"
    lines = [r"\midrule" if row.role == "reference" else r"\addlinespace[2pt]"] if starts else []
    if row.role == "heading":
        name = latex_text(shown(str(row.cells[0].value)))
        span = rf"\multicolumn{{{len(table.columns)}}}{{l}}{{\textbf{{\emph{{{name}}}}}}} \\"
        return [*lines, span]
    cells = list(map(_cell, row.cells, table.columns))
    if _continues(table, row, before):
        cells[0] = ""
    return [*lines, " & ".join(cells) + r" \\"]


def _continues(table: Table, row: Row, before: Row | None) -> bool:
    """Whether a row is of the same as the one above it, which is not said again."""
    if table.num_keys < 2 or before is None or any(one.role == "heading" for one in table.rows):
        return False
    return row.cells[0] == before.cells[0]


def _cell(cell: Cell, column: Column) -> str:
    if isinstance(cell.value, str):
        return latex_text(shown(cell.value))
    number = _number(cell_text(cell, column))
    number = rf"\textbf{{{number}}}" if cell.best else number
    interval = _number(interval_text(cell, column))
    return f"{number}{_mark(cell.mark)} {interval}".strip()


def _number(text: str) -> str:
    """A number or an interval; in rows these are never first, so brackets may stay as they are."""
    return "".join(
        _COMMANDS.get(letter, letter) if letter not in "[]" else letter for letter in text
    )


def _mark(mark: str) -> str:
    if not mark.isalpha():
        return _COMMANDS[mark] if mark else ""
    return rf"\textsuperscript{{{mark}}}"
