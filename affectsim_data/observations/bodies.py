"""Where a performer is and looks over one motion cycle, smoothed for a camera that follows."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.episodes import Person
from affectsim_data.poses import FloatArray, transform_points

__all__ = ["SAMPLES_PER_KNOT", "BodyPath", "body_path", "path_instants", "path_of_frames"]

_KNOT_PAIRS_PER_S = 2.5
SAMPLES_PER_KNOT = 6
"""A path has samples at every knot of a camera that follows it, and between: some 30 a second."""
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

    @property
    def mean_heading(self) -> float:
        """Yaw the body faces over the cycle, radians in (-pi, pi]."""
        return float(np.angle(np.exp(1j * self.heading).mean()))

    def placed(self, T_world_performance: FloatArray) -> BodyPath:
        """The same way elsewhere, `(4, 4)`, turned about the vertical and moved."""
        pose = np.asarray(T_world_performance)
        return dataclasses.replace(
            self,
            center=transform_points(pose, self.center),
            heading=self.heading + np.arctan2(pose[0, 2], pose[2, 2]),
        )

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


def path_instants(duration_s: float) -> FloatArray:
    """Instants of a path's samples, seconds, `(num_samples,)`.

    A multiple of 12 of them, so that every cycle instant is one.
    """
    count = 2 * SAMPLES_PER_KNOT * max(2, round(duration_s * _KNOT_PAIRS_PER_S))
    instants: FloatArray = np.arange(count) * duration_s / count
    return instants


def body_path(person: Person) -> BodyPath:
    """The smoothed way of a person over one cycle."""
    duration_s = person.motion.duration_s
    return path_of_frames(person.joint_frames(path_instants(duration_s)), duration_s)


def path_of_frames(frames: FloatArray, duration_s: float) -> BodyPath:
    """The same of a body's joint frames at `path_instants`, `(num_samples, 22, 4, 4)`."""
    from scipy.ndimage import gaussian_filter1d  # slow to import, and few conditions need it

    joints = frames[..., :3, 3]
    low, high = joints[..., 1].min(axis=1), joints[..., 1].max(axis=1)
    center = joints[:, 0].copy()
    center[:, 1] = (low + high) / 2.0
    forward = frames[:, 0, :3, 2]
    direction = forward[:, 0] * 1j + forward[:, 2]
    rate = len(frames) / duration_s
    smooth = gaussian_filter1d(direction, _HEADING_SMOOTHING_S * rate, mode="wrap")
    # A performer who turns round on the spot may average out: fall back to the raw direction.
    heading = np.angle(np.where(np.abs(smooth) > 1e-3, smooth, direction))
    center = gaussian_filter1d(center, _POSITION_SMOOTHING_S * rate, axis=0, mode="wrap")
    return BodyPath(center=center, heading=np.unwrap(heading), duration_s=duration_s)
