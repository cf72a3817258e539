"""What a reader of results must know beside the numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from affectsim_data.evaluation.bootstrap import MIN_CLUSTERS
from affectsim_data.evaluation.drawing import Drawing
from affectsim_data.evaluation.results import Benefit, ModelCard
from affectsim_data.evaluation.scored import ScoredTable
from affectsim_data.motions import EMOTIONS

__all__ = ["FEW_CLUSTERS", "notes_on"]

FEW_CLUSTERS = 20
"""Fewer clusters than this make intervals rough, and a note says so."""
_SHOWN = 5


def notes_on(
    table: ScoredTable,
    drawing: Drawing,
    benefits: Sequence[Benefit],
    model_cards: Mapping[str, ModelCard],
) -> list[str]:
    """Sentences about what is missing, rough or undefined in the results of a table."""
    return [
        *_on_clusters(drawing),
        *_on_emotions(table),
        *_on_conditions(table),
        *_on_acquisition(table),
        *_on_ogr(benefits, drawing.confidence),
        *_on_cards(table, model_cards),
    ]


def _on_clusters(drawing: Drawing) -> Iterator[str]:
    count = drawing.num_clusters
    if count < MIN_CLUSTERS:
        yield (
            f"There are no intervals: {count} clusters, and fewer than {MIN_CLUSTERS} say next to "
            "nothing about others."
        )
    elif count < FEW_CLUSTERS:
        yield (
            f"Intervals and tests are rough: there are only {count} clusters; {FEW_CLUSTERS} or "
            "more are advisable."
        )


def _on_emotions(table: ScoredTable) -> Iterator[str]:
    counts = np.bincount(table.truth, minlength=len(EMOTIONS))
    absent = [emotion for emotion, count in zip(EMOTIONS, counts, strict=True) if not count]
    if absent:
        yield (
            f"No episode is {' or '.join(absent)}: Macro-F1 is over all five emotions, so "
            f"{len(absent)} of them count 0 and it cannot exceed "
            f"{1 - len(absent) / len(EMOTIONS):.0%}."
        )


def _on_conditions(table: ScoredTable) -> Iterator[str]:
    for place, condition in enumerate(table.conditions):
        missing = [
            model
            for model, run in zip(table.models, table.was_run[:, place], strict=True)
            if not run
        ]
        if missing:
            yield (
                f"{_listed(missing)} {'was' if len(missing) == 1 else 'were'} not run under "
                f"{condition}: means under it are over the others."
            )
    if "p_init" not in table.conditions:
        yield "Nothing was run under p_init: there are no gains, gaps, recovery rates or tests."


def _on_acquisition(table: ScoredTable) -> Iterator[str]:
    active = table.condition_index("a_obs")
    if active is None:
        return
    if table.acquisitions is None:
        yield (
            "No trajectories were given: there is no E-SPL, no subset of new observations, and "
            "nothing on how the policy moved."
        )
    elif not table.acquisitions.acquired.any():
        yield "The policy acquired no new observation: a_obs is p_init throughout."
    if table.condition_index("p_init") is not None:
        tied = int(table.same_frames[active].sum())
        if tied:
            yield (
                f"In {tied:,} of {table.num_episodes:,} episodes a_obs is the clip of p_init; "
                "these ties are no evidence and tests leave them out."
            )


def _on_ogr(benefits: Sequence[Benefit], confidence: float) -> Iterator[str]:
    overall = [one for one in benefits if one.subset == "all"]
    without = [one.model for one in overall if one.gap.value <= 0]
    if without:
        yield (
            f"{_listed(without)} {'has' if len(without) == 1 else 'have'} no OGR: Macro-F1 under "
            "p_ref is not above p_init."
        )
    unbounded = [one.model for one in overall if math.isinf(one.ogr.low)]
    if unbounded:
        yield (
            f"The OGR of {_listed(unbounded)} has no bounds at {confidence:.0%} confidence: the "
            "gap it divides by may be zero."
        )


def _on_cards(table: ScoredTable, model_cards: Mapping[str, ModelCard]) -> Iterator[str]:
    strange = [name for name in model_cards if name not in table.models]
    if strange:
        yield f"Described, but without predictions: {_listed(strange)}."


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else ""
    return ", ".join(names[:_SHOWN]) + more
