"""What arms, head and trunk do in each emotion, whether the body stands or sits.

Every function here gives a cycle of keyframes: wrists are `(out, up, forward)` from their shoulder
in metres, turns are degrees. The arm is 0.55 m long; the face is about (-0.12, 0.12, 0.17).
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from affectsim_data.builders.performances.curves import curve, keyframes, noise, wave
from affectsim_data.builders.performances.styles import POSTURES, Performer, Posture, Side
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray

__all__ = ["UpperBody", "Vector", "upper_body"]

Vector = tuple[float, float, float]


@dataclasses.dataclass
class UpperBody:
    """Curves of the upper body; arrays start with `num_frames`, angles in radians."""

    trunk: FloatArray
    """Pitch, yaw, roll, `(num_frames, 3)`."""
    head: FloatArray
    """Pitch, yaw, roll in the chest, `(num_frames, 3)`."""
    shrug: FloatArray
    """`(num_frames,)`."""
    wrists: dict[Side, FloatArray]
    """`(num_frames, 3)`, metres."""
    elbows: dict[Side, FloatArray]
    """`(num_frames, 3)`."""
    palms: dict[Side, FloatArray]
    """`(num_frames,)`."""
    recoil: FloatArray
    """How far the whole body draws back, metres, `(num_frames,)`."""
    bounce: FloatArray
    """How far it springs up, 0 to 1, `(num_frames,)`."""


@dataclasses.dataclass(frozen=True)
class _Cycle:
    """The setting a gesture is made in."""

    phase: FloatArray
    who: Performer
    rest: Vector
    """Wrist of an arm at rest."""
    size: float
    rng: np.random.Generator

    def reach(self, keys: list[tuple[float, Vector]]) -> FloatArray:
        """Wrist curve through keys, larger or smaller and higher or lower with the performer."""
        rest = np.array(self.rest)
        grown = [
            (at, rest + (np.array(key) - rest) * self.size + [0.0, self._lift(key), 0.0])
            for at, key in keys
        ]
        return keyframes(self.phase, grown)

    def _lift(self, key: Vector) -> float:
        return self.who.raise_m if key != self.rest else 0.0

    def turn(self, pitch: FloatArray, yaw: FloatArray, roll: FloatArray) -> FloatArray:
        """Angles in degrees, as `(num_frames, 3)` radians."""
        return np.deg2rad(np.stack([pitch, yaw, roll], axis=1))


def upper_body(
    emotion: Emotion,
    phase: FloatArray,
    who: Performer,
    *,
    rest: Vector,
    size: float,
    rng: np.random.Generator,
) -> UpperBody:
    """One cycle of an emotion's gestures.

    Args:
        emotion: What is felt.
        phase: Of each frame, in [0, 1).
        who: The performer.
        rest: Where a wrist rests, from its shoulder: beside the hip, or on the thigh.
        size: Factor on the size of gestures, beside the performer's own.
        rng: Noise of this take.
    """
    cycle = _Cycle(phase, who, rest, size * who.reach, rng)
    posture = POSTURES[emotion]
    body = _GESTURES[emotion](cycle, posture)
    sway = noise(phase, amplitude=np.deg2rad(1.2), rng=rng)
    breath = np.deg2rad(0.8) * wave(phase, 2)
    body.trunk += np.stack([breath, sway, noise(phase, amplitude=0.012, rng=rng)], axis=1)
    body.trunk[:, 0] += np.deg2rad(posture.trunk_pitch_deg + who.trunk_pitch_deg)
    body.head[:, 0] += np.deg2rad(posture.head_pitch_deg) + noise(phase, amplitude=0.02, rng=rng)
    body.shrug += np.deg2rad(posture.shrug_deg) + breath
    for side, wrist in body.wrists.items():
        wrist += np.stack([noise(phase, amplitude=0.005, rng=rng) for _ in range(3)], axis=1)
        if posture.tremor_m:
            shake = noise(phase, amplitude=posture.tremor_m, rng=rng, slowest=len(phase) // 7)
            body.wrists[side] = wrist + shake[:, None] * np.array([0.5, 1.0, 0.5])
    return body


def _still(cycle: _Cycle) -> UpperBody:
    """Arms at rest, head and trunk straight."""
    count = len(cycle.phase)
    out = 0.25 + 0.5 * cycle.who.elbow_out
    return UpperBody(
        trunk=np.zeros((count, 3)),
        head=np.zeros((count, 3)),
        shrug=np.zeros(count),
        wrists={side: np.tile(np.array(cycle.rest), (count, 1)) for side in ("left", "right")},
        elbows={side: np.tile([out, -0.5, -1.0], (count, 1)) for side in ("left", "right")},
        palms={side: np.zeros(count) for side in ("left", "right")},
        recoil=np.zeros(count),
        bounce=np.zeros(count),
    )


def _angry(cycle: _Cycle, posture: Posture) -> UpperBody:
    """Points at someone, twice, then pounds both fists down, twice; the head thrusts along."""
    body, phase, who = _still(cycle), cycle.phase, cycle.who
    body.wrists[who.hand] = cycle.reach(
        [
            (0.00, (0.08, -0.20, 0.22)),
            (0.07, (-0.04, 0.02, 0.53)),
            (0.15, (-0.04, 0.03, 0.52)),
            (0.22, (0.10, 0.06, 0.16)),
            (0.29, (-0.05, -0.02, 0.54)),
            (0.38, (-0.05, 0.00, 0.52)),
            (0.49, (0.10, 0.26, 0.16)),
            (0.57, (0.00, -0.24, 0.36)),
            (0.66, (0.08, 0.24, 0.18)),
            (0.74, (0.00, -0.25, 0.36)),
            (0.83, (0.02, -0.24, 0.34)),
        ]
    )
    body.wrists[who.other_hand] = cycle.reach(
        [
            (0.00, (0.11, -0.45, 0.14)),
            (0.38, (0.13, -0.43, 0.12)),
            (0.49, (0.10, 0.22, 0.16)),
            (0.57, (0.00, -0.24, 0.36)),
            (0.66, (0.08, 0.20, 0.18)),
            (0.74, (0.00, -0.25, 0.36)),
            (0.85, (0.04, -0.26, 0.32)),
        ]
    )
    for side in ("left", "right"):
        body.elbows[side] += np.array([0.25, -0.2, 0.2])
    sign = 1.0 if who.hand == "left" else -1.0
    thrust = curve(
        phase,
        (0.0, 0.07, 0.2, 0.29, 0.42, 0.49, 0.57, 0.66, 0.74, 0.86),
        (0.0, 1.0, 0.2, 1.0, 0.3, -0.5, 1.3, -0.4, 1.4, 0.5),
    )
    yaw = -sign * curve(phase, (0.0, 0.07, 0.22, 0.29, 0.5), (-3.0, 14.0, -4.0, 15.0, 0.0))
    zero = np.zeros_like(phase)
    body.trunk = cycle.turn(7.0 * thrust, yaw, zero)
    shake = 6.0 * wave(phase, 9) * curve(phase, (0.3, 0.4, 0.47, 0.8), (0.0, 1.0, 0.0, 0.0))
    body.head = cycle.turn(4.0 * thrust - 5.0, -0.8 * yaw + shake, zero)
    body.bounce = 0.25 * np.maximum(-thrust, 0.0)
    body.recoil = -0.035 * thrust
    return body


def _fearful(cycle: _Cycle, posture: Posture) -> UpperBody:
    """Draws back behind raised arms, peeks out to both sides, is startled again."""
    body, phase, who = _still(cycle), cycle.phase, cycle.who
    startle = curve(
        phase,
        (0.0, 0.05, 0.22, 0.4, 0.52, 0.57, 0.7, 0.9),
        (0.0, 1.0, 0.85, 0.1, 0.0, 0.8, 0.7, 0.0),
    )
    for side in ("left", "right"):
        high = (-0.07, 0.12, 0.30) if side == who.hand else (-0.09, 0.02, 0.33)
        low = np.array([-0.12, -0.20, 0.23])
        guard = low + startle[:, None] * (np.array(high) - low)
        guard[:, 1] += who.raise_m
        body.wrists[side] = guard * [1.0, 1.0, 0.4 + 0.6 * min(cycle.size, 1.1)]
        body.elbows[side] = np.tile([0.15, -1.0, -0.1], (len(phase), 1))
        body.palms[side] = 0.9 * startle
    sign = 1.0 if who.hand == "left" else -1.0
    look = sign * curve(
        phase,
        (0.0, 0.05, 0.22, 0.3, 0.37, 0.44, 0.52, 0.57, 0.7, 0.78, 0.86),
        (0.0, -30.0, -32.0, 38.0, 40.0, -20.0, 0.0, 30.0, 30.0, -40.0, -38.0),
    )
    zero = np.zeros_like(phase)
    body.trunk = cycle.turn(-16.0 * startle, 0.35 * look, 0.12 * look * startle)
    body.head = cycle.turn(14.0 * startle - 4.0, 0.75 * look, -0.15 * look * startle)
    body.shrug = np.deg2rad(8.0) * startle
    body.recoil = 0.14 * startle
    body.bounce = zero - 0.35 * startle
    return body


def _happy(cycle: _Cycle, posture: Posture) -> UpperBody:
    """Throws both arms up, twice, then waves with one hand; springs on the toes throughout."""
    body, phase, who = _still(cycle), cycle.phase, cycle.who
    up: Vector = (0.20, 0.47, 0.08)
    high: Vector = (0.28, 0.40, 0.10)
    low: Vector = (0.12, -0.26, 0.27)
    throws = [(0.0, low), (0.10, up), (0.20, high), (0.28, low), (0.38, up), (0.47, high)]
    waves: list[tuple[float, Vector]] = [
        (0.55 + 0.08 * n, (0.05 if n % 2 else 0.32, 0.36, 0.14)) for n in range(5)
    ]
    body.wrists[who.hand] = cycle.reach([*throws, *waves])
    body.wrists[who.other_hand] = cycle.reach(
        [*throws[:5], (0.58, (0.20, -0.20, 0.22)), (0.72, (0.22, -0.12, 0.26)), (0.88, low)]
    )
    for side in ("left", "right"):
        body.elbows[side] += np.array([0.35, 0.0, 0.1])
        body.palms[side] = np.full(len(phase), 0.5)
    sign = 1.0 if who.hand == "left" else -1.0
    zero = np.zeros_like(phase)
    spring = 0.5 + 0.5 * wave(phase, 7, 0.10)
    tilt = sign * curve(phase, (0.0, 0.5, 0.62, 0.8, 0.93), (0.0, 0.0, -6.0, -6.0, 0.0))
    body.trunk = cycle.turn(zero - 2.0 + 5.0 * (1.0 - spring), 4.0 * wave(phase, 2), tilt)
    body.head = cycle.turn(
        4.0 * spring - 4.0, 6.0 * wave(phase, 1, 0.7), -tilt + 3.0 * wave(phase, 2)
    )
    body.bounce = spring
    return body


def _neutral(cycle: _Cycle, posture: Posture) -> UpperBody:
    """Stands easy; one hand lifts a little, palm up, twice, as in quiet talk."""
    body, phase, who = _still(cycle), cycle.phase, cycle.who
    height = max(-0.30, cycle.rest[1] + 0.15)
    body.wrists[who.hand] = cycle.reach(
        [
            (0.02, cycle.rest),
            (0.16, (0.04, height, 0.26)),
            (0.24, (0.10, height + 0.03, 0.32)),
            (0.34, (0.03, height, 0.26)),
            (0.44, (0.11, height + 0.03, 0.32)),
            (0.60, cycle.rest),
            (0.80, cycle.rest),
        ]
    )
    body.palms[who.hand] = curve(phase, (0.02, 0.18, 0.44, 0.6), (0.0, 0.9, 0.9, 0.0))
    sign = 1.0 if who.hand == "left" else -1.0
    nod = curve(phase, (0.0, 0.2, 0.3, 0.42, 0.6), (0.0, 3.0, 0.0, 3.0, 0.0))
    zero = np.zeros_like(phase)
    body.trunk = cycle.turn(zero, sign * 3.0 * wave(phase, 1, 0.3), zero)
    body.head = cycle.turn(nod, sign * 7.0 * wave(phase, 1, 0.75), zero)
    return body


def _sad(cycle: _Cycle, posture: Posture) -> UpperBody:
    """Slumps and sways; a hand goes to the lowered face, wipes the eyes, and sinks again."""
    body, phase, who = _still(cycle), cycle.phase, cycle.who
    # Slumped, the face is lower and further forward than on a straight body.
    face: Vector = (-0.11, -0.01, 0.27)
    aside: Vector = (-0.06, 0.00, 0.28)
    # A large gesture would end behind the face and a small one before it: bodies are one size.
    body.wrists[who.hand] = dataclasses.replace(cycle, size=1.0).reach(
        [
            (0.06, cycle.rest),
            (0.26, face),
            (0.34, aside),
            (0.42, face),
            (0.52, aside),
            (0.60, face),
            (0.82, cycle.rest),
        ]
    )
    # The elbow hangs while the hand is at the face.
    body.elbows[who.hand] = np.tile([0.35, -1.0, 0.0], (len(phase), 1))
    sunk = curve(phase, (0.0, 0.28, 0.6, 0.85), (0.0, 1.0, 1.0, 0.0))
    sob = wave(phase, 10) * curve(phase, (0.2, 0.32, 0.58, 0.7), (0.0, 1.0, 1.0, 0.0))
    zero = np.zeros_like(phase)
    body.trunk = cycle.turn(5.0 * sunk + 0.8 * sob, 2.5 * wave(phase), 2.5 * wave(phase, 1, 0.2))
    body.head = cycle.turn(9.0 * sunk + sob, 3.0 * wave(phase, 1, 0.6), zero + 3.0 * wave(phase))
    body.shrug = np.deg2rad(2.0) * sob
    return body


_GESTURES: dict[Emotion, Callable[[_Cycle, Posture], UpperBody]] = {
    "angry": _angry,
    "fearful": _fearful,
    "happy": _happy,
    "neutral": _neutral,
    "sad": _sad,
}
