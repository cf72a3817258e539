"""Cameras that do not move: the robot's first pose and the room monitor."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.episodes import Episode, Robot, World
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    compose_pose,
    quaternion_multiply,
    yaw_quaternion,
)

__all__ = ["PInit", "PMon", "head_camera_pose", "monitor_pose"]


def head_camera_pose(position: FloatArray, yaw: FloatArray, robot: Robot) -> FloatArray:
    """`T_world_camera`, `(..., 4, 4)`, of a robot on the floor at `(..., 3)` with yaw `(...)`."""
    eye = np.asarray(position, np.float64) + np.array([0.0, robot.camera_height_m, 0.0])
    return compose_pose(yaw_quaternion(yaw), eye)


def monitor_pose(position: FloatArray, yaw: FloatArray, pitch: FloatArray) -> FloatArray:
    """`T_world_camera`, `(..., 4, 4)`, at `(..., 3)`, turned by yaw and then tilted by pitch."""
    tilt = axis_angle_quaternion(np.array([1.0, 0.0, 0.0]), pitch)
    return compose_pose(quaternion_multiply(yaw_quaternion(yaw), tilt), position)


@dataclasses.dataclass(frozen=True)
class PInit:
    """P-Init: the robot stands still at x0 and sees what its head camera sees there."""

    name: str = "p_init"

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """One pose for every frame."""
        pose = head_camera_pose(
            np.array(episode.start_position), np.array(episode.start_yaw), world.robot
        )
        return CameraTrajectory.still(pose, num_frames=len(time_s))


@dataclasses.dataclass(frozen=True)
class PMon:
    """P-Mon: a fixed camera near the ceiling of the performer's room."""

    name: str = "p_mon"

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """One pose for every frame."""
        pose = monitor_pose(
            np.array(episode.monitor_position),
            np.array(episode.monitor_yaw),
            np.array(episode.monitor_pitch),
        )
        return CameraTrajectory.still(pose, num_frames=len(time_s))
