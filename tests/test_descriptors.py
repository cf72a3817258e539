"""Kinematic descriptors: laws, cases worked by hand, and derivatives against splines."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike
from scipy.interpolate import make_interp_spline

from affectsim_data.content import content_path
from affectsim_data.motions import Motion
from affectsim_data.motions.bvh import read_bvh
from affectsim_data.motions.derivatives import differentiate, smooth_over
from affectsim_data.motions.descriptors import (
    MAIN_DESCRIPTORS,
    PARTS,
    descriptor_table,
    kinematic_descriptors,
    walk_kinematics,
)
from affectsim_data.motions.posture import SEGMENT_MASSES, facing, segment_centers
from affectsim_data.motions.retargeting import retarget, source_pose
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_multiply,
    quaternion_rotate,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES, NUM_JOINTS

X, Y, Z = np.eye(3)
OTHER = {"left": "right", "right": "left"}
DOCS = Path(__file__).parents[1] / "docs" / "descriptors.md"


def place(name: str) -> int:
    return JOINT_NAMES.index(name)


def turn(axis: FloatArray, angle: ArrayLike) -> FloatArray:
    return axis_angle_quaternion(axis, np.asarray(angle, np.float64))


def pose_motion(
    turns: dict[str, FloatArray], *, num_frames: int, fps: float, root: FloatArray | None = None
) -> Motion:
    """The T-pose, joints turned as said, standing unless the root goes somewhere."""
    rotations = np.tile([1.0, 0.0, 0.0, 0.0], (num_frames, NUM_JOINTS, 1))
    for name, rotation in turns.items():
        rotations[:, place(name)] = rotation
    if root is None:
        root = np.tile([0.0, BODY.hip_height, 0.0], (num_frames, 1))
    return Motion("m", "p", "g", "happy", "test", fps, root, rotations)


def wavy_motion(seed: int = 3, *, fps: float = 30.0, seconds: float = 4.0) -> Motion:
    """All joints sway smoothly at 0.25 to 0.75 Hz: a closed cycle, the same curve at any rate."""
    rng = np.random.default_rng(seed)
    phase = 2.0 * np.pi * np.arange(round(seconds * fps)) / round(seconds * fps)
    waves = np.stack([wave(k * phase) for k in (1, 2, 3) for wave in (np.sin, np.cos)])
    bends = np.einsum("kf,kja->fja", waves, rng.normal(0.0, 0.12, (6, NUM_JOINTS, 3)))
    angles = np.linalg.norm(bends, axis=-1)
    rotations = axis_angle_quaternion(bends / angles[..., None], angles)
    root = np.einsum("kf,ka->fa", waves, rng.normal(0.0, 0.05, (6, 3))) + 0.9 * Y
    return Motion("wavy", "p", "g", "sad", "test", fps, root, rotations)


def walk_motion(
    *,
    speed: float = 1.2,
    stride_hz: float = 0.9,
    seconds: float = 10.0,
    fps: float = 30.0,
    radius_m: float | None = None,
) -> Motion:
    """Legs like scissors, arms hanging and swinging by 20 degrees, a bounce of 4 cm."""
    time = np.arange(round(seconds * fps)) / fps
    swing = np.sin(2.0 * np.pi * stride_hz * time)
    way = speed * time
    heading = np.zeros_like(time) if radius_m is None else way / radius_m
    root = np.stack([0.0 * way, 0.9 + 0.02 * np.cos(4.0 * np.pi * stride_hz * time), way], axis=1)
    if radius_m is not None:
        root[:, 0] = radius_m * (1.0 - np.cos(heading))
        root[:, 2] = radius_m * np.sin(heading)
    arm = np.deg2rad(20.0) * swing
    turns = {
        "pelvis": yaw_quaternion(heading),
        "left_hip": turn(X, -0.4 * swing),
        "right_hip": turn(X, 0.4 * swing),
        "left_shoulder": quaternion_multiply(turn(X, arm), turn(Z, -np.pi / 2.0)),
        "right_shoulder": quaternion_multiply(turn(X, -arm), turn(Z, np.pi / 2.0)),
    }
    return pose_motion(turns, num_frames=len(time), fps=fps, root=root)


def moved(motion: Motion, yaw: float, shift: FloatArray) -> Motion:
    rotations = motion.joint_rotations.copy()
    rotations[:, 0] = quaternion_multiply(yaw_quaternion(yaw), rotations[:, 0])
    root = quaternion_rotate(yaw_quaternion(yaw), motion.root_translation) + shift
    return dataclasses.replace(motion, root_translation=root, joint_rotations=rotations)


def mirrored(motion: Motion) -> Motion:
    sides = [name.partition("_") for name in JOINT_NAMES]
    order = [place(OTHER.get(side, side) + rest + part) for side, rest, part in sides]
    rotations = motion.joint_rotations[:, order] * [1.0, 1.0, -1.0, -1.0]
    root = motion.root_translation * [-1.0, 1.0, 1.0]
    return dataclasses.replace(motion, root_translation=root, joint_rotations=rotations)


def assert_close(
    found: dict[str, float], expected: dict[str, float], *, rtol: float = 1e-6, atol: float = 1e-7
) -> None:
    assert found.keys() == expected.keys()
    wrong = {
        name: (found[name], expected[name])
        for name in found
        if not np.isclose(found[name], expected[name], rtol=rtol, atol=atol)
    }
    assert not wrong


@pytest.mark.parametrize(("yaw", "shift"), [(0.0, [3.0, 0.0, -2.0]), (2.0, [0.0, 0.0, 0.0])])
def test_place_and_heading_do_not_matter(yaw: float, shift: list[float]) -> None:
    motion = wavy_motion()
    found = kinematic_descriptors(moved(motion, yaw, np.array(shift)))
    expected = kinematic_descriptors(motion)
    # A footprint of all frames is the same, but its hull is found in another order.
    assert_close(found, expected, rtol=1e-5, atol=1e-6)


def test_mirror_swaps_left_and_right() -> None:
    motion = wavy_motion()
    expected = kinematic_descriptors(motion)
    swapped = {}
    for name, value in expected.items():
        side, _, rest = name.partition("_")
        swapped["_".join(filter(None, (OTHER.get(side, side), rest)))] = value
    found = kinematic_descriptors(mirrored(motion))
    assert_close(found, swapped)
    assert found["left_hand_jerk_mean_m_s3"] != pytest.approx(expected["left_hand_jerk_mean_m_s3"])


def test_a_motion_played_twice_as_fast() -> None:
    slow = wavy_motion(seconds=16.0)  # so slow that the low-pass leaves both alone
    fast = dataclasses.replace(slow, fps=2.0 * slow.fps)
    before, after = kinematic_descriptors(slow), kinematic_descriptors(fast)
    powers = {
        "angular_speed_": 2.0,
        "angular_acceleration_": 4.0,
        "_speed_": 2.0,
        "_acceleration_": 4.0,
        "_jerk_mean": 8.0,
        "_jerk_max": 8.0,
        "quantity_of_motion_mean": 2.0,
        "_path_length": 1.0,
        "dimensionless_jerk": 1.0,
    }
    for key, factor in powers.items():
        names = [name for name in before if key in name]
        assert names
        for name in names:
            assert after[name] == pytest.approx(factor * before[name], rel=1e-2), name


def test_who_stands_still_does_not_move() -> None:
    turns = {"left_elbow": turn(Z, 1.0), "spine1": turn(X, 0.2)}
    found = kinematic_descriptors(pose_motion(turns, num_frames=60, fps=30.0))
    moving = [
        name
        for name in found
        if any(key in name for key in ("speed", "acceleration", "jerk", "path", "quantity", "mad"))
    ]
    assert len(moving) > 130
    assert max(found[name] for name in moving) < 1e-9
    assert found["bounce_m"] == found["dimensionality"] == found["hand_asymmetry"] == 0.0
    assert found["elbow_flexion_mean_deg"] == pytest.approx(np.rad2deg(1.0) / 2.0)


def test_a_hand_on_a_circle() -> None:
    """The forearm points sideways from the axis of the upper arm, which spins once a second."""
    spin = 2.0 * np.pi * np.arange(60) / 30.0
    turns = {"left_shoulder": turn(X, spin), "left_elbow": turn(Z, np.pi / 2.0)}
    found = kinematic_descriptors(pose_motion(turns, num_frames=60, fps=30.0))
    radius, rate = 0.25, 2.0 * np.pi
    left = 1.0 / (1.0 + (1.0 / 5.0) ** 4)  # what the low-pass leaves at 1 Hz
    for order, name in enumerate(("speed_mean_m_s", "acceleration_mean_m_s2", "jerk_mean_m_s3"), 1):
        assert found[f"left_hand_{name}"] == pytest.approx(left * radius * rate**order)
        assert found[f"hands_{name}"] == pytest.approx(0.5 * left * radius * rate**order)
        assert found[f"right_hand_{name}"] == pytest.approx(0.0, abs=1e-9)
    assert found["left_hand_angular_speed_mean_rad_s"] == pytest.approx(left * rate)
    assert found["left_hand_angular_acceleration_max_rad_s2"] == pytest.approx(0.0, abs=1e-9)
    assert found["left_hand_path_length_m"] == pytest.approx(left * 2.0 * 2.0 * np.pi * radius)
    # j = r w^3, v = r w, two seconds: D^4 j^2 / v^2 = D^4 w^4.
    assert found["left_hand_dimensionless_jerk"] == pytest.approx(16.0 * rate**4)
    assert found["dimensionality"] == pytest.approx(2.0)
    assert found["hand_asymmetry"] == pytest.approx(1.0)


def test_distances_and_angles_of_a_pose() -> None:
    # Elbows at 0.48 m to the side and forearms of 0.25 m: wrists 0.6 m apart.
    fold = float(np.arccos((0.30 - 0.48) / 0.25))
    turns = {
        "left_elbow": turn(Z, fold),
        "right_elbow": turn(Z, -fold),
        "pelvis": turn(X, np.deg2rad(10.0)),
        "neck": turn(X, np.deg2rad(25.0)),
        "left_knee": turn(X, np.deg2rad(40.0)),
    }
    found = kinematic_descriptors(pose_motion(turns, num_frames=20, fps=30.0))
    assert found["hand_span_mean"] == pytest.approx(0.6 / 1.70)
    assert found["elbow_flexion_mean_deg"] == pytest.approx(np.rad2deg(fold))
    assert found["knee_flexion_mean_deg"] == pytest.approx(20.0)
    assert found["trunk_pitch_mean_deg"] == pytest.approx(10.0)
    assert found["neck_pitch_mean_deg"] == pytest.approx(35.0)
    assert found["head_angle_vertical_mean_deg"] == pytest.approx(35.0)
    assert found["head_angle_back_mean_deg"] == pytest.approx(25.0)


def test_extent_of_the_rest_pose() -> None:
    found = kinematic_descriptors(pose_motion({}, num_frames=20, fps=30.0))
    rest = BODY.rest_positions
    width, height, depth = np.ptp(rest, axis=0)
    assert found["bounding_box_mean_m3"] == pytest.approx(width * height * depth)
    ends = [place(f"{side}_{end}") for side in ("left", "right") for end in ("wrist", "foot")]
    away = np.linalg.norm(rest[ends] - rest[place("head")], axis=1).mean()
    assert found["limb_contraction_mean_m"] == pytest.approx(away)
    # From above: a kite with the wrists and toes as corners; wrists lie on z = 0.
    wrist, toe, depth = 0.73, 0.09, 0.13
    assert found["convex_hull_2d_mean_m2"] == pytest.approx((wrist + toe) * depth)
    assert found["convex_hull_2d_global_m2"] == pytest.approx((wrist + toe) * depth)
    assert 0.0 < found["convex_hull_3d_mean_m3"] < found["bounding_box_mean_m3"]


def test_center_of_mass_lies_where_anatomy_says() -> None:
    assert SEGMENT_MASSES.sum() == pytest.approx(1.0)
    arms_down = {"left_shoulder": turn(Z, -1.5), "right_shoulder": turn(Z, 1.5)}
    positions = pose_motion(arms_down, num_frames=8, fps=30.0).joint_positions()
    center = np.einsum("s,fsk->fk", SEGMENT_MASSES, segment_centers(positions))[0]
    assert center[0] == pytest.approx(0.0, abs=1e-12)
    assert 0.53 < center[1] / 1.70 < 0.58  # 0.55 to 0.57 of stature in people who stand


def test_facing_follows_the_heading() -> None:
    motion = moved(pose_motion({}, num_frames=8, fps=30.0), 0.7, np.zeros(3))
    expected = [np.sin(0.7), 0.0, np.cos(0.7)]
    np.testing.assert_allclose(facing(motion.joint_positions())[0], expected, atol=1e-12)


@pytest.mark.parametrize("cyclic", [True, False])
def test_derivatives_agree_with_splines(cyclic: bool) -> None:
    """A spline of degree 9 through a dense curve of up to 1 Hz; the low-pass opened wide."""
    fps, seconds = 60.0, 6.0
    rng = np.random.default_rng(0)
    time = np.arange(round(fps * seconds)) / fps
    rates = np.arange(1, 7) / seconds
    sines = np.sin(2.0 * np.pi * rates * time[:, None] + rng.uniform(0.0, 6.0, 6))
    curve = sines @ rng.normal(0.0, 1.0, (6, 2))
    if not cyclic:
        curve = curve + time[:, None] * [0.5, -1.0]
    spline = make_interp_spline(time, curve, k=9)
    inner = slice(90, -90)
    for order, found in enumerate(
        differentiate(curve, fps, (1, 2, 3), cyclic=cyclic, cutoff_hz=60.0), start=1
    ):
        expected = spline(time, order)
        error = np.abs(found - expected)[inner].max()
        assert error < (1e-4 if cyclic else 2e-2) * np.abs(expected).max(), order


@pytest.mark.parametrize(("hz", "share"), [(0.5, 1.0), (5.0, 0.5), (14.0, 0.016)])
def test_low_pass_keeps_movement_and_drops_jitter(hz: float, share: float) -> None:
    time = np.arange(120) / 30.0
    (smooth,) = differentiate(np.sin(2.0 * np.pi * hz * time), 30.0, (0,))
    assert np.sqrt(2.0) * smooth.std() == pytest.approx(share, rel=0.02)


def test_open_clips_keep_their_ends() -> None:
    time = np.arange(90) / 30.0
    line = np.stack([2.0 * time, 1.0 - time], axis=1)
    smooth, velocity, acceleration = differentiate(line, 30.0, (0, 1, 2), cyclic=False)
    np.testing.assert_allclose(smooth, line, atol=1e-12)
    np.testing.assert_allclose(velocity, np.tile([2.0, -1.0], (90, 1)), atol=1e-12)
    np.testing.assert_allclose(acceleration, 0.0, atol=1e-10)


def test_running_mean_removes_what_repeats() -> None:
    time = np.arange(240) / 30.0
    sway = np.sin(2.0 * np.pi * time / 0.7)
    drift = 1.3 * time
    mean = smooth_over(drift + sway, 30.0, 0.7, cyclic=False)
    np.testing.assert_allclose(mean[30:-30], drift[30:-30], atol=0.02)


def test_rate_hardly_matters() -> None:
    slow, fast = (kinematic_descriptors(wavy_motion(fps=fps)) for fps in (30.0, 120.0))
    for name in MAIN_DESCRIPTORS:
        assert fast[name] == pytest.approx(slow[name], rel=0.02), name


def test_gait_of_a_walk_worked_by_hand() -> None:
    gait = walk_kinematics(walk_motion(), cyclic=False)
    assert gait.speed_m_s == pytest.approx(1.2, rel=0.005)
    assert gait.cadence_steps_min == pytest.approx(108.0, rel=0.01)
    assert gait.stride_m == pytest.approx(1.2 / 0.9, rel=0.01)
    assert gait.bounce_m == pytest.approx(0.04, rel=0.03)
    assert gait.hand_swing_m == pytest.approx(2.0 * 0.55 * np.sin(np.deg2rad(20.0)), rel=0.02)
    assert gait.elbow_flexion_deg == pytest.approx(0.0, abs=1e-6)
    assert gait.trunk_pitch_deg == pytest.approx(0.0, abs=0.1)
    assert gait.neck_pitch_deg == pytest.approx(0.0, abs=0.1)
    phase = np.linspace(0.0, 2.0 * np.pi, 1000)
    ahead = 2.0 * 0.55 * np.sin(np.deg2rad(20.0) * np.sin(phase))
    assert gait.hand_span == pytest.approx(np.hypot(0.36, ahead).mean() / 1.70, rel=0.01)


def test_gait_on_a_round_is_that_of_the_straight() -> None:
    straight = walk_kinematics(walk_motion(), cyclic=False)
    # One round of 12 m in 10 s; the cycle closes after 9 strides.
    round_walk = walk_motion(radius_m=12.0 / (2.0 * np.pi))
    found = dataclasses.asdict(walk_kinematics(round_walk))
    for name, expected in dataclasses.asdict(straight).items():
        # Hands that swing while the body turns have a little more jerk.
        relative = 0.2 if name == "hand_jerk_m_s3" else 0.02
        absolute = 0.2 if name.endswith("_deg") else 1e-3
        assert found[name] == pytest.approx(expected, rel=relative, abs=absolute), name


def test_pauses_and_turns_do_not_count() -> None:
    """Walk, stand for four seconds, turn about, walk back."""
    out = walk_motion(seconds=5.0)
    back = moved(out, np.pi, np.array([0.0, 0.0, 6.0]))
    root, rotations = out.root_translation, out.joint_rotations
    steady = [np.repeat(values[-1:], 120, axis=0) for values in (root, rotations)]
    whole = dataclasses.replace(
        out,
        root_translation=np.concatenate([root, steady[0], back.root_translation]),
        joint_rotations=np.concatenate([rotations, steady[1], back.joint_rotations]),
    )
    gait = walk_kinematics(whole, cyclic=False)
    assert gait.speed_m_s == pytest.approx(1.2, rel=0.1)
    assert gait.cadence_steps_min == pytest.approx(108.0, rel=0.06)
    assert gait.hand_swing_m == pytest.approx(0.376, rel=0.05)


def test_table_has_a_row_per_motion() -> None:
    motions = [wavy_motion(1), dataclasses.replace(wavy_motion(2), performance="mourn")]
    table = descriptor_table(motions)
    assert table.num_rows == 2
    assert table.column("performance").to_pylist() == ["", "mourn"]
    assert table.column("duration_s").to_pylist() == [4.0, 4.0]
    expected = kinematic_descriptors(motions[1])
    assert {name: table.column(name)[1].as_py() for name in expected} == expected
    with pytest.raises(ValueError, match="at least one motion, got none"):
        descriptor_table([])


def test_bad_motions_are_named() -> None:
    short = pose_motion({}, num_frames=5, fps=30.0)
    with pytest.raises(ValueError, match=r"motion 'm': descriptors need at least 8 frames, got 5"):
        kinematic_descriptors(short)
    with pytest.raises(ValueError, match=r"expected a cycle, got 11\.96 m .* cyclic=False"):
        walk_kinematics(walk_motion())
    with pytest.raises(ValueError, match=r"'m' \(test\): expected a walk of at least 0\.1 m/s"):
        walk_kinematics(pose_motion({}, num_frames=60, fps=30.0))
    with pytest.raises(ValueError, match="nan or inf in 2 of 9 frames, first in frame 3"):
        differentiate(np.array([0.0, 0, 0, np.nan, 0, 0, 0, np.inf, 0]), 30.0)


def test_every_descriptor_is_documented() -> None:
    text = DOCS.read_text(encoding="utf-8")
    names = list(kinematic_descriptors(wavy_motion()))
    assert set(MAIN_DESCRIPTORS) <= set(names)
    for name in names:
        part = next((p for p in sorted(PARTS, key=len, reverse=True) if name.startswith(p)), "")
        feature = name.removeprefix(f"{part}_") if part else name
        for statistic in ("_mean", "_max", "_mad"):
            feature = feature.partition(statistic)[0]
        stems = (f"`{name}`", f"`{feature}`", f"`PART_{feature}`", f"`{part}_{feature}`")
        assert any(stem in text for stem in stems), name
    for field in dataclasses.fields(walk_kinematics(walk_motion(), cyclic=False)):
        assert f"`{field.name}`" in text


def real_clip(realdata: Path, name: str) -> Motion:
    """A clip of Bandai-Namco's data set 1 on the canonical body, open as it was captured."""
    recipe = tomllib.loads(content_path("builders", "bandai_namco.toml").read_text("utf-8"))
    path = realdata / "bandai_namco" / "dataset-1" / f"dataset-1_{name}_001.bvh"
    source = source_pose(read_bvh(path), metres_per_unit=0.01)
    root, rotations = retarget(source, recipe["joints"])
    return Motion(name, "p", "g", "happy", name, source.fps, root, rotations)


@pytest.mark.realdata
def test_real_walks_measure_as_documented(realdata: Path) -> None:
    """docs/descriptors.md: speed, cadence, stride, bounce, trunk and neck pitch, by style."""
    documented = {
        "normal": (1.30, 111, 1.41, 0.035, -1.2, -9.4),
        "angry": (1.96, 151, 1.56, 0.058, 13.6, 11.9),
        "happy": (1.42, 118, 1.44, 0.106, 3.0, -10.9),
        "sad": (0.62, 73, 1.03, 0.015, 0.5, 6.1),
        "not-confident": (0.48, 82, 0.71, 0.012, 12.9, 26.0),
    }
    for style, expected in documented.items():
        gait = walk_kinematics(real_clip(realdata, f"walk_{style}"), cyclic=False)
        found = (gait.speed_m_s, gait.cadence_steps_min, gait.stride_m, gait.bounce_m)
        np.testing.assert_allclose(found, expected[:4], rtol=0.05, err_msg=style)
        pitches = (gait.trunk_pitch_deg, gait.neck_pitch_deg)
        np.testing.assert_allclose(pitches, expected[4:], atol=0.5, err_msg=style)


@pytest.mark.realdata
def test_hand_jerk_of_real_gestures_lies_in_the_measured_ranges(realdata: Path) -> None:
    ranges = {"angry": (40, 400), "happy": (18, 57), "normal": (11, 47), "sad": (2, 3.5)}
    for style, (low, high) in (ranges | {"not-confident": (2, 37)}).items():
        for action in ("bye", "guide"):
            clip = real_clip(realdata, f"{action}_{style}")
            jerk = kinematic_descriptors(clip, cyclic=False)["hands_jerk_mean_m_s3"]
            assert low <= jerk <= high, (style, action)
