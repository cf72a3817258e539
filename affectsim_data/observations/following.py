"""Trajectories that keep a relative view as the performer moves, in front of what is in the way."""

from __future__ import annotations

import numpy as np

from affectsim_data.observations.bodies import SAMPLES_PER_KNOT
from affectsim_data.observations.knots import make_knots
from affectsim_data.observations.orbit import MARGIN_M, NEAREST_M
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.observations.steadying import SteadyPath
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["follow", "greatest_haste"]

_TUBE_M = 0.15
"""The way out to the camera is free this far to its sides, too."""
_WALL_GAP_M = 0.15
"""Kept before a wall that is nearer than a camera should come to the body."""
_PULL_SMOOTHING_S = (0.3, 0.6, 1.2)
"""A camera is pulled in that long before it must be; if that is too fast, for the whole cycle."""
_EASE = 0.9
"""Share of the speed and acceleration allowed that pulling in may use."""


def follow(
    steady: SteadyPath,
    duration_s: float,
    *,
    azimuth: float,
    distance_m: float,
    eye_y: float,
    caster: RayCaster,
    search: ReferenceSearch,
) -> FloatArray:
    """Knots `(k, 7)` of a camera at a relative pose, pulled in where something is in the way.

    Args:
        steady: What it follows, in the world.
        duration_s: Of the cycle.
        azimuth: To the heading, radians.
        distance_m: To the body, horizontal.
        eye_y: Height in the world.
        caster: Rays against the scene.
        search: Limits.
    """
    side = steady.heading + azimuth
    out = np.stack([np.sin(side), np.zeros(len(side)), np.cos(side)], axis=-1)
    axis = steady.center.copy()
    axis[:, 1] = eye_y
    free = _free(axis, out, distance_m, caster)
    distance = _eased(np.minimum(free, distance_m), axis, out, duration_s, search)
    knots = slice(None, None, SAMPLES_PER_KNOT)
    return make_knots((axis + distance[:, None] * out)[knots], steady.center[knots])


def _free(axis: FloatArray, out: FloatArray, distance_m: float, caster: RayCaster) -> FloatArray:
    """How far out of the body's axis a camera can be at each sample, `(n,)`."""
    across = np.stack([out[:, 2], np.zeros(len(out)), -out[:, 0]], axis=-1)
    up = np.broadcast_to(np.array([0.0, 1.0, 0.0]), out.shape)
    beside = np.stack([0.0 * up, across, -across, up, -up]) * _TUBE_M
    wall = caster.distance(axis + beside, out, limit=distance_m + 2.0 * MARGIN_M)
    # In a corner the sides may be blocked at once: what is straight ahead counts there.
    narrow = np.minimum(NEAREST_M, np.maximum(wall[0] - _WALL_GAP_M, 0.5 * wall[0]))
    free: FloatArray = np.maximum(wall.min(axis=0) - MARGIN_M, narrow)
    return free


def _eased(
    wanted: FloatArray,
    axis: FloatArray,
    out: FloatArray,
    duration_s: float,
    search: ReferenceSearch,
) -> FloatArray:
    """Distances `(n,)` nowhere above the wanted ones that change gently."""
    if np.ptp(wanted) < 1e-6:
        return np.full(len(wanted), wanted.min())
    from scipy.ndimage import minimum_filter1d, uniform_filter1d  # slow to import, seldom needed

    rate = len(wanted) / duration_s
    for smoothing_s in _PULL_SMOOTHING_S:
        half = max(1, round(smoothing_s * rate / 2.0))
        # Means over no more samples than the least was taken over stay below what is wanted.
        eased = minimum_filter1d(wanted, 4 * half + 1, mode="wrap")
        for _ in range(2):
            eased = uniform_filter1d(eased, 2 * half + 1, mode="wrap")
        speed, acceleration = greatest_haste(axis + eased[:, None] * out, rate)
        if speed <= _EASE * search.speed_m_s and acceleration <= _EASE * search.acceleration_m_s2:
            gentle: FloatArray = np.minimum(eased, wanted)
            return gentle
    return np.full(len(wanted), wanted.min())


def greatest_haste(eyes: FloatArray, rate: float) -> tuple[float, float]:
    """Greatest speed and acceleration of cyclic positions `(n, 3)`."""
    velocity = (np.roll(eyes, -1, axis=0) - eyes) * rate
    change = (np.roll(velocity, -1, axis=0) - velocity) * rate
    return float(np.linalg.norm(velocity, axis=1).max()), float(
        np.linalg.norm(change, axis=1).max()
    )
