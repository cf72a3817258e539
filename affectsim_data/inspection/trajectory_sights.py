"""What a robot had of its target along a run: how much of the body, from how far, which side."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import NDArray

from affectsim_data.episodes import World
from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import VisibleShare, body_samples, scene_caster, visible_share

__all__ = ["SEEN_SHARE", "Sights", "run_sights"]

SEEN_SHARE = 0.3
"""Part of the body in view from which on somebody counts as seen."""
_BATCH = 12
"""States at a time: rays against a second person are exact for so many instants."""


@dataclasses.dataclass(frozen=True, eq=False)
class Sights:
    """Of some states of a run, `(num_states,)` each; all of it privileged."""

    states: NDArray[np.int64]
    """Which ones."""
    visible: FloatArray
    """Share of the body's surface in the image with nothing before it, in [0, 1]."""
    in_image: FloatArray
    """Share in the image, hidden or not."""
    distance_m: FloatArray
    """From the robot to the middle of the body, on the plan."""
    azimuth: FloatArray
    """Of the robot, seen from the target: radians off its facing, 0 in front, in (-pi, pi]."""

    @functools.cached_property
    def is_seen(self) -> NDArray[np.bool_]:
        """Where enough of the body is in view."""
        return self.visible >= SEEN_SHARE


def run_sights(run: RecordedRun, world: World, states: NDArray[np.int64] | None = None) -> Sights:
    """Casts rays from the robot to the target; of all states if none are given."""
    chosen = np.arange(run.num_actions + 1) if states is None else np.asarray(states, np.int64)
    if not len(chosen):
        nothing = np.zeros(0)
        return Sights(chosen, nothing, nothing, nothing, nothing)
    instants = run.episode.phase_s + run.times_s[chosen]
    poses = run.T_world_camera(world.robot)[chosen]
    shares = [
        _shares(world, instants[first : first + _BATCH], poses[first : first + _BATCH])
        for first in range(0, len(chosen), _BATCH)
    ]
    center, heading = body_path(world.target).at(instants)
    out = run.positions[chosen] - center
    side = np.arctan2(out[:, 0], out[:, 2]) - heading
    return Sights(
        states=chosen,
        visible=np.concatenate([share.visible[:, 0] for share in shares]),
        in_image=np.concatenate([share.in_image[:, 0] for share in shares]),
        distance_m=np.hypot(out[:, 0], out[:, 2]),
        azimuth=np.angle(np.exp(1j * side)),
    )


def _shares(world: World, instants: FloatArray, poses: FloatArray) -> VisibleShare:
    samples = body_samples(world, instants)
    return visible_share(samples, poses[:, None], world.camera, scene_caster(world.scene))
