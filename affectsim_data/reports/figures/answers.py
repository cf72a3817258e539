"""What is answered: confusions of the emotions, and answers that name none."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.results import ConditionScore, Evaluation
from affectsim_data.evaluation.scored import OUTCOMES
from affectsim_data.inspection.figures import INK
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray
from affectsim_data.reports.figures.marks import condition_marks
from affectsim_data.reports.figures.panels import grouped_models, label_rows, row_inches

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_confusions", "draw_outcomes"]

_SHADES: FloatArray = np.array([[0.92, 0.95, 0.98], [0.36, 0.64, 0.82], [0.0, 0.28, 0.47]])
"""Of a share of 0, 0.5 and 1: opaque, so that its number reads alike on light and dark pages."""
_DARK_SHARE = 0.5
"""From here on numbers are white."""
_PARTS = {
    "right": "#0072b2",
    "wrong emotion": "#56b4e9",
    "refusal": "#d55e00",
    "ambiguous": "#e69f00",
    "empty": "#cc79a7",
    "other": "#8c8c8c",
    "missing": "#009e73",
}
"""The last five are `OUTCOMES`."""


def draw_confusions(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """A confusion per condition, rows in per cent; of several models their mean."""
    marks = [
        mark
        for mark in condition_marks(evaluation.conditions)
        if _scores(evaluation, mark.condition)
    ]
    columns = min(len(marks), 2 if len(marks) == 4 else 3)
    rows = -(-len(marks) // columns)
    figure = draw(
        figsize=(min(7.2, 3.6 * columns), 0.35 + (3.0 if columns < 3 else 2.5) * rows),
        layout="constrained",
    )
    panels = figure.subplots(rows, columns, squeeze=False)
    for place, axes in enumerate(panels.ravel()):
        if place >= len(marks):
            axes.set_visible(False)
            continue
        shares = _mean_confusion(_scores(evaluation, marks[place].condition))
        _draw_confusion(axes, shares)
        axes.set_title(marks[place].label, fontsize=10, color=INK)
        if place % columns == 0:
            axes.set_ylabel("acted emotion", color=INK, fontsize=10)
        if place + columns >= len(marks):
            axes.set_xlabel("answer", color=INK, fontsize=10)
    return figure


def _scores(evaluation: Evaluation, condition: str) -> list[ConditionScore]:
    return [
        one
        for one in evaluation.scores
        if one.condition == condition and one.subset == "all" and one.num_episodes
    ]


def _mean_confusion(scores: Sequence[ConditionScore]) -> FloatArray:
    """Shares `(5, 6)` of each true emotion's answers, the mean over models; NaN without any."""
    counts: FloatArray = np.array([one.confusion for one in scores], dtype=np.float64)
    totals = counts.sum(axis=2, keepdims=True)
    shares = np.divide(counts, totals, out=np.full(counts.shape, np.nan), where=totals > 0)
    mean: FloatArray = shares.mean(axis=0)
    return mean


def _draw_confusion(axes: Any, shares: FloatArray) -> None:
    from matplotlib.patches import Rectangle

    columns = (*EMOTIONS, "none")
    for row, column in np.ndindex(*shares.shape):
        share = float(shares[row, column])
        if np.isnan(share):
            continue
        corner = (column - 0.48, row - 0.46)
        axes.add_patch(Rectangle(corner, 0.96, 0.92, facecolor=_shade(share), edgecolor="none"))
        axes.text(
            column,
            row,
            f"{100 * share:.0f}",
            ha="center",
            va="center",
            fontsize=9,
            color="#ffffff" if share > _DARK_SHARE else "#1a1a1a",
            fontweight="bold" if row == column else "normal",
        )
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(EMOTIONS) - 0.5, -0.5)
    axes.set_xticks(range(len(columns)), columns, rotation=30, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(EMOTIONS)), EMOTIONS)
    axes.tick_params(colors=INK, labelsize=9, length=0)
    axes.spines[:].set_visible(False)
    axes.axvline(len(EMOTIONS) - 0.5, color=INK, linewidth=0.8)


def _shade(share: float) -> tuple[float, ...]:
    steps = np.linspace(0.0, 1.0, len(_SHADES))
    return tuple(float(np.interp(share, steps, channel)) for channel in _SHADES.T)


def draw_outcomes(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """A bar per model and condition: right, wrong, and the ways of naming no emotion."""
    marks = condition_marks(evaluation.conditions)
    groups = grouped_models(evaluation, lambda model: 0.0)
    cards = [card for _, mine in groups for card in mine]
    height = 1.15 + row_inches(len(cards)) * len(cards)
    figure = draw(figsize=(7.2, height), layout="constrained")
    panels = np.atleast_1d(figure.subplots(1, len(marks), sharey=True))
    for axes, mark in zip(panels, marks, strict=True):
        found = [evaluation.score(card.model, mark.condition) for card in cards]
        shares = np.array([_parts(one) for one in found])
        left = np.zeros(len(cards))
        for column, color in enumerate(_PARTS.values()):
            axes.barh(range(len(cards)), shares[:, column], left=left, color=color, height=0.7)
            left += shares[:, column]
        label_rows(axes, evaluation, cards)
        axes.set_xlim(0, 100)
        axes.set_xticks([0, 40, 80])
        axes.set_title(mark.label, fontsize=10, color=INK)
    figure.supxlabel("share of episodes, %", color=INK, fontsize=10)
    _legend(figure)
    return figure


def _parts(score: ConditionScore | None) -> NDArray[np.float64]:
    """Shares of the parts of a bar, per cent; zeros for a model that was not run."""
    if score is None or not score.num_episodes:
        return np.zeros(len(_PARTS))
    right = sum(score.confusion[place][place] for place in range(len(EMOTIONS)))
    counts = [right, score.num_valid - right, *(score.outcomes.get(one, 0) for one in OUTCOMES)]
    return 100 * np.array(counts, dtype=np.float64) / score.num_episodes


def _legend(figure: Figure) -> None:
    from matplotlib.patches import Patch

    figure.legend(
        handles=[Patch(facecolor=color, label=name) for name, color in _PARTS.items()],
        loc="outside upper center",
        ncols=len(_PARTS),
        frameon=False,
        labelcolor=INK,
        fontsize=8.5,
        handlelength=1.0,
        columnspacing=1.2,
    )
