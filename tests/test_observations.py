"""Conditions: where each camera stands, by hand; the reference view in rooms one can foresee."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import Any

import numpy as np
import pytest
from small_release import (
    Point,
    box_room,
    circle_motion,
    front_view,
    limb_avatar,
    make_episode,
    place,
    sway_motion,
    world_of,
)

from affectsim_data.episodes import Episode, ReferenceView, World
from affectsim_data.motions import Motion
from affectsim_data.observations import (
    Condition,
    Orbit,
    PInit,
    PMon,
    PRef,
    ReferenceSearch,
    head_camera_pose,
    monitor_pose,
    plan_reference,
)
from affectsim_data.observations.bodies import body_path
from affectsim_data.observations.knots import interpolate_knots
from affectsim_data.observations.steadying import steady_path
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.skeletons import JOINT_NAMES
from affectsim_data.visibility import RayCaster, scene_caster

AVATAR = limb_avatar("plain")
SWAY = sway_motion("sway", "happy")
WALK = circle_motion("walk", "sad", radius=0.6)
TIMES = np.arange(60) / 30.0


def stage(
    motion: Motion = SWAY,
    *,
    anchor: Point = (0.0, 0.0, 0.0),
    facing: float = 0.0,
    boxes: Iterable[tuple[Point, Point]] = (),
    half: float = 4.0,
) -> tuple[Episode, World]:
    """An episode and its world: one motion in a box room."""
    world = world_of(box_room("room", half=half, boxes=boxes), [(motion, AVATAR, anchor, facing)])
    target = place(motion, AVATAR, anchor, facing)
    return make_episode(target=target, duration_s=motion.duration_s, action=motion.action), world


def eyes_of(condition: Condition, motion: Motion = SWAY, **options: Any) -> FloatArray:
    """Camera positions of a condition, `(60, 3)`."""
    episode, world = stage(motion, **options)
    return condition.trajectory(episode, world, TIMES).T_world_camera[:, :3, 3]


# p_init and p_mon.


@pytest.mark.parametrize(
    ("yaw_deg", "view"),
    [
        (0.0, (0.0, 0.0, -1.0)),
        (90.0, (-1.0, 0.0, 0.0)),
        (180.0, (0.0, 0.0, 1.0)),
        (-90.0, (1.0, 0.0, 0.0)),
    ],
)
def test_p_init_looks_level_along_the_robots_yaw(yaw_deg: float, view: Point) -> None:
    episode, world = stage()
    episode = dataclasses.replace(
        episode, start_position=(1.0, 0.2, 3.0), start_yaw=math.radians(yaw_deg)
    )
    trajectory = PInit().trajectory(episode, world, TIMES)
    assert len(trajectory) == 60
    assert trajectory.is_still
    pose = trajectory.T_world_camera[0]
    np.testing.assert_allclose(pose[:3, 3], [1.0, 1.4, 3.0])  # 1.2 m above the floor at 0.2
    np.testing.assert_allclose(-pose[:3, 2], view, atol=1e-12)
    np.testing.assert_allclose(pose[:3, 1], [0.0, 1.0, 0.0], atol=1e-12)


def test_head_cameras_come_in_batches() -> None:
    _, world = stage()
    poses = head_camera_pose(np.zeros((5, 3)), np.linspace(0.0, 1.0, 5), world.robot)
    assert poses.shape == (5, 4, 4)
    np.testing.assert_allclose(poses[:, 1, 3], 1.2)


def test_p_mon_looks_down_by_its_pitch() -> None:
    episode, world = stage()
    episode = dataclasses.replace(
        episode,
        monitor_position=(3.0, 2.4, 0.0),
        monitor_yaw=math.radians(90.0),
        monitor_pitch=math.radians(-30.0),
    )
    trajectory = PMon().trajectory(episode, world, TIMES)
    assert trajectory.is_still
    pose = trajectory.T_world_camera[7]
    np.testing.assert_allclose(pose[:3, 3], [3.0, 2.4, 0.0])
    # Yaw 90 looks along -X; 30 degrees down takes half of it to -Y.
    np.testing.assert_allclose(-pose[:3, 2], [-math.sqrt(0.75), -0.5, 0.0], atol=1e-12)
    assert abs(pose[1, 0]) < 1e-12, "its horizon is level"
    assert pose[1, 1] > 0.0


def test_a_level_monitor_is_a_head_camera() -> None:
    _, world = stage()
    monitor = monitor_pose(np.array([1.0, 1.2, 2.0]), np.array(0.4), np.array(0.0))
    head = head_camera_pose(np.array([1.0, 0.0, 2.0]), np.array(0.4), world.robot)
    np.testing.assert_allclose(monitor, head, atol=1e-12)


def test_conditions_have_names() -> None:
    conditions: list[Condition] = [PInit(), PRef(), PMon(), Orbit()]
    assert [c.name for c in conditions[:3]] == ["p_init", "p_ref", "p_mon"]
    assert all(isinstance(condition, Condition) for condition in conditions)
    assert Orbit(distance_m=2.5, azimuth_deg=-45.0).name == "orbit_2.5m_-45deg_1.2m"
    assert Orbit(follow=False).name == "orbit_2m_0deg_1.2m_still"


# Orbit.


@pytest.mark.parametrize(
    ("azimuth_deg", "side"),
    [(0.0, (0.0, 1.0)), (90.0, (1.0, 0.0)), (180.0, (0.0, -1.0)), (-90.0, (-1.0, 0.0))],
)
def test_orbit_sides_by_hand(azimuth_deg: float, side: tuple[float, float]) -> None:
    # The performer looks along +Z and has its left at +X.
    eyes = eyes_of(Orbit(distance_m=2.0, azimuth_deg=azimuth_deg, height_m=1.5))
    np.testing.assert_allclose(eyes[:, [0, 2]], np.tile(side, (60, 1)) * 2.0, atol=1e-3)
    np.testing.assert_allclose(eyes[:, 1], 1.5)


def test_orbit_turns_with_the_facing_and_moves_with_the_anchor() -> None:
    eyes = eyes_of(Orbit(distance_m=1.5), anchor=(1.0, 0.3, -1.0), facing=math.pi / 2.0)
    np.testing.assert_allclose(eyes, np.tile([2.5, 1.5, -1.0], (60, 1)), atol=1e-3)


def test_in_front_the_person_looks_into_the_camera() -> None:
    episode, world = stage(WALK, facing=0.4)
    trajectory = Orbit(azimuth_deg=0.0).trajectory(episode, world, TIMES)
    frames = world.target.joint_frames(TIMES)
    to_camera = trajectory.T_world_camera[:, :3, 3] - frames[:, 0, :3, 3]
    to_camera /= np.linalg.norm(to_camera, axis=1, keepdims=True)
    facing = frames[:, 0, :3, 2]
    assert (np.einsum("ni,ni->n", to_camera, facing) > 0.95).all()


def test_at_90_degrees_the_left_hand_is_nearer() -> None:
    episode, world = stage(WALK, facing=-1.0)
    eyes = Orbit(azimuth_deg=90.0).trajectory(episode, world, TIMES).T_world_camera[:, :3, 3]
    joints = world.target.joint_frames(TIMES)[..., :3, 3]
    left, right = (
        np.linalg.norm(joints[:, JOINT_NAMES.index(f"{side}_wrist")] - eyes, axis=1)
        for side in ("left", "right")
    )
    assert (left < right - 0.1).all()


def test_orbit_holds_its_distance_and_keeps_the_body_in_the_middle() -> None:
    episode, world = stage(WALK)
    trajectory = Orbit(distance_m=2.5, azimuth_deg=30.0).trajectory(episode, world, TIMES)
    center, _ = body_path(world.target).at(TIMES)
    offset = trajectory.T_world_camera[:, :3, 3] - center
    np.testing.assert_allclose(np.linalg.norm(offset[:, [0, 2]], axis=1), 2.5)
    pelvis = world.target.joint_frames(TIMES)[:, 0, :3, 3]
    for pose, place_of_pelvis in zip(trajectory.T_world_camera, pelvis, strict=True):
        seen = np.linalg.inv(pose) @ [*place_of_pelvis, 1.0]
        pixel, depth = world.camera.project(seen[:3])
        assert float(depth) > 1.5
        np.testing.assert_allclose(pixel, [112.0, 112.0], atol=25.0)


@pytest.mark.parametrize(
    ("wall_m", "distance_m"),
    # 0.3 m before the wall; nearer to it, not under 0.8 m; but never behind it.
    [(3.0, 2.0), (1.5, 1.2), (1.0, 0.8), (0.6, 0.54)],
)
def test_a_wall_pulls_an_orbit_in_front_of_it(wall_m: float, distance_m: float) -> None:
    eyes = eyes_of(Orbit(distance_m=2.0), anchor=(0.0, 0.0, 4.0 - wall_m))
    np.testing.assert_allclose(eyes[:, 2], 4.0 - wall_m + distance_m, atol=0.02)


def test_an_orbit_may_be_asked_to_go_through_walls() -> None:
    through = Orbit(distance_m=2.0, in_free_space=False)
    np.testing.assert_allclose(eyes_of(through, anchor=(0.0, 0.0, 3.0))[:, 2], 5.0, atol=1e-3)
    assert through.name == "orbit_2m_0deg_1.2m_through"


def test_orbit_follows_or_stays() -> None:
    follows, stays = (eyes_of(Orbit(follow=follow), WALK) for follow in (True, False))
    assert np.ptp(follows, axis=0).max() > 1.0
    assert np.ptp(stays, axis=0).max() == 0.0


def test_following_is_periodic_and_smooth() -> None:
    episode, world = stage(WALK)
    orbit, cycle = Orbit(distance_m=2.0), WALK.duration_s
    time_s = np.arange(0.0, cycle, 1.0 / 30.0)
    now = orbit.trajectory(episode, world, time_s).T_world_camera
    later = orbit.trajectory(episode, world, time_s + 2.0 * cycle).T_world_camera
    np.testing.assert_allclose(now, later, atol=1e-9)
    eyes = np.concatenate([now, now[:1]])[:, :3, 3]
    # Once round a circle of some 2.6 m in 3 s is 0.18 m a frame.
    assert np.linalg.norm(np.diff(eyes, axis=0), axis=1).max() < 0.25


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"distance_m": 0.0}, r"Orbit distance_m must be 0\.05 to 50, got 0"),
        ({"distance_m": -1.0}, r"Orbit distance_m must be 0\.05 to 50, got -1"),
        ({"distance_m": math.nan}, r"Orbit distance_m must be 0\.05 to 50, got nan"),
        ({"azimuth_deg": math.inf}, "Orbit needs a finite azimuth_deg .* got inf and 1.2"),
        ({"height_m": 30.0}, "height_m from -5 to 20, got 0.0 and 30"),
        ({"height_m": math.nan}, "height_m from -5 to 20, got 0.0 and nan"),
    ],
)
def test_bad_orbits_are_refused(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Orbit(**fields)


# p_ref.


def plan(motion: Motion = SWAY, **options: Any) -> tuple[ReferenceView, float, World, RayCaster]:
    """The reference view of one motion in a room, its share, and where it was planned."""
    _, world = stage(motion, **options)
    caster = scene_caster(world.scene)
    return *plan_reference(world, caster), world, caster


def hits_nothing(view: ReferenceView, world: World, caster: RayCaster) -> bool:
    """Whether the way from the body's axis to the camera is free at every knot."""
    instants = np.arange(len(view.knots)) * world.target.motion.duration_s / len(view.knots)
    axis, _ = body_path(world.target).at(instants)
    axis[:, 1] = view.knots[:, 1]
    return not caster.hidden(view.knots[:, :3], axis).any()


def test_in_an_empty_room_the_reference_is_in_front() -> None:
    view, share, world, caster = plan()
    assert view.azimuth == 0.0
    assert 1.7 <= view.distance_m <= 2.7
    assert share == 1.0
    assert set(view.parts) == {
        *("visibility", "alignment", "distance_fit", "framing", "clearance"),
    }
    assert all(0.0 <= part <= 1.0 for part in view.parts.values())
    assert view.parts["alignment"] == view.parts["visibility"] == view.parts["clearance"] == 1.0
    assert hits_nothing(view, world, caster)
    # It stands at +Z, where the performer looks, and looks back at it.
    np.testing.assert_allclose(view.knots[:, 0], 0.0, atol=0.02)
    assert (view.knots[:, 2] > 1.5).all()


def test_the_score_is_the_weighted_sum_of_its_parts() -> None:
    view, _, _, _ = plan()
    search = ReferenceSearch()
    total = sum(getattr(search, f"weight_{name}") * part for name, part in view.parts.items())
    assert view.score == pytest.approx(total)
    assert 0.0 < view.score <= 1.0


def test_with_a_wall_in_front_the_reference_is_at_a_side() -> None:
    wall = ((-1.2, 0.0, 0.7), (1.2, 2.5, 0.9))
    view, share, world, caster = plan(boxes=[wall])
    assert 30.0 <= abs(math.degrees(view.azimuth)) <= 150.0
    assert share > 0.9
    assert hits_nothing(view, world, caster)


def test_the_reference_stays_on_this_side_of_a_wall_behind_it() -> None:
    # The performer looks at a wall 1.2 m away all along the room: there is no room in front.
    view, _, world, caster = plan(anchor=(0.0, 0.0, 2.8))
    assert abs(math.degrees(view.azimuth)) > 45.0
    assert (np.abs(view.knots[:, [0, 2]]) < 4.0 - 0.1).all()
    assert hits_nothing(view, world, caster)


@pytest.mark.parametrize("half", [1.5, 2.0, 3.0, 4.0])
@pytest.mark.parametrize("motion", [SWAY, WALK], ids=["sway", "walk"])
def test_the_reference_is_never_inside_or_behind_a_wall(half: float, motion: Motion) -> None:
    # In the smallest rooms every candidate is beyond a wall, and something must still come out.
    for facing in (0.0, 0.9, 2.5):
        view, _, world, caster = plan(motion, half=half, facing=facing)
        assert (np.abs(view.knots[:, [0, 2]]) < half).all()
        assert hits_nothing(view, world, caster)
        assert np.isfinite(view.knots).all()


@pytest.mark.parametrize(("wall_m", "distance_m"), [(2.0, 1.4), (3.0, 1.9)])
def test_a_view_that_keeps_its_margin_to_the_wall_is_preferred(
    wall_m: float, distance_m: float
) -> None:
    # From 1.9 m a wall at 2 m hides nothing, but it is nearer than 0.3 m behind the camera.
    _, world = stage(anchor=(0.0, 0.0, 4.0 - wall_m))
    search = ReferenceSearch(
        azimuths_deg=(0.0,), distances_m=(1.4, 1.9), preferred_distance_m=1.9, weight_clearance=0.0
    )
    view, _ = plan_reference(world, scene_caster(world.scene), search=search)
    assert (view.knots[:, 2] <= 4.0 - 0.3 + 1e-6).all()
    assert (view.parts["visibility"] == 1.0) == (view.distance_m == distance_m)


@pytest.mark.parametrize("wall_m", [0.3, 0.5, 0.8, 1.2])
def test_a_wall_close_to_the_face_is_not_looked_through(wall_m: float) -> None:
    _, world = stage(anchor=(0.0, 0.0, 4.0 - wall_m))
    caster, search = scene_caster(world.scene), ReferenceSearch(azimuths_deg=(0.0,))
    view, _ = plan_reference(world, caster, search=search)
    assert (view.knots[:, 2] < 4.0).all()
    assert hits_nothing(view, world, caster)


def test_a_camera_pulled_in_by_a_pillar_stays_before_it() -> None:
    # The walker's front sweeps past a pillar: there the camera must come nearer.
    pillar = ((-0.2, 0.0, 1.6), (0.2, 2.6, 2.0))
    view, _, world, caster = plan(WALK, boxes=[pillar])
    assert hits_nothing(view, world, caster)


def test_without_a_pillar_the_relative_pose_is_kept() -> None:
    strolling = dataclasses.replace(WALK, fps=10.0)
    view, _, world, _ = plan(strolling)
    steady = steady_path(body_path(world.target))
    offset = view.knots[:, :3] - steady.center[::6]
    np.testing.assert_allclose(np.hypot(offset[:, 0], offset[:, 2]), view.distance_m, atol=1e-6)
    side = np.arctan2(offset[:, 0], offset[:, 2]) - steady.heading[::6]
    np.testing.assert_allclose(np.exp(1j * side), np.exp(1j * view.azimuth), atol=1e-6)


def test_a_camera_does_not_race_round_somebody_who_spins() -> None:
    # Once round in 3 s is 120 degrees a second: the camera keeps its side in the room instead.
    view, _, world, _ = plan(WALK)
    steady = steady_path(body_path(world.target))
    offset = view.knots[:, :3] - steady.center[::6]
    np.testing.assert_allclose(offset, np.broadcast_to(offset[0], offset.shape), atol=1e-6)


def test_knots_are_closed_and_continuous() -> None:
    episode, world = stage(WALK)
    view, _ = plan_reference(world, scene_caster(world.scene))
    episode = dataclasses.replace(episode, reference=view)
    time_s = np.arange(0.0, 2.0 * WALK.duration_s + 0.01, 1.0 / 30.0)
    poses = PRef().trajectory(episode, world, time_s).T_world_camera
    np.testing.assert_allclose(poses[:90], poses[90:180], atol=1e-9)
    steps = np.linalg.norm(np.diff(poses[:, :3, 3], axis=0), axis=1)
    assert steps.max() < 0.25, "no jump, at the end of the cycle either"
    turns = np.einsum("nij,nij->n", poses[1:, :3, :3], poses[:-1, :3, :3])
    assert turns.min() > 1.0 + 2.0 * math.cos(math.radians(6.0)), "at most 6 degrees a frame"


def test_knots_hold_unit_quaternions_that_look_at_the_body() -> None:
    view, _, world, _ = plan(WALK)
    np.testing.assert_allclose(np.linalg.norm(view.knots[:, 3:], axis=1), 1.0, atol=1e-6)
    assert (view.knots[:, 3] >= 0.0).all()
    assert len(view.knots) == 16, "some five a second, and an even number"
    poses = interpolate_knots(view.knots, np.arange(16) / 16.0)
    center = steady_path(body_path(world.target)).center[::6]
    np.testing.assert_allclose(poses, look_at(view.knots[:, :3], center), atol=1e-6)


def test_interpolation_between_knots_by_hand() -> None:
    knots = np.zeros((4, 7))
    knots[:, 0] = [0.0, 1.0, 2.0, 1.0]
    knots[:, 3] = 1.0
    poses = interpolate_knots(knots, np.array([0.0, 0.125, 0.5, 0.875, 1.0, 2.25]))
    # At 1/8 the cubic is 0 + 3/8 of the way up: its slope at the lowest knot is 0.
    np.testing.assert_allclose(poses[:, 0, 3], [0.0, 0.375, 2.0, 0.375, 0.0, 1.0])


def test_p_ref_plays_the_stored_knots() -> None:
    episode, world = stage()
    episode = dataclasses.replace(episode, reference=front_view())
    pose = PRef().trajectory(episode, world, TIMES).T_world_camera
    np.testing.assert_allclose(pose[:, :3, 3], np.tile([0.0, 1.2, 2.0], (60, 1)), atol=1e-6)
    np.testing.assert_allclose(pose[:, :3, :3], np.tile(np.eye(3), (60, 1, 1)), atol=1e-12)


def test_the_plan_never_depends_on_the_emotion() -> None:
    plans = [
        plan(dataclasses.replace(WALK, emotion=emotion, motion_id=emotion, action=emotion))
        for emotion in ("sad", "happy", "angry")
    ]
    for view, share, _, _ in plans[1:]:
        np.testing.assert_array_equal(view.knots, plans[0][0].knots)
        assert dataclasses.replace(view, knots=plans[0][0].knots) == plans[0][0]
        assert share == plans[0][1]


def test_the_partner_is_looked_round() -> None:
    scene = box_room("room")
    partner = (SWAY, AVATAR, (0.0, 0.0, 1.0), math.pi)
    world = world_of(scene, [(SWAY, AVATAR, (0.0, 0.0, 0.0), 0.0), partner])
    view, share = plan_reference(world, scene_caster(scene))
    assert view.azimuth != 0.0
    assert share > 0.9


def test_a_search_may_be_changed_by_a_recipe() -> None:
    _, world = stage()
    search = ReferenceSearch(azimuths_deg=(90.0,), distances_m=(2.3,), heights_m=(1.5,))
    view, _ = plan_reference(world, scene_caster(world.scene), search=search)
    assert (view.azimuth, view.distance_m, view.height_m) == (math.pi / 2.0, 2.3, 1.5)
