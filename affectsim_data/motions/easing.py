"""Ways between two moments of a motion on which place and speed go on at both ends."""

from __future__ import annotations

import numpy as np

from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_slerp,
    standard_quaternion,
)

__all__ = [
    "coasting",
    "fading",
    "numbers_between",
    "rotation_vector",
    "rotations_between",
    "smooth_step",
    "spun",
]


def numbers_between(
    before: FloatArray,
    after: FloatArray,
    time_s: FloatArray,
    left_s: FloatArray,
    *,
    fps: float,
    settle_s: float,
) -> FloatArray:
    """Numbers that lead from the last of two frames `(2,)` to the first of two others, `(n,)`.

    Args:
        before: The last two frames before.
        after: The first two frames after.
        time_s: Since the last frame before, `(n,)`.
        left_s: To the first frame after, `(n,)`.
        fps: Frames per second of `before` and `after`.
        settle_s: How long either speed takes to die away.
    """
    share = smooth_step(time_s / (time_s + left_s))
    leaving = before[-1] + fading(time_s, settle_s) * (before[-1] - before[-2]) * fps
    coming = after[0] - fading(left_s, settle_s) * (after[1] - after[0]) * fps
    blended: FloatArray = leaving + share * (coming - leaving)
    return blended


def rotations_between(
    before: FloatArray,
    after: FloatArray,
    time_s: FloatArray,
    left_s: FloatArray,
    *,
    fps: float,
    settle_s: float,
) -> FloatArray:
    """The same for rotations `(2, num_joints, 4)` each, `(n, num_joints, 4)`."""
    share = smooth_step(time_s / (time_s + left_s))
    speed = rotation_vector(quaternion_multiply(before[1], quaternion_conjugate(before[0]))) * fps
    next_speed = rotation_vector(quaternion_multiply(after[1], quaternion_conjugate(after[0])))
    leaving = spun(speed, fading(time_s, settle_s)[:, None])
    coming = spun(-next_speed * fps, fading(left_s, settle_s)[:, None])
    return quaternion_slerp(
        quaternion_multiply(leaving, before[1]),
        quaternion_multiply(coming, after[0]),
        share[:, None],
    )


def rotation_vector(rotation: FloatArray) -> FloatArray:
    """Axis times angle of rotations `(..., 4)`, by the shorter way, `(..., 3)`."""
    q = standard_quaternion(rotation)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    vector: FloatArray = 2.0 * np.arctan2(sine, q[..., :1]) * q[..., 1:] / np.maximum(sine, 1e-12)
    return vector


def spun(spin: FloatArray, time_s: FloatArray) -> FloatArray:
    """What spins `(..., 3)`, rad/s, turn in times `(n, ...)`, `(n, ..., 4)`."""
    speed = np.linalg.norm(spin, axis=-1)
    axis = spin / np.maximum(speed, 1e-12)[..., None]
    return axis_angle_quaternion(axis, speed * time_s)


def coasting(time_s: FloatArray, coast_s: float) -> FloatArray:
    """Seconds' worth of way that a speed goes on for while it dies away, and stays at."""
    left = np.clip(1.0 - time_s / coast_s, 0.0, 1.0)
    coast: FloatArray = coast_s / 3.0 * (1.0 - left**3)
    return coast


def fading(time_s: FloatArray, fade_s: float) -> FloatArray:
    """The same, but come back to nothing after `fade_s`."""
    passed = np.clip(time_s / fade_s, 0.0, 1.0)
    fading: FloatArray = fade_s * passed * (1.0 - passed) ** 2
    return fading


def smooth_step(share: FloatArray) -> FloatArray:
    """Smoothstep: 0 to 1 with no speed at either end."""
    smooth: FloatArray = share * share * (3.0 - 2.0 * share)
    return smooth
