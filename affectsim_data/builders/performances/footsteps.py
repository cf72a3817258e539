"""Feet of somebody who stands and steps now and then: planted between steps, never sliding."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.ndimage import gaussian_filter1d

from affectsim_data.builders.performances.curves import minimum_jerk
from affectsim_data.builders.performances.rig import SIDES, TOE_OFFSET, foot_rotation
from affectsim_data.builders.performances.styles import Side
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["Step", "step_feet", "weight_center"]

_ANKLE_M = float(BODY.rest_positions[JOINT_NAMES.index("left_ankle"), 1])
_HEEL_LIFT = np.deg2rad(22.0)
_CLOSED_M = 1e-6


@dataclasses.dataclass(frozen=True)
class Step:
    """One foot lifted and put down elsewhere."""

    side: Side
    start: float
    """Phase of the cycle at which the heel lifts, [0, 1)."""
    end: float
    """Phase at which the foot is flat again, after `start`."""
    x: float
    """Where the ankle goes, to the left, metres in the performance frame."""
    z: float
    """Where it goes, forward."""
    yaw: float = 0.0
    """Which way the toes point then, radians, 0 is +Z, positive to the left."""
    lift_m: float = 0.05
    """How high the ankle is lifted."""


def step_feet(
    phase: FloatArray, stance: Mapping[Side, tuple[float, float, float]], steps: Sequence[Step]
) -> tuple[dict[Side, FloatArray], dict[Side, FloatArray]]:
    """Ankles `(n, 3)` and foot angles `(n, 2)` per side, as `BodyTrack` wants them.

    Args:
        phase: Of each frame, in [0, 1), `(n,)`.
        stance: Where each foot stands at phase 0: ankle x and z in metres, yaw in radians.
        steps: Steps of the cycle in any order; each foot must come back to its stance.

    Raises:
        ValueError: Steps of one foot overlap, leave the cycle, or do not lead back.
    """
    ankles, feet = {}, {}
    for side in SIDES:
        mine = sorted((step for step in steps if step.side == side), key=lambda step: step.start)
        ankles[side], feet[side] = _one_foot(phase, side, stance[side], mine)
    return ankles, feet


def weight_center(
    ankles: Mapping[Side, FloatArray], *, smooth_frames: float = 5.0, bias: float = 0.0
) -> FloatArray:
    """Where the pelvis should be above the floor to be over the feet that carry it, `(n, 3)`, y 0.

    Args:
        ankles: Per side, `(n, 3)`.
        smooth_frames: Standard deviation of the smoothing in time, cyclic.
        bias: Weight on the left foot beyond a half, -0.5 to 0.5.
    """
    left, right = (
        np.clip(1.0 - (ankles[side][:, 1] - _ANKLE_M) / 0.04, 0.0, 1.0) for side in SIDES
    )
    left, right = (0.5 + bias) * left + 1e-3, (0.5 - bias) * right + 1e-3
    share = (left / (left + right))[:, None]
    center = share * ankles["left"] + (1.0 - share) * ankles["right"]
    center[:, 1] = 0.0
    smooth: FloatArray = gaussian_filter1d(center, smooth_frames, axis=0, mode="wrap")
    return smooth


def _one_foot(
    phase: FloatArray, side: Side, stance: tuple[float, float, float], steps: list[Step]
) -> tuple[FloatArray, FloatArray]:
    place = np.array(stance)
    where, pitch, lift = np.tile(place, (len(phase), 1)), np.zeros(len(phase)), np.zeros(len(phase))
    end = 0.0
    for step in steps:
        if not end <= step.start < step.end <= 1.0:
            raise ValueError(
                f"{side} foot: steps must follow one another within [0, 1], got one from "
                f"{step.start} to {step.end} after {end}"
            )
        target = np.array([step.x, step.z, step.yaw])
        swing = np.clip((phase - step.start) / (step.end - step.start), 0.0, 1.0)
        share = minimum_jerk(swing)
        after = phase >= step.start
        where[after] = (place + share[:, None] * (target - place))[after]
        lift += step.lift_m * np.sin(np.pi * swing) ** 2
        pitch += _HEEL_LIFT * np.sin(np.pi * swing) ** 2 * (1.0 - swing) * 2.0
        place, end = target, step.end
    if np.abs(place - stance).max() > _CLOSED_M:
        raise ValueError(f"{side} foot: steps must lead back to {stance}, got {tuple(place)}")
    ankle = np.stack([where[:, 0], _ANKLE_M + lift, where[:, 1]], axis=1)
    feet = np.stack([where[:, 2], pitch], axis=1)
    flat = quaternion_rotate(yaw_quaternion(feet[:, 0]), TOE_OFFSET)
    return ankle + flat - quaternion_rotate(foot_rotation(feet), TOE_OFFSET), feet
