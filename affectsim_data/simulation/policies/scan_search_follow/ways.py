"""Going along ways over the own map, and learning from moves that were cut short."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import STEP_M, Action
from affectsim_data.simulation.policies.driving import drive_along
from affectsim_data.simulation.policies.scan_search_follow.mapping import PERSON_M, OccupancyMap

__all__ = ["Walk"]

_ARRIVED_M = 0.25
"""A place is as good as a goal from which it is no farther."""
_PLANS_A_GOAL, _BUMPS_A_GOAL = 6, 3
_RETURNS_A_GOAL = 2
_SPARE_STEPS, _STEPS_A_MOVE = 30, 3.0
"""A goal that takes more ways, bumps or steps than that is given up: the robot is stuck."""
_SAME_M = 0.1
_NEAR_M, _BESIDE_M = 0.2, 0.15
"""A corner is passed this near to it, or this near to the way that leads on from it."""
_ROOMS_M = (0.38, 0.32, 0.25)
"""The room a move has to end with, less where there is no other; of walls it may go away."""
_LOOKED_AHEAD_M = 1.5
"""A way is planned anew when something comes in it this near."""
_BUMP_M, _BUMP_HALF_M, _BUMP_REACH_M = 0.25, 0.12, 0.2
"""What cut a move short lies so far ahead of where the robot's middle ended, this far to both
sides."""


class Walk:
    """Going to places on the own map, step by step, and learning from moves that were cut short."""

    def __init__(self, plan: OccupancyMap) -> None:
        self._plan = plan
        self._path: FloatArray | None = None
        self._goal: FloatArray | None = None
        self._bumps: list[FloatArray] = []
        self._plans = 0
        self._steps_left = 0
        self._bumps_left = 0
        self._passed: list[FloatArray] = []
        self._returns = 0
        self.planner_calls = 0
        """Ways planned so far."""

    def note(self, here: FloatArray, yaw: float, clipped: bool) -> None:
        """Takes in how the last move went; before anything else in a step."""
        if clipped:
            ahead = np.array([-math.sin(yaw), -math.cos(yaw)])
            right = np.array([math.cos(yaw), -math.sin(yaw)])
            sides = _BUMP_HALF_M * np.array([[-1.0], [0.0], [1.0]]) * right
            self._plan.block(here + _BUMP_M * ahead + sides)
            self._bumps.append(here + _BUMP_M * ahead)
            self._bumps_left -= 1
            self._path = None

    def forget_bumps(self) -> bool:
        """Forgets what cut moves short, on the map too; whether there was anything to forget."""
        had_any = bool(self._bumps)
        self._bumps.clear()
        self._path = None
        self._plan.forget_blocks()
        return had_any

    def action(
        self, here: FloatArray, yaw: float, goal: FloatArray, *, within_m: float = _ARRIVED_M
    ) -> Action | None:
        """The next action on the way to a goal, `None` if there is none: arrived, or no way."""
        if math.dist(here, goal) <= within_m:
            return None
        if self._goal is None or not np.array_equal(goal, self._goal):
            self._goal, self._path = goal, None
            self._plans, self._steps_left, self._bumps_left = 0, 1, _BUMPS_A_GOAL
            self._passed, self._returns = [], 0
        if self._turns_back(here):
            return None
        self._steps_left -= 1
        for _ in range(2):
            is_cut = self._path is None or self._is_cut(here, self._path)
            if is_cut and not self._find(here, goal):
                return None
            assert self._path is not None
            self._path = _ahead(here, self._path)
            for room_m in _ROOMS_M:
                is_free = functools.partial(self._is_free, room_m)
                action = drive_along(here, yaw, self._path, is_free=is_free)
                if action is not None:
                    return action if self._steps_left > 0 else None
            self._path = None
        return None

    def _turns_back(self, here: FloatArray) -> bool:
        """Whether the robot goes to and fro between the same places."""
        if not self._passed or math.dist(here, self._passed[-1]) > _SAME_M:
            self._returns += any(math.dist(here, one) <= _SAME_M for one in self._passed)
            self._passed.append(here)
        return self._returns > _RETURNS_A_GOAL

    def _find(self, here: FloatArray, goal: FloatArray) -> bool:
        """Plans the way; whether there is one, after not too many others to the same goal."""
        self._path = None
        if self._plans >= _PLANS_A_GOAL or self._bumps_left <= 0:
            return False
        self._plans += 1
        self.planner_calls += 1
        self._path = self._plan.path(here, goal)
        if self._path is None:
            return False
        if self._plans == 1:
            length_m = float(np.hypot(*np.diff(self._path, axis=0).T).sum())
            self._steps_left = _SPARE_STEPS + round(_STEPS_A_MOVE * length_m / STEP_M)
        return True

    def _is_free(self, room_m: float, start: FloatArray, end: FloatArray) -> bool:
        """Whether a move ends with so much room, or no less than before."""
        near = [(bump, _BUMP_REACH_M) for bump in self._bumps]
        near += [(person, PERSON_M) for person in self._plan.people_xz]
        for place, reach_m in near:
            if math.dist(end, place) < min(reach_m, math.dist(start, place) - 0.02):
                return False
        points = np.stack([start, 0.5 * (start + end), end])
        cells = self._plan.cells(points)
        possible = np.isfinite(self._plan.costs()[cells[:, 0], cells[:, 1]])
        # From where nobody could stand the robot may go to where it can.
        if not possible[2] or possible[0] > possible[1]:
            return False
        before_m, half_m, after_m = self._plan.room(points)
        return bool(min(half_m, after_m) >= min(room_m, before_m))

    def _is_cut(self, here: FloatArray, path: FloatArray) -> bool:
        """Whether nobody can go the next part of a way any more."""
        corners = np.concatenate([here[None], path])
        pieces = [
            start
            + np.linspace(0.0, 1.0, 2 + int(math.dist(start, end) / 0.1))[1:, None] * (end - start)
            for start, end in itertools.pairwise(corners)
        ]
        points = np.concatenate(pieces)
        points = points[np.hypot(*(points - here).T) < _LOOKED_AHEAD_M]
        cells = self._plan.cells(points)
        return bool(np.isinf(self._plan.costs()[cells[:, 0], cells[:, 1]]).any())


def _ahead(here: FloatArray, path: FloatArray) -> FloatArray:
    """The corners of a way that still lie ahead."""
    while len(path) > 1:
        to_next = path[1] - path[0]
        share = float((here - path[0]) @ to_next) / max(float(to_next @ to_next), 1e-9)
        beside_m = np.hypot(*(here - path[0] - min(share, 1.0) * to_next))
        passed = share > 0.0 and beside_m < _BESIDE_M
        if not passed and np.hypot(*(path[0] - here)) >= _NEAR_M:
            break
        path = path[1:]
    return path
