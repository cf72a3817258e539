"""Writes motions as BVH files, which Blender and most animation tools open."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from affectsim_data.motions.motion import Motion
from affectsim_data.poses import FloatArray, quaternion_matrix
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS

__all__ = ["write_bvh"]

CENTIMETRES = 100.0
END_SITES = {
    "head": (0.0, 0.175, 0.0),
    "left_foot": (0.0, 0.0, 0.07),
    "right_foot": (0.0, 0.0, 0.07),
    "left_wrist": (0.18, 0.0, 0.0),
    "right_wrist": (-0.18, 0.0, 0.0),
}
"""Where the last bones of the 1.70 m body end: crown, toes, fingertips; metres."""


def write_bvh(motion: Motion, path: Path | str) -> None:
    """Writes one cycle of a motion as BVH: the canonical body, centimetres, degrees, +Y up.

    The joints keep their names and their T-pose; the root has a position and three rotations, every
    other joint three rotations, in the order Z, X, Y. Reading the file back gives every joint
    within 0.01 mm. `emotion` and the other labels have no place in the format; put them into the
    path, from which a recipe reads them.

    Raises:
        FileNotFoundError: The folder is not there.
    """
    order = _depth_first()
    angles = _unwrapped(_euler_zxy(motion.joint_rotations[:, order]))
    numbers = np.concatenate(
        [motion.root_translation * CENTIMETRES, angles.reshape(motion.num_frames, -1)], axis=1
    )
    lines = ["HIERARCHY", *_hierarchy(0), "MOTION", f"Frames: {motion.num_frames}"]
    lines.append(f"Frame Time: {1.0 / motion.fps:.9f}")
    # Adding zero turns -0.0, which would be written as -0.000000, into 0.0.
    lines += [" ".join(f"{value:.6f}" for value in row) for row in numbers.round(6) + 0.0]
    Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")


def _children(joint: int) -> list[int]:
    return [child for child, parent in enumerate(JOINT_PARENTS) if parent == joint]


def _depth_first(joint: int = 0) -> list[int]:
    """Joints in the order of the file."""
    return [joint, *(below for child in _children(joint) for below in _depth_first(child))]


def _hierarchy(joint: int) -> list[str]:
    """Lines of a joint and all below it."""
    name = JOINT_NAMES[joint]
    position = "" if joint else "Xposition Yposition Zposition "
    body = [
        f"OFFSET {_centimetres(BODY.joint_offsets[joint])}",
        f"CHANNELS {3 if joint else 6} {position}Zrotation Xrotation Yrotation",
    ]
    for child in _children(joint):
        body += _hierarchy(child)
    if name in END_SITES:
        body += ["End Site", "{", f"\tOFFSET {_centimetres(np.array(END_SITES[name]))}", "}"]
    return [f"{'JOINT' if joint else 'ROOT'} {name}", "{", *(f"\t{line}" for line in body), "}"]


def _centimetres(offset: FloatArray) -> str:
    return " ".join(f"{value:.6f}" for value in offset * CENTIMETRES)


def _euler_zxy(rotations: FloatArray) -> FloatArray:
    """Angles `(..., 3)` in degrees with `Rz @ Rx @ Ry` the rotations `(..., 4)`.

    The middle row and column of that product hold `sin x` alone and products with `cos x`. Where
    `cos x` is nearly zero only z + y or z - y counts; y is then zero.
    """
    m = quaternion_matrix(rotations)
    x = np.arcsin(np.clip(m[..., 2, 1], -1.0, 1.0))
    locked = np.hypot(m[..., 0, 1], m[..., 1, 1]) < 1e-7
    z = np.arctan2(-m[..., 0, 1], m[..., 1, 1])
    y = np.arctan2(-m[..., 2, 0], m[..., 2, 2])
    z = np.where(locked, np.arctan2(m[..., 1, 0], m[..., 0, 0]), z)
    y = np.where(locked, 0.0, y)
    degrees: FloatArray = np.rad2deg(np.stack([z, x, y], axis=-1))
    return degrees


def _unwrapped(angles: FloatArray) -> FloatArray:
    """Angles in degrees, without jumps of 360 from frame to frame, which editors would tween."""
    smooth: FloatArray = np.unwrap(angles, period=360.0, axis=0)
    return smooth
