"""Forward kinematics: against a slow loop of matrices, and by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from affectsim_data.poses import axis_angle_quaternion, quaternion_matrix
from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, NUM_JOINTS, Skeleton

IDENTITY = np.tile([1.0, 0.0, 0.0, 0.0], (NUM_JOINTS, 1))


def test_joint_order_is_that_of_smpl() -> None:
    assert NUM_JOINTS == 22
    assert JOINT_NAMES[:4] == ("pelvis", "left_hip", "right_hip", "spine1")
    assert JOINT_NAMES[-2:] == ("left_wrist", "right_wrist")
    pairs = zip(JOINT_NAMES[1:], JOINT_PARENTS[1:], strict=True)
    parent_names = {name: JOINT_NAMES[parent] for name, parent in pairs}
    assert parent_names["left_collar"] == parent_names["neck"] == "spine3"
    assert parent_names["right_foot"] == "right_ankle"
    assert parent_names["head"] == "neck"


def test_rest_pose_is_a_t_pose_on_the_floor() -> None:
    rest = dict(zip(JOINT_NAMES, BODY.rest_positions, strict=True))
    np.testing.assert_allclose(rest["pelvis"], [0.0, 0.95, 0.0])
    np.testing.assert_allclose(rest["left_wrist"][1], rest["left_shoulder"][1])
    assert rest["left_wrist"][0] > 0.6, "the left hand points along +X"
    assert rest["left_foot"][2] > 0.1, "the toes point along +Z"
    assert 0.0 < rest["left_foot"][1] < 0.05
    assert BODY.hip_height == 0.95


def test_left_and_right_mirror_each_other() -> None:
    rest = dict(zip(JOINT_NAMES, BODY.rest_positions, strict=True))
    for name in JOINT_NAMES:
        if name.startswith("left"):
            mirrored = rest[name.replace("left", "right")] * [-1.0, 1.0, 1.0]
            np.testing.assert_allclose(rest[name], mirrored)


def test_identity_rotations_give_the_rest_pose() -> None:
    positions, rotations = BODY.forward_kinematics([0.0, 0.95, 0.0], IDENTITY)
    np.testing.assert_allclose(positions, BODY.rest_positions)
    np.testing.assert_allclose(rotations, IDENTITY)


def test_forward_kinematics_agrees_with_a_loop_of_matrices() -> None:
    rng = np.random.default_rng(1)
    local = np.roll(Rotation.random(3 * NUM_JOINTS, random_state=1).as_quat(), 1, axis=1)
    local = local.reshape(3, NUM_JOINTS, 4)
    root = rng.normal(size=(3, 3))
    positions, rotations = BODY.forward_kinematics(root, local)
    for frame in range(3):
        world: list[np.ndarray] = []
        for joint, parent in enumerate(JOINT_PARENTS):
            T = np.eye(4)
            T[:3, :3] = Rotation.from_quat(np.roll(local[frame, joint], -1)).as_matrix()
            T[:3, 3] = root[frame] if parent < 0 else BODY.joint_offsets[joint]
            world.append(T if parent < 0 else world[parent] @ T)
        np.testing.assert_allclose(positions[frame], [T[:3, 3] for T in world], atol=1e-12)
        matrices = quaternion_matrix(rotations[frame])
        np.testing.assert_allclose(matrices, [T[:3, :3] for T in world], atol=1e-12)


def test_a_bent_elbow_moves_only_the_wrist() -> None:
    elbow, wrist = JOINT_NAMES.index("left_elbow"), JOINT_NAMES.index("left_wrist")
    bent = IDENTITY.copy()
    # A quarter turn about +Z takes the forearm from +X to +Y.
    bent[elbow] = axis_angle_quaternion([0.0, 0.0, 1.0], np.pi / 2.0)
    positions, _ = BODY.forward_kinematics([0.0, 0.95, 0.0], bent)
    moved = np.abs(positions - BODY.rest_positions).max(axis=1) > 1e-9
    assert np.flatnonzero(moved).tolist() == [wrist]
    np.testing.assert_allclose(positions[wrist] - positions[elbow], [0.0, 0.25, 0.0], atol=1e-12)


def test_bones_keep_their_lengths() -> None:
    local = np.roll(Rotation.random(NUM_JOINTS, random_state=2).as_quat(), 1, axis=1)
    positions, _ = BODY.forward_kinematics(np.zeros(3), local)
    lengths = np.linalg.norm(positions[1:] - positions[list(JOINT_PARENTS[1:])], axis=1)
    np.testing.assert_allclose(lengths, np.linalg.norm(BODY.joint_offsets[1:], axis=1))


@pytest.mark.parametrize(
    ("names", "parents", "message"),
    [
        (("a", "a"), (-1, 0), "joint names must be unique"),
        (("a", "b"), (-1,), r"2 joints need 2 parents and offsets \(n, 3\), got 1 and \(2, 3\)"),
        (("a", "b"), (-1, -1), "joint 'b': parents must come first"),
        (("a", "b"), (-1, 1), "joint 'b': parents must come first"),
        (("a", "b"), (0, 0), "joint 'a': parents must come first"),
        (("a", "b"), (-1, -2), "joint 'b': parents must come first"),
    ],
)
def test_bad_skeletons_are_refused(
    names: tuple[str, ...], parents: tuple[int, ...], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        Skeleton(names, parents, np.zeros((2, 3)))


def test_skeletons_are_frozen() -> None:
    with pytest.raises(dataclasses.FrozenInstanceError):
        BODY.joint_names = ()  # type: ignore[misc]  # the point of the test
