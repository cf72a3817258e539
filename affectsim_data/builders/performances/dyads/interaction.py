"""How two scripts make one interaction: where people stand, whom they look at, where they touch."""

from __future__ import annotations

import dataclasses
from typing import Literal

from affectsim_data.builders.performances.scenarios.vocabulary import Arm, Script, Vector
from affectsim_data.motions.motion import Emotion

__all__ = ["Clasp", "Interaction", "Look", "Role", "Share", "Spot", "Touch"]

Share = tuple[tuple[float, float], ...]
"""`(seconds, share)`: how far something holds over the cycle, 0 to 1."""


@dataclasses.dataclass(frozen=True)
class Spot:
    """A place in the air, from the floor under the target's start."""

    side: float
    """Towards the target's preferred side, metres."""
    up: float
    forward: float


@dataclasses.dataclass(frozen=True)
class Look:
    """Turns the face to something for a while; nods and shakes of the head go on."""

    share: Share
    at: Literal["partner", "hand", "other"] | Spot = "partner"
    """The other person's face, that person's preferred or other hand, or a spot."""


@dataclasses.dataclass(frozen=True)
class Role:
    """What one of two people does."""

    script: Script
    looks: tuple[Look, ...] = ()
    """Their shares add up to at most 1 at any time; the rest follows the script."""


@dataclasses.dataclass(frozen=True)
class Clasp:
    """Palm on palm."""

    target_arm: Arm
    partner_arm: Arm
    way: tuple[tuple[float, Spot], ...]
    """Where the palms meet, over time."""
    share: Share


@dataclasses.dataclass(frozen=True)
class Touch:
    """A palm on another person's body, with which it moves."""

    by: Literal["target", "partner"]
    arm: Arm
    """Of who touches."""
    limb: Literal["collar", "shoulder", "elbow"]
    """Joint of who is touched: collar bone, upper arm, forearm."""
    of: Arm
    """Which side of who is touched."""
    place: Vector
    """`(out, up, forward)` in the joint as in the T-pose, out along the limb, metres."""
    share: Share


@dataclasses.dataclass(frozen=True)
class Interaction:
    """Two roles on one time line."""

    name: str
    partner_emotion: Emotion
    target: Role
    partner: Role
    forward_m: float
    """Where the partner stands, from the target."""
    side_m: float = 0.0
    """The same to the target's preferred side."""
    facing_deg: float = 180.0
    """Which way the partner looks; 180 back at the target, turning to the preferred side."""
    hands: Literal["own", "same", "mirrored", "right"] = "own"
    """Which hand each prefers: the own; the partner the target's or the one opposite; the right."""
    clasps: tuple[Clasp, ...] = ()
    touches: tuple[Touch, ...] = ()
