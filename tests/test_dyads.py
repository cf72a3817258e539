"""Interactions of two people: closed cycles, planted feet, hands that meet, bodies that do not."""

from __future__ import annotations

import dataclasses
import functools
from typing import Literal

import numpy as np
import pytest

from affectsim_data.builders.performances import perform_dyad
from affectsim_data.builders.performances.dyads import (
    DYADS,
    NUM_DYADS,
    DyadTracks,
    dyad_tracks,
    interaction_of,
)
from affectsim_data.builders.performances.dyads.interaction import Interaction
from affectsim_data.builders.performances.dyads.meeting import PALM
from affectsim_data.builders.performances.rig import BodyTrack, solve_body
from affectsim_data.builders.performances.styles import Side, performer
from affectsim_data.motions import EMOTIONS, Emotion, Motion
from affectsim_data.motions.looping import seam_step
from affectsim_data.poses import (
    FloatArray,
    matrix_quaternion,
    quaternion_multiply,
    quaternion_rotate,
    transform_points,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

EVERY = [(emotion, take) for emotion in EMOTIONS for take in range(NUM_DYADS)]
NAMES = [DYADS[emotion][take] for emotion, take in EVERY]
CASTS = (("p1", "p2", 1.0), ("p7", "p8", 1.4), ("p5", "p6", 0.4))
"""Target, partner, intensity: right- and left-handed, strong and weak."""
EXTREMITIES = ("head", "left_wrist", "right_wrist")
SIDES: tuple[Side, Side] = ("left", "right")
every_dyad = pytest.mark.parametrize(("emotion", "take"), EVERY, ids=NAMES)
Who = Literal["target", "partner"]
Capsules = dict[str, tuple[FloatArray, FloatArray, float]]


@functools.cache
def tracks(emotion: Emotion, take: int, cast: tuple[str, str, float]) -> DyadTracks:
    first, second, intensity = cast
    return dyad_tracks(
        emotion,
        take,
        performer(first),
        performer(second),
        intensity=intensity,
        rng=np.random.default_rng(7),
    )


@functools.cache
def pose(
    emotion: Emotion, take: int, cast: tuple[str, str, float], who: Who
) -> tuple[FloatArray, FloatArray]:
    """Joints in the target's frame: positions `(n, 22, 3)` and rotations `(n, 22, 4)`."""
    found = tracks(emotion, take, cast)
    body: BodyTrack = getattr(found, who)
    positions, rotations = BODY.forward_kinematics(*solve_body(body))
    if who == "target":
        return positions, rotations
    turn = matrix_quaternion(found.T_target_partner[:3, :3])
    return transform_points(found.T_target_partner, positions), quaternion_multiply(turn, rotations)


def joint(values: FloatArray, name: str) -> FloatArray:
    found: FloatArray = values[:, JOINT_NAMES.index(name)]
    return found


def motion(track: BodyTrack, emotion: Emotion) -> Motion:
    root, rotations = solve_body(track)
    return Motion(
        motion_id="mini/interaction",
        performer_id="p1",
        group_id="mini/interaction",
        emotion=emotion,
        action="interaction",
        fps=30.0,
        root_translation=root,
        joint_rotations=rotations,
    )


def seen_angle(emotion: Emotion, take: int, who: Who) -> FloatArray:
    """Between where a face points and the other's face, degrees, `(n,)`."""
    positions, rotations = pose(emotion, take, CASTS[0], who)
    others, _ = pose(emotion, take, CASTS[0], "partner" if who == "target" else "target")
    ahead = quaternion_rotate(joint(rotations, "head"), [0.0, 0.0, 1.0])
    way = joint(others, "head") - joint(positions, "head")
    cosine = (ahead * way).sum(axis=1) / np.linalg.norm(way, axis=1)
    angle: FloatArray = np.rad2deg(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return angle


def capsules(positions: FloatArray, rotations: FloatArray) -> Capsules:
    """A body as capsules: ends `(n, 3)` and radius, those of a slim clothed adult."""
    spine = joint(positions, "pelvis"), joint(positions, "spine3")
    neck = joint(positions, "spine3"), joint(positions, "neck")
    shoulders = joint(positions, "left_shoulder"), joint(positions, "right_shoulder")
    head, up = joint(positions, "head"), joint(rotations, "head")
    crown = head + quaternion_rotate(up, [0.0, 0.12, 0.02])
    found: Capsules = {
        "trunk": (*spine, 0.135),
        "neck": (*neck, 0.06),
        "shoulders": (*shoulders, 0.07),
        "head": (head, crown, 0.10),
    }
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee, ankle, toe, shoulder, elbow, wrist = (
            joint(positions, f"{side}_{name}")
            for name in ("hip", "knee", "ankle", "foot", "shoulder", "elbow", "wrist")
        )
        hand = quaternion_rotate(joint(rotations, f"{side}_wrist"), [0.15 * sign, 0.0, 0.0])
        found |= {
            f"{side} upper arm": (shoulder, elbow, 0.05),
            f"{side} forearm": (elbow, wrist, 0.04),
            f"{side} hand": (wrist, wrist + hand, 0.025),
            f"{side} thigh": (hip, knee, 0.075),
            f"{side} shin": (knee, ankle, 0.055),
            f"{side} foot": (ankle, toe, 0.045),
        }
    return found


def segment_distance(
    start: FloatArray, end: FloatArray, other_start: FloatArray, other_end: FloatArray
) -> FloatArray:
    """Least distance of two segments, row by row, `(n,)` (Ericson 2005, section 5.1.9)."""
    way, other, apart = end - start, other_end - other_start, start - other_start
    a, e, b = (way**2).sum(1), (other**2).sum(1), (way * other).sum(1)
    c, f = (way * apart).sum(1), (other * apart).sum(1)
    slant = a * e - b * b
    share = np.clip(np.where(slant > 1e-12, (b * f - c * e) / np.maximum(slant, 1e-12), 0), 0, 1)
    along = np.clip((b * share + f) / e, 0.0, 1.0)
    share = np.clip((b * along - c) / a, 0.0, 1.0)
    gap = start + share[:, None] * way - other_start - along[:, None] * other
    distance: FloatArray = np.linalg.norm(gap, axis=1)
    return distance


def test_the_distance_of_segments_is_that_worked_out_by_hand() -> None:
    x, y, z = np.eye(3)
    crossing = segment_distance(np.array([-x]), np.array([x]), np.array([z - y]), np.array([z + y]))
    beyond = segment_distance(
        np.array([0 * x]), np.array([x]), np.array([3 * x]), np.array([4 * x])
    )
    askew = segment_distance(np.array([0 * x]), np.array([x]), np.array([x + y]), np.array([x + z]))
    np.testing.assert_allclose([crossing[0], beyond[0]], [1.0, 2.0])
    np.testing.assert_allclose(askew[0], np.sqrt(0.5))


def touching(interaction: Interaction, found: DyadTracks) -> dict[tuple[str, str], FloatArray]:
    """Pairs of parts, target's and partner's, that a contact brings together, and its share."""
    pairs: dict[tuple[str, str], FloatArray] = {}
    clasped = list(found.target.contacts) if interaction.clasps else []
    for side in clasped:
        for other, contact in found.partner.contacts.items():
            for part in ("hand", "forearm"):
                for others in ("hand", "forearm"):
                    pair = (f"{side} {part}", f"{other} {others}")
                    pairs[pair] = np.maximum(pairs.get(pair, 0.0), contact.share)
    limbs = {"collar": ("upper arm",), "shoulder": ("upper arm", "forearm")}
    for touch in interaction.touches:
        track = found.target if touch.by == "target" else found.partner
        parts = limbs.get(touch.limb, ("upper arm", "forearm", "hand"))
        touched = ["shoulders", *(f"{side} {part}" for side in SIDES for part in parts)]
        for side, contact in track.contacts.items():
            for mine in (f"{side} hand", f"{side} forearm"):
                for limb in touched:
                    pair = (mine, limb) if touch.by == "target" else (limb, mine)
                    pairs[pair] = np.maximum(pairs.get(pair, 0.0), contact.share)
    return pairs


def test_every_emotion_has_its_interactions() -> None:
    assert list(DYADS) == list(EMOTIONS)
    assert len({name for names in DYADS.values() for name in names}) == NUM_DYADS * len(EMOTIONS)
    for emotion, take in EVERY:
        assert tracks(emotion, take, CASTS[0]).name == DYADS[emotion][take]


@every_dyad
def test_both_play_one_closed_cycle_of_five_to_ten_seconds(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        found = tracks(emotion, take, cast)
        target, partner = (motion(track, emotion) for track in (found.target, found.partner))
        assert target.num_frames == partner.num_frames
        assert 5.0 <= target.duration_s <= 10.0
        for played in (target, partner):
            excess_m, excess_rad = seam_step(played)
            assert excess_m < 0.01
            assert excess_rad < np.deg2rad(5.0)
            np.testing.assert_allclose(played.root_translation[0, [0, 2]], 0.0, atol=1e-12)
            forward = quaternion_rotate(played.joint_rotations[0, 0], [0.0, 0.0, 1.0])
            assert forward[2] > np.cos(np.deg2rad(15.0))


@every_dyad
def test_feet_are_planted_above_the_floor(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        for who in ("target", "partner"):
            positions, _ = pose(emotion, take, cast, who)
            assert positions[..., 1].min() > 0.0185, (cast, who)
            for side in SIDES:
                toe = joint(positions, f"{side}_foot")
                before = np.roll(toe, 1, axis=0)
                step = np.linalg.norm((toe - before)[:, [0, 2]], axis=1)
                planted = (toe[:, 1] < 0.0205) & (before[:, 1] < 0.0205)
                assert planted.mean() > 0.6, (cast, who)
                assert step[planted].sum() < 0.01, (cast, who)


@every_dyad
def test_knees_and_elbows_bend_the_right_way(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        for who in ("target", "partner"):
            positions, _ = pose(emotion, take, cast, who)
            local = solve_body(getattr(tracks(emotion, take, cast), who))[1]
            across = joint(positions, "left_hip") - joint(positions, "right_hip")
            forward = np.cross(across, [0.0, 1.0, 0.0])
            for side, sign in (("left", 1.0), ("right", -1.0)):
                hip, knee, ankle = (
                    joint(positions, f"{side}_{name}") for name in ("hip", "knee", "ankle")
                )
                assert ((knee - 0.5 * (hip + ankle)) * forward).sum(axis=1).min() > 0.0
                forearm = quaternion_rotate(joint(local, f"{side}_elbow"), [sign, 0.0, 0.0])
                assert forearm[:, 2].min() > -0.05
                assert np.abs(forearm[:, 1]).max() < 0.05


@every_dyad
def test_no_joint_flips_from_one_frame_to_the_next(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        for who in ("target", "partner"):
            positions, rotations = pose(emotion, take, cast, who)
            same = np.abs((rotations * np.roll(rotations, 1, axis=0)).sum(axis=-1))
            step = 2.0 * np.arccos(np.clip(same, 0.0, 1.0))
            toes = [JOINT_NAMES.index(f"{side}_foot") for side in SIDES]
            assert np.rad2deg(np.delete(step, toes, axis=1)).max() < 48.0, (cast, who)
            speed = np.linalg.norm(positions - np.roll(positions, 1, axis=0), axis=-1) * 30.0
            assert speed.max() < 7.5, (cast, who)


@every_dyad
def test_wrists_keep_out_of_the_own_trunk(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        for who in ("target", "partner"):
            positions, _ = pose(emotion, take, cast, who)
            low, high = joint(positions, "pelvis"), joint(positions, "neck")
            for side in SIDES:
                wrist = joint(positions, f"{side}_wrist")
                away = segment_distance(low, high, wrist, wrist + np.array([0.0, 1e-6, 0.0]))
                assert away.min() > 0.125, (cast, who, side)


@every_dyad
def test_bodies_meet_nowhere_but_at_their_contacts(emotion: Emotion, take: int) -> None:
    for cast in CASTS:
        found = tracks(emotion, take, cast)
        meant = touching(interaction_of(emotion, take), found)
        bodies = [capsules(*pose(emotion, take, cast, who)) for who in ("target", "partner")]
        for name, (start, end, radius) in bodies[0].items():
            for other, (other_start, other_end, other_radius) in bodies[1].items():
                gap = segment_distance(start, end, other_start, other_end) - radius - other_radius
                free = gap[meant.get((name, other), np.zeros(len(gap))) < 0.02]
                assert free.size == 0 or free.min() > -0.01, (cast, name, other)


@every_dyad
def test_hands_are_where_they_touch(emotion: Emotion, take: int) -> None:
    interaction = interaction_of(emotion, take)
    for cast in CASTS:
        found = tracks(emotion, take, cast)
        assert bool(found.target.contacts or found.partner.contacts) == bool(
            interaction.clasps or interaction.touches
        )
        for who in ("target", "partner"):
            track: BodyTrack = getattr(found, who)
            positions = BODY.forward_kinematics(*solve_body(track))[0]
            for side, contact in track.contacts.items():
                held = contact.share > 0.99
                miss = np.linalg.norm(joint(positions, f"{side}_wrist") - contact.position, axis=1)
                assert held.any(), (cast, who, side)
                assert miss[held].max() < 0.01, (cast, who, side)


def palm(
    emotion: Emotion, take: int, cast: tuple[str, str, float], who: Who, side: Side
) -> FloatArray:
    """Skin of a palm in the target's frame, `(n, 3)`."""
    positions, rotations = pose(emotion, take, cast, who)
    way = PALM * [1.0 if side == "left" else -1.0, 1.0, 1.0]
    return joint(positions, f"{side}_wrist") + quaternion_rotate(
        joint(rotations, f"{side}_wrist"), way
    )


@pytest.mark.parametrize("name", ["celebrate", "greet", "hand_over", "farewell"])
def test_palms_meet_in_a_clasp_and_part_again(name: str) -> None:
    emotion, take = EVERY[NAMES.index(name)]
    for cast in CASTS:
        found = tracks(emotion, take, cast)
        together = 0
        for side, contact in found.target.contacts.items():
            for other, others in found.partner.contacts.items():
                gap = np.linalg.norm(
                    palm(emotion, take, cast, "target", side)
                    - palm(emotion, take, cast, "partner", other),
                    axis=1,
                )
                held = np.minimum(contact.share, others.share) > 0.99
                if not np.array_equal(contact.share, others.share):
                    continue
                together += 1
                assert gap[held].max() < 0.03, (cast, side)
                assert gap.max() > 0.25, (cast, side)
        assert together == (2 if name == "farewell" else 1)


def test_a_comforting_hand_lies_on_the_shoulder() -> None:
    emotion, take = EVERY[NAMES.index("comfort")]
    for cast in CASTS:
        found = tracks(emotion, take, cast)
        ((side, contact),) = found.partner.contacts.items()
        held = contact.share > 0.99
        positions, _ = pose(emotion, take, cast, "target")
        hand = palm(emotion, take, cast, "partner", side)
        shoulder = joint(
            positions, f"{'left' if performer(cast[0]).hand == 'right' else 'right'}_shoulder"
        )
        assert np.linalg.norm(hand - shoulder, axis=1)[held].max() < 0.10
        assert (hand - shoulder)[held, 1].min() > 0.03


def test_who_chats_looks_at_the_other_and_who_grieves_does_not() -> None:
    chat, farewell = (EVERY[NAMES.index(name)] for name in ("chat", "farewell"))
    assert seen_angle(*chat, "target").mean() < 25.0
    assert seen_angle(*chat, "partner").mean() < 25.0
    assert seen_angle(*EVERY[NAMES.index("accuse")], "target").mean() < 15.0
    assert seen_angle(*farewell, "target").mean() > 22.0


def test_the_partner_looks_where_the_target_points_and_later() -> None:
    emotion, take = EVERY[NAMES.index("directions")]
    angles = [seen_angle(emotion, take, who) for who in ("target", "partner")]
    first = [int(np.argmax(angle > 35.0)) for angle in angles]
    assert all(angle.max() > 40.0 for angle in angles)
    assert 0.2 <= (first[1] - first[0]) / 30.0 <= 0.7


def test_a_startle_comes_after_what_startles() -> None:
    emotion, take = EVERY[NAMES.index("startle")]
    raised = [
        np.max([joint(pose(emotion, take, CASTS[0], who)[0], f"{s}_wrist")[:, 1] for s in SIDES], 0)
        for who in ("partner", "target")
    ]
    jump, start = (int(np.argmax(height > 0.5 * (height.max() + height[0]))) for height in raised)
    assert 0.1 <= (start - jump) / 30.0 <= 0.6
    gap = tracks(emotion, take, CASTS[0])
    away = gap.target.pelvis_position[:, 2]
    assert away.min() < -0.15


@every_dyad
def test_partners_are_within_reach_of_a_talk(emotion: Emotion, take: int) -> None:
    pelvises = [
        joint(pose(emotion, take, CASTS[0], who)[0], "pelvis")[:, [0, 2]]
        for who in ("target", "partner")
    ]
    apart = np.linalg.norm(pelvises[0] - pelvises[1], axis=1)
    assert apart.min() > 0.45
    assert apart.max() < 1.65
    found = tracks(emotion, take, CASTS[0])
    if DYADS[emotion][take] == "cling":
        assert found.T_target_partner[2, 2] > 0.95
    else:
        assert found.T_target_partner[2, 2] < -0.9


def test_the_louder_of_two_who_argue_is_the_target() -> None:
    speeds = []
    for who in ("target", "partner"):
        positions, _ = pose("angry", 0, CASTS[0], who)
        hands = positions[:, [JOINT_NAMES.index(f"{side}_wrist") for side in SIDES]]
        speeds.append(np.linalg.norm(hands - np.roll(hands, 1, axis=0), axis=2).mean() * 30.0)
    assert speeds[0] > 1.2 * speeds[1]


@pytest.mark.parametrize("name", ["argue", "accuse", "dismiss", "startle", "celebrate"])
def test_intensity_makes_movement_larger(name: str) -> None:
    emotion, take = EVERY[NAMES.index(name)]
    paths = []
    for intensity in (0.4, 1.4):
        positions, _ = pose(emotion, take, ("p1", "p2", intensity), "target")
        moving = positions[:, [JOINT_NAMES.index(part) for part in EXTREMITIES]]
        paths.append(np.linalg.norm(np.diff(moving, axis=0), axis=2).sum())
    assert paths[1] > 1.2 * paths[0]


def test_performers_differ_and_the_same_seed_gives_the_same_bytes() -> None:
    one, two = (
        perform_dyad("sad", ("p1", "p2"), take=0, rng=np.random.default_rng(5)) for _ in range(2)
    )
    assert one.target.joint_rotations.tobytes() == two.target.joint_rotations.tobytes()
    assert one.partner.root_translation.tobytes() == two.partner.root_translation.tobytes()
    assert one.T_target_partner.tobytes() == two.T_target_partner.tobytes()
    other = perform_dyad("sad", ("p1", "p2"), take=0, rng=np.random.default_rng(6))
    assert one.target.joint_rotations.tobytes() != other.target.joint_rotations.tobytes()
    someone = perform_dyad("sad", ("p3", "p2"), take=0, rng=np.random.default_rng(5))
    assert someone.target.num_frames != one.target.num_frames or not np.allclose(
        someone.target.joint_rotations, one.target.joint_rotations, atol=0.02
    )


def test_left_handed_targets_play_the_mirror_image_of_a_comfort() -> None:
    left = dataclasses.replace(performer("p1"), hand="left")
    right = dataclasses.replace(performer("p1"), hand="right")
    places = [
        dyad_tracks(
            "sad", 0, who, performer("p2"), intensity=1.0, rng=np.random.default_rng(3)
        ).T_target_partner[0, 3]
        for who in (left, right)
    ]
    assert places[0] < -0.1 < 0.1 < places[1]


def test_an_unknown_interaction_says_which_there_are() -> None:
    who = performer("p1"), performer("p2")
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match=r"'sad': take must be one of 0 \(comfort\).*got 3"):
        dyad_tracks("sad", 3, *who, intensity=1.0, rng=rng)
    with pytest.raises(ValueError, match=r"emotion must be one of angry, .* got 'bored'"):
        dyad_tracks("bored", 0, *who, intensity=1.0, rng=rng)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="two performers, got 'p1' twice"):
        perform_dyad("sad", ("p1", "p1"), rng=rng)
