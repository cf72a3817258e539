"""What a check says of a motion, and what all checks look at."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.motions.motion import Motion
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY

__all__ = ["Finding", "Measure", "Posed", "pose", "sustained"]


@dataclasses.dataclass(frozen=True)
class Measure:
    """The worst a check found, before it is held against a limit."""

    value: float
    """In the unit of the check; more is worse."""
    frame: int = -1
    """First frame of the motion, or of the source for its checks, where it is; -1 for nowhere."""
    joint: str = ""
    """Canonical joint where it is."""
    detail: str = ""
    """What happens there, for the reason."""
    time_s: float = math.nan
    """Time of the frame."""


@dataclasses.dataclass(frozen=True)
class Finding:
    """What one check says of one motion."""

    check: str
    """Name of the check, a table of `builders/screening.toml`."""
    value: float
    """What was measured, in `unit`; `nan` where the check does not apply or is switched off."""
    limit: float
    """Largest value that passes."""
    unit: str
    """Of value and limit."""
    passed: bool
    """Whether the value is within the limit, or there is none."""
    frame: int
    """First frame of what was measured; -1 for nowhere. Of the source file where the check reads
    the source."""
    time_s: float
    """Time of that frame from the start of the clip, seconds; `nan` for nowhere."""
    joint: str
    """Canonical joint where it is; empty for the whole body."""
    reason: str
    """A sentence that says why."""


@dataclasses.dataclass(frozen=True)
class Posed:
    """A motion and where it puts the joints of the canonical body."""

    motion: Motion
    positions: FloatArray
    """Metres, `(num_frames, 22, 3)`."""
    rotations: FloatArray
    """Of the joint frames in the performance frame, `(num_frames, 22, 4)`."""

    @property
    def fps(self) -> float:
        """Frames per second."""
        return self.motion.fps

    def num_frames_in(self, duration_s: float) -> int:
        """Frames a duration takes, at least 1."""
        return max(round(duration_s * self.motion.fps), 1)


def pose(motion: Motion) -> Posed:
    """The motion with the joints it puts into place."""
    return Posed(motion, *BODY.forward_kinematics(motion.root_translation, motion.joint_rotations))


def sustained(values: FloatArray, num_frames: int) -> FloatArray:
    """What `(n, ...)` values keep up for `num_frames` on end from each frame, `(n', ...)`.

    Examples:
        >>> sustained(np.array([0.0, 3.0, 2.0, 0.0]), 2).tolist()
        [0.0, 2.0, 0.0]
    """
    length = min(num_frames, len(values))
    windows = np.lib.stride_tricks.sliding_window_view(values, length, axis=0)
    kept: FloatArray = windows.min(axis=-1)
    return kept
