"""Where a performer is and looks over one motion cycle, smoothed for a camera that follows."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.episodes import Person
from affectsim_data.poses import FloatArray

__all__ = ["BodyPath", "body_path"]

_PATH_FPS = 30.0
_POSITION_SMOOTHING_S = 0.25
_HEADING_SMOOTHING_S = 0.8
"""Long enough that glances and steps do not swing the camera."""


@dataclasses.dataclass(frozen=True)
class BodyPath:
    """One cycle of a body, evenly sampled from instant 0; the last sample leads into the first."""

    center: FloatArray
    """Middle of the body between soles and head, world, `(num_samples, 3)`."""
    heading: FloatArray
    """Yaw the pelvis faces, radians, 0 along +Z, unwrapped, `(num_samples,)`."""
    duration_s: float
    """Of the cycle."""

    def at(self, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Centre `(n, 3)` and heading `(n,)` at instants `(n,)`, cyclic."""
        count = len(self.center)
        place = np.mod(np.asarray(time_s) / self.duration_s, 1.0) * count
        before = np.floor(place).astype(np.intp) % count
        after, share = (before + 1) % count, place - np.floor(place)
        center = self.center[before] + share[:, None] * (self.center[after] - self.center[before])
        turn = self.heading[after] - self.heading[before]
        turn = np.angle(np.exp(1j * turn))
        return center, self.heading[before] + share * turn


def body_path(person: Person) -> BodyPath:
    """The smoothed way of a person over one cycle."""
    from scipy.ndimage import gaussian_filter1d  # slow to import, and few conditions need it

    duration = person.motion.duration_s
    count = max(2, round(duration * _PATH_FPS))
    frames = person.joint_frames(np.arange(count) * duration / count)
    joints = frames[..., :3, 3]
    low, high = joints[..., 1].min(axis=1), joints[..., 1].max(axis=1)
    center = joints[:, 0].copy()
    center[:, 1] = (low + high) / 2.0
    forward = frames[:, 0, :3, 2]
    direction = forward[:, 0] * 1j + forward[:, 2]
    rate = count / duration
    smooth = gaussian_filter1d(direction, _HEADING_SMOOTHING_S * rate, mode="wrap")
    # A performer who turns round on the spot may average out: fall back to the raw direction.
    heading = np.angle(np.where(np.abs(smooth) > 1e-3, smooth, direction))
    center = gaussian_filter1d(center, _POSITION_SMOOTHING_S * rate, axis=0, mode="wrap")
    return BodyPath(center=center, heading=np.unwrap(heading), duration_s=duration)
