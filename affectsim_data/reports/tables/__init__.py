"""The tables of an evaluation: one model, and writers for terminal, Markdown, CSV and LaTeX."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Console
from rich.text import Text

from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.tables.benefit_tables import benefit_tables
from affectsim_data.reports.tables.breakdown_tables import breakdown_tables, ring_table
from affectsim_data.reports.tables.latex import latex_table
from affectsim_data.reports.tables.markdown import markdown_table
from affectsim_data.reports.tables.model import Cell, Column, Row, Table
from affectsim_data.reports.tables.paper_layout import paper_tables
from affectsim_data.reports.tables.published_tables import published_tables
from affectsim_data.reports.tables.quality import quality_tables, summary_table
from affectsim_data.reports.tables.spreadsheet import csv_table
from affectsim_data.reports.tables.terminal import print_table
from affectsim_data.reports.tables.texts import one_line

__all__ = [
    "Cell",
    "Column",
    "Row",
    "Table",
    "csv_table",
    "latex_table",
    "markdown_table",
    "print_tables",
    "settings_lines",
    "tables_of",
]

_MAX_ROWS = 60
"""Rows a table has in a terminal; more are for files."""
_FOR_FILES = ("confusions", "by_scene", "recall")
"""And so are these: long, or the same numbers as in another table."""
_QUOTED = "published_"


def tables_of(evaluation: Evaluation) -> tuple[Table, ...]:
    """The tables of a report, in its order.

    The summary, those of the paper, ours, and at last the paper's own rows; which there are depends
    on the conditions that were evaluated.
    """
    rings = [ring_table(evaluation)] if "a_obs" in evaluation.conditions else []
    return (
        summary_table(evaluation),
        *paper_tables(evaluation),
        *benefit_tables(evaluation),
        *rings,
        *quality_tables(evaluation),
        *breakdown_tables(evaluation),
        *published_tables(),
    )


def print_tables(
    evaluation: Evaluation,
    console: Console,
    *,
    findings: Sequence[str] = (),
    brief: bool = False,
) -> None:
    """Prints what was evaluated and the main thing; then, unless `brief`, the other tables.

    Confusions, scenes and the paper's own rows are left to the files of a report.

    Args:
        evaluation: What was found.
        console: Where to print.
        findings: The main thing in sentences, printed first.
        brief: Only the main thing.
    """
    for line in settings_lines(evaluation):
        console.print(Text(line))
    for sentence in findings:
        console.print()
        console.print(Text(one_line(sentence), style="bold" if sentence == findings[0] else ""))
    if evaluation.notes:
        console.print()
    for note in evaluation.notes:
        console.print(Text(f"Note: {one_line(note)}", style="yellow"))
    first, *others = tables_of(evaluation)
    print_table(first, console)
    for table in [] if brief else others:
        if table.name not in _FOR_FILES and not table.name.startswith(_QUOTED):
            print_table(table, console, max_rows=_MAX_ROWS)


def settings_lines(evaluation: Evaluation) -> Sequence[str]:
    """What was evaluated, and how its intervals were made."""
    settings = evaluation.settings
    return (
        f"{one_line(evaluation.release)}, split {one_line(evaluation.split)}: "
        f"{evaluation.num_episodes:,} episodes, {_counted(len(evaluation.models), 'model')}, "
        f"{_counted(len(evaluation.conditions), 'condition')}",
        f"{100 * settings.confidence:g} % intervals: {settings.interval}; "
        f"{settings.num_resamples:,} resamples of "
        f"{_counted(settings.num_clusters, settings.cluster)}, seed {settings.seed}",
    )


def _counted(count: int, noun: str) -> str:
    return f"{count:,} {noun}{'' if count == 1 else 's'}"
