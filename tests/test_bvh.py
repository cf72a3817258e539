"""BVH read and written: by-hand skeletons, Euler orders against SciPy, damaged and real files."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
from corpus_files import kdae_rig, rig_bvh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from affectsim_data.builders.performances import PerformanceAction, perform
from affectsim_data.motions import Emotion, Motion
from affectsim_data.motions.bvh import BvhClip, read_bvh
from affectsim_data.motions.bvh_writing import write_bvh
from affectsim_data.motions.retargeting import SourcePose, retarget, source_pose
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY, JOINT_NAMES

LEG = """HIERARCHY
ROOT Hips
{
  OFFSET 5 5 5
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Knee
  {
    OFFSET 0 -2 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT Foot
    {
      OFFSET 0 -1 0
      CHANNELS 4 Yposition Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 0 0.5
      }
    }
  }
}
MOTION
Frames: 2
Frame Time: 0.04
1 2 3 0 0 0 0 0 0 -1 0 0 0
1 2 3 90 0 0 0 90 0 -3 0 0 0
"""


def written(tmp_path: Path, text: str | bytes) -> Path:
    path = tmp_path / "clip.bvh"
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def single_joint(order: str, angles: tuple[float, float, float]) -> str:
    channels = " ".join(f"{axis}rotation" for axis in order)
    numbers = " ".join(repr(angle) for angle in angles)
    return (
        f"HIERARCHY\nROOT Hips\n{{\nOFFSET 0 0 0\nCHANNELS 3 {channels}\n}}\n"
        f"MOTION\nFrames: 1\nFrame Time: 0.1\n{numbers}\n"
    )


def test_a_clip_worked_by_hand(tmp_path: Path) -> None:
    clip = read_bvh(written(tmp_path, LEG))
    assert clip.joint_names == ("Hips", "Knee", "Foot")
    assert clip.joint_parents == (-1, 0, 1)
    assert clip.end_sites == {"Foot": (0.0, 0.0, 0.5)}
    assert (clip.num_frames, clip.frame_time_s) == (2, 0.04)
    positions, _ = clip.world()
    # The root's position channels replace its OFFSET of 5 5 5.
    np.testing.assert_allclose(positions[0], [[1, 2, 3], [1, 0, 3], [1, -1, 3]], atol=1e-12)
    # The hips turn by 90 degrees about Z: down becomes +X. The knee then turns about its X, and
    # the foot's Yposition channel replaces that part of its OFFSET.
    np.testing.assert_allclose(positions[1], [[1, 2, 3], [3, 2, 3], [3, 2, 0]], atol=1e-12)


@pytest.mark.parametrize("order", ["".join(o) for o in itertools.permutations("XYZ")])
def test_every_euler_order_agrees_with_scipy(tmp_path: Path, order: str) -> None:
    angles = (35.0, -70.0, 130.0)
    clip = read_bvh(written(tmp_path, single_joint(order, angles)))
    expected = Rotation.from_euler(order, angles, degrees=True).as_quat()[[3, 0, 1, 2]]
    found = clip.local_rotations()[0, 0]
    assert abs(found @ expected) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("MOTION\n", "", r"expected a MOTION block, got none in 24 lines"),
        ("HIERARCHY", "HIERACHY", r"line 1: expected HIERARCHY, got 'HIERACHY'"),
        ("JOINT Foot", "JOINT Hips", r"line 10: expected joint names that differ, got 'Hips'"),
        ("4 Yposition", "4 Wposition", r"line 13: expected one of .* 'Foot', got 'Wposition'"),
        ("3 Zrotation X", "3 Zrotation Z", r"channels that differ for joint 'Knee'"),
        ("0 -2 0", "0 two 0", r"line 8: expected a number after OFFSET, got 'two'"),
        ("0 -2 0", "0 nan 0", r"line 8: expected a number after OFFSET that is finite, got 'nan'"),
        ("CHANNELS 6", "CHANNELS 99", r"expected 0 to 6 channels for joint 'Hips', got '99'"),
        ("Frames: 2", "Frames: 3", r"expected 3 frames after 'Frames:', got 2 lines"),
        ("Frames: 2", "Frames: 1", r"expected 1 frames after 'Frames:', got 2 lines"),
        ("Frames: 2", "Frames: 99999999999", r"expected 1 to 2000000 after 'Frames:'"),
        ("Frames: 2", "Frames: -2", r"expected 1 to 2000000 after 'Frames:', got '-2'"),
        ("Frame Time: 0.04", "Frame Time: 0", r"expected 0.0001 to 10 seconds"),
        ("Frame Time: 0.04", "", r"expected 'Frame Time:', got '1 2 3"),
        ("90 0 -3", "90 0 x3", r"line 25: expected a number in frame 1, got 'x3'"),
        ("90 0 -3", "90 0", r"line 25: expected 13 numbers in frame 1, .* got 12"),
        (
            "90 0 -3",
            "90 inf -3",
            r"line 25: .*got inf in frame 1, Yrotation of joint 'Knee'",
        ),
    ],
)
def test_a_damaged_file_is_one_error_that_says_where(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    assert old in LEG
    with pytest.raises(ValueError, match=message) as caught:
        read_bvh(written(tmp_path, LEG.replace(old, new, 1)))
    assert "clip.bvh" in str(caught.value)


def test_binary_junk_is_not_a_clip(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"clip\.bvh: expected text, got binary data at byte 0"):
        read_bvh(written(tmp_path, bytes(range(255, 0, -1))))
    with pytest.raises(ValueError, match="expected text, got a NUL byte"):
        read_bvh(written(tmp_path, LEG.replace("Hips", "H\0ps")))


def test_no_file(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="no BVH file at"):
        read_bvh(tmp_path / "none.bvh")


@settings(max_examples=60)
@given(cut=st.integers(0, len(LEG) - 2))
def test_every_cut_short_file_is_an_error(
    tmp_path_factory: pytest.TempPathFactory, cut: int
) -> None:
    path = written(tmp_path_factory.mktemp("cut"), LEG[:cut])
    with pytest.raises(ValueError, match=r"clip\.bvh"):
        read_bvh(path)


def test_a_deep_hierarchy_ends_in_an_error_not_in_the_stack(tmp_path: Path) -> None:
    joints = "".join(f"JOINT j{n}\n{{\nOFFSET 0 0 0\nCHANNELS 0\n" for n in range(5000))
    with pytest.raises(ValueError, match="at most 512 joints"):
        read_bvh(written(tmp_path, LEG.replace("  JOINT Knee", joints + "JOINT Knee")))


def independent_positions(clip: BvhClip, frame: int) -> np.ndarray:
    """World positions by 4x4 matrices and SciPy, one joint after the other."""
    column = 0
    matrices: list[np.ndarray] = []
    for joint, names in enumerate(clip.channels):
        numbers = clip.values[frame, column : column + len(names)]
        column += len(names)
        local = np.eye(4)
        local[:3, 3] = clip.offsets[joint]
        order = ""
        angles: list[float] = []
        for name, number in zip(names, numbers, strict=True):
            if name.endswith("position"):
                local["XYZ".index(name[0]), 3] = number
            else:
                order, angles = order + name[0], [*angles, number]
        if order:
            local[:3, :3] = Rotation.from_euler(order, angles, degrees=True).as_matrix()
        parent = clip.joint_parents[joint]
        matrices.append(local if parent < 0 else matrices[parent] @ local)
    return np.array([matrix[:3, 3] for matrix in matrices])


@pytest.mark.realdata
def test_real_files_agree_with_an_independent_reader(realdata: Path) -> None:
    paths = sorted(realdata.glob("**/*.bvh"))
    assert paths
    for path in paths:
        clip = read_bvh(path)
        positions, rotations = clip.world()
        assert np.isfinite(rotations).all()
        for frame in (0, clip.num_frames // 2):
            expected = independent_positions(clip, frame)
            np.testing.assert_allclose(positions[frame], expected, atol=1e-9 * 400, rtol=1e-9)


def every_way_to_turn(num_frames: int = 60) -> Motion:
    """A motion whose joints turn at random, some of them to where Euler angles lock."""
    rng = np.random.default_rng(0)
    rotations = Rotation.random(num_frames * 22, random_state=rng).as_quat()[:, [3, 0, 1, 2]]
    rotations = rotations.reshape(num_frames, 22, 4)
    for joint, x_deg in ((1, 90.0), (2, -90.0), (3, 89.9999), (4, -89.999999), (5, 180.0)):
        z, y = rng.uniform(-180.0, 180.0, (2, num_frames))
        angles = np.stack([z, np.full(num_frames, x_deg), y], axis=1)
        turned = Rotation.from_euler("ZXY", angles, degrees=True).as_quat()
        rotations[:, joint] = turned[:, [3, 0, 1, 2]]
    root = np.cumsum(rng.normal(size=(num_frames, 3)), axis=0)
    return Motion("m", "p", "g", "happy", "scenario", 24.0, root, rotations)


def read_back(motion: Motion, path: Path) -> tuple[SourcePose, FloatArray]:
    """What `write_bvh` wrote, in metres, and its joints in the canonical order."""
    write_bvh(motion, path)
    source = source_pose(read_bvh(path), metres_per_unit=0.01)
    order = [source.joint_names.index(name) for name in JOINT_NAMES]
    return source, source.positions[:, order]


@pytest.mark.parametrize("emotion", ["angry", "sad"])
@pytest.mark.parametrize("action", ["simple_walk", "being_seated"])
def test_a_written_motion_is_read_back(
    tmp_path: Path, action: PerformanceAction, emotion: Emotion
) -> None:
    motion = perform(action, emotion, "p1", rng=np.random.default_rng(0))
    source, positions = read_back(motion, tmp_path / "clip.bvh")
    assert source.fps == pytest.approx(motion.fps, rel=1e-7)
    np.testing.assert_allclose(positions, motion.joint_positions(), atol=1e-6)
    # Retargeting finds joint frames from what the limbs do, the facing from hips and shoulders, and
    # flat feet from where they stand: 10 degrees of a joint and 15 cm of a place are the most that
    # costs, except at the feet of who sits on tiptoe.
    root, rotations = retarget(source, {name: name for name in JOINT_NAMES})
    cosines = np.abs((rotations * motion.joint_rotations).sum(-1)).clip(0.0, 1.0)
    others = [i for i, name in enumerate(JOINT_NAMES) if not name.endswith(("ankle", "foot"))]
    assert np.rad2deg(2.0 * np.arccos(cosines[:, others])).max() < 10.0
    found = BODY.forward_kinematics(root, rotations)[0]
    assert np.linalg.norm(found - motion.joint_positions(), axis=-1).max() < 0.15


def test_no_rotation_is_beyond_the_writer(tmp_path: Path) -> None:
    motion = every_way_to_turn()
    _, positions = read_back(motion, tmp_path / "clip.bvh")
    np.testing.assert_allclose(positions, motion.joint_positions(), atol=1e-6)


def test_written_angles_do_not_jump_by_whole_turns(tmp_path: Path) -> None:
    turns = Rotation.from_euler("Z", np.linspace(0.0, 720.0, 121)[:, None], degrees=True)
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (121, 22, 1))
    rotations[:, 0] = turns.as_quat()[:, [3, 0, 1, 2]]
    motion = Motion("m", "p", "g", "sad", "spin", 30.0, np.zeros((121, 3)), rotations)
    path = tmp_path / "clip.bvh"
    write_bvh(motion, path)
    clip = read_bvh(path)
    assert clip.channels[0][3] == "Zrotation"
    np.testing.assert_allclose(clip.values[:, 3], np.linspace(0.0, 720.0, 121), atol=1e-5)
    assert set(clip.end_sites) == {"head", "left_foot", "right_foot", "left_wrist", "right_wrist"}
    with pytest.raises(FileNotFoundError, match="none"):
        write_bvh(motion, tmp_path / "none" / "clip.bvh")


def test_a_long_clip_of_a_large_skeleton_is_read_whole(tmp_path: Path) -> None:
    path = tmp_path / "clip.bvh"
    path.write_text(rig_bvh(kdae_rig(), 2000, 125.0), encoding="utf-8")
    clip = read_bvh(path)
    assert clip.values.shape == (2000, 59 * 6)
    assert clip.num_frames * clip.frame_time_s == pytest.approx(16.0)
