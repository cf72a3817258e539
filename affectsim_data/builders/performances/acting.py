"""Puts a script on a body, a performer and an intensity."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.builders.performances.arms import Place, Vector, move_arm
from affectsim_data.builders.performances.curves import FPS, cycle_phase, follow, keyframes
from affectsim_data.builders.performances.footsteps import Step, step_feet
from affectsim_data.builders.performances.living import (
    breathe,
    glances,
    limit_head,
    sway,
    tremble,
)
from affectsim_data.builders.performances.paths import paced
from affectsim_data.builders.performances.rig import (
    SIGN,
    TOE_OFFSET,
    BodyTrack,
    foot_rotation,
)
from affectsim_data.builders.performances.scripts import ARMS, Arm, Channel, Script
from affectsim_data.builders.performances.styles import (
    GAITS,
    POSTURES,
    TEMPO,
    Expression,
    Performer,
    Posture,
    Side,
    blend_loosely,
)
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray, quaternion_rotate
from affectsim_data.skeletons import BODY

__all__ = ["SEAT_BACK_M", "SEAT_HEIGHT_M", "act", "choose"]

SEAT_HEIGHT_M = 0.45
SEAT_BACK_M = 0.40
"""Way of the pelvis from standing to the seat, backward: a thigh's length."""
_PELVIS_M = SEAT_HEIGHT_M + 0.10
"""The pelvis joint lies about 10 cm above what one sits on."""
_STANDING_M = BODY.hip_height - 0.015
_TOES_OUT = np.deg2rad(9.0)
_SEAT_TILT = np.deg2rad(-7.0)
"""A seat tips the pelvis back; the trunk comes forward again above it."""
_LEAST_SHOWN, _MOST_SHOWN = 0.3, 1.3
_RESPONSE_HZ = (0.7, 3.8)
_LONGEST_S = 8.8
_EXACT: tuple[Channel, ...] = ("seated", "rise", "heels", "forward")
"""Channels that are played as written: they must fit a seat, a floor, a door."""
_UNEVEN = 0.4
_MISS_TOUCH_M, _MISS_AIR_M = 0.012, 0.05
"""How far hands miss a place on the body and in the air, in somebody as loose as 1."""
_MIDDLE_ARM = np.array([0.05, -0.36, 0.20])
"""Wrist of an arm that is neither raised nor at rest; gestures grow from there."""
_KICK_M = np.array([0.10, 0.22])
"""Up and forward way of the ankle of a leg swung out, sitting."""


@dataclasses.dataclass(frozen=True)
class _Show:
    """A script on its way to a body."""

    script: Script
    who: Performer
    rng: np.random.Generator
    phase: FloatArray
    time: FloatArray
    """Phase of the script at each frame: nobody keeps time exactly."""
    hz: float
    """How promptly the body follows."""
    shown: float
    """Factor on turns of trunk and head."""
    size: float
    """Factor on gestures."""
    gains: Mapping[Channel, float]
    """Factor on each channel of the script."""

    def side(self, arm: Arm) -> Side:
        """Which side an arm or leg of the script is on."""
        return self.who.hand if arm == "hand" else self.who.other_hand

    def curve(self, channel: Channel, *, damping: float = 0.75) -> FloatArray:
        """A channel as the script has it, `(n,)`."""
        keys = self.script.channels.get(channel)
        if not keys:
            return np.zeros(len(self.phase))
        timed = [(at / self.script.length_s, value) for at, value in keys]
        curve = follow(keyframes(self.time, timed), hz=self.hz, damping=damping)
        return self.gains[channel] * curve

    def turn(self, part: str) -> FloatArray:
        """Pitch, yaw and roll of trunk or head, radians, `(n, 3)`."""
        names: tuple[Channel, Channel, Channel] = (
            ("trunk_pitch", "trunk_yaw", "trunk_roll")
            if part == "trunk"
            else ("head_pitch", "head_yaw", "head_roll")
        )
        sign = SIGN[self.who.hand]
        turns = np.stack([self.curve(name) for name in names], axis=1)
        radians: FloatArray = np.deg2rad(turns * [1.0, sign, -sign]) * self.shown
        return radians


def act(
    script: Script,
    emotion: Emotion,
    who: Performer,
    *,
    expression: Expression,
    rng: np.random.Generator,
    seated: bool,
    plain: bool = False,
) -> BodyTrack:
    """A script performed: one closed cycle.

    Args:
        script: What is done when.
        emotion: In which posture and how promptly.
        who: The performer.
        expression: How strongly the emotion shows, 1 as written.
        rng: Noise of this take.
        seated: Sits on a seat under the origin throughout; else stands, but for the channel
            `seated`, which lowers the body to a seat behind.
        plain: The script is an everyday one, done in the manner of the emotion.
    """
    calm = POSTURES["neutral"]
    posture, moved = (
        blend_loosely(POSTURES[emotion], calm, min(share, _MOST_SHOWN), expression.loose, rng)
        for share in (expression.posture, expression.snap)
    )
    written = 1.0 if plain else TEMPO[emotion]
    tempo = who.tempo * (1.0 + (TEMPO[emotion] - 1.0) * expression.pace) / written
    tempo = max(tempo, script.length_s / _LONGEST_S)
    phase = cycle_phase(round(script.length_s / tempo * FPS))
    hz = (script.hz or moved.response_hz) * tempo * float(np.exp(0.2 * rng.normal()))
    everyday = plain or emotion == "neutral"
    shown, size = (
        1.0 if everyday else min(_LEAST_SHOWN + (1.0 - _LEAST_SHOWN) * share, _MOST_SHOWN)
        for share in (expression.posture, expression.size)
    )
    gains = {
        name: 1.0 if name in _EXACT else float(np.exp(0.7 * expression.loose * rng.normal()))
        for name in script.channels
    }
    time = paced(phase, _UNEVEN * expression.loose, rng)
    show = _Show(
        script, who, rng, phase, time, float(np.clip(hz, *_RESPONSE_HZ)), shown, size, gains
    )
    track = _body(show, posture.crouch_m, seated=seated)
    track.shrug += np.deg2rad(posture.shrug_deg)
    if plain:
        _bear(track, posture)
    breathe(track, moved)
    sway(track, phase, who, rng, seated=seated)
    wander = GAITS[emotion].look_deg * expression.posture if plain else script.glances_deg * shown
    _look_about(show, track, np.deg2rad(wander))
    limit_head(track)
    for arm in ARMS:
        keys = [
            (at / script.length_s, _grown(show, arm, place, expression.loose))
            for at, place in script.arms[arm]
        ]
        promptly = show.hz * float(np.exp(0.4 * expression.loose * rng.normal()))
        move_arm(track, show.side(arm), keys, phase=show.time, hz=promptly)
    tremble(track, phase, moved.tremor_m * rng.uniform(0.2, 1.0), rng)
    return track


def choose(
    scripts: Mapping[Emotion, Sequence[Script]],
    emotion: Emotion,
    who: Performer,
    take: int,
    expression: Expression,
) -> tuple[Script, bool]:
    """Which script a take plays, and whether it is an everyday one: restrained people play those.

    Args:
        scripts: Ways to do it for every emotion; the neutral ones are the everyday ones.
        emotion: What is felt.
        who: The performer, whose own way comes first.
        take: Which repetition; ways alternate.
        expression: How strongly it shows.
    """
    plain = expression.restrained
    ways = scripts["neutral" if plain else emotion]
    return ways[(who.habit + take) % len(ways)], plain


def _bear(track: BodyTrack, posture: Posture) -> None:
    """Bows or lifts trunk and head of an everyday script as an emotion does."""
    calm = POSTURES["neutral"]
    pitch = np.deg2rad(posture.trunk_pitch_deg - calm.trunk_pitch_deg)
    track.trunk_turn[:, 0] += 0.75 * pitch
    track.pelvis_turn[:, 0] += 0.25 * pitch
    track.head_turn[:, 0] += np.deg2rad(posture.head_pitch_deg - calm.head_pitch_deg)


def _body(show: _Show, crouch_m: float, *, seated: bool) -> BodyTrack:
    """Pelvis, trunk, head and legs."""
    who, count = show.who, len(show.phase)
    down = np.ones(count) if seated else np.clip(show.curve("seated", damping=1.0), 0.0, 1.0)
    ankles, feet = _feet(show, 0.40 if seated else 0.0)
    standing = _STANDING_M - crouch_m
    position = np.zeros((count, 3))
    position[:, 0] = SIGN[who.hand] * show.curve("aside") * show.shown
    position[:, 1] = standing + down * (_PELVIS_M - standing) + show.curve("rise")
    position[:, 2] = show.curve("forward") * show.shown
    if not seated:
        position[:, 2] -= SEAT_BACK_M * np.sin(0.5 * np.pi * down)
        position[:, 1] += 0.11 * np.sin(np.deg2rad(np.maximum(show.curve("heels"), 0.0)))
    trunk, head = show.turn("trunk"), show.turn("head")
    trunk[:, 0] += np.deg2rad(who.trunk_pitch_deg)
    head[:, 0] += np.deg2rad(who.head_pitch_deg)
    # Weight has to stay over the feet: the trunk leans most half way down.
    bend = 4.0 * down * (1.0 - down)
    pelvis = np.zeros_like(position)
    pelvis[:, 0] = down * _SEAT_TILT + np.deg2rad(22.0) * bend + 0.25 * trunk[:, 0]
    pelvis[:, 1] = (1.0 - down) * 0.25 * trunk[:, 1]
    pelvis[:, 2] = 0.3 * trunk[:, 2]
    trunk = trunk * [0.75, 0.85, 0.7]
    trunk[:, 0] += np.deg2rad(15.0) * bend - 0.8 * down * _SEAT_TILT
    head[:, 0] -= np.deg2rad(16.0) * bend
    shrug = np.deg2rad(show.curve("shrug") * show.shown + who.shrug_deg)
    return BodyTrack(position, pelvis, trunk, head, shrug, {}, {}, {}, ankles, feet)


def _feet(show: _Show, forward: float) -> tuple[dict[Side, FloatArray], dict[Side, FloatArray]]:
    """Ankles and feet: planted, but for steps, taps, lifted heels and kicks."""
    script, length_s = show.script, show.script.length_s
    half_width = 0.10 * show.who.stance
    stance: dict[Side, tuple[float, float, float]] = {}
    steps = []
    for arm in ARMS:
        side = show.side(arm)
        out, ahead, _ = script.feet.get(arm, (0.0, 0.0, 0.0))
        x, z = SIGN[side] * (half_width + out), forward + ahead
        stance[side] = (x, z, SIGN[side] * _TOES_OUT)
        steps += [
            Step(
                side,
                step.start_s / length_s,
                step.end_s / length_s,
                x + SIGN[side] * step.out,
                z + step.forward,
                stance[side][2],
                step.lift_m,
            )
            for step in script.steps
            if step.foot == arm
        ]
    ankles, feet = step_feet(show.time, stance, steps)
    for arm in ARMS:
        side = show.side(arm)
        lifted = show.curve("heels") + script.feet.get(arm, (0.0, 0.0, 0.0))[2] + _taps(show, arm)
        _pitch_foot(ankles[side], feet[side], np.deg2rad(lifted))
        kick = show.curve("kick_hand" if arm == "hand" else "kick_other") * show.size
        ankles[side][:, 1:] += np.clip(kick, 0.0, None)[:, None] * _KICK_M
        feet[side][:, 1] -= np.deg2rad(15.0) * np.clip(kick, 0.0, None)
    return ankles, feet


def _taps(show: _Show, arm: Arm) -> FloatArray:
    """Degrees a foot is lifted by tapping, `(n,)`."""
    lifted = np.zeros(len(show.phase))
    at_s = show.time * show.script.length_s
    for tap in show.script.taps:
        if tap.foot == arm:
            turns = max(round(tap.hz * (tap.end_s - tap.start_s)), 1)
            within = np.clip((at_s - tap.start_s) / (tap.end_s - tap.start_s), 0.0, 1.0)
            lifted += tap.degrees * show.shown * np.sin(np.pi * turns * within) ** 2
    return lifted


def _pitch_foot(ankle: FloatArray, feet: FloatArray, pitch: FloatArray) -> None:
    """Turns a foot in place: about its toe base if the heel lifts, about its heel otherwise."""
    flat = quaternion_rotate(foot_rotation(feet), TOE_OFFSET)
    feet[:, 1] += pitch
    pivot = np.stack([feet[:, 0], np.maximum(feet[:, 1], 0.0)], axis=1)
    ankle += flat - quaternion_rotate(foot_rotation(pivot), TOE_OFFSET)
    # The heel, 5 cm behind the ankle, would sink into the floor while the toes are up.
    ankle[:, 1] += 0.05 * np.sin(np.maximum(-feet[:, 1], 0.0))


def _look_about(show: _Show, track: BodyTrack, wide: float) -> None:
    """Head and, a little, trunk turn where the eyes wander, `wide` radians."""
    length_s = len(show.phase) / FPS
    look = wide * glances(show.phase, max(round(length_s / 0.9), 2), show.rng)
    track.head_turn[:, 1] += 0.8 * look
    track.trunk_turn[:, 1] += 0.25 * look


def _grown(show: _Show, arm: Arm, place: Place, loose: float) -> Place:
    """A place in the air as far out as performer and intensity have it; on the body, as it is."""
    who = show.who
    out, up, forward = place.pole
    pole = (out * (0.7 + 0.8 * who.elbow_out), up, forward)
    missed = loose * show.rng.normal(size=3).clip(-2.0, 2.0)
    if place.anchor == "floor":
        return dataclasses.replace(place, pole=pole)
    if place.anchor != "shoulder":
        near = np.array(place.offset) + _MISS_TOUCH_M * missed
        return _moved(place, near, pole)
    resting = place.offset[1] < -0.5
    size = 1.0 if resting else who.reach * show.size
    size *= 1.0 + (who.asymmetry if arm == "hand" else -who.asymmetry) * (0.0 if resting else 0.5)
    offset = _MIDDLE_ARM + (np.array(place.offset) - _MIDDLE_ARM) * size
    offset += [who.hands_out_m, 0.0 if resting else who.raise_m, 0.0]
    return _moved(place, offset + _MISS_AIR_M * missed, pole)


def _moved(place: Place, offset: FloatArray, pole: Vector) -> Place:
    out, up, forward = (float(value) for value in offset)
    return dataclasses.replace(place, offset=(out, up, forward), pole=pole)
