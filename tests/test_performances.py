"""Procedural people: cycles close, feet stay put, joints bend as joints do, emotions differ."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from affectsim_data.builders.performances import (
    PERFORMANCE_ACTIONS,
    PerformanceAction,
    perform,
    perform_pair,
)
from affectsim_data.builders.performances.curves import curve, cycle_phase, noise
from affectsim_data.builders.performances.styles import KINEMATICS, performer
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.motions.inverse_kinematics import two_bone_ik
from affectsim_data.motions.looping import seam_step
from affectsim_data.poses import FloatArray, quaternion_rotate
from affectsim_data.skeletons import JOINT_NAMES

PERFORMERS = ("p1", "p2", "p3", "p4")
EVERY = [(action, emotion) for action in PERFORMANCE_ACTIONS for emotion in EMOTIONS]


def shown(action: PerformanceAction, emotion: Emotion, who: str = "p1") -> Motion:
    return perform(action, emotion, who, rng=np.random.default_rng(7))


def joint(positions: FloatArray, name: str) -> FloatArray:
    found: FloatArray = positions[:, JOINT_NAMES.index(name)]
    return found


@pytest.mark.parametrize(("action", "emotion"), EVERY)
def test_a_performance_is_a_closed_cycle_on_the_floor(
    action: PerformanceAction, emotion: Emotion
) -> None:
    motion = shown(action, emotion)
    assert (motion.fps, motion.emotion, motion.action) == (30.0, emotion, action)
    assert 2.0 < motion.duration_s < 9.0
    np.testing.assert_allclose(motion.root_translation[0, [0, 2]], 0.0, atol=1e-12)
    excess_m, excess_rad = seam_step(motion)
    assert excess_m < 0.02
    # Toes stop dead on the floor, so one frame may turn more than those beside it.
    assert excess_rad < np.deg2rad(8.0)
    positions = motion.joint_positions()
    assert joint(positions, "left_foot")[:, 1].min() > 0.019
    assert joint(positions, "right_foot")[:, 1].min() > 0.019
    assert joint(positions, "head")[:, 1].max() < 1.75
    forward = quaternion_rotate(motion.joint_rotations[0, 0], [0.0, 0.0, 1.0])
    assert forward[2] > np.cos(np.deg2rad(12.0))


@pytest.mark.parametrize(("action", "emotion"), EVERY)
def test_planted_feet_do_not_slide(action: PerformanceAction, emotion: Emotion) -> None:
    for who in PERFORMERS:
        positions = shown(action, emotion, who).joint_positions()
        for side in ("left", "right"):
            toe = joint(positions, f"{side}_foot")
            step = np.linalg.norm((toe - np.roll(toe, 1, axis=0))[:, [0, 2]], axis=1)
            planted = (toe[:, 1] < 0.0205) & (np.roll(toe[:, 1], 1) < 0.0205)
            assert planted.mean() > 0.4
            # Slides of all stances of a cycle together.
            assert step[planted].sum() < 0.01


@pytest.mark.parametrize(("action", "emotion"), EVERY)
def test_knees_and_elbows_bend_the_right_way(action: PerformanceAction, emotion: Emotion) -> None:
    motion = shown(action, emotion, "p3")
    positions = motion.joint_positions()
    across = joint(positions, "left_hip") - joint(positions, "right_hip")
    forward = np.cross(across, [0.0, 1.0, 0.0])
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee, ankle = (joint(positions, f"{side}_{n}") for n in ("hip", "knee", "ankle"))
        assert ((knee - 0.5 * (hip + ankle)) * forward).sum(axis=1).min() > 0.0
        # In the elbow's frame, which its parent shares, the forearm only flexes and turns: it
        # never points back along the upper arm, nor behind the plane the joint opens to.
        elbow = motion.joint_rotations[:, JOINT_NAMES.index(f"{side}_elbow")]
        forearm = quaternion_rotate(elbow, [sign, 0.0, 0.0])
        assert forearm[:, 2].min() > -0.05
        assert np.abs(forearm[:, 1]).max() < 0.05


@pytest.mark.parametrize("action", ["free_gesture", "being_seated", "simple_walk"])
def test_wrists_keep_out_of_the_trunk(action: PerformanceAction) -> None:
    for emotion in EMOTIONS:
        positions = shown(action, emotion).joint_positions()
        low, high = joint(positions, "pelvis"), joint(positions, "neck")
        for side in ("left", "right"):
            wrist = joint(positions, f"{side}_wrist")
            along = np.clip(
                ((wrist - low) * (high - low)).sum(1) / ((high - low) ** 2).sum(1), 0.0, 1.0
            )
            away = np.linalg.norm(wrist - low - along[:, None] * (high - low), axis=1)
            assert away.min() > 0.13, (emotion, side)


def test_who_sits_has_feet_and_pelvis_where_a_seat_wants_them() -> None:
    positions = shown("being_seated", "neutral").joint_positions()
    np.testing.assert_allclose(joint(positions, "pelvis")[:, 1], 0.55, atol=0.02)
    rise = joint(positions, "left_knee")[:, 1] - joint(positions, "left_hip")[:, 1]
    assert np.abs(rise).max() < 0.06
    down = shown("sit_down", "neutral").root_translation
    assert down[:, 1].max() > 0.9
    assert down[:, 1].min() == pytest.approx(0.55, abs=0.01)
    assert down[:, 2].min() == pytest.approx(-0.40, abs=0.02)


def test_walks_differ_as_measured_walks_do() -> None:
    walks = {emotion: shown("simple_walk", emotion) for emotion in EMOTIONS}
    speed = {
        emotion: np.linalg.norm(np.diff(walk.root_translation[:, [0, 2]], axis=0), axis=1).mean()
        for emotion, walk in walks.items()
    }
    assert speed["angry"] > speed["neutral"] > speed["fearful"] > speed["sad"]
    bounce = {emotion: np.ptp(walk.root_translation[:, 1]) for emotion, walk in walks.items()}
    assert max(bounce, key=lambda emotion: bounce[emotion]) == "happy"
    assert min(bounce, key=lambda emotion: bounce[emotion]) == "sad"
    span = {}
    for emotion, walk in walks.items():
        positions = walk.joint_positions()
        apart = joint(positions, "left_wrist") - joint(positions, "right_wrist")
        span[emotion] = float(np.linalg.norm(apart, axis=1).mean()) / 1.70
    assert span["fearful"] < 0.15 < span["sad"] < span["neutral"]
    assert list(KINEMATICS) == list(EMOTIONS)


def test_the_walk_goes_round_an_oval_that_fits_a_room() -> None:
    for who in PERFORMERS:
        for emotion in EMOTIONS:
            extent = np.ptp(shown("simple_walk", emotion, who).root_translation, axis=0)
            assert extent[2] < 3.2
            assert extent[0] < 1.5


def test_a_pair_shares_length_and_group() -> None:
    for emotion in EMOTIONS:
        target, partner = perform_pair(emotion, ("p1", "p2"), rng=np.random.default_rng(3))
        assert target.num_frames == partner.num_frames
        assert target.group_id == partner.group_id
        assert (target.emotion, partner.emotion) == (emotion, "neutral")
        assert (target.performer_id, partner.performer_id) == ("p1", "p2")
        assert target.motion_id != partner.motion_id
    with pytest.raises(ValueError, match="needs two performers, got 'p1' twice"):
        perform_pair("sad", ("p1", "p1"), rng=np.random.default_rng(3))


def test_the_same_seed_gives_the_same_bytes() -> None:
    one, two = (shown("free_gesture", "fearful") for _ in range(2))
    assert one.joint_rotations.tobytes() == two.joint_rotations.tobytes()
    other = perform("free_gesture", "fearful", "p1", rng=np.random.default_rng(8))
    assert one.joint_rotations.tobytes() != other.joint_rotations.tobytes()


def test_performers_differ_and_stay_themselves() -> None:
    assert performer("p1") == performer("p1")
    assert len({performer(who).tempo for who in PERFORMERS}) == 4
    assert {performer(who).hand for who in PERFORMERS} == {"left", "right"}


def test_an_unknown_action_is_named() -> None:
    with pytest.raises(ValueError, match=r"action must be one of simple_walk, .*, got 'dance'"):
        perform("dance", "happy", "p1", rng=np.random.default_rng(0))  # type: ignore[arg-type]


def test_the_built_in_set_takes_seconds() -> None:
    started = time.perf_counter()
    for emotion in EMOTIONS:
        for who in PERFORMERS:
            for action in ("simple_walk", "being_seated", "free_gesture"):
                perform(action, emotion, who, rng=np.random.default_rng(1))
        for first, second in (("p1", "p2"), ("p2", "p3"), ("p3", "p4")):
            perform_pair(emotion, (first, second), rng=np.random.default_rng(1))
    assert time.perf_counter() - started < 6.0


@given(
    target=st.tuples(*[st.floats(-1.0, 1.0) for _ in range(3)]),
    pole=st.tuples(*[st.floats(-1.0, 1.0) for _ in range(3)]),
)
def test_two_bones_reach_what_they_can(
    target: tuple[float, float, float], pole: tuple[float, float, float]
) -> None:
    goal, hint = np.array([target]), np.array([pole])
    distance = float(np.linalg.norm(goal))
    if distance < 0.06 or np.linalg.norm(np.cross(goal, hint)) < 1e-3 * distance:
        return
    upper, lower, hinge = two_bone_ik(goal, hint, 0.30, 0.25)
    np.testing.assert_allclose(np.linalg.norm([upper, lower, hinge], axis=-1), 1.0, atol=1e-9)
    tip = 0.30 * upper + 0.25 * lower
    if distance < 0.5497:
        np.testing.assert_allclose(tip, goal, atol=1e-9)
    else:
        np.testing.assert_allclose(tip / 0.5497, goal / distance, atol=2e-3)
    along = goal / distance
    aside = hint - (hint * along).sum() * along
    assert (upper * aside).sum() > -1e-9
    np.testing.assert_allclose((upper * hinge).sum(), 0.0, atol=1e-9)


@settings(max_examples=30)
@given(num_frames=st.integers(30, 200), seed=st.integers(0, 2**32 - 1))
def test_curves_end_as_they_begin(num_frames: int, seed: int) -> None:
    phase = np.concatenate([cycle_phase(num_frames), [1.0]])
    waves = noise(phase, amplitude=1.0, rng=np.random.default_rng(seed))
    assert waves[-1] == pytest.approx(waves[0], abs=1e-9)
    keyed = curve(phase, (0.1, 0.4, 0.8), (0.0, 1.0, 0.3))
    assert keyed[-1] == pytest.approx(keyed[0], abs=1e-9)
    assert keyed.min() >= -1e-12
    assert keyed.max() <= 1.0 + 1e-12
