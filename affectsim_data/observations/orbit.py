"""Counterfactual views: the same performance from any side, distance and height."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.episodes import Episode, World
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.visibility import RayCaster, scene_caster

__all__ = ["Orbit", "free_distance", "relative_camera"]

MARGIN_M = 0.3
"""Kept between a camera and what is behind it."""
NEAREST_M = 0.8
"""The margin shrinks before a camera comes nearer to the body axis than this."""


def relative_camera(
    center: FloatArray,
    heading: FloatArray,
    *,
    azimuth: FloatArray | float,
    distance_m: FloatArray | float,
    eye_y: FloatArray | float,
) -> FloatArray:
    """Cameras that look at body centres from a side, `T_world_camera` `(..., 4, 4)`.

    Args:
        center: What they look at, `(..., 3)`.
        heading: Yaw the body faces, radians, `(...)`.
        azimuth: Side, radians: 0 in front of the body, positive towards its left.
        distance_m: Horizontal distance to the centre.
        eye_y: Height of the camera in the world.
    """
    side = np.asarray(heading) + azimuth
    eye = np.stack(
        np.broadcast_arrays(
            center[..., 0] + distance_m * np.sin(side),
            np.asarray(eye_y, np.float64),
            center[..., 2] + distance_m * np.cos(side),
        ),
        axis=-1,
    )
    return look_at(eye, np.broadcast_to(center, eye.shape))


def free_distance(
    center: FloatArray, side: FloatArray, *, eye_y: float, caster: RayCaster
) -> FloatArray:
    """How far from the body axis a camera can be on a side without being in or behind anything.

    Args:
        center: Body centres, `(n, 3)`.
        side: Yaw of the direction, radians, `(n,)`.
        eye_y: Height of the camera in the world.
        caster: The scene.

    Returns:
        Horizontal distances, `(n,)`: at least 0.8 m unless a wall is nearer even than that.
    """
    axis = center.copy()
    axis[:, 1] = eye_y
    direction = np.stack([np.sin(side), np.zeros(len(side)), np.cos(side)], axis=-1)
    wall = caster.distance(axis, direction)
    free: FloatArray = np.maximum(wall - MARGIN_M, np.minimum(NEAREST_M, 0.9 * wall))
    return free


@dataclasses.dataclass(frozen=True)
class Orbit:
    """A camera on a circle around the performer that looks at the body and follows it.

    Side and height are exactly as asked. A wall or a tall piece of furniture nearer than the asked
    distance pulls the camera in front of it; `T_world_camera` in the sample says where it was.
    """

    distance_m: float = 2.0
    """Horizontal distance to the body, metres."""
    azimuth_deg: float = 0.0
    """Side: 0 in front, 90 at the performer's left, 180 behind."""
    height_m: float = 1.2
    """Of the camera above the performer's floor."""
    in_free_space: bool = True
    """Pull the camera in where the scene is in the way; else it goes through walls."""
    follow: bool = True
    """Keep the relative pose as the performer moves; else stay where the cycle's mean body was."""

    def __post_init__(self) -> None:
        if not 0.05 <= self.distance_m <= 50.0:
            raise ValueError(f"Orbit distance_m must be 0.05 to 50, got {self.distance_m}")
        if not math.isfinite(self.azimuth_deg) or not -5.0 <= self.height_m <= 20.0:
            raise ValueError(
                f"Orbit needs a finite azimuth_deg and height_m from -5 to 20, "
                f"got {self.azimuth_deg} and {self.height_m}"
            )

    @property
    def name(self) -> str:
        """States every parameter: `orbit_2m_135deg_1.2m`, then `_still`, `_through` if so."""
        tail = "" if self.follow else "_still"
        tail += "" if self.in_free_space else "_through"
        return f"orbit_{self.distance_m:g}m_{self.azimuth_deg:g}deg_{self.height_m:g}m{tail}"

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """Poses relative to the smoothed way of the target."""
        path = body_path(world.target)
        if self.follow:
            center, heading = path.at(time_s)
        else:
            mean = np.angle(np.exp(1j * path.heading).mean())
            center = np.repeat(path.center.mean(axis=0)[None], len(time_s), axis=0)
            heading = np.full(len(time_s), mean)
        azimuth, eye_y = math.radians(self.azimuth_deg), episode.target.anchor[1] + self.height_m
        distance: FloatArray | float = self.distance_m
        if self.in_free_space:
            caster = scene_caster(world.scene)
            free = free_distance(center, heading + azimuth, eye_y=eye_y, caster=caster)
            distance = np.minimum(free, self.distance_m)
        poses = relative_camera(center, heading, azimuth=azimuth, distance_m=distance, eye_y=eye_y)
        return CameraTrajectory(poses)
