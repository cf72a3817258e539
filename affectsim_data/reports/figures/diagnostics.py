"""Where observation helps: by emotion, family and challenge, as the paper's Figure 6."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from affectsim_data.evaluation.results import Estimate, Evaluation, GroupMean
from affectsim_data.inspection.figures import INK, style_axes
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports.figures.marks import (
    ConditionMark,
    condition_legend,
    condition_marks,
    draw_chance,
    draw_estimate,
    level_label,
)
from affectsim_data.reports.figures.panels import group_means, group_title
from affectsim_data.schemas import CHALLENGES, FAMILIES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_emotions", "draw_families"]

_PANEL_INCHES = 2.35
_SPREAD = 0.52
"""Share of a level's room over which its conditions stand."""


def draw_emotions(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """Left: recall by emotion and condition; right: its change from P-Init. A row per group."""
    means = group_means(evaluation)
    marks = condition_marks(evaluation.conditions)
    height = 0.8 + _PANEL_INCHES * len(means)
    figure = draw(figsize=(7.2, height), layout="constrained")
    panels = figure.subplots(len(means), 2, squeeze=False, sharex=True, sharey="col")
    for mean, (left, right) in zip(means, panels, strict=True):
        for place, mark in enumerate(marks):
            recall = mean.recall.get(mark.condition, {})
            for level, emotion in enumerate(EMOTIONS):
                spot = level + _shift(place, len(marks))
                draw_estimate(left, _at(recall, emotion), spot, mark, upright=True)
        _draw_gains(right, mean, [mark for mark in marks if mark.condition != "p_init"])
        _finish(left, EMOTIONS, group_title(evaluation, mean), "recall, %")
        _finish(right, EMOTIONS, "", "change from P-Init, points")
    condition_legend(figure, marks, chance=False)
    return figure


def _draw_gains(axes: Any, mean: GroupMean, marks: Sequence[ConditionMark]) -> None:
    """Bars of recall minus that of P-Init."""
    initial = mean.recall.get("p_init", {})
    width = 0.8 / max(1, len(marks))
    for place, mark in enumerate(marks):
        recall = mean.recall.get(mark.condition, {})
        gains = [100 * (_at(recall, one).value - _at(initial, one).value) for one in EMOTIONS]
        spots = np.arange(len(EMOTIONS)) + width * (place - (len(marks) - 1) / 2)
        axes.bar(spots, np.nan_to_num(gains), width=0.9 * width, color=mark.color)
    axes.axhline(0.0, color=INK, linewidth=1.0)


def draw_families(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """Macro-F1 by condition: left the families, right the challenges. A row per group."""
    means = group_means(evaluation)
    marks = condition_marks(evaluation.conditions)
    families = _levels(evaluation, "family", FAMILIES)
    challenges = _levels(evaluation, "challenge", CHALLENGES)
    figure = draw(figsize=(7.2, 0.95 + _PANEL_INCHES * len(means)), layout="constrained")
    panels = figure.subplots(
        len(means),
        2 if challenges else 1,
        squeeze=False,
        sharey=True,
        sharex="col",
        width_ratios=[max(1, len(families)), len(challenges)] if challenges else None,
    )
    for mean, row in zip(means, panels, strict=True):
        for axes, factor, levels in zip(
            row, ("family", "challenge"), (families, challenges), strict=False
        ):
            draw_chance(axes, evaluation, upright=True)
            for level, name in enumerate(levels):
                _draw_level(axes, evaluation, mean, factor, name, level, marks)
            labels = [_counted(evaluation, factor, name) for name in levels]
            title = group_title(evaluation, mean) if axes is row[0] else ""
            _finish(axes, labels, title, "Macro-F1, %" if axes is row[0] else "")
    for axes, factor in zip(panels[-1], ("family", "challenge"), strict=False):
        axes.set_xlabel(factor)
    condition_legend(figure, marks, chance=True)
    return figure


def _draw_level(
    axes: Any,
    evaluation: Evaluation,
    mean: GroupMean,
    factor: str,
    level: str,
    place: int,
    marks: Sequence[ConditionMark],
) -> None:
    for number, mark in enumerate(marks):
        if factor == "family":
            estimate = _at(mean.family_macro_f1.get(level, {}), mark.condition)
        else:
            estimate = _level_mean(evaluation, mean.group, factor, level, mark.condition)
        spot = place + _shift(number, len(marks))
        draw_estimate(axes, estimate, spot, mark, upright=True)


def _level_mean(
    evaluation: Evaluation, group: str, factor: str, level: str, condition: str
) -> Estimate:
    """Unweighted mean over the models of a group; of a single model its own, with interval."""
    mine = {card.model for card in evaluation.models if not group or card.group == group}
    found = [
        one.macro_f1
        for one in evaluation.breakdowns
        if (one.factor, one.level, one.condition) == (factor, level, condition)
        and one.model in mine
        and not math.isnan(one.macro_f1.value)
    ]
    if len(found) == 1:
        return found[0]
    return Estimate(float(np.mean([one.value for one in found])) if found else math.nan)


def _levels(evaluation: Evaluation, factor: str, order: Sequence[str]) -> list[str]:
    """Levels there are, the known ones first."""
    there = {one.level for one in evaluation.breakdowns if one.factor == factor and one.level}
    return [name for name in order if name in there] + sorted(there - set(order))


def _counted(evaluation: Evaluation, factor: str, level: str) -> str:
    """A level with its number of episodes, on lines of its own."""
    count = next(
        one.num_episodes
        for one in evaluation.breakdowns
        if (one.factor, one.level) == (factor, level)
    )
    return f"{level_label(level).replace(' ', chr(10), 1)}\n({count:,})"


def _at(estimates: Any, key: str) -> Estimate:
    return estimates.get(key, Estimate(math.nan))  # type: ignore[no-any-return]  # of Estimates


def _shift(place: int, count: int) -> float:
    return _SPREAD * (place - (count - 1) / 2) / max(1, count - 1)


def _finish(axes: Any, labels: Sequence[str], title: str, y_label: str) -> None:
    axes.set_xticks(range(len(labels)), labels)
    axes.set_xlim(-0.55, len(labels) - 0.45)
    style_axes(axes, grid="y")
    axes.tick_params(axis="x", length=0, labelsize=8.5)
    if y_label:
        axes.set_ylabel(y_label)
    if title:
        axes.set_title(title, fontsize=10, color=INK, loc="left")
