"""What a policy is: observations in, actions out."""

from __future__ import annotations

import dataclasses
from typing import Protocol, runtime_checkable

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.running import Observation

__all__ = ["Decision", "Policy", "PrivilegedPolicy"]


@dataclasses.dataclass(frozen=True)
class Decision:
    """What a policy does next."""

    action: Action
    planner_calls: int = 0
    """Calls of its planner that led to it; they count against the budget."""
    approaching: bool = False
    """Whether it goes to a view of a person it has found: the phase the trajectory tells."""
    num_steps: int = 1
    """The action is done so often, without a look between; the episode may end before that."""


class Policy(Protocol):
    """Anything that moves the robot; one object acts in many episodes, one after the other."""

    @property
    def name(self) -> str:
        """What stands in the column `policy`: the policy and its configuration."""
        ...

    def reset(self, camera: Camera, *, seed: int) -> None:
        """A new episode begins; nothing may be carried over from the last.

        Args:
            camera: Of the images to come.
            seed: Of whatever is random; the same seed and observations, the same actions.
        """
        ...

    def act(self, observation: Observation) -> Decision:
        """The next action. After a handoff it goes on to be asked, to follow the person."""
        ...


@runtime_checkable
class PrivilegedPolicy(Protocol):
    """A policy that is told what no robot knows: for comparison only, and said so in its name."""

    def reveal(self, episode: Episode, world: World, navmesh: NavMesh) -> None:
        """Told after `reset`."""
        ...
