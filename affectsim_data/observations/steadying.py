"""The way a reference camera keeps relative to: a body's, without its haste."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.observations.bodies import BodyPath
from affectsim_data.poses import FloatArray, transform_points

__all__ = ["SteadyPath", "steady_path"]

_TURN_RAD_S = np.radians(60.0)
"""Faster turns of the facing are smoothed until the camera need not swing round."""
_ACCELERATION_M_S2 = 3.0
"""The same for moves of the body."""
_SMOOTHING_S = (0.0, 0.4, 0.8, 1.6, 3.2)
"""Tried in turn; last comes none but the mean."""


@dataclasses.dataclass(frozen=True, eq=False)
class SteadyPath:
    """One cycle of what a camera follows, evenly sampled from instant 0; the end leads on to it."""

    center: FloatArray
    """What it looks at, `(num_samples, 3)`."""
    heading: FloatArray
    """Yaw that azimuths count from, radians, unwrapped, `(num_samples,)`."""

    def placed(self, T_world_performance: FloatArray) -> SteadyPath:
        """The same way elsewhere, `(4, 4)`, turned about the vertical and moved."""
        pose = np.asarray(T_world_performance)
        yaw = np.arctan2(pose[0, 2], pose[2, 2])
        center = transform_points(pose, self.center)
        return SteadyPath(center, self.heading + yaw)


def steady_path(path: BodyPath) -> SteadyPath:
    """A body's way, smoothed as far as it takes for its turns and moves to be gentle.

    A heading that turns round and round keeps its whole turns, evenly spread at the worst.
    """
    count, rate = len(path.heading), len(path.heading) / path.duration_s
    closing = path.heading[0] - path.heading[-1]
    winding = path.heading[-1] - path.heading[0] + np.angle(np.exp(1j * closing))
    even = winding * np.arange(count) / count
    heading = _gentle(
        (path.heading - even)[:, None],
        rate,
        order=1,
        limit=_TURN_RAD_S - abs(winding) / path.duration_s,
    )
    center = _gentle(path.center, rate, order=2, limit=_ACCELERATION_M_S2)
    return SteadyPath(center, heading[:, 0] + even)


def _gentle(values: FloatArray, rate: float, *, order: int, limit: float) -> FloatArray:
    """Cyclic values `(n, d)` smoothed until their first or second derivative keeps a limit."""
    from scipy.ndimage import gaussian_filter1d  # slow to import, and few conditions need it

    for smoothing_s in _SMOOTHING_S:
        smooth = values
        if smoothing_s:
            smooth = gaussian_filter1d(values, smoothing_s * rate, axis=0, mode="wrap")
        change = smooth
        for _ in range(order):
            change = (np.roll(change, -1, axis=0) - change) * rate
        if np.linalg.norm(change, axis=1).max() <= limit:
            return smooth
    mean: FloatArray = np.broadcast_to(values.mean(axis=0), values.shape).copy()
    return mean if order == 1 else smooth
