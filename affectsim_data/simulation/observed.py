"""Observations as Gymnasium has them: a dictionary of arrays, and the space they are from."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gymnasium import spaces

from affectsim_data.cameras import Camera
from affectsim_data.simulation.actions import ACTION_RATE_HZ, STEP_M, Budget
from affectsim_data.simulation.running import Observation

__all__ = ["as_arrays", "observation_space"]

_LONGEST_CLIP_S = 3600.0
"""No clip takes as long to collect; with the budget it bounds how long and far the robot goes."""
_HIGHEST_CAMERA_M = 10.0


def observation_space(camera: Camera, budget: Budget) -> spaces.Dict:
    """What observations of images of this size can be within this budget.

    All bounds are finite but that of depth, which is `inf` where nothing was hit.
    """
    image = (camera.height, camera.width)
    longest_s = budget.max_actions / ACTION_RATE_HZ + _LONGEST_CLIP_S
    farthest_m = longest_s * ACTION_RATE_HZ * STEP_M
    reach = np.array([farthest_m, farthest_m, math.pi], np.float32)
    most = np.array([budget.max_actions, budget.max_planner_calls], np.int32)
    return spaces.Dict(
        {
            "rgb": spaces.Box(0, 255, (*image, 3), np.uint8),
            "depth": spaces.Box(0.0, np.inf, image, np.float32),
            "pose": spaces.Box(-reach, reach, dtype=np.float32),
            "camera_height_m": spaces.Box(0.0, _HIGHEST_CAMERA_M, (1,), np.float32),
            "time_s": spaces.Box(0.0, longest_s, (1,), np.float32),
            "budget_left": spaces.Box(np.zeros_like(most), most, dtype=np.int32),
            "clipped": spaces.Discrete(2),
            "collecting": spaces.Discrete(2),
        }
    )


def as_arrays(observation: Observation) -> dict[str, Any]:
    """What the robot sees and knows, as the observation space has it."""
    x, _, z = observation.position.tolist()
    left = (observation.actions_left, observation.planner_calls_left)
    return {
        "rgb": observation.rgb,
        "depth": observation.depth,
        "pose": np.array([x, 0.0 - z, observation.yaw], np.float32),
        "camera_height_m": np.array([observation.camera_height_m], np.float32),
        "time_s": np.array([observation.time_s], np.float32),
        "budget_left": np.array(left, np.int32),
        "clipped": np.int64(observation.clipped),
        "collecting": np.int64(observation.collecting),
    }
