"""All metrics of a subset of episodes, in the sample and in every draw of its clusters."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.drawing import Drawing, Support
from affectsim_data.evaluation.metrics import path_efficiency
from affectsim_data.evaluation.recognition import recognition_in
from affectsim_data.evaluation.results import Subset
from affectsim_data.evaluation.scored import RINGS_M, ScoredTable
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray
from affectsim_data.schemas import CHALLENGES, FAMILIES

__all__ = ["SubsetDraws", "levels_of"]

_ORDER: dict[str, tuple[str, ...]] = {
    "family": FAMILIES,
    "challenge": CHALLENGES,
    "emotion": EMOTIONS,
}


@dataclasses.dataclass(frozen=True)
class SubsetDraws:
    """First axis of arrays as in `Drawing`, R draws; NaN where a model was not run."""

    table: ScoredTable
    drawing: Drawing
    subset: Subset
    where: NDArray[np.bool_]
    """Episodes of the subset, `(num_episodes,)`."""
    support: Support
    """What stands behind its numbers."""
    macro_f1: FloatArray
    """`(1 + R, num_models, num_conditions)`."""
    accuracy: FloatArray
    """`(1 + R, num_models, num_conditions)`."""
    recall: FloatArray
    """`(1 + R, num_models, num_conditions, 5)`."""
    family_macro_f1: Mapping[str, FloatArray]
    """Within each family, over the emotions there are, `(1 + R, num_models, num_conditions)`."""
    recovery_rate: FloatArray
    """`(1 + R, num_models)`."""
    num_initial_errors: NDArray[np.int64]
    """`(num_models,)`; 0 where p_init was not run."""
    e_spl: FloatArray
    """`(1 + R, len(RINGS_M), num_models)`; NaN without trajectories."""

    @classmethod
    def of(
        cls, table: ScoredTable, drawing: Drawing, subset: Subset, where: NDArray[np.bool_]
    ) -> SubsetDraws:
        """Everything about the episodes of `where`, of which there must be one at least."""
        found = recognition_in(table, drawing, where)
        families = {
            family: recognition_in(table, drawing, inside).macro_f1(among_present=True)
            for family, inside in levels_of(table, "family", where)
        }
        rates, num_errors = _recovery(table, drawing, where)
        return cls(
            table=table,
            drawing=drawing,
            subset=subset,
            where=where,
            support=drawing.support(where),
            macro_f1=found.macro_f1(),
            accuracy=found.accuracy(),
            recall=found.recall(),
            family_macro_f1=families,
            recovery_rate=rates,
            num_initial_errors=num_errors,
            e_spl=_e_spl(table, drawing, where),
        )

    def difference(self, condition: str) -> FloatArray:
        """Macro-F1 under a condition minus that under p_init, `(1 + R, num_models)`."""
        one, other = self.table.condition_index(condition), self.table.condition_index("p_init")
        if one is None or other is None:
            return np.full(self.macro_f1.shape[:2], math.nan)
        gain: FloatArray = self.macro_f1[:, :, one] - self.macro_f1[:, :, other]
        return gain


def levels_of(
    table: ScoredTable, factor: str, where: NDArray[np.bool_]
) -> list[tuple[str, NDArray[np.bool_]]]:
    """Levels of a factor and their episodes, in the usual order, else by name; none is empty."""
    values = table.factors[factor]
    found = [str(level) for level in np.unique(values[where]) if level]
    usual = _ORDER.get(factor, ())
    found.sort(key=lambda level: (usual.index(level) if level in usual else len(usual), level))
    return [(level, where & (values == level)) for level in found]


def _right(table: ScoredTable, condition: str) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Right answers `(num_models, num_episodes)`, and which models were run `(num_models,)`."""
    place = table.condition_index(condition)
    if place is None:
        nothing = np.zeros((len(table.models), table.num_episodes), bool)
        return nothing, np.zeros(len(table.models), bool)
    return table.answers[:, place] == table.truth, table.was_run[:, place]


def _recovery(
    table: ScoredTable, drawing: Drawing, where: NDArray[np.bool_]
) -> tuple[FloatArray, NDArray[np.int64]]:
    """Share of initial errors that a_obs mends, and the number of initial errors."""
    initially, run_initially = _right(table, "p_init")
    finally_, run_finally = _right(table, "a_obs")
    wrong = ~initially & where & run_initially[:, None]
    errors, mended = drawing.sums(np.stack([wrong, wrong & finally_])).transpose(1, 0, 2)
    both = (run_initially & run_finally) & (errors > 0)
    rates = np.divide(mended, errors, out=np.full(errors.shape, math.nan), where=both)
    return rates, wrong.sum(axis=-1)


def _e_spl(table: ScoredTable, drawing: Drawing, where: NDArray[np.bool_]) -> FloatArray:
    right, run = _right(table, "a_obs")
    shape = (len(drawing.weights), len(RINGS_M), len(table.models))
    if table.acquisitions is None or not run.any():
        return np.full(shape, math.nan)
    efficiency = path_efficiency(table.acquisitions.path_length_m, table.d_star_m)
    valid = where & ~np.isnan(efficiency)
    earned = np.where(valid, np.nan_to_num(efficiency), 0.0)
    counts = drawing.sums(valid)[..., None]
    there = np.broadcast_to(counts > 0, shape) & run
    totals = drawing.sums(earned[:, None] * right)
    scores: FloatArray = np.divide(totals, counts, out=np.full(shape, math.nan), where=there)
    return scores
