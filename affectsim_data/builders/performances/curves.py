"""Periodic curves: what starts as it ends needs no seam."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from affectsim_data.poses import FloatArray

__all__ = ["FPS", "curve", "cycle_phase", "follow", "keyframes", "minimum_jerk", "noise", "wave"]

FPS = 30.0
"""Frames per second of every procedural performance."""


def cycle_phase(num_frames: int) -> FloatArray:
    """Phase of each frame of a cycle, `(num_frames,)`, in [0, 1)."""
    return np.arange(num_frames) / num_frames


def keyframes(phase: FloatArray, keys: Sequence[tuple[float, ArrayLike]]) -> FloatArray:
    """A smooth periodic curve through `(phase, value)` keys, at `phase` `(n,)`: `(n, ...)`.

    Between keys it never overshoots (monotone cubic, Fritsch & Carlson 1980), so a hand that is
    kept clear of the body at the keys stays clear.
    """
    times = np.array([time for time, _ in keys])
    values = np.array([np.asarray(value, np.float64) for _, value in keys])
    ring = np.concatenate([times - 1.0, times, times + 1.0])
    smooth: FloatArray = PchipInterpolator(ring, np.concatenate([values] * 3))(np.mod(phase, 1.0))
    return smooth


def curve(phase: FloatArray, times: Sequence[float], values: Sequence[float]) -> FloatArray:
    """`keyframes` of plain numbers, times and values apart, `(n,)`."""
    return keyframes(phase, list(zip(times, values, strict=True)))


def follow(values: FloatArray, *, hz: float, damping: float = 0.8) -> FloatArray:
    """What hangs from a spring does while its hand moves along a periodic curve, `(n, ...)`.

    The curve comes out late and without edges; below a damping of 0.7 it swings past its turns. A
    second-order low pass in the frequency domain, so cycles stay closed.

    Args:
        values: One cycle at `FPS`, `(n, ...)`.
        hz: Natural frequency; slower is heavier.
        damping: 1 is critical.
    """
    ratio = np.fft.rfftfreq(len(values), 1.0 / FPS) / hz
    response = 1.0 / (1.0 - ratio**2 + 2j * damping * ratio)
    spectrum = np.fft.rfft(values, axis=0)
    spectrum = spectrum * response.reshape(-1, *[1] * (values.ndim - 1))
    followed: FloatArray = np.fft.irfft(spectrum, len(values), axis=0)
    return followed


def minimum_jerk(share: FloatArray) -> FloatArray:
    """0 to 1, still at both ends in speed and acceleration (Flash & Hogan 1985), `(n,)`."""
    smooth: FloatArray = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return smooth


def noise(
    phase: FloatArray,
    *,
    amplitude: float,
    rng: np.random.Generator,
    slowest: int = 1,
    terms: int = 4,
) -> FloatArray:
    """Smooth periodic noise, `(n,)`: sines of `slowest` turns a cycle and more, phases random."""
    turns = np.arange(slowest, slowest + terms)
    shift = rng.uniform(0.0, 1.0, terms)
    waves = np.sin(2.0 * np.pi * (phase[:, None] * turns + shift))
    mixed: FloatArray = amplitude * (waves / np.sqrt(terms)).sum(axis=1)
    return mixed


def wave(phase: FloatArray, turns: int = 1, shift: float = 0.0) -> FloatArray:
    """A cosine of `turns` periods a cycle, greatest at phase `shift`, `(n,)`."""
    cosine: FloatArray = np.cos(2.0 * np.pi * turns * (phase - shift))
    return cosine
