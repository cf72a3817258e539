"""What standing performances are made of: arm poses on landmarks of the body, steps, shakes.

Everything is written for the preferred hand: `hand` is the preferred one, turns and ways are
positive towards its side. Times are seconds of the full, unhurried performance. How a script is
put on a body, a performer and an intensity is in `staging`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

__all__ = [
    "AKIMBO",
    "ARMS",
    "BELLY",
    "BOTH_ON_FACE",
    "BROW",
    "CLASPED",
    "CROWN",
    "FACE",
    "FIST_HIGH",
    "FOLDED_OVER",
    "FOLDED_UNDER",
    "GUARD",
    "HANGING",
    "HEART",
    "HUG_OVER",
    "HUG_UNDER",
    "KNEE",
    "MOUTH",
    "NAPE",
    "OPEN",
    "OVERHEAD",
    "POINT",
    "STOP",
    "SUPPORT",
    "TALK",
    "TEMPLE",
    "THIGH",
    "Anchor",
    "Arm",
    "ArmKey",
    "ArmPose",
    "Channel",
    "Hop",
    "Key",
    "Move",
    "Script",
    "Shake",
    "Vector",
    "keys",
]

Vector = tuple[float, float, float]
Arm = Literal["hand", "other"]
"""The preferred arm or leg, and the one that is not."""
ARMS: tuple[Arm, Arm] = ("hand", "other")
Anchor = Literal["shoulder", "chest", "head", "pelvis", "thigh"]
"""What a wrist is placed on.

`shoulder` is free in the air: axes are level and turn with the chest; the place grows with the
performer's reach and with intensity. The others are landmarks whose axes turn with the bone, so a
hand that is put on the face stays there however the trunk bends: `chest` lies between the
shoulder blades' lower ends (0.14 m below the shoulders), `head` at the height of the chin,
`thigh` at the hip of the same side, its up axis along the thigh bone.
"""
Channel = Literal[
    "look_pitch",
    "look_yaw",
    "look_roll",
    "trunk_pitch",
    "trunk_yaw",
    "trunk_roll",
    "shrug",
    "pelvis_up",
    "pelvis_side",
    "hand_out",
    "hand_up",
    "hand_forward",
    "hand_palm",
    "hand_bend",
    "other_out",
    "other_up",
    "other_forward",
    "other_palm",
    "other_bend",
]


@dataclasses.dataclass(frozen=True)
class ArmPose:
    """Where a wrist is, how the elbow is held and how the hand is turned."""

    wrist: Vector
    """`(out, up, forward)` from the anchor, metres; out is towards the arm's own side."""
    elbow: Vector | None = None
    """Which way the elbow sticks out, `(out, up, forward)`; by default down and back."""
    palm_deg: float = 0.0
    """0: thumb in the plane the elbow bends in; positive turns the thumb outward, palm up."""
    bend_deg: float = 0.0
    """Of the wrist, positive to the palm."""
    anchor: Anchor = "shoulder"

    def moved(self, out: float = 0.0, up: float = 0.0, forward: float = 0.0) -> ArmPose:
        """The pose with its wrist elsewhere, metres."""
        own_out, own_up, own_forward = self.wrist
        return dataclasses.replace(self, wrist=(own_out + out, own_up + up, own_forward + forward))

    def turned(self, palm_deg: float, bend_deg: float | None = None) -> ArmPose:
        """The pose with its hand turned otherwise; the wrist's bend stays unless given."""
        bend = self.bend_deg if bend_deg is None else bend_deg
        return dataclasses.replace(self, palm_deg=palm_deg, bend_deg=bend)


ArmKey = tuple[float, ArmPose]
Key = tuple[float, Vector]


def keys(
    times: Sequence[float], first: Sequence[float], second: Sequence[float], third: Sequence[float]
) -> tuple[Key, ...]:
    """Keys written as curves: instants, then each component at them.

    Raises:
        ValueError: Curves and instants differ in number.

    Examples:
        >>> keys((0.0, 0.5), (0.0, 9.0), (0.0, -3.0), (0.0, 1.0))
        ((0.0, (0.0, 0.0, 0.0)), (0.5, (9.0, -3.0, 1.0)))
    """
    places = zip(first, second, third, strict=True)
    return tuple(zip(times, places, strict=True))


@dataclasses.dataclass(frozen=True)
class Move:
    """One step: where the body is to stand when this foot has landed."""

    foot: Arm
    start: float
    end: float
    side: float = 0.0
    """Where the middle of the feet goes, to the preferred side of the start, metres."""
    forward: float = 0.0
    heading_deg: float = 0.0
    """Which way the body faces then, to the preferred side."""
    lift_m: float = 0.06


@dataclasses.dataclass(frozen=True)
class Shake:
    """An oscillation on top of a channel for a while; it swells and fades."""

    channel: Channel
    amplitude: float
    """Degrees for turns, metres for places."""
    rate_hz: float
    start: float
    end: float
    fade_s: float = 0.25
    shift: float = 0.0
    """Periods by which it starts later in its cycle."""


@dataclasses.dataclass(frozen=True)
class Hop:
    """Both feet off the floor for a moment."""

    start: float
    end: float
    height_m: float = 0.07


@dataclasses.dataclass(frozen=True)
class Script:
    """A performance as keys in time; every list is one cycle and comes back by itself."""

    duration_s: float
    """Length at full intensity."""
    plain_s: float
    """Length at intensity 0."""
    hand: tuple[ArmKey, ...]
    other: tuple[ArmKey, ...]
    trunk: tuple[Key, ...] = ((0.0, (0.0, 0.0, 0.0)),)
    """Pitch forward, yaw and roll to the preferred side, degrees, on top of the posture."""
    look: tuple[Key, ...] = ((0.0, (0.0, 0.0, 0.0)),)
    """Where the face points, seen from the feet: pitch down, yaw, roll, degrees."""
    shrug: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    """Degrees."""
    pelvis: tuple[Key, ...] = ((0.0, (0.0, 0.0, 0.0)),)
    """Shift to the preferred side, up and forward, metres, from over the feet."""
    heels: tuple[tuple[float, tuple[float, float]], ...] = ((0.0, (0.0, 0.0)),)
    """Heels raised over planted toes, degrees: preferred side, other side."""
    kneel: tuple[tuple[float, tuple[float, float]], ...] = ((0.0, (0.0, 0.0)),)
    """How far each knee is put on the floor, 0 to 1: preferred side, other side."""
    moves: tuple[Move, ...] = ()
    hops: tuple[Hop, ...] = ()
    shakes: tuple[Shake, ...] = ()
    stance: float = 1.0
    """Factor on the distance of the feet."""
    deep: bool = False
    """Whether the body goes down however little it shows: `pelvis` and `heels` never shrink."""


_DOWN: Vector = (0.35, -1.0, -0.15)
_WIDE: Vector = (1.0, -0.45, -0.3)

HANGING = ArmPose((0.06, -0.525, 0.05))
TALK = ArmPose((0.05, -0.30, 0.30), palm_deg=50.0)
"""Forearm level, palm half up, as in quiet talk."""
OPEN = ArmPose((0.38, -0.12, 0.26), _WIDE, palm_deg=70.0, bend_deg=-15.0)
"""Arm spread, palm up and forward."""
STOP = ArmPose((0.02, 0.05, 0.42), _DOWN, palm_deg=-75.0, bend_deg=-45.0)
"""Arm out, palm to the front."""
POINT = ArmPose((-0.04, 0.02, 0.52), _DOWN, palm_deg=-60.0)
FIST_HIGH = ArmPose((0.14, 0.31, 0.21), _WIDE, palm_deg=-20.0, bend_deg=20.0)
"""Fist beside and above the head, ready to strike."""
OVERHEAD = ArmPose((0.20, 0.46, 0.06), (1.0, 0.0, 0.1), palm_deg=-30.0)
GUARD = ArmPose((-0.08, 0.08, 0.30), (0.3, -1.0, 0.0), palm_deg=-60.0, bend_deg=-30.0)
"""Forearm upright before the face, palm to the front."""

FACE = ArmPose((0.038, -0.019, 0.162), (0.31, -1.0, 0.0), 63.0, -39.0, "head")
"""Hand over the eyes."""
BOTH_ON_FACE = ArmPose((0.055, -0.023, 0.163), (0.35, -1.04, -0.03), 51.0, -41.0, "head")
"""One of two hands before the face."""
MOUTH = ArmPose((0.044, -0.077, 0.152), (0.35, -1.0, -0.03), 56.0, -18.0, "head")
BROW = ArmPose((0.138, 0.11, 0.15), (0.93, -0.48, -0.1), 76.0, 13.0, "head")
"""Hand flat over the eyes, against the sun."""
TEMPLE = ArmPose((0.152, 0.047, 0.093), (0.92, -0.59, 0.38), 20.0, -38.0, "head")
CROWN = ArmPose((0.136, 0.176, 0.013), (0.98, 0.05, 0.49), 77.0, 2.0, "head")
"""Forearm beside the head, hand on top of it."""
NAPE = ArmPose((0.136, 0.021, -0.099), (1.0, 0.13, 0.53), 18.0, 16.0, "head")
HEART = ArmPose((0.017, -0.003, 0.172), (0.81, -0.8, -0.1), 31.0, 18.0, "chest")
CLASPED = ArmPose((0.05, 0.016, 0.247), (0.52, -1.0, -0.1), 7.0, -40.0, "chest")
"""Hands together before the breast."""
BELLY = ArmPose((0.06, 0.131, 0.182), (0.92, -0.56, -0.32), 10.0, 36.0, "pelvis")
AKIMBO = ArmPose((0.221, 0.116, 0.0), (0.96, 0.0, -0.55), 35.0, -30.0, "pelvis")
FOLDED_UNDER = ArmPose((-0.015, -0.035, 0.18), (0.73, -0.97, 0.0), 28.0, 20.0, "chest")
FOLDED_OVER = ArmPose((-0.01, 0.045, 0.268), (0.73, -0.97, 0.0), 28.0, 28.0, "chest")
HUG_UNDER = ArmPose((-0.045, -0.07, 0.168), (0.9, -1.0, 0.05), 33.0, 20.0, "chest")
HUG_OVER = ArmPose((-0.05, 0.068, 0.25), (0.9, -1.0, 0.05), 33.0, 35.0, "chest")
"""Hand round the other upper arm."""
SUPPORT = ArmPose((0.0, -0.12, 0.195), (0.63, -1.0, 0.0), 30.0, 15.0, "chest")
"""Across the body, holding the other elbow."""
THIGH = ArmPose((0.055, -0.195, 0.095), (0.91, 0.34, -0.64), -41.0, -33.0, "thigh")
KNEE = ArmPose((0.035, -0.31, 0.095), (0.9, 0.3, -0.5), -41.0, -33.0, "thigh")
