"""`straight_to_target` and `reference`: policies that know where everything is, to compare with."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable

import numpy as np

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.policies.driving import bearing, drive_along, turn_towards
from affectsim_data.simulation.policies.protocol import Decision
from affectsim_data.simulation.policies.truth import Truth, nearest_view, reference_view
from affectsim_data.simulation.running import Observation

__all__ = ["GuidedPolicy", "reference", "straight_to_target"]

_THERE_M = 0.35
"""Nearer its view than this, the robot need not go on."""

View = Callable[[Truth, float], FloatArray | None]
"""Where to stand, `(3,)`, by the truth and the instant of the motion; `None` for nowhere."""


@dataclasses.dataclass
class GuidedPolicy:
    """Goes the shortest way to a view of the target, hands off there, and keeps facing it."""

    name: str
    """Begins with `privileged:`."""
    view: View
    """Where to stand."""

    def reset(self, camera: Camera, *, seed: int) -> None:
        """Forgets the last episode."""
        self._truth: Truth | None = None
        self._goal: FloatArray | None = None

    def reveal(self, episode: Episode, world: World, navmesh: NavMesh) -> None:
        """Chooses the view for the instant at which the clip will begin."""
        self._truth = Truth(episode, world, navmesh)
        self._goal = self.view(self._truth, episode.phase_s)

    def act(self, observation: Observation) -> Decision:
        """On to the view, then to face the target, then the handoff."""
        if self._truth is None:
            raise ValueError(f"{self.name}: has to be told the truth: call reveal after reset")
        if self._goal is None:
            return Decision("stop")
        place, yaw = self._truth.place(observation)
        # Once it collects it only turns: a robot that drives looks where it goes.
        action = None if observation.collecting else self._drive(place, yaw, observation)
        if action is None:
            target = self._truth.people(observation.time_s)[0]
            action = turn_towards(yaw, bearing(place[[0, 2]], target[[0, 2]]))
        if action is None:
            action = "stop" if observation.collecting else "hand_off"
        return Decision(action, approaching=not observation.collecting)

    def _drive(self, place: FloatArray, yaw: float, observation: Observation) -> Action | None:
        """The next action on the shortest way to the view, `None` if it is there."""
        assert self._truth is not None
        assert self._goal is not None
        if _apart(place, self._goal) <= _THERE_M:
            return None
        way = self._truth.navmesh.shortest_path(place, self._goal)
        if way is None:
            return None
        is_free = functools.partial(self._truth.is_free, time_s=observation.time_s)
        return drive_along(place[[0, 2]], yaw, way[1:, [0, 2]], is_free=is_free)


def straight_to_target() -> GuidedPolicy:
    """The shortest way to the nearest place some 1.75 m from the target, from whatever side."""
    return GuidedPolicy("privileged:straight_to_target", nearest_view)


def reference() -> GuidedPolicy:
    """The shortest way to where the P-Ref camera is as the clip begins, as near as a robot can."""
    return GuidedPolicy("privileged:reference", reference_view)


def _apart(one: FloatArray, other: FloatArray) -> float:
    """Distance of two points on the plan."""
    away = np.subtract(one, other)
    return math.hypot(away[0], away[2])
