"""Smoothed signals and their time derivatives, the same at every rate.

Differentiating thrice amplifies noise by the cube of its frequency, so every derivative is of the
signal behind one low-pass: a Butterworth filter of second order run forwards and backwards, whose
response without phase is `1 / (1 + (f / cutoff)**4)`. Filter and derivative are applied in the
frequency domain, where both are exact for a cycle and do not depend on the rate.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["CUTOFF_HZ", "MIN_FRAMES", "differentiate", "smooth_over"]

CUTOFF_HZ = 5.0
"""Of the low-pass: voluntary movement of limbs lies below, jitter of capture above. At 5 Hz hand
jerk of real gestures comes out as it was measured, see docs/descriptors.md."""
MIN_FRAMES = 8
"""Fewer frames have no third derivative worth the name."""


def differentiate(
    values: FloatArray,
    fps: float,
    orders: Sequence[int] = (1, 2, 3),
    *,
    cyclic: bool = True,
    cutoff_hz: float = CUTOFF_HZ,
) -> list[FloatArray]:
    """Time derivatives of a low-passed signal, one array of the signal's shape per order.

    Args:
        values: The signal, frames first, `(num_frames, ...)`.
        fps: Frames per second.
        orders: Which derivatives; 0 is the smoothed signal itself.
        cyclic: Whether the last frame leads into the first. An open signal is continued at both
            ends by its mirror image through the end point, which keeps its slope there.
        cutoff_hz: Where the low-pass halves an amplitude.

    Raises:
        ValueError: Fewer than `MIN_FRAMES` frames, or a value that is not finite.
    """
    signal, drift, spectrum, frequency = _spectrum(values, fps, cyclic=cyclic)
    spectrum = spectrum * _column(1.0 / (1.0 + (frequency / cutoff_hz) ** 4), spectrum)
    found = []
    for order in orders:
        turned = spectrum * _column(_differentiator(frequency, order, signal), spectrum)
        derivative = np.fft.irfft(turned, len(signal), axis=0)[: len(values)]
        if order == 0:
            derivative += drift
        elif order == 1:
            derivative += (drift[1] - drift[0]) * fps
        found.append(derivative)
    return found


def smooth_over(
    values: FloatArray, fps: float, period_s: float, *, cyclic: bool = True
) -> FloatArray:
    """Running mean over a period, which need not be whole frames, of the signal's shape.

    Whatever repeats with the period is gone; what is slower stays.

    Raises:
        ValueError: Fewer than `MIN_FRAMES` frames, or a value that is not finite.
    """
    signal, drift, spectrum, frequency = _spectrum(values, fps, cyclic=cyclic)
    spectrum = spectrum * _column(np.sinc(frequency * period_s), spectrum)
    mean: FloatArray = np.fft.irfft(spectrum, len(signal), axis=0)[: len(values)] + drift
    return mean


def _spectrum(
    values: FloatArray, fps: float, *, cyclic: bool
) -> tuple[FloatArray, FloatArray, np.ndarray, FloatArray]:
    """Periodic signal `(m, ...)`, the drift taken out of it `(n, ...)`, spectrum, frequencies."""
    count = len(values)
    if count < MIN_FRAMES:
        raise ValueError(f"derivatives need at least {MIN_FRAMES} frames, got {count}")
    finite = np.isfinite(values).reshape(count, -1).all(axis=1)
    if not finite.all():
        raise ValueError(
            f"derivatives need finite values, got nan or inf in {int((~finite).sum())} of {count} "
            f"frames, first in frame {int(np.argmin(finite))}"
        )
    signal, drift = np.asarray(values, np.float64), np.zeros_like(values, np.float64)
    if not cyclic:
        share = _column(np.arange(count) / (count - 1.0), signal)
        drift = signal[0] + share * (signal[-1] - signal[0])
        signal = signal - drift
        # Odd about both ends: values and slopes go on smoothly.
        signal = np.concatenate([signal, -signal[-2:0:-1]])
    frequency: FloatArray = np.fft.rfftfreq(len(signal), 1.0 / fps).astype(np.float64)
    return signal, drift, np.fft.rfft(signal, axis=0), frequency


def _differentiator(frequency: FloatArray, order: int, signal: FloatArray) -> np.ndarray:
    factor = (2j * np.pi * frequency) ** order
    if order % 2 and len(signal) % 2 == 0:
        factor[-1] = 0.0  # the highest frequency has no sign, so no odd derivative
    return factor


def _column(values: np.ndarray, like: np.ndarray) -> np.ndarray:
    """Values of frames, shaped to multiply signals."""
    return values.reshape(-1, *(1,) * (like.ndim - 1))
