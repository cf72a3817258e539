"""Standing and sitting: an upper body on planted feet or on a seat."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.curves import curve, cycle_phase, keyframes, noise, wave
from affectsim_data.builders.performances.gestures import UpperBody, Vector, upper_body
from affectsim_data.builders.performances.rig import (
    SIDES,
    SIGN,
    TOE_OFFSET,
    BodyTrack,
    foot_rotation,
)
from affectsim_data.builders.performances.styles import POSTURES, Performer, Side
from affectsim_data.builders.performances.walking import FPS
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = [
    "SEAT_HEIGHT_M",
    "gesture_track",
    "knock_track",
    "listening_track",
    "seated_track",
    "sit_down_track",
]

SEAT_HEIGHT_M = 0.45
_SEATED_PELVIS_M = SEAT_HEIGHT_M + 0.10
"""The pelvis joint lies about 10 cm above what one sits on."""
_SIT_BACK_M = 0.40
"""Way of the pelvis from standing to the seat, backward: a thigh's length."""
HANGING: Vector = (0.06, -0.525, 0.05)
ON_THIGH: Vector = (-0.02, -0.40, 0.30)
"""Low enough to rest on the thigh however the trunk leans; `_on_thighs` stops it there."""
_THIGH_TOP_M = 0.645
"""Height of a wrist whose hand lies on the thigh."""
_SHOULDER_M = 0.44
"""Height of the shoulders above the pelvis, sitting straight."""
_ANKLE_M = float(BODY.rest_positions[JOINT_NAMES.index("left_ankle"), 1])


def _frames(emotion: Emotion, who: Performer) -> int:
    return round(POSTURES[emotion].cycle_s / who.tempo * FPS)


def gesture_track(
    emotion: Emotion,
    who: Performer,
    *,
    rng: np.random.Generator,
    size: float = 1.0,
    num_frames: int | None = None,
) -> BodyTrack:
    """Standing, expressing an emotion with the whole body.

    Args:
        emotion: What is felt.
        who: The performer.
        rng: Noise of this take.
        size: Factor on the gestures.
        num_frames: Length of the cycle; by default the emotion's own.
    """
    phase = cycle_phase(num_frames or _frames(emotion, who))
    body = upper_body(emotion, phase, who, rest=HANGING, size=size, rng=rng)
    return _standing(emotion, phase, who, body, rng=rng)


def listening_track(num_frames: int, who: Performer, *, rng: np.random.Generator) -> BodyTrack:
    """Standing still, arms down, nodding now and then."""
    phase = cycle_phase(num_frames)
    body = upper_body("neutral", phase, who, rest=HANGING, size=0.0, rng=rng)
    nods = curve(
        phase,
        (0.0, 0.3, 0.34, 0.38, 0.42, 0.47, 0.8, 0.84, 0.89),
        (0.0, 0.0, 5.0, 0.0, 5.0, 0.0, 0.0, 4.0, 0.0),
    )
    body.head[:, 0] += np.deg2rad(nods)
    body.head[:, 1] *= 0.3
    return _standing("neutral", phase, who, body, rng=rng)


def knock_track(emotion: Emotion, who: Performer, *, rng: np.random.Generator) -> BodyTrack:
    """Knocks on a door 0.65 m ahead with the preferred hand, waits, and knocks again."""
    phase = cycle_phase(round(0.8 * _frames(emotion, who)))
    body = upper_body(emotion, phase, who, rest=HANGING, size=0.25, rng=rng)
    hard = {"angry": 1.5, "happy": 1.1, "neutral": 1.0, "fearful": 0.6, "sad": 0.6}[emotion]
    raised = np.array([0.0, 0.04 + who.raise_m, 0.44])
    back = raised - [0.0, -0.02 * hard, 0.11 * hard]
    pulses = [(0.18 + 0.06 * n, raised if n % 2 else back) for n in range(8)]
    rest = np.array(HANGING)
    keys = [(0.0, rest), *pulses, (0.78, rest), (0.92, rest)]
    body.wrists[who.hand] = keyframes(phase, keys)
    body.elbows[who.hand] = np.tile([0.3, -1.0, -0.2], (len(phase), 1))
    return _standing(emotion, phase, who, body, rng=rng)


def seated_track(emotion: Emotion, who: Performer, *, rng: np.random.Generator) -> BodyTrack:
    """Sitting on a seat 0.45 m high, expressing an emotion above the hips."""
    phase = cycle_phase(_frames(emotion, who))
    body = upper_body(emotion, phase, who, rest=ON_THIGH, size=1.0, rng=rng)
    position = np.zeros((len(phase), 3))
    position[:, 1] = _SEATED_PELVIS_M + 0.015 * np.maximum(body.bounce, 0.0)
    position[:, 2] = -0.1 * body.recoil
    ankles, feet = _planted(len(phase), 0.10 * who.stance, 0.40)
    # A seat tips the pelvis back; the trunk comes forward again above it.
    pelvis = np.zeros_like(position)
    pelvis[:, 0] = np.deg2rad(-6.0)
    body.trunk[:, 0] += np.deg2rad(6.0 if emotion != "sad" else 14.0)
    _on_thighs(body, position[:, 1], pelvis[:, 0] + body.trunk[:, 0])
    return _track(position, pelvis, body, ankles, feet)


def _on_thighs(body: UpperBody, pelvis_m: FloatArray, pitch: FloatArray) -> None:
    """Keeps wrists above the thighs, and low ones where the thighs are, as the trunk leans."""
    lowest = _THIGH_TOP_M - pelvis_m - _SHOULDER_M * np.cos(pitch)
    for side, wrist in body.wrists.items():
        low = np.clip((lowest + 0.08 - wrist[:, 1]) / 0.08, 0.0, 1.0)
        wrist[:, 1] = np.maximum(wrist[:, 1], lowest)
        wrist[:, 2] -= 0.6 * low * _SHOULDER_M * np.sin(pitch)
        body.wrists[side] = wrist


def sit_down_track(emotion: Emotion, who: Performer, *, rng: np.random.Generator) -> BodyTrack:
    """Sits down on a seat 0.40 m behind, stays a moment, and gets up again."""
    phase = cycle_phase(round(1.1 * _frames(emotion, who)))
    body = upper_body(emotion, phase, who, rest=HANGING, size=0.15, rng=rng)
    seated = curve(phase, (0.0, 0.12, 0.4, 0.66, 0.92), (0.0, 0.0, 1.0, 1.0, 0.0))
    # Weight has to stay over the feet: the trunk leans most half way.
    bend = 4.0 * seated * (1.0 - seated)
    position = np.zeros((len(phase), 3))
    standing = BODY.hip_height - 0.015 - 0.3 * POSTURES[emotion].crouch_m
    position[:, 1] = standing + seated * (_SEATED_PELVIS_M - standing)
    position[:, 2] = -_SIT_BACK_M * np.sin(0.5 * np.pi * seated)
    pelvis = np.zeros_like(position)
    pelvis[:, 0] = np.deg2rad(22.0) * bend
    body.trunk[:, 0] += np.deg2rad(16.0) * bend
    body.head[:, 0] -= np.deg2rad(14.0) * bend
    for side in SIDES:
        rest = np.array(ON_THIGH) - np.array(HANGING)
        body.wrists[side] = body.wrists[side] + seated[:, None] * rest
    ankles, feet = _planted(len(phase), 0.11 * who.stance, 0.0)
    return _track(position, pelvis, body, ankles, feet)


def _standing(
    emotion: Emotion,
    phase: FloatArray,
    who: Performer,
    body: UpperBody,
    *,
    rng: np.random.Generator,
) -> BodyTrack:
    """The lower body under an upper one: weight shifts, knees give, heels lift, feet step."""
    posture = POSTURES[emotion]
    count = len(phase)
    ankles, feet = _planted(count, posture.stance_m * who.stance, 0.0)
    if emotion == "fearful":
        _step_back(body, phase, who, ankles)
    elif emotion == "angry":
        _stamp(phase, who, ankles)
    position = np.zeros((count, 3))
    weight = 0.018 if emotion != "sad" else 0.03
    position[:, 0] = weight * wave(phase, 1, 0.15) + noise(phase, amplitude=0.004, rng=rng)
    position[:, 2] = -body.recoil + noise(phase, amplitude=0.004, rng=rng)
    spring = np.maximum(body.bounce, 0.0)
    amount = 0.075 if emotion == "happy" else 0.03
    lift = np.clip(spring - 0.5, 0.0, 1.0) * 2.0
    for side in SIDES:
        _raise_heel(ankles[side], feet[side], np.deg2rad(24.0) * lift * (emotion == "happy"))
    position[:, 1] = BODY.hip_height - 0.015 - posture.crouch_m
    position[:, 1] += amount * (spring - (0.6 if emotion == "happy" else 0.0))
    position[:, 1] += 0.08 * np.minimum(body.bounce, 0.0)
    pelvis = np.zeros_like(position)
    pelvis[:, 0] = 0.25 * body.trunk[:, 0]
    pelvis[:, 1] = 0.25 * body.trunk[:, 1]
    body.trunk = body.trunk * [0.75, 0.75, 1.0]
    return _track(position, pelvis, body, ankles, feet)


def _planted(
    num_frames: int, half_width: float, forward: float
) -> tuple[dict[Side, FloatArray], dict[Side, FloatArray]]:
    """Ankles and feet that stay where they are, toes a little out."""
    ankles, feet = {}, {}
    for side in SIDES:
        place = [SIGN[side] * half_width, _ANKLE_M, forward]
        ankles[side] = np.tile(np.array(place), (num_frames, 1))
        feet[side] = np.tile([SIGN[side] * np.deg2rad(9.0), 0.0], (num_frames, 1))
    return ankles, feet


def _raise_heel(ankle: FloatArray, feet: FloatArray, pitch: FloatArray) -> None:
    """Turns a flat foot about its toe base, in place."""
    flat = quaternion_rotate(yaw_quaternion(feet[:, 0]), TOE_OFFSET)
    feet[:, 1] = pitch
    ankle += flat - quaternion_rotate(foot_rotation(feet), TOE_OFFSET)


def _step_back(
    body: UpperBody, phase: FloatArray, who: Performer, ankles: dict[Side, FloatArray]
) -> None:
    """One foot steps back as the body recoils, and forward again as it calms; then the other."""
    for side, times in (
        (who.hand, (0.02, 0.10, 0.30, 0.42)),
        (who.other_hand, (0.54, 0.62, 0.78, 0.92)),
    ):
        off, on, up, down = times
        away = keyframes(phase, [(off, 0.0), (on, 1.0), (up, 1.0), (down, 0.0)])
        ankles[side][:, 2] -= 0.24 * away
        ankles[side][:, 1] += 0.05 * 4.0 * away * (1.0 - away)


def _stamp(phase: FloatArray, who: Performer, ankles: dict[Side, FloatArray]) -> None:
    """The foot beside the pointing hand stamps once, after the fists have come down."""
    lift = curve(phase, (0.83, 0.905, 0.95), (0.0, 1.0, 0.0))
    ankles[who.other_hand][:, 1:] += lift[:, None] * [0.13, 0.05]


def _track(
    position: FloatArray,
    pelvis: FloatArray,
    body: UpperBody,
    ankles: dict[Side, FloatArray],
    feet: dict[Side, FloatArray],
) -> BodyTrack:
    return BodyTrack(
        position,
        pelvis,
        body.trunk,
        body.head,
        body.shrug,
        body.wrists,
        body.elbows,
        body.palms,
        ankles,
        feet,
    )
