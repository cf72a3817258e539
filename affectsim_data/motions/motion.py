"""The behaviour m: an emotion-labelled performance on the 22-joint body skeleton."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.poses import FloatArray, quaternion_slerp
from affectsim_data.skeletons import BODY, NUM_JOINTS

__all__ = ["EMOTIONS", "Emotion", "Motion", "Uncut", "emotion_label"]

Emotion = Literal["angry", "fearful", "happy", "neutral", "sad"]
EMOTIONS: tuple[Emotion, ...] = get_args(Emotion)
"""The label space, in the order of label indices 0 to 4."""

_ROTATION_GRID = 2.0**15
_ROOT_GRID = 2.0**16
"""Parts of a metre; a power of two, so that float32 holds its multiples exactly, up to 256 m."""
_NORM_TOLERANCE = 2.0**-14
"""More than rounding changes a norm by, so that what was rounded is not scaled again."""


def emotion_label(emotion: str) -> int:
    """Index of an emotion in `EMOTIONS`.

    Raises:
        ValueError: Not one of the five.

    Examples:
        >>> emotion_label("happy")
        2
    """
    if emotion not in EMOTIONS:
        raise ValueError(f"emotion must be one of {', '.join(EMOTIONS)}, got {emotion!r}")
    return EMOTIONS.index(emotion)


@dataclasses.dataclass(frozen=True)
class Uncut:
    """What a motion needs to become again what it was before it was closed into a cycle."""

    before: int
    """How many of the frames here come before those that are kept."""
    start: int
    """First frame of the cycle that is a frame of the original, unchanged."""
    stop: int
    """Frame after the last one."""
    root_translation: FloatArray
    """Frames of the original that the cycle lacks, `(num_frames, 3)`."""
    joint_rotations: FloatArray
    """The same, `(num_frames, 22, 4)`."""

    def __post_init__(self) -> None:
        count = len(self.root_translation)
        shapes = self.root_translation.shape, self.joint_rotations.shape
        if shapes != ((count, 3), (count, NUM_JOINTS, 4)):
            raise ValueError(
                f"original frames must be (n, 3) and (n, {NUM_JOINTS}, 4), "
                f"got {shapes[0]} and {shapes[1]}"
            )
        if not (0 <= self.before <= count and 0 <= self.start <= self.stop):
            raise ValueError(
                f"original frames: expected 0 <= before <= {count} and 0 <= start <= stop, "
                f"got before {self.before}, start {self.start}, stop {self.stop}"
            )


@dataclasses.dataclass(frozen=True)
class Motion:
    """One performance by one person at a fixed rate, for the canonical body, played cyclically.

    The performance frame has its origin on the floor under the pelvis of the first frame, +Y up,
    and the performer looks along +Z there.
    """

    motion_id: str
    """Unique in a release, for example `bandai_namco/walk_happy_001`."""
    performer_id: str
    """Who performed."""
    group_id: str
    """What may not be shared between splits: the source performance or interaction sequence."""
    emotion: Emotion
    """The label; it lives here and nowhere else."""
    action: str
    """What is done: `simple_walk`, `being_seated`, `scenario`, ... or the source's own word."""
    fps: float
    """Frames per second."""
    root_translation: FloatArray
    """Pelvis of the canonical body in the performance frame, metres, `(num_frames, 3)`."""
    joint_rotations: FloatArray
    """Of a joint in its parent, unit `wxyz`, `(num_frames, 22, 4)`; identity is the T-pose."""
    performance: str = ""
    """What was performed, more closely than `action` and often telling the emotion: `threaten`."""
    take: int = 0
    """Which repetition by this performer of this action and emotion, from 0."""
    source: str = ""
    """Corpus and file it came from."""
    licence: str = ""
    """Licence of the source, SPDX where there is one."""
    provenance: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    """What was done to the source, as JSON can hold it: file, rate, scale, planted frames, loop."""
    uncut: Uncut | None = None
    """How to get back what there was before the cycle was closed; none if nothing was done."""

    def __post_init__(self) -> None:
        name = f"motion {self.motion_id!r}"
        if self.emotion not in EMOTIONS:
            raise ValueError(
                f"{name}: emotion must be one of {', '.join(EMOTIONS)}, got {self.emotion!r}"
            )
        num_frames = len(self.root_translation)
        if self.root_translation.shape != (num_frames, 3) or num_frames < 2:
            raise ValueError(
                f"{name}: root_translation must be (num_frames >= 2, 3), "
                f"got {self.root_translation.shape}"
            )
        if self.joint_rotations.shape != (num_frames, NUM_JOINTS, 4):
            raise ValueError(
                f"{name}: joint_rotations must be ({num_frames}, {NUM_JOINTS}, 4), "
                f"got {self.joint_rotations.shape}"
            )
        if not 0.0 < self.fps < math.inf:
            raise ValueError(f"{name}: fps must be positive and finite, got {self.fps}")
        for field in ("root_translation", "joint_rotations"):
            bad = ~np.isfinite(getattr(self, field)).reshape(num_frames, -1).all(axis=1)
            if bad.any():
                raise ValueError(
                    f"{name}: {field} must be finite, got nan or inf in {int(bad.sum())} of "
                    f"{num_frames} frames, first in frame {int(np.argmax(bad))}"
                )
        norms = np.linalg.norm(self.joint_rotations, axis=-1)
        if np.abs(norms - 1.0).max() > 1e-3:
            frame, joint = np.unravel_index(np.abs(norms - 1.0).argmax(), norms.shape)
            raise ValueError(
                f"{name}: joint_rotations must be unit quaternions, got norm "
                f"{norms[frame, joint]:.4f} in frame {frame}, joint {joint}"
            )

        if self.uncut is not None and self.uncut.stop > num_frames:
            raise ValueError(
                f"{name}: original frames must be within the {num_frames} of the cycle, "
                f"got stop {self.uncut.stop}"
            )

    @property
    def num_frames(self) -> int:
        """Frames in one cycle."""
        return len(self.root_translation)

    @property
    def duration_s(self) -> float:
        """Length of one cycle in seconds."""
        return self.num_frames / self.fps

    def sample(self, time_s: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Root translations `(n, 3)` and joint rotations `(n, 22, 4)` at instants `(n,)`, cyclic.

        Between frames the root moves linearly and joints turn by the shorter way; the last frame
        leads into the first.
        """
        position = np.mod(np.asarray(time_s, np.float64) * self.fps, self.num_frames)
        floor = np.floor(position)
        before = floor.astype(np.intp) % self.num_frames
        after = (before + 1) % self.num_frames
        share = position - floor
        root = self.root_translation
        root = root[before] + share[:, None] * (root[after] - root[before])
        rotations = quaternion_slerp(
            self.joint_rotations[before], self.joint_rotations[after], share[:, None]
        )
        return root, rotations

    def joint_positions(self) -> FloatArray:
        """Joints of the canonical body in the performance frame, metres, `(num_frames, 22, 3)`."""
        return BODY.forward_kinematics(self.root_translation, self.joint_rotations)[0]

    def original(self) -> Motion:
        """The motion before it was closed into a cycle, frame by frame; itself if it never was."""
        uncut = self.uncut
        if uncut is None:
            return self
        root, rotations = (
            np.concatenate(
                [kept[: uncut.before], cycle[uncut.start : uncut.stop], kept[uncut.before :]]
            ).astype(np.float64)
            for kept, cycle in (
                (uncut.root_translation, self.root_translation),
                (uncut.joint_rotations, self.joint_rotations),
            )
        )
        provenance = {key: value for key, value in self.provenance.items() if key != "loop"}
        note = self.provenance.get("loop", {}).get("note", "")
        return dataclasses.replace(
            self,
            root_translation=root,
            joint_rotations=rotations,
            source=self.source.removesuffix(note).removesuffix("; "),
            provenance=provenance,
            uncut=None,
        )

    def rounded(self) -> Motion:
        """The motion as shards store it: float32, quaternions with `w >= 0`.

        Components of quaternions are multiples of 2^-15 and translations of 2^-16 m, which
        compresses far better than all bits of a float32 and moves no joint by 0.3 mm. The root is
        finer because all joints move with it, and jerk multiplies what is rounded by the cube of
        the rate: at 30 fps steps of 2^-13 m would be noise of 4 m/s^3, these are of 0.5 m/s^3.
        """
        uncut = self.uncut and dataclasses.replace(
            self.uncut,
            root_translation=_rounded_root(self.uncut.root_translation),
            joint_rotations=_rounded_rotations(self.uncut.joint_rotations),
        )
        return dataclasses.replace(
            self,
            root_translation=_rounded_root(self.root_translation),
            joint_rotations=_rounded_rotations(self.joint_rotations),
            uncut=uncut,
        )


def _rounded_root(root: FloatArray) -> FloatArray:
    rounded: FloatArray = np.round(np.asarray(root, np.float64) * _ROOT_GRID) / _ROOT_GRID
    return rounded


def _rounded_rotations(rotations: FloatArray) -> FloatArray:
    """On the grid with `w >= 0`; what is on it stays as it is."""
    q = np.asarray(rotations, np.float64)
    norms = np.linalg.norm(q, axis=-1, keepdims=True)
    q = np.where(np.abs(norms - 1.0) > _NORM_TOLERANCE, q / norms, q)
    q = np.where(q[..., :1] < 0.0, -q, q)
    rounded: FloatArray = np.round(q * _ROTATION_GRID) / _ROTATION_GRID
    return rounded + 0.0  # no negative zeros
