"""Scan, search, follow: the baseline; it finds a person on RGB-D alone and goes to a good view."""

from __future__ import annotations

from affectsim_data.cameras import Camera
from affectsim_data.simulation.actions import Action
from affectsim_data.simulation.policies.protocol import Decision
from affectsim_data.simulation.policies.scan_search_follow.approaching import Approach
from affectsim_data.simulation.policies.scan_search_follow.following import follow
from affectsim_data.simulation.policies.scan_search_follow.searching import Search
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses
from affectsim_data.simulation.policies.scan_search_follow.ways import Walk
from affectsim_data.simulation.running import Observation

__all__ = ["ScanSearchFollow"]

_STILL_M_PER_S, _STILL_STEPS = 0.3, 3
"""While the clip is collected, somebody slower than this is looked at once in so many steps where
there is no need to turn."""


class ScanSearchFollow:
    """Looks around, searches where the map ends, goes to a good view, hands off, and follows."""

    name = "scan_search_follow"

    def reset(self, camera: Camera, *, seed: int) -> None:
        """A new episode; nothing is random, so the seed does not matter."""
        self._senses = Senses()
        self._walk = Walk(self._senses.plan)
        self._search = Search(self._senses, self._walk, hfov=camera.hfov)
        self._approach: Approach | None = None
        self._calls = 0
        self._past_calls = 0

    def act(self, observation: Observation) -> Decision:
        """The next action."""
        senses = self._senses
        senses.take_in(observation)
        if observation.collecting:
            action = follow(senses)
            still = senses.is_seen and senses.track.speed < _STILL_M_PER_S
            rests = still and action == "stop"
            return Decision(action, approaching=True, num_steps=_STILL_STEPS if rests else 1)
        self._walk.note(senses.here, senses.yaw, observation.clipped)
        if self._approach is None and senses.is_found:
            self._approach = Approach(senses, self._walk)
        action = self._approached() or self._search.action()
        approaching = self._approach is not None
        calls, self._calls = self._calls, self._counted()
        return Decision(action, self._calls - calls, approaching)

    def _approached(self) -> Action | None:
        """The next action towards a view of the person, `None` if there is none."""
        if self._approach is None:
            return None
        action = self._approach.action()
        if action is None:
            self._past_calls += self._approach.planner_calls
            self._approach = None
            self._senses.forget_person()
            self._search.restart()
        return action

    def _counted(self) -> int:
        """Planner calls of the episode."""
        now = 0 if self._approach is None else self._approach.planner_calls
        return self._past_calls + now + self._walk.planner_calls + self._search.planner_calls
