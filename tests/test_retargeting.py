"""Retargeting: directions kept, left stays left, feet stand, clasped hands stay clasped."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from real_clips import real_clips
from walkers import walker

from affectsim_data.builders.corpora import load_recipe
from affectsim_data.motions import Motion
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.planting import TOES, find_stances, stance_slides
from affectsim_data.motions.retargeting import (
    SourcePose,
    resample,
    retarget,
    retarget_with_report,
    source_pose,
)
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    matrix_quaternion,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

SAME_NAMES = {name: name for name in JOINT_NAMES}
LIMB_BONES = [
    (f"{side}_{start}", f"{side}_{end}")
    for side in ("left", "right")
    for start, end in (
        ("shoulder", "elbow"),
        ("elbow", "wrist"),
        ("hip", "knee"),
        ("knee", "ankle"),
    )
]


def column(name: str) -> int:
    return JOINT_NAMES.index(name)


def as_source(motion: Motion, frames: FloatArray | None = None) -> SourcePose:
    """The canonical body itself as a source; `frames` turns each joint frame away, `(22, 4)`."""
    positions, rotations = BODY.forward_kinematics(motion.root_translation, motion.joint_rotations)
    zero = BODY.rest_positions
    if frames is not None:
        rotations = quaternion_multiply(rotations, frames)
        zero = np.zeros_like(zero)
    return SourcePose(JOINT_NAMES, positions, rotations, zero, np.array([0.0, 1.0, 0.0]), 30.0)


def bone(positions: FloatArray, start: int, end: int) -> FloatArray:
    vectors = positions[:, end] - positions[:, start]
    unit: FloatArray = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    return unit


def degrees_between(a: FloatArray, b: FloatArray) -> float:
    return float(np.rad2deg(np.arccos(np.clip((a * b).sum(axis=1), -1.0, 1.0))).max())


def test_retargeting_the_body_to_itself_changes_no_limb() -> None:
    motion = walker()
    root, rotations = retarget(as_source(motion), SAME_NAMES)
    found = BODY.forward_kinematics(root, rotations)[0]
    expected = motion.joint_positions()
    for start, end in LIMB_BONES:
        pair = column(start), column(end)
        assert degrees_between(bone(found, *pair), bone(expected, *pair)) < 1.0
    assert np.abs(found - expected).max() < 0.01


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_frames_a_source_gives_its_joints_do_not_matter(seed: int) -> None:
    motion = walker()
    rng = np.random.default_rng(seed)
    limbs = [column(f"{s}_{n}") for s in ("left", "right") for n in ("shoulder", "hip", "collar")]
    frames = np.tile([1.0, 0.0, 0.0, 0.0], (22, 1))
    for joint in limbs:
        turn = matrix_quaternion(np.linalg.qr(rng.normal(size=(3, 3)))[0])
        chain = [joint]
        if joint not in (column("left_collar"), column("right_collar")):
            # Frames of a limb agree where nothing bends: one turn for all of it.
            side, part = JOINT_NAMES[joint].split("_")
            names = ("elbow", "wrist") if part == "shoulder" else ("knee", "ankle", "foot")
            chain += [column(f"{side}_{name}") for name in names]
        frames[chain] = turn
    plain = retarget(as_source(motion, np.tile([1.0, 0.0, 0.0, 0.0], (22, 1))), SAME_NAMES)
    turned = retarget(as_source(motion, frames), SAME_NAMES)
    np.testing.assert_allclose(turned[0], plain[0], atol=1e-9)
    np.testing.assert_allclose(np.abs((turned[1] * plain[1]).sum(-1)), 1.0, atol=1e-9)


def test_size_and_heading_of_the_source_do_not_matter() -> None:
    source = as_source(walker())
    turn = yaw_quaternion(2.1)
    moved = dataclasses.replace(
        source,
        positions=1.3 * quaternion_rotate(turn, source.positions) + [4.0, 0.7, -2.0],
        rotations=quaternion_multiply(turn, source.rotations),
    )
    expected, found = retarget(source, SAME_NAMES), retarget(moved, SAME_NAMES)
    np.testing.assert_allclose(found[0], expected[0], atol=1e-9)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-9)


def test_unmapped_spine_joints_share_the_bend() -> None:
    motion = walker()
    few = {k: v for k, v in SAME_NAMES.items() if k not in ("spine1", "spine2", "left_foot")}
    _, rotations = retarget(as_source(motion), few)
    identity = np.array([1.0, 0.0, 0.0, 0.0])
    np.testing.assert_allclose(
        rotations[:, column("spine1")], rotations[:, column("spine2")], atol=1e-9
    )
    np.testing.assert_allclose(rotations[:, column("left_foot")] - identity, 0.0, atol=1e-9)


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({**SAME_NAMES, "tail": "pelvis"}, r"joint map: \['tail'\] are not body joints"),
        ({**SAME_NAMES, "head": "Kopf"}, r"joint map names \['Kopf'\]; the file has"),
        ({"pelvis": "pelvis"}, r"expected a source joint for \['head', 'left_ankle'"),
    ],
)
def test_a_wrong_joint_map_is_named(joints: dict[str, str], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        retarget(as_source(walker()), joints)


def test_resampling_keeps_duration_and_ends() -> None:
    motion = walker()
    root, rotations = resample(
        motion.root_translation, motion.joint_rotations, fps=120.0, target_fps=30.0
    )
    assert len(root) == (motion.num_frames - 1) // 4 + 1
    np.testing.assert_allclose(root, motion.root_translation[::4], atol=1e-12)
    np.testing.assert_allclose(rotations, motion.joint_rotations[::4], atol=1e-9)


@pytest.mark.parametrize("fps", [120.0, 125.0])
def test_resampling_keeps_planted_feet_planted(fps: float) -> None:
    motion = walker(fps=fps)
    root, rotations = resample(
        motion.root_translation, motion.joint_rotations, fps=fps, target_fps=30.0
    )
    toes = BODY.forward_kinematics(root, rotations)[0][:, TOES]
    stances = find_stances(toes, 30.0)
    assert len(stances) >= 7
    assert stance_slides(toes, stances).max() < 1e-3


def test_clasped_hands_stay_clasped_on_broader_shoulders() -> None:
    """Bandai-Namco's shoulders are 21 cm apart, the body's 36."""
    narrow = dataclasses.replace(BODY, joint_offsets=BODY.joint_offsets.copy())
    for side in ("left", "right"):
        narrow.joint_offsets[column(f"{side}_shoulder"), 0] *= 0.2
    local = np.zeros((60, 22, 4))
    local[..., 0] = 1.0
    for side, sign in (("left", 1.0), ("right", -1.0)):
        down = axis_angle_quaternion([0.0, 0.0, 1.0], -1.2 * sign)
        inward = axis_angle_quaternion([1.0, 0.0, 0.0], 0.6)
        local[:, column(f"{side}_shoulder")] = quaternion_multiply(down, inward)
        bent = axis_angle_quaternion([0.0, 1.0, 0.0], -1.5 * sign)
        local[:, column(f"{side}_elbow")] = bent
    root = np.tile(BODY.joint_offsets[0], (60, 1))
    positions, world = narrow.forward_kinematics(root, local)
    source = SourcePose(
        JOINT_NAMES, positions, world, narrow.rest_positions, np.array([0.0, 1.0, 0.0]), 30.0
    )
    wrists = [column("left_wrist"), column("right_wrist")]
    apart = np.linalg.norm(np.diff(positions[0, wrists], axis=0))
    assert apart < 0.16
    found = BODY.forward_kinematics(*retarget(source, SAME_NAMES))[0]
    assert np.linalg.norm(np.diff(found[30, wrists], axis=0)) == pytest.approx(apart, abs=0.01)


def test_the_report_says_what_was_done() -> None:
    motion = walker()
    source = as_source(motion)
    source = dataclasses.replace(source, positions=1.25 * source.positions)
    *_, report = retarget_with_report(source, SAME_NAMES)
    assert report.leg_scale == pytest.approx(0.8)
    assert report.num_stances >= 7
    assert 0.8 * motion.num_frames < report.planted_frames <= motion.num_frames
    assert report.slide_after_m < 1e-3


@pytest.mark.realdata
def test_real_limbs_point_as_in_the_source(realdata: Path) -> None:
    for name, source, joints in real_clips(realdata):
        root, rotations = retarget(source, joints)
        found = BODY.forward_kinematics(root, rotations)[0]
        index = {joint: source.joint_names.index(own) for joint, own in joints.items()}
        bones = [
            (
                bone(source.positions, index[start], index[end]),
                bone(found, column(start), column(end)),
            )
            for start, end in LIMB_BONES
        ]
        # The figure is turned to face +Z as a whole; the turn is found from the limbs themselves.
        # Touching hands and standing feet move limbs, most frames of most limbs do not.
        before, after = (np.concatenate(parts) for parts in zip(*bones, strict=True))
        z_before, z_after = before[:, 2] + 1j * before[:, 0], after[:, 2] + 1j * after[:, 0]
        turn = yaw_quaternion(np.angle((z_before.conj() * z_after).sum()))
        turned = np.sum(quaternion_rotate(turn, before) * after, axis=1)
        off = np.rad2deg(np.arccos(np.clip(turned, -1.0, 1.0)))
        off = off.reshape(len(LIMB_BONES), -1)
        legs = ["hip" in start or "knee" in start for start, _ in LIMB_BONES]
        assert np.median(off[legs]) < 5.0, name
        assert np.percentile(off[legs], 95.0) < 12.0, name
        assert np.percentile(off, 95.0) < 30.0, name
        check_stands_as_a_person(root, rotations, found)


def check_stands_as_a_person(root: FloatArray, rotations: FloatArray, found: FloatArray) -> None:
    feet = found[:, [column(f"{side}_foot") for side in ("left", "right")], 1].min(axis=1)
    assert -0.02 < np.percentile(feet, 5.0) < 0.06
    assert 0.6 < np.median(root[:, 1]) < 1.0
    np.testing.assert_allclose(root[0, [0, 2]], 0.0, atol=1e-9)
    # Left stays left, and knees bend forward, as seen from the pelvis.
    across = found[:, column("left_hip")] - found[:, column("right_hip")]
    forward = np.cross(across, [0.0, 1.0, 0.0])
    assert across[0, 0] > 0.1
    for side in ("left", "right"):
        hip, knee, ankle = (found[:, column(f"{side}_{n}")] for n in ("hip", "knee", "ankle"))
        bend = knee - 0.5 * (hip + ankle)
        assert np.percentile((bend * forward).sum(axis=1), 2.0) > -0.01


@pytest.mark.realdata
def test_trunks_of_other_skeletons_are_upright(realdata: Path) -> None:
    """CMU's zero pose is a T-pose, its hips lie off the root, its Euler order and unit differ."""
    seen = 0
    for name, source, joints in real_clips(realdata):
        if not name.startswith("dataset"):
            world = BODY.forward_kinematics(*retarget(source, joints))[1]
            up = quaternion_rotate(world[:, column("spine3")], [0.0, 1.0, 0.0])
            assert np.median(up[:, 1]) > np.cos(np.deg2rad(40.0)), name
            seen += 1
    assert seen >= 8


@pytest.mark.realdata
def test_heads_over_two_neck_joints_keep_their_range(realdata: Path) -> None:
    """CMU's jump 01_01 nods with both: a map to the lower one would bend the head by 90 degrees."""
    recipe = load_recipe("cmu")
    source = source_pose(
        read_bvh(realdata / "cmu" / "01_01.bvh"), metres_per_unit=recipe.metres_per_unit
    )
    _, local = retarget(source, dict(recipe.joint_map(source.joint_names)))
    for name, most_deg in (("neck", 65.0), ("head", 50.0)):
        cosine = np.abs(local[1:, JOINT_NAMES.index(name), 0])
        assert np.rad2deg(2.0 * np.arccos(cosine.clip(0.0, 1.0))).max() < most_deg, name
