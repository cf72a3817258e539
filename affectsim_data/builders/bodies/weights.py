"""Joint weights that bend well under linear blending: smooth, full at elbows and knees."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from affectsim_data.builders.bodies.surfaces import IntArray, normalized
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["bendable_weights", "limited"]

_PASSES = 3
_ELBOW = ((-0.045, 0.040), (0.004, 0.065))
"""Middle and half width of the change from upper arm to forearm, metres beyond the joint of a
1.7 m tall body: on the outside, on the inside. Short outside, so that the elbow keeps its point."""
_KNEE = ((0.036, 0.045), (0.004, 0.075))
"""The same from thigh to shin. The knee cap belongs to the thigh, else a bent knee caves in."""
_WRIST = ((-0.030, 0.060), (-0.030, 0.060))
"""Long, for the forearm carries the twist of the hand."""


def bendable_weights(
    weights: FloatArray,
    positions: FloatArray,
    joints: Mapping[str, FloatArray],
    groups: Iterable[IntArray],
) -> FloatArray:
    """Weights `(num_vertices, 22)`, at most four a vertex, rows sum to one.

    Args:
        weights: Of the base mesh, `(num_vertices, 22)`.
        positions: Its vertices in the pose of `joints`, metres, `(num_vertices, 3)`.
        joints: Joint positions by name, metres, `(3,)`.
        groups: Faces `(n, 4)` of surfaces over which weights are to change smoothly.
    """
    smooth = weights
    for quads in groups:
        smooth = _smoothed(smooth, quads)
    for side in ("left", "right"):
        arm = [joints[f"{side}_{name}"] for name in ("shoulder", "elbow", "wrist")]
        upper, lower = normalized(arm[1] - arm[0]), normalized(arm[2] - arm[1])
        leg = [joints[f"{side}_{name}"] for name in ("hip", "ankle")]
        scale = float(np.linalg.norm(leg[1] - leg[0])) / 0.835  # That of the canonical body.
        hinges = (
            ("shoulder", "elbow", upper + lower, lower - upper, _ELBOW),
            ("elbow", "wrist", lower, lower - upper, _WRIST),
            ("hip", "knee", leg[1] - leg[0], np.array([0.0, 0.0, -1.0]), _KNEE),
        )
        for first, second, along, inside, ramps in hinges:
            pair = [JOINT_NAMES.index(f"{side}_{name}") for name in (first, second)]
            place = positions - joints[f"{side}_{second}"]
            share = _hinge_share(place / scale, normalized(along), inside, ramps)
            smooth = _shared_out(smooth, pair, share)
    return limited(smooth)


def _smoothed(weights: FloatArray, quads: IntArray) -> FloatArray:
    """Weights drawn halfway to the mean of their neighbours, a few times."""
    edges = np.concatenate([quads[:, [i, (i + 1) % 4]] for i in range(4)])
    pairs = np.unique(np.concatenate([edges, edges[:, ::-1]]), axis=0)
    degree = np.bincount(pairs[:, 0], minlength=len(weights))[:, None]
    for _ in range(_PASSES):
        total = np.zeros_like(weights)
        np.add.at(total, pairs[:, 0], weights[pairs[:, 1]])
        weights = np.where(degree > 0, 0.5 * weights + 0.5 * total / np.maximum(degree, 1), weights)
    return weights


def _hinge_share(
    place: FloatArray,
    along: FloatArray,
    inside: FloatArray,
    ramps: tuple[tuple[float, float], tuple[float, float]],
) -> FloatArray:
    """Share of the lower of two bones at places `(n, 3)` relative to the joint, `(n,)`."""
    distance = place @ along
    around = place - distance[:, None] * along
    inward = normalized(inside - along * (inside @ along))
    share = 0.5 + 0.5 * np.clip(normalized(around) @ inward, -1.0, 1.0)
    (outer, outer_half), (inner, inner_half) = ramps
    middle, half = outer + share * (inner - outer), outer_half + share * (inner_half - outer_half)
    rise = ((distance - middle) / half / 2.0 + 0.5).clip(0.0, 1.0)
    smooth: FloatArray = rise * rise * (3.0 - 2.0 * rise)
    return smooth


def _shared_out(weights: FloatArray, pair: list[int], share: FloatArray) -> FloatArray:
    """Weights where two joints split by `share` `(n,)` what they have together."""
    both = weights[:, pair].sum(axis=1)
    split = weights.copy()
    split[:, pair[0]], split[:, pair[1]] = both * (1.0 - share), both * share
    # Where others have a say, as in the palm or the seat, the split fades in.
    trust = ((both - 0.6) / 0.35).clip(0.0, 1.0)[:, None]
    mixed: FloatArray = weights + trust * (split - weights)
    return mixed


def limited(weights: FloatArray) -> FloatArray:
    """The four largest weights of a row, summing to one."""
    floor = np.sort(weights, axis=1)[:, -4][:, None]
    kept = np.where(weights >= np.maximum(floor, 1e-3), weights, 0.0)
    total: FloatArray = kept / kept.sum(axis=1, keepdims=True)
    return total
