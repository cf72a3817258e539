"""What is known of one performance while it is put on a body."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter1d

from affectsim_data.builders.performances.curves import keyframes
from affectsim_data.builders.performances.rig import SIGN
from affectsim_data.builders.performances.scenarios.vocabulary import Arm, Channel, Script
from affectsim_data.builders.performances.styles import Performer, Posture, Side
from affectsim_data.motions.motion import Emotion
from affectsim_data.poses import FloatArray

__all__ = ["MANNERS", "Manner", "Stage"]


@dataclasses.dataclass(frozen=True)
class Manner:
    """How an emotion moves, whatever it does."""

    smooth_frames: float
    """Standard deviation of the smoothing of arms, trunk and head; large is soft."""
    breath_hz: float
    breath_deg: float
    """How far the chest rises."""


MANNERS: dict[Emotion, Manner] = {
    "angry": Manner(0.9, 0.45, 1.2),
    "fearful": Manner(1.8, 0.75, 0.9),
    "happy": Manner(1.5, 0.35, 0.9),
    "neutral": Manner(1.2, 0.25, 0.8),
    "sad": Manner(4.0, 0.22, 1.6),
}
"""Sad movement is slow and soft, anger abrupt; fear breathes fast and shallow, sadness deep."""


@dataclasses.dataclass(frozen=True)
class Stage:
    """A script, who performs it, how, and the instants it is performed at."""

    script: Script
    who: Performer
    posture: Posture
    manner: Manner
    time_s: FloatArray
    """Instants of the script, `(n,)`, within its cycle."""
    size: float
    """Factor on gestures in the air."""
    amount: float
    """Factor on turns, shifts, steps and shakes."""
    rng: np.random.Generator

    @property
    def sign(self) -> float:
        """+1 where the preferred side is the left: what is written for it, along +X."""
        return SIGN[self.who.hand]

    @property
    def phase(self) -> FloatArray:
        """Phase of the script at each frame, `(n,)`, in [0, 1)."""
        return self.time_s / self.script.duration_s

    @property
    def ground_amount(self) -> float:
        """Factor on what the legs do: a body that goes down to the floor goes all the way."""
        return 1.0 if self.script.deep else self.amount

    def side(self, arm: Arm) -> Side:
        """Left or right."""
        return self.who.hand if arm == "hand" else self.who.other_hand

    def curve(self, keys: Sequence[tuple[float, ArrayLike]], *, lead_s: float = 0.0) -> FloatArray:
        """Keys of the script at each frame, read `lead_s` ahead, `(n, ...)`."""
        period = self.script.duration_s
        rated = sorted(((time / period, value) for time, value in keys), key=_time)
        return keyframes(np.mod(self.phase + lead_s / period, 1.0), rated)

    def shaken(self, *channels: Channel) -> FloatArray:
        """Oscillations of channels, `(n, num_channels)`."""
        return np.stack([self._shaken(channel) for channel in channels], axis=1)

    def _shaken(self, channel: Channel) -> FloatArray:
        total = np.zeros_like(self.time_s)
        for shake in self.script.shakes:
            if shake.channel == channel:
                since, left = self.time_s - shake.start, shake.end - self.time_s
                swell = np.clip(np.minimum(since, left) / shake.fade_s, 0.0, 1.0)
                wave = np.sin(2.0 * np.pi * (shake.rate_hz * since - shake.shift))
                total += shake.amplitude * swell * swell * (3.0 - 2.0 * swell) * wave
        return self.amount * total

    def smooth(self, values: FloatArray) -> FloatArray:
        """Curves without the edges that this manner does not have, `(n, ...)`."""
        frames = self.manner.smooth_frames
        softened: FloatArray = gaussian_filter1d(values, frames, axis=0, mode="wrap")
        return softened


def _time(key: tuple[float, ArrayLike]) -> float:
    return key[0]
