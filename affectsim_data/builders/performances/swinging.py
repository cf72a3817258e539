"""Arms of somebody who walks: they swing against the legs, or are held before the body in fear."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.performances.arms import Place, hold_clear, reach_for
from affectsim_data.builders.performances.curves import FPS, curve, cycle_phase, noise, wave
from affectsim_data.builders.performances.rig import SIDES, BodyTrack
from affectsim_data.builders.performances.styles import Gait, Kinematics, Performer, Side
from affectsim_data.poses import FloatArray

__all__ = ["swing_arms"]

_UPPER_M, _FOREARM_M = 0.30, 0.25
_LANDED = 0.25
"""Phase of a stride at which the wrist is greatest forward: the other foot has just landed."""
_STATURE_M = 1.70
_LEAST_FLEXION = np.deg2rad(8.0)
_MOUTH = Place("head", (-0.03, -0.13, 0.17), (0.3, -1.0, 0.1), palm_deg=60.0)
_TO_MOUTH_S = 0.6
_HUGGING = 0.4
"""Share of fearful takes in which arms are folded around the body instead of hands wrung."""


def swing_arms(
    track: BodyTrack,
    gait: FloatArray,
    style: Kinematics,
    gait_style: Gait,
    who: Performer,
    *,
    held: float,
    rng: np.random.Generator,
) -> None:
    """Puts the arms of a walk on a track whose trunk and legs are there.

    Args:
        track: Changed in place.
        gait: Strides done at each frame, the left leg upright at whole numbers, `(n,)`.
        style: What was measured.
        gait_style: How abruptly arms turn about.
        who: The performer.
        held: Share to which hands are held together before the belly, 0 to 1.
        rng: How swings differ from one another.
    """
    phase = cycle_phase(len(gait))
    hugging = 1.0 if rng.random() < _HUGGING else 0.0
    wringing = noise(phase, amplitude=0.012, rng=rng, slowest=round(len(gait) / FPS))
    for side in SIDES:
        more = 1.0 + (who.asymmetry if side == who.hand else -who.asymmetry)
        vary = 1.0 + noise(phase, amplitude=0.10, rng=rng)
        wrist, elbow = _swung(gait, style, gait_style, who, side, more * vary)
        # One hand lies before the other; both move as one, and rub.
        over = 1.0 if side == who.hand else 0.0
        at = np.array([-0.165 - 0.02 * over, -0.43 + 0.075 * over + who.raise_m, 0.195])
        at += hugging * np.array([-0.055, 0.06, 0.02])
        clasped = np.tile(at, (len(gait), 1))
        clasped[:, 1] += 0.008 * wave(gait, 2, 0.1) + (2.0 * over - 1.0) * wringing
        clasped[:, 2] += 0.075 * over + 0.5 * style.hand_swing_m * wave(gait, 1, 0.2)
        track.wrists[side] = wrist + held * (clasped - wrist)
        pole = elbow / _UPPER_M
        track.elbows[side] = pole + held * (np.array([0.75, -0.8, -0.5]) - pole)
        track.palms[side] = np.full(len(gait), np.deg2rad(15.0))
        track.wrist_bends[side] = np.full(len(gait), np.deg2rad(50.0 * held))
        hold_clear(track, side)
    if held > 0.3 and rng.random() < 0.6:
        _hand_to_mouth(track, phase, who.hand, rng)


def _swung(
    gait: FloatArray,
    style: Kinematics,
    gait_style: Gait,
    who: Performer,
    side: Side,
    amount: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Wrist and elbow from the shoulder, `(n, 3)`: the forearm follows the upper arm, late."""
    shift = 0.5 - _LANDED + (0.0 if side == "left" else 0.5)
    forward, late = (_snapped(wave(gait, 1, shift + lag), gait_style.snap) for lag in (0.0, 0.06))
    bent = np.deg2rad(style.elbow_flexion_deg + who.elbow_flexion_deg)
    # Of the 0.5 m to the wrist; bending elbow and turning chest add a third to the swing.
    widest = np.arcsin(min(0.72 * style.hand_swing_m * who.reach / 2.0 / 0.5, 0.8))
    upper = widest * amount * forward - 0.35 * bent
    flexion = np.maximum(bent * (1.0 + 0.35 * amount * late), _LEAST_FLEXION)
    # Half the span of the hands, less half that of the shoulders.
    out = style.hand_span * _STATURE_M / 2.0 - 0.18 - 0.25 * style.hand_swing_m * 0.3
    aside = np.arcsin(np.clip((out + who.hands_out_m) / 0.5, 0.02, 0.6))
    elbow, tip = np.zeros((len(gait), 3)), np.zeros((len(gait), 3))
    elbow[:, 1], elbow[:, 2] = -np.cos(upper), np.sin(upper)
    tip[:, 1], tip[:, 2] = -np.cos(upper + flexion), np.sin(upper + flexion)
    for bone in (elbow, tip):
        bone[:, 0] = -bone[:, 1] * np.sin(aside)
        bone[:, 1] *= np.cos(aside)
    elbow *= _UPPER_M
    return elbow + _FOREARM_M * tip, elbow


def _snapped(swing: FloatArray, snap: float) -> FloatArray:
    """A swing that shoots through the middle and stops hard at its ends, for `snap` above 0."""
    steep = max(2.0 * snap, 1e-3)
    shot: FloatArray = np.tanh(steep * swing) / np.tanh(steep)
    return shot


def _hand_to_mouth(
    track: BodyTrack, phase: FloatArray, side: Side, rng: np.random.Generator
) -> None:
    """For about a second and a half one hand goes from the belly to the mouth."""
    length_s = len(phase) / FPS
    start = rng.uniform(0.2, 0.6)
    ramp, stay = _TO_MOUTH_S / length_s, rng.uniform(0.5, 1.0) / length_s
    times = (start, start + ramp, start + ramp + stay, start + 2.0 * ramp + stay)
    reach_for(track, side, _MOUTH, curve(phase, times, (0.0, 1.0, 1.0, 0.0)))
