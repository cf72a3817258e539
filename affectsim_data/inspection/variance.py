"""How much of what differs between motions is the emotion, and how much the performer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = ["variance_components"]


def variance_components(
    values: FloatArray,
    emotions: NDArray[np.str_],
    performers: NDArray[np.str_],
    actions: NDArray[np.str_],
) -> dict[str, FloatArray]:
    """How much emotions and performers differ within an action, `(num_descriptors,)` each.

    Per action the additive model `value = mean + emotion + performer + residual` is fitted by least
    squares. `emotion_sd` and `performer_sd` are the standard deviations of its effects, less what
    the residual adds to them by chance; `residual_sd` is what takes of one performer and emotion
    differ by. Over actions they are averaged as variances, weighted by motions.
    `performer_to_emotion` is their ratio. Actions with fewer than two emotions or performers, or
    no motion to spare for a residual, are left out; with none left all is `nan`.

    Args:
        values: Descriptors of motions, `(num_motions, num_descriptors)`.
        emotions: Emotion of each motion, `(num_motions,)`.
        performers: Performer of each motion.
        actions: Action of each motion.
    """
    weights, parts = [], []
    for action in np.unique(actions):
        rows = actions == action
        part = _additive(values[rows], emotions[rows], performers[rows])
        if part is not None:
            weights.append(int(rows.sum()))
            parts.append(part)
    if not parts:
        empty = np.full(values.shape[1], np.nan)
        keys = ("emotion_sd", "performer_sd", "residual_sd", "performer_to_emotion")
        return dict.fromkeys(keys, empty)
    emotion, performer, residual = np.sqrt(np.average(parts, axis=0, weights=weights))
    ratio = np.divide(performer, emotion, out=np.full_like(emotion, np.nan), where=emotion > 1e-12)
    return {
        "emotion_sd": emotion,
        "performer_sd": performer,
        "residual_sd": residual,
        "performer_to_emotion": ratio,
    }


def _additive(
    values: FloatArray, emotions: NDArray[np.str_], performers: NDArray[np.str_]
) -> FloatArray | None:
    """Variances between emotions, between performers and of the rest, `(3, num_descriptors)`."""
    effects = [np.unique(groups, return_inverse=True) for groups in (emotions, performers)]
    sizes = [len(names) for names, _ in effects]
    spare = len(values) - (sum(sizes) - 1)
    if min(sizes) < 2 or spare < 1:
        return None
    # Columns sum to zero over the levels, so that effects are around the mean.
    columns = [(np.eye(n) - 1.0 / n)[places] for n, (_, places) in zip(sizes, effects, strict=True)]
    design = np.concatenate([np.ones((len(values), 1)), *columns], axis=1)
    solution = np.linalg.lstsq(design, values, rcond=None)[0]
    residual = np.sum((values - design @ solution) ** 2, axis=0) / spare
    found = []
    for start, n in ((1, sizes[0]), (1 + sizes[0], sizes[1])):
        effect = solution[start : start + n]
        by_chance = residual * n / len(values)
        found.append(np.maximum(effect.var(axis=0, ddof=1) - by_chance, 0.0))
    return np.array([*found, residual])
