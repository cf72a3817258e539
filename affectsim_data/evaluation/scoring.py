"""Scores of models under conditions, and what observation did for them."""

from __future__ import annotations

import math

import numpy as np

from affectsim_data.evaluation.confusion import confusion_codes, macro_f1_scores
from affectsim_data.evaluation.drawing import Bounds
from affectsim_data.evaluation.results import Benefit, ConditionScore
from affectsim_data.evaluation.scored import NUM_COLUMNS, OUTCOMES, RINGS_M, outcome_code
from affectsim_data.evaluation.subsets import SubsetDraws
from affectsim_data.motions import EMOTIONS

__all__ = ["benefits_of", "recall_bounds", "scores_of"]

_NAMED = np.array([1.0] * len(EMOTIONS) + [0.0])
"""Leaves the last column out of a confusion: answers that name no emotion."""


def scores_of(draws: SubsetDraws) -> list[ConditionScore]:
    """Scores of every model under every condition it was run under."""
    macro_f1 = draws.drawing.score_bounds(draws.macro_f1, draws.support)
    accuracy = draws.drawing.share_bounds(draws.accuracy, draws.support)
    recall = recall_bounds(draws)
    table = draws.table
    return [
        _score(draws, (model, condition), macro_f1, accuracy, recall)
        for model in range(len(table.models))
        for condition in range(len(table.conditions))
        if table.was_run[model, condition]
    ]


def recall_bounds(draws: SubsetDraws) -> list[Bounds]:
    """Recall of each emotion, `(num_models, num_conditions)`, by the clusters that have it."""
    return [
        draws.drawing.share_bounds(
            draws.recall[..., code],
            draws.drawing.support(draws.where & (draws.table.truth == code)),
        )
        for code in range(len(EMOTIONS))
    ]


def _score(
    draws: SubsetDraws,
    place: tuple[int, int],
    macro_f1: Bounds,
    accuracy: Bounds,
    recall: list[Bounds],
) -> ConditionScore:
    table = draws.table
    answers = table.answers[place][draws.where]
    cells = confusion_codes(table.truth[draws.where], answers)
    confusion = np.bincount(cells, minlength=len(EMOTIONS) * NUM_COLUMNS)
    confusion = confusion.reshape(len(EMOTIONS), NUM_COLUMNS)
    latencies = table.latency_ms[place][draws.where]
    latencies = latencies[~np.isnan(latencies)]
    return ConditionScore(
        model=table.models[place[0]],
        condition=table.conditions[place[1]],
        subset=draws.subset,
        num_episodes=len(answers),
        macro_f1=macro_f1.at(*place),
        accuracy=accuracy.at(*place),
        macro_f1_valid=float(macro_f1_scores(confusion * _NAMED)),
        num_valid=int((answers >= 0).sum()),
        outcomes={one: int((answers == outcome_code(one)).sum()) for one in OUTCOMES},
        recall={emotion: one.at(*place) for emotion, one in zip(EMOTIONS, recall, strict=True)},
        confusion=tuple(tuple(row) for row in confusion.tolist()),
        median_latency_ms=float(np.median(latencies)) if len(latencies) else math.nan,
    )


def benefits_of(draws: SubsetDraws) -> list[Benefit]:
    """What observation did for every model."""
    drawing, support = draws.drawing, draws.support
    gain, gap = draws.difference("a_obs"), draws.difference("p_ref")
    gains, gaps = drawing.bounds(gain, support), drawing.bounds(gap, support)
    monitor_gaps = drawing.bounds(draws.difference("p_mon"), support)
    ogr = drawing.ratio_bounds(gain, gap, support)
    recovery = drawing.share_bounds(draws.recovery_rate, support)
    e_spl = drawing.share_bounds(draws.e_spl, support)
    return [
        Benefit(
            model=name,
            subset=draws.subset,
            gain=gains.at(model),
            gap=gaps.at(model),
            monitor_gap=monitor_gaps.at(model),
            ogr=ogr.at(model),
            recovery_rate=recovery.at(model),
            num_initial_errors=int(draws.num_initial_errors[model]),
            e_spl={ring: e_spl.at(place, model) for place, ring in enumerate(RINGS_M)},
        )
        for model, name in enumerate(draws.table.models)
    ]
