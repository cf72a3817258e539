"""Hands that touch: keeps them together, or at the head, on a body of other proportions.

Limbs that point as in the source put hands elsewhere where shoulders or arms differ: clasped hands
of a narrow-shouldered skeleton come 15 cm apart on the canonical body. Where source hands are near
one another or the head, wrists are brought as near as they were, by the smallest turns of the arms.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, grey_opening

from affectsim_data.motions.easing import smooth_step
from affectsim_data.motions.reaching import reach_further
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    standard_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["keep_hands"]

_HEAD = JOINT_NAMES.index("head")
_COLLARS, _SHOULDERS, _ELBOWS, _WRISTS = (
    [JOINT_NAMES.index(f"{side}_{part}") for side in ("left", "right")]
    for part in ("collar", "shoulder", "elbow", "wrist")
)
_UPPER_M, _LOWER_M = (
    float(np.linalg.norm(BODY.joint_offsets[joints[0]])) for joints in (_ELBOWS, _WRISTS)
)
_TOGETHER_M = (0.15, 0.35)
"""Distance between wrists at which hands touch for certain, and from which they are apart."""
_AT_HEAD_M = (0.18, 0.28)
"""The same between a wrist and the head joint, at the base of the skull."""
_TOUCH_S, _EASE_S = 0.4, 0.1
"""Hands that pass one another or the face in less than this, as in waving, do not touch."""


def keep_hands(
    root_translation: FloatArray,
    joint_rotations: FloatArray,
    wrists: FloatArray,
    head: FloatArray,
    *,
    fps: float,
) -> FloatArray:
    """Joint rotations with hands as near one another, and the head, as in the source.

    Args:
        root_translation: Of the canonical body, metres, `(num_frames, 3)`.
        joint_rotations: `(num_frames, 22, 4)`.
        wrists: Left and right of the source, in the same axes and at the same size, metres,
            `(num_frames, 2, 3)`.
        head: Of the source, `(num_frames, 3)`.
        fps: Frames per second.
    """
    positions, world = BODY.forward_kinematics(root_translation, joint_rotations)
    target = _targets(positions, wrists, head, fps)
    moved = (np.abs(target - positions[:, _WRISTS]) > 0.0).any(axis=(1, 2))
    if not moved.any():
        return joint_rotations
    positions, world, target = positions[moved], world[moved], target[moved]
    turns = reach_further(
        (positions[:, _SHOULDERS], positions[:, _ELBOWS], positions[:, _WRISTS]),
        target - positions[:, _SHOULDERS],
        quaternion_rotate(world[:, _SHOULDERS], [0.0, 0.0, -1.0]),
        (_UPPER_M, _LOWER_M),
    )
    upper = quaternion_multiply(turns[0], world[:, _SHOULDERS])
    lower = quaternion_multiply(turns[1], world[:, _ELBOWS])
    chain = np.stack([upper, lower, world[:, _WRISTS]])
    above = np.stack([world[:, _COLLARS], upper, lower])
    arms = standard_quaternion(quaternion_multiply(quaternion_conjugate(above), chain))
    local = joint_rotations.copy()
    for joints, rotations in zip((_SHOULDERS, _ELBOWS, _WRISTS), arms, strict=True):
        local[np.flatnonzero(moved)[:, None], joints] = rotations
    return local


def _targets(positions: FloatArray, wrists: FloatArray, head: FloatArray, fps: float) -> FloatArray:
    """Where wrists go, `(num_frames, 2, 3)`: to each other about their middle, then to the head."""
    places = positions[:, _WRISTS]
    apart = wrists - wrists.mean(axis=1, keepdims=True)
    together = places.mean(axis=1, keepdims=True) + apart
    share = _share(np.linalg.norm(wrists[:, 0] - wrists[:, 1], axis=-1), _TOGETHER_M, fps)
    target = places + share[:, None, None] * (together - places)
    from_head = wrists - head[:, None]
    at_head = positions[:, [_HEAD]] + from_head
    share = _share(np.linalg.norm(from_head, axis=-1), _AT_HEAD_M, fps)
    moved: FloatArray = target + share[..., None] * (at_head - target)
    return moved


def _share(distance: FloatArray, limits: tuple[float, float], fps: float) -> FloatArray:
    """1 where hands touch, 0 where they are apart or only pass, smooth between, `(n, ...)`."""
    near, far = limits
    share = smooth_step(np.clip((far - distance) / (far - near), 0.0, 1.0))
    if not share.any():
        return share
    frames = max(round(_TOUCH_S * fps), 1)
    lasting = grey_opening(share, size=(frames,) + (1,) * (share.ndim - 1), mode="nearest")
    eased: FloatArray = gaussian_filter1d(lasting, _EASE_S * fps, axis=0, mode="nearest")
    return np.where(eased < 1e-4, 0.0, eased)
