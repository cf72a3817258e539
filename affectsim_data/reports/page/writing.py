"""One self-contained HTML page: no script, nothing loaded, every text from data escaped."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from affectsim_data.content import content_path
from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.page.examples import Example
from affectsim_data.reports.page.layout import page_values
from affectsim_data.reports.tables.model import Table
from affectsim_data.reports.tables.texts import one_line

__all__ = ["page_text", "write_page"]

_TEMPLATE = "report.html.jinja"
_PER_CENT = re.compile(r"(?<=\d) %")


def write_page(
    evaluation: Evaluation,
    tables: Sequence[Table],
    figures: Mapping[str, bytes],
    path: Path | str,
    *,
    examples: Sequence[Example] = (),
) -> None:
    """Writes a page a stranger can read; the same results give the same bytes.

    Args:
        evaluation: What was found.
        tables: Its tables, as `reports.tables.tables_of` gives them.
        figures: Its figures, as `reports.figures.draw_figures` gives them; without any, the page
            has none.
        path: Where to write; its folder is there, and a file of that name is replaced.
        examples: Answers to quote.
    """
    path = Path(path)
    half = path.with_name(f".{path.name}.half")
    half.write_text(
        page_text(evaluation, tables, figures, examples=examples), encoding="utf-8", newline="\n"
    )
    os.replace(half, path)


def page_text(
    evaluation: Evaluation,
    tables: Sequence[Table],
    figures: Mapping[str, bytes],
    *,
    examples: Sequence[Example] = (),
) -> str:
    """The page as HTML; arguments as of `write_page`."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(content_path("cards")),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        finalize=_visible,
        keep_trailing_newline=True,
    )
    values = page_values(evaluation, tables, figures, examples)
    return environment.get_template(_TEMPLATE).render(page=values)


def _visible(value: Any) -> Any:
    """Text from data as one line in which every character can be seen, per cent kept together."""
    if isinstance(value, Markup) or not isinstance(value, str):
        return value
    return _PER_CENT.sub("\N{NO-BREAK SPACE}%", one_line(value))
