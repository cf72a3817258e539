"""What each check is limited by: the tables of `builders/screening.toml` as frozen values."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

__all__ = [
    "ANGLES",
    "LIMITS",
    "DroppedFrames",
    "Floating",
    "FootSlide",
    "Frozen",
    "GroundPenetration",
    "Jerk",
    "JointLimits",
    "Limit",
    "RepeatedFrames",
    "SelfPenetration",
    "Thresholds",
]

ANGLES: tuple[str, ...] = (
    *("elbow_flexion", "elbow_sideways", "knee_flexion", "knee_sideways"),
    *("hip_flexion", "hip_abduction", "hip_twist", "shoulder_swing", "shoulder_twist"),
    *("collar_swing", "wrist_swing", "ankle_swing"),
    *("spine1_bend", "spine2_bend", "spine3_bend", "neck_bend", "head_bend"),
)
"""Angles that have a range."""


@dataclasses.dataclass(frozen=True)
class Limit:
    """A check with nothing but a limit."""

    limit: float
    """Largest value that passes, in the unit of the check."""


@dataclasses.dataclass(frozen=True)
class RepeatedFrames(Limit):
    """Limit in seconds."""

    still_m: float
    """A pose is the same while no joint moves by this much."""


@dataclasses.dataclass(frozen=True)
class DroppedFrames(Limit):
    """Limit in metres."""

    around_s: float
    """How far the surroundings of a jump reach, on both sides."""
    background: float
    """How many times the jumps around it a jump must exceed to count."""


@dataclasses.dataclass(frozen=True)
class JointLimits(Limit):
    """Limit in degrees beyond a range."""

    sustained_s: float
    """How long a joint must be out of its range."""
    ranges_deg: Mapping[str, tuple[float, float]]
    """Range of an angle, by joint and angle: `knee_flexion`."""


@dataclasses.dataclass(frozen=True)
class FootSlide(Limit):
    """Limit in metres of one stance."""

    height_m: float
    """A foot is down while ankle and toes are within this of their lowest level."""
    still_m_s: float
    """A stance needs an instant slower than this."""
    step_m_s: float
    """Faster than this, a foot beside one that stands takes a low step."""
    swing_m_s: float
    """Faster than this no foot is standing."""


@dataclasses.dataclass(frozen=True)
class GroundPenetration(Limit):
    """Limit in metres below the floor."""

    sustained_s: float
    """How long."""


@dataclasses.dataclass(frozen=True)
class Floating(Limit):
    """Limit in seconds."""

    height_m: float
    """The lowest part of the body is off the floor from this height."""
    still_m_s: float
    """An ankle slower than this stands."""
    fall_m_s2: float
    """A body whose pelvis falls with this acceleration or more jumps or runs."""


@dataclasses.dataclass(frozen=True)
class SelfPenetration(Limit):
    """Limit in metres."""

    sustained_s: float
    """How long."""


@dataclasses.dataclass(frozen=True)
class Frozen(Limit):
    """Limit in seconds."""

    share: float
    """Only what is at least this share of the motion counts."""
    still_deg_s: float
    """A joint is still while it turns more slowly than this."""
    moved_deg: float
    """A joint that never turns this far was not recorded, rather than stuck."""
    alive_m_s: float
    """The body must move on at this mean speed of its joints."""


@dataclasses.dataclass(frozen=True)
class Jerk(Limit):
    """Limit in robust standard deviations of the logarithm."""

    class_size: int
    """Motions of the same action and emotion needed to compare among them; else all."""
    min_spread: float
    """Least robust standard deviation of the logarithm to divide by."""


@dataclasses.dataclass(frozen=True)
class Thresholds:
    """Limits of all checks, in the order of the report."""

    bone_drift: Limit
    bone_asymmetry: Limit
    repeated_frames: RepeatedFrames
    dropped_frames: DroppedFrames
    joint_limits: JointLimits
    root_jump: DroppedFrames
    limb_swap: Limit
    foot_slide: FootSlide
    ground_penetration: GroundPenetration
    floating: Floating
    self_penetration: SelfPenetration
    seam: Limit
    seam_turn: Limit
    frozen: Frozen
    jerk: Jerk
    off: Mapping[str, str]
    """Reason a check is switched off, by name."""

    @property
    def checks(self) -> tuple[str, ...]:
        """Names of the checks, those switched off included."""
        return tuple(LIMITS)


LIMITS: Mapping[str, type[Limit]] = {
    "bone_drift": Limit,
    "bone_asymmetry": Limit,
    "repeated_frames": RepeatedFrames,
    "dropped_frames": DroppedFrames,
    "joint_limits": JointLimits,
    "root_jump": DroppedFrames,
    "limb_swap": Limit,
    "foot_slide": FootSlide,
    "ground_penetration": GroundPenetration,
    "floating": Floating,
    "self_penetration": SelfPenetration,
    "seam": Limit,
    "seam_turn": Limit,
    "frozen": Frozen,
    "jerk": Jerk,
}
"""What a check is limited by, in the order of the report."""
