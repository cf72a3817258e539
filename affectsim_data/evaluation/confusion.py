"""Counts of answers by truth, and what follows from them; for one table or thousands at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.scored import NUM_COLUMNS
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["accuracies", "confusion_codes", "macro_f1_scores", "recalls"]


def confusion_codes(truth: NDArray[np.int8], answers: NDArray[np.int8]) -> NDArray[np.int64]:
    """Cell of the flattened `(5, 6)` confusion each answer falls into; the last column is other.

    Args:
        truth: Index of the emotion, `(num_episodes,)`.
        answers: Index of the emotion, negative for anything else, `(..., num_episodes)`.

    Returns:
        Codes of the shape of `answers`, in [0, 30).
    """
    columns = np.where(answers < 0, NUM_COLUMNS - 1, answers).astype(np.int64)
    return truth.astype(np.int64) * NUM_COLUMNS + columns


def macro_f1_scores(confusions: FloatArray) -> FloatArray:
    """Macro-F1 over the five emotions of confusions `(..., 5, 6)`, shape `(...)`.

    F1 of an emotion is `2 TP / (2 TP + FP + FN)`, and 0 where nothing of it was there or named, as
    in scikit-learn with `zero_division=0`. NaN for a confusion without any episode.
    """
    hits = np.diagonal(confusions[..., : len(EMOTIONS)], axis1=-2, axis2=-1)
    present = confusions.sum(axis=-1)
    named = confusions[..., : len(EMOTIONS)].sum(axis=-2)
    both = present + named
    scores = np.divide(2 * hits, both, out=np.zeros_like(both, dtype=np.float64), where=both > 0)
    mean: FloatArray = np.where(present.sum(axis=-1) > 0, scores.mean(axis=-1), np.nan)
    return mean


def recalls(confusions: FloatArray) -> FloatArray:
    """Share of each emotion's episodes answered rightly, `(..., 5)`; NaN where it has none."""
    hits = np.diagonal(confusions[..., : len(EMOTIONS)], axis1=-2, axis2=-1)
    present = confusions.sum(axis=-1)
    shares: FloatArray = np.divide(
        hits, present, out=np.full(present.shape, np.nan), where=present > 0
    )
    return shares


def accuracies(confusions: FloatArray) -> FloatArray:
    """Share of all episodes answered rightly, `(...)`; NaN where there are none."""
    hits = np.diagonal(confusions[..., : len(EMOTIONS)], axis1=-2, axis2=-1).sum(axis=-1)
    present = confusions.sum(axis=(-2, -1))
    shares: FloatArray = np.divide(
        hits, present, out=np.full(present.shape, np.nan), where=present > 0
    )
    return shares
