"""Every model's Macro-F1 by condition in one row, as the paper's Figure 5."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.results import Estimate, Evaluation, ModelCard, Subset
from affectsim_data.inspection.figures import INK
from affectsim_data.reports.figures.marks import (
    ConditionMark,
    condition_legend,
    condition_marks,
    draw_chance,
    draw_estimate,
    points_text,
    short_name,
)
from affectsim_data.reports.figures.panels import (
    grouped_models,
    label_rows,
    model_panels,
    note_column,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_models", "shown_conditions", "shown_difference"]

_OFFSET = 0.17
"""Rows apart: marks of a row stand a little below one another, so that intervals can be told."""


def shown_conditions(evaluation: Evaluation) -> tuple[str, ...]:
    """Conditions of the figure: the paper's three; P-Mon too while nothing was active."""
    if "a_obs" in evaluation.conditions:
        asked: tuple[str, ...] = ("p_init", "a_obs", "p_ref")
    else:
        asked = ("p_init", "p_mon", "p_ref")
    found = tuple(name for name in asked if name in evaluation.conditions)
    return found or evaluation.conditions


def shown_difference(evaluation: Evaluation) -> str:
    """Which difference stands beside the rows: `gain`, `gap`, or none."""
    there = set(evaluation.conditions)
    if {"p_init", "a_obs"} <= there:
        return "gain"
    return "gap" if {"p_init", "p_ref"} <= there else ""


def draw_models(evaluation: Evaluation, draw: type[Figure], subset: Subset) -> Figure:
    """A row per model: a mark per condition, intervals as thin lines, the difference in figures."""
    marks = condition_marks(shown_conditions(evaluation))
    groups = grouped_models(evaluation, lambda model: _last_score(evaluation, model, marks, subset))
    figure, panels = model_panels(draw, groups)
    for place, ((group, cards), [axes]) in enumerate(zip(groups, panels, strict=True)):
        draw_chance(axes, evaluation)
        for row, card in enumerate(cards):
            _draw_row(axes, evaluation, card, row, marks, subset)
        label_rows(axes, evaluation, cards)
        note_column(
            axes,
            [_difference(evaluation, card.model, subset) for card in cards],
            head="" if place else _difference_head(evaluation),
        )
        if group or len(groups) > 1:
            axes.set_title(
                short_name(group or "other models", 60), fontsize=10, color=INK, loc="left"
            )
    panels[-1][0].set_xlabel("Macro-F1, %")
    _set_range(panels[-1][0])
    condition_legend(figure, marks, chance=True)
    return figure


def _draw_row(
    axes: Any,
    evaluation: Evaluation,
    card: ModelCard,
    row: int,
    marks: Sequence[ConditionMark],
    subset: Subset,
) -> None:
    scores = [evaluation.score(card.model, mark.condition, subset) for mark in marks]
    values = [100 * one.macro_f1.value for one in scores if one is not None]
    known = [value for value in values if not math.isnan(value)]
    if len(known) > 1:
        axes.plot([min(known), max(known)], [row, row], color=INK, alpha=0.35, linewidth=2.2)
    for place, (mark, score) in enumerate(zip(marks, scores, strict=True)):
        if score is not None:
            shift = _OFFSET * (place - (len(marks) - 1) / 2)
            draw_estimate(axes, score.macro_f1, row + shift, mark)


def _last_score(
    evaluation: Evaluation, model: str, marks: Sequence[ConditionMark], subset: Subset
) -> float:
    """What rows are sorted by: the reference view where there is one."""
    scores = [evaluation.score(model, mark.condition, subset) for mark in reversed(marks)]
    return next((one.macro_f1.value for one in scores if one is not None), math.nan)


def _difference(evaluation: Evaluation, model: str, subset: Subset) -> tuple[str, bool]:
    benefit, name = evaluation.benefit(model, subset), shown_difference(evaluation)
    if benefit is None or not name:
        return "", False
    estimate: Estimate = benefit.gain if name == "gain" else benefit.gap
    return points_text(estimate), estimate.excludes_zero


def _difference_head(evaluation: Evaluation) -> str:
    heads = {"gain": "A-Obs − P-Init, points", "gap": "P-Ref − P-Init, points"}  # noqa: RUF001
    return heads.get(shown_difference(evaluation), "")


def _set_range(axes: Any) -> None:
    """From 0 or below chance upwards: differences are what is to be seen."""
    low, high = axes.get_xlim()
    axes.set_xlim(max(0.0, low), min(100.0, high))
