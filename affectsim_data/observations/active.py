"""A-Obs: what a robot saw that moved to see better, from the recorded trajectory of a policy."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.episodes import Episode, World
from affectsim_data.observations.recordings import RecordedRuns
from affectsim_data.observations.still import PInit, head_camera_pose
from affectsim_data.poses import FloatArray

__all__ = ["AObs", "clip_start_s"]

_LONGEST_ACTION_M = 0.3
"""No action leads further than 0.25 m: what begins further from the start begins elsewhere."""


def clip_start_s(handed_off_s: float, duration_s: float) -> float:
    """When the clip begins: at the first whole cycle of the motion after the handoff.

    There the motion is where the clips of all other conditions begin.

    Args:
        handed_off_s: End of the action `hand_off`, since the start of the episode.
        duration_s: Of a cycle.

    Examples:
        >>> clip_start_s(4.25, 2.0), clip_start_s(4.0, 2.0)
        (6.0, 4.0)
    """
    return math.ceil(handed_off_s / duration_s - 1e-9) * duration_s


@dataclasses.dataclass(frozen=True)
class AObs:
    """A-Obs: the robot's head camera while it collects the clip.

    Between the ends of two actions the robot moves straight and turns evenly. Where nothing was
    handed off, or the robot stopped before the clip was whole, the clip is that of P-Init.
    """

    trajectories: RecordedRuns
    name: str = "a_obs"

    def falls_back(self, episode: Episode) -> bool:
        """Whether no whole clip was acquired, so that this one is that of P-Init.

        Raises:
            ValueError: There is no trajectory of the episode, or it begins elsewhere.
        """
        knots = self._knots(episode)
        if not len(knots):
            return True
        clip_end_s = clip_start_s(knots[0, 0], episode.duration_s) + 2.0 * episode.duration_s
        return bool(knots[-1, 0] < clip_end_s - 1e-9)

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """Poses between the ends of actions, at the instants of the motion that were collected.

        Raises:
            ValueError: There is no trajectory of the episode, or it begins elsewhere.
        """
        if self.falls_back(episode):
            return PInit().trajectory(episode, world, time_s)
        knots = self._knots(episode)
        since_start_s = clip_start_s(knots[0, 0], episode.duration_s) + time_s - episode.phase_s
        # Rounded, because degrees in a table are not the radians they were made of: a robot that
        # stays is to see the very pixels of P-Init.
        turned = np.unwrap(np.concatenate([[0.0], knots[:, 4] - episode.start_yaw]))[1:]
        path = np.column_stack([knots[:, 1:4], episode.start_yaw + np.round(turned, 12)])
        x, y, z, yaw = (np.interp(since_start_s, knots[:, 0], column) for column in path.T)
        position = np.stack([x, y, z], axis=-1)
        return CameraTrajectory(head_camera_pose(position, yaw, world.robot))

    def _knots(self, episode: Episode) -> FloatArray:
        """Poses from the handoff on, of a trajectory that is of this episode."""
        runs = self.trajectories
        place = runs.place(episode.episode_id)
        x, _, z = (runs.first_positions[place] - episode.start_position).tolist()
        if math.hypot(x, z) > _LONGEST_ACTION_M:
            raise ValueError(
                f"{runs.file}: the trajectory of episode {episode.episode_id!r} begins "
                f"{math.hypot(x, z):.2f} m from where the robot starts; it was recorded in another "
                "release"
            )
        return runs.after_handoff(episode.episode_id)
