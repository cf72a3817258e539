"""What a script of a performance by one person says: curves, places of hands, steps, taps.

Everything is written for the preferred hand: `hand` is the preferred arm and the leg of its side,
`other` the opposite ones; turns and ways are positive towards the preferred side. Times are
seconds of the unhurried performance at full intensity.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Literal

from affectsim_data.builders.performances.arms import Place, Vector

__all__ = [
    "ARMS",
    "Arm",
    "ArmKey",
    "Channel",
    "FootStep",
    "Key",
    "Script",
    "Tap",
    "beats",
    "shaken",
]

Arm = Literal["hand", "other"]
ARMS: tuple[Arm, Arm] = ("hand", "other")
Channel = Literal[
    "trunk_pitch",
    "trunk_yaw",
    "trunk_roll",
    "head_pitch",
    "head_yaw",
    "head_roll",
    "shrug",
    "heels",
    "kick_hand",
    "kick_other",
    "forward",
    "aside",
    "rise",
    "seated",
]
"""Degrees; metres for `forward`, `aside` and `rise` of the pelvis; a share for `seated` (0 stands,
1 sits) and for kicks (1 is a leg swung out). Pitch is forward and down."""
Key = tuple[float, float]
ArmKey = tuple[float, Place]


@dataclasses.dataclass(frozen=True)
class Tap:
    """A foot that taps or shakes."""

    foot: Arm
    hz: float
    degrees: float
    """Positive lifts the heel, negative the toes."""
    start_s: float
    end_s: float


@dataclasses.dataclass(frozen=True)
class FootStep:
    """A foot put elsewhere, metres from where it stands at the start."""

    foot: Arm
    start_s: float
    end_s: float
    out: float = 0.0
    forward: float = 0.0
    lift_m: float = 0.05


@dataclasses.dataclass(frozen=True)
class Script:
    """One way to perform one thing in one emotion."""

    length_s: float
    arms: Mapping[Arm, Sequence[ArmKey]]
    """Where each wrist is when; both arms are given."""
    channels: Mapping[Channel, Sequence[Key]]
    """Curves through keys; what is not given is 0."""
    feet: Mapping[Arm, Vector] = dataclasses.field(default_factory=dict)
    """Where a foot stands instead: ankle out and forward of its usual place, metres; heel lifted,
    degrees."""
    steps: Sequence[FootStep] = ()
    taps: Sequence[Tap] = ()
    glances_deg: float = 0.0
    """How far the head turns when the eyes wander; anxious eyes never rest."""
    hz: float = 0.0
    """How promptly the body follows; 0 as the emotion has it."""


def beats(start_s: float, count: int, every_s: float, *values: float) -> list[Key]:
    """Keys that go through `values` over and over, `count` times, each time for `every_s`.

    Examples:
        >>> beats(1.0, 2, 0.5, 0.0, 3.0)
        [(1.0, 0.0), (1.25, 3.0), (1.5, 0.0), (1.75, 3.0)]
    """
    step = every_s / len(values)
    every = [value for _ in range(count) for value in values]
    return [(round(start_s + index * step, 6), value) for index, value in enumerate(every)]


def shaken(start_s: float, count: int, every_s: float, *places: Place) -> list[ArmKey]:
    """Keys of a wrist that goes through `places` over and over, as `beats` does."""
    step = every_s / len(places)
    every = [place for _ in range(count) for place in places]
    return [(round(start_s + index * step, 6), place) for index, place in enumerate(every)]
