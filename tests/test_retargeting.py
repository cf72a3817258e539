"""Retargeting and cycles: directions kept, left stays left, feet on the floor, seams closed."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from affectsim_data.builders.corpus_recipe import load_recipe
from affectsim_data.builders.performances import perform
from affectsim_data.content import content_path
from affectsim_data.motions import Motion
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.looping import close_loop, make_cyclic, out_and_back, seam_step
from affectsim_data.motions.retargeting import SourcePose, resample, retarget, source_pose
from affectsim_data.poses import (
    FloatArray,
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


def walking() -> Motion:
    return perform("simple_walk", "neutral", "p1", rng=np.random.default_rng(0))


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
    motion = walking()
    root, rotations = retarget(as_source(motion), SAME_NAMES)
    found = BODY.forward_kinematics(root, rotations)[0]
    expected = motion.joint_positions()
    for start, end in LIMB_BONES:
        pair = column(start), column(end)
        # The facing is estimated, so the whole figure may be turned by a degree or two.
        assert degrees_between(bone(found, *pair), bone(expected, *pair)) < 5.0
    assert np.abs(found - expected).max() < 0.15


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_the_frames_a_source_gives_its_joints_do_not_matter(seed: int) -> None:
    motion = walking()
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
    source = as_source(walking())
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
    motion = walking()
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
        retarget(as_source(walking()), joints)


def test_resampling_keeps_duration_and_ends() -> None:
    motion = walking()
    root, rotations = resample(
        motion.root_translation, motion.joint_rotations, fps=120.0, target_fps=30.0
    )
    assert len(root) == (motion.num_frames - 1) // 4 + 1
    np.testing.assert_allclose(root, motion.root_translation[::4], atol=1e-12)
    np.testing.assert_allclose(rotations, motion.joint_rotations[::4], atol=1e-9)


def test_a_loop_closes_and_says_so() -> None:
    whole = perform("free_gesture", "happy", "p1", rng=np.random.default_rng(0))
    part = dataclasses.replace(
        whole,
        root_translation=whole.root_translation[:60],
        joint_rotations=whole.joint_rotations[:60],
    )
    closed = close_loop(part, seam_s=0.4)
    excess_m, excess_rad = seam_step(closed)
    assert excess_m < 0.02
    assert excess_rad < np.deg2rad(5.0)
    np.testing.assert_array_equal(closed.joint_rotations[:48], part.joint_rotations[:48])
    assert closed.source.endswith("; seam of 0.4 s blended")


def test_out_and_back_returns_without_a_jump() -> None:
    whole = walking()
    straight = dataclasses.replace(
        whole,
        root_translation=whole.root_translation[:40],
        joint_rotations=whole.joint_rotations[:40],
    )
    cycle = make_cyclic(straight)
    assert cycle.num_frames == 2 * 40 + 2 * 24
    assert cycle.source.endswith("; out and back, turns of 0.8 s")
    ring = np.concatenate([cycle.joint_positions(), cycle.joint_positions()[:1]])
    assert np.linalg.norm(np.diff(ring, axis=0), axis=-1).max() < 0.25
    heading = quaternion_rotate(cycle.joint_rotations[:, 0], [0.0, 0.0, 1.0])
    first, second = heading[:40], heading[64:104]
    np.testing.assert_allclose(first * [-1.0, 1.0, -1.0], second, atol=1e-9)
    shorter = out_and_back(straight, max_travel_m=0.5)
    assert "first 1" in shorter.source or "first 2" in shorter.source
    assert np.ptp(shorter.root_translation[:, [0, 2]], axis=0).max() < 1.2


@pytest.mark.realdata
def test_real_limbs_point_as_in_the_source(realdata: Path) -> None:
    recipe = load_recipe(content_path("builders", "bandai_namco.toml"))
    started, played_s = time.perf_counter(), 0.0
    for path in sorted((realdata / "bandai_namco").glob("**/*.bvh")):
        clip = read_bvh(path)
        source = source_pose(clip, metres_per_unit=0.01)
        root, rotations = retarget(source, recipe.joints)
        found = BODY.forward_kinematics(root, rotations)[0]
        played_s += clip.num_frames * clip.frame_time_s
        index = {name: clip.joint_names.index(joint) for name, joint in recipe.joints.items()}
        bones = [
            (
                bone(source.positions, index[start], index[end]),
                bone(found, column(start), column(end)),
            )
            for start, end in LIMB_BONES
        ]
        # The figure is turned to face +Z as a whole; the turn is found from the limbs themselves.
        before, after = (np.concatenate(parts) for parts in zip(*bones, strict=True))
        z_before, z_after = before[:, 2] + 1j * before[:, 0], after[:, 2] + 1j * after[:, 0]
        turn = yaw_quaternion(np.angle((z_before.conj() * z_after).sum()))
        assert degrees_between(quaternion_rotate(turn, before), after) < 1.0, path.name
        check_stands_as_a_person(root, rotations, found)
    assert played_s / (time.perf_counter() - started) > 50.0


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
def test_other_skeletons_stand_upright(realdata: Path) -> None:
    """CMU's zero pose is a T-pose, its hips lie off the root, its Euler order and unit differ."""
    joints = {"pelvis": "Hips", "spine1": "LowerBack", "spine3": "Spine1", "neck": "Neck"}
    joints["head"] = "Head"
    for side, name in (("left", "Left"), ("right", "Right")):
        joints |= {f"{side}_hip": f"{name}UpLeg", f"{side}_knee": f"{name}Leg"}
        joints |= {f"{side}_ankle": f"{name}Foot", f"{side}_foot": f"{name}ToeBase"}
        joints |= {f"{side}_collar": f"{name}Shoulder", f"{side}_shoulder": f"{name}Arm"}
        joints |= {f"{side}_elbow": f"{name}ForeArm", f"{side}_wrist": f"{name}Hand"}
    for path in [realdata / "cmu" / "12_01_walk.bvh", *(realdata / "xia_styles").glob("*.bvh")]:
        source = source_pose(read_bvh(path), metres_per_unit=0.05644)
        root, rotations = retarget(source, joints)
        found, world = BODY.forward_kinematics(root, rotations)
        check_stands_as_a_person(root, rotations, found)
        up = quaternion_rotate(world[:, column("spine3")], [0.0, 1.0, 0.0])
        assert np.median(up[:, 1]) > np.cos(np.deg2rad(40.0))
