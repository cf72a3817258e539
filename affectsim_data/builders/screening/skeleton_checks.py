"""Checks of a recording itself: do bones keep their lengths, are frames missing or repeated."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from affectsim_data.builders.screening.findings import Measure, sustained
from affectsim_data.builders.screening.limits import DroppedFrames, RepeatedFrames
from affectsim_data.motions.joint_frames import SourcePose
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS

__all__ = ["bone_asymmetry", "bone_drift", "dropped_frames", "repeated_frames"]

_SHORTEST_BONE_M = 0.03
"""Shorter ones, as between joints that files put into one place, have no length to keep."""
_RIGID = 1e-4
"""A length that changes by less than this share of it is that of one bone."""
_ROUNDING = 1e-6
"""Less than this share of a length is arithmetic."""


def bone_drift(source: SourcePose, joints: Mapping[str, str]) -> Measure:
    """How far a bone's length gets from its median over the clip, as a share of it."""
    worst = Measure(0.0)
    for child, lengths in _bones(source, joints).items():
        usual = float(np.median(lengths))
        if usual < _SHORTEST_BONE_M:
            continue
        drift = np.abs(lengths / usual - 1.0)
        frame = int(drift.argmax())
        if drift[frame] > max(worst.value, _ROUNDING):
            first = int(np.argmax(drift > 0.5 * drift[frame]))
            detail = f"the bone to {child} is {lengths[frame]:.3f} m long, usually {usual:.3f} m"
            worst = Measure(float(drift[frame]), first, child, detail)
    return worst


def bone_asymmetry(source: SourcePose, joints: Mapping[str, str]) -> Measure:
    """How much longer a bone is than that of the other side, as a share of the shorter one."""
    usual = {child: float(np.median(x)) for child, x in _bones(source, joints).items()}
    worst = Measure(0.0)
    for child, length in usual.items():
        other = usual.get(child.replace("left", "right"), 0.0)
        # Bones from the trunk to a limb hang on where files put their trunk joints.
        if not child.endswith(("knee", "ankle", "elbow", "wrist")) or "right" in child:
            continue
        shorter, longer = sorted((length, other))
        if shorter < _SHORTEST_BONE_M:
            continue
        if longer / shorter - 1.0 > max(worst.value, _ROUNDING):
            long_one = child if length > other else child.replace("left", "right")
            detail = f"the bone to {long_one} is {longer:.3f} m long, the other {shorter:.3f} m"
            worst = Measure(longer / shorter - 1.0, 0, long_one, detail)
    return worst


def repeated_frames(positions: FloatArray, fps: float, limits: RepeatedFrames) -> Measure:
    """Longest time in which no joint of `(num_frames, num_joints, 3)` moves at all, seconds."""
    still = np.linalg.norm(np.diff(positions, axis=0), axis=-1).max(axis=1) < limits.still_m
    if not still.any():
        return Measure(0.0)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(np.int8), [0]])))
    lengths = edges[1::2] - edges[::2]
    longest = int(lengths.argmax())
    count = int(lengths[longest])
    detail = f"{count + 1} frames on end hold the same pose"
    return Measure(count / fps, int(edges[2 * longest]), "", detail)


def dropped_frames(
    positions: FloatArray, fps: float, names: tuple[str, ...], limits: DroppedFrames
) -> Measure:
    """Largest jump of a joint between neighbouring frames, metres.

    A jump is how far a step is from the mean of the steps before and after, beyond what such
    differences amount to in the frames around: `background` times the largest of them.

    Args:
        positions: Of the joints, metres, `(num_frames, num_joints, 3)`.
        fps: Frames per second.
        names: Of the joints.
        limits: Thresholds.
    """
    reach = max(round(limits.around_s * fps), 3)
    if len(positions) < 2 * reach + 4:
        return Measure(0.0)
    steps = np.diff(positions, axis=0)
    jumps = np.linalg.norm(steps[1:-1] - 0.5 * (steps[:-2] + steps[2:]), axis=-1)
    padded = np.pad(jumps, ((reach, reach), (0, 0)))
    # A jump at t shows at t - 1 and t + 1 as well, so its surroundings begin 2 frames away.
    side = reach - 1
    largest = -sustained(-padded, side)
    count = len(jumps)
    before, after = largest[:count], largest[reach + 2 : reach + 2 + count]
    excess = jumps - limits.background * np.maximum(before, after)
    frame, joint = (int(i) for i in np.unravel_index(excess.argmax(), excess.shape))
    value = max(float(excess[frame, joint]), 0.0)
    detail = f"{names[joint]} jumps {jumps[frame, joint]:.3f} m from one frame to the next"
    return Measure(value, frame + 2, names[joint], detail)


def _bones(source: SourcePose, joints: Mapping[str, str]) -> dict[str, FloatArray]:
    """Length of the bone to each mapped joint from the nearest mapped one above, `(n,)` metres."""
    places = {
        name: source.joint_names.index(joints[name]) for name in JOINT_NAMES if name in joints
    }
    bones: dict[str, FloatArray] = {}
    for child, place in places.items():
        above = JOINT_PARENTS[JOINT_NAMES.index(child)]
        while above >= 0 and JOINT_NAMES[above] not in places:
            above = JOINT_PARENTS[above]
        if above >= 0:
            bones[child] = _bone_lengths(source, places[JOINT_NAMES[above]], place)
    return bones


def _bone_lengths(source: SourcePose, above: int, place: int) -> FloatArray:
    """Length of the bone from the joint `above` to the one at `place`, `(num_frames,)`.

    A map may skip joints, as the second one of a neck, and then the distance changes as they bend:
    the bone then begins at the nearest joint between the two that keeps its distance.
    """
    lengths: FloatArray = _distances(source, above, place)
    if _drift(lengths) <= _RIGID:
        return lengths
    between = [_distances(source, joint, place) for joint in range(above + 1, place)]
    rigid = [one for one in between if np.median(one) > _SHORTEST_BONE_M and _drift(one) <= _RIGID]
    return min(rigid, key=lambda one: float(np.median(one)), default=lengths)


def _drift(lengths: FloatArray) -> float:
    return float(np.ptp(lengths) / max(float(np.median(lengths)), _SHORTEST_BONE_M))


def _distances(source: SourcePose, one: int, other: int) -> FloatArray:
    away = source.positions[:, other] - source.positions[:, one]
    distances: FloatArray = np.linalg.norm(away, axis=1)
    return distances
