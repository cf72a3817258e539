"""Limbs that reach elsewhere than they do, turned as little as possible."""

from __future__ import annotations

import numpy as np

from affectsim_data.motions.inverse_kinematics import two_bone_ik
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)

__all__ = ["hinged", "reach_further", "turn_between", "unit", "yaw_of"]

_STRAIGHT_M = 0.003
_SIDEWAYS_SINE = 0.15
"""Of the angle by which knees of stepping legs bend sideways at most."""


def reach_further(
    joints: tuple[FloatArray, FloatArray, FloatArray],
    target: FloatArray,
    hint: FloatArray,
    lengths_m: tuple[float, float],
    *,
    forward: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """World turns of both bones of limbs that bring their ends to a target.

    They are the smallest there are: what a limb is turned about its own length stays.

    Args:
        joints: First, middle and last joints, metres, `(n, k, 3)` each for k limbs.
        target: Where the last ones go, from the first ones, `(n, k, 3)`.
        hint: Where middle joints stick out to as far as limbs bend more than they do, unit,
            `(n, k, 3)`: a limb that was straight does not show it.
        lengths_m: Of the two bones.
        forward: Where all middle joints are to stick out to, the more the longer, `(n, k, 3)`.

    Returns:
        Rotations of the first and of the second bones in the world, `(n, k, 4)` each.
    """
    first, middle, last = joints
    upper, lower, along = unit(middle - first), unit(last - middle), unit(last - first)
    out = middle - first
    out = out - np.sum(out * along, axis=-1, keepdims=True) * along
    more = _bulge(target, lengths_m) - np.linalg.norm(out, axis=-1, keepdims=True)
    out = out + (np.maximum(more, 0.0) + _STRAIGHT_M) * hint
    pole = quaternion_rotate(turn_between(along, unit(target)), unit(out))
    if forward is not None:
        share = np.minimum(np.linalg.norm(forward, axis=-1, keepdims=True), 1.0)
        pole = (1.0 - share) * pole + forward
    new = two_bone_ik(target.reshape(-1, 3), pole.reshape(-1, 3), *lengths_m)[:2]
    new_upper, new_lower = (directions.reshape(first.shape) for directions in new)
    return turn_between(upper, new_upper), turn_between(lower, new_lower)


def hinged(thigh: FloatArray, shank: FloatArray, share: FloatArray) -> FloatArray:
    """Thighs `(n, 2, 4)` turned about their length so that knees hardly bend sideways.

    Args:
        thigh: World rotations, `(n, 2, 4)`.
        shank: World rotations of the shanks, which stay, `(n, 2, 4)`.
        share: How much of it is to be done, `(n,)`.
    """
    bone = quaternion_rotate(quaternion_multiply(quaternion_conjugate(thigh), shank), [0, -1.0, 0])
    bent = np.hypot(bone[..., 0], bone[..., 2])
    # A knee bent backwards is turned as if it bent forwards, not half round.
    aside = np.arctan2(-np.sign(bone[..., 2]) * bone[..., 0], np.abs(bone[..., 2]))
    most = np.arcsin(np.minimum(_SIDEWAYS_SINE / np.maximum(bent, 1e-9), 1.0))
    turn = (np.clip(aside, -most, most) - aside) * share[:, None]
    return quaternion_multiply(thigh, yaw_quaternion(turn))


def _bulge(target: FloatArray, lengths_m: tuple[float, float]) -> FloatArray:
    """How far middle joints stick out of the line to the target, metres, `(..., 1)`."""
    upper, lower = lengths_m
    distance = np.linalg.norm(target, axis=-1, keepdims=True)
    cosine = (upper**2 + distance**2 - lower**2) / np.maximum(2.0 * upper * distance, 1e-9)
    bulge: FloatArray = upper * np.sqrt(np.maximum(1.0 - cosine**2, 0.0))
    return bulge


def turn_between(start: FloatArray, end: FloatArray) -> FloatArray:
    """The smallest turns that take unit vectors to others, `(..., 4)`; opposite ones are kept."""
    real = 1.0 + np.sum(start * end, axis=-1, keepdims=True)
    turn = np.concatenate([np.maximum(real, 1e-9), np.cross(start, end)], axis=-1)
    return unit(turn)


def yaw_of(rotations: FloatArray) -> FloatArray:
    """The part of rotations `(..., 4)` that is about +Y, radians, `(...)`.

    It does not jump where what looked ahead comes to look straight down, as a raised heel makes.
    """
    yaw: FloatArray = 2.0 * np.arctan2(rotations[..., 2], rotations[..., 0])
    return yaw


def unit(vectors: FloatArray) -> FloatArray:
    """Vectors `(..., k)` of length 1; nothing stays nothing."""
    norms = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: FloatArray = vectors / np.maximum(norms, 1e-12)
    return unit
