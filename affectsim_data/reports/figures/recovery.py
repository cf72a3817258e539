"""How much there is to gain by a better view, and how much of it active observation recovers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.results import Benefit, Estimate, Evaluation, ModelCard
from affectsim_data.inspection.figures import INK
from affectsim_data.reports.figures.marks import (
    MINUS,
    ConditionMark,
    condition_marks,
    draw_estimate,
    has_interval,
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

__all__ = ["draw_recovery"]

_DIFFERENCES = (("p_mon", "monitor_gap"), ("a_obs", "gain"), ("p_ref", "gap"))
_OFFSET = 0.17
_OGR_RANGE = (-1.0, 2.0)
"""The axis ends here at the latest: a gap near zero makes any ratio."""


def draw_recovery(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """Left: differences from P-Init with intervals; right, with A-Obs: OGR. A row per model."""
    marks = condition_marks(name for name, _ in _DIFFERENCES if name in evaluation.conditions)
    has_ogr = {"a_obs", "p_ref"} <= set(evaluation.conditions)
    groups = grouped_models(evaluation, lambda model: _gap(evaluation, model))
    figure, panels = model_panels(draw, groups, columns=2 if has_ogr else 1)
    for (group, cards), row in zip(groups, panels, strict=True):
        row[0].axvline(0.0, color=INK, linewidth=1.1, zorder=1)
        for place, card in enumerate(cards):
            benefit = evaluation.benefit(card.model)
            if benefit is not None:
                _draw_differences(row[0], benefit, place, marks)
        if has_ogr:
            _draw_ratios(row[1], evaluation, cards)
        for axes in row:
            label_rows(axes, evaluation, cards)
        if len(groups) > 1:
            title = short_name(group or "other models", 60)
            row[0].set_title(title, fontsize=10, color=INK, loc="left")
        if not has_ogr:
            note_column(row[0], [_gap_note(evaluation, card.model) for card in cards])
    panels[-1][0].set_xlabel("change of Macro-F1\nfrom P-Init, points")
    if has_ogr:
        panels[-1][1].set_xlabel("share of the gap\nrecovered (OGR)")
    _legend(figure, marks)
    return figure


def _gap(evaluation: Evaluation, model: str) -> float:
    benefit = evaluation.benefit(model)
    return math.nan if benefit is None else benefit.gap.value


def _gap_note(evaluation: Evaluation, model: str) -> tuple[str, bool]:
    benefit = evaluation.benefit(model)
    if benefit is None or "p_ref" not in evaluation.conditions:
        return "", False
    return points_text(benefit.gap), benefit.gap.excludes_zero


def _draw_differences(
    axes: Any, benefit: Benefit, row: int, marks: Sequence[ConditionMark]
) -> None:
    for place, mark in enumerate(marks):
        estimate: Estimate = getattr(benefit, dict(_DIFFERENCES)[mark.condition])
        shift = _OFFSET * (place - (len(marks) - 1) / 2)
        draw_estimate(axes, estimate, row + shift, mark)


def _draw_ratios(axes: Any, evaluation: Evaluation, cards: Sequence[ModelCard]) -> None:
    """OGR of each model; what is undefined or off the axis is said in words."""
    [mark] = condition_marks(["a_obs"])
    low, high = _ogr_range(evaluation)
    for line in (0.0, 1.0):
        axes.axvline(line, color=INK, linewidth=1.1, zorder=1)
    notes = []
    for row, card in enumerate(cards):
        benefit = evaluation.benefit(card.model)
        ogr = Estimate(math.nan) if benefit is None else benefit.ogr
        notes.append((_ogr_note(ogr), ogr.excludes_zero))
        if math.isfinite(ogr.value):
            _draw_ratio(axes, ogr, row, mark, low, high)
    axes.set_xlim(low, high)
    note_column(axes, notes)


def _draw_ratio(
    axes: Any, ogr: Estimate, row: int, mark: ConditionMark, low: float, high: float
) -> None:
    """A mark with its interval; arrow heads where either is beyond the axis."""
    if low <= ogr.value <= high:
        axes.plot([ogr.value], [row], mark.marker, color=mark.color, markersize=mark.size)
    else:
        _draw_head(axes, low if ogr.value < low else high, row, mark, left=ogr.value < low)
    ends = (max(low, ogr.low), min(high, ogr.high))
    if has_interval(ogr) and ends[0] < ends[1]:
        axes.plot(ends, [row, row], color=mark.color, linewidth=1.2, solid_capstyle="butt")
        if ogr.low < low:
            _draw_head(axes, low, row, mark, left=True)
        if ogr.high > high:
            _draw_head(axes, high, row, mark, left=False)


def _draw_head(axes: Any, end: float, row: int, mark: ConditionMark, *, left: bool) -> None:
    marker = "<" if left else ">"
    axes.plot([end], [row], marker=marker, color=mark.color, markersize=6, clip_on=False)


def _ogr_range(evaluation: Evaluation) -> tuple[float, float]:
    """From 0 to 1 at least, and as far as values and intervals go within reason."""
    found = [
        end
        for one in evaluation.benefits
        if one.subset == "all"
        for end in (one.ogr.value, one.ogr.low, one.ogr.high)
        if math.isfinite(end)
    ]
    low = max(_OGR_RANGE[0], min([0.0, *found]))
    high = min(_OGR_RANGE[1], max([1.0, *found]))
    return low - 0.06, high + 0.06


def _ogr_note(ogr: Estimate) -> str:
    if math.isnan(ogr.value):
        return "undefined"
    return f"{ogr.value:.2f}".replace("-", MINUS)


def _legend(figure: Figure, marks: Sequence[ConditionMark]) -> None:
    """Which difference each mark is."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            marker=mark.marker,
            color=mark.color,
            markersize=mark.size,
            markeredgewidth=2.4 if mark.marker == "|" else 0,
            linestyle="",
            label=f"{mark.label} {MINUS} P-Init",
        )
        for mark in marks
    ]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=len(handles) or 1,
        frameon=False,
        labelcolor=INK,
        fontsize=9.5,
    )
