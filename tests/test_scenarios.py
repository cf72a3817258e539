"""Standing performances: closed cycles on planted feet, bodies that bend as bodies do, and what
tells one emotion from another."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from affectsim_data.builders.performances.rig import solve_body
from affectsim_data.builders.performances.scenarios import (
    NUM_SCENARIOS,
    SCENARIOS,
    scenario_track,
)
from affectsim_data.builders.performances.scenarios.arms import key_weights
from affectsim_data.builders.performances.scenarios.vocabulary import HANGING, ArmPose, keys
from affectsim_data.builders.performances.styles import performer
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.motions.descriptors import kinematic_descriptors
from affectsim_data.motions.looping import seam_step
from affectsim_data.poses import FloatArray, quaternion_conjugate, quaternion_rotate
from affectsim_data.skeletons import BODY, JOINT_NAMES

EVERY = [(emotion, take) for emotion in EMOTIONS for take in range(NUM_SCENARIOS)]
CASTS = (("p1", 1.0), ("p2", 0.4), ("p5", 1.2))
JERK_RANGES = {
    "angry": (40.0, 400.0),
    "fearful": (2.0, 37.0),
    "happy": (18.0, 57.0),
    "neutral": (11.0, 47.0),
    # Real sad gestures, bows and waves, stay below 3.5; kneeling down and getting up does not.
    "sad": (2.0, 10.0),
}
"""Mean hand jerk of recorded gestures (Bandai-Namco), m/s3, least and most of the clips."""


@functools.cache
def shown(emotion: Emotion, take: int, who: str = "p1", intensity: float = 1.0) -> Motion:
    rng = np.random.default_rng(7)
    name, track = scenario_track(emotion, take, performer(who), intensity=intensity, rng=rng)
    root, rotations = solve_body(track)
    return Motion(
        motion_id=name,
        performer_id=who,
        group_id=name,
        emotion=emotion,
        action="scenario",
        fps=30.0,
        root_translation=root - root[0] * [1.0, 0.0, 1.0],
        joint_rotations=rotations,
        performance=name,
        take=take,
    )


def frames(motion: Motion) -> tuple[FloatArray, FloatArray]:
    return BODY.forward_kinematics(motion.root_translation, motion.joint_rotations)


def joint(positions: FloatArray, name: str) -> FloatArray:
    found: FloatArray = positions[:, JOINT_NAMES.index(name)]
    return found


def jerk(emotion: Emotion, take: int, who: str) -> float:
    return kinematic_descriptors(shown(emotion, take, who))["hands_jerk_mean_m_s3"]


@pytest.mark.parametrize(("emotion", "take"), EVERY)
def test_a_scenario_is_a_closed_cycle_on_the_spot(emotion: Emotion, take: int) -> None:
    for who, intensity in CASTS:
        motion = shown(emotion, take, who, intensity)
        assert 5.0 <= motion.duration_s <= 10.0
        excess_m, excess_rad = seam_step(motion)
        assert excess_m < 0.005
        assert excess_rad < np.deg2rad(2.0)
        assert np.abs(motion.root_translation[:, [0, 2]]).max() < 0.8
        forward = quaternion_rotate(motion.joint_rotations[0, 0], [0.0, 0.0, 1.0])
        assert forward[2] > np.cos(np.deg2rad(12.0))


@pytest.mark.parametrize(("emotion", "take"), EVERY)
def test_feet_are_planted_and_nobody_is_below_the_floor(emotion: Emotion, take: int) -> None:
    for who, intensity in CASTS:
        positions, _ = frames(shown(emotion, take, who, intensity))
        assert positions[..., 1].min() > 0.0199
        for side in ("left", "right"):
            assert joint(positions, f"{side}_knee")[:, 1].min() > 0.055
            assert joint(positions, f"{side}_wrist")[:, 1].min() > 0.06
            toe = joint(positions, f"{side}_foot")
            step = np.linalg.norm((toe - np.roll(toe, 1, axis=0))[:, [0, 2]], axis=1)
            planted = (toe[:, 1] < 0.0205) & (np.roll(toe[:, 1], 1) < 0.0205)
            assert planted.mean() > 0.5
            # Slides of all stances of a cycle together.
            assert step[planted].sum() < 0.002


@pytest.mark.parametrize(("emotion", "take"), EVERY)
def test_knees_and_elbows_bend_the_right_way(emotion: Emotion, take: int) -> None:
    for who, intensity in CASTS:
        motion = shown(emotion, take, who, intensity)
        positions, rotations = frames(motion)
        for side, sign in (("left", 1.0), ("right", -1.0)):
            hip, knee, ankle = (joint(positions, f"{side}_{n}") for n in ("hip", "knee", "ankle"))
            toes = quaternion_rotate(joint(rotations, f"{side}_ankle"), [0.0, 0.0, 1.0])
            front = toes + quaternion_rotate(joint(rotations, "pelvis"), [0.0, 0.0, 1.0])
            assert ((knee - 0.5 * (hip + ankle)) * front).sum(axis=1).min() > 0.0
            elbow = motion.joint_rotations[:, JOINT_NAMES.index(f"{side}_elbow")]
            forearm = quaternion_rotate(elbow, [sign, 0.0, 0.0])
            assert forearm[:, 2].min() > -0.05
            assert np.abs(forearm[:, 1]).max() < 0.05


@pytest.mark.parametrize(("emotion", "take"), EVERY)
def test_hands_keep_out_of_trunk_and_head_and_arms_never_snap(emotion: Emotion, take: int) -> None:
    for who, intensity in CASTS:
        motion = shown(emotion, take, who, intensity)
        positions, rotations = frames(motion)
        low, high = joint(positions, "pelvis"), joint(positions, "neck")
        skull = joint(positions, "head") + quaternion_rotate(
            joint(rotations, "head"), [0.0, 0.07, 0.02]
        )
        for side, sign in (("left", 1.0), ("right", -1.0)):
            wrist = joint(positions, f"{side}_wrist")
            along = ((wrist - low) * (high - low)).sum(1) / ((high - low) ** 2).sum(1)
            axis = low + np.clip(along, 0.0, 1.0)[:, None] * (high - low)
            assert np.linalg.norm(wrist - axis, axis=1).min() > 0.11
            turn = joint(rotations, f"{side}_wrist")
            for reach in (0.0, 0.08, 0.15):
                palm = wrist + quaternion_rotate(turn, [sign * reach, 0.0, 0.0])
                assert np.linalg.norm(palm - skull, axis=1).min() > 0.08
            elbow = joint(positions, f"{side}_elbow")
            speed = 30.0 * np.linalg.norm(elbow - np.roll(elbow, 1, axis=0), axis=1)
            assert speed.max() < 6.0


def test_every_emotion_has_as_many_scenarios_of_its_own() -> None:
    assert tuple(SCENARIOS) == EMOTIONS
    assert {len(names) for names in SCENARIOS.values()} == {NUM_SCENARIOS}
    assert len({name for names in SCENARIOS.values() for name in names}) == 5 * NUM_SCENARIOS
    assert [shown("sad", take).performance for take in range(NUM_SCENARIOS)] == list(
        SCENARIOS["sad"]
    )


def test_hands_jerk_as_hands_of_recorded_people_do() -> None:
    means = {
        emotion: float(
            np.mean([jerk(emotion, take, who) for take in range(5) for who in ("p1", "p2")])
        )
        for emotion in EMOTIONS
    }
    assert means["angry"] > means["happy"] > means["fearful"] > means["neutral"] > means["sad"]
    for emotion, (least, most) in JERK_RANGES.items():
        assert least < means[emotion] < most, (emotion, means)  # type: ignore[index]


def test_postures_tell_emotions_apart() -> None:
    kinds = {
        emotion: [kinematic_descriptors(shown(emotion, take)) for take in range(NUM_SCENARIOS)]
        for emotion in EMOTIONS
    }

    def mean(emotion: Emotion, name: str) -> float:
        return float(np.mean([found[name] for found in kinds[emotion]]))

    span = {emotion: mean(emotion, "hand_span_mean") for emotion in EMOTIONS}
    assert min(span, key=lambda emotion: span[emotion]) == "fearful"
    trunk = {emotion: mean(emotion, "trunk_pitch_mean_deg") for emotion in EMOTIONS}
    assert trunk["sad"] > trunk["neutral"] + 8.0
    assert trunk["angry"] > trunk["neutral"] + 5.0
    neck = {emotion: mean(emotion, "neck_pitch_mean_deg") for emotion in EMOTIONS}
    assert max(neck, key=lambda emotion: neck[emotion]) == "sad"
    assert min(neck, key=lambda emotion: neck[emotion]) == "happy"


def test_who_collapses_kneels_on_the_floor_and_who_celebrates_leaves_it() -> None:
    for who in ("p1", "p5"):
        kneeling, _ = frames(shown("sad", SCENARIOS["sad"].index("collapse"), who))
        knees = np.stack([joint(kneeling, f"{side}_knee")[:, 1] for side in ("left", "right")])
        assert (knees < 0.085).all(axis=0).mean() > 0.25
        assert joint(kneeling, "head")[:, 1].min() < 1.0
        hopping, _ = frames(shown("happy", SCENARIOS["happy"].index("celebrate"), who))
        toes = np.stack([joint(hopping, f"{side}_foot")[:, 1] for side in ("left", "right")])
        aloft = (toes > 0.04).all(axis=0)
        assert np.count_nonzero(aloft & ~np.roll(aloft, 1)) == 2


@pytest.mark.parametrize("emotion", EMOTIONS)
def test_intensity_changes_how_much_and_not_what(emotion: Emotion) -> None:
    bows = []
    for take in range(NUM_SCENARIOS):
        plain, strong = (shown(emotion, take, "p1", intensity) for intensity in (0.4, 1.2))
        phase = np.arange(200) / 200.0
        ways = []
        for motion in (plain, strong):
            positions, rotations = frames(motion)
            chest = joint(rotations, "spine3")
            bows.append(float(np.ptp(quaternion_rotate(chest, [0.0, 0.0, 1.0])[:, 1])))
            hand = joint(positions, f"{performer('p1').hand}_wrist") - joint(positions, "spine3")
            hand = quaternion_rotate(quaternion_conjugate(chest), hand)
            own = np.arange(len(hand)) / len(hand)
            way = np.stack([np.interp(phase, own, axis - axis.mean()) for axis in hand.T])
            ways.append(way.ravel())
        if np.ptp(ways[1]) > 0.1:
            alike = float(np.corrcoef(ways[0], ways[1]).min())
            # A hand held to the breast keeps its place, one held out comes nearer.
            assert alike > 0.6, SCENARIOS[emotion][take]
    assert sum(bows[0::2]) < 0.9 * sum(bows[1::2])


def test_the_same_seed_gives_the_same_bytes_and_another_take_does_not() -> None:
    tracks = [
        scenario_track("happy", 1, performer("p1"), intensity=1.0, rng=np.random.default_rng(seed))
        for seed in (3, 3, 4)
    ]
    one, two, other = (solve_body(track)[1] for _, track in tracks)
    assert one.tobytes() == two.tobytes()
    assert one.shape != other.shape or one.tobytes() != other.tobytes()
    lengths = {shown("neutral", 0, who).num_frames for who in ("p1", "p2", "p3", "p5")}
    assert len(lengths) >= 3


def test_left_handers_do_it_with_the_left() -> None:
    take = SCENARIOS["happy"].index("greet")
    for who in ("p1", "p2", "p3", "p5", "p8"):
        positions, _ = frames(shown("happy", take, who))
        highest = {
            side: joint(positions, f"{side}_wrist")[:, 1].max() for side in ("left", "right")
        }
        assert max(highest, key=lambda side: highest[side]) == performer(who).hand


def test_an_unknown_take_or_emotion_is_named() -> None:
    who, rng = performer("p1"), np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"sad scenario must be one of 0 mourn, .*, got 5"):
        scenario_track("sad", 5, who, intensity=1.0, rng=rng)
    with pytest.raises(ValueError, match=r"must be one of 0 explain, .*, got -1"):
        scenario_track("neutral", -1, who, intensity=1.0, rng=rng)
    with pytest.raises(ValueError, match=r"emotion must be one of angry, .*, got 'bored'"):
        scenario_track("bored", 0, who, intensity=1.0, rng=rng)  # type: ignore[arg-type]


def test_key_weights_share_out_one_and_pass_through_keys() -> None:
    times, period = np.array([0.2, 1.0, 1.7, 3.0]), 4.0
    places = np.array([[0.0, 0, 0], [0.1, 0.2, 0], [0.2, 0.4, 0], [0.2, 0.4, 0]])
    weights = key_weights(np.linspace(0.0, 4.0, 161)[:-1], times, places, period)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0, atol=1e-12)
    np.testing.assert_allclose(key_weights(times, times, places, period), np.eye(4), atol=1e-12)
    # A key on the way is passed at speed, one that starts a rest is a stop.
    moved = key_weights(times + 1e-4, times, places, period) @ places - places
    assert np.linalg.norm(moved[1]) > 1e-5
    assert np.linalg.norm(moved[2]) < 1e-6


def test_poses_move_and_turn_and_uneven_curves_are_refused() -> None:
    assert HANGING.moved(up=0.1, out=0.02).wrist == pytest.approx((0.08, -0.425, 0.05))
    assert ArmPose((0.0, 0.0, 0.3), bend_deg=9.0).turned(30.0).bend_deg == 9.0
    assert HANGING.turned(30.0, -5.0).bend_deg == -5.0
    with pytest.raises(ValueError, match="zip"):
        keys((0.0, 1.0), (0.0,), (0.0, 0.0), (0.0, 0.0))
