"""Rows and panels that several figures share: models gathered by group, sorted, with labels."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.results import Evaluation, GroupMean, ModelCard, Subset
from affectsim_data.inspection.figures import GRID, INK, style_axes
from affectsim_data.reports.figures.marks import model_labels, short_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "group_means",
    "group_title",
    "grouped_models",
    "label_rows",
    "model_panels",
    "note_column",
    "row_inches",
]

_ROW_INCH, _FEW_ROWS_INCH, _FEW = 0.27, 0.42, 8


def grouped_models(
    evaluation: Evaluation, value: Callable[[str], float]
) -> list[tuple[str, list[ModelCard]]]:
    """Models by group in the order groups come, the highest value first, NaN last."""
    groups: dict[str, list[ModelCard]] = {}
    for card in evaluation.models:
        groups.setdefault(card.group, []).append(card)

    def rank(card: ModelCard) -> tuple[bool, float]:
        score = value(card.model)
        return (True, 0.0) if math.isnan(score) else (False, -score)

    return [(group, sorted(cards, key=rank)) for group, cards in groups.items()]


def row_inches(num_rows: int) -> float:
    """Height of a row: few rows have room for their intervals."""
    return _FEW_ROWS_INCH if num_rows <= _FEW else _ROW_INCH


def model_panels(
    draw: type[Figure], groups: Sequence[tuple[str, Sequence[ModelCard]]], *, columns: int = 1
) -> tuple[Figure, list[list[Any]]]:
    """A figure with a row of panels per group, as high as it has models.

    Returns:
        The figure, and its panels by group and column; those of a column share their x axis.
    """
    counts = [len(cards) for _, cards in groups]
    inch = row_inches(sum(counts))
    height = 1.25 + inch * sum(counts) + 0.42 * (len(groups) - 1)
    figure = draw(figsize=(7.2, height), layout="constrained")
    panels = figure.subplots(
        len(groups),
        columns,
        squeeze=False,
        sharex="col",
        sharey="row",
        height_ratios=[count + 0.6 for count in counts],
    )
    return figure, [list(row) for row in panels]


def label_rows(axes: Any, evaluation: Evaluation, cards: Sequence[ModelCard]) -> None:
    """Names of models beside the axis, the first row on top."""
    labels = model_labels(evaluation.models)
    axes.set_yticks(range(len(cards)), [labels[card.model] for card in cards])
    axes.set_ylim(len(cards) - 0.4, -0.6)
    style_axes(axes, grid="x")
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    for row in range(1, len(cards), 2):
        axes.axhspan(row - 0.5, row + 0.5, color=GRID, alpha=0.1, linewidth=0, zorder=0)


def note_column(axes: Any, notes: Sequence[tuple[str, bool]], *, head: str = "") -> None:
    """Text at the right of each row; what is marked is bold."""
    for row, (text, strong) in enumerate(notes):
        axes.annotate(
            text,
            (1.0, row),
            xycoords=("axes fraction", "data"),
            xytext=(6, 0),
            textcoords="offset points",
            va="center",
            color=INK,
            fontsize=8.5,
            fontweight="bold" if strong else "normal",
            annotation_clip=False,
        )
    if head:
        axes.annotate(
            head,
            (1.0, 1.0),
            xycoords="axes fraction",
            xytext=(6, 5),
            textcoords="offset points",
            color=INK,
            fontsize=8.5,
        )


def group_means(evaluation: Evaluation, subset: Subset = "all") -> list[GroupMean]:
    """Means of the groups that have a name, or that of all models where none has."""
    mine = [mean for mean in evaluation.means if mean.subset == subset]
    named = [mean for mean in mine if mean.group]
    return named or mine[:1]


def group_title(evaluation: Evaluation, mean: GroupMean) -> str:
    """What a panel of a group is headed with."""
    if mean.num_models == 1 and not mean.group:
        return short_name(evaluation.models[0].model, 40)
    name = short_name(mean.group, 34) if mean.group else "all models"
    return f"{name}, mean of {mean.num_models}" if mean.num_models > 1 else name
