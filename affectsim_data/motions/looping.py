"""Closes performances into cycles, because motions are played cyclically.

`close_loop` serves whoever stays in place: the performance is ended where it is most like its
beginning, and over the last moments pose and position are warped by what is still lacking, so
that the last frame leads into the first. Feet are not warped along: they stand, or make a step.
`out_and_back` serves whoever walks off: warping would drag the person metres over the floor, so
the way is walked back, with a turn in real steps at both ends, and the cycle ends where it began.
Both say in `source` and `provenance` what was done, and `Motion.original()` undoes it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.motions.easing import smooth_step
from affectsim_data.motions.motion import Motion, Uncut
from affectsim_data.motions.planting import (
    ANKLES,
    TOE_OFFSET,
    TOES,
    find_stances,
    move_feet,
)
from affectsim_data.motions.turning import turn_back, walk_home
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY

__all__ = ["close_loop", "common_end", "make_cyclic", "out_and_back", "seam_step"]

TRAVEL_MIN_M = 0.5
"""Net displacement from which a performance counts as travelling."""
_FLOOR = np.array([1.0, 0.0, 1.0])
_IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
_LEAST_FRAMES = 3
_WALKING_M_S = 0.4
"""Whoever is this fast at either end is on their way, and no seam can be blended."""

_TRIM_SHARE, _TRIM_MOST_S, _SWING_BACK_S = 0.2, 1.0, 0.5
_TRIM_COST_M_S = 0.02
"""How much nearer, on average over the joints, an end must come for a second that is given up."""
_SPEED_S = 0.15
"""Weighs differences in speed against differences in place."""
_STEP_S, _STEP_LIFT_M, _NEAR_END_S = 0.4, 0.04, 0.1
_SAME_PLACE_M, _SAME_TURN = 0.005, np.deg2rad(3.0)
"""A planted foot that is nearer to its beginning than that needs no step to get there."""


def make_cyclic(
    motion: Motion, *, max_travel_m: float | None = None, seam_s: float = 0.4
) -> Motion:
    """The motion as a closed cycle: out and back if it travels, else with a blended seam.

    Raises:
        ValueError: It has fewer than three frames.
    """
    if _net_travel(motion) > TRAVEL_MIN_M:
        return out_and_back(motion, max_travel_m=max_travel_m)
    return close_loop(motion, seam_s=seam_s)


def close_loop(motion: Motion, seam_s: float = 0.4, *, num_frames: int | None = None) -> Motion:
    """The motion with its end warped onto its beginning, or walked there if it ends in a walk.

    At most the last fifth, or second, is given up if that brings the end nearer to the beginning.
    With e the pose one frame after the last, were the motion to go on as it does, each frame of
    the seam is turned and moved by a share of the way from e to frame 0 that grows smoothly from 0
    to 1: what the performer does there stays, and the gap closes. A foot that stands at both ends
    but not in the same place makes a step; the seam is made longer for it.

    Args:
        motion: A performance whose root comes back to nearly where it began.
        seam_s: Length of the seam; at most half of the motion is touched.
        num_frames: How many frames to keep, for motions that must stay in step; then nothing is
            walked home.

    Raises:
        ValueError: It has fewer than three frames, or than are to be kept.
    """
    _check_length(motion)
    if num_frames is None and _speed_at_ends(motion) > _WALKING_M_S:
        return _walked_home(motion)
    count = common_end([motion]) if num_frames is None else num_frames
    if not _LEAST_FRAMES <= count <= motion.num_frames:
        raise ValueError(
            f"motion {motion.motion_id!r}: num_frames must be from {_LEAST_FRAMES} to "
            f"{motion.num_frames}, got {count}"
        )
    root, local = motion.root_translation[:count], motion.joint_rotations[:count]
    positions, world = BODY.forward_kinematics(root, local)
    planted = _planted(positions[:, TOES], motion.fps)
    gaps = _foot_gaps(positions, world)
    stands = _stands(planted, motion.fps)
    stepping = [foot for foot in (0, 1) if stands[foot] and gaps[foot]]
    seam = min(max(round(max(seam_s, _STEP_S * len(stepping)) * motion.fps), 1), count // 2)
    seamed = _warped(root, local, seam)
    if stands.any() or planted[-seam:].any():
        feet = _SeamFeet(positions, world, planted, stands, stepping)
        seamed = _with_feet(seamed, feet, seam, motion.fps)
    note = f"seam of {seam / motion.fps:.1f} s blended"
    if count < motion.num_frames:
        note = f"first {count} of {motion.num_frames} frames, {note}"
    loop = {"kind": "seam", "frames": [count - seam, count], "used_frames": count}
    return _cycle(motion, *seamed, loop, note)


def out_and_back(motion: Motion, *, max_travel_m: float | None = None) -> Motion:
    """The performance, a turn, the performance again on the way back, and a turn.

    The way back is the same clip turned by 180 degrees about +Y. The turns, 1 to 2.5 s long, take
    real steps, and up to half a metre beyond the way and beside it.

    Args:
        motion: A performance that travels.
        max_travel_m: Cut the performance where it is this far from its start, so that it fits
            into a room. It ends in the middle of a step, so up to half a second earlier.

    Raises:
        ValueError: It has fewer than three frames.
    """
    _check_length(motion)
    count = motion.num_frames
    if max_travel_m is not None:
        way = (motion.root_translation - motion.root_translation[0]) * _FLOOR
        far = np.linalg.norm(way, axis=1) >= max_travel_m
        count = max(int(np.argmax(far)) + 1, _LEAST_FRAMES) if far.any() else count
    count = _mid_swing(motion, count)
    root, local = motion.root_translation[:count], motion.joint_rotations[:count]
    turn, back = turn_back(root, local, fps=motion.fps)
    half = yaw_quaternion(np.pi)
    # The second turn is the first one, turned as the way back is.
    shift = back[0][0] - quaternion_rotate(half, root[0])
    home_root = quaternion_rotate(half, turn[0]) + shift
    home_local = turn[1].copy()
    home_local[:, 0] = quaternion_multiply(half, turn[1][:, 0])
    note = f"out and back, turns of {len(turn[0]) / motion.fps:.1f} s"
    if len(root) < motion.num_frames:
        note = f"first {len(root)} of {motion.num_frames} frames, {note}"
    loop = {
        "kind": "out_and_back",
        "frames": [len(root), 2 * len(root) + 2 * len(turn[0])],
        "turn_frames": len(turn[0]),
        "used_frames": len(root),
    }
    roots = np.concatenate([root, turn[0], back[0], home_root])
    locals_ = np.concatenate([local, turn[1], back[1], home_local])
    return _cycle(motion, roots, locals_, loop, note)


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


def _check_length(motion: Motion) -> None:
    if motion.num_frames < _LEAST_FRAMES:
        raise ValueError(
            f"motion {motion.motion_id!r}: a cycle needs {_LEAST_FRAMES} frames or more, "
            f"got {motion.num_frames}; leave the file out"
        )


def _net_travel(motion: Motion) -> float:
    """Horizontal distance of the root from the first to the last frame, metres."""
    way = (motion.root_translation[-1] - motion.root_translation[0]) * _FLOOR
    return float(np.linalg.norm(way))


def _speed_at_ends(motion: Motion) -> float:
    """How fast the root moves over the floor in the first or last half second, m/s."""
    root = motion.root_translation * _FLOOR
    frames = min(round(0.5 * motion.fps), motion.num_frames - 1)
    ways = root[frames] - root[0], root[-1] - root[-1 - frames]
    return max(float(np.linalg.norm(way)) for way in ways) * motion.fps / frames


def _walked_home(motion: Motion) -> Motion:
    """The motion, and the steps that lead from its end to its beginning."""
    root, local = motion.root_translation, motion.joint_rotations
    steps = walk_home(root, local, fps=motion.fps)
    count = len(steps[0])
    note = f"walked home in {count / motion.fps:.1f} s"
    loop = {
        "kind": "walked_home",
        "frames": [len(root), len(root) + count],
        "turn_frames": count,
        "used_frames": len(root),
    }
    root, local = np.concatenate([root, steps[0]]), np.concatenate([local, steps[1]])
    return _cycle(motion, root, local, loop, note)


def common_end(motions: Sequence[Motion]) -> int:
    """How many frames to keep, so that what would come next is most like the first frame.

    At most the last fifth, or second, is given up.

    Args:
        motions: What is performed together: as many frames each, at one rate.
    """
    motion = motions[0]
    count = motion.num_frames
    spare = int(min(_TRIM_SHARE * count, _TRIM_MOST_S * motion.fps, count - _LEAST_FRAMES))
    positions = np.concatenate([one.joint_positions() for one in motions], axis=1)
    positions = np.concatenate([positions, 2.0 * positions[-1:] - positions[-2:-1]])
    ends = np.arange(count - spare, count + 1)
    speeds = np.diff(positions, axis=0) * motion.fps
    apart = np.linalg.norm(positions[ends] - positions[0], axis=-1)
    unlike = np.linalg.norm(speeds[ends - 1] - speeds[0], axis=-1)
    cost = (apart + _SPEED_S * unlike).mean(axis=1)
    cost += _TRIM_COST_M_S * (count - ends) / motion.fps
    return int(ends[np.argmin(cost)])


def _mid_swing(motion: Motion, count: int) -> int:
    """How many of `count` frames to keep, so that the last foot in the air passes the body.

    From there a foot can be put down anywhere; one about to land would have to be taken back.
    """
    spare = int(min(_TRIM_SHARE * count, _SWING_BACK_S * motion.fps, count - _LEAST_FRAMES))
    positions = motion.joint_positions()[:count]
    planted = _planted(positions[:, TOES], motion.fps)
    forward = quaternion_rotate(motion.joint_rotations[:count, 0], [0.0, 0.0, 1.0])
    feet = positions[:, ANKLES] - positions[:, :1]
    ahead = np.abs(np.sum(feet * (forward * _FLOOR)[:, None], axis=-1))
    ahead = np.where(planted, 0.0, ahead).sum(axis=1)
    ahead = np.where(planted.sum(axis=1) == 1, ahead, np.inf)[count - 1 - spare :]
    if not np.isfinite(ahead).any():
        return count
    return count - spare + int(np.argmin(ahead))


def _planted(toes: FloatArray, fps: float) -> NDArray[np.bool_]:
    """Whether each foot is planted, `(num_frames, 2)`."""
    planted = np.zeros((len(toes), 2), bool)
    for stance in find_stances(toes, fps):
        planted[stance.start : stance.stop, stance.foot] = True
    return planted


def _stands(planted: NDArray[np.bool_], fps: float) -> NDArray[np.bool_]:
    """Feet planted within a tenth of a second of both ends, `(2,)`."""
    near = max(round(_NEAR_END_S * fps), 1)
    return np.asarray(planted[:near].any(axis=0) & planted[-near:].any(axis=0))


def _foot_gaps(positions: FloatArray, world: FloatArray) -> NDArray[np.bool_]:
    """Whether each foot ends elsewhere, or turned otherwise, than it begins, `(2,)`."""
    apart = np.linalg.norm(positions[-1, TOES] - positions[0, TOES], axis=-1)
    cosine = np.abs(np.sum(world[-1, ANKLES] * world[0, ANKLES], axis=-1))
    turned = 2.0 * np.arccos(np.clip(cosine, 0.0, 1.0))
    gaps: NDArray[np.bool_] = (apart > _SAME_PLACE_M) | (turned > _SAME_TURN)
    return gaps


def _warped(root: FloatArray, local: FloatArray, seam: int) -> tuple[FloatArray, FloatArray]:
    """The last `seam` frames turned and moved towards frame 0."""
    count = len(root)
    share = smooth_step(np.arange(1, seam + 1) / (seam + 1.0))
    root, local = root.copy(), local.copy()
    next_root = 2.0 * root[-1] - root[-2]
    step = quaternion_multiply(local[-1], quaternion_conjugate(local[-2]))
    next_local = quaternion_multiply(step, local[-1])
    gap = quaternion_multiply(quaternion_conjugate(next_local), local[0])
    partial = quaternion_slerp(_IDENTITY, gap, share[:, None])
    root[count - seam :] += share[:, None] * (root[0] - next_root)
    local[count - seam :] = quaternion_multiply(local[count - seam :], partial)
    return root, local


@dataclasses.dataclass(frozen=True)
class _SeamFeet:
    """Feet of a motion before its end is warped."""

    positions: FloatArray
    """Of all joints, metres, `(num_frames, 22, 3)`."""
    world: FloatArray
    """World rotations of all joints, `(num_frames, 22, 4)`."""
    planted: NDArray[np.bool_]
    """`(num_frames, 2)`."""
    stands: NDArray[np.bool_]
    """Feet that are planted at both ends, `(2,)`."""
    stepping: list[int]
    """Those of them that make a step, one after the other."""


def _with_feet(
    warped: tuple[FloatArray, FloatArray], before: _SeamFeet, seam: int, fps: float
) -> tuple[FloatArray, FloatArray]:
    """The warped motion with feet that stand or step in its last `seam` frames: none slides."""
    root, local = (part[-seam:] for part in warped)
    positions, world = BODY.forward_kinematics(root, local)
    toes, feet = positions[:, TOES], world[:, ANKLES]
    for foot in (0, 1):
        stood = before.positions[-seam:, TOES[foot]], before.world[-seam:, ANKLES[foot]]
        goal = toes[:, foot], feet[:, foot]
        start, stop = 0, seam + 1
        if before.stands[foot]:
            goal = before.positions[0, TOES[foot]], before.world[0, ANKLES[foot]]
            if foot in before.stepping:
                start, stop = (
                    (before.stepping.index(foot) + after) * (seam + 1) // len(before.stepping)
                    for after in (0, 1)
                )
        elif before.planted[-seam:, foot].any():
            start = min(int(np.flatnonzero(before.planted[-seam:, foot])[-1]), seam // 2)
        share = np.clip((np.arange(1, seam + 1) - start) / max(stop - start, 1), 0.0, 1.0)
        eased = smooth_step(share)
        toes[:, foot] = stood[0] + eased[:, None] * (goal[0] - stood[0])
        feet[:, foot] = quaternion_slerp(stood[1], np.broadcast_to(goal[1], stood[1].shape), eased)
        if foot in before.stepping:
            toes[:, foot, 1] += _STEP_LIFT_M * np.sin(np.pi * share) ** 2
    ankles = toes - quaternion_rotate(feet, TOE_OFFSET)
    standing = np.ones((seam, 2), bool)
    moved = move_feet(root, local, ankles, feet, standing, fps=fps, fade=True)
    for whole, part in zip(warped, moved, strict=True):
        whole[-seam:] = part
    return warped


def _cycle(
    motion: Motion, root: FloatArray, local: FloatArray, loop: Mapping[str, object], note: str
) -> Motion:
    """The closed motion, which remembers the frames of the original that it lacks."""
    shared = min(motion.num_frames, len(root))
    same = (root[:shared] == motion.root_translation[:shared]).all(axis=1)
    same &= (local[:shared] == motion.joint_rotations[:shared]).all(axis=(1, 2))
    kept = shared if same.all() else int(np.argmin(same))
    uncut = Uncut(
        *(0, 0, kept),
        root_translation=motion.root_translation[kept:].copy(),
        joint_rotations=motion.joint_rotations[kept:].copy(),
    )
    source = f"{motion.source}; {note}" if motion.source else note
    return dataclasses.replace(
        motion,
        root_translation=root,
        joint_rotations=local,
        source=source,
        provenance={**motion.provenance, "loop": {**loop, "note": note}},
        uncut=uncut,
    )
