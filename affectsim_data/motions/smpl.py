"""Reads motion of SMPL bodies from `.npz` files as AMASS keeps it: `poses`, `trans` and a rate.

SMPL, SMPL-H and SMPL-X share the first 22 joints, and these are the joints of our body: same names,
same order, frames aligned with the world in the T-pose. So rotations carry over as they are, where
`retarget` must estimate the joint frames of other skeletons. Shape parameters need the licensed
SMPL model and are not used: every body is taken for the mean one.
"""

from __future__ import annotations

import dataclasses
import math
import zipfile
import zlib
from pathlib import Path
from typing import IO

import numpy as np
from numpy.typing import NDArray

from affectsim_data.motions.facing import face_forward
from affectsim_data.motions.joint_frames import SourcePose
from affectsim_data.motions.planting import TOES, find_stances, plant_feet
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_multiply,
    quaternion_rotate,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS, Skeleton

__all__ = ["SmplClip", "read_smpl", "smpl_motion", "smpl_source"]

MAX_ARRAY_BYTES = 512 * 2**20
"""Of one array: an hour of SMPL-X at 100 Hz; bounds what a hostile file can allocate."""
MAX_NUMBERS = 165
"""Of a frame of `poses`: three for each of SMPL-X's 55 joints; SMPL-H has 156, SMPL 72."""
RATE_KEYS = ("mocap_framerate", "mocap_frame_rate")


@dataclasses.dataclass(frozen=True)
class SmplClip:
    """The body of one file: file axes, metres."""

    translation: FloatArray
    """`trans`: where the body's origin went, metres, `(num_frames, 3)`."""
    rotations: FloatArray
    """Of a body joint in its parent, unit `wxyz`, `(num_frames, 22, 4)`; the root's in the file."""
    fps: float


def _mean_offsets() -> FloatArray:
    """Joints of the mean SMPL body in their parents, metres, rounded to a centimetre and made
    symmetric; the root's is where the pelvis lies from the body's origin."""
    left = {
        "left_hip": (0.07, -0.09, -0.01),
        "left_knee": (0.04, -0.38, 0.0),
        "left_ankle": (-0.01, -0.40, -0.04),
        "left_foot": (0.03, -0.06, 0.12),
        "left_collar": (0.08, 0.12, -0.03),
        "left_shoulder": (0.09, 0.03, -0.01),
        "left_elbow": (0.26, -0.01, -0.03),
        "left_wrist": (0.25, 0.01, 0.0),
    }
    middle = {
        "pelvis": (0.0, -0.22, 0.03),
        "spine1": (0.0, 0.11, -0.03),
        "spine2": (0.0, 0.14, 0.0),
        "spine3": (0.0, 0.05, 0.03),
        "neck": (0.0, 0.21, -0.04),
        "head": (0.0, 0.07, 0.05),
    }
    right = {name.replace("left", "right"): (-x, y, z) for name, (x, y, z) in left.items()}
    offsets = {**left, **middle, **right}
    return np.array([offsets[name] for name in JOINT_NAMES])


_MEAN_BODY = Skeleton(JOINT_NAMES, JOINT_PARENTS, _mean_offsets())


def read_smpl(path: Path | str) -> SmplClip:
    """The body motion in an `.npz` file; hands, face, shape and soft tissue are not read.

    Nothing is unpickled, and sizes are checked before memory is taken.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Not such a file; starts with the path, says what was expected and found.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"no SMPL file at {path}")
    try:
        with zipfile.ZipFile(path) as archive:
            names = set(archive.namelist())
            rate_key = next((key for key in RATE_KEYS if f"{key}.npy" in names), None)
            lacking = [key for key in ("poses", "trans") if f"{key}.npy" not in names]
            lacking += [] if rate_key else [" or ".join(RATE_KEYS)]
            if rate_key is None or lacking:
                there = ", ".join(sorted(name.removesuffix(".npy") for name in names)) or "nothing"
                raise ValueError(f"expected the arrays {', '.join(lacking)}; the file has {there}")
            poses = _read_array(archive, "poses", ndim=2)
            translation = _read_array(archive, "trans", ndim=2)
            fps = float(_read_array(archive, rate_key, ndim=0))
    except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, NotImplementedError) as error:
        raise ValueError(f"{path}: expected an intact .npz file: {error}") from error
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    _check(poses, translation, fps, name=str(path))
    vectors = poses[:, : 3 * NUM_JOINTS].reshape(-1, NUM_JOINTS, 3)
    angles = np.linalg.norm(vectors, axis=-1)
    axes = vectors / np.maximum(angles, 1e-12)[..., None]
    return SmplClip(translation, axis_angle_quaternion(axes, angles), fps)


def smpl_source(clip: SmplClip, *, up_axis: str = "z") -> SourcePose:
    """The clip on the mean SMPL body, in metres with +Y up, as screening and reports look at it.

    Raises:
        ValueError: `up_axis` is neither `y` nor `z`.
    """
    root, rotations = _upright(clip, up_axis)
    positions, world = _MEAN_BODY.forward_kinematics(root, rotations)
    up = np.array([0.0, 1.0, 0.0])
    zero = _MEAN_BODY.rest_positions.copy()
    return SourcePose(JOINT_NAMES, positions, world, zero, up, clip.fps)


def smpl_motion(clip: SmplClip, *, up_axis: str = "z") -> tuple[FloatArray, FloatArray]:
    """The clip on the canonical body, in the performance frame; joints turn as in the file.

    The hips move as the SMPL body's, scaled by leg length. Floor, facing and origin are as
    `retarget` finds them, and planted feet are kept still, for which hips and knees give way by a
    few degrees; nothing above them turns otherwise than in the file.

    Returns:
        `root_translation` `(num_frames, 3)` in metres and `joint_rotations` `(num_frames, 22, 4)`.

    Raises:
        ValueError: `up_axis` is neither `y` nor `z`.
    """
    pelvis, rotations = _upright(clip, up_axis)
    scale = _leg_length(BODY) / _leg_length(_MEAN_BODY)
    toes = _MEAN_BODY.forward_kinematics(pelvis, rotations)[0][:, TOES]
    stances = find_stances(scale * toes, clip.fps)
    hips = pelvis + quaternion_rotate(rotations[:, 0], _hip_centre(_MEAN_BODY))
    root = scale * hips - quaternion_rotate(rotations[:, 0], _hip_centre(BODY))
    root, rotations = face_forward(root, rotations, stances)
    return plant_feet(root, rotations, stances, fps=clip.fps)


def _upright(clip: SmplClip, up_axis: str) -> tuple[FloatArray, FloatArray]:
    """Pelvis `(num_frames, 3)` and joint rotations `(num_frames, 22, 4)` with +Y up."""
    if up_axis not in ("y", "z"):
        raise ValueError(f"up_axis must be 'y' or 'z', got {up_axis!r}")
    # SMPL turns the body about its pelvis, which lies off the origin that `trans` moves.
    root, rotations = clip.translation + _MEAN_BODY.joint_offsets[0], clip.rotations.copy()
    if up_axis == "z":
        upright = axis_angle_quaternion([1.0, 0.0, 0.0], -np.pi / 2.0)
        root = quaternion_rotate(upright, root)
        rotations[:, 0] = quaternion_multiply(upright, rotations[:, 0])
    return root, rotations


def _hip_centre(skeleton: Skeleton) -> FloatArray:
    """Middle between the hips, seen from the pelvis, `(3,)`."""
    hips = [JOINT_NAMES.index(f"{side}_hip") for side in ("left", "right")]
    centre: FloatArray = skeleton.joint_offsets[hips].mean(axis=0)
    return centre


def _leg_length(skeleton: Skeleton) -> float:
    """Thigh plus shank, metres."""
    bones = [JOINT_NAMES.index(name) for name in ("left_knee", "left_ankle")]
    return float(np.linalg.norm(skeleton.joint_offsets[bones], axis=1).sum())


def _read_array(archive: zipfile.ZipFile, key: str, *, ndim: int) -> FloatArray:
    """An array of numbers, its header checked before its values are read."""
    with archive.open(f"{key}.npy") as stream:
        shape, dtype = _array_header(stream)
        size = math.prod(shape) * dtype.itemsize
        if dtype.kind not in "fiu":
            raise ValueError(f"expected numbers in {key}, got {dtype}")
        if len(shape) != ndim:
            raise ValueError(f"expected {ndim} axes in {key}, got the shape {shape}")
        if size > MAX_ARRAY_BYTES:
            raise ValueError(f"expected at most {MAX_ARRAY_BYTES} bytes in {key}, got {size}")
        stream.seek(0)
        array: NDArray[np.generic] = np.lib.format.read_array(stream, allow_pickle=False)
    return array.astype(np.float64)


def _array_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype[np.generic]]:
    """Shape and type of an array in a `.npy` stream."""
    version = np.lib.format.read_magic(stream)
    if version == (1, 0):
        shape, _, dtype = np.lib.format.read_array_header_1_0(stream)
    elif version == (2, 0):
        shape, _, dtype = np.lib.format.read_array_header_2_0(stream)
    else:
        raise ValueError(f"expected .npy version 1.0 or 2.0, got {version}")
    return shape, dtype


def _check(poses: FloatArray, translation: FloatArray, fps: float, *, name: str) -> None:
    """Raises unless the arrays are those of one body in motion."""
    count, width = poses.shape
    if width % 3 or not 3 * NUM_JOINTS <= width <= MAX_NUMBERS:
        raise ValueError(
            f"{name}: expected poses of (num_frames, {3 * NUM_JOINTS} to {MAX_NUMBERS}), three "
            f"numbers a joint, got {poses.shape}"
        )
    if count < 2 or translation.shape != (count, 3):
        raise ValueError(
            f"{name}: expected 2 frames or more and trans of (num_frames, 3), got poses of "
            f"{poses.shape} and trans of {translation.shape}"
        )
    if not 0.1 <= fps <= 10_000.0:
        raise ValueError(f"{name}: expected 0.1 to 10000 frames per second, got {fps}")
    for key, array in (("poses", poses), ("trans", translation)):
        bad = ~np.isfinite(array[:, : 3 * NUM_JOINTS])
        if bad.any():
            frame, number = (int(i) for i in np.argwhere(bad)[0])
            raise ValueError(
                f"{name}: expected finite numbers, got {array[frame, number]} in {key}, frame "
                f"{frame}, number {number}"
            )
