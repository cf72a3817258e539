"""The shipped avatars: rest pose, skinning, surface samples, GLB."""

from __future__ import annotations

import numpy as np
import pytest
from small_release import limb_avatar

from affectsim_data.avatars import Avatar
from affectsim_data.content import content_path
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES, NUM_JOINTS

AVATAR_IDS = sorted(path.stem for path in content_path("builders", "avatars").glob("*.glb"))


def payload_of(avatar_id: str) -> bytes:
    return content_path("builders", f"avatars/{avatar_id}.glb").read_bytes()


@pytest.fixture(params=AVATAR_IDS)
def avatar(request: pytest.FixtureRequest) -> Avatar:
    return Avatar.from_glb(payload_of(request.param), name=request.param)


def identity_rotations() -> FloatArray:
    rotations = np.zeros((1, NUM_JOINTS, 4))
    rotations[..., 0] = 1.0
    return rotations


def rest_root(avatar: Avatar) -> FloatArray:
    """Root translation of the canonical body that puts this one into its rest place, `(1, 3)`."""
    return avatar.skeleton.rest_positions[:1] / avatar.motion_scale


def test_there_are_eight_avatars() -> None:
    assert AVATAR_IDS == ["ada", "ben", "cleo", "dan", "ela", "finn", "gita", "hugo"]


@pytest.mark.parametrize("avatar_id", AVATAR_IDS)
def test_glb_round_trip_is_byte_identical(avatar_id: str) -> None:
    payload = payload_of(avatar_id)
    assert len(payload) < 1_000_000
    avatar = Avatar.from_glb(payload, name=avatar_id)
    assert avatar.avatar_id == avatar_id
    assert avatar.licence == "CC0-1.0"
    assert avatar.to_glb() == payload


@pytest.mark.parametrize("avatar_id", AVATAR_IDS)
def test_truncated_glb_is_an_error_that_names_the_file(avatar_id: str) -> None:
    payload = payload_of(avatar_id)
    for length in (10, 1000, len(payload) - 1):
        with pytest.raises(ValueError, match=rf"^{avatar_id}\.glb"):
            Avatar.from_glb(payload[:length], name=f"{avatar_id}.glb")


def test_levels_of_detail_get_coarser(avatar: Avatar) -> None:
    counts = [len(mesh.faces) for mesh in avatar.meshes]
    assert counts == sorted(counts, reverse=True)
    assert 9_000 < counts[0] < 14_000
    assert 5_000 < counts[1] <= 6_000
    assert counts[2] <= 3_000
    assert len(avatar.mesh(max_triangles=7_000).faces) == counts[1]
    assert len(avatar.mesh(max_triangles=10).faces) == counts[2]


def test_vertex_attributes_are_sound(avatar: Avatar) -> None:
    for mesh in avatar.meshes:
        assert (mesh.joint_weights.astype(int).sum(axis=1) == 255).all()
        assert np.allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-4)
        assert np.isfinite(mesh.positions).all()
        assert np.unique(mesh.faces).size == len(mesh.positions)


def test_rest_pose_is_a_t_pose_on_the_floor(avatar: Avatar) -> None:
    for mesh in avatar.meshes:
        low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
        assert abs(low[1]) < 0.005
        assert 1.5 < high[1] < 2.0
        assert 0.85 < (high[0] - low[0]) / (high[1] - low[1]) < 1.15
    joints = dict(zip(JOINT_NAMES, avatar.skeleton.rest_positions, strict=True))
    assert np.allclose(joints["pelvis"][[0, 2]], 0.0, atol=1e-6)
    for side, sign in (("left", 1.0), ("right", -1.0)):
        for name in ("hip", "knee", "ankle", "foot", "collar", "shoulder", "elbow", "wrist"):
            assert joints[f"{side}_{name}"][0] * sign > 0.01
        arm = joints[f"{side}_wrist"] - joints[f"{side}_shoulder"]
        assert np.allclose(arm / np.linalg.norm(arm), [sign, 0.0, 0.0], atol=1e-3)
        leg = joints[f"{side}_ankle"] - joints[f"{side}_hip"]
        assert np.allclose(leg / np.linalg.norm(leg), [0.0, -1.0, 0.0], atol=1e-3)
        assert joints[f"{side}_foot"][2] > joints[f"{side}_ankle"][2] + 0.05
    nose = avatar.meshes[0].positions[avatar.meshes[0].positions[:, 1] > joints["head"][1]]
    assert nose[:, 2].max() > joints["head"][2] + 0.05


def test_joints_lie_inside_the_body(avatar: Avatar) -> None:
    mesh = avatar.meshes[0]
    corners = mesh.positions[mesh.faces].astype(np.float64)
    for name, joint in zip(JOINT_NAMES, avatar.skeleton.rest_positions, strict=True):
        away = corners - joint
        length = np.linalg.norm(away, axis=2)
        a, b, c = away[:, 0], away[:, 1], away[:, 2]
        la, lb, lc = length.T
        # Van Oosterom and Strackee (1983): the solid angle of a triangle; all sum to 4 pi inside.
        above = np.einsum("fi,fi->f", a, np.cross(b, c))
        below = la * lb * lc
        below += np.einsum("fi,fi->f", a, b) * lc + np.einsum("fi,fi->f", a, c) * lb
        below += np.einsum("fi,fi->f", b, c) * la
        winding = 2.0 * np.arctan2(above, below).sum() / (4.0 * np.pi)
        assert winding > 0.5, name


def test_faces_point_outwards(avatar: Avatar) -> None:
    for mesh in avatar.meshes:
        a, b, c = mesh.positions[mesh.faces].astype(np.float64).swapaxes(0, 1)
        assert np.einsum("fi,fi->", a, np.cross(b, c)) / 6.0 > 0.03  # Cubic metres.
        cross = np.cross(b - a, c - a)
        agreement = np.einsum("fi,fi->f", cross, mesh.normals[mesh.faces].sum(axis=1))
        area = np.linalg.norm(cross, axis=1)
        assert area[agreement > 0].sum() > 0.97 * area.sum()


def test_identity_pose_returns_the_rest_vertices(avatar: Avatar) -> None:
    matrices = avatar.joint_matrices(rest_root(avatar), identity_rotations())
    for mesh in avatar.meshes:
        assert np.allclose(mesh.skin(matrices)[0], mesh.positions, atol=1e-6)


def test_left_elbow_moves_only_the_left_forearm(avatar: Avatar) -> None:
    rotations = identity_rotations()
    half = np.sqrt(0.5)
    rotations[0, JOINT_NAMES.index("left_elbow")] = [half, 0.0, -half, 0.0]
    matrices = avatar.joint_matrices(rest_root(avatar), rotations)
    joints = dict(zip(JOINT_NAMES, avatar.skeleton.rest_positions, strict=True))
    for mesh in avatar.meshes:
        moved = np.linalg.norm(mesh.skin(matrices)[0] - mesh.positions, axis=1) > 1e-3
        assert (mesh.positions[moved, 0] > joints["left_shoulder"][0] + 0.02).all()
        assert moved[mesh.positions[:, 0] > joints["left_elbow"][0] + 0.06].all()
        hand = mesh.skin(matrices)[0][mesh.positions[:, 0] > joints["left_wrist"][0]]
        assert (hand[:, 2] > joints["left_wrist"][2] + 0.1).all()  # Bent forward.


def test_surface_samples_are_uniform_by_area(avatar: Avatar) -> None:
    samples = avatar.surface_samples(4000, rng=np.random.default_rng(7))
    mesh = avatar.meshes[-1]
    a, b, c = mesh.positions[mesh.faces].astype(np.float64).swapaxes(0, 1)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    middle = (a + b + c) / 3.0
    for axis in range(3):
        for level in np.quantile(mesh.positions[:, axis], [0.25, 0.5, 0.75]):
            expected = area[middle[:, axis] > level].sum() / area.sum()
            got = (samples.positions[:, axis] > level).mean()
            assert abs(got - expected) < 0.03
    assert np.allclose(samples.joint_weights.sum(axis=1), 1.0)


def test_surface_samples_repeat_and_follow_the_body(avatar: Avatar) -> None:
    first, second = (avatar.surface_samples(64, rng=np.random.default_rng(3)) for _ in range(2))
    other = avatar.surface_samples(64, rng=np.random.default_rng(4))
    assert np.array_equal(first.positions, second.positions)
    assert not np.array_equal(first.positions, other.positions)
    shift = np.array([[0.5, 0.0, -2.0]])
    matrices = avatar.joint_matrices(
        rest_root(avatar) + shift / avatar.motion_scale, identity_rotations()
    )
    assert np.allclose(first.skin(matrices)[0], first.positions + shift, atol=1e-6)


def test_rounded_bodies_are_the_same_to_an_eighth_of_a_millimetre() -> None:
    avatar = limb_avatar("plain", scale=1.0373)
    rounded = avatar.rounded()
    for before, after in zip(avatar.meshes, rounded.meshes, strict=True):
        assert np.abs(after.positions - before.positions).max() <= 2.0**-13 + 1e-7
        assert np.abs(after.normals - before.normals).max() <= 2.0**-8 + 1e-7
        assert not np.array_equal(after.positions, before.positions)
    assert rounded.rounded().to_glb() == rounded.to_glb()
