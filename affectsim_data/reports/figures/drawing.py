"""All figures of a report as files, and the words beneath them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from typing import TYPE_CHECKING

from affectsim_data.evaluation.results import Evaluation
from affectsim_data.inspection.figures import figure_class, neutral_settings, png_bytes, svg_bytes
from affectsim_data.reports.figures.acquisition import draw_acquisition
from affectsim_data.reports.figures.answers import draw_confusions, draw_outcomes
from affectsim_data.reports.figures.diagnostics import draw_emotions, draw_families
from affectsim_data.reports.figures.models import draw_models, shown_conditions, shown_difference
from affectsim_data.reports.figures.recovery import draw_recovery
from affectsim_data.reports.tables.texts import condition_title

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FigureText", "draw_figures", "figure_texts"]


@dataclasses.dataclass(frozen=True)
class FigureText:
    """What stands beside a figure; nothing of it comes from data."""

    title: str
    caption: str
    """How to read it."""


def draw_figures(evaluation: Evaluation) -> dict[str, bytes]:
    """Files by name, a PNG and an SVG of each figure; the same results give the same bytes.

    Which there are depends on the results: those of A-Obs need A-Obs, `acquisition` trajectories.

    Raises:
        ModuleNotFoundError: matplotlib is not installed.
    """
    draw = figure_class("the figures of a report")
    files: dict[str, bytes] = {}
    with neutral_settings():
        for name in figure_texts(evaluation):
            figure = _DRAWN[name](evaluation, draw)
            files[f"{name}.png"] = png_bytes(figure)
            files[f"{name}.svg"] = svg_bytes(figure)
    return files


def figure_texts(evaluation: Evaluation) -> dict[str, FigureText]:
    """Title and caption of each figure these results have, in the order of a report."""
    interval = f"{100 * evaluation.settings.confidence:g} % intervals"
    texts = {"models": FigureText("Macro-F1 of every model", _models_caption(evaluation, interval))}
    if any(one.subset == "new_observation" for one in evaluation.scores):
        texts["models_new_observation"] = FigureText(
            "Macro-F1 where a new observation was collected",
            "The same over the episodes in which the policy collected a clip after its handoff; in "
            "the others A-Obs is the clip of P-Init. Which these are is an outcome of the policy, "
            f"not a part of the benchmark. {_models_caption(evaluation, interval)}",
        )
    if "p_init" in evaluation.conditions and len(evaluation.conditions) > 1:
        texts["recovery"] = FigureText(*_recovery_words(evaluation, interval))
    texts["emotions"] = FigureText(
        "Recall by emotion",
        f"Left: share of the episodes of each emotion that are answered rightly, with {interval}. "
        "Right: the change from P-Init. Unweighted means over the models of a group.",
    )
    if any(one.factor == "family" for one in evaluation.breakdowns):
        texts["families"] = FigureText(
            "Macro-F1 by family and challenge",
            f"Thin lines are {interval}; means over several models by challenge have none. In "
            "brackets the number of episodes; small families have wide intervals. The dashed line "
            "is chance over all episodes.",
        )
    texts["confusions"] = FigureText(
        "What is taken for what",
        "A row per acted emotion, its answers in per cent; right answers on the diagonal, bold. "
        f"None: the answer named no emotion, or several.{_mean_words(evaluation)}",
    )
    texts["outcomes"] = FigureText(
        "Answers that name an emotion, and others",
        "Whatever names no emotion counts as wrong: refusals, several emotions at once, empty and "
        "unrelated answers, and missing ones where these were allowed.",
    )
    if evaluation.acquisition:
        texts["acquisition"] = FigureText(
            "How the policy moved",
            f"Over all episodes, by family and by challenge, with {interval}; in brackets the "
            "number of episodes.",
        )
    return texts


def _models_caption(evaluation: Evaluation, interval: str) -> str:
    shown = shown_conditions(evaluation)
    words = {"p_init": "grey circles", "p_mon": "green squares", "a_obs": "blue diamonds"}
    words |= {"p_ref": "orange ticks"}
    marks = [f"{condition_title(name)}: {words[name]}" for name in shown if name in words]
    sides = {
        "gain": " At the right A-Obs minus P-Init in points, bold where its interval excludes 0.",
        "gap": " At the right P-Ref minus P-Init in points, bold where its interval excludes 0.",
        "": "",
    }
    return _sentence(
        f"{'; '.join(marks)}{'; ' if marks else ''}thin lines are {interval}, the dashed line is "
        f"chance, {100 * evaluation.chance:.1f} %.{sides[shown_difference(evaluation)]}"
    )


def _sentence(text: str) -> str:
    return text[:1].upper() + text[1:]


def _recovery_words(evaluation: Evaluation, interval: str) -> tuple[str, str]:
    if {"a_obs", "p_ref"} <= set(evaluation.conditions):
        return (
            "The gap, the gain, and the share recovered",
            f"Left: changes of Macro-F1 from P-Init with {interval}. Right: observation gap "
            "recovery, gain / gap: 0 is no gain, 1 reaches the reference view. Undefined where "
            "P-Ref is not above P-Init; a line from end to end where the gap may be 0, so that "
            "the ratio can be anything. Arrow heads: beyond the axis. Bold where the interval "
            "excludes 0.",
        )
    return (
        "The observation gap",
        f"Changes of Macro-F1 from P-Init with {interval}: how much another view of the same "
        "moment is worth. Bold where the interval of P-Ref minus P-Init excludes 0.",
    )


def _mean_words(evaluation: Evaluation) -> str:
    return " Unweighted means over all models." if len(evaluation.models) > 1 else ""


_DRAWN: dict[str, Callable[[Evaluation, type[Figure]], Figure]] = {
    "models": lambda evaluation, draw: draw_models(evaluation, draw, "all"),
    "models_new_observation": lambda evaluation, draw: draw_models(
        evaluation, draw, "new_observation"
    ),
    "recovery": draw_recovery,
    "emotions": draw_emotions,
    "families": draw_families,
    "confusions": draw_confusions,
    "outcomes": draw_outcomes,
    "acquisition": draw_acquisition,
}
