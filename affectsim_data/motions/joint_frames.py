"""Constant rotations that tie the joint frames of a source skeleton to those of the 22-joint body.

Two directions known in both skeletons fix each of them: where the bone points, and which way is
sideways: for a limb, the axis its elbow or knee really bends about, seen over the clip.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.motions.reaching import unit
from affectsim_data.poses import (
    FloatArray,
    matrix_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["LIMBS", "SIDES", "TRUNK", "SourcePose", "frame_offsets"]

SIDES = ("left", "right")
TRUNK = ("pelvis", "spine1", "spine2", "spine3", "neck", "head")
LIMBS = (("shoulder", "elbow", "wrist"), ("hip", "knee", "ankle"))

_HINGE_SURE_SINE = 0.2
"""Below this mean sine of flexion a limb was all but straight, and which way it bent may be noise:
its axis is then drawn to where one would expect it, the more the less it bent."""
_STANDING_PERCENTILE = 20.0
"""Share of the frames, those with the foot lowest, in which it counts as standing."""


@dataclasses.dataclass(frozen=True)
class SourcePose:
    """A skeleton in motion, in metres with +Y up, whatever its file's conventions."""

    joint_names: tuple[str, ...]
    positions: FloatArray
    """World positions, metres, `(num_frames, num_joints, 3)`."""
    rotations: FloatArray
    """World rotations of the joint frames, unit `wxyz`, `(num_frames, num_joints, 4)`."""
    zero_positions: FloatArray
    """Positions with every rotation zero, metres, file axes, `(num_joints, 3)`."""
    up: FloatArray
    """The up direction in file axes, `(3,)`."""
    fps: float

    @property
    def num_frames(self) -> int:
        """Frames of the clip."""
        return len(self.positions)


def frame_offsets(source: SourcePose, index: dict[str, int]) -> dict[str, FloatArray]:
    """Constant rotation from the canonical to the source frame of each mapped joint, `(4,)`."""
    offsets = _trunk_offsets(source, index)
    chest = max((name for name in offsets if name.startswith("spine")), default="pelvis")
    for side in SIDES:
        offsets |= _limb_offsets(source, index, offsets, chest, f"{side}_shoulder")
        offsets |= _limb_offsets(source, index, offsets, "pelvis", f"{side}_hip")
        collar = f"{side}_collar"
        if collar in index:
            forward = _world_axis(source, index, offsets, chest, (0.0, 0.0, 1.0))
            bone = _bone(source, index, collar, f"{side}_shoulder")
            offsets[collar] = _offset(
                _mean_local(source, index[collar], bone),
                _mean_local(source, index[collar], forward),
                _rest_bone(f"{side}_shoulder"),
                (0.0, 0.0, 1.0),
            )
    return offsets


def _trunk_offsets(source: SourcePose, index: dict[str, int]) -> dict[str, FloatArray]:
    """Offsets of pelvis, spine, neck and head.

    Sideways is the hip line for the pelvis and the shoulder line above it. Up is the file's own
    where its zero pose stands upright, else where the bone points.
    """
    trunk = [name for name in TRUNK if name in index]
    below_neck = [name for name in trunk if name != "head" and name != "neck"]
    arms = ("left_collar", "right_collar")
    if any(name not in index for name in arms):
        arms = ("left_shoulder", "right_shoulder")
    shoulders = _mean_local(source, index[below_neck[-1]], _bone(source, index, arms[1], arms[0]))
    hips = _mean_local(source, index["pelvis"], _bone(source, index, "right_hip", "left_hip"))
    zero = source.zero_positions @ source.up
    stands = zero[index["head"]] > zero[index["pelvis"]] > zero[index["left_ankle"]]
    offsets = {}
    up = source.up
    for name, above in zip(trunk, [*trunk[1:], ""], strict=True):
        # The head has no bone of its own: it is straight on the neck where it is not turned.
        if above and not stands:
            up = _mean_local(source, index[name], _bone(source, index, name, above))
        sideways = hips if name == "pelvis" else shoulders
        offsets[name] = _offset(up, sideways, (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    return offsets


def _limb_offsets(
    source: SourcePose,
    index: dict[str, int],
    trunk: dict[str, FloatArray],
    base: str,
    first: str,
) -> dict[str, FloatArray]:
    """Offsets of an arm or a leg, from the axis its middle joint bends about.

    The axis is the same vector in the frames of the whole limb: they agree where nothing bends.
    """
    side, part = first.split("_")
    limb = next(limb for limb in LIMBS if limb[0] == part)
    upper, middle, end = (f"{side}_{name}" for name in limb)
    arm = part == "shoulder"
    rest_axis = ((0.0, -1.0 if side == "left" else 1.0, 0.0)) if arm else (1.0, 0.0, 0.0)
    bones = _bone(source, index, upper, middle), _bone(source, index, middle, end)
    hinge = _mean_local(source, index[upper], np.cross(*bones), normalize=False)
    unsure = _HINGE_SURE_SINE - float(np.linalg.norm(hinge))
    if unsure > 0.0:
        # Hanging straight, an elbow would bend about the axis that points to the body's right.
        sideways = (-1.0 if arm else 1.0, 0.0, 0.0)
        across = _world_axis(source, index, trunk, base, sideways)
        hinge = hinge + unsure * _mean_local(source, index[upper], across)
    outer = _mean_local(source, index[middle], bones[1])
    directions = {upper: _mean_local(source, index[upper], bones[0]), middle: outer}
    rest = {name: _rest_bone(child) for name, child in ((upper, middle), (middle, end))}
    toe = f"{side}_foot"
    if arm:
        directions[end], rest[end] = outer, rest[middle]
    elif toe in index:
        foot = _mean_local(source, index[end], _bone(source, index, end, toe))
        directions |= {end: foot, toe: foot}
        rest |= {name: _standing_slope(source, index, side, name, foot) for name in (end, toe)}
    return {name: _offset(directions[name], hinge, rest[name], rest_axis) for name in directions}


def _standing_slope(
    source: SourcePose, index: dict[str, int], side: str, name: str, foot: FloatArray
) -> FloatArray:
    """Where the foot's direction points, in the rest pose, for `name` to stand flat, `(3,)`.

    Feet differ in how steeply they fall from ankle to toe base. Taking that slope over would leave
    people on tiptoe, so the source's own slope while the foot is on the floor counts as flat.
    """
    feet = source.positions[:, [index[f"{side}_ankle"], index[f"{side}_foot"]], 1].sum(axis=1)
    standing = feet <= np.percentile(feet, _STANDING_PERCENTILE)
    direction = quaternion_rotate(source.rotations[standing, index[name]], foot)
    slope = float(np.median(np.arcsin(np.clip(direction[:, 1], -1.0, 1.0))))
    return np.array([0.0, np.sin(slope), np.cos(slope)])


def _bone(source: SourcePose, index: dict[str, int], start: str, end: str) -> FloatArray:
    """Unit vectors from one joint to another in the world, `(num_frames, 3)`."""
    return unit(source.positions[:, index[end]] - source.positions[:, index[start]])


def _rest_bone(child: str) -> FloatArray:
    """Direction from the parent to `child` in the canonical rest pose, `(3,)`."""
    return unit(BODY.joint_offsets[JOINT_NAMES.index(child)])


def _mean_local(
    source: SourcePose, joint: int, vectors: FloatArray, *, normalize: bool = True
) -> FloatArray:
    """Mean over the frames of world vectors `(num_frames, 3)`, seen in a source joint's frame."""
    inverse = quaternion_conjugate(source.rotations[:, joint])
    mean: FloatArray = quaternion_rotate(inverse, vectors).mean(axis=0)
    return unit(mean) if normalize else mean


def _world_axis(
    source: SourcePose,
    index: dict[str, int],
    offsets: dict[str, FloatArray],
    name: str,
    axis: ArrayLike,
) -> FloatArray:
    """An axis of a canonical joint's frame in the world, `(num_frames, 3)`."""
    rotations = quaternion_multiply(source.rotations[:, index[name]], offsets[name])
    return quaternion_rotate(rotations, axis)


def _offset(
    bone: ArrayLike,
    sideways: ArrayLike,
    rest_bone: ArrayLike,
    rest_sideways: ArrayLike,
) -> FloatArray:
    """Rotation `(4,)` that takes the rest directions to the source-local ones, bone first."""
    return matrix_quaternion(_frame(bone, sideways) @ _frame(rest_bone, rest_sideways).T)


def _frame(first: ArrayLike, second: ArrayLike) -> FloatArray:
    """Right-handed orthonormal columns: `first`, `second` made orthogonal to it, their cross."""
    one = unit(np.asarray(first, np.float64))
    two = np.asarray(second, np.float64)
    two = unit(two - (two @ one) * one)
    return np.stack([one, two, np.cross(one, two)], axis=1)
