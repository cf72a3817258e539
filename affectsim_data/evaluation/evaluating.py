"""From a table of answers to all results, with their statistics."""

from __future__ import annotations

from collections.abc import Mapping
from typing import get_args

import numpy as np

from affectsim_data.evaluation.bootstrap import INTERVAL_NAME
from affectsim_data.evaluation.breakdowns import acquisition_summaries, breakdowns_of, ring_counts
from affectsim_data.evaluation.drawing import ClusterLevel, Drawing
from affectsim_data.evaluation.means import group_means
from affectsim_data.evaluation.notes import notes_on
from affectsim_data.evaluation.pairing import paired_tests
from affectsim_data.evaluation.references import chance_macro_f1, reference_rows
from affectsim_data.evaluation.results import Evaluation, ModelCard, Settings
from affectsim_data.evaluation.scored import ScoredTable
from affectsim_data.evaluation.scoring import benefits_of, scores_of
from affectsim_data.evaluation.subsets import SubsetDraws

__all__ = ["evaluate"]

_MIN_DRAWS = 100
"""Fewer draws or swaps say nothing about a tail of 2.5 %."""


def evaluate(
    table: ScoredTable,
    *,
    cluster: ClusterLevel = "performance",
    num_resamples: int = 2000,
    num_permutations: int = 2000,
    confidence: float = 0.95,
    seed: int = 0,
    model_cards: Mapping[str, ModelCard] | None = None,
) -> Evaluation:
    """All results of a table, with intervals and tests; equal for equal arguments, to the bit.

    Args:
        table: Answers beside the truth.
        cluster: What is drawn as a whole. Performances are, unless performers are asked for, of
            which a split often has too few.
        num_resamples: Draws of the bootstrap, 100 or more.
        num_permutations: Swaps of the permutation tests, 100 or more.
        confidence: Of the intervals, in (0, 1).
        seed: Of draws and swaps.
        model_cards: Group and size of models, by name; the rest stand in no group.

    Raises:
        ValueError: The table is empty, an argument is out of its range, or there are too few
            performers.
    """
    _check(table, cluster, num_resamples, num_permutations, confidence)
    drawing = Drawing.of(
        table, cluster, num_resamples=num_resamples, confidence=confidence, seed=seed
    )
    known = model_cards or {}
    cards = tuple(known.get(name, ModelCard(name)) for name in table.models)
    subsets = _subsets(table, drawing)
    benefits = tuple(one for draws in subsets for one in benefits_of(draws))
    return Evaluation(
        release=table.release,
        split=table.split,
        num_episodes=table.num_episodes,
        settings=Settings(
            cluster=cluster,
            num_clusters=drawing.num_clusters,
            confidence=confidence,
            num_resamples=num_resamples,
            num_permutations=num_permutations,
            seed=seed,
            interval=INTERVAL_NAME,
        ),
        models=cards,
        conditions=table.conditions,
        scores=tuple(one for draws in subsets for one in scores_of(draws)),
        benefits=benefits,
        tests=tuple(paired_tests(table, drawing, num_permutations=num_permutations, seed=seed)),
        breakdowns=tuple(breakdowns_of(table, drawing)),
        means=tuple(one for draws in subsets for one in group_means(draws, cards)),
        acquisition=tuple(acquisition_summaries(table, drawing)),
        rings=tuple(ring_counts(table)),
        references=reference_rows(table.truth),
        chance=chance_macro_f1(table.truth),
        notes=(*table.notes, *notes_on(table, drawing, benefits, known)),
    )


def _subsets(table: ScoredTable, drawing: Drawing) -> list[SubsetDraws]:
    """All episodes, and those with a new observation if there are any."""
    everything = np.ones(table.num_episodes, bool)
    found = [SubsetDraws.of(table, drawing, "all", everything)]
    if table.acquisitions is not None and table.acquisitions.acquired.any():
        acquired = table.acquisitions.acquired
        found.append(SubsetDraws.of(table, drawing, "new_observation", acquired))
    return found


def _check(
    table: ScoredTable,
    cluster: str,
    num_resamples: int,
    num_permutations: int,
    confidence: float,
) -> None:
    if not table.num_episodes or not table.was_run.any():
        raise ValueError(
            f"there is nothing to evaluate: {table.num_episodes} episodes, "
            f"{len(table.models)} models, {len(table.conditions)} conditions"
        )
    if cluster not in get_args(ClusterLevel):
        raise ValueError(f"cluster must be performance or performer, got {cluster!r}")
    for name, value in {
        "num_resamples": num_resamples,
        "num_permutations": num_permutations,
    }.items():
        if value < _MIN_DRAWS:
            raise ValueError(f"{name} must be at least {_MIN_DRAWS}, got {value}")
    if not 0 < confidence < 1:
        raise ValueError(f"confidence must be in (0, 1), for example 0.95, got {confidence}")
