"""What a robot can do in a step, how long that takes, and how often it may."""

from __future__ import annotations

import dataclasses
import math
from typing import Literal, get_args

__all__ = [
    "ACTIONS",
    "ACTION_RATE_HZ",
    "PERSON_CLEARANCE_M",
    "STEP_M",
    "TURN",
    "Action",
    "Budget",
]

Action = Literal["move_forward", "turn_left", "turn_right", "hand_off", "stop"]
ACTIONS: tuple[Action, ...] = get_args(Action)
"""In the order of their numbers in the environment."""
ACTION_RATE_HZ = 4.0
"""Actions a second (paper, "Execution settings"); the person keeps moving meanwhile."""
STEP_M = 0.25
"""Length of a move forward (paper, "Execution settings")."""
TURN = math.radians(15.0)
"""Angle of a turn (paper, "Execution settings")."""
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
