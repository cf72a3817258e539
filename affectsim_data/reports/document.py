"""A report as one Markdown document: findings, figures, tables."""

from __future__ import annotations

from collections.abc import Collection, Sequence

from affectsim_data.evaluation.results import Evaluation
from affectsim_data.reports.figures import figure_texts
from affectsim_data.reports.page import findings
from affectsim_data.reports.page.guide import guide
from affectsim_data.reports.tables import Table, settings_lines
from affectsim_data.reports.tables.markdown import markdown_name, markdown_table, markdown_text

__all__ = ["report_markdown"]

_MAX_ROWS = 200
"""Rows of a table in a document for people."""


def report_markdown(
    evaluation: Evaluation, tables: Sequence[Table], figures: Collection[str]
) -> str:
    """The document; it names figures as `figures/NAME.png` and tables as `tables/NAME.csv`.

    Args:
        evaluation: What was found.
        tables: Its tables.
        figures: Names of the files of figures there are.
    """
    topics = dict.fromkeys(table.topic for table in tables)
    title = f"{markdown_name(evaluation.release)}, {markdown_name(evaluation.split)}"
    parts = [
        f"# Evaluation on {title}",
        "\n".join(f"- {markdown_text(line)}" for line in settings_lines(evaluation)),
        *[markdown_text(sentence) for sentence in findings(evaluation)],
        *[f"> **Note:** {markdown_text(note)}" for note in evaluation.notes],
        "## How to read this",
        *[f"**{term}.** {markdown_text(text)}" for term, text in guide(evaluation)],
        *_figures(evaluation, figures),
    ]
    for topic in topics:
        parts.append(f"## {topic}")
        parts += [_table(table) for table in tables if table.topic == topic]
    return "\n\n".join(parts) + "\n"


def _figures(evaluation: Evaluation, figures: Collection[str]) -> list[str]:
    parts = []
    for name, text in figure_texts(evaluation).items():
        if f"{name}.png" in figures:
            parts.append(f"![{text.title}](figures/{name}.png)\n\n*{text.title}.* {text.caption}")
    return ["## Figures", *parts] if parts else []


def _table(table: Table) -> str:
    files = f"[CSV](tables/{table.name}.csv), [LaTeX](tables/{table.name}.tex)"
    if len(table.rows) > _MAX_ROWS:
        rest = f"{len(table.rows):,} rows, left to the files: {files}"
        return f"### {table.title}\n\n{table.caption}\n\n{rest}"
    return f"{markdown_table(table)}\n\n{files}"
