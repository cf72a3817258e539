"""What answering without looking is worth: the scores everything is to be held against."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from affectsim_data.evaluation.results import ReferenceRow
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = ["chance_macro_f1", "expected_macro_f1", "reference_rows"]


def reference_rows(truth: NDArray[np.int8]) -> tuple[ReferenceRow, ...]:
    """Expected Macro-F1 of constant answers, uniform guessing and guessing by the prior.

    Args:
        truth: Index of the emotion of each episode, `(num_episodes,)`, at least one.
    """
    counts = np.bincount(truth, minlength=len(EMOTIONS))
    constant = np.eye(len(EMOTIONS))
    rows = [
        ReferenceRow(f"constant:{emotion}", expected_macro_f1(counts, constant[code]))
        for code, emotion in enumerate(EMOTIONS)
    ]
    uniform = ReferenceRow("uniform", chance_macro_f1(truth))
    prior = ReferenceRow("prior", expected_macro_f1(counts, counts / counts.sum()))
    return (*rows, uniform, prior)


def chance_macro_f1(truth: NDArray[np.int8]) -> float:
    """Expected Macro-F1 of uniform guessing, a little under 0.2 on a balanced table."""
    counts = np.bincount(truth, minlength=len(EMOTIONS))
    return expected_macro_f1(counts, np.full(len(EMOTIONS), 1 / len(EMOTIONS)))


def expected_macro_f1(counts: NDArray[np.int64], shares: FloatArray) -> float:
    """Expected Macro-F1 of answers drawn at random, whatever is seen; exact, not simulated.

    Of N episodes n are of an emotion, and S of all answers name it: binomial, with the share p it
    is drawn with. Given S, hits are hypergeometric with mean S n / N, so the expected F1,
    2 hits / (n + S), is 2 n / N times the mean of S / (n + S), a sum over S of N + 1 terms.

    Args:
        counts: Episodes of each emotion, `(5,)`.
        shares: How often each emotion is answered, `(5,)`, of sum 1.

    Examples:
        Of two episodes, angry and sad, the answer is always sad: F1 of sad is 2/3, the others 0.

        >>> round(expected_macro_f1(np.array([1, 0, 0, 0, 1]), np.array([0.0, 0, 0, 0, 1])), 4)
        0.1333
    """
    total = int(counts.sum())
    named = np.arange(total + 1)[:, None]
    both = counts + named
    ratio = np.divide(named, both, out=np.zeros(both.shape), where=both > 0)
    chances = stats.binom.pmf(named, total, shares)
    scores = 2 * counts / total * (chances * ratio).sum(axis=0)
    return float(scores.mean())
