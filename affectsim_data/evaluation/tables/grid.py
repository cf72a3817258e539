"""Predictions laid out by model, condition and episode."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.answers import parse_answers
from affectsim_data.evaluation.scored import outcome_code
from affectsim_data.evaluation.tables.predictions import Predictions
from affectsim_data.motions import EMOTIONS

__all__ = ["Grid", "answer_codes", "lay_out"]

_NONE = -1


@dataclasses.dataclass(frozen=True)
class Grid:
    """What is known per model, condition and episode; arrays of that shape."""

    models: tuple[str, ...]
    conditions: tuple[str, ...]
    entries: NDArray[np.int64]
    """Row of the predictions, -1 where there is none."""
    answers: NDArray[np.int8]
    """As in `ScoredTable`; missing where there is no row."""
    latency_ms: NDArray[np.float32]
    """NaN where not told."""
    frames: NDArray[np.int64]
    """Code of the hash of frames, -1 where not told."""

    @property
    def is_there(self) -> NDArray[np.bool_]:
        """Whether there is a prediction."""
        there: NDArray[np.bool_] = self.entries != _NONE
        return there

    @property
    def was_run(self) -> NDArray[np.bool_]:
        """Whether there is any, `(num_models, num_conditions)`."""
        run: NDArray[np.bool_] = np.any(self.is_there, axis=2)
        return run

    def place(self, condition: str) -> int | None:
        """Place of a condition, or `None` if nothing was run under it."""
        return self.conditions.index(condition) if condition in self.conditions else None


def lay_out(
    predictions: Predictions, answers: NDArray[np.int8], places: NDArray[np.int64], count: int
) -> Grid:
    """Rows of predictions at their places.

    Args:
        predictions: Without two rows for the same place.
        answers: Code of each row, `(num_rows,)`.
        places: Place of each row's episode, -1 for rows to leave out, `(num_rows,)`.
        count: Episodes.
    """
    table = predictions.table
    models, conditions = predictions.models, predictions.conditions
    shape = (len(models), len(conditions), count)
    known = np.flatnonzero(places >= 0)
    model, condition = (
        pc.index_in(table.column(name), value_set=pa.array(words, pa.string())).to_numpy()[known]
        for name, words in (("model", models), ("condition", conditions))
    )
    at = (model.astype(np.int64), condition.astype(np.int64), places[known])
    entries = np.full(shape, _NONE)
    laid_answers = np.full(shape, outcome_code("missing"), np.int8)
    latency_ms = np.full(shape, np.nan, np.float32)
    frames = np.full(shape, _NONE)
    entries[at] = known
    laid_answers[at] = answers[known]
    latency_ms[at] = _floats(table.column("latency_ms"))[known]
    frames[at] = _word_codes(table.column("frames_sha256"))[0][known]
    return Grid(models, conditions, entries, laid_answers, latency_ms, frames)


def answer_codes(table: pa.Table) -> tuple[NDArray[np.int8], list[str]]:
    """Code of every row of predictions, as in `ScoredTable.answers`; and notes.

    The label is the answer where there is one; elsewhere the text is parsed.
    """
    found = pc.index_in(table.column("label"), value_set=pa.array(EMOTIONS, pa.string()))
    labels = found.fill_null(_NONE).to_numpy().astype(np.int8)
    words, distinct = _word_codes(table.column("raw_text"))
    # The last stands for rows without a text, which have a label.
    parsed = np.append(np.asarray(parse_answers(distinct), np.int8), outcome_code("empty"))[words]
    return np.where(labels >= 0, labels, parsed), _disagreements(labels, parsed, words >= 0)


def _disagreements(
    labels: NDArray[np.int8], parsed: NDArray[np.int8], has_text: NDArray[np.bool_]
) -> list[str]:
    both = has_text & (labels >= 0)
    other = both & (parsed >= 0) & (parsed != labels)
    if not other.any():
        return []
    return [
        f"label and raw_text name different emotions in {other.sum():,} of the {both.sum():,} rows "
        "that have both, letters read in the usual order of options; the label counts"
    ]


def _word_codes(column: pa.ChunkedArray) -> tuple[NDArray[np.int64], list[str]]:
    """Code of every text, -1 for null, `(n,)`; and the texts they stand for."""
    encoded = column.dictionary_encode().combine_chunks()
    codes: NDArray[Any] = encoded.indices.fill_null(_NONE).to_numpy(zero_copy_only=False)
    return codes.astype(np.int64), encoded.dictionary.to_pylist()


def _floats(column: pa.ChunkedArray) -> NDArray[np.float32]:
    values: NDArray[Any] = column.fill_null(np.nan).to_numpy()
    return values.astype(np.float32)
