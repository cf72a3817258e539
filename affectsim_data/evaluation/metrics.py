"""The metrics of the benchmark, on plain sequences of label names; shares are in [0, 1].

Labels are the five emotions. A prediction that is none of them, be it `None`, an empty text, a
refusal or free text, is wrong. Tables of many models with their statistics: `evaluating`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.evaluation.confusion import confusion_codes, macro_f1_scores, recalls
from affectsim_data.evaluation.scored import NUM_COLUMNS
from affectsim_data.motions import EMOTIONS
from affectsim_data.poses import FloatArray

__all__ = [
    "active_gain",
    "confusion_matrix",
    "emotion_spl",
    "macro_f1",
    "observation_gap_recovery",
    "path_efficiency",
    "per_class_recall",
    "recovery_rate",
]

_CODES: dict[str, int] = {emotion: code for code, emotion in enumerate(EMOTIONS)}

Names = Sequence[Any] | NDArray[Any]
"""Names of emotions, and in predictions anything else."""


def macro_f1(labels: Names, predictions: Names) -> float:
    """Unweighted mean over the five emotions of F1 = 2 TP / (2 TP + FP + FN).

    An emotion that neither is there nor was predicted counts 0, as in scikit-learn with the five
    emotions as `labels` and `zero_division=0`.

    Args:
        labels: Names of emotions.
        predictions: As many; what is no emotion is wrong.

    Returns:
        In [0, 1]; `nan` without any episode.

    Raises:
        ValueError: Lengths differ, or a label is no emotion.

    Examples:
        Angry: one hit, one miss: 2/3. Sad: one hit, one false alarm: 2/3. The others: 0.

        >>> round(macro_f1(["angry", "angry", "sad"], ["angry", "sad", "sad"]), 4)
        0.2667
        >>> round(macro_f1(["angry", "angry", "sad"], ["angry", "refusal", "sad"]), 4)
        0.3333
    """
    return float(macro_f1_scores(confusion_matrix(labels, predictions).astype(np.float64)))


def per_class_recall(labels: Names, predictions: Names) -> dict[str, float]:
    """Share of each emotion's episodes that were named rightly.

    Args:
        labels: Names of emotions.
        predictions: As many; what is no emotion is wrong.

    Returns:
        By emotion, in [0, 1]; `nan` for an emotion without an episode.

    Raises:
        ValueError: Lengths differ, or a label is no emotion.

    Examples:
        >>> per_class_recall(["angry", "angry", "sad"], ["angry", None, "sad"])
        {'angry': 0.5, 'fearful': nan, 'happy': nan, 'neutral': nan, 'sad': 1.0}
    """
    shares = recalls(confusion_matrix(labels, predictions).astype(np.float64))
    return dict(zip(EMOTIONS, shares.tolist(), strict=True))


def confusion_matrix(labels: Names, predictions: Names) -> NDArray[np.int64]:
    """Episodes by label (rows) and prediction (columns), `(5, 6)`; the last column is all else.

    Raises:
        ValueError: Lengths differ, or a label is no emotion.

    Examples:
        >>> confusion_matrix(["sad", "sad"], ["sad", "don't know"])[4]
        array([0, 0, 0, 0, 1, 1])
    """
    _check_lengths(labels=labels, predictions=predictions)
    cells = confusion_codes(_label_codes(labels), _prediction_codes(predictions))
    counts = np.bincount(cells, minlength=len(EMOTIONS) * NUM_COLUMNS)
    return counts.reshape(len(EMOTIONS), NUM_COLUMNS).astype(np.int64)


def active_gain(*, initial: float, active: float) -> float:
    """What active observation adds to the score from the initial view; negative for a loss.

    Examples:
        >>> active_gain(initial=0.25, active=0.5)
        0.25
    """
    return active - initial


def observation_gap_recovery(*, initial: float, reference: float, active: float) -> float:
    """Share of the gap between initial and reference score that active observation recovers.

    Not clipped: below 0 is a loss, above 1 beats the reference.

    Args:
        initial: Score from the initial view.
        reference: Score from the reference view.
        active: Score after active observation.

    Returns:
        The recovered share, or `nan` unless the reference beats the initial view.

    Examples:
        >>> observation_gap_recovery(initial=0.25, reference=0.75, active=0.5)
        0.5
        >>> observation_gap_recovery(initial=0.5, reference=0.5, active=0.75)
        nan
    """
    if reference <= initial:
        return math.nan
    return (active - initial) / (reference - initial)


def recovery_rate(labels: Names, initial: Names, active: Names) -> float:
    """Share of the errors from the initial view that are right after active observation.

    Right answers that became wrong do not enter; see `active_gain` for the balance.

    Args:
        labels: Names of emotions.
        initial: Predictions from the initial view; what is no emotion is an error.
        active: Predictions after active observation, of the same episodes.

    Returns:
        In [0, 1]; `nan` if nothing was wrong at first.

    Raises:
        ValueError: Lengths differ, or a label is no emotion.

    Examples:
        Two errors at first, of which one is mended.

        >>> recovery_rate(["sad", "sad", "sad"], ["sad", "angry", None], ["angry", "sad", "happy"])
        0.5
    """
    _check_lengths(labels=labels, initial=initial, active=active)
    truth = _label_codes(labels)
    wrong = _prediction_codes(initial) != truth
    if not wrong.any():
        return math.nan
    return float((_prediction_codes(active)[wrong] == truth[wrong]).mean())


def emotion_spl(
    labels: Names, active: Names, path_length_m: ArrayLike, d_star_m: ArrayLike
) -> float:
    """Emotion-SPL: mean of right answers weighted by `path_efficiency`.

    Args:
        labels: Names of emotions.
        active: Predictions after active observation.
        path_length_m: Way the robot went, metres; also where it fell back to the initial view.
        d_star_m: Shortest way to the ring, metres; NaN where the ring is empty or out of reach,
            and such an episode is left out of the mean.

    Returns:
        In [0, 1]; `nan` if every episode is left out.

    Raises:
        ValueError: Lengths differ, a label is no emotion, or a length is negative or infinite.

    Examples:
        Right at 4 m for 2 m, right without a step for none, wrong, and left out: (1/2 + 1 + 0) / 3.

        >>> labels, active = ["sad", "sad", "sad", "sad"], ["sad", "sad", "angry", "sad"]
        >>> emotion_spl(labels, active, [4.0, 0.0, 1.0, 1.0], [2.0, 0.0, 1.0, float("nan")])
        0.5
    """
    paths, shortest = np.asarray(path_length_m), np.asarray(d_star_m)
    _check_lengths(labels=labels, active=active, path_length_m=paths, d_star_m=shortest)
    efficiency = path_efficiency(paths, shortest)
    valid = ~np.isnan(efficiency)
    if not valid.any():
        return math.nan
    right = _prediction_codes(active) == _label_codes(labels)
    return float((right * np.nan_to_num(efficiency))[valid].mean())


def path_efficiency(path_length_m: ArrayLike, d_star_m: ArrayLike) -> FloatArray:
    """Shortest way over the longer of it and the way gone, in [0, 1]; 1 if both are 0.

    Args:
        path_length_m: Way the robot went, metres.
        d_star_m: Shortest way, metres; broadcast with it. NaN gives NaN.

    Raises:
        ValueError: A length is negative or infinite, or a way gone is NaN.

    Examples:
        >>> path_efficiency([4.0, 1.0, 0.0, 3.0], [2.0, 2.0, 0.0, 0.0])
        array([0.5, 1. , 1. , 0. ])
    """
    paths, shortest = np.asarray(path_length_m, float), np.asarray(d_star_m, float)
    _check_ways("path_length_m", paths, known=~np.zeros(paths.shape, bool))
    _check_ways("d_star_m", shortest, known=~np.isnan(shortest))
    longer = np.maximum(paths, shortest)
    out: FloatArray = np.divide(
        shortest, longer, out=np.ones(longer.shape, np.float64), where=longer != 0
    )
    return out


def _label_codes(labels: Names) -> NDArray[np.int8]:
    codes = _prediction_codes(labels)
    if (codes < 0).any():
        row = int(np.argmax(codes < 0))
        raise ValueError(f"labels[{row}] must be one of {', '.join(EMOTIONS)}, got {labels[row]!r}")
    return codes


def _prediction_codes(names: Names) -> NDArray[np.int8]:
    """Index of each emotion, -1 for anything else."""
    codes = (_CODES.get(name, -1) if isinstance(name, str) else -1 for name in names)
    return np.fromiter(codes, np.int8, len(names))


def _check_lengths(**columns: Names) -> None:
    counts = {name: len(values) for name, values in columns.items()}
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{name} {count}" for name, count in counts.items())
        raise ValueError(f"there must be one value per episode, got {listed}")


def _check_ways(name: str, values: FloatArray, *, known: NDArray[np.bool_]) -> None:
    bad = known & ~(np.isfinite(values) & (values >= 0))
    if bad.any():
        row = int(np.argmax(bad))
        raise ValueError(f"{name}[{row}] must be a length in metres, got {values.flat[row]}")
