"""Unweighted means over models, of all and of each group."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.drawing import Support
from affectsim_data.evaluation.results import Estimate, GroupMean, ModelCard
from affectsim_data.evaluation.scored import RINGS_M
from affectsim_data.evaluation.subsets import SubsetDraws
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["group_means"]


def group_means(draws: SubsetDraws, cards: Sequence[ModelCard]) -> list[GroupMean]:
    """Means over all models, and over those of each group, in order of first appearance.

    Args:
        draws: Metrics of the models, each of which is drawn along with the others.
        cards: One for each model of the table, in its order.
    """
    groups = list(dict.fromkeys(card.group for card in cards if card.group))
    everybody = np.ones(len(cards), bool)
    chosen = [(group, np.array([card.group == group for card in cards])) for group in groups]
    return [_mean(draws, group, models) for group, models in [("", everybody), *chosen]]


def _mean(draws: SubsetDraws, group: str, models: NDArray[np.bool_]) -> GroupMean:
    table = draws.table
    conditions = [
        (place, name)
        for place, name in enumerate(table.conditions)
        if (table.was_run[:, place] & models).any()
    ]
    gain, gap = draws.difference("a_obs"), draws.difference("p_ref")
    ogr_of_means, mean_ogr, num_ogr = _ogr(draws, gain, gap, models)
    return GroupMean(
        group=group,
        subset=draws.subset,
        num_models=int(models.sum()),
        macro_f1={
            name: _mean_score(draws, draws.macro_f1[:, :, place], models)
            for place, name in conditions
        },
        recall={name: _recall(draws, place, models) for place, name in conditions},
        family_macro_f1={
            family: {name: _family_mean(draws, family, place, models) for place, name in conditions}
            for family in draws.family_macro_f1
        },
        gain=_mean_difference(draws, gain, models),
        gap=_mean_difference(draws, gap, models),
        ogr_of_means=ogr_of_means,
        mean_ogr=mean_ogr,
        num_ogr=num_ogr,
        recovery_rate=_mean_share(draws, draws.recovery_rate, models),
        e_spl={
            ring: _mean_share(draws, draws.e_spl[:, place], models)
            for place, ring in enumerate(RINGS_M)
        },
        monitor_gap=_mean_difference(draws, draws.difference("p_mon"), models),
    )


def _recall(draws: SubsetDraws, place: int, models: NDArray[np.bool_]) -> dict[str, Estimate]:
    return {
        emotion: _mean_share(
            draws,
            draws.recall[:, :, place, code],
            models,
            draws.drawing.support(draws.where & (draws.table.truth == code)),
        )
        for code, emotion in enumerate(EMOTIONS)
    }


def _family_mean(
    draws: SubsetDraws, family: str, place: int, models: NDArray[np.bool_]
) -> Estimate:
    inside = draws.where & (draws.table.factors["family"] == family)
    rows = draws.family_macro_f1[family][:, :, place]
    return _mean_score(draws, rows, models, draws.drawing.support(inside))


def _mean_score(
    draws: SubsetDraws, rows: FloatArray, models: NDArray[np.bool_], support: Support | None = None
) -> Estimate:
    """Mean Macro-F1 of the models that have it, from rows `(1 + R, num_models)`."""
    return draws.drawing.score_bounds(_over_models(rows, models), support or draws.support).at()


def _mean_difference(draws: SubsetDraws, rows: FloatArray, models: NDArray[np.bool_]) -> Estimate:
    """The same for gains and gaps."""
    return draws.drawing.bounds(_over_models(rows, models), draws.support).at()


def _mean_share(
    draws: SubsetDraws, rows: FloatArray, models: NDArray[np.bool_], support: Support | None = None
) -> Estimate:
    """The same for shares, whose intervals stay in [0, 1]."""
    return draws.drawing.share_bounds(_over_models(rows, models), support or draws.support).at()


def _over_models(rows: FloatArray, models: NDArray[np.bool_]) -> FloatArray:
    """Mean over the same models in every row: those that have the number in the sample."""
    counted = models & ~np.isnan(rows[0])
    if not counted.any():
        return np.full(len(rows), math.nan)
    mean: FloatArray = rows[:, counted].mean(axis=1)
    return mean


def _ogr(
    draws: SubsetDraws, gain: FloatArray, gap: FloatArray, models: NDArray[np.bool_]
) -> tuple[Estimate, Estimate, int]:
    """Gap recovery of the mean scores, mean of the models' own, and how many have one."""
    both = models & ~np.isnan(gain[0]) & ~np.isnan(gap[0])
    top, bottom = _over_models(gain, both), _over_models(gap, both)
    of_means = draws.drawing.ratio_bounds(top, bottom, draws.support).at()
    own = both & (np.nan_to_num(gap[0]) > 0)
    if not own.any():
        return of_means, Estimate(math.nan), 0
    ratios = np.divide(gain, gap, out=np.full(gain.shape, math.nan), where=gap != 0)
    mean = _over_models(ratios, own)
    single = draws.drawing.ratio_bounds(gain[:, own], gap[:, own], draws.support)
    if np.isinf(single.low).any() or np.isinf(single.high).any():
        # One gap that may be zero, and the mean of the ratios may be anything.
        return of_means, Estimate(float(mean[0]), -math.inf, math.inf), int(own.sum())
    return of_means, draws.drawing.bounds(mean, draws.support).at(), int(own.sum())
