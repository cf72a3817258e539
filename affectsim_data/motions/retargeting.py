"""Takes motion of any humanoid skeleton to the 22-joint body, keeping where every limb points.

A source joint and its canonical joint are rigidly tied: `canonical = source @ offset`, a constant
rotation per joint, found in `joint_frames` from what bones do in the clip. So a zero pose that is
no T-pose, as in Bandai-Namco's files, does not matter.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.motions.bvh import BvhClip
from affectsim_data.motions.facing import face_forward
from affectsim_data.motions.hands import keep_hands
from affectsim_data.motions.joint_frames import LIMBS, SIDES, TRUNK, SourcePose, frame_offsets
from affectsim_data.motions.planting import (
    TOES,
    Stance,
    find_stances,
    plant_feet,
    stance_slides,
)
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
    standard_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS

__all__ = [
    "REQUIRED_JOINTS",
    "RetargetReport",
    "SourcePose",
    "resample",
    "retarget",
    "retarget_with_report",
    "source_pose",
]

REQUIRED_JOINTS = frozenset(
    {"pelvis", "head", *(f"{side}_{part}" for side in SIDES for limb in LIMBS for part in limb)}
)
"""Canonical joints a source must have; the rest is interpolated or stays straight."""


@dataclasses.dataclass(frozen=True)
class RetargetReport:
    """What retargeting did to a motion, for its provenance."""

    leg_scale: float
    """Leg of the canonical body by the source's; root motion is scaled by it."""
    num_stances: int
    """Times a foot was planted."""
    planted_frames: int
    """Source frames in which at least one foot was."""
    slide_before_m: float
    """Longest slide of a planted foot before it was locked."""
    slide_after_m: float
    """The same afterwards."""


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

    Limbs point as in the source, but for hands that touch and feet that stand. The hips move as
    the source's, scaled by leg length; planted feet stand on the floor and stay where they are;
    frame 0 has its pelvis over the origin and looks along +Z, where looking is the mean direction
    across hips and shoulders over the first frames.

    Args:
        source: The motion to take over.
        joints: Source joint of a canonical joint, by name.

    Returns:
        `root_translation` `(num_frames, 3)` in metres and `joint_rotations` `(num_frames, 22, 4)`.

    Raises:
        ValueError: The map names unknown joints, or lacks one of `REQUIRED_JOINTS`.
    """
    return retarget_with_report(source, joints)[:2]


def retarget_with_report(
    source: SourcePose, joints: Mapping[str, str]
) -> tuple[FloatArray, FloatArray, RetargetReport]:
    """What `retarget` returns, and what it did to get there."""
    index = _joint_indices(source, joints)
    root, local, scale = _transferred(source, index)
    feet = [index.get(f"{side}_foot", index[f"{side}_ankle"]) for side in SIDES]
    stances = find_stances(scale * source.positions[:, feet], source.fps)
    root, local = face_forward(root, local, stances)
    planted = plant_feet(root, local, stances, fps=source.fps)
    return *planted, _report(source, scale, stances, (root, local), planted)


def resample(
    root_translation: FloatArray, joint_rotations: FloatArray, *, fps: float, target_fps: float
) -> tuple[FloatArray, FloatArray]:
    """The same motion at another rate: the root moves linearly, joints turn by the shorter way.

    Poses are taken at their instants, not averaged: planted feet stay planted and contacts stay
    contacts. Little can alias: in 120 Hz captures what is faster than 15 Hz moves joints by 0.1 to
    2 mm (root mean square), and a low-pass at 12 Hz changes the jerk of hands by 3 % on average.
    """
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


def _transferred(source: SourcePose, index: dict[str, int]) -> tuple[FloatArray, FloatArray, float]:
    """Root and joint rotations with limbs pointing as in the source, and the leg scale."""
    offsets = frame_offsets(source, index)
    world = np.zeros((source.num_frames, NUM_JOINTS, 4))
    for name, offset in offsets.items():
        rotations = source.rotations[:, index[name]]
        world[:, JOINT_NAMES.index(name)] = quaternion_multiply(rotations, offset)
    _fill_unmapped(world, set(offsets))
    local = world.copy()
    local[:, 1:] = quaternion_multiply(
        quaternion_conjugate(world[:, list(JOINT_PARENTS[1:])]), world[:, 1:]
    )
    scale = float(_leg_length(BODY.rest_positions, {n: i for i, n in enumerate(JOINT_NAMES)}))
    scale /= float(np.median(_leg_length(source.positions, index)))
    hips = source.positions[:, [index["left_hip"], index["right_hip"]]].mean(axis=1)
    rest = BODY.joint_offsets[[JOINT_NAMES.index(f"{side}_hip") for side in SIDES]].mean(axis=0)
    root: FloatArray = scale * hips - quaternion_rotate(world[:, 0], rest)
    wrists = scale * source.positions[:, [index[f"{side}_wrist"] for side in SIDES]]
    head = scale * source.positions[:, index["head"]]
    local = keep_hands(root, local, wrists, head, fps=source.fps)
    return root, standard_quaternion(local), scale


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


def _leg_length(positions: FloatArray, index: Mapping[str, int]) -> FloatArray:
    """Thigh plus shank, mean of both legs, of joint positions `(..., num_joints, 3)`."""
    chains = [[index[f"{side}_{part}"] for part in ("hip", "knee", "ankle")] for side in SIDES]
    bones = np.diff(positions[..., chains, :], axis=-2)
    length: FloatArray = np.linalg.norm(bones, axis=-1).sum(axis=-1).mean(axis=-1)
    return length


def _report(
    source: SourcePose,
    scale: float,
    stances: Sequence[Stance],
    before: tuple[FloatArray, FloatArray],
    after: tuple[FloatArray, FloatArray],
) -> RetargetReport:
    planted = np.zeros(source.num_frames, bool)
    for stance in stances:
        planted[stance.start : stance.stop] = True
    slides = [
        stance_slides(BODY.forward_kinematics(*motion)[0][:, TOES], stances)
        for motion in (before, after)
    ]
    most = [float(slide.max(initial=0.0)) for slide in slides]
    return RetargetReport(scale, len(stances), int(planted.sum()), most[0], most[1])
