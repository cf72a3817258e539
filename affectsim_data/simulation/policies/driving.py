"""Driving: along a polyline and towards a bearing, in turns of 15 degrees and moves of 0.25 m.

Everything is on the plan, in any frame in which yaw 0 looks along -Z: that of the world, or the
robot's own starting frame, as observations have it. Nothing is remembered between calls, and still
nothing swings to and fro: a turn has to be worth more than it costs, and turning makes what it
aims at cheaper.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import STEP_M, TURN, Action

__all__ = ["IsFree", "bearing", "drive_along", "turn_towards"]

IsFree = Callable[[FloatArray, FloatArray], bool]
"""Whether the robot can go straight from one place to another, `(2,)` each: x and z."""

_TOLERANCE = math.radians(10.0)
"""More than half a turn, or the robot would swing about a bearing between two headings."""
_TURN_COST_M = 0.002
"""What a turn has to gain with the next move; a straight way is kept to within 9.3 degrees."""
_LEAST_GAIN_M = 0.05
"""A move that brings the robot less near the end is not made; on the way, past a wall, one may
even cost this."""
_PASSED_M = 0.3
"""A corner this near counts as passed: more than a move, so that it is not circled."""


def bearing(place: ArrayLike, goal: ArrayLike) -> float:
    """Yaw of a robot at a place that looks at a goal, `(2,)` each: x and z; in [-pi, pi].

    Examples:
        >>> bearing((0.0, 0.0), (0.0, -1.0)) == 0.0
        True
        >>> round(math.degrees(bearing((0.0, 0.0), (-1.0, 0.0))))
        90
    """
    dx, dz = np.subtract(goal, place).tolist()
    return math.atan2(-dx, -dz)


def turn_towards(yaw: float, wanted: float, *, tolerance: float = _TOLERANCE) -> Action | None:
    """The turn that brings a yaw nearer to the wanted one, `None` if it is within the tolerance.

    Args:
        yaw: Of the robot, radians.
        wanted: Where it should look.
        tolerance: Radians, more than half a turn: what it is over that, the wanted yaw may
            sway either way before the robot turns back.

    Raises:
        ValueError: A tolerance with which the robot would swing to and fro for ever.
    """
    if not tolerance >= TURN / 2.0:
        raise ValueError(f"tolerance must be at least {TURN / 2.0:.3f}, got {tolerance}")
    off = math.remainder(wanted - yaw, 2.0 * math.pi)
    if abs(off) <= tolerance + 1e-9:
        return None
    return "turn_left" if off > 0.0 else "turn_right"


def drive_along(
    place: ArrayLike, yaw: float, polyline: ArrayLike, *, is_free: IsFree | None = None
) -> Action | None:
    """The next action along a polyline, `None` at its end or where no move leads on.

    Of the 24 headings a robot can turn to, it takes the one whose move ends nearest to the next
    corner, less a little for every turn; moves that are not free are left out. So a robot beside a
    wall goes along it, and at a corner goes round it.

    Args:
        place: Of the robot, `(2,)`: x and z.
        yaw: Of the robot, radians.
        polyline: Corners of the way, `(n, 2)`, at least its end. What lies behind the place of it
            that is nearest to the robot does not matter; so a way that turns back on itself, as no
            shortest way does, may be cut short or gone to and fro.
        is_free: Whether a move can be made; all can if not given.
    """
    here = np.asarray(place, np.float64)
    corner, is_end = _next_corner(here, np.asarray(polyline, np.float64).reshape(-1, 2))
    turns = np.arange(-11, 13)
    yaws = yaw + turns * TURN
    ends = here - STEP_M * np.stack([np.sin(yaws), np.cos(yaws)], axis=1)  # (24, 2)
    gain = np.hypot(*(corner - here)) - np.hypot(*(corner - ends).T)
    least = _LEAST_GAIN_M if is_end else -_LEAST_GAIN_M
    worth = np.where(gain >= least, gain - _TURN_COST_M * np.abs(turns), -np.inf)
    # Of two as good, the one to the left; rounding must not choose.
    order = np.lexsort((-turns, -np.round(worth, 9)))
    for one in order[np.isfinite(worth[order])]:
        if is_free is None or is_free(here, ends[one]):
            turn = int(turns[one])
            return "move_forward" if turn == 0 else "turn_left" if turn > 0 else "turn_right"
    return None


def _next_corner(here: FloatArray, corners: FloatArray) -> tuple[FloatArray, bool]:
    """The first corner that is not passed yet, or the end; and whether nothing is ahead of it."""
    left = corners[_num_behind(here, corners) :]
    ahead = np.flatnonzero(np.hypot(*(left - here).T) > _PASSED_M)
    return (left[ahead[0]], False) if len(ahead) else (corners[-1], True)


def _num_behind(here: FloatArray, corners: FloatArray) -> int:
    """Corners before the place of the polyline that is nearest; of two as near, the later."""
    if len(corners) == 1:
        return 0
    way = np.diff(corners, axis=0)
    length2 = np.maximum((way**2).sum(axis=1), 1e-12)
    share = np.clip(((here - corners[:-1]) * way).sum(axis=1) / length2, 0.0, 1.0)
    off = np.hypot(*(here - corners[:-1] - share[:, None] * way).T)
    piece = int(np.flatnonzero(off <= off.min() + 1e-6)[-1])
    return piece + int(share[piece] > 0.0)
