"""Rows of models: gathered by group as in the paper, with means of groups and what chance gives."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

from affectsim_data.evaluation.results import (
    Estimate,
    Evaluation,
    GroupMean,
    ModelCard,
    ReferenceRow,
    Subset,
)
from affectsim_data.reports.tables.model import Cell, Column, Mark, Row, number

__all__ = [
    "above_chance",
    "chance_row",
    "find_mean",
    "gathered",
    "mean_name",
    "model_columns",
    "model_keys",
    "needs",
    "reference_name",
    "reference_rows",
    "with_best",
]


def model_columns(evaluation: Evaluation) -> tuple[Column, ...]:
    """Columns that name a model; its size only where somebody told one."""
    name = Column("model", "Model")
    if any(card.parameters for card in evaluation.models):
        return (name, Column("parameters", "Size"))
    return (name,)


def model_keys(evaluation: Evaluation, name: str, parameters: str = "") -> tuple[Cell, ...]:
    """The cells of `model_columns`."""
    keys = (Cell(name), Cell(parameters or None))
    return keys[: len(model_columns(evaluation))]


def gathered(
    evaluation: Evaluation,
    entry: Callable[[ModelCard], Sequence[Cell]],
    mean: Callable[[GroupMean], Sequence[Cell]] | None = None,
    *,
    subset: Subset = "all",
) -> list[Row]:
    """A row per model under the heading of its group; then the mean of the group, and of all.

    A mean over one model would repeat it and is left out.

    Args:
        evaluation: Whose models.
        entry: The cells of a model, behind those that name it.
        mean: The same of a group's mean; without it no means are given.
        subset: Of the means.
    """
    groups = list(dict.fromkeys(card.group for card in evaluation.models))
    rows: list[Row] = []
    for group in groups:
        cards = [card for card in evaluation.models if card.group == group]
        if len(groups) > 1 or group:
            rows.append(Row((Cell(group or "Other models"),), "heading"))
        rows += [
            Row((*model_keys(evaluation, card.model, card.parameters), *entry(card)))
            for card in cards
        ]
        if mean is not None and group and len(cards) > 1 and len(groups) > 1:
            rows += _mean_rows(evaluation, group, subset, mean)
    if mean is not None and len(evaluation.models) > 1:
        rows += _mean_rows(evaluation, "", subset, mean)
    return rows


def _mean_rows(
    evaluation: Evaluation,
    group: str,
    subset: Subset,
    cells: Callable[[GroupMean], Sequence[Cell]],
) -> list[Row]:
    mean = find_mean(evaluation, group, subset)
    if mean is None:
        return []
    return [Row((*model_keys(evaluation, mean_name(mean)), *cells(mean)), "mean")]


def find_mean(evaluation: Evaluation, group: str, subset: Subset = "all") -> GroupMean | None:
    """The means of a group, or `None` if there are none."""
    return next(
        (one for one in evaluation.means if (one.group, one.subset) == (group, subset)), None
    )


def mean_name(mean: GroupMean) -> str:
    """How a table names a mean."""
    return f"{mean.group or 'All models'}: mean ({mean.num_models})"


def above_chance(estimate: Estimate | None, chance: float, *, best: bool = False) -> Cell:
    """The cell of a Macro-F1, marked unless all of its interval is above chance."""
    cell = number(estimate, best=best)
    if cell.is_undefined or cell.low > chance:
        return cell
    return dataclasses.replace(cell, mark="†")


def with_best(cells: Sequence[Cell]) -> list[Cell]:
    """The cells with the highest printed bold; none of a single one."""
    values = [cell.value for cell in cells if isinstance(cell.value, float)]
    known = [value for value in values if not math.isnan(value)]
    if len(known) < 2:
        return list(cells)
    return [dataclasses.replace(cell, best=cell.value == max(known)) for cell in cells]


def needs(estimate: Estimate | None, *conditions: str, of: Evaluation, why: Mark = "c") -> Cell:
    """The cell of an estimate that needs conditions; where it is undefined, whether for want of
    them."""
    missing = any(condition not in of.conditions for condition in conditions)
    return number(estimate, why="a" if missing else why)


def chance_row(evaluation: Evaluation, num_scores: int, num_others: int = 0) -> Row:
    """The row of chance: the same Macro-F1 whatever the condition, then blanks."""
    keys = model_keys(evaluation, "Chance (uniform)")
    return Row(
        (*keys, *[Cell(evaluation.chance)] * num_scores, *[Cell()] * num_others), "reference"
    )


def reference_rows(evaluation: Evaluation, num_scores: int, num_others: int = 0) -> list[Row]:
    """What answering without looking scores, the same under every condition."""
    return [
        Row(
            (
                *model_keys(evaluation, reference_name(reference)),
                *[Cell(reference.macro_f1)] * num_scores,
                *[Cell()] * num_others,
            ),
            "reference",
        )
        for reference in evaluation.references
    ]


def reference_name(reference: ReferenceRow) -> str:
    """How a table names a way of answering without looking.

    Examples:
        >>> reference_name(ReferenceRow("constant:happy", 1 / 15))
        'Always happy'
    """
    kind, _, emotion = reference.name.partition(":")
    names = {"uniform": "Chance (uniform)", "prior": "Guessing by the prior"}
    return f"Always {emotion}" if kind == "constant" else names.get(kind, reference.name)
