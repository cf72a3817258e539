"""Quaternions and rigid transforms: group laws, SciPy as the other implementation, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from scipy.spatial.transform import Rotation, Slerp

from affectsim_data import poses
from affectsim_data.poses import FloatArray

_floats = st.floats(-1.0, 1.0, width=32)
quaternions = (
    hnp.arrays(np.float64, 4, elements=_floats)
    .filter(lambda q: bool(np.linalg.norm(q) > 0.05))
    .map(poses.standard_quaternion)
)
vectors = hnp.arrays(np.float64, 3, elements=st.floats(-100.0, 100.0))


def as_scipy(rotation: FloatArray) -> Rotation:
    """The same rotation by SciPy, whose quaternions are `xyzw`."""
    return Rotation.from_quat(np.roll(rotation, -1, axis=-1))


def same_rotation(left: FloatArray, right: FloatArray) -> bool:
    """Whether two unit quaternions turn alike: q and -q do."""
    return bool(np.all(np.abs(np.sum(left * right, axis=-1)) > 1.0 - 1e-12))


@given(quaternions, quaternions)
def test_product_rotates_by_the_right_factor_first(left: FloatArray, right: FloatArray) -> None:
    product = poses.quaternion_multiply(left, right)
    expected = (as_scipy(left) * as_scipy(right)).as_matrix()
    np.testing.assert_allclose(poses.quaternion_matrix(product), expected, atol=1e-12)


@given(quaternions)
def test_product_with_the_conjugate_is_identity(rotation: FloatArray) -> None:
    product = poses.quaternion_multiply(rotation, poses.quaternion_conjugate(rotation))
    np.testing.assert_allclose(product, [1.0, 0.0, 0.0, 0.0], atol=1e-12)


@given(quaternions, vectors)
def test_rotate_agrees_with_scipy(rotation: FloatArray, vector: FloatArray) -> None:
    expected = as_scipy(rotation).apply(vector)
    np.testing.assert_allclose(poses.quaternion_rotate(rotation, vector), expected, atol=1e-10)


@given(quaternions)
def test_matrix_and_quaternion_round_trip(rotation: FloatArray) -> None:
    matrix = poses.quaternion_matrix(rotation)
    np.testing.assert_allclose(matrix, as_scipy(rotation).as_matrix(), atol=1e-12)
    back = poses.matrix_quaternion(matrix)
    assert same_rotation(back, rotation)
    assert back[0] >= 0.0


@pytest.mark.parametrize("axis", range(3))
def test_half_turns_survive_the_matrix(axis: int) -> None:
    # Here w is 0 and a naive division by it fails.
    half_turn = np.zeros(4)
    half_turn[1 + axis] = 1.0
    back = poses.matrix_quaternion(poses.quaternion_matrix(half_turn))
    assert same_rotation(back, half_turn)


def test_matrix_quaternion_of_a_batch_chooses_a_stable_row_for_each() -> None:
    rotations = Rotation.random(200, random_state=3)
    back = poses.matrix_quaternion(rotations.as_matrix().reshape(10, 20, 3, 3))
    assert same_rotation(back.reshape(-1, 4), np.roll(rotations.as_quat(), 1, axis=-1))


def test_standard_quaternion_is_unit_with_positive_real_part() -> None:
    np.testing.assert_allclose(
        poses.standard_quaternion([[-2.0, 0.0, 0.0, 0.0], [0.0, 3.0, 4.0, 0.0]]),
        [[1.0, 0.0, 0.0, 0.0], [0.0, 0.6, 0.8, 0.0]],
    )


@given(quaternions, quaternions, st.floats(0.0, 1.0))
def test_slerp_agrees_with_scipy(start: FloatArray, end: FloatArray, share: float) -> None:
    mixed = poses.quaternion_slerp(start, end, share)
    assert math.isclose(float(np.linalg.norm(mixed)), 1.0, abs_tol=1e-12)
    both = Rotation.concatenate([as_scipy(start), as_scipy(end)])
    between = (both[0].inv() * both[1]).magnitude()
    if between < math.pi - 1e-3:  # at half a turn either way round is the shorter one
        expected = Slerp([0.0, 1.0], both)(share)
        assert (as_scipy(mixed).inv() * expected).magnitude() < 1e-6


def test_slerp_by_hand() -> None:
    quarter = poses.yaw_quaternion(math.pi / 2.0)
    mixed = poses.quaternion_slerp([1.0, 0.0, 0.0, 0.0], quarter, [0.0, 0.5, 1.0])
    np.testing.assert_allclose(mixed, poses.yaw_quaternion(np.array([0, 0.25, 0.5]) * math.pi))


def test_slerp_takes_the_shorter_way_between_opposite_signs() -> None:
    rotation = poses.yaw_quaternion(0.3)
    assert same_rotation(poses.quaternion_slerp(rotation, -rotation, 0.5), rotation)


def test_yaw_turns_counter_clockwise_seen_from_above() -> None:
    # Seen from above (+Y towards the eye), +Z turns to +X and -Z to -X.
    quarter = poses.yaw_quaternion(math.pi / 2.0)
    np.testing.assert_allclose(
        poses.quaternion_rotate(quarter, [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0], atol=1e-15
    )
    np.testing.assert_allclose(
        poses.quaternion_rotate(quarter, [0.0, 0.0, -1.0]), [-1.0, 0.0, 0.0], atol=1e-15
    )


@given(quaternions, vectors, quaternions, vectors, vectors)
def test_poses_compose_and_invert(
    q1: FloatArray, t1: FloatArray, q2: FloatArray, t2: FloatArray, point: FloatArray
) -> None:
    T_a_b, T_b_c = poses.compose_pose(q1, t1), poses.compose_pose(q2, t2)
    step_by_step = poses.quaternion_rotate(q1, poses.quaternion_rotate(q2, point) + t2) + t1
    at_once = poses.transform_points(T_a_b @ T_b_c, point[None])[0]
    np.testing.assert_allclose(at_once, step_by_step, atol=1e-9)
    np.testing.assert_allclose(poses.invert_pose(T_a_b), np.linalg.inv(T_a_b), atol=1e-9)


def test_compose_pose_broadcasts_and_transforms_batches() -> None:
    turn = poses.compose_pose(poses.yaw_quaternion(np.zeros(5)), [1.0, 2.0, 3.0])
    assert turn.shape == (5, 4, 4)
    moved = poses.transform_points(turn, np.zeros((5, 7, 3)))
    np.testing.assert_array_equal(moved, np.broadcast_to([1.0, 2.0, 3.0], (5, 7, 3)))
    np.testing.assert_array_equal(turn[:, 3], np.tile([0.0, 0.0, 0.0, 1.0], (5, 1)))


def test_look_at_by_hand() -> None:
    # From +X towards the origin: the camera's right is then -Z, its back +X.
    T_world_camera = poses.look_at([2.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    expected = [[0, 0, 1, 2], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
    np.testing.assert_allclose(T_world_camera, expected, atol=1e-15)


@given(vectors, vectors)
def test_look_at_is_a_level_rotation_towards_the_target(
    eye: FloatArray, target: FloatArray
) -> None:
    if math.hypot(eye[0] - target[0], eye[2] - target[2]) < 0.01:
        return
    T = poses.look_at(eye, target)
    np.testing.assert_allclose(T[:3, :3] @ T[:3, :3].T, np.eye(3), atol=1e-9)
    assert np.linalg.det(T[:3, :3]) > 0.0
    seen = poses.transform_points(poses.invert_pose(T), target[None])[0]
    way = float(np.linalg.norm(target - eye))
    np.testing.assert_allclose(seen, [0.0, 0.0, -way], atol=1e-6)
    assert abs(T[1, 0]) < 1e-12, "the camera's right is horizontal"
    assert T[1, 1] > 0.0, "its up is not upside down"


@pytest.mark.parametrize("target", [(1.0, 2.0, 3.0), (1.0, 9.0, 3.0), (1.0, -9.0, 3.0)])
def test_look_at_refuses_what_has_no_level_camera(target: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="not straight above, below or at the eye"):
        poses.look_at([1.0, 2.0, 3.0], target)
