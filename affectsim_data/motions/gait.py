"""How somebody walks, in the terms of gait studies: speed, cadence, stride, posture, arm swing."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from affectsim_data.motions.derivatives import MIN_FRAMES, differentiate, smooth_over
from affectsim_data.motions.motion import Motion
from affectsim_data.motions.posture import (
    elbow_flexion,
    facing,
    hand_span,
    joint,
    neck_pitch,
    trunk_pitch,
)
from affectsim_data.poses import FloatArray

__all__ = ["WalkKinematics", "check_clip", "walk_kinematics"]

_FLOOR = np.array([1.0, 0.0, 1.0])
_STRIDE_HZ = (0.3, 1.8)
"""Strides a second that count as walking or running: 36 to 216 steps a minute."""
_TURN_MAX = float(np.deg2rad(45.0))
"""Rate of turning, per second, up to which a stretch is straight."""
_STRAIGHT_SHARE = 0.4
"""Share of the frames, the straightest ones, that counts even if all of the way turns."""
_PAUSE_SHARE = 0.5
"""Frames slower than this share of the upper quartile of speed are pauses, not walking."""
_SPEED_MIN_M_S = 0.1
_PADDED = 1 << 14


@dataclasses.dataclass(frozen=True)
class WalkKinematics:
    """Gait of one walk on its straight stretches, on the canonical body (1.70 m tall)."""

    speed_m_s: float
    """Of the pelvis along the direction of travel."""
    cadence_steps_min: float
    """Steps of both feet a minute."""
    stride_m: float
    """Way from a step of a foot to its next."""
    bounce_m: float
    """Rise and fall of the pelvis within a step."""
    elbow_flexion_deg: float
    """Of both arms; 0 is straight."""
    hand_swing_m: float
    """Fore-and-aft range of a wrist relative to the pelvis within a stride, mean of both."""
    trunk_pitch_deg: float
    """Lean of pelvis to neck, positive forwards."""
    neck_pitch_deg: float
    """Lean of neck to head past rest, positive forwards."""
    hand_span: float
    """Distance between the wrists, share of stature."""
    hand_jerk_m_s3: float
    """Third derivative of the wrists, mean of both."""


def walk_kinematics(motion: Motion, *, cyclic: bool = True) -> WalkKinematics:
    """Gait of a walk, from the frames in which it goes straight on.

    Straight are the frames whose direction of travel, averaged over a stride, turns by no more
    than 45 degrees a second; where these are fewer than 40 % of the frames, the straightest 40 %.
    Frames of less than half the upper quartile of speed count as pauses and are left out.

    Args:
        motion: Somebody who walks.
        cyclic: Whether the motion is a closed cycle; False for a clip as it was captured.

    Raises:
        ValueError: Fewer than 8 frames; no walk: slower than 0.1 m/s; said to be cyclic, but its
            end is far from its beginning.
    """
    check_clip(motion, cyclic=cyclic)
    found = _measure(motion.joint_positions(), motion.fps, cyclic=cyclic)
    if not found.speed_m_s >= _SPEED_MIN_M_S:
        raise ValueError(
            f"motion {motion.motion_id!r} ({motion.action}): expected a walk of at least "
            f"{_SPEED_MIN_M_S} m/s, got {found.speed_m_s:.2f} m/s; `kinematic_descriptors` takes "
            "any action"
        )
    return found


def _measure(positions: FloatArray, fps: float, *, cyclic: bool) -> WalkKinematics:
    """Gait of joint positions `(num_frames, 22, 3)`."""
    pelvis = positions[:, 0]
    apart = _ankles_apart(positions, fps, cyclic=cyclic)
    rough_hz = _strongest_frequency(apart, fps)
    travel = _travel(pelvis, fps, 1.0 / rough_hz, cyclic=cyclic)
    direction = travel / np.maximum(np.linalg.norm(travel, axis=1, keepdims=True), 1e-9)
    straight = _straight(travel, direction, fps, cyclic=cyclic)
    stride_hz = _mean_frequency(apart, fps, rough_hz, straight)
    (velocity,) = differentiate(pelvis, fps, (1,), cyclic=cyclic)
    speed = float(np.sum(velocity * direction, axis=1)[straight].mean())
    wrists = positions[:, [joint("left_wrist"), joint("right_wrist")]]
    swing = np.sum((wrists - pelvis[:, None]) * direction[:, None], axis=-1)
    stride, step = fps / stride_hz, 0.5 * fps / stride_hz
    (jerk,) = differentiate(wrists, fps, (3,), cyclic=cyclic)
    return WalkKinematics(
        speed_m_s=speed,
        cadence_steps_min=120.0 * stride_hz,
        stride_m=speed / stride_hz,
        bounce_m=_typical_range(pelvis[:, 1:2], step, straight, cyclic=cyclic),
        elbow_flexion_deg=_mean_deg(elbow_flexion(positions)[straight]),
        hand_swing_m=_typical_range(swing, stride, straight, cyclic=cyclic),
        trunk_pitch_deg=_mean_deg(trunk_pitch(positions, direction)[straight]),
        neck_pitch_deg=_mean_deg(neck_pitch(positions, direction)[straight]),
        hand_span=float(hand_span(positions)[straight].mean()),
        hand_jerk_m_s3=float(np.linalg.norm(jerk, axis=-1)[straight].mean()),
    )


def check_clip(motion: Motion, *, cyclic: bool) -> None:
    """Raises unless a motion is long enough and, if said to be cyclic, ends where it began.

    Raises:
        ValueError: It is not.
    """
    name = f"motion {motion.motion_id!r}"
    if motion.num_frames < MIN_FRAMES:
        raise ValueError(
            f"{name}: descriptors need at least {MIN_FRAMES} frames, got {motion.num_frames}"
        )
    steps = np.linalg.norm(np.diff(motion.root_translation, axis=0), axis=1)
    gap = float(np.linalg.norm(motion.root_translation[0] - motion.root_translation[-1]))
    if cyclic and gap > max(0.3, 3.0 * float(steps.max())):
        raise ValueError(
            f"{name}: expected a cycle, got {gap:.2f} m between the pelvis of its last frame and "
            "its first; close it with `make_cyclic`, or say cyclic=False"
        )


def _ankles_apart(positions: FloatArray, fps: float, *, cyclic: bool) -> FloatArray:
    """Distance of the left ankle ahead of the right, along the facing, around its mean, `(n,)`."""
    apart = positions[:, joint("left_ankle")] - positions[:, joint("right_ankle")]
    along = np.sum(apart * facing(positions), axis=1)
    (smooth,) = differentiate(along, fps, (0,), cyclic=cyclic)
    centered: FloatArray = smooth - smooth.mean()
    return centered


def _strongest_frequency(signal: FloatArray, fps: float) -> float:
    """Strides a second where the spectrum peaks."""
    window = np.hanning(len(signal) + 2)[1:-1]
    padded = max(_PADDED, 1 << (8 * len(signal)).bit_length())
    power = np.abs(np.fft.rfft(signal * window, padded)) ** 2
    frequency = np.fft.rfftfreq(padded, 1.0 / fps)
    low, high = np.searchsorted(frequency, _STRIDE_HZ)
    return float(frequency[low + np.argmax(power[low:high])])


def _mean_frequency(
    signal: FloatArray, fps: float, rough_hz: float, straight: NDArray[np.bool_]
) -> float:
    """Strides a second on straight frames only: how fast the phase of the stride advances.

    Turns interrupt the rhythm of steps, and a spectrum of the whole would count them.
    """
    frequency = np.fft.fftfreq(len(signal), 1.0 / fps)
    band = (frequency > 0.5 * rough_hz) & (frequency < 1.6 * rough_hz)
    # Without negative frequencies the signal becomes an arrow that turns once a stride.
    arrow = np.fft.ifft(np.fft.fft(signal) * band)
    turned = arrow[1:] * np.conj(arrow[:-1]) * (straight[1:] & straight[:-1])
    found = float(np.angle(turned.sum())) * fps / (2.0 * np.pi)
    return found if found > 0.0 else rough_hz


def _travel(pelvis: FloatArray, fps: float, stride_s: float, *, cyclic: bool) -> FloatArray:
    """Horizontal velocity of the pelvis without the sway of strides, `(num_frames, 3)`."""
    smooth = smooth_over(pelvis * _FLOOR, fps, stride_s, cyclic=cyclic)
    return differentiate(smooth, fps, (1,), cyclic=cyclic)[0]


def _straight(
    travel: FloatArray, direction: FloatArray, fps: float, *, cyclic: bool
) -> NDArray[np.bool_]:
    speed = np.linalg.norm(travel, axis=1)
    walking: NDArray[np.bool_] = speed >= _PAUSE_SHARE * np.quantile(speed, 0.75)
    (turning,) = differentiate(direction, fps, (1,), cyclic=cyclic)
    rate = np.linalg.norm(turning, axis=1)
    limit = max(_TURN_MAX, float(np.quantile(rate[walking], _STRAIGHT_SHARE)))
    straight: NDArray[np.bool_] = walking & (rate <= limit)
    return straight


def _typical_range(
    values: FloatArray, window: float, straight: NDArray[np.bool_], *, cyclic: bool
) -> float:
    """Median range of `(num_frames, n)` within windows centred on straight frames, mean over n."""
    count = len(values)
    length = min(round(window) + 1, count)
    starts = np.arange(count if cyclic else count - length + 1)
    if cyclic:
        values = np.concatenate([values, values[: length - 1]])
    windows = sliding_window_view(values, length, axis=0)[starts]
    centered = straight[(starts + length // 2) % count]
    if centered.any():
        windows = windows[centered]
    return float(np.median(np.ptp(windows, axis=-1), axis=0).mean())


def _mean_deg(angles: FloatArray) -> float:
    return float(np.rad2deg(angles.mean()))
