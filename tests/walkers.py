"""People made in code whose planted feet are known: one walks straight ahead, one sways."""

from __future__ import annotations

import numpy as np

from affectsim_data.motions import Motion
from affectsim_data.motions.planting import TOE_OFFSET, TOE_REST_M, move_feet
from affectsim_data.poses import FloatArray, axis_angle_quaternion, quaternion_rotate
from affectsim_data.skeletons import JOINT_NAMES

CYCLE_S, STANCE = 1.0, 0.6
"""Of the walk: both feet step once a cycle, and stand for this share of it."""


def walker(*, seconds: float = 4.0, fps: float = 30.0, speed: float = 1.0) -> Motion:
    """Walks along +Z from the origin, left foot standing first."""
    time_s = np.arange(round(seconds * fps)) / fps
    root = np.zeros((len(time_s), 3))
    root[:, 1] = 0.87 + 0.01 * np.sin(4.0 * np.pi * time_s / CYCLE_S)
    root[:, 2] = speed * time_s
    toes = np.zeros((len(time_s), 2, 3))
    for foot, side in ((0, 0.09), (1, -0.09)):
        phase = time_s / CYCLE_S + 0.5 * foot
        cycle = np.floor(phase)
        swing = np.clip((phase - cycle - STANCE) / (1.0 - STANCE), 0.0, 1.0)
        share = swing * swing * (3.0 - 2.0 * swing)
        place = speed * CYCLE_S * (cycle + share - 0.5 * foot + 0.5 * STANCE)
        lift = 0.06 * np.sin(np.pi * swing) ** 2
        toes[:, foot] = np.stack([side + 0 * lift, TOE_REST_M + lift, place + 0.13], axis=1)
    arms = 0.5 * np.sin(2.0 * np.pi * time_s / CYCLE_S)
    return _person("walker", root, toes, arms, fps)


def planted_frames(num_frames: int, fps: float) -> np.ndarray:
    """Frames in which each foot of the walker stands, `(num_frames, 2)`."""
    phase = np.arange(num_frames)[:, None] / fps / CYCLE_S + np.array([0.0, 0.5])
    return np.asarray(phase - np.floor(phase) < STANCE)


def swayer(*, seconds: float = 3.0, fps: float = 30.0, drift_m: float = 0.0) -> Motion:
    """Stands and sways; the left foot moves by `drift_m` in a step in the middle."""
    time_s = np.arange(round(seconds * fps)) / fps
    root = np.zeros((len(time_s), 3))
    root[:, 0], root[:, 1] = 0.03 * np.sin(1.7 * time_s), 0.91
    toes = np.tile([[0.09, TOE_REST_M, 0.13], [-0.09, TOE_REST_M, 0.13]], (len(time_s), 1, 1))
    swing = np.clip((time_s - 0.5 * seconds) / 0.4, 0.0, 1.0)
    toes[:, 0, 2] += drift_m * swing * swing * (3.0 - 2.0 * swing)
    toes[:, 0, 1] += 0.05 * np.sin(np.pi * swing) ** 2 * (drift_m != 0.0)
    return _person("swayer", root, toes, 0.4 * np.sin(2.3 * time_s), fps)


def _person(
    motion_id: str, root: FloatArray, toes: FloatArray, arms: FloatArray, fps: float
) -> Motion:
    local = np.zeros((len(root), 22, 4))
    local[..., 0] = 1.0
    for side, sign in (("left", 1.0), ("right", -1.0)):
        down = axis_angle_quaternion([0.0, 0.0, 1.0], np.full(len(root), -1.2 * sign))
        local[:, JOINT_NAMES.index(f"{side}_shoulder")] = down
        bent = axis_angle_quaternion([0.0, 1.0, 0.0], -sign * (0.7 + sign * arms))
        local[:, JOINT_NAMES.index(f"{side}_elbow")] = bent
    flat = np.tile([1.0, 0.0, 0.0, 0.0], (len(root), 2, 1))
    ankles = toes - quaternion_rotate(flat, TOE_OFFSET)
    root, local = move_feet(root, local, ankles, flat, np.zeros((len(root), 2), bool), fps=fps)
    return Motion(motion_id, "p1", motion_id, "neutral", "test", fps, root, local, source="made")
