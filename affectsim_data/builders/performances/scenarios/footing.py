"""The lower body of a performance: feet that stand, step, hop and kneel, a pelvis over them."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from affectsim_data.builders.performances.curves import noise
from affectsim_data.builders.performances.footsteps import Step, step_feet, weight_center
from affectsim_data.builders.performances.rig import (
    SIDES,
    SIGN,
    TOE_OFFSET,
    BodyTrack,
    body_frames,
    foot_rotation,
)
from affectsim_data.builders.performances.scenarios.stage import Stage
from affectsim_data.builders.performances.scenarios.vocabulary import Script
from affectsim_data.builders.performances.styles import Side
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["lower_body", "settle"]

_LEG_M = 0.832
_THIGH_M, _SHIN_M = (
    float(np.linalg.norm(BODY.joint_offsets[JOINT_NAMES.index(name)]))
    for name in ("left_knee", "left_ankle")
)
_KNEE_ON_FLOOR_M = 0.062
"""Height of the knee joint of somebody who kneels."""
_TOE_OUT = np.deg2rad(9.0)
_EASY_KNEES_M = 0.006
"""Nobody stands with the knees locked."""
_PUSH_S = 0.13
"""From the heels' lift to a hop's take-off, and from its landing to flat feet."""


def lower_body(stage: Stage) -> BodyTrack:
    """Feet that step and a pelvis over them; everything above at rest."""
    ankles, feet = step_feet(stage.phase, _stance(stage), _steps(stage))
    heading = 0.5 * (feet["left"][:, 0] + feet["right"][:, 0])
    heading = gaussian_filter1d(heading, 5.0, mode="wrap")
    position = weight_center(ankles)
    position += quaternion_rotate(yaw_quaternion(heading), _shift(stage))
    heels = stage.ground_amount * np.deg2rad(stage.curve(stage.script.heels))
    spring, tiptoe, dip = _hops(stage.time_s, stage.script)
    for side, heel in zip((stage.who.hand, stage.who.other_hand), heels.T, strict=True):
        _raise_heel(ankles[side], feet[side], heel + stage.amount * tiptoe)
    height = BODY.hip_height - _EASY_KNEES_M - stage.posture.crouch_m
    position[:, 1] += height - stage.amount * dip
    zero = np.zeros_like(position)
    # Hips tip towards the leg that is not stood on.
    tip = 0.8 * (position - weight_center(ankles, smooth_frames=9.0))[:, 0]
    track = BodyTrack(
        pelvis_position=position,
        pelvis_turn=np.stack([zero[:, 0], heading, tip], axis=1),
        trunk_turn=zero.copy(),
        head_turn=zero.copy(),
        shrug=zero[:, 0].copy(),
        wrists={},
        elbows={},
        palms={},
        ankles=ankles,
        feet=feet,
    )
    _reach_the_floor(track)
    for place in (position, *ankles.values()):
        place[:, 1] += stage.amount * spring
    return track


def settle(stage: Stage, track: BodyTrack) -> None:
    """Both legs reach the floor from where the trunk took the hips; knees rest on it or above."""
    _reach_the_floor(track)
    if stage.script.deep:
        _kneel(stage, track)
        knees = [JOINT_NAMES.index(f"{side}_knee") for side in SIDES]
        for _ in range(3):
            lowest = body_frames(track)[1][:, knees, 1].min(axis=1)
            below = np.maximum(_KNEE_ON_FLOOR_M - lowest, 0.0)
            track.pelvis_position[:, 1] += gaussian_filter1d(below, 1.0, mode="wrap")


def _stance(stage: Stage) -> dict[Side, tuple[float, float, float]]:
    half = stage.posture.stance_m * stage.who.stance * stage.script.stance
    return {side: (SIGN[side] * half, 0.0, SIGN[side] * _TOE_OUT) for side in SIDES}


def _steps(stage: Stage) -> list[Step]:
    """Moves of the script as steps of the two feet."""
    period, amount, stance = stage.script.duration_s, stage.ground_amount, _stance(stage)
    steps = []
    for move in stage.script.moves:
        side = stage.side(move.foot)
        out, _, toes = stance[side]
        heading = stage.sign * amount * np.deg2rad(move.heading_deg)
        step = Step(
            side=side,
            start=move.start / period,
            end=move.end / period,
            x=amount * stage.sign * move.side + out * np.cos(heading),
            z=amount * move.forward - out * np.sin(heading),
            yaw=heading + toes,
            lift_m=move.lift_m,
        )
        steps.append(step)
    return steps


def _shift(stage: Stage) -> FloatArray:
    """Way of the pelvis from over the feet, to the left, up and forward, `(n, 3)`."""
    shift = stage.ground_amount * stage.curve(stage.script.pelvis)
    shift[:, :2] += stage.shaken("pelvis_side", "pelvis_up")
    shift[:, 0] *= stage.sign
    for axis, amplitude in ((0, 0.008), (2, 0.005)):
        wander = amplitude * stage.who.sway
        shift[:, axis] += noise(stage.phase, amplitude=wander, rng=stage.rng)
    return shift


def _raise_heel(ankle: FloatArray, feet: FloatArray, pitch: FloatArray) -> None:
    """Turns a foot further about its toe base, in place."""
    before = quaternion_rotate(foot_rotation(feet), TOE_OFFSET)
    feet[:, 1] += pitch
    ankle += before - quaternion_rotate(foot_rotation(feet), TOE_OFFSET)


def _hops(time_s: FloatArray, script: Script) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Height above the floor, heels raised (radians) and knees given (metres), `(n,)` each."""
    height, heels, dip = (np.zeros_like(time_s) for _ in range(3))
    for hop in script.hops:
        flight = np.clip((time_s - hop.start) / (hop.end - hop.start), 0.0, 1.0)
        height += 4.0 * hop.height_m * flight * (1.0 - flight)
        whole = hop.end - hop.start + 2.0 * _PUSH_S
        rise = np.clip((time_s - hop.start + _PUSH_S) / whole, 0.0, 1.0)
        heels += np.deg2rad(38.0) * np.sin(np.pi * rise) ** 2
        for at in (hop.start - 0.16, hop.end + 0.10):
            dip += 0.055 * np.exp(-0.5 * ((time_s - at) / 0.07) ** 2)
    return height, heels, np.minimum(dip, 0.09)


def _reach_the_floor(track: BodyTrack) -> None:
    """Lowers the pelvis, smoothly, to where both legs reach their feet."""
    root = track.pelvis_position
    limit = np.full(len(root), np.inf)
    level = yaw_quaternion(track.pelvis_turn[:, 1])
    for side in SIDES:
        hip = quaternion_rotate(level, BODY.joint_offsets[JOINT_NAMES.index(f"{side}_hip")])
        flat = np.linalg.norm((track.ankles[side] - root - hip)[:, [0, 2]], axis=1)
        reach = np.sqrt(np.maximum(_LEG_M**2 - flat**2, 0.01))
        limit = np.minimum(limit, track.ankles[side][:, 1] + reach - hip[:, 1])
    over = np.minimum(limit - root[:, 1], 0.0)
    lowest = minimum_filter1d(over, 9, mode="wrap")
    root[:, 1] += gaussian_filter1d(lowest, 1.8, mode="wrap", truncate=2.3)


def _kneel(stage: Stage, track: BodyTrack) -> None:
    """Moves the pelvis fore and aft to where, at its height, knees lie on the floor."""
    shares = np.clip(stage.curve(stage.script.kneel), 0.0, 1.0)
    positions = body_frames(track)[1]
    ahead = quaternion_rotate(yaw_quaternion(track.pelvis_turn[:, 1]), [0.0, 0.0, 1.0])
    shift = np.zeros(len(shares))
    for side, share in zip((stage.who.hand, stage.who.other_hand), shares.T, strict=True):
        hip, ankle = positions[:, JOINT_NAMES.index(f"{side}_hip")], track.ankles[side]
        drop = np.clip(ankle[:, 1] - _KNEE_ON_FLOOR_M, 0.0, 0.99 * _SHIN_M)
        rise = np.clip(hip[:, 1] - _KNEE_ON_FLOOR_M, 0.0, 0.999 * _THIGH_M)
        knee = ((ankle - hip) * ahead).sum(axis=1) + np.sqrt(_SHIN_M**2 - drop**2)
        way = knee - np.sqrt(_THIGH_M**2 - rise**2)
        shift += way * share / np.maximum(shares.sum(axis=1), 1.0)
    track.pelvis_position += gaussian_filter1d(shift, 2.0, mode="wrap")[:, None] * ahead
