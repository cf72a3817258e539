"""SMPL bodies from .npz: rotations carried over, up, floor, hostile and damaged files."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from corpus_files import elbow_bends_deg, smpl_arrays, write_smpl
from scipy.spatial.transform import Rotation

from affectsim_data.builders.performances import perform
from affectsim_data.motions import Motion
from affectsim_data.motions.smpl import SmplClip, read_smpl, smpl_motion, smpl_source
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

LEG = ("hip", "knee", "ankle", "foot")
UPRIGHT = axis_angle_quaternion([1.0, 0.0, 0.0], np.pi / 2.0)
"""Takes +Y up into +Z up."""


def clip_of(motion: Motion, *, heading: float = 0.0) -> dict[str, FloatArray]:
    """Arrays of a file in which an SMPL body turns its joints as a motion of ours does."""
    turn = quaternion_multiply(UPRIGHT, yaw_quaternion(heading))
    rotations = motion.joint_rotations.copy()
    rotations[:, 0] = quaternion_multiply(turn, rotations[:, 0])
    vectors = Rotation.from_quat(rotations[..., [1, 2, 3, 0]].reshape(-1, 4)).as_rotvec()
    poses = np.zeros((motion.num_frames, 156))
    poses[:, :66] = vectors.reshape(motion.num_frames, 66)
    moved = quaternion_rotate(turn, motion.root_translation)
    return {"poses": poses, "trans": moved, "mocap_framerate": np.array(motion.fps)}


def walking() -> Motion:
    return perform("simple_walk", "happy", "p1", rng=np.random.default_rng(0))


@pytest.mark.parametrize("heading", [0.0, 2.5])
def test_joints_turn_as_in_the_file(tmp_path: Path, heading: float) -> None:
    motion = walking()
    clip = read_smpl(write_smpl(tmp_path / "walk.npz", clip_of(motion, heading=heading)))
    assert clip.fps == motion.fps
    _, rotations = smpl_motion(clip)
    dots = np.abs((rotations * motion.joint_rotations).sum(-1)).clip(0.0, 1.0)
    above = [i for i, name in enumerate(JOINT_NAMES) if i and not name.endswith(LEG)]
    np.testing.assert_allclose(dots[:, above], 1.0, atol=1e-12)
    # Legs give way where the feet of a body of other proportions stand.
    legs = [i for i, name in enumerate(JOINT_NAMES) if name.endswith(LEG)]
    assert np.rad2deg(2.0 * np.arccos(dots[:, legs])).max() < 8.0
    # The whole figure faces +Z by its own hips and shoulders: a turn about +Y, the same throughout.
    inverse = motion.joint_rotations[:, 0] * [1.0, -1.0, -1.0, -1.0]
    turn = quaternion_multiply(rotations[:, 0], inverse)
    np.testing.assert_allclose(np.abs(turn @ turn[0]), 1.0, atol=1e-9)
    np.testing.assert_allclose(turn[:, [1, 3]], 0.0, atol=1e-9)
    assert np.abs(2.0 * np.arcsin(turn[0, 2])) < np.deg2rad(15.0)


def test_the_person_stands_on_the_floor_over_the_origin(tmp_path: Path) -> None:
    clip = read_smpl(write_smpl(tmp_path / "clip.npz"))
    root, rotations = smpl_motion(clip)
    positions, _ = BODY.forward_kinematics(root, rotations)
    np.testing.assert_allclose(positions[0, 0, [0, 2]], 0.0, atol=1e-9)
    np.testing.assert_allclose(positions[0], BODY.rest_positions, atol=1e-9)
    source = smpl_source(clip)
    feet = [JOINT_NAMES.index(f"{side}_foot") for side in ("left", "right")]
    assert np.abs(source.positions[:, feet, 1]).max() < 0.1
    # The file's body faces -Y, which is +Z once +Z is up.
    toes = source.positions[0, feet, 2] - source.positions[0, [7, 8], 2]
    assert (toes > 0.1).all()
    np.testing.assert_allclose(source.positions[0, 0, [0, 2]], [1.5, 2.0 + 0.22], atol=1e-9)


def test_root_motion_scales_with_the_legs(tmp_path: Path) -> None:
    arrays = smpl_arrays(60)
    arrays["trans"][:, 1] -= np.linspace(0.0, 1.0, 60)
    root, _ = smpl_motion(read_smpl(write_smpl(tmp_path / "clip.npz", arrays)))
    way = root[-1] - root[0]
    np.testing.assert_allclose(way[:2], 0.0, atol=1e-9)
    # 0.835 m of thigh and shank, where the mean SMPL body has 0.78.
    assert way[2] == pytest.approx(0.835 / 0.78, rel=0.01)


def test_y_up_and_other_widths(tmp_path: Path) -> None:
    z_up = smpl_arrays(width=66)
    expected = smpl_motion(read_smpl(write_smpl(tmp_path / "z.npz", z_up)))
    y_up = smpl_arrays(width=165)
    y_up["poses"][:, 0] = 0.0
    y_up["trans"] = y_up["trans"][:, [0, 2, 1]] * [1.0, 1.0, -1.0]
    y_up["mocap_frame_rate"] = y_up.pop("mocap_framerate").astype(np.int64)
    found = smpl_motion(read_smpl(write_smpl(tmp_path / "y.npz", y_up)), up_axis="y")
    np.testing.assert_allclose(found[0], expected[0], atol=1e-9)
    np.testing.assert_allclose(found[1], expected[1], atol=1e-9)
    clip = SmplClip(np.zeros((2, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (2, 22, 1)), 30.0)
    with pytest.raises(ValueError, match="up_axis must be 'y' or 'z', got 'x'"):
        smpl_source(clip, up_axis="x")


def test_a_known_bend_comes_back(tmp_path: Path) -> None:
    root, rotations = smpl_motion(read_smpl(write_smpl(tmp_path / "clip.npz")))
    motion = Motion("a", "b", "c", "sad", "d", 120.0, root, rotations)
    assert elbow_bends_deg(motion)[120] == pytest.approx(40.0, abs=1e-6)
    assert elbow_bends_deg(motion, "right").max() < 1e-5


def changed(**changes: Any) -> dict[str, Any]:
    """The default arrays with others in their place; None takes one away."""
    arrays = smpl_arrays(num_frames=8) | changes
    return {key: value for key, value in arrays.items() if value is not None}


def with_number(key: str, value: float) -> FloatArray:
    array: FloatArray = smpl_arrays(num_frames=8)[key].copy()
    array[3, 2] = value
    return array


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        (changed(poses=None), r"expected the arrays poses; the file has betas, dmpls, gender"),
        (changed(trans=None, poses=None), r"expected the arrays poses, trans; "),
        (changed(mocap_framerate=None), "expected the arrays mocap_framerate or mocap_frame_rate"),
        (changed(poses=np.zeros((8, 63))), r"expected poses of .*66 to 165.* got \(8, 63\)"),
        (changed(poses=np.zeros((8, 67))), r"three numbers a joint, got \(8, 67\)"),
        (changed(poses=np.zeros((8, 300))), r"got \(8, 300\)"),
        (changed(poses=np.zeros(156)), r"expected 2 axes in poses, got the shape \(156,\)"),
        (changed(trans=np.zeros((7, 3))), r"poses of \(8, 156\) and trans of \(7, 3\)"),
        (changed(poses=with_number("poses", np.nan)), "got nan in poses, frame 3, number 2"),
        (changed(trans=with_number("trans", np.inf)), "got inf in trans, frame 3, number 2"),
        (changed(mocap_framerate=np.array(0.0)), "expected 0.1 to 10000 frames per second, got 0"),
        (changed(mocap_framerate=np.array("120")), "expected numbers in mocap_framerate, got <U3"),
        (changed(mocap_framerate=np.array([30.0, 30.0])), r"0 axes in mocap_framerate"),
        (changed(poses=np.full((8, 156), None)), "expected numbers in poses, got object"),
    ],
)
def test_a_file_that_is_no_body_says_why(
    tmp_path: Path, arrays: dict[str, Any], message: str
) -> None:
    path = write_smpl(tmp_path / "clip.npz", arrays)
    with pytest.raises(ValueError, match=message) as caught:
        read_smpl(path)
    assert str(caught.value).startswith(str(path))


def header_only(shape: tuple[int, ...]) -> bytes:
    """An array that announces a shape and holds nothing."""
    stream = io.BytesIO()
    fields = {"descr": "<f8", "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(stream, fields)
    return stream.getvalue()


def test_a_header_that_announces_gigabytes_is_refused_before_memory_is_taken(
    tmp_path: Path,
) -> None:
    path = write_smpl(tmp_path / "clip.npz", changed(poses=None))
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("poses.npy", header_only((10**12, 156)))
    with pytest.raises(ValueError, match=r"at most 536870912 bytes in poses, got 1248000000000000"):
        read_smpl(path)


@pytest.mark.parametrize("shape", [(8, 156), (-8, 156)])
def test_a_header_that_does_not_fit_its_numbers(tmp_path: Path, shape: tuple[int, int]) -> None:
    path = write_smpl(tmp_path / "clip.npz", changed(poses=None))
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("poses.npy", header_only(shape))
    with pytest.raises(ValueError, match=r"clip\.npz: "):
        read_smpl(path)


def test_files_cut_short_or_of_another_kind(tmp_path: Path) -> None:
    path = write_smpl(tmp_path / "clip.npz")
    data = path.read_bytes()
    for cut in (0, 10, len(data) // 2, len(data) - 5):
        path.write_bytes(data[:cut])
        with pytest.raises(ValueError, match=r"clip\.npz: expected an intact \.npz file"):
            read_smpl(path)
    flipped = bytearray(data)
    flipped[2000] ^= 255
    path.write_bytes(flipped)
    with pytest.raises(ValueError, match=r"clip\.npz: "):
        read_smpl(path)
    with zipfile.ZipFile(path, "w") as archive:
        for key in ("poses", "trans", "mocap_framerate"):
            archive.writestr(f"{key}.npy", b"junk")
    with pytest.raises(ValueError, match=r"clip\.npz: "):
        read_smpl(path)
    with pytest.raises(FileNotFoundError, match="no SMPL file at"):
        read_smpl(tmp_path / "none.npz")
