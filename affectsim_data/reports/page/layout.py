"""Tables, figures and words of a page as its template takes them; nothing is escaped here."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from affectsim_data import __version__
from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.figures import figure_texts
from affectsim_data.reports.page.examples import Example
from affectsim_data.reports.page.findings import findings
from affectsim_data.reports.page.guide import guide
from affectsim_data.reports.page.pictures import inline_svg
from affectsim_data.reports.tables.model import Cell, Column, Row, Table
from affectsim_data.reports.tables.texts import (
    cell_text,
    condition_title,
    interval_text,
    mark_text,
    one_line,
)

__all__ = ["page_values"]

_LONGEST_ANSWER, _LONGEST_NAME = 300, 160
_OPEN, _MOST_OPEN = ("main_results", "benefits"), 40
"""Tables a reader need not open, if they are short."""
_PUBLISHED = "published_"
"""Tables that quote the paper are named with it."""


def page_values(
    evaluation: Evaluation,
    tables: Sequence[Table],
    figures: Mapping[str, bytes],
    examples: Sequence[Example],
) -> dict[str, Any]:
    """Everything the template asks for."""
    own = [table for table in tables if not table.name.startswith(_PUBLISHED)]
    quoted = [table for table in tables if table.name.startswith(_PUBLISHED)]
    summary = [table for table in own if table.name == "summary"]
    topics = list(dict.fromkeys(table.topic for table in own if table not in summary))
    return {
        "release": evaluation.release,
        "split": evaluation.split,
        "facts": _facts(evaluation),
        "notes": evaluation.notes,
        "findings": findings(evaluation),
        "summary": _table(summary[0]) if summary else None,
        "pictures": _pictures(evaluation, figures),
        "guide": guide(evaluation),
        "topics": [
            (topic, [_table(one) for one in own if one.topic == topic and one not in summary])
            for topic in topics
        ],
        "examples": [_example(one) for one in examples],
        "settings": _settings(evaluation),
        "published": [_table(one) for one in quoted],
        "version": __version__,
    }


def _facts(evaluation: Evaluation) -> list[tuple[str, str]]:
    settings, names = evaluation.settings, [card.model for card in evaluation.models]
    several = f"{len(names)} models"
    return [
        ("Release", evaluation.release),
        ("Split", evaluation.split),
        ("Episodes", f"{evaluation.num_episodes:,}"),
        (f"{settings.cluster.capitalize()}s", f"{settings.num_clusters:,}"),
        ("Recognizers", _clipped(names[0], _LONGEST_NAME) if len(names) == 1 else several),
        ("Conditions", ", ".join(condition_title(one) for one in evaluation.conditions)),
    ]


def _settings(evaluation: Evaluation) -> list[tuple[str, str]]:
    settings = evaluation.settings
    return [
        ("Kind of interval", settings.interval),
        ("Confidence", f"{100 * settings.confidence:g} %"),
        ("Resampled by", f"{settings.cluster}, {settings.num_clusters:,} of them"),
        ("Resamples", f"{settings.num_resamples:,}"),
        ("Permutations", f"{settings.num_permutations:,}"),
        ("Seed", str(settings.seed)),
    ]


def _pictures(evaluation: Evaluation, figures: Mapping[str, bytes]) -> list[dict[str, Any]]:
    """Figures with their words; those of which no SVG was handed over are left out."""
    return [
        {
            "title": text.title,
            "caption": text.caption,
            "svg": inline_svg(
                figures[f"{name}.svg"],
                name,
                label=f"{text.title}. The tables of this page have its numbers.",
            ),
        }
        for name, text in figure_texts(evaluation).items()
        if f"{name}.svg" in figures
    ]


def _table(table: Table) -> dict[str, Any]:
    entries = sum(row.role != "heading" for row in table.rows)
    return {
        "title": table.title,
        "caption": table.caption,
        "size": f"{entries:,} row{'' if entries == 1 else 's'}",
        "is_open": table.name in _OPEN and entries <= _MOST_OPEN,
        "columns": [
            {
                "title": _clipped(column.title, _LONGEST_NAME),
                "detail": column.detail,
                "is_name": column.kind == "text",
            }
            for column in table.columns
        ],
        "rows": [{"role": row.role, "cells": _cells(row, table)} for row in table.rows],
        "remarks": [
            *((mark_text(mark), text) for mark, text in table.footnotes),
            *(("", note) for note in table.notes),
        ],
    }


def _cells(row: Row, table: Table) -> list[dict[str, Any]]:
    columns = table.columns[:1] if row.role == "heading" else table.columns
    return [
        _cell(cell, column, is_key=place < table.num_keys)
        for place, (cell, column) in enumerate(zip(row.cells, columns, strict=True))
    ]


def _cell(cell: Cell, column: Column, *, is_key: bool) -> dict[str, Any]:
    """A cell; names are whole here, for figures and terminals shorten them."""
    is_text = isinstance(cell.value, str)
    return {
        "text": _clipped(str(cell.value), _LONGEST_NAME) if is_text else cell_text(cell, column),
        "interval": interval_text(cell, column),
        "mark": mark_text(cell.mark),
        "best": cell.best,
        "is_key": is_key,
        "is_text": is_text,
    }


def _example(example: Example) -> dict[str, str]:
    values = {
        field.name: _clipped(getattr(example, field.name), _LONGEST_NAME)
        for field in dataclasses.fields(example)
    }
    said = _clipped(example.raw_text, _LONGEST_ANSWER) or "(nothing)"
    return values | {"raw_text": said, "condition": condition_title(values["condition"])}


def _clipped(text: str, longest: int) -> str:
    """One line in which every character can be seen, cut where it is too long."""
    # A character that cannot be seen becomes several that can: cut before and after.
    line = one_line(text[: 4 * longest])
    return line if len(line) <= longest else f"{line[: longest - 1]}…"
