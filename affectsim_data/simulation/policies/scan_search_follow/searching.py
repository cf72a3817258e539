"""Looking for a person: look around, go to a border of what the map knows, look around again."""

from __future__ import annotations

import math

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import TURN, Action
from affectsim_data.simulation.policies.scan_search_follow.approaching import look_at, watch
from affectsim_data.simulation.policies.scan_search_follow.exploring import best_frontier
from affectsim_data.simulation.policies.scan_search_follow.senses import Senses
from affectsim_data.simulation.policies.scan_search_follow.viewing import best_view
from affectsim_data.simulation.policies.scan_search_follow.ways import Walk

__all__ = ["Search"]

_HEADINGS = round(2.0 * math.pi / TURN)
_DOUBTED = 0.58
"""Confidence from which somebody may be a person."""
_DOUBT_LOOKS = 10
"""Looks at somebody who may be a person, before the search goes on."""
_FAR_M = 3.0
_SAME_M = 0.8
"""So near to where nobody was it is not looked at again, unless beyond doubt."""


class Search:
    """Looks for a person."""

    def __init__(self, senses: Senses, walk: Walk, *, hfov: float) -> None:
        self._senses, self._walk = senses, walk
        self._seen_half = round(hfov / 2.0 / TURN)
        self._turns_left = _HEADINGS - 2 * self._seen_half
        self._goal: FloatArray | None = None
        self._is_frontier = False
        self._suspects: list[FloatArray] = []
        self._avoid: list[FloatArray] = []
        self._visited: list[FloatArray] = []
        self._doubts = 0
        self._nobody: list[FloatArray] = []
        self.planner_calls = 0
        """Goals chosen so far."""

    def restart(self) -> None:
        """Looks all around again: the person was here."""
        self._goal = None
        self._look_around()

    def action(self) -> Action:
        """The next action."""
        doubt = self._doubt()
        if doubt is not None:
            return doubt
        senses = self._senses
        for _ in range(2):
            turn = self._turn()
            if turn is not None:
                return turn
            if self._goal is None or (self._is_frontier and not self._is_open(self._goal)):
                self._goal = self._next_goal()
            if self._goal is None:
                self._look_around()
                continue
            action = self._walk.action(senses.here, senses.yaw, self._goal)
            if action is None and self._is_frontier:
                action = self._faced(self._goal)
            if action is not None:
                return action
            self._avoid.append(self._goal)
            self._goal = None
        return "turn_left"

    def _faced(self, goal: FloatArray) -> Action | None:
        """The turn towards what is unseen about a frontier, `None` if it is looked at."""
        senses = self._senses
        around = goal + 2.0 * _AROUND
        unseen = around[senses.plan.unseen(around)]
        return look_at(senses, unseen.mean(axis=0)) if len(unseen) else None

    def _doubt(self) -> Action | None:
        """Looks once more at somebody who may be a person."""
        senses = self._senses
        place = senses.track.place_xz
        if (
            place is None
            or senses.unseen_s > 0.5
            or senses.track.confidence < _DOUBTED
            or any(np.hypot(*(place - one)) < _SAME_M for one in self._nobody)
        ):
            return None
        self._doubts += 1
        if self._doubts > _DOUBT_LOOKS:
            self._doubts = 0
            self._go_and_see(place)
            return None
        return watch(senses, place)

    def _go_and_see(self, place: FloatArray) -> None:
        """Makes somebody far away who may be a person the next goal, once; else it was nobody."""
        senses = self._senses
        far = math.dist(place, senses.here) > _FAR_M
        if not far or any(math.dist(place, one) < _SAME_M for one in self._suspects):
            self._nobody.append(place)
            return
        self._suspects.append(place)
        self.planner_calls += 1
        found = best_view(senses.plan, senses.here, senses.course, [], senses.partner_xz)
        self._goal = found.place_xz
        self._is_frontier = False
        self._turns_left = 0

    def _is_open(self, goal: FloatArray) -> bool:
        """Whether there still is something unseen at a frontier."""
        return bool(self._senses.plan.unseen(goal + _AROUND).any())

    def _look_around(self) -> None:
        self._turns_left = _HEADINGS - 2 * self._seen_half
        self._visited.append(self._senses.here)

    def _turn(self) -> Action | None:
        """The next turn of looking around, `None` if every direction has been seen."""
        if self._turns_left <= 0:
            return None
        self._turns_left -= 1
        return "turn_left"

    def _next_goal(self) -> FloatArray | None:
        senses = self._senses
        self.planner_calls += 1
        goal = best_frontier(senses.plan, senses.here, senses.yaw, self._avoid)
        self._is_frontier = goal is not None
        if goal is None:
            goal = self._least_visited()
            self._avoid.clear()
            if goal is None:
                self._walk.forget_bumps()
        return goal

    def _least_visited(self) -> FloatArray | None:
        """The reachable place farthest from all those looked around at."""
        senses = self._senses
        way = senses.plan.distances_from(senses.here)
        cells = np.argwhere(np.isfinite(way))[::7]
        if not len(cells) or not self._visited:
            return None
        places = senses.plan.points(cells)
        nearest = np.min([np.hypot(*(places - one).T) for one in self._visited], axis=0)
        best = int(np.argmax(np.round(nearest, 6)))
        return places[best] if nearest[best] > 1.0 else None


_AROUND = np.stack(
    [
        radius * np.array([math.sin(angle), math.cos(angle)])
        for radius in (0.1, 0.2, 0.3)
        for angle in np.arange(12) * math.pi / 6.0
    ]
)
