"""Puts a motion into its performance frame: where its floor is, and where ahead."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from affectsim_data.motions.joint_frames import SIDES
from affectsim_data.motions.planting import TOE_REST_M, TOES, Stance
from affectsim_data.poses import (
    FloatArray,
    quaternion_multiply,
    quaternion_rotate,
    standard_quaternion,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["face_forward"]

_FACING_FRAMES = 10
_CONTACT_PERCENTILE = 20.0
"""Of the lower foot's clearance: half way between flat feet and toes that push off, which would
otherwise float or sink by 2 cm."""


def face_forward(
    root: FloatArray, local: FloatArray, stances: Sequence[Stance]
) -> tuple[FloatArray, FloatArray]:
    """The motion in its performance frame: on the floor, over the origin, looking along +Z.

    Looking is the mean direction across hips and shoulders over the first ten frames; the floor is
    where planted feet mostly stand, or where the lower foot mostly is if none is ever planted.

    Args:
        root: Of the canonical body, metres, +Y up, `(num_frames, 3)`.
        local: Joint rotations, `(num_frames, 22, 4)`.
        stances: When its feet are planted.
    """
    positions = BODY.forward_kinematics(root, local)[0]
    column = JOINT_NAMES.index
    left, right = ([column(f"{side}_{part}") for part in ("hip", "shoulder")] for side in SIDES)
    across = (positions[:_FACING_FRAMES, left] - positions[:_FACING_FRAMES, right]).mean(
        axis=(0, 1)
    )
    turn = yaw_quaternion(np.arctan2(across[2], across[0]))
    start = root[0] * np.array([1.0, 0.0, 1.0])
    start[1] = _floor_height(positions, stances)
    turned = local.copy()
    turned[:, 0] = quaternion_multiply(turn, local[:, 0])
    return quaternion_rotate(turn, root - start), standard_quaternion(turned)


def _floor_height(positions: FloatArray, stances: Sequence[Stance]) -> float:
    """Where the floor is under joints `(num_frames, 22, 3)`: where planted feet mostly stand."""
    if stances:
        standing = [positions[s.start : s.stop, TOES[s.foot], 1] for s in stances]
        return float(np.median(np.concatenate(standing))) - TOE_REST_M
    feet = [JOINT_NAMES.index(f"{side}_{part}") for side in SIDES for part in ("ankle", "foot")]
    clearance = (positions[:, feet, 1] - BODY.rest_positions[feet, 1]).min(axis=1)
    return float(np.percentile(clearance, _CONTACT_PERCENTILE))
