"""Where an action takes the robot: along the navmesh, and not into people."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import PERSON_CLEARANCE_M, STEP_M, TURN, Action

__all__ = ["RobotState", "after", "wrapped_angle"]

_SLACK2_M2 = 1e-5
"""habitat-sim's rule for a collision, as in `navmesh.moves`."""
_TOUCHING_M2 = 1e-9
"""Way times distance by which a move past somebody may come nearer: less than rounding shows."""


@dataclasses.dataclass(frozen=True)
class RobotState:
    """Where the robot is."""

    position: tuple[float, float, float]
    """On the floor, metres."""
    yaw: float
    """Radians: 0 looks along -Z, counter-clockwise from above; in (-pi, pi]."""
    clipped: bool = False
    """Whether the move that led here was cut short."""


def after(state: RobotState, action: Action, navmesh: NavMesh, people: FloatArray) -> RobotState:
    """The robot after an action; whether it was cut short is said of moves alone.

    A move goes straight on and ends at the first wall, or where it comes within 0.5 m of anybody.
    Nobody pushes the robot: where a person has come nearer than that, it may still go away.

    Args:
        state: Before it.
        action: Only moves and turns change where the robot is.
        navmesh: Where it can go; it does not slide along walls.
        people: Pelvis of each participant at the end of the action, `(n, 3)`.
    """
    if action == "turn_left" or action == "turn_right":
        turned = state.yaw + (TURN if action == "turn_left" else -TURN)
        return RobotState(state.position, wrapped_angle(turned))
    if action != "move_forward":
        return RobotState(state.position, state.yaw)
    start = np.array(state.position)
    ahead = np.array([-math.sin(state.yaw), 0.0, -math.cos(state.yaw)])
    share = _free_share(start[[0, 2]], STEP_M * ahead[[0, 2]], people[:, [0, 2]])
    if share == 0.0:
        # Not asked of the navmesh, which would snap the robot to itself.
        return RobotState(state.position, state.yaw, clipped=True)
    reached = navmesh.step(start, start + share * STEP_M * ahead)
    moved2 = float(((reached.position - start)[[0, 2]] ** 2).sum())
    x, y, z = (float(value) for value in reached.position)
    return RobotState((x, y, z), state.yaw, moved2 + _SLACK2_M2 < STEP_M**2)


def _free_share(start: FloatArray, move: FloatArray, people: FloatArray) -> float:
    """Part of a straight move, in [0, 1], before it comes too near to anybody; all on the plan.

    Who is too near already may still go away from them.
    """
    if not len(people):
        return 1.0
    away = start - people  # (n, 2)
    a = float(move @ move)
    b = away @ move
    c = (away**2).sum(axis=1) - PERSON_CLEARANCE_M**2
    reach = b**2 - a * c
    enters = (-b - np.sqrt(np.maximum(reach, 0.0))) / a
    nearing = b < -_TOUCHING_M2
    share = np.where((c > 0) & (reach > 0) & nearing, np.clip(enters, 0.0, 1.0), 1.0)
    share = np.where((c <= 0) & nearing, 0.0, share)
    return float(share.min())


def wrapped_angle(angle: float) -> float:
    """The same angle in (-pi, pi].

    Examples:
        >>> wrapped_angle(-math.pi) == math.pi
        True
    """
    return math.pi - (math.pi - angle) % (2 * math.pi)
