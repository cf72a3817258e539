"""What no robot knows about the episode it acts in: for debugging, told only on request."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from affectsim_data.observations.still import head_camera_pose
from affectsim_data.simulation.moving import wrapped_angle
from affectsim_data.simulation.running import EpisodeRun
from affectsim_data.visibility import body_samples, scene_caster, visible_share

__all__ = ["privileged_facts"]


def privileged_facts(run: EpisodeRun) -> dict[str, Any]:
    """Which episode it is, how it ended, and where robot and target are at this instant.

    - `position_m`, `yaw`: of the robot in the world, `(3,)` and radians.
    - `target_position_m`, `target_distance_m`, `target_bearing`: the target's pelvis, `(3,)`; how
      far it is on the plan; and by what angle the robot would have to turn left to face it.
    - `visible_share`: of the target's body surface, in the camera's image, in [0, 1].
    """
    position = np.array(run.state.position)
    target = run.people(run.time_s)[0]
    x, _, z = (target - position).tolist()
    samples = body_samples(run.world, run.episode.phase_s + np.array([run.time_s]))
    pose = head_camera_pose(position, np.array(run.state.yaw), run.world.robot)
    seen = visible_share(samples, pose[None, None], run.camera, scene_caster(run.world.scene))
    return {
        "episode_id": run.episode.episode_id,
        "scene_id": run.episode.scene_id,
        "emotion": run.episode.emotion,
        "outcome": run.outcome or "",
        "position_m": position,
        "yaw": run.state.yaw,
        "target_position_m": target,
        "target_distance_m": math.hypot(x, z),
        "target_bearing": wrapped_angle(math.atan2(-x, -z) - run.state.yaw),
        "visible_share": float(seen.visible[0, 0]),
    }
