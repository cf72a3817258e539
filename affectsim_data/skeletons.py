"""The 22-joint body skeleton every motion and avatar shares, and forward kinematics on it.

Names and order are the body joints of SMPL, as HumanML3D uses them (Loper et al. 2015; Guo et al.
2022). In the rest pose, a T-pose, the body stands on the floor, +Y up, looks along +Z with its
left hand along +X, and every joint frame is aligned with the world: all rotations are identity.
"""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    quaternion_multiply,
    quaternion_rotate,
)

__all__ = ["BODY", "JOINT_NAMES", "JOINT_PARENTS", "NUM_JOINTS", "Skeleton"]

JOINT_NAMES: tuple[str, ...] = (
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
)
JOINT_PARENTS: tuple[int, ...] = (
    *(-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7),
    *(8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19),
)
NUM_JOINTS = len(JOINT_NAMES)
_Places = slice | list[int]


@dataclasses.dataclass(frozen=True)
class Skeleton:
    """A tree of joints, parents before children."""

    joint_names: tuple[str, ...]
    """Names, unique."""
    joint_parents: tuple[int, ...]
    """Index of the parent joint; -1 for the root, which comes first."""
    joint_offsets: FloatArray
    """Rest position of a joint in its parent, metres, `(num_joints, 3)`; the root's: its height."""

    def __post_init__(self) -> None:
        count = len(self.joint_names)
        if len(set(self.joint_names)) != count:
            raise ValueError(f"joint names must be unique, got {self.joint_names}")
        if len(self.joint_parents) != count or self.joint_offsets.shape != (count, 3):
            raise ValueError(
                f"{count} joints need {count} parents and offsets (n, 3), "
                f"got {len(self.joint_parents)} and {self.joint_offsets.shape}"
            )
        for index, parent in enumerate(self.joint_parents):
            if (index == 0) != (parent == -1) or not -1 <= parent < index:
                raise ValueError(f"joint {self.joint_names[index]!r}: parents must come first")

    @functools.cached_property
    def rest_positions(self) -> FloatArray:
        """Joint positions in the rest pose, `(num_joints, 3)`, metres; not to be written to."""
        positions = self.joint_offsets.copy()
        for joint, parent in enumerate(self.joint_parents):
            if parent >= 0:
                positions[joint] += positions[parent]
        positions.flags.writeable = False
        return positions

    @property
    def hip_height(self) -> float:
        """Height of the root above the floor in the rest pose, metres: the scale of root motion."""
        return float(self.joint_offsets[0, 1])

    def forward_kinematics(
        self, root_translation: ArrayLike, joint_rotations: ArrayLike
    ) -> tuple[FloatArray, FloatArray]:
        """Positions `(..., num_joints, 3)` and global rotations `(..., num_joints, 4)`.

        Args:
            root_translation: Root position, metres, `(..., 3)`.
            joint_rotations: Rotation of each joint in its parent, `(..., num_joints, 4)`.
        """
        local = np.asarray(joint_rotations, np.float64)
        rotations = np.empty_like(local)
        positions = np.empty((*local.shape[:-1], 3))
        rotations[..., 0, :] = local[..., 0, :]
        positions[..., 0, :] = root_translation
        for joints, parents in self._generations:
            above = rotations[..., parents, :]
            turned = quaternion_rotate(above, self.joint_offsets[joints])
            positions[..., joints, :] = positions[..., parents, :] + turned
            rotations[..., joints, :] = quaternion_multiply(above, local[..., joints, :])
        return positions, rotations

    def joint_frames(
        self,
        root_translation: ArrayLike,
        joint_rotations: ArrayLike,
        *,
        T_world_performance: ArrayLike | None = None,
    ) -> FloatArray:
        """Frames of the joints, `(..., num_joints, 4, 4)`: what `forward_kinematics` says, faster.

        Args:
            root_translation: Root position, metres, `(..., 3)`.
            joint_rotations: Rotation of each joint in its parent, `(..., num_joints, 4)`.
            T_world_performance: Takes the frames from the performance into the world, `(4, 4)`.
        """
        frames = compose_pose(joint_rotations, self.joint_offsets)
        frames[..., 0, :3, 3] = root_translation
        if T_world_performance is not None:
            frames[..., 0, :, :] = np.asarray(T_world_performance) @ frames[..., 0, :, :]
        for joints, parents in self._generation_places:
            above, own = frames[..., parents, :, :], frames[..., joints, :, :]
            frames[..., joints, :, :] = above @ own
        return frames

    @functools.cached_property
    def _generation_places(self) -> list[tuple[_Places, _Places]]:
        """The same as `_generations`, as slices where that is possible: they copy nothing."""
        return [(_places(joints), _places(parents)) for joints, parents in self._generations]

    @functools.cached_property
    def _generations(self) -> list[tuple[list[int], list[int]]]:
        """Joints equally far from the root, with their parents, nearest first."""
        depth = [0] * len(self.joint_parents)
        for joint, parent in enumerate(self.joint_parents[1:], start=1):
            depth[joint] = depth[parent] + 1
        generations = []
        for level in range(1, max(depth) + 1):
            joints = [joint for joint, found in enumerate(depth) if found == level]
            generations.append((joints, [self.joint_parents[joint] for joint in joints]))
        return generations


def _places(joints: list[int]) -> _Places:
    consecutive = list(range(joints[0], joints[0] + len(joints)))
    return slice(joints[0], joints[0] + len(joints)) if joints == consecutive else joints


def _body_offsets() -> FloatArray:
    """Offsets of a 1.70 m tall person: segment lengths as shares of height from Winter (2009),
    *Biomechanics and Motor Control of Human Movement*, fig. 4.1, rounded to 5 mm."""
    left = {
        "left_hip": (0.090, -0.050, 0.0),
        "left_knee": (0.0, -0.415, 0.0),
        "left_ankle": (0.0, -0.420, 0.0),
        "left_foot": (0.0, -0.045, 0.130),
        "left_collar": (0.070, 0.110, 0.0),
        "left_shoulder": (0.110, 0.030, 0.0),
        "left_elbow": (0.300, 0.0, 0.0),
        "left_wrist": (0.250, 0.0, 0.0),
    }
    middle = {
        "pelvis": (0.0, 0.950, 0.0),
        "spine1": (0.0, 0.110, 0.0),
        "spine2": (0.0, 0.130, 0.0),
        "spine3": (0.0, 0.060, 0.0),
        "neck": (0.0, 0.200, 0.0),
        "head": (0.0, 0.095, 0.020),
    }
    right = {name.replace("left", "right"): (-x, y, z) for name, (x, y, z) in left.items()}
    offsets = {**left, **middle, **right}
    return np.array([offsets[name] for name in JOINT_NAMES])


BODY = Skeleton(JOINT_NAMES, JOINT_PARENTS, _body_offsets())
"""The canonical body, 1.70 m tall, that motions are stored for; avatars have their own."""
