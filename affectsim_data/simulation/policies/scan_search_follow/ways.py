"""Ways over the own map: wide berths where there is room, narrow and daring ones where not."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import STEP_M, Action
from affectsim_data.simulation.policies.driving import drive_along
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap

__all__ = ["Walk", "find_path", "way_lengths"]

_MANNERS = (
    (0.45, False, 0.0),
    (0.38, False, 1.5),
    (0.42, True, 2.0),
    (0.3, False, 4.0),
    (0.34, True, 5.0),
)
"""Room asked for in metres, whether over floor not yet seen, and metres of way that it costs more.
The robot's radius is 0.3 m; the map is some 0.05 m off."""
_ARRIVED_M = 0.25
_PLANS_A_GOAL, _BUMPS_A_GOAL = 5, 3
_RETURNS_A_GOAL = 2
_SPARE_STEPS, _STEPS_A_MOVE = 30, 3.0
"""A goal that takes more ways, bumps or steps than that is given up: the robot is stuck."""
_SPARE_M = 0.05
"""A move may end that much nearer to things than the way was planned for."""
_SAME_M = 0.1
_NEAR_M, _BESIDE_M = 0.2, 0.15
"""A corner is passed this near to it, or this near to the way that leads on from it."""
_LEAST_M = 0.2
"""The room a move has to have where there is no other."""
_BUMP_M, _BUMP_REACH_M = 0.2, 0.2
"""What cut a move short lies so far ahead of where the robot's middle ended."""


def way_lengths(plan: OccupancyMap, here: FloatArray) -> FloatArray:
    """Metres of way from a place `(2,)` to every cell, more where it is narrow; `inf` for none."""
    lengths = np.full(plan.shape, np.inf)
    for radius, daring, extra in _MANNERS:
        found = plan.distances_from(here, radius, daring=daring) + extra
        np.minimum(lengths, found, out=lengths)
    return lengths


def find_path(
    plan: OccupancyMap, here: FloatArray, goal: FloatArray
) -> tuple[FloatArray, float] | None:
    """The way to a goal that `way_lengths` measured, `(n, 2)`, and the room it has, metres."""
    row, column = plan.cells(goal)
    costs = [
        float(plan.distances_from(here, radius, daring=daring)[row, column]) + extra
        for radius, daring, extra in _MANNERS
    ]
    radius, daring, _ = _MANNERS[int(np.argmin(costs))]
    path = plan.path(here, goal, radius, daring=daring) if np.isfinite(min(costs)) else None
    return None if path is None else (path, radius)


class Walk:
    """Going to places on the own map, step by step, and learning from moves that were cut short."""

    def __init__(self, plan: OccupancyMap) -> None:
        self._plan = plan
        self._path: FloatArray | None = None
        self._goal: FloatArray | None = None
        self._bumps: list[FloatArray] = []
        self._room_m = _MANNERS[0][0]
        self._cuts = 0
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
            bump = here + _BUMP_M * np.array([-math.sin(yaw), -math.cos(yaw)])
            self._plan.block(bump)
            self._bumps.append(bump)
            self._bumps_left -= 1
            self._path = None

    def arrived(self, here: FloatArray, goal: FloatArray) -> bool:
        """Whether a place is as good as the goal."""
        return float(np.hypot(*(goal - here))) <= _ARRIVED_M

    def action(self, here: FloatArray, yaw: float, goal: FloatArray) -> Action | None:
        """The next action on the way to a goal, `None` if there is none: arrived, or no way."""
        if self.arrived(here, goal):
            return None
        if self._goal is None or not np.array_equal(goal, self._goal):
            self._goal, self._path = goal, None
            self._plans, self._steps_left, self._bumps_left = 0, 1, _BUMPS_A_GOAL
            self._passed, self._returns = [], 0
        if self._turns_back(here):
            return None
        self._steps_left -= 1
        for _ in range(2):
            is_cut = self._path is None or self._num_cuts(here, self._path) > self._cuts + 1
            if is_cut and not self._find(here, goal):
                return None
            assert self._path is not None
            self._path = _ahead(here, self._path)
            for room_m in (self._room_m - _SPARE_M, _LEAST_M):
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
        found = find_path(self._plan, here, goal)
        if found is None:
            return False
        self._path, self._room_m = found
        self._cuts = self._num_cuts(here, self._path)
        if self._plans == 1:
            length_m = float(np.hypot(*np.diff(self._path, axis=0).T).sum())
            self._steps_left = _SPARE_STEPS + round(_STEPS_A_MOVE * length_m / STEP_M)
        return True

    def _is_free(self, room_m: float, start: FloatArray, end: FloatArray) -> bool:
        """Whether a move ends with so much room, or no less than before."""
        for bump in self._bumps:
            if np.hypot(*(end - bump)) < min(
                _BUMP_REACH_M, float(np.hypot(*(start - bump))) - 0.02
            ):
                return False
        around = room_m * _CIRCLE
        return bool(self._hits(end + around) <= self._hits(start + around))

    def _hits(self, points: FloatArray) -> int:
        return int(self._plan.occupied(points).sum())

    def _num_cuts(self, here: FloatArray, path: FloatArray) -> int:
        """Points of a way, 0.1 m apart, that something stands on."""
        corners = np.concatenate([here[None], path])
        pieces = [
            start
            + np.linspace(0.0, 1.0, 2 + int(math.dist(start, end) / 0.1))[1:, None] * (end - start)
            for start, end in itertools.pairwise(corners)
        ]
        return self._hits(np.concatenate(pieces))


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


_CIRCLE = np.stack(
    [np.sin(2.0 * np.pi * np.arange(12) / 12), np.cos(2.0 * np.pi * np.arange(12) / 12)], axis=1
)
