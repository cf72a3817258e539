"""A policy for tests that fails in a way of its own in every episode but one."""

from __future__ import annotations

import os
import time
from typing import Any

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.simulation.policies import Decision
from affectsim_data.simulation.running import Observation


class Troubled:
    """Turns twice, hands off and waits; what goes wrong is by the episode's number."""

    name = "privileged:troubled"

    def reset(self, camera: Camera, *, seed: int) -> None:
        """Forgets."""
        self._steps = 0
        self._number = ""

    def reveal(self, episode: Episode, world: World, navmesh: NavMesh) -> None:
        """Learns which episode it is."""
        self._number = episode.episode_id.rpartition("/")[2]

    def act(self, observation: Observation) -> Any:
        """Turns, hands off, waits, and fails."""
        self._steps += 1
        if self._steps == 4 and self._number == "0":
            raise LookupError("lost them while following")
        if self._steps == 3 and self._number == "1":
            return "hand_off"
        if self._steps == 3 and self._number == "2":
            time.sleep(1.1)
        if self._steps == 3 and self._number == "3":
            time.sleep(600.0)
        if self._steps == 2 and self._number == "4":
            os._exit(7)
        if self._steps < 3:
            return Decision("turn_left")
        return Decision("stop" if observation.collecting else "hand_off")
