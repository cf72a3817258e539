"""Walking a closed oval, feet planted: the cycle ends where and as it began."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from affectsim_data.builders.performances.curves import FPS, cycle_phase, minimum_jerk, noise, wave
from affectsim_data.builders.performances.living import breathe, glances, limit_head, tremble
from affectsim_data.builders.performances.paths import Oval, paced
from affectsim_data.builders.performances.rig import (
    SIDES,
    SIGN,
    TOE_OFFSET,
    BodyTrack,
    foot_rotation,
    turn_rotation,
)
from affectsim_data.builders.performances.styles import (
    GAITS,
    KINEMATICS,
    POSTURES,
    Expression,
    Gait,
    Kinematics,
    Performer,
    Side,
    blend_loosely,
)
from affectsim_data.builders.performances.swinging import swing_arms
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["FPS", "walk_track"]

_PATH_M = 6.3
"""Length of the oval at an ordinary stride, 2.6 m by 1.2 m; slow walkers take a smaller one."""
_LONGEST_S = 8.0
_STANCE = (-0.25, 0.36)
"""Phase of a stride, from the moment the pelvis passes the foot, in which the foot is planted."""
_HEEL_OFF, _FOOT_FLAT = 0.10, -0.16
_LEG_M = 0.829
_GRAVITY = 9.81
_HALF_WIDTH_M = 0.075
_STRETCHED, _DAMPED = 1.04, 0.88
"""Stride and bounce come out as measured with these: the straight frames of an oval are slower than
its middle, and legs that swing out add to the rise and fall."""
_CADENCE_SHARE = 0.6
"""Legs are pendulums: steps differ less in tempo between people than gestures do."""
_NECK_SHARE = 0.7
"""Lean from pelvis to neck over the pitch of the chest: the spine bends on the way."""
_HEAD_GAIN = 1.4
"""Turn of the head over that of the neck past the chest: 2 turns both alike, less spares the eyes
from looking at the sky."""


@dataclasses.dataclass(frozen=True)
class _Walk:
    """One walk: who, how, and when each foot stands."""

    who: Performer
    style: Kinematics
    gait_style: Gait
    path: Oval
    num_strides: int
    stride_s: float
    gait: FloatArray
    """Strides done at each frame; the left leg is upright at whole numbers."""
    jitter: dict[Side, FloatArray]
    """Departure of each footprint from the even one: outward, forward, toes, `(num_strides, 3)`."""


def walk_track(
    emotion: Emotion,
    who: Performer,
    *,
    take: int = 0,
    expression: Expression,
    rng: np.random.Generator,
) -> BodyTrack:
    """One round of the oval, starting in the middle of a straight side.

    Args:
        emotion: What is felt.
        who: The performer.
        take: Which way round: to the side of the preferred hand, or for odd takes the other.
        expression: How strongly it shows: 1 as measured, 0 as neutral.
        rng: Noise of this take.
    """
    style = _style(emotion, expression, rng)
    loose = expression.loose
    calm = POSTURES["neutral"]
    posture = blend_loosely(POSTURES[emotion], calm, expression.posture, loose, rng)
    gait_style = blend_loosely(GAITS[emotion], GAITS["neutral"], expression.snap, loose, rng)
    gait_style = _within_reason(gait_style)
    round_side = who.hand if take % 2 == 0 else who.other_hand
    walk = _plan(style, gait_style, who, round_side, rng)
    phase = cycle_phase(len(walk.gait))
    ankles, feet = {}, {}
    for side in SIDES:
        ankles[side], feet[side] = _steps(walk, side)
    position, pelvis_turn, trunk_turn, head_turn = _trunk(walk, rng)
    position[:, 1] = _pelvis_height(walk, position, pelvis_turn, ankles)
    position[:, 1] -= 0.5 * posture.crouch_m
    track = BodyTrack(
        position,
        pelvis_turn,
        trunk_turn,
        head_turn,
        np.full(len(phase), np.deg2rad(posture.shrug_deg + who.shrug_deg)),
        {},
        {},
        {},
        ankles,
        feet,
        nod=np.full(len(phase), np.deg2rad(posture.head_bow_deg)),
    )
    breathe(track, posture)
    limit_head(track)
    held = min(expression.posture, 1.0) if emotion == "fearful" else 0.0
    swing_arms(track, walk.gait, style, walk.gait_style, who, held=held, rng=rng)
    tremble(track, phase, posture.tremor_m, rng)
    return track


def _style(emotion: Emotion, expression: Expression, rng: np.random.Generator) -> Kinematics:
    """What was measured, each channel as strong as it shows."""
    calm = KINEMATICS["neutral"]
    pace, size, posture = (
        blend_loosely(KINEMATICS[emotion], calm, share, expression.loose, rng)
        for share in (expression.pace, expression.size, expression.posture)
    )
    return dataclasses.replace(
        posture,
        cadence_steps_min=pace.cadence_steps_min,
        stride_m=pace.stride_m,
        bounce_m=max(size.bounce_m, 0.004),
        hand_swing_m=max(size.hand_swing_m, 0.02),
    )


def _within_reason(gait: Gait) -> Gait:
    """A gait that can be walked however exaggerated: feet leave the floor, nobody goes back."""
    return dataclasses.replace(
        gait,
        foot_lift_m=max(gait.foot_lift_m, 0.016),
        strike_deg=min(max(gait.strike_deg, -24.0), 0.0),
        push_deg=min(max(gait.push_deg, 15.0), 60.0),
        unevenness=min(max(gait.unevenness, 0.01), 0.3),
        snap=min(max(gait.snap, 0.0), 1.0),
        look_deg=min(max(gait.look_deg, 0.0), 50.0),
    )


def _plan(
    style: Kinematics, gait: Gait, who: Performer, side: Side, rng: np.random.Generator
) -> _Walk:
    stride_s = 120.0 / (style.cadence_steps_min * who.tempo**_CADENCE_SHARE)
    # The ends of a round have shorter steps than its straight sides, where walks were measured.
    stride_m = _STRETCHED * style.stride_m * who.stride / Oval.side_speed
    num_strides = int(np.clip(round(_PATH_M / stride_m), 4, int(_LONGEST_S / stride_s)))
    path = Oval(num_strides * stride_m, SIGN[side])
    phase = cycle_phase(round(num_strides * stride_s * FPS))
    vary = gait.unevenness * np.array([0.15, 0.25 * stride_m, 0.6])
    jitter = {foot: rng.normal(size=(num_strides, 3)).clip(-2.0, 2.0) * vary for foot in SIDES}
    paces = paced(phase, 0.8 * gait.unevenness, rng) * num_strides
    return _Walk(who, style, gait, path, num_strides, stride_s, paces, jitter)


def _trunk(
    walk: _Walk, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Pelvis position, and turns of pelvis, trunk and head, `(n, 3)` each; heights are left 0."""
    who, style, gait = walk.who, walk.style, walk.gait
    round_phase = gait / walk.num_strides
    phase = cycle_phase(len(gait))
    center, heading = walk.path.at(round_phase)
    left = quaternion_rotate(yaw_quaternion(heading), [1.0, 0.0, 0.0])
    position = center + (0.02 * who.sway * wave(gait))[:, None] * left
    twist = np.deg2rad(4.0 + 9.0 * style.hand_swing_m) * wave(gait, shift=-_STANCE[1])
    roll = np.deg2rad(walk.gait_style.roll_deg) * wave(gait, shift=0.04)
    lean = _lean(walk)
    pitch = np.deg2rad(style.trunk_pitch_deg / _NECK_SHARE + who.trunk_pitch_deg)
    # The chest tips a little forward as each foot lands and is caught again.
    nod = np.deg2rad(1.0 + 12.0 * style.bounce_m) * wave(gait, 2, 0.30)
    wander = [noise(phase, amplitude=np.deg2rad(0.8) * who.sway, rng=rng) for _ in range(3)]
    drop = np.deg2rad(2.5) * wave(gait, shift=0.04)
    pelvis_turn = np.stack([0.3 * pitch + 0.3 * nod, heading - 0.5 * twist, 0.5 * lean - drop], 1)
    trunk_turn = np.stack([0.7 * pitch + 0.7 * nod, 1.3 * twist, 0.5 * lean + drop + roll], axis=1)
    trunk_turn += np.stack(wander, axis=1)
    # People look where they go, and into the bend before they take it; the head keeps its level.
    ahead = walk.path.at(round_phase + 0.05)[1] - heading
    look = np.deg2rad(walk.gait_style.look_deg) * glances(phase, round(len(phase) / FPS), rng)
    head_pitch = _HEAD_GAIN * (np.deg2rad(style.neck_pitch_deg) - pitch)
    head_pitch += np.deg2rad(who.head_pitch_deg)
    head_turn = np.stack(
        [head_pitch - 0.8 * nod, 0.7 * ahead - 0.8 * twist + look, -0.7 * lean - 0.6 * roll], 1
    )
    trunk_turn[:, 1] += 0.25 * look
    return position, pelvis_turn, trunk_turn, head_turn


def _lean(walk: _Walk) -> FloatArray:
    """Roll into the bend, radians, `(n,)`: a third of what balance asks, the feet do the rest."""
    step = 0.25
    around = [walk.path.at((walk.gait + shift) / walk.num_strides) for shift in (-step, step)]
    way_s = 2.0 * step * walk.stride_s
    speed = np.linalg.norm(around[1][0] - around[0][0], axis=1) / way_s
    turning = (around[1][1] - around[0][1]) / way_s
    lean: FloatArray = -0.35 * np.arctan(speed * turning / _GRAVITY)
    return lean


def _steps(walk: _Walk, side: Side) -> tuple[FloatArray, FloatArray]:
    """Ankle positions `(n, 3)` and foot angles `(n, 2)` of one foot.

    The toe base is the fixed point of a stance: the heel lands and lifts around it. In between the
    foot swings from one footprint to the next.
    """
    start, end = _STANCE
    shift = 0.0 if side == "left" else 0.5
    gait = walk.gait - shift
    stance = np.floor(gait - start)
    phase = gait - stance
    swing = np.clip((phase - end) / (1.0 + start - end), 0.0, 1.0)
    share = _swing_share(swing)
    prints = [_print(walk, side, stance + step, shift) for step in (0.0, 1.0)]
    toe = prints[0][0] + share[:, None] * (prints[1][0] - prints[0][0])
    yaw = prints[0][1] + share * (prints[1][1] - prints[0][1])
    toe[:, 1] += walk.gait_style.foot_lift_m * np.sin(np.pi * swing) ** 2
    pitch = _foot_pitch(phase, swing, walk.gait_style)
    feet = np.stack([yaw, pitch], axis=1)
    pivot = np.stack([yaw, np.maximum(pitch, 0.0)], axis=1)
    ankle = toe - quaternion_rotate(foot_rotation(pivot), TOE_OFFSET)
    # The heel, 5 cm behind the ankle, would sink into the floor while the toes are up.
    ankle[:, 1] += 0.05 * np.sin(np.maximum(-pitch, 0.0))
    return ankle, feet


def _swing_share(swing: FloatArray) -> FloatArray:
    """Share of the way to the next footprint: a foot sets off at once and lands softly.

    The mean of a quintic, still at both ends, and of a quartic that is still at the end only: a
    toe that lingers while the pelvis goes on would stretch the leg, and the knee would snap.
    """
    early = swing**2 * (6.0 - 8.0 * swing + 3.0 * swing**2)
    share: FloatArray = 0.5 * (minimum_jerk(swing) + early)
    return share


def _print(
    walk: _Walk, side: Side, stance: FloatArray, shift: float
) -> tuple[FloatArray, FloatArray]:
    """Toe base `(n, 3)` and yaw `(n,)` of a footprint."""
    center, heading = walk.path.at((stance + shift) / walk.num_strides)
    out, forward, turn = walk.jitter[side][np.mod(stance, walk.num_strides).astype(np.intp)].T
    ankle_m = BODY.rest_positions[JOINT_NAMES.index("left_ankle"), 1]
    sole = np.zeros_like(center)
    sole[:, 0] = SIGN[side] * (_HALF_WIDTH_M * walk.who.stance + out)
    sole[:, 1], sole[:, 2] = ankle_m, forward
    toe = center + quaternion_rotate(yaw_quaternion(heading), sole + TOE_OFFSET)
    return toe, heading + SIGN[side] * (np.deg2rad(6.0) + 0.3 * turn)


def _foot_pitch(phase: FloatArray, swing: FloatArray, style: Gait) -> FloatArray:
    """Heel strike with toes up, flat, heel off; then through the swing to the next strike."""
    start, end = _STANCE
    strike, push = np.deg2rad(style.strike_deg), np.deg2rad(style.push_deg)
    landing = np.clip((_FOOT_FLAT - phase) / (_FOOT_FLAT - start), 0.0, 1.0)
    lifting = np.clip((phase - _HEEL_OFF) / (end - _HEEL_OFF), 0.0, 1.0)
    stance: FloatArray = strike * landing**2 + push * lifting**2
    ease = swing * swing * (3.0 - 2.0 * swing)
    return np.where(swing > 0.0, push + ease * (strike - push), stance)


def _pelvis_height(
    walk: _Walk, position: FloatArray, pelvis_turn: FloatArray, ankles: dict[Side, FloatArray]
) -> FloatArray:
    """Height of the pelvis, `(n,)`: bounces twice a stride, as high as both legs can reach."""
    bounce = 0.5 * _DAMPED * walk.style.bounce_m * walk.who.bounce * wave(walk.gait, 2)
    limit = np.full_like(walk.gait, BODY.hip_height - 0.01)
    for side in SIDES:
        hip = BODY.joint_offsets[JOINT_NAMES.index(f"{side}_hip")]
        hips = position + quaternion_rotate(turn_rotation(pelvis_turn), hip)
        flat = np.linalg.norm((ankles[side] - hips)[:, [0, 2]], axis=1)
        reach = np.sqrt(np.maximum(_LEG_M**2 - flat**2, 0.01))
        limit = np.minimum(limit, ankles[side][:, 1] + reach - (hips - position)[:, 1])
    # A lower envelope without corners: least over a third of a stride, then smoothed as wide.
    width = max(round(walk.stride_s * FPS / 3.0), 3)
    lowest = minimum_filter1d(limit - bounce, 2 * width + 1, mode="wrap")
    height: FloatArray = bounce + gaussian_filter1d(lowest, width / 2.5, mode="wrap", truncate=2.5)
    return height
