"""Pinhole cameras: by hand, and against OpenCV and the OpenGL projection."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import cv2
import numpy as np
import pytest

from affectsim_data.cameras import Camera, CameraTrajectory, to_opencv
from affectsim_data.poses import compose_pose, invert_pose, look_at, yaw_quaternion

CAMERA = Camera(width=200, height=100, hfov=math.radians(90.0))


def random_points(count: int) -> np.ndarray:
    """Points in front of a camera, in its frame, `(count, 3)`."""
    rng = np.random.default_rng(5)
    return rng.uniform([-3.0, -3.0, -9.0], [3.0, 3.0, -0.5], (count, 3))


def test_intrinsics_by_hand() -> None:
    # 90 degrees over 200 pixels: the focal length is half the width.
    np.testing.assert_allclose(CAMERA.intrinsics, [[100, 0, 100], [0, 100, 50], [0, 0, 1]])
    assert math.isclose(CAMERA.vfov, 2.0 * math.atan(0.5))


@pytest.mark.parametrize(
    ("point", "pixel"),
    [
        ((0.0, 0.0, -2.0), (100.0, 50.0)),  # straight ahead: the middle of the image
        ((1.0, 0.0, -2.0), (150.0, 50.0)),  # right of it: larger u
        ((0.0, 0.5, -2.0), (100.0, 25.0)),  # above it: smaller v
        ((-2.0, 1.0, -2.0), (0.0, 0.0)),  # the top left corner
    ],
)
def test_project_by_hand(point: tuple[float, ...], pixel: tuple[float, ...]) -> None:
    pixels, depth = CAMERA.project(point)
    np.testing.assert_allclose(pixels, pixel, atol=1e-12)
    assert float(depth) == 2.0


def test_points_behind_the_camera_have_no_pixel() -> None:
    pixels, depth = CAMERA.project([[0.0, 0.0, 1.0], [1.0, 1.0, 0.0]])
    assert np.isnan(pixels).all()
    assert (depth <= 0.0).all()


def test_projection_agrees_with_opencv() -> None:
    points = random_points(50)
    T_world_camera = look_at([3.0, 1.2, 4.0], [0.0, 1.0, 0.5])
    points_world = points @ T_world_camera[:3, :3].T + T_world_camera[:3, 3]
    T_cv_world = invert_pose(to_opencv(T_world_camera))
    turn, _ = cv2.Rodrigues(T_cv_world[:3, :3])
    expected, _ = cv2.projectPoints(
        points_world, turn, T_cv_world[:3, 3], CAMERA.intrinsics, np.zeros(5)
    )
    np.testing.assert_allclose(CAMERA.project(points)[0], expected[:, 0], atol=1e-6)


def test_to_opencv_twice_is_the_same_pose() -> None:
    pose = look_at([1.0, 2.0, 3.0], [0.0, 0.0, 0.0])
    np.testing.assert_allclose(to_opencv(to_opencv(pose)), pose)
    # OpenCV's third axis looks along the view, its second down.
    np.testing.assert_allclose(to_opencv(pose)[:3, 2], -pose[:3, 2])
    np.testing.assert_allclose(to_opencv(pose)[:3, 1], -pose[:3, 1])


def test_projection_matrix_draws_where_project_says() -> None:
    points = random_points(50)
    clip = np.c_[points, np.ones(50)] @ CAMERA.projection_matrix(near=0.05, far=50.0).T
    cube = clip[:, :3] / clip[:, 3:]
    pixels, depth = CAMERA.project(points)
    np.testing.assert_allclose((cube[:, 0] + 1.0) * 100.0, pixels[:, 0], atol=1e-9)
    np.testing.assert_allclose((1.0 - cube[:, 1]) * 50.0, pixels[:, 1], atol=1e-9)
    np.testing.assert_allclose(clip[:, 3], depth)


def test_projection_matrix_maps_near_and_far_to_the_cube() -> None:
    matrix = CAMERA.projection_matrix(near=0.1, far=20.0)
    near, far = matrix @ [0.0, 0.0, -0.1, 1.0], matrix @ [0.0, 0.0, -20.0, 1.0]
    assert near[2] / near[3] == pytest.approx(-1.0)
    assert far[2] / far[3] == pytest.approx(1.0)


def test_sees_what_is_in_the_image_and_nothing_behind() -> None:
    pose = compose_pose(yaw_quaternion(0.0), [0.0, 0.0, 0.0])
    points = np.array(
        [
            [0.0, 0.0, -2.0],
            [-1.999, 0.999, -2.0],  # just inside the top left corner
            [2.001, 0.0, -2.0],  # just right of the image
            [0.0, 1.01, -2.0],
            [0.0, 0.0, 2.0],
        ]
    )
    np.testing.assert_array_equal(CAMERA.sees(points, pose), [True, True, False, False, False])


def test_sees_turns_with_the_camera() -> None:
    poses = compose_pose(yaw_quaternion(np.array([0.0, math.pi / 2.0, math.pi])), np.zeros(3))
    # Yaw 90 degrees looks along -X, as robots do.
    points = np.array([[0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_array_equal(
        CAMERA.sees(points + np.array([0.0, 0.01, 0.0]), poses), np.eye(3) > 0
    )


def test_resized_keeps_the_horizontal_field_of_view() -> None:
    small = CAMERA.resized(width=100, height=100)
    assert (small.width, small.height, small.hfov) == (100, 100, CAMERA.hfov)


def test_json_round_trip() -> None:
    camera = Camera(width=224, height=224, hfov=math.radians(60.0))
    fields = camera.to_json()
    assert fields == {"width": 224, "height": 224, "hfov_deg": 60.0}
    assert Camera.from_json(fields).to_json() == fields


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"width": 0}, r"camera width must be 1 to 8192 pixels, got 0"),
        ({"height": 100_000}, r"camera height must be 1 to 8192 pixels, got 100000"),
        ({"width": 2.5}, r"camera width must be 1 to 8192 pixels, got 2\.5"),
        ({"hfov": 0.0}, r"hfov must be between 0 and 180 degrees, got 0"),
        ({"hfov": math.pi}, r"hfov must be between 0 and 180 degrees, got 180"),
        ({"hfov": math.nan}, r"hfov must be between 0 and 180 degrees, got nan"),
    ],
)
def test_bad_cameras_are_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        dataclasses.replace(CAMERA, **fields)


def test_json_with_half_a_pixel_is_refused() -> None:
    with pytest.raises(ValueError, match=r"camera width must be .* got 224\.5"):
        Camera.from_json({"width": 224.5, "height": 224, "hfov_deg": 60.0})


def test_cameras_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        CAMERA.width = 3  # type: ignore[misc]  # the point of the test


def test_still_trajectories_are_still() -> None:
    still = CameraTrajectory.still(np.eye(4), num_frames=3)
    assert len(still) == 3
    assert still.is_still
    moved = still.T_world_camera.copy()
    moved[2, 0, 3] = 1e-9
    assert not CameraTrajectory(moved).is_still


@pytest.mark.parametrize("shape", [(4, 4), (0, 4, 4), (3, 3, 4)])
def test_trajectories_of_a_wrong_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ValueError, match=r"T_world_camera must be \(num_frames, 4, 4\), got"):
        CameraTrajectory(np.zeros(shape))


def test_trajectories_must_be_finite() -> None:
    poses = np.tile(np.eye(4), (2, 1, 1))
    poses[1, 0, 3] = np.nan
    with pytest.raises(ValueError, match="T_world_camera must be finite"):
        CameraTrajectory(poses)
