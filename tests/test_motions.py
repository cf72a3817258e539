"""The behaviour m: sampling between frames, and what is refused."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from small_release import circle_motion, sway_motion

from affectsim_data.motions import EMOTIONS, Motion, emotion_label
from affectsim_data.motions.motion import Uncut
from affectsim_data.poses import standard_quaternion, yaw_quaternion
from affectsim_data.releases.rows import motion_row, read_motion

MOTION = circle_motion("circle", "sad")


def turning(degrees: list[float], *, fps: float = 1.0) -> Motion:
    """A motion whose pelvis moves 1 m a frame along +X and stands at these yaws."""
    count = len(degrees)
    rotations = np.zeros((count, 22, 4))
    rotations[..., 0] = 1.0
    rotations[:, 0] = yaw_quaternion(np.radians(degrees))
    root = np.zeros((count, 3))
    root[:, 0] = np.arange(count)
    return Motion("m", "p", "g", "happy", "turn", fps, root, rotations)


def test_emotions_are_in_label_order() -> None:
    assert EMOTIONS == ("angry", "fearful", "happy", "neutral", "sad")
    assert [emotion_label(emotion) for emotion in EMOTIONS] == [0, 1, 2, 3, 4]
    with pytest.raises(ValueError, match=r"emotion must be one of angry, .*, got 'disgust'"):
        emotion_label("disgust")


def test_sampling_at_frames_gives_the_frames() -> None:
    root, rotations = MOTION.sample(np.arange(MOTION.num_frames) / MOTION.fps)
    np.testing.assert_allclose(root, MOTION.root_translation, atol=1e-12)
    np.testing.assert_allclose(rotations, MOTION.joint_rotations, atol=2.0**-15)


@given(st.floats(-50.0, 50.0), st.integers(-3, 3))
def test_sampling_is_periodic(time_s: float, cycles: int) -> None:
    now, later = MOTION.sample([time_s]), MOTION.sample([time_s + cycles * MOTION.duration_s])
    for a, b in zip(now, later, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-6)


def test_sampling_interpolates_by_hand() -> None:
    root, rotations = turning([0.0, 90.0, 180.0]).sample([0.5, 1.25])
    np.testing.assert_allclose(root, [[0.5, 0.0, 0.0], [1.25, 0.0, 0.0]])
    np.testing.assert_allclose(rotations[:, 0], yaw_quaternion(np.radians([45.0, 112.5])))
    np.testing.assert_allclose(rotations[:, 1:], np.tile([1.0, 0, 0, 0], (2, 21, 1)))


def test_the_last_frame_leads_into_the_first_by_the_shorter_way() -> None:
    motion = turning([10.0, 180.0, 350.0], fps=2.0)
    root, rotations = motion.sample([1.25])  # half way from frame 2 to frame 0
    np.testing.assert_allclose(root, [[1.0, 0.0, 0.0]])
    assert abs(float(rotations[0, 0] @ yaw_quaternion(0.0))) == pytest.approx(1.0)


def test_an_instant_just_before_zero_is_the_end_of_the_cycle() -> None:
    root, _ = turning([0.0, 0.0, 0.0]).sample([-1e-18, -1e-9])
    np.testing.assert_allclose(root[:, 0], 0.0, atol=1e-6)


def test_duration_counts_the_step_back_to_the_first_frame() -> None:
    assert turning([0.0, 1.0, 2.0], fps=2.0).duration_s == 1.5


def test_joint_positions_start_over_the_origin() -> None:
    positions = sway_motion("sway", "happy").joint_positions()
    assert positions.shape == (60, 22, 3)
    np.testing.assert_allclose(positions[0, 0], [0.0, 0.95, 0.0], atol=2.0**-16)


def test_rounding_is_what_shards_hold_and_happens_once() -> None:
    motion = dataclasses.replace(
        turning([0.0, 200.0]), root_translation=np.array([[1 / 3, 0, 0], [0, 1 / 7, 0]])
    )
    once = motion.rounded()
    assert once.root_translation[0, 0] == round(2**16 / 3) / 2**16
    for array in (once.root_translation, once.joint_rotations):
        np.testing.assert_array_equal(array, array.astype(np.float32))
    assert (once.joint_rotations[..., 0] >= 0.0).all()
    twice = once.rounded()
    np.testing.assert_array_equal(once.root_translation, twice.root_translation)
    np.testing.assert_array_equal(once.joint_rotations, twice.joint_rotations)


def test_rounding_adds_hardly_any_jerk_to_the_root() -> None:
    time_s = np.arange(300) / 30.0
    root = np.stack([0.3 * np.sin(time_s), 0.9 + 0.01 * np.cos(time_s), 1.4 * time_s], axis=1)
    motion = Motion("m", "p", "g", "happy", "any", 30.0, root, turning([0.0] * 300).joint_rotations)
    added = np.diff(motion.rounded().root_translation - root, 3, axis=0) * 30.0**3
    assert 0.3 < np.sqrt(np.mean(added**2)) < 0.7  # m/s^3 along each axis; walking hands have 60


@given(st.integers(0, 2**32 - 1))
def test_rounding_moves_no_joint_by_a_third_of_a_millimetre(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rotations = standard_quaternion(rng.normal(size=(2, 22, 4)))
    root = rng.uniform(-3.0, 3.0, (2, 3))
    motion = Motion("m", "p", "g", "happy", "any", 30.0, root, rotations)
    moved = motion.rounded().joint_positions() - motion.joint_positions()
    assert np.linalg.norm(moved, axis=-1).max() < 3e-4


def kept(before: int, start: int, stop: int, count: int) -> Uncut:
    rotations = np.zeros((count, 22, 4))
    rotations[..., 0] = 1.0
    return Uncut(before, start, stop, np.arange(3.0 * count).reshape(count, 3), rotations)


def test_the_original_is_what_was_kept_between_what_was_cut_off() -> None:
    loop = {"note": "looped"}
    cycle = dataclasses.replace(
        turning([0.0] * 6),
        uncut=kept(1, 2, 4, 3),
        provenance={"loop": loop, "fps": 30},
        source="looped",
    )
    original = cycle.original()
    np.testing.assert_array_equal(original.root_translation[:, 0], [0.0, 2.0, 3.0, 3.0, 6.0])
    assert original.joint_rotations.shape == (5, 22, 4)
    assert (original.source, original.provenance, original.uncut) == ("", {"fps": 30}, None)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ((4, 0, 2, 3), "expected 0 <= before <= 3 and 0 <= start <= stop, got before 4"),
        ((0, 2, 1, 3), "expected 0 <= before <= 3 .* start 2, stop 1"),
        ((0, 0, 61, 3), "motion 'circle': original frames must be within the 60 .*, got stop 61"),
    ],
)
def test_an_original_that_cannot_be_is_refused(
    numbers: tuple[int, int, int, int], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(MOTION, uncut=kept(*numbers))


def test_frames_of_the_original_must_have_their_shapes() -> None:
    with pytest.raises(ValueError, match=r"must be \(n, 3\) and \(n, 22, 4\), got \(2, 3\)"):
        Uncut(0, 0, 1, np.zeros((2, 3)), np.zeros((2, 24, 4)))


def test_a_row_gives_back_motion_provenance_and_original() -> None:
    looped = dataclasses.replace(
        MOTION, uncut=kept(1, 0, 50, 4), provenance={"fps": 120.0, "a": [1]}
    )
    for motion in (MOTION.rounded(), looped.rounded()):
        back = read_motion(motion_row(motion), "row 3")
        assert back.provenance == motion.provenance
        found, expected = back.original(), motion.original()
        np.testing.assert_array_equal(found.root_translation, expected.root_translation)
        np.testing.assert_array_equal(found.joint_rotations, expected.joint_rotations)
        assert motion_row(back) == motion_row(motion)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"provenance": "{"}, "row 3: provenance must be JSON, got '{'"),
        ({"provenance": "[1]"}, r"row 3: provenance must be a JSON object, got '\[1\]'"),
        ({"kept_start": 7, "kept_stop": 6}, "row 3: original frames: expected .* start 7, stop 6"),
        (
            {"original_root_translation_shape": [9, 3]},
            "row 3: original_root_translation with shape",
        ),
    ],
)
def test_bad_rows_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    row = motion_row(MOTION) | changes
    with pytest.raises(ValueError, match=message):
        read_motion(row, "row 3")


def _with(frame: int, joint: int | None, value: float) -> dict[str, Any]:
    if joint is None:
        root = MOTION.root_translation.copy()
        root[frame] = value
        return {"root_translation": root}
    rotations = MOTION.joint_rotations.copy()
    rotations[frame, joint] = value
    return {"joint_rotations": rotations}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"emotion": "joy"}, "motion 'circle': emotion must be one of angry, .* got 'joy'"),
        ({"fps": 0.0}, "motion 'circle': fps must be positive and finite, got 0"),
        ({"fps": math.inf}, "motion 'circle': fps must be positive and finite, got inf"),
        ({"fps": math.nan}, "motion 'circle': fps must be positive and finite, got nan"),
        (
            {"root_translation": np.zeros((60, 2))},
            r"root_translation must be \(num_frames >= 2, 3\), got \(60, 2\)",
        ),
        (
            {"root_translation": np.zeros((1, 3)), "joint_rotations": np.zeros((1, 22, 4))},
            r"root_translation must be \(num_frames >= 2, 3\), got \(1, 3\)",
        ),
        (
            {"joint_rotations": np.zeros((60, 24, 4))},
            r"joint_rotations must be \(60, 22, 4\), got \(60, 24, 4\)",
        ),
        (_with(7, None, np.nan), "root_translation must be finite, .* 1 of 60 frames, .* frame 7"),
        (_with(3, 5, np.inf), "joint_rotations must be finite, .* 1 of 60 frames, .* frame 3"),
        (_with(9, 4, 1.0), "unit quaternions, got norm 2.0000 in frame 9, joint 4"),
    ],
)
def test_bad_motions_are_refused_by_name(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(MOTION, **changes)


def test_motions_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        MOTION.emotion = "happy"  # type: ignore[misc]  # the point of the test
