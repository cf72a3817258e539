"""Walking a closed oval, feet planted: the cycle ends where and as it began."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d, minimum_filter1d

from affectsim_data.builders.performances.curves import cycle_phase, noise, wave
from affectsim_data.builders.performances.rig import (
    SIDES,
    SIGN,
    TOE_OFFSET,
    BodyTrack,
    foot_rotation,
)
from affectsim_data.builders.performances.styles import KINEMATICS, POSTURES, Performer, Side
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["FPS", "walk_track"]

FPS = 30.0
_PATH_M = 6.6
"""Length of the oval at an ordinary stride, 2.4 m by 1.2 m; slow walkers take a smaller one."""
_LONGEST_S = 8.0
_STANCE = (-0.25, 0.36)
"""Phase of a stride, from the moment the pelvis passes the foot, in which the foot is planted."""
_HEEL_OFF, _FOOT_FLAT = 0.10, -0.16
_TOE_OFF_PITCH, _STRIKE_PITCH = np.deg2rad(42.0), np.deg2rad(-16.0)
_OVAL = 0.5
"""Share by which curvature varies: 0 is a circle, 0.5 has straight sides."""
_SLOWDOWN = 0.16
"""Share by which speed varies between the sides and the ends of the oval."""
_LEG_M = 0.832


def walk_track(emotion: Emotion, who: Performer, *, rng: np.random.Generator) -> BodyTrack:
    """One round of the oval, starting in the middle of a straight side."""
    style, posture = KINEMATICS[emotion], POSTURES[emotion]
    stride_s = 120.0 / (style.cadence_steps_min * who.tempo)
    # A round has bends, where steps are shorter than the straight ones that were measured.
    stride_m = style.stride_m * 0.88 * (0.5 + 0.5 * who.reach)
    num_strides = int(np.clip(round(_PATH_M / stride_m), 4, int(_LONGEST_S / stride_s)))
    phase = cycle_phase(round(num_strides * stride_s * FPS))
    side_way = SIGN[who.hand]
    path = _Oval(num_strides * stride_m, side_way)
    gait = phase * num_strides
    ankles, feet = {}, {}
    for side in SIDES:
        shift = 0.0 if side == "left" else 0.5
        half_width = 0.075 * who.stance
        ankles[side], feet[side] = _steps(path, gait - shift, shift, num_strides, side, half_width)
    center, heading = path.at(phase)
    left = quaternion_rotate(yaw_quaternion(heading), [1.0, 0.0, 0.0])
    position = center + (0.018 * wave(gait))[:, None] * left
    twist = np.deg2rad(4.0 + 8.0 * style.hand_swing_m) * wave(gait, shift=-_STANCE[1])
    lean = -side_way * 0.10 * (1.0 - wave(phase, 2)) * style.stride_m / 1.35
    pitch = np.deg2rad(style.trunk_pitch_deg + who.trunk_pitch_deg)
    zero = np.zeros_like(phase)
    pelvis_turn = np.stack([zero + 0.3 * pitch, heading - 0.5 * twist, 0.5 * lean], axis=1)
    position[:, 1] = _pelvis_height(position, pelvis_turn, ankles, gait, style.bounce_m)
    position[:, 1] -= 0.5 * posture.crouch_m
    sway = noise(phase, amplitude=0.02, rng=rng)
    trunk_turn = np.stack([zero + 0.7 * pitch, 1.3 * twist, 0.5 * lean + sway], axis=1)
    # People look where they go, and into the bend before they take it.
    ahead = path.at(phase + 0.05)[1] - heading
    head_pitch = np.deg2rad(style.neck_pitch_deg + posture.head_bow_deg)
    look = noise(phase, amplitude=0.10 if emotion != "fearful" else 0.35, rng=rng)
    head_turn = np.stack([zero + head_pitch, ahead - 0.8 * twist + look, -0.7 * lean], axis=1)
    track = BodyTrack(
        position,
        pelvis_turn,
        trunk_turn,
        head_turn,
        zero + np.deg2rad(posture.shrug_deg),
        {},
        {},
        dict.fromkeys(SIDES, zero),
        ankles,
        feet,
    )
    for side in SIDES:
        track.wrists[side], track.elbows[side] = _arm(emotion, who, gait, side)
        tremor = noise(phase, amplitude=posture.tremor_m, rng=rng, slowest=len(phase) // 6)
        track.wrists[side][:, 1] += tremor
    return track


class _Oval:
    """A closed path whose curvature varies smoothly, walked faster along its sides."""

    def __init__(self, length_m: float, side_way: float) -> None:
        self.side_way = side_way
        self._way = np.linspace(0.0, 1.0, 2049)
        heading = self._heading(self._way)
        speed = length_m * np.stack([np.sin(heading), np.zeros_like(heading), np.cos(heading)], 1)
        middle = 0.5 * (speed[1:] + speed[:-1]) * np.diff(self._way)[:, None]
        self._points = np.concatenate([np.zeros((1, 3)), np.cumsum(middle, axis=0)])
        self._points -= self._way[:, None] * self._points[-1]

    def _heading(self, way: FloatArray) -> FloatArray:
        turn = 2.0 * np.pi * way - _OVAL * np.sin(4.0 * np.pi * way)
        return self.side_way * turn

    def at(self, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points `(n, 3)` and heading `(n,)` at any phase of the round; the heading never jumps."""
        way = phase + _SLOWDOWN * np.sin(4.0 * np.pi * phase) / (4.0 * np.pi)
        within = np.mod(way, 1.0)
        points = np.stack([np.interp(within, self._way, axis) for axis in self._points.T], axis=1)
        return points, self._heading(way)


def _steps(
    path: _Oval,
    gait: FloatArray,
    shift: float,
    num_strides: int,
    side: Side,
    half_width: float,
) -> tuple[FloatArray, FloatArray]:
    """Ankle positions `(n, 3)` and foot angles `(n, 2)` of one foot.

    The toe base is the fixed point of a stance: the heel lands and lifts around it. In between the
    foot swings from one footprint to the next.
    """
    start, end = _STANCE
    stance = np.floor(gait - start)
    phase = gait - stance
    swing = np.clip((phase - end) / (1.0 + start - end), 0.0, 1.0)
    share = swing**3 * (10.0 - 15.0 * swing + 6.0 * swing**2)
    prints = [path.at((stance + shift + step) / num_strides) for step in (0.0, 1.0)]
    yaw = prints[0][1] + share * (prints[1][1] - prints[0][1])
    outward = [
        SIGN[side] * half_width,
        BODY.rest_positions[JOINT_NAMES.index("left_ankle"), 1],
        0.0,
    ]
    toes = []
    for center, heading in prints:
        sole = np.array(outward) + TOE_OFFSET
        toes.append(center + quaternion_rotate(yaw_quaternion(heading), sole))
    toe = toes[0] + share[:, None] * (toes[1] - toes[0])
    toe[:, 1] += 0.045 * np.sin(np.pi * swing) ** 2
    pitch = _foot_pitch(phase, swing)
    toe_out = yaw + SIGN[side] * np.deg2rad(6.0)
    feet = np.stack([toe_out, pitch], axis=1)
    pivot = np.stack([toe_out, np.maximum(pitch, 0.0)], axis=1)
    ankle = toe - quaternion_rotate(foot_rotation(pivot), TOE_OFFSET)
    # The heel, 5 cm behind the ankle, would sink into the floor while the toes are up.
    ankle[:, 1] += 0.05 * np.sin(np.maximum(-pitch, 0.0))
    return ankle, feet


def _foot_pitch(phase: FloatArray, swing: FloatArray) -> FloatArray:
    """Heel strike with toes up, flat, heel off; then through the swing to the next strike."""
    start, end = _STANCE
    landing = np.clip((_FOOT_FLAT - phase) / (_FOOT_FLAT - start), 0.0, 1.0)
    lifting = np.clip((phase - _HEEL_OFF) / (end - _HEEL_OFF), 0.0, 1.0)
    stance: FloatArray = _STRIKE_PITCH * landing**2 + _TOE_OFF_PITCH * lifting**2
    ease = swing * swing * (3.0 - 2.0 * swing)
    through = _TOE_OFF_PITCH + ease * (_STRIKE_PITCH - _TOE_OFF_PITCH)
    return np.where(swing > 0.0, through, stance)


def _pelvis_height(
    position: FloatArray,
    pelvis_turn: FloatArray,
    ankles: dict[Side, FloatArray],
    gait: FloatArray,
    bounce_m: float,
) -> FloatArray:
    """Height of the pelvis, `(n,)`: bounces twice a stride, as high as both legs can reach."""
    bounce = 0.5 * bounce_m * wave(gait, 2)
    limit = np.full_like(gait, BODY.hip_height - 0.01)
    for side in SIDES:
        hip = BODY.joint_offsets[JOINT_NAMES.index(f"{side}_hip")]
        hips = position + quaternion_rotate(yaw_quaternion(pelvis_turn[:, 1]), hip)
        flat = np.linalg.norm((ankles[side] - hips)[:, [0, 2]], axis=1)
        reach = np.sqrt(np.maximum(_LEG_M**2 - flat**2, 0.01))
        limit = np.minimum(limit, ankles[side][:, 1] + reach - hip[1])
    # A lower envelope without corners: least over a third of a stride, then smoothed as wide.
    width = max(round(len(gait) / (3.0 * max(gait[-1], 1.0))), 3)
    lowest = minimum_filter1d(limit - bounce, 2 * width + 1, mode="wrap")
    height: FloatArray = bounce + gaussian_filter1d(lowest, width / 2.5, mode="wrap", truncate=2.5)
    return height


def _arm(
    emotion: Emotion, who: Performer, gait: FloatArray, side: Side
) -> tuple[FloatArray, FloatArray]:
    """Wrist and elbow of an arm that swings against the leg of its side."""
    style = KINEMATICS[emotion]
    # The wrist is greatest forward when the other foot has just landed.
    forward = wave(gait, shift=0.5 + _STANCE[0] + (0.0 if side == "left" else 0.5))
    # Of the 0.55 m to the wrist; bending elbow and turning chest add a third to the swing.
    swing = np.arcsin(min(0.72 * style.hand_swing_m * who.reach / 2.0 / 0.5, 0.8)) * forward
    flexion = np.deg2rad(style.elbow_flexion_deg) * (1.0 + 0.35 * forward)
    upper = swing - 0.35 * np.deg2rad(style.elbow_flexion_deg)
    lower = upper + flexion
    # Half the span of the hands, less half that of the shoulders, of a person 1.70 m tall.
    out = style.hand_span * 1.70 / 2.0 - 0.18
    arm = 0.30 * np.stack([np.zeros_like(upper), -np.cos(upper), np.sin(upper)], axis=1)
    arm += 0.25 * np.stack([np.zeros_like(lower), -np.cos(lower), np.sin(lower)], axis=1)
    arm[:, 0] = out
    if emotion == "fearful":
        # Hands held together before the chest hang neither at the sides nor from the elbow alone.
        arm[:, 1] = -0.12 + who.raise_m + 0.01 * wave(gait, 2)
        arm[:, 2] = 0.22 + 0.5 * style.hand_swing_m * forward
    pole = np.array([0.25 + 0.5 * who.elbow_out, -1.0 if emotion == "fearful" else -0.3, -1.0])
    return arm, np.tile(pole, (len(gait), 1))
