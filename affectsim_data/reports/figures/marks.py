"""How conditions, models and numbers look in every figure of a report."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from affectsim_data.evaluation.results import Estimate, Evaluation, ModelCard
from affectsim_data.inspection.figures import INK
from affectsim_data.reports.tables.texts import DASH, one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = [
    "CHANCE_LABEL",
    "MINUS",
    "ConditionMark",
    "condition_legend",
    "condition_marks",
    "draw_chance",
    "draw_estimate",
    "has_interval",
    "level_label",
    "model_labels",
    "points_text",
    "short_name",
]

CHANCE_LABEL = "chance"
MINUS = "\N{MINUS SIGN}"
_MAX_NAME = 30
"""Characters of a model's name beside an axis."""


@dataclasses.dataclass(frozen=True)
class ConditionMark:
    """A condition as figures show it: never by colour alone."""

    condition: str
    label: str
    color: str
    marker: str
    size: float
    """Points."""


_KNOWN = (
    ConditionMark("p_init", "P-Init", "#8c8c8c", "o", 6.5),
    ConditionMark("p_mon", "P-Mon", "#009e73", "s", 5.5),
    ConditionMark("a_obs", "A-Obs", "#0072b2", "D", 5.5),
    ConditionMark("p_ref", "P-Ref", "#d55e00", "|", 11.0),
)
"""In the order they are drawn; colours after Okabe and Ito, shapes of the paper's Figure 5."""
_OTHERS = (("#cc79a7", "^"), ("#e69f00", "v"), ("#56b4e9", "P"), ("#f0e442", "X"))


def condition_marks(conditions: Iterable[str]) -> tuple[ConditionMark, ...]:
    """Marks of conditions: the paper's four in one order, then any others by name."""
    asked = set(conditions)
    known = [mark for mark in _KNOWN if mark.condition in asked]
    others = sorted(asked - {mark.condition for mark in _KNOWN})
    return (
        *known,
        *(
            ConditionMark(name, short_name(name, 20), *_OTHERS[place % len(_OTHERS)], 6.0)
            for place, name in enumerate(others)
        ),
    )


def short_name(name: str, longest: int = _MAX_NAME) -> str:
    """A name on one line; of a long one without its organisation, if need be without its middle.

    Examples:
        >>> short_name("organisation/model-72b", 16)
        'model-72b'
        >>> short_name("organisation/family-of-models-72b-instruct", 24)
        'family-of-mo…2b-instruct'
    """
    line = one_line(name) or "(no name)"
    if len(line) > longest:
        line = line.rpartition("/")[2] or line
    if len(line) <= longest:
        return line
    front = longest // 2
    return f"{line[:front]}…{line[front + 1 - longest :]}"


def model_labels(models: Sequence[ModelCard]) -> dict[str, str]:
    """What stands beside the rows of models: short, and no two alike."""
    labels: dict[str, str] = {}
    for place, card in enumerate(models, start=1):
        size = "" if card.parameters in card.model else f" {short_name(card.parameters, 8)}"
        label = short_name(card.model) + size
        labels[card.model] = f"{label} #{place}" if label in labels.values() else label
    return labels


def level_label(level: str) -> str:
    """A level of a factor as words: `far_visible` is far visible."""
    return short_name(level.replace("_", " "), 24)


def has_interval(estimate: Estimate) -> bool:
    """Whether there is an interval at all; its ends may be infinite."""
    return not (math.isnan(estimate.low) or math.isnan(estimate.high))


def points_text(estimate: Estimate) -> str:
    """A difference of scores in percentage points with its interval.

    Examples:
        >>> points_text(Estimate(0.138, 0.091, 0.184))
        '+13.8 [+9.1, +18.4]'
    """
    if math.isnan(estimate.value):
        return DASH
    text = f"{100 * estimate.value:+.1f}"
    if has_interval(estimate):
        text += f" [{100 * estimate.low:+.1f}, {100 * estimate.high:+.1f}]"
    return text.replace("-", MINUS).replace("inf", "∞")


def draw_estimate(
    axes: Any, estimate: Estimate, place: float, mark: ConditionMark, *, upright: bool = False
) -> None:
    """A mark with a thin line for its interval, in per cent; nothing where there is no value."""
    if not math.isfinite(estimate.value):
        return
    ends = [100 * estimate.low, 100 * estimate.high]
    if all(map(math.isfinite, ends)):
        line = ([place, place], ends) if upright else (ends, [place, place])
        axes.plot(*line, color=mark.color, linewidth=1.1, alpha=0.75, solid_capstyle="butt")
    spot = (place, 100 * estimate.value) if upright else (100 * estimate.value, place)
    marker = "_" if upright and mark.marker == "|" else mark.marker
    axes.plot(
        *([one] for one in spot),
        marker=marker,
        color=mark.color,
        markersize=mark.size,
        markeredgewidth=2.4 if marker in "|_" else 0,
        linestyle="",
        zorder=3,
    )


def condition_legend(figure: Figure, marks: Sequence[ConditionMark], *, chance: bool) -> None:
    """Says which mark is which condition, above the figure."""
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
            label=mark.label,
        )
        for mark in marks
    ]
    if chance:
        handles.append(Line2D([], [], color=INK, linestyle=(0, (4, 3)), label=CHANCE_LABEL))
    figure.legend(
        handles=handles,
        loc="outside upper center",
        ncols=min(6, len(handles)),
        frameon=False,
        labelcolor=INK,
        fontsize=9.5,
    )


def draw_chance(axes: Any, evaluation: Evaluation, *, upright: bool = False) -> None:
    """A dashed line at what uniform guessing scores."""
    line = axes.axhline if upright else axes.axvline
    line(100 * evaluation.chance, color=INK, linestyle=(0, (4, 3)), linewidth=1.1, zorder=1)
