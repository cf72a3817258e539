"""Tests of every condition against p_init, by the same episodes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.bootstrap import effective_clusters
from affectsim_data.evaluation.drawing import Drawing
from affectsim_data.evaluation.power import mean_standard_error, minimum_detectable_effect
from affectsim_data.evaluation.results import PairedTest
from affectsim_data.evaluation.scored import ScoredTable
from affectsim_data.evaluation.significance import cluster_permutation, holm, mcnemar_exact
from affectsim_data.poses import FloatArray

__all__ = ["paired_tests"]


def paired_tests(
    table: ScoredTable, drawing: Drawing, *, num_permutations: int, seed: int
) -> list[PairedTest]:
    """A test for every model and condition run beside p_init, adjusted over models."""
    initial = table.condition_index("p_init")
    if initial is None:
        return []
    found = [
        _tests_of(table, drawing, initial, place, num_permutations=num_permutations, seed=seed)
        for place in range(len(table.conditions))
        if place != initial and (table.was_run[:, place] & table.was_run[:, initial]).any()
    ]
    return [test for tests in found for test in tests]


def _tests_of(
    table: ScoredTable,
    drawing: Drawing,
    initial: int,
    place: int,
    *,
    num_permutations: int,
    seed: int,
) -> list[PairedTest]:
    """Tests of one condition, for the models that were run under both."""
    models = np.flatnonzero(table.was_run[:, place] & table.was_run[:, initial])
    pairs = ~table.same_frames[place]
    before = (table.answers[models, initial] == table.truth)[:, pairs]
    after = (table.answers[models, place] == table.truth)[:, pairs]
    only_initial, only_condition = (before & ~after).sum(axis=1), (after & ~before).sum(axis=1)
    mcnemar = mcnemar_exact(only_initial, only_condition)
    differences = after.astype(np.float64) - before
    clusters = np.unique(drawing.clusters[pairs], return_inverse=True)[1]
    if pairs.any():
        permuted = cluster_permutation(
            differences, clusters, num_permutations=num_permutations, seed=seed
        )
    else:
        permuted = np.ones(len(models))
    detectable = _detectable(differences, clusters)
    adjusted = holm(mcnemar), holm(permuted)
    return [
        PairedTest(
            model=table.models[model],
            condition=table.conditions[place],
            num_pairs=int(pairs.sum()),
            num_tied=int((~pairs).sum()),
            only_initial=int(only_initial[row]),
            only_condition=int(only_condition[row]),
            mcnemar_p=float(mcnemar[row]),
            permutation_p=float(permuted[row]),
            mcnemar_holm_p=float(adjusted[0][row]),
            permutation_holm_p=float(adjusted[1][row]),
            detectable=float(detectable[row]),
        )
        for row, model in enumerate(models)
    ]


def _detectable(differences: FloatArray, clusters: NDArray[np.int64]) -> FloatArray:
    """Minimum detectable difference in accuracy among these pairs, `(num_models,)`."""
    if len(np.unique(clusters)) < 2:
        return np.full(len(differences), math.nan)
    degrees = max(effective_clusters(clusters) - 1, 1.0)
    return minimum_detectable_effect(mean_standard_error(differences, clusters), degrees=degrees)
