"""Inverse kinematics of two-bone limbs: where elbow and knee go when wrist or ankle is given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.poses import FloatArray, matrix_quaternion

__all__ = ["align_bone", "two_bone_ik"]


def two_bone_ik(
    target: FloatArray,
    pole: FloatArray,
    upper_m: float,
    lower_m: float,
    *,
    max_flexion: float = np.pi,
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Directions of two bones that reach for a target, by the law of cosines.

    Args:
        target: From the root joint, metres, `(n, 3)`; out of reach, the limb points at it.
        pole: Where the middle joint sticks out to, `(n, 3)`.
        upper_m: Length of the first bone.
        lower_m: Length of the second.
        max_flexion: How far the middle joint bends, radians; a nearer target is not reached.

    Returns:
        Unit directions of both bones and the axis the middle joint bends about, each `(n, 3)`.
    """
    distance = np.linalg.norm(target, axis=-1, keepdims=True)
    along = target / np.maximum(distance, 1e-9)
    folded = upper_m**2 + lower_m**2 + 2.0 * upper_m * lower_m * np.cos(max_flexion)
    shortest = max(float(np.sqrt(max(folded, 0.0))), abs(upper_m - lower_m) + 1e-3)
    longest = (upper_m + lower_m) * 0.9995
    distance = np.clip(distance, shortest, longest)
    cosine = (upper_m**2 + distance**2 - lower_m**2) / (2.0 * upper_m * distance)
    cosine = np.clip(cosine, -1.0, 1.0)
    out = pole - np.sum(pole * along, axis=-1, keepdims=True) * along
    out = out / np.maximum(np.linalg.norm(out, axis=-1, keepdims=True), 1e-9)
    upper = along * cosine + out * np.sqrt(1.0 - cosine**2)
    lower = (along * distance - upper_m * upper) / lower_m
    return upper, lower, np.cross(out, along)


def align_bone(
    bone: FloatArray, axis: FloatArray, rest_bone: ArrayLike, rest_axis: ArrayLike
) -> FloatArray:
    """Rotation `(n, 4)` that takes a bone and its bending axis from rest to `(n, 3)` each.

    Args:
        bone: Unit direction the bone is to point along, `(n, 3)`.
        axis: Unit axis it is to bend about, perpendicular to `bone`, `(n, 3)`.
        rest_bone: Direction of the bone in the rest pose, `(3,)`.
        rest_axis: Its bending axis there, `(3,)`.
    """
    target = np.stack([bone, axis, np.cross(bone, axis)], axis=-1)
    one, two = np.asarray(rest_bone, np.float64), np.asarray(rest_axis, np.float64)
    rest = np.stack([one, two, np.cross(one, two)], axis=-1)
    return matrix_quaternion(target @ rest.T)
