"""Closes performances into cycles, because motions are played cyclically.

`close_loop` serves whoever stays in place: over the last moments of the cycle, pose and position
are warped by what the end lacks to the beginning, so the last frame leads into the first.
`out_and_back` serves whoever walks off: warping would drag the person metres over the floor, so
the way is walked back, with a turn on the spot at both ends, and the cycle ends where it began.
Both say in `source` what was done.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.motions.motion import Motion
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
    yaw_quaternion,
)

__all__ = ["close_loop", "make_cyclic", "out_and_back", "seam_step"]

TRAVEL_MIN_M = 0.5
"""Net displacement from which a performance counts as travelling."""
_FLOOR = np.array([1.0, 0.0, 1.0])
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def make_cyclic(
    motion: Motion, *, max_travel_m: float | None = None, seam_s: float = 0.4
) -> Motion:
    """The motion as a closed cycle: out and back if it travels, else with a blended seam."""
    if _net_travel(motion) > TRAVEL_MIN_M:
        return out_and_back(motion, max_travel_m=max_travel_m)
    return close_loop(motion, seam_s=seam_s)


def close_loop(motion: Motion, seam_s: float = 0.4) -> Motion:
    """The motion with its end warped onto its beginning.

    With e the pose one frame after the last, were the motion to go on as it does, each frame of
    the seam is turned and moved by a share of the way from e to frame 0 that grows smoothly from 0
    to 1: what the performer does there stays, and the gap closes. Height, heading and horizontal
    drift of the root close with it.

    Args:
        motion: A performance whose root comes back to nearly where it began.
        seam_s: Length of the seam; at most half of the motion is touched.
    """
    count = motion.num_frames
    seam = min(max(round(seam_s * motion.fps), 1), count // 2)
    share = _smooth(np.arange(1, seam + 1) / (seam + 1.0))
    root, local = motion.root_translation.copy(), motion.joint_rotations.copy()
    next_root = 2.0 * root[-1] - root[-2]
    step = quaternion_multiply(local[-1], quaternion_conjugate(local[-2]))
    next_local = quaternion_multiply(step, local[-1])
    gap = quaternion_multiply(quaternion_conjugate(next_local), local[0])
    partial = quaternion_slerp(_IDENTITY, gap, share[:, None])
    root[count - seam :] += share[:, None] * (root[0] - next_root)
    local[count - seam :] = quaternion_multiply(local[count - seam :], partial)
    note = f"seam of {seam / motion.fps:.1f} s blended"
    return _with_note(motion, root, local, note)


def out_and_back(
    motion: Motion, *, turn_s: float = 0.8, max_travel_m: float | None = None
) -> Motion:
    """The performance, a turn, the performance again on the way back, and a turn.

    The way back is the same clip turned by 180 degrees about +Y, started where the first pass
    ended. In each turn the heading turns through the angle that is left, always to the same side;
    pose and height blend from the end of a pass to the beginning of the next, and the root slows
    down and sets off again (a cubic with the speeds at both ends).

    Args:
        motion: A performance that travels.
        turn_s: Length of each turn.
        max_travel_m: Cut the performance where it is this far from its start, so that it fits
            into a room.
    """
    num_turn = max(round(turn_s * motion.fps), 2)
    root, local = motion.root_translation, motion.joint_rotations
    if max_travel_m is not None:
        away = np.linalg.norm((root - root[0]) * _FLOOR, axis=1)
        if away.max() > max_travel_m:
            stop = max(int(np.argmax(away > max_travel_m)), 2)
            root, local = root[:stop], local[:stop]
    half_turn = yaw_quaternion(np.pi)
    back_root = quaternion_rotate(half_turn, (root - root[0]) * _FLOOR) + root[-1] * _FLOOR
    back_root[:, 1] = root[:, 1]
    back_local = local.copy()
    back_local[:, 0] = quaternion_multiply(half_turn, local[:, 0])
    there = _turn(root, local, back_root, back_local, num_turn)
    home = _turn(back_root, back_local, root, local, num_turn)
    note = f"out and back, turns of {num_turn / motion.fps:.1f} s"
    if len(root) < motion.num_frames:
        note = f"first {len(root)} of {motion.num_frames} frames, {note}"
    return _with_note(
        motion,
        np.concatenate([root, there[0], back_root, home[0]]),
        np.concatenate([local, there[1], back_local, home[1]]),
        note,
    )


def seam_step(motion: Motion) -> tuple[float, float]:
    """How much more the step from the last frame to the first moves than the steps beside it.

    Returns:
        Excess of the fastest joint, metres, and of the fastest turn, radians; 0 for a cycle that
        cannot be told from its other frames.
    """
    positions = motion.joint_positions()
    ring = np.concatenate([positions[-4:], positions[:4]])
    moved = np.linalg.norm(np.diff(ring, axis=0), axis=-1)
    rotations = np.concatenate([motion.joint_rotations[-4:], motion.joint_rotations[:4]])
    cosine = np.abs(np.sum(rotations[1:] * rotations[:-1], axis=-1))
    turned = 2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))
    beside = [2, 4]
    return (
        float(np.max(moved[3] - moved[beside].max(axis=0)).clip(0.0)),
        float(np.max(turned[3] - turned[beside].max(axis=0)).clip(0.0)),
    )


def _net_travel(motion: Motion) -> float:
    """Horizontal distance of the root from the first to the last frame, metres."""
    way = (motion.root_translation[-1] - motion.root_translation[0]) * _FLOOR
    return float(np.linalg.norm(way))


def _turn(
    root: FloatArray,
    local: FloatArray,
    next_root: FloatArray,
    next_local: FloatArray,
    num_frames: int,
) -> tuple[FloatArray, FloatArray]:
    """Frames between the end of one pass and the beginning of the next."""
    time = np.arange(1, num_frames + 1) / (num_frames + 1.0)
    share = _smooth(time)
    start, end = root[-1], next_root[0]
    steps = num_frames + 1.0
    speed_in, speed_out = (root[-1] - root[-2]) * steps, (next_root[1] - next_root[0]) * steps
    t = time[:, None]
    between = (
        (2 * t**3 - 3 * t**2 + 1) * start
        + (t**3 - 2 * t**2 + t) * speed_in
        + (3 * t**2 - 2 * t**3) * end
        + (t**3 - t**2) * speed_out
    )
    between[:, 1] = start[1] + share * (end[1] - start[1])
    heading, next_heading = _heading(local[-1, 0]), _heading(next_local[0, 0])
    turned = quaternion_slerp(local[-1], next_local[0], share[:, None])
    upright = quaternion_multiply(yaw_quaternion(-heading), local[-1, 0])
    next_upright = quaternion_multiply(yaw_quaternion(-next_heading), next_local[0, 0])
    yaw = heading + share * np.mod(next_heading - heading, 2.0 * np.pi)
    turned[:, 0] = quaternion_multiply(
        yaw_quaternion(yaw), quaternion_slerp(upright, next_upright, share)
    )
    return between, turned


def _heading(rotation: FloatArray) -> float:
    """Yaw of the direction a pelvis rotation `(4,)` looks along."""
    forward = quaternion_rotate(rotation, [0.0, 0.0, 1.0])
    return float(np.arctan2(forward[0], forward[2]))


def _smooth(share: FloatArray) -> FloatArray:
    """Smoothstep: 0 to 1 with no speed at either end."""
    smooth: FloatArray = share * share * (3.0 - 2.0 * share)
    return smooth


def _with_note(motion: Motion, root: FloatArray, local: FloatArray, note: str) -> Motion:
    source = f"{motion.source}; {note}" if motion.source else note
    return dataclasses.replace(motion, root_translation=root, joint_rotations=local, source=source)
