"""Borders of what the map knows, and what it is worth to go and look beyond them."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.driving import bearing
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap

__all__ = ["best_frontier", "nearest_frontier"]

_SIZE_WORTH = 1.5
"""Metres of way that a metre of border is worth."""
_SMALLEST_M, _LARGEST_M = 0.5, 2.0
"""A longer border promises no more: a doorway leads to as much as a wide passage."""
_TURN_WORTH_M = 2.0
"""Metres of way that turning round costs."""
_AVOID_M = 0.5


def best_frontier(
    plan: OccupancyMap, here: FloatArray, yaw: float, avoid: list[FloatArray]
) -> FloatArray | None:
    """A place at the border of the known from which to look beyond it, `(2,)`.

    Args:
        plan: What is known of the home.
        here: Where the robot is, `(2,)`.
        yaw: Where it looks.
        avoid: Goals that were reached to no avail, or could not be, `(2,)` each.

    Returns:
        The goal, `None` if no border can be reached.
    """
    found = list(_reachable(plan, here, avoid))
    worths = []
    for goal, way_m, size_m in found:
        turn = abs(math.remainder(bearing(here, goal) - yaw, 2.0 * math.pi)) / math.pi
        worths.append(_SIZE_WORTH * min(size_m, _LARGEST_M) - way_m - _TURN_WORTH_M * turn)
    return found[int(np.argmax(worths))][0] if found else None


def nearest_frontier(
    plan: OccupancyMap, here: FloatArray, place_xz: FloatArray, avoid: list[FloatArray]
) -> FloatArray | None:
    """A place at the border of the known on the way to a place that no way leads to yet, `(2,)`.

    Args:
        plan: What is known of the home.
        here: Where the robot is, `(2,)`.
        place_xz: What it wants to come near to, `(2,)`.
        avoid: As of `best_frontier`.

    Returns:
        The goal, `None` if no border can be reached.
    """
    found = list(_reachable(plan, here, avoid))
    costs = [way_m + math.dist(goal, place_xz) for goal, way_m, _ in found]
    return found[int(np.argmin(costs))][0] if found else None


def _reachable(
    plan: OccupancyMap, here: FloatArray, avoid: list[FloatArray]
) -> Iterator[tuple[FloatArray, float, float]]:
    """Of every border that can be reached: its nearest place, the way there, and its length."""
    way = plan.distances_from(here)
    for frontier in plan.frontiers():
        reach = way[frontier.cells[:, 0], frontier.cells[:, 1]]
        places = plan.points(frontier.cells)
        for one in avoid:
            reach = np.where(np.hypot(*(places - one).T) < _AVOID_M, np.inf, reach)
        if frontier.size >= _SMALLEST_M and np.isfinite(reach).any():
            nearest = int(np.argmin(reach))
            yield places[nearest], float(reach[nearest]), frontier.size
