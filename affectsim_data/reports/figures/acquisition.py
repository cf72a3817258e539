"""How a policy came to its observations: handoff, way and budget, over all and by challenge."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.results import AcquisitionSummary, Estimate, Evaluation
from affectsim_data.inspection.figures import INK, style_axes
from affectsim_data.reports.figures.marks import level_label, short_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["draw_acquisition"]

_PANELS = (
    ("stable_handoff", "stable handoff,\n% of episodes", 100.0),
    ("mean_path_m", "mean path,\nm", 1.0),
    ("budget_exhausted", "budget exhausted,\n% of episodes", 100.0),
    ("clipped", "clipped moves,\n% of attempts", 100.0),
)
"""Field, axis, factor to its unit."""
_COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7")
_MARKERS = "Dos^"
_FACTORS = ("", "family", "challenge")


def draw_acquisition(evaluation: Evaluation, draw: type[Figure]) -> Figure:
    """Four panels side by side with the same rows: all episodes, families, challenges."""
    rows = [one for factor in _FACTORS for one in evaluation.acquisition if one.factor == factor]
    keys = list(dict.fromkeys((one.factor, one.level) for one in rows if one.num_episodes))
    policies = list(dict.fromkeys(one.policy for one in rows))
    figure = draw(figsize=(7.2, 1.1 + 0.34 * len(keys)), layout="constrained")
    panels = figure.subplots(1, len(_PANELS), sharey=True)
    for axes, (field, label, unit) in zip(panels, _PANELS, strict=True):
        for one in rows:
            if one.num_episodes:
                place = policies.index(one.policy)
                shift = 0.2 * (place - (len(policies) - 1) / 2)
                row = keys.index((one.factor, one.level)) + shift
                _draw(axes, getattr(one, field), row, place, unit)
        axes.set_xlabel(label)
        axes.set_xlim(0.0, max(1.08 * axes.get_xlim()[1], 1.0))
        _finish(axes, keys, rows)
        axes.xaxis.label.set(fontsize=9)
    if len(policies) > 1:
        _legend(figure, policies)
    return figure


def _draw(axes: Any, estimate: Estimate, row: float, place: int, unit: float) -> None:
    color, marker = _COLORS[place % 4], _MARKERS[place % 4]
    ends = [unit * estimate.low, unit * estimate.high]
    if all(map(math.isfinite, ends)):
        axes.plot(ends, [row, row], color=color, linewidth=1.2, solid_capstyle="butt")
    axes.plot([unit * estimate.value], [row], marker, color=color, markersize=5.5)


def _finish(axes: Any, keys: list[tuple[str, str]], rows: list[AcquisitionSummary]) -> None:
    counts = {(one.factor, one.level): one.num_episodes for one in rows}
    labels = [
        f"{level_label(level) if factor else 'all episodes'} ({counts[factor, level]:,})"
        for factor, level in keys
    ]
    axes.set_yticks(range(len(keys)), labels)
    axes.set_ylim(len(keys) - 0.5, -0.5)
    style_axes(axes, grid="x")
    axes.tick_params(axis="y", length=0)
    axes.spines["left"].set_visible(False)
    for row in range(1, len(keys)):
        if keys[row][0] != keys[row - 1][0]:
            axes.axhline(row - 0.5, color=INK, linewidth=0.8, alpha=0.6)


def _legend(figure: Figure, policies: list[str]) -> None:
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], marker=_MARKERS[n % 4], color=_COLORS[n % 4], label=short_name(name))
        for n, name in enumerate(policies)
    ]
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=3,
        frameon=False,
        labelcolor=INK,
        fontsize=9,
    )
