"""Feet that stand: stances found as they were made, held on any body, nothing else disturbed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from real_clips import real_clips
from walkers import planted_frames, swayer, walker

from affectsim_data.motions.planting import (
    ANKLES,
    TOES,
    Stance,
    find_stances,
    foot_shifts,
    plant_feet,
    stance_slides,
)
from affectsim_data.motions.reaching import hinged, yaw_of
from affectsim_data.motions.retargeting import retarget_with_report
from affectsim_data.poses import (
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

UPPER = [
    joint
    for joint, name in enumerate(JOINT_NAMES)
    if not name.endswith(("hip", "knee", "ankle", "foot"))
]


@pytest.mark.parametrize("fps", [30.0, 120.0])
def test_stances_of_a_walk_are_found_as_they_were_made(fps: float) -> None:
    motion = walker(fps=fps)
    found = np.zeros((motion.num_frames, 2), bool)
    for stance in find_stances(motion.joint_positions()[:, TOES], fps):
        found[stance.start : stance.stop, stance.foot] = True
    made = planted_frames(motion.num_frames, fps)
    assert (found & ~made).mean() < 0.03
    assert (found & made).sum() / made.sum() > 0.85


def test_stances_do_not_depend_on_where_the_floor_is_or_where_the_walk_goes() -> None:
    motion = walker()
    toes = motion.joint_positions()[:, TOES]
    moved = toes[..., [2, 1, 0]] + [3.0, 0.8, -5.0]
    assert find_stances(moved, 30.0) == find_stances(toes, 30.0)


def test_feet_in_the_air_have_no_stances() -> None:
    toes = walker().joint_positions()[:, TOES]
    assert find_stances(toes + np.arange(len(toes))[:, None, None] * [0.0, 0.0, 0.1], 30.0) == []


def test_a_dragged_foot_is_not_planted() -> None:
    toes = np.tile([[0.1, 0.02, 0.0], [-0.1, 0.02, 0.0]], (60, 1, 1))
    toes[:, 0, 2] = 0.09 * np.arange(60) / 30.0  # 9 cm/s, for 18 cm
    assert {stance.foot for stance in find_stances(toes, 30.0)} == {1}


def test_planted_feet_stay_and_the_upper_body_too() -> None:
    motion = walker()
    stances = find_stances(motion.joint_positions()[:, TOES], motion.fps)
    # A pelvis that swings 2 cm to and fro drags both feet along.
    swing = 0.02 * np.sin(np.arange(motion.num_frames) / 4.0)
    root = motion.root_translation + swing[:, None] * np.array([1.0, 0.0, 0.5])
    before = BODY.forward_kinematics(root, motion.joint_rotations)[0]
    assert stance_slides(before[:, TOES], stances).max() > 0.03
    after, world = BODY.forward_kinematics(
        *plant_feet(root, motion.joint_rotations, stances, fps=motion.fps)
    )
    assert stance_slides(after[:, TOES], stances).max() < 1e-3
    assert np.abs(after - before)[:, UPPER].max() < 0.005
    feet = BODY.forward_kinematics(root, motion.joint_rotations)[1][:, ANKLES]
    turned = np.abs((world[:, ANKLES] * feet).sum(-1)).min()
    assert 2.0 * np.arccos(min(turned, 1.0)) < np.deg2rad(10.0)


def test_what_stands_already_and_what_never_stands_is_left_alone() -> None:
    motion = swayer()
    whole = motion.root_translation, motion.joint_rotations
    assert plant_feet(*whole, [], fps=30.0) == whole
    stances = find_stances(motion.joint_positions()[:, TOES], 30.0)
    again = plant_feet(*plant_feet(*whole, stances, fps=30.0), stances, fps=30.0)
    np.testing.assert_allclose(
        BODY.forward_kinematics(*again)[0], motion.joint_positions(), atol=2e-3
    )


def test_a_shift_blends_from_stance_to_stance() -> None:
    toes = np.zeros((20, 2, 3))
    toes[..., 1] = 0.02
    toes[4:8, 0, 0] = [0.0, 0.01, 0.01, 0.02]
    toes[12:16, 0, 0] = [0.0, 0.03, 0.03, 0.03]
    shifts = foot_shifts(toes, [Stance(0, 4, 8), Stance(0, 12, 16)])
    np.testing.assert_allclose(shifts[4:8, 0, 0], [0.01, 0.0, 0.0, -0.01])
    np.testing.assert_allclose(shifts[12:16, 0, 0], [0.03, 0.0, 0.0, 0.0])
    assert (np.diff(shifts[7:13, 0, 0]) > 0.0).all()
    np.testing.assert_allclose(shifts[:4, 0, 0], 0.01)
    np.testing.assert_allclose(shifts[16:, 0, 0], 0.0)
    assert not shifts[:, 1].any()


def test_a_foot_that_would_have_to_go_far_is_left_alone() -> None:
    toes = np.zeros((20, 2, 3))
    toes[4:8, 0, 0] = [0.0, 0.2, 0.2, 0.2]
    assert not foot_shifts(toes, [Stance(0, 4, 8)]).any()


def test_legs_that_are_too_short_lower_the_pelvis_and_no_more_than_needed() -> None:
    motion = swayer()
    root = motion.root_translation + np.array([0.0, 0.05, 0.0])
    stances = [Stance(foot, 0, motion.num_frames) for foot in (0, 1)]
    after, _ = plant_feet(root, motion.joint_rotations, stances, fps=30.0)
    sunk = root[:, 1] - after[:, 1]
    assert 0.0 < sunk.max() < 0.05
    assert np.abs(np.diff(sunk, 2)).max() < 0.002


def test_hips_turned_sideways_keep_their_knees_forward() -> None:
    motion = walker()
    local = motion.joint_rotations.copy()
    sway = 0.15 * np.sin(np.arange(motion.num_frames) / 6.0)
    local[:, 0] = quaternion_multiply(yaw_quaternion(sway), local[:, 0])
    stances = find_stances(motion.joint_positions()[:, TOES], 30.0)
    found = BODY.forward_kinematics(*plant_feet(motion.root_translation, local, stances, fps=30.0))
    positions = found[0]
    for side in ("left", "right"):
        hip, knee, ankle = (
            positions[:, JOINT_NAMES.index(f"{side}_{part}")] for part in ("hip", "knee", "ankle")
        )
        assert (knee - 0.5 * (hip + ankle))[:, 2].min() > -0.01
    assert stance_slides(positions[:, TOES], stances).max() < 1e-3


@pytest.mark.realdata
def test_real_feet_stand_still_after_retargeting(realdata: Path) -> None:
    """Every clip: no planted foot slides a millimetre, the trunk sinks 2 cm at most, if ever."""
    slides, sunk = [], []
    for _, source, joints in real_clips(realdata):
        root, rotations, report = retarget_with_report(source, joints)
        slides.append(report.slide_after_m)
        assert report.slide_after_m <= max(report.slide_before_m, 1e-3)
        positions = BODY.forward_kinematics(root, rotations)[0]
        sunk.append(np.percentile(positions[:, TOES, 1].min(axis=1), 10.0))
    assert len(slides) >= 30
    assert max(slides) < 1e-3
    assert min(sunk) > -0.01


def test_knees_are_hinges_and_nothing_moves_for_it() -> None:
    """A thigh turns about its length until its knee hardly bends sideways; the shank stays."""
    rng = np.random.default_rng(0)
    thigh = axis_angle_quaternion([1.0, 0.0, 0.0], rng.uniform(-1.0, 1.0, (20, 2)))
    bend = axis_angle_quaternion([0.6, 0.0, 0.8], rng.uniform(-0.3, 1.5, (20, 2)))
    shank = quaternion_multiply(thigh, bend)
    down = [0.0, -1.0, 0.0]
    assert np.abs(quaternion_rotate(bend, down)[..., 0]).max() > 0.5
    turned = hinged(thigh, shank, np.ones(20))
    np.testing.assert_allclose(
        quaternion_rotate(turned, down), quaternion_rotate(thigh, down), atol=1e-12
    )
    knee = quaternion_multiply(quaternion_conjugate(turned), shank)
    assert np.abs(quaternion_rotate(knee, down)[..., 0]).max() < 0.1501
    np.testing.assert_array_equal(hinged(thigh, shank, np.zeros(20)), thigh)


def test_the_yaw_of_a_foot_goes_on_where_its_heel_passes_over_its_toes() -> None:
    pitches = np.deg2rad(np.linspace(0.0, 140.0, 50))
    feet = quaternion_multiply(yaw_quaternion(0.7), axis_angle_quaternion([1.0, 0.0, 0.0], pitches))
    np.testing.assert_allclose(yaw_of(feet), 0.7)
