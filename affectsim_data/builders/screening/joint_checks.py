"""Checks of joint angles: ranges bodies have, limbs exchanged, joints that hang."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from affectsim_data.builders.screening.findings import Measure, Posed, sustained
from affectsim_data.builders.screening.limits import Frozen, JointLimits
from affectsim_data.motions.joint_frames import SourcePose
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
)
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS

__all__ = [
    "frozen",
    "hanging_joints",
    "joint_angles",
    "joint_limits",
    "limb_swap",
]

_MIRROR = np.array([1.0, 1.0, -1.0, -1.0])
"""What the other side's rotation looks like on the left: mirrored at the plane x = 0."""
_BONES: dict[str, tuple[float, float, float]] = {
    "shoulder": (1.0, 0.0, 0.0),
    "elbow": (1.0, 0.0, 0.0),
    "wrist": (1.0, 0.0, 0.0),
    "collar": (1.0, 0.0, 0.0),
    "hip": (0.0, -1.0, 0.0),
    "knee": (0.0, -1.0, 0.0),
    "ankle": (0.0, 0.0, 1.0),
}
"""Direction of the bone beyond a joint, left side, T-pose."""
_SHOULDER_CENTER = np.array([0.6, -0.3, 0.7]) / np.linalg.norm([0.6, -0.3, 0.7])
"""Middle of what an upper arm reaches: outwards, forwards and a little down."""
_LIMBS = {"arm": ("shoulder", "elbow", "wrist"), "leg": ("hip", "knee", "ankle")}
_HANGING = tuple(
    f"{side}_{part}" for side in ("left", "right") for part in ("shoulder", "elbow", "wrist")
)


def joint_angles(joint_rotations: FloatArray) -> dict[str, FloatArray]:
    """Anatomical angles, degrees, by `JOINT_ANGLE`, each `(num_frames,)`.

    Hinges have flexion and what bends sideways; hips flexion, abduction and twist; the shoulder's
    swing is from the middle of its reach, other swings are from the T-pose. Left and right agree.
    """
    angles: dict[str, FloatArray] = {}
    for side in ("left", "right"):
        for part, bone in _BONES.items():
            local = joint_rotations[:, JOINT_NAMES.index(f"{side}_{part}")]
            local = local * _MIRROR if side == "right" else local
            for angle, values in _part_angles(part, np.array(bone), local).items():
                angles[f"{side}_{part}_{angle}"] = values
    for name in ("spine1", "spine2", "spine3", "neck", "head"):
        cosine = np.abs(joint_rotations[:, JOINT_NAMES.index(name), 0])
        angles[f"{name}_bend"] = np.rad2deg(2.0 * np.arccos(cosine.clip(0.0, 1.0)))
    return angles


def joint_limits(posed: Posed, limits: JointLimits) -> Measure:
    """How far an angle leaves its range and stays out of it, degrees."""
    length = posed.num_frames_in(limits.sustained_s)
    worst = Measure(0.0)
    for name, values in joint_angles(posed.motion.joint_rotations).items():
        low, high = limits.ranges_deg[name.removeprefix("left_").removeprefix("right_")]
        outside = sustained(np.maximum(low - values, values - high), length)
        frame = int(outside.argmax())
        if outside[frame] <= worst.value:
            continue
        first = int(np.argmax(outside > limits.limit)) if outside[frame] > limits.limit else frame
        joint, angle = name.rsplit("_", 1)
        detail = (
            f"{angle} of {joint} is {values[frame]:.0f} degrees, the range is "
            f"{low:.0f} to {high:.0f}"
        )
        worst = Measure(float(outside[frame]), first, joint, detail)
    return worst


def limb_swap(posed: Posed) -> Measure:
    """How much better a step of both arms or legs fits if left and right are exchanged, metres.

    Each limb is where its middle and end joint are from its first one, in the frame of the trunk.
    Where it goes on is foretold from its last step; an exchange, as it is or mirrored, fits the
    other limb's better.
    """
    worst = Measure(0.0)
    for limb, parts in _LIMBS.items():
        trunk = posed.rotations[:, JOINT_NAMES.index("spine3" if limb == "arm" else "pelvis")]
        left, right = (_limb_vectors(posed, side, parts, trunk) for side in ("left", "right"))
        if len(left) < 3:
            continue
        next_left, next_right = 2.0 * left[1:-1] - left[:-2], 2.0 * right[1:-1] - right[:-2]
        kept = _apart(left[2:], next_left) + _apart(right[2:], next_right)
        swapped = _apart(left[2:], next_right) + _apart(right[2:], next_left)
        flip = np.array([-1.0, 1.0, 1.0])
        mirrored = _apart(left[2:], next_right * flip) + _apart(right[2:], next_left * flip)
        gain = 0.5 * (kept - np.minimum(swapped, mirrored))
        frame = int(gain.argmax())
        if gain[frame] > worst.value:
            detail = f"left and right {limb} seem to change places"
            worst = Measure(float(gain[frame]), frame + 2, f"left_{parts[0]}", detail)
    return worst


def frozen(
    local: Mapping[str, FloatArray], positions: FloatArray, fps: float, limits: Frozen
) -> Measure:
    """Longest time a joint hangs still that moves otherwise, seconds.

    Counts only a joint that hangs for a `share` of the time while the body moves on. Only sensors
    hang: joints of people always tremble, those of made motions may be held still.

    Args:
        local: Rotation of a joint in the one above, `(num_frames, 4)`, by name: `hanging_joints`.
        positions: Of all joints, metres, `(num_frames, num_joints, 3)`.
        fps: Frames per second.
        limits: Thresholds.
    """
    speed = np.linalg.norm(np.diff(positions, axis=0), axis=-1).mean(axis=1) * fps
    worst = Measure(0.0)
    for name, rotations in local.items():
        still = _turned_deg(rotations[1:], rotations[:-1]) * fps < limits.still_deg_s
        moves = _turned_deg(rotations, rotations[:1]).max() >= limits.moved_deg
        if not moves or still.mean() < limits.share:
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
        starts, lengths = edges[::2], edges[1::2] - edges[::2]
        longest = int(lengths.argmax())
        start, length = int(starts[longest]), int(lengths[longest])
        alive = float(speed[start : start + length].mean())
        if length / fps > worst.value and alive >= limits.alive_m_s:
            detail = f"{name} does not turn for {length / fps:.1f} s while the body moves"
            worst = Measure(length / fps, start, name, detail)
    return worst


def hanging_joints(source: SourcePose, joints: Mapping[str, str]) -> dict[str, FloatArray]:
    """Rotations of the arm joints of a recording in the mapped joints above them."""
    local = {}
    for name in _HANGING:
        above = JOINT_PARENTS[JOINT_NAMES.index(name)]
        while above >= 0 and JOINT_NAMES[above] not in joints:
            above = JOINT_PARENTS[above]
        if name in joints and above >= 0:
            parent, child = (
                source.rotations[:, source.joint_names.index(joints[joint])]
                for joint in (JOINT_NAMES[above], name)
            )
            local[name] = quaternion_multiply(quaternion_conjugate(parent), child)
    return local


def _part_angles(part: str, bone: FloatArray, local: FloatArray) -> Mapping[str, FloatArray]:
    """Angles of a joint of the left side, degrees."""
    x, y, z = np.moveaxis(quaternion_rotate(local, bone), -1, 0)
    if part == "elbow":
        return {"flexion": _degrees(z, x), "sideways": np.rad2deg(np.arcsin(y.clip(-1.0, 1.0)))}
    sideways = np.rad2deg(np.arcsin(x.clip(-1.0, 1.0)))
    if part == "knee":
        return {"flexion": _degrees(-z, -y), "sideways": sideways}
    twist = np.rad2deg(2.0 * np.arctan2(local[:, 1:] @ bone, local[:, 0]) + np.pi) % 360.0 - 180.0
    if part == "hip":
        return {"flexion": _degrees(z, -y), "abduction": sideways, "twist": -twist}
    center = _SHOULDER_CENTER if part == "shoulder" else bone
    cosine = x * center[0] + y * center[1] + z * center[2]
    swing = np.rad2deg(np.arccos(cosine.clip(-1.0, 1.0)))
    return {"swing": swing, "twist": twist} if part == "shoulder" else {"swing": swing}


def _degrees(sine: FloatArray, cosine: FloatArray) -> FloatArray:
    """Angle from -90 to 270: a limb folded past 180 degrees is folded, not bent backwards."""
    angle: FloatArray = (np.rad2deg(np.arctan2(sine, cosine)) + 90.0) % 360.0 - 90.0
    return angle


def _limb_vectors(
    posed: Posed, side: str, parts: tuple[str, str, str], trunk: FloatArray
) -> FloatArray:
    """Middle and end joint from the first one, in the trunk's frame, `(num_frames, 2, 3)`."""
    first, middle, end = (JOINT_NAMES.index(f"{side}_{part}") for part in parts)
    away = posed.positions[:, [middle, end]] - posed.positions[:, first, None]
    return quaternion_rotate(quaternion_conjugate(trunk)[:, None], away)


def _apart(one: FloatArray, other: FloatArray) -> FloatArray:
    """Mean distance of the joints of two `(n, joints, 3)`, `(n,)`."""
    mean: FloatArray = np.linalg.norm(one - other, axis=-1).mean(axis=-1)
    return mean


def _turned_deg(one: FloatArray, other: FloatArray) -> FloatArray:
    """Angle between rotations, degrees; exact for small ones, where a cosine is not."""
    sign = np.where(np.sum(one * other, axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    half = 0.5 * np.linalg.norm(one - sign * other, axis=-1)
    turned: FloatArray = np.rad2deg(4.0 * np.arcsin(half.clip(0.0, 1.0)))
    return turned
