"""Picks answers for a page to quote: mended, lost and without an emotion; by rule, not by taste."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.scored import OUTCOMES, ScoredTable
from affectsim_data.evaluation.tables import Predictions
from affectsim_data.motions import EMOTIONS
from affectsim_data.reports.page import Example

__all__ = ["examples_of"]

_MAX_MODELS = 4


def examples_of(predictions: Predictions, table: ScoredTable) -> list[Example]:
    """Answers to quote, in words of the models: of the first four, the first of each kind.

    The kinds: wrong under p_init and right under p_ref (or a_obs, or p_mon), quoted both; the
    reverse, quoted both; and one that names no emotion. Answers given as labels only are not
    quoted.

    Args:
        predictions: The rows.
        table: The same, scored.
    """
    found: list[Example] = []
    for model in range(min(_MAX_MODELS, len(table.models))):
        for condition, episode in dict.fromkeys(_picked(table, model)):
            text = _text(predictions, table, model, condition, episode)
            if text is not None:
                found.append(_example(table, model, condition, episode, text))
    return found


def _picked(table: ScoredTable, model: int) -> Iterator[tuple[int, int]]:
    """Condition and episode of what is to be quoted of a model."""
    initial = table.condition_index("p_init")
    better = next(
        (
            place
            for name in ("p_ref", "a_obs", "p_mon")
            if (place := table.condition_index(name)) is not None and table.was_run[model, place]
        ),
        None,
    )
    answers = table.answers[model]
    if initial is not None and better is not None and table.was_run[model, initial]:
        right = answers == table.truth
        mended = ~right[initial] & right[better]
        lost = right[initial] & ~right[better]
        for kind in (mended, lost):
            for episode in _first(kind):
                yield initial, episode
                yield better, episode
    # Missing ones are no answers.
    unnamed = (answers < 0) & (answers > -len(OUTCOMES)) & table.was_run[model][:, None]
    for episode in _first(unnamed.any(axis=0)):
        yield int(np.argmax(unnamed[:, episode])), episode


def _first(where: NDArray[np.bool_]) -> list[int]:
    return [int(np.argmax(where))] if where.any() else []


def _text(
    predictions: Predictions, table: ScoredTable, model: int, condition: int, episode: int
) -> str | None:
    """What a model said; `None` if it is not told."""
    rows = predictions.table
    key = {
        "model": table.models[model],
        "condition": table.conditions[condition],
        "episode_id": str(table.episode_ids[episode]),
    }
    for name, value in key.items():
        rows = rows.filter(pc.equal(rows.column(name), value))
    text: str | None = rows.column("raw_text")[0].as_py() if rows.num_rows else None
    return text


def _example(table: ScoredTable, model: int, condition: int, episode: int, text: str) -> Example:
    code = int(table.answers[model, condition, episode])
    return Example(
        episode_id=str(table.episode_ids[episode]),
        model=table.models[model],
        condition=table.conditions[condition],
        truth=EMOTIONS[table.truth[episode]],
        answer=EMOTIONS[code] if code >= 0 else OUTCOMES[-1 - code],
        raw_text=text,
    )
