"""What a robot can do in a step, how long that takes, and how often it may."""

from __future__ import annotations

import dataclasses
from typing import TypeAlias

from affectsim_data.episodes import ACTION_RATE_HZ, STEP_M, TURN
from affectsim_data.schemas import ROBOT_ACTIONS, RobotAction

__all__ = [
    "ACTIONS",
    "ACTION_RATE_HZ",
    "PERSON_CLEARANCE_M",
    "STEP_M",
    "TURN",
    "Action",
    "Budget",
]

Action: TypeAlias = RobotAction
ACTIONS: tuple[Action, ...] = ROBOT_ACTIONS
"""In the order of their numbers in the environment."""
PERSON_CLEARANCE_M = 0.5
"""A move is cut short this far from the pelvis of a participant, on the plan."""


@dataclasses.dataclass(frozen=True)
class Budget:
    """What a search may cost before it has to hand off (paper, "Execution settings")."""

    max_actions: int = 480
    """Primitive actions before the handoff; those of collecting a clip after it are free."""
    max_planner_calls: int = 80
    """Calls of a policy's planner."""

    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if not isinstance(value, int) or value < 1:
                raise ValueError(f"{field.name} must be a whole number from 1, got {value!r}")
