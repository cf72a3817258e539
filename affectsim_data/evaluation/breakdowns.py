"""Results within the levels of a factor, and how the policy behaved there."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.drawing import Drawing
from affectsim_data.evaluation.recognition import recognition_in
from affectsim_data.evaluation.results import AcquisitionSummary, Breakdown, Estimate, RingCount
from affectsim_data.evaluation.scored import RINGS_M, Acquisitions, ScoredTable
from affectsim_data.evaluation.subsets import levels_of
from affectsim_data.poses import FloatArray

__all__ = ["FACTORS", "acquisition_summaries", "breakdowns_of", "ring_counts"]

FACTORS = ("family", "challenge", "action", "emotion", "scene_id")


def breakdowns_of(table: ScoredTable, drawing: Drawing) -> list[Breakdown]:
    """Scores of every model under every condition, within every level of every factor."""
    everywhere = np.ones(table.num_episodes, bool)
    return [
        one
        for factor in FACTORS
        for level, where in levels_of(table, factor, everywhere)
        for one in _within(table, drawing, factor, level, where)
    ]


def _within(
    table: ScoredTable, drawing: Drawing, factor: str, level: str, where: NDArray[np.bool_]
) -> list[Breakdown]:
    found = recognition_in(table, drawing, where)
    support = drawing.support(where)
    accuracy = drawing.share_bounds(found.accuracy(), support)
    # Within one emotion the share of right answers is its recall; F1 would know no false alarms.
    macro_f1 = accuracy
    if factor != "emotion":
        macro_f1 = drawing.score_bounds(found.macro_f1(among_present=True), support)
    num_episodes, num_clusters = int(where.sum()), drawing.num_clusters_of(where)
    return [
        Breakdown(
            factor=factor,
            level=level,
            model=table.models[model],
            condition=table.conditions[condition],
            num_episodes=num_episodes,
            num_clusters=num_clusters,
            macro_f1=macro_f1.at(model, condition),
            accuracy=accuracy.at(model, condition),
        )
        for model, condition in np.argwhere(table.was_run)
    ]


def acquisition_summaries(table: ScoredTable, drawing: Drawing) -> list[AcquisitionSummary]:
    """How the policy behaved over all episodes, and in every level of every factor."""
    acquired = table.acquisitions
    if acquired is None:
        return []
    everywhere = np.ones(table.num_episodes, bool)
    parts = [("", "", everywhere)]
    parts += [
        (factor, level, where)
        for factor in FACTORS
        for level, where in levels_of(table, factor, everywhere)
    ]
    return [_summary(acquired, drawing, *part) for part in parts]


def _summary(
    acquired: Acquisitions, drawing: Drawing, factor: str, level: str, where: NDArray[np.bool_]
) -> AcquisitionSummary:
    columns = np.stack(
        [
            np.ones(len(where)),
            acquired.handed_off,
            acquired.path_length_m,
            acquired.path_before_handoff_m,
            acquired.budget_exhausted,
            acquired.num_clipped,
            acquired.num_translations,
        ]
    )
    sums = drawing.sums(np.where(where, columns, 0.0))
    count, handed, path, before, exhausted, clipped, moves = sums.T
    support = drawing.support(where)

    def share(top: FloatArray, bottom: FloatArray) -> Estimate:
        return drawing.share_bounds(_ratio(top, bottom), support).at()

    return AcquisitionSummary(
        policy=acquired.policy,
        factor=factor,
        level=level,
        num_episodes=int(where.sum()),
        stable_handoff=share(handed, count),
        mean_path_m=drawing.bounds(_ratio(path, count), support, within=(0.0, math.inf)).at(),
        path_before_handoff=share(before, path),
        budget_exhausted=share(exhausted, count),
        clipped=share(clipped, moves),
        new_observations=int((acquired.acquired & where).sum()),
    )


def _ratio(top: FloatArray, bottom: FloatArray) -> FloatArray:
    ratio: FloatArray = np.divide(top, bottom, out=np.full(top.shape, math.nan), where=bottom > 0)
    return ratio


def ring_counts(table: ScoredTable) -> list[RingCount]:
    """Episodes that E-SPL at each distance is over, and those it leaves out."""
    valid = ~np.isnan(table.d_star_m)
    return [
        RingCount(
            distance_m=ring,
            num_valid=int(valid[place].sum()),
            num_empty=int((~valid[place] & table.ring_empty[place]).sum()),
            num_unreachable=int((~valid[place] & ~table.ring_empty[place]).sum()),
        )
        for place, ring in enumerate(RINGS_M)
    ]
