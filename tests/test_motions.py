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
from affectsim_data.poses import yaw_quaternion

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
    np.testing.assert_allclose(rotations, MOTION.joint_rotations, atol=1e-7)


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
    np.testing.assert_allclose(positions[0, 0], [0.0, 0.95, 0.0], atol=1e-6)


def test_rounding_is_what_float32_shards_hold_and_happens_once() -> None:
    motion = dataclasses.replace(
        turning([0.0, 200.0]), root_translation=np.array([[1 / 3, 0, 0], [0, 1 / 7, 0]])
    )
    once = motion.rounded()
    assert once.root_translation[0, 0] == float(np.float32(1 / 3))
    assert (once.joint_rotations[..., 0] >= 0.0).all()
    twice = once.rounded()
    np.testing.assert_array_equal(once.root_translation, twice.root_translation)
    np.testing.assert_allclose(once.joint_rotations, twice.joint_rotations, atol=6e-8)


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
