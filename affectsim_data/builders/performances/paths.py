"""The way somebody walks: a closed oval that fits a room, paced as people pace."""

from __future__ import annotations

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["Oval", "paced"]

_STRAIGHT = 1.25
"""Exponent of the curvature's rise: 1 is round, more has straighter sides and tighter ends."""
_SLOWDOWN = 0.24
"""Share by which speed varies: that much above the mean along the sides, below it in the ends."""
_SLOWEST_PACE = 0.5
_PACE_TERMS = 5


class Oval:
    """A closed path whose curvature varies smoothly, walked faster along its sides."""

    side_speed = 1.0 + _SLOWDOWN
    """Speed in the middle of a side over that of the whole round."""

    def __init__(self, length_m: float, side_way: float) -> None:
        """A round of `length_m` metres, bending to the left if `side_way` is 1, right if -1."""
        self._way = np.linspace(0.0, 1.0, 2049)
        bend = np.abs(np.sin(2.0 * np.pi * self._way)) ** (2.0 * _STRAIGHT)
        turned = np.concatenate([[0.0], np.cumsum(0.5 * (bend[1:] + bend[:-1]))])
        self._turned = side_way * 2.0 * np.pi * turned / turned[-1]
        direction = np.stack(
            [np.sin(self._turned), np.zeros_like(self._turned), np.cos(self._turned)], axis=1
        )
        steps = 0.5 * length_m * (direction[1:] + direction[:-1]) / (len(self._way) - 1)
        self._points = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        self._points -= self._way[:, None] * self._points[-1]

    def at(self, phase: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points `(n, 3)` and heading `(n,)` at any phase of the round; the heading never jumps."""
        way = phase + _SLOWDOWN * np.sin(4.0 * np.pi * phase) / (4.0 * np.pi)
        rounds = np.floor(way)
        within = way - rounds
        points = np.stack([np.interp(within, self._way, axis) for axis in self._points.T], axis=1)
        heading = np.interp(within, self._way, self._turned) + rounds * self._turned[-1]
        return points, heading


def paced(phase: FloatArray, unevenness: float, rng: np.random.Generator) -> FloatArray:
    """Phase of what is done at phase of the time, `(n,)`: now faster, now slower, never backward.

    Starts at 0 and stays below 1.

    Args:
        phase: Of each frame, evenly in [0, 1).
        unevenness: Standard deviation of the pace as a share of its mean.
        rng: Where it quickens.
    """
    turns = np.arange(1, _PACE_TERMS + 1)
    shift = rng.uniform(0.0, 2.0 * np.pi, _PACE_TERMS)
    size = rng.uniform(0.5, 1.0, _PACE_TERMS)
    size *= unevenness / np.sqrt(0.5 * (size**2).sum())
    waves = size * np.cos(2.0 * np.pi * turns * phase[:, None] + shift)
    size *= min(1.0, (1.0 - _SLOWEST_PACE) / max(-float(waves.sum(axis=1).min()), 1e-9))
    gained = np.sin(2.0 * np.pi * turns * phase[:, None] + shift) - np.sin(shift)
    way: FloatArray = phase + gained @ (size / (2.0 * np.pi * turns))
    return way
