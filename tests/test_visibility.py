"""Who hides what: against trimesh's ray caster and a plain one, and rooms worked by hand."""

from __future__ import annotations

import math
import sys
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from small_release import (
    box_quads,
    box_room,
    circle_motion,
    limb_avatar,
    surface,
    sway_motion,
    world_of,
)

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person
from affectsim_data.poses import FloatArray, compose_pose, look_at, yaw_quaternion
from affectsim_data.visibility import (
    BodySamples,
    MovingCaster,
    RayCaster,
    body_samples,
    cycle_instants,
    people_samples,
    scene_caster,
    visible_share,
)

CAMERA = Camera(width=224, height=224, hfov=math.radians(60.0))
WALL = surface("wall", [[[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]]])
NOTHING = surface("nothing", [[[0, 99, 0], [1, 99, 0], [1, 99, 1], [0, 99, 1]]])


def caster_of(quads: ArrayLike) -> RayCaster:
    """Over quads `(n, 4, 3)`."""
    one = surface("one", quads)
    return RayCaster(one.positions, one.faces)


def no_embree(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine for which embreex has no wheel."""
    pytest.importorskip("rtree", reason="trimesh's own ray caster needs rtree")
    for name in ("embreex", "embreex.rtcore_scene", "embreex.mesh_construction"):
        monkeypatch.setitem(sys.modules, name, None)


def random_soup() -> tuple[FloatArray, np.ndarray, FloatArray, FloatArray]:
    """Vertices and faces of 300 triangles in a cube, and 400 rays through it."""
    rng = np.random.default_rng(11)
    centers = rng.uniform(-2.0, 2.0, (300, 1, 3))
    corners = centers + rng.normal(scale=0.5, size=(300, 3, 3))
    origins = rng.uniform(-3.0, 3.0, (400, 3))
    directions = rng.normal(size=(400, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return corners.reshape(-1, 3), np.arange(900).reshape(-1, 3), origins, directions


def plain_distance(vertices: FloatArray, origins: FloatArray, directions: FloatArray) -> FloatArray:
    """First hits by testing every triangle (Moeller and Trumbore 1997)."""
    a, b, c = np.moveaxis(vertices.reshape(-1, 3, 3), 1, 0)
    first, second = b - a, c - a
    p = np.cross(directions[:, None], second)
    scale = np.einsum("tk,rtk->rt", first, p)
    s = origins[:, None] - a
    q = np.cross(s, first)
    u = np.einsum("rtk,rtk->rt", s, p) / scale
    v = np.einsum("rk,rtk->rt", directions, q) / scale
    way = np.einsum("tk,rtk->rt", second, q) / scale
    hit = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (way > 0.0)
    nearest: FloatArray = np.where(hit, way, np.inf).min(axis=1)
    return nearest


@pytest.mark.parametrize("embree", [True, False])
def test_distances_agree_with_a_plain_caster(embree: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not embree:
        no_embree(monkeypatch)
    vertices, faces, origins, directions = random_soup()
    distance = RayCaster(vertices, faces).distance(origins, directions)
    expected = plain_distance(vertices, origins, directions)
    assert 50 < np.isfinite(expected).sum() < 350, "hits and misses are both tried"
    np.testing.assert_allclose(distance, expected, atol=1e-4)


def test_distances_agree_with_trimesh() -> None:
    pytest.importorskip("rtree", reason="trimesh's own ray caster needs rtree")
    import trimesh

    vertices, faces, origins, directions = random_soup()
    mesh: Any = trimesh.Trimesh(vertices, faces, process=False, use_embree=False)
    assert "triangle" in type(mesh.ray).__module__
    places, rays, _ = mesh.ray.intersects_location(origins, directions, multiple_hits=True)
    expected = np.full(len(origins), np.inf)
    np.minimum.at(expected, rays, np.linalg.norm(places - origins[rays], axis=1))
    distance = RayCaster(vertices, faces).distance(origins, directions)
    np.testing.assert_allclose(distance, expected, atol=1e-4)


@pytest.mark.parametrize("embree", [True, False])
def test_hidden_agrees_with_distance(embree: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not embree:
        no_embree(monkeypatch)
    vertices, faces, origins, _ = random_soup()
    caster, targets = RayCaster(vertices, faces), origins[::-1]
    way = np.linalg.norm(targets - origins, axis=1)
    first_hit = plain_distance(vertices, origins, (targets - origins) / way[:, None])
    hidden = caster.hidden(origins, targets)
    sure = np.abs(first_hit - way) > 0.01  # not where the target lies on a surface
    np.testing.assert_array_equal(hidden[sure], (first_hit < way)[sure])
    assert 50 < hidden.sum() < 350


@pytest.mark.parametrize("embree", [True, False])
def test_rays_by_hand(embree: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not embree:
        no_embree(monkeypatch)
    caster = RayCaster(WALL.positions, WALL.faces)
    origins = np.array([[0.0, 0.0, 3.0], [0.0, 0.0, -2.0], [0.0, 0.0, 3.0]])
    directions = np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 1.0]])
    distance = caster.distance(origins, directions)
    np.testing.assert_allclose(distance, [3.0, 2.0, np.inf], rtol=1e-6)
    limited = caster.distance(origins, directions, limit=2.5)
    np.testing.assert_allclose(limited, [np.inf, 2.0, np.inf], rtol=1e-6)
    # From one side to the other; to a point before the wall; to a point on the wall itself.
    eyes = np.array([0.0, 0.0, 3.0])
    targets = np.array([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]])
    np.testing.assert_array_equal(caster.hidden(eyes, targets), [True, False, False])


def test_rays_broadcast_and_keep_their_shape() -> None:
    caster = RayCaster(WALL.positions, WALL.faces)
    origins = np.array([0.0, 0.0, 1.0]) * np.arange(1, 5)[:, None, None]
    distance = caster.distance(origins, np.array([[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]))
    assert distance.shape == (4, 2)
    np.testing.assert_allclose(distance[:, 0], [1.0, 2.0, 3.0, 4.0])
    assert np.isinf(distance[:, 1]).all()
    assert caster.hidden(origins, np.zeros((1, 5, 3)) - [0.0, 0.0, 1.0]).shape == (4, 5)


def test_a_scene_hides_with_all_its_surfaces() -> None:
    caster = scene_caster(box_room("r", boxes=[((1.0, 0.0, -1.0), (2.0, 1.0, 1.0))]))
    directions = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 1.0, 0.0]])
    distance = caster.distance([0.0, 0.5, 0.0], directions)
    np.testing.assert_allclose(distance, [1.0, 4.0, 0.5, 2.1], rtol=1e-5)


def points_and_eye() -> tuple[BodySamples, FloatArray]:
    """Four points around the view axis at one instant, and a camera 3 m before them."""
    points = np.array([[-0.5, 0.0, 0.0], [-0.2, 0.0, 0.0], [0.2, 0.0, 0.0], [0.5, 0.0, 0.0]])
    return BodySamples(points[None]), look_at([0.0, 0.0, 3.0], [0.0, 0.0, 0.0])[None, None]


def share_of(samples: BodySamples, poses: FloatArray, caster: RayCaster) -> tuple[float, ...]:
    """Shares in the image, unhidden and visible, of one camera at one instant."""
    share = visible_share(samples, poses, CAMERA, caster)
    return tuple(float(x[0, 0]) for x in (share.in_image, share.unhidden, share.visible))


def test_a_wall_before_one_half_hides_one_half() -> None:
    samples, poses = points_and_eye()
    half_wall = [[[0, -9, 1], [9, -9, 1], [9, 9, 1], [0, 9, 1]]]
    assert share_of(samples, poses, caster_of(half_wall)) == (1.0, 0.5, 0.5)
    behind = np.array(half_wall) - [0.0, 0.0, 2.0]
    assert share_of(samples, poses, caster_of(behind)) == (1.0, 1.0, 1.0)


def test_points_outside_the_image_are_not_visible_but_unhidden() -> None:
    samples, _ = points_and_eye()
    # From 0.6 m a field of view of 60 degrees covers 0.35 m to either side.
    near = look_at([0.0, 0.0, 0.6], [0.0, 0.0, 0.0])[None, None]
    empty = caster_of(NOTHING.positions)
    assert share_of(samples, near, empty) == (0.5, 1.0, 0.5)
    away = look_at([0.0, 0.0, 3.0], [0.0, 0.0, 6.0])[None, None]
    assert share_of(samples, away, empty) == (0.0, 1.0, 0.0)


def test_visible_needs_both() -> None:
    samples, _ = points_and_eye()
    near = look_at([0.0, 0.0, 0.6], [0.0, 0.0, 0.0])[None, None]
    half_wall = [[[0, -9, 0.3], [9, -9, 0.3], [9, 9, 0.3], [0, 9, 0.3]]]
    assert share_of(samples, near, caster_of(half_wall)) == (0.5, 0.5, 0.25)


def test_one_camera_may_serve_all_instants() -> None:
    samples, poses = points_and_eye()
    twice = BodySamples(
        np.concatenate([samples.points, samples.points + np.array([0.0, 0.0, 9.0])])
    )
    share = visible_share(twice, poses, CAMERA, caster_of(NOTHING.positions))
    np.testing.assert_allclose(share.visible, [[1.0], [0.0]])


def test_body_points_lie_on_the_body_and_move_with_it() -> None:
    motion, avatar = circle_motion("c", "sad"), limb_avatar("plain")
    world = world_of(box_room("r"), [(motion, avatar, (1.0, 0.0, -1.0), 0.4)])
    samples = body_samples(world, [0.0, 1.5])
    assert samples.points.shape == (2, 96, 3)
    assert len(samples.points[0]) >= 64, "DESIGN section 4"
    roots = world.target.joint_frames([0.0, 1.5])[:, 0, :3, 3]
    for points, root in zip(samples.points, roots, strict=True):
        assert np.linalg.norm((points - root)[:, [0, 2]], axis=1).max() < 1.0
        assert -0.01 <= points[:, 1].min() < 0.2
        assert 1.4 < points[:, 1].max() < 2.0
    again = body_samples(world, [0.0, 1.5])
    np.testing.assert_array_equal(samples.points, again.points)


def test_a_person_in_an_empty_room_is_wholly_visible() -> None:
    scene = box_room("r")
    world = world_of(scene, [(sway_motion("s", "sad"), limb_avatar("plain"), (0, 0, 0), 0.0)])
    samples = body_samples(world, [0.0, 0.5])
    poses = look_at([0.0, 1.2, 2.5], [0.0, 0.9, 0.0])[None, None]
    share = visible_share(samples, poses, CAMERA, scene_caster(scene))
    np.testing.assert_array_equal(share.visible, 1.0)


def test_a_low_wall_hides_the_legs() -> None:
    wall = box_quads((-4.0, 0.0, 1.0), (4.0, 0.95, 1.1))
    scene = box_room("r", boxes=[((-3.9, 0.0, 1.0), (3.9, 0.95, 1.1))])
    world = world_of(scene, [(sway_motion("s", "sad"), limb_avatar("plain"), (0, 0, 0), 0.0)])
    samples = body_samples(world, [0.0])
    eye = np.array([0.0, 0.95, 3.0])  # level with the top of the wall: what is below it is hidden
    share = visible_share(
        samples, look_at(eye, [0.0, 0.9, 0.0])[None, None], CAMERA, caster_of(wall)
    )
    below = (samples.points[0, :, 1] < 0.94).mean()
    assert 0.2 < below < 0.8
    assert float(share.unhidden[0, 0]) == pytest.approx(1.0 - below, abs=0.05)


def test_the_partner_hides_the_target() -> None:
    scene, motion, avatar = box_room("r"), sway_motion("s", "sad"), limb_avatar("plain")
    poses = look_at([0.0, 1.0, 3.0], [0.0, 1.0, 0.0])[None, None]
    caster = scene_caster(scene)
    shares = []
    for partner in (
        [],
        [(motion, avatar, (0.0, 0.0, 1.0), 0.0)],
        [(motion, avatar, (2, 0, 1), 0.0)],
    ):
        world = world_of(scene, [(motion, avatar, (0.0, 0.0, 0.0), 0.0), *partner])
        share = visible_share(body_samples(world, [0.0, 1.0]), poses, CAMERA, caster)
        shares.append(float(share.visible.mean()))
    alone, behind, beside = shares
    assert alone == beside == 1.0
    assert behind < 0.4


def test_the_body_does_not_hide_itself() -> None:
    # The far side counts as seen (DESIGN section 4): shares are about the room, not about facing.
    scene, avatar = box_room("r"), limb_avatar("plain")
    for facing in (0.0, math.pi / 2.0, math.pi):
        world = world_of(scene, [(sway_motion("s", "sad"), avatar, (0.0, 0.0, 0.0), facing)])
        poses = look_at([0.0, 1.2, 3.0], [0.0, 0.9, 0.0])[None, None]
        samples = body_samples(world, [0.0])
        assert visible_share(samples, poses, CAMERA, scene_caster(scene)).visible.min() == 1.0


def test_a_moving_body_hides_what_it_hides_at_each_instant() -> None:
    vertices, faces, eyes, targets = random_soup()
    moved = vertices + np.array([[[0.0, 0.0, 0.0]], [[0.7, 0.1, -0.4]], [[-1.0, 0.3, 0.2]]])
    moving = MovingCaster(moved, faces).hidden(eyes, np.broadcast_to(targets, (3, *targets.shape)))
    alone = [RayCaster(one, faces).hidden(eyes, targets) for one in moved]
    assert np.mean(moving != np.stack(alone)) < 0.002, "but for rays along an edge"
    assert 0.05 < moving.mean() < 0.95


def test_placed_samples_are_those_of_placed_people() -> None:
    motion, avatar = circle_motion("c", "sad"), limb_avatar("plain")
    away = compose_pose(yaw_quaternion(np.pi), np.array([0.0, 0.0, 1.2]))
    people = [Person(motion, avatar, np.eye(4)), Person(motion, avatar, away)]
    instants = cycle_instants(motion.duration_s)
    at_home = people_samples(people, instants)
    eyes = np.random.default_rng(2).uniform(-3.0, 3.0, (1, 9, 3)) * [1.0, 0.2, 1.0]
    for yaw, place in ((0.4, (1.0, 0.3, -2.0)), (2.5, (-3.0, 0.0, 1.0))):
        pose = compose_pose(yaw_quaternion(yaw), np.array(place))
        there = [Person(one.motion, one.avatar, pose @ one.T_world_performance) for one in people]
        expected, placed = people_samples(there, instants), at_home.placed(pose)
        np.testing.assert_allclose(placed.points, expected.points, atol=1e-12)
        hidden = placed.hidden_by_partner(eyes + place)
        assert hidden.shape == (12, 9, 96)
        assert np.mean(hidden != expected.hidden_by_partner(eyes + place)) < 0.002
        assert 0.0 < hidden.mean() < 1.0


def test_cycle_instants_by_hand() -> None:
    np.testing.assert_allclose(cycle_instants(6.0), np.arange(12) * 0.5)


def test_nobody_hides_a_body_that_is_alone() -> None:
    samples = BodySamples(np.zeros((2, 5, 3)))
    assert not samples.hidden_by_partner(np.ones((1, 3, 3))).any()
    assert samples.hidden_by_partner(np.ones((2, 3, 3))).shape == (2, 3, 5)
