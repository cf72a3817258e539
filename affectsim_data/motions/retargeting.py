"""Takes motion of any humanoid skeleton to the 22-joint body, keeping where every limb points.

A source joint and its canonical joint are rigidly tied: `canonical = source @ offset`, a constant
rotation per joint, found in `joint_frames` from what bones do in the clip. So a zero pose that is
no T-pose, as in Bandai-Namco's files, does not matter.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from affectsim_data.motions.bvh import BvhClip
from affectsim_data.motions.joint_frames import LIMBS, SIDES, TRUNK, SourcePose, frame_offsets
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
    standard_quaternion,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS

__all__ = ["REQUIRED_JOINTS", "SourcePose", "resample", "retarget", "source_pose"]

REQUIRED_JOINTS = frozenset(
    {"pelvis", "head", *(f"{side}_{part}" for side in SIDES for limb in LIMBS for part in limb)}
)
"""Canonical joints a source must have; the rest is interpolated or stays straight."""

_FACING_FRAMES = 10
_CONTACT_PERCENTILE = 20.0
"""Of the lower foot's clearance: half way between flat feet and toes that push off, which would
otherwise float or sink by 2 cm."""


def source_pose(clip: BvhClip, *, metres_per_unit: float, up_axis: str = "y") -> SourcePose:
    """A BVH clip in metres with +Y up.

    Raises:
        ValueError: `up_axis` is neither `y` nor `z`.
    """
    if up_axis not in ("y", "z"):
        raise ValueError(f"up_axis must be 'y' or 'z', got {up_axis!r}")
    positions, rotations = clip.world()
    zero = clip.local_positions()[0]
    for joint, parent in enumerate(clip.joint_parents):
        if parent >= 0:
            zero[joint] += zero[parent]
    up = np.array([0.0, 1.0, 0.0])
    if up_axis == "z":
        up = np.array([0.0, 0.0, 1.0])
        upright = axis_angle_quaternion([1.0, 0.0, 0.0], -np.pi / 2.0)
        positions = quaternion_rotate(upright, positions)
        rotations = quaternion_multiply(upright, rotations)
    return SourcePose(
        clip.joint_names,
        positions * metres_per_unit,
        rotations,
        zero * metres_per_unit,
        up,
        1.0 / clip.frame_time_s,
    )


def retarget(source: SourcePose, joints: Mapping[str, str]) -> tuple[FloatArray, FloatArray]:
    """The motion on the canonical body, in the performance frame.

    Limbs point as in the source. The hips move as the source's, scaled by leg length; the lowest
    foot stands on the floor; frame 0 has its pelvis over the origin and looks along +Z, where
    looking is the mean direction across hips and shoulders over the first frames.

    Args:
        source: The motion to take over.
        joints: Source joint of a canonical joint, by name.

    Returns:
        `root_translation` `(num_frames, 3)` in metres and `joint_rotations` `(num_frames, 22, 4)`.

    Raises:
        ValueError: The map names unknown joints, or lacks one of `REQUIRED_JOINTS`.
    """
    index = _joint_indices(source, joints)
    offsets = frame_offsets(source, index)
    world = np.zeros((source.num_frames, NUM_JOINTS, 4))
    for name, offset in offsets.items():
        rotations = source.rotations[:, index[name]]
        world[:, JOINT_NAMES.index(name)] = quaternion_multiply(rotations, offset)
    _fill_unmapped(world, set(offsets))
    local = world.copy()
    for joint, parent in enumerate(JOINT_PARENTS):
        if parent >= 0:
            local[:, joint] = quaternion_multiply(
                quaternion_conjugate(world[:, parent]), world[:, joint]
            )
    root = _root_translation(source, index, world[:, 0])
    return _face_forward(root, standard_quaternion(local))


def resample(
    root_translation: FloatArray, joint_rotations: FloatArray, *, fps: float, target_fps: float
) -> tuple[FloatArray, FloatArray]:
    """The same motion at another rate: the root moves linearly, joints turn by the shorter way."""
    # 1 / 0.0333333 is 30 fps to whoever wrote the file.
    if abs(fps / target_fps - 1.0) < 1e-3:
        return root_translation, joint_rotations
    last = len(root_translation) - 1
    position = np.arange(int(last / fps * target_fps + 1e-6) + 1) * (fps / target_fps)
    before = np.minimum(position.astype(np.intp), max(last - 1, 0))
    after = np.minimum(before + 1, last)
    share = position - before
    root = root_translation[before]
    root = root + share[:, None] * (root_translation[after] - root)
    turned = quaternion_slerp(joint_rotations[before], joint_rotations[after], share[:, None])
    return root, turned


def _joint_indices(source: SourcePose, joints: Mapping[str, str]) -> dict[str, int]:
    """Index in the source of each mapped canonical joint."""
    unknown = sorted(set(joints) - set(JOINT_NAMES))
    if unknown:
        raise ValueError(f"joint map: {unknown} are not body joints; use {list(JOINT_NAMES)}")
    lacking = sorted(REQUIRED_JOINTS - set(joints))
    if lacking:
        raise ValueError(f"joint map: expected a source joint for {lacking}")
    absent = sorted(set(joints.values()) - set(source.joint_names))
    if absent:
        raise ValueError(f"joint map names {absent}; the file has {list(source.joint_names)}")
    return {name: source.joint_names.index(joints[name]) for name in JOINT_NAMES if name in joints}


def _fill_unmapped(world: FloatArray, mapped: set[str]) -> None:
    """Spine joints without a source share the bend between neighbours; others follow the parent."""
    known = {JOINT_NAMES.index(name) for name in mapped}
    trunk = [JOINT_NAMES.index(name) for name in TRUNK]
    for joint, parent in enumerate(JOINT_PARENTS):
        if joint in known:
            continue
        world[:, joint] = world[:, parent]
        above = [j for j in trunk if j in known and j > joint]
        if joint in trunk and above:
            steps = trunk.index(above[0]) - trunk.index(parent)
            share = np.full(len(world), 1.0 / steps)
            world[:, joint] = quaternion_slerp(world[:, parent], world[:, above[0]], share)


def _root_translation(
    source: SourcePose, index: dict[str, int], pelvis_rotations: FloatArray
) -> FloatArray:
    """Pelvis of the canonical body with its hips where the source's are, scaled, `(n, 3)`."""
    hips = source.positions[:, [index["left_hip"], index["right_hip"]]].mean(axis=1)
    rest = BODY.joint_offsets[[JOINT_NAMES.index(f"{side}_hip") for side in SIDES]].mean(axis=0)
    scale = _leg_length(BODY.rest_positions, {n: i for i, n in enumerate(JOINT_NAMES)})
    scale /= float(np.median(_leg_length(source.positions, index)))
    root: FloatArray = scale * hips - quaternion_rotate(pelvis_rotations, rest)
    return root


def _leg_length(positions: FloatArray, index: Mapping[str, int]) -> FloatArray:
    """Thigh plus shank, mean of both legs, of joint positions `(..., num_joints, 3)`."""
    chains = [[index[f"{side}_{part}"] for part in ("hip", "knee", "ankle")] for side in SIDES]
    bones = np.diff(positions[..., chains, :], axis=-2)
    length: FloatArray = np.linalg.norm(bones, axis=-1).sum(axis=-1).mean(axis=-1)
    return length


def _face_forward(root: FloatArray, local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The motion in its performance frame: on the floor, over the origin, looking along +Z."""
    positions = BODY.forward_kinematics(root, local)[0]
    column = JOINT_NAMES.index
    feet = [column(f"{side}_{part}") for side in SIDES for part in ("ankle", "foot")]
    clearance = (positions[:, feet, 1] - BODY.rest_positions[feet, 1]).min(axis=1)
    left, right = ([column(f"{side}_{part}") for part in ("hip", "shoulder")] for side in SIDES)
    across = (positions[:_FACING_FRAMES, left] - positions[:_FACING_FRAMES, right]).mean(
        axis=(0, 1)
    )
    turn = yaw_quaternion(np.arctan2(across[2], across[0]))
    start = root[0] * np.array([1.0, 0.0, 1.0])
    start[1] = np.percentile(clearance, _CONTACT_PERCENTILE)
    turned = local.copy()
    turned[:, 0] = quaternion_multiply(turn, local[:, 0])
    return quaternion_rotate(turn, root - start), standard_quaternion(turned)
