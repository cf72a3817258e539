"""The search for a reference view: against an exhaustive one, and against its own limits."""

from __future__ import annotations

import dataclasses
import functools
import math
from typing import Any

import numpy as np
import pytest
from small_release import CAMERA, Point, box_room, circle_motion, limb_avatar, sway_motion, world_of

from affectsim_data.episodes import World
from affectsim_data.motions import Motion
from affectsim_data.observations import ReferencePlanner, ReferenceSearch, plan_reference
from affectsim_data.observations.bodies import body_path
from affectsim_data.observations.candidates import make_candidates
from affectsim_data.observations.checking import Checks, check_knots
from affectsim_data.observations.knots import interpolate_knots, make_knots
from affectsim_data.observations.ranking import Ranking
from affectsim_data.observations.reference import reference_planner
from affectsim_data.observations.steadying import steady_path
from affectsim_data.observations.tracks import BodyTrack, body_track
from affectsim_data.poses import FloatArray, compose_pose, look_at, yaw_quaternion
from affectsim_data.visibility import scene_caster, visible_share

AVATAR = limb_avatar("plain")
SWAY = sway_motion("sway", "happy")
WALK = dataclasses.replace(circle_motion("walk", "sad"), fps=10.0)
SEARCH = ReferenceSearch()


def crowded(seed: int) -> World:
    """Somebody at the middle of a room with seven boxes of any size about, none on top of them."""
    rng = np.random.default_rng(seed)
    boxes: list[tuple[Point, Point]] = []
    for angle, away in zip(rng.uniform(0.0, 2.0 * np.pi, 7), rng.uniform(1.2, 3.5, 7), strict=True):
        x, z = away * np.sin(angle), away * np.cos(angle)
        w, h, d = rng.uniform(0.1, 0.4, 3) * [1.0, 4.0, 1.0]
        boxes.append(((x - w, 0.0, z - d), (x + w, h + 0.3, z + d)))
    people = [(SWAY, AVATAR, (0.0, 0.0, 0.0), float(rng.uniform(-np.pi, np.pi)))]
    if seed % 3 == 0:
        people.append((SWAY, AVATAR, (0.9, 0.0, 0.4), float(rng.uniform(-np.pi, np.pi))))
    return world_of(box_room("crowded", boxes=boxes), people)


def ranking_of(world: World, search: ReferenceSearch = SEARCH) -> tuple[Ranking, BodyTrack]:
    """Candidates about the target where it stands, nothing measured yet."""
    track = body_track(world.people)
    floor = np.eye(4)
    candidates = make_candidates(track, steady_path(track.path), CAMERA, search)
    caster = scene_caster(world.scene)
    return Ranking(candidates, track.samples, floor, caster, search), track


@functools.cache
def planned(motion: Motion | None = None) -> ReferencePlanner:
    """A planner of one performance in its own frame."""
    person = world_of(box_room("r"), [(motion or SWAY, AVATAR, (0.0, 0.0, 0.0), 0.0)]).target
    return ReferencePlanner(body_track([person]), CAMERA, SEARCH)


# The ranking.


@pytest.mark.parametrize("seed", range(6))
def test_the_order_is_that_of_an_exhaustive_search(seed: int) -> None:
    world = crowded(seed)
    ranking, _ = ranking_of(world)
    first = [chosen for chosen, _ in zip(ranking, range(5), strict=False)]
    assert not ranking.measured.all(), "or nothing was pruned"
    exhaustive, _ = ranking_of(world)
    exhaustive.measure_all()
    order = np.lexsort((np.arange(len(exhaustive.scores)), -exhaustive.scores))
    assert first == order[:5].tolist()
    np.testing.assert_array_equal(ranking.scores[first], exhaustive.scores[first])
    assert list(ranking_of(world)[0]) == order.tolist(), "to the last one"


@pytest.mark.parametrize("seed", range(3))
def test_bounds_are_never_below_the_scores(seed: int) -> None:
    ranking, _ = ranking_of(crowded(seed))
    bounds = ranking.scores.copy()
    list(ranking)
    assert (ranking.scores <= bounds).all()
    assert (ranking.scores < bounds - 0.01).any()
    for name, part in ranking.parts.items():
        assert ((part >= 0.0) & (part <= 1.0 + 1e-12)).all(), name


def test_visibility_is_the_visible_share_of_cameras_that_can_be_there() -> None:
    world = crowded(3)
    ranking, track = ranking_of(world)
    list(ranking)
    steady = steady_path(track.path)
    candidates = make_candidates(track, steady, CAMERA, SEARCH)
    poses = look_at(
        candidates.eyes, np.broadcast_to(candidates.center[:, None], candidates.eyes.shape)
    )
    share = visible_share(track.samples, poses, CAMERA, scene_caster(world.scene)).visible
    free = ranking.kept & (ranking.parts["clearance"] > 0.99)
    assert free.sum() > 5
    expected = share.mean(axis=0)[free]
    np.testing.assert_allclose(ranking.parts["visibility"][free], expected, atol=0.002)


def test_nobody_films_from_inside_the_partner() -> None:
    partner = (SWAY, AVATAR, (0.0, 0.0, 1.7), math.pi)
    world = world_of(box_room("r"), [(SWAY, AVATAR, (0.0, 0.0, 0.0), 0.0), partner])
    view, _ = plan_reference(world, scene_caster(world.scene))
    joints = world.people[1].joint_frames(np.arange(60) / 30.0)[..., :3, 3]
    assert np.linalg.norm(joints.reshape(-1, 1, 3) - view.knots[:, :3], axis=-1).min() >= 0.45


# Trajectories.


def checks_of(world: World, knots: FloatArray, search: ReferenceSearch = SEARCH) -> Checks:
    """What a trajectory does in a world."""
    track = body_track(world.people)
    return check_knots(
        knots,
        track,
        steady_path(track.path),
        camera=CAMERA,
        caster=scene_caster(world.scene),
        search=search,
    )


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("motion", [SWAY, WALK], ids=["sway", "walk"])
def test_what_is_stored_holds_when_looked_at_again(seed: int, motion: Motion) -> None:
    world = crowded(seed)
    target = dataclasses.replace(world.target, motion=motion)
    world = dataclasses.replace(world, people=(target,))
    view, share = plan_reference(world, scene_caster(world.scene))
    np.testing.assert_array_equal(view.knots, view.knots.astype(np.float32))
    checks = checks_of(world, view.knots)
    assert checks.safe
    assert checks.gentle(SEARCH)
    assert checks.visible == pytest.approx(share, abs=1e-9)


def standing() -> World:
    return world_of(box_room("r"), [(SWAY, AVATAR, (0.0, 0.0, 0.0), 0.0)])


def still(eye: Point) -> FloatArray:
    """Knots of a camera that does not move and looks at the body, `(10, 7)`."""

    center = body_path(standing().target).center[:1]
    return np.repeat(make_knots(np.array([eye]), center), 10, axis=0)


def test_a_good_view_passes_every_check() -> None:
    checks = checks_of(standing(), still((0.0, 1.2, 2.2)))
    assert checks.hold(SEARCH)
    assert (checks.visible, checks.framed, checks.in_sight) == (1.0, 1.0, 1.0)
    assert checks.speed_m_s == pytest.approx(0.0, abs=1e-9)
    assert checks.turn_rad_s == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(
    ("eye", "failed"),
    [
        ((0.0, 1.2, 4.2), {"outside": 1.0}),  # behind the wall at 4 m
        ((0.0, 1.2, 3.95), {"clear": 0.0, "outside": 0.0}),  # 5 cm before it
        ((0.0, 1.0, 0.3), {"clear": 0.0}),  # in the performer
        ((0.0, 1.2, 1.2), {"framed": 0.0, "clear": 1.0}),  # too near
    ],
)
def test_bad_views_fail(eye: Point, failed: dict[str, float]) -> None:
    checks = checks_of(standing(), still(eye))
    assert not checks.hold(SEARCH)
    assert {name: getattr(checks, name) for name in failed} == failed


def test_a_camera_between_two_knots_is_looked_at_too() -> None:
    # Free at every knot, but half way the camera passes through a post.
    post = ((-0.05, 0.0, 2.0), (0.05, 2.0, 2.4))
    world = world_of(box_room("r", boxes=[post]), [(SWAY, AVATAR, (0.0, 0.0, 0.0), 0.0)])
    knots = still((0.0, 1.2, 2.2))
    knots[:, 0] = np.where(np.arange(10) % 2, 0.5, -0.5)
    checks = checks_of(world, knots)
    assert 0.0 < checks.clear < 1.0
    assert checks.speed_m_s > 3.0


def test_haste_and_turning_by_hand() -> None:
    # Round a circle of 2 m in 2 s: pi rad/s, 2 pi m/s, 2 pi^2 m/s2.
    angle = np.arange(40) * 2.0 * np.pi / 40
    eyes = np.stack([2.0 * np.sin(angle), 0.0 * angle + 1.2, 2.0 * np.cos(angle)], axis=1)

    checks = checks_of(standing(), make_knots(eyes, np.broadcast_to([0.0, 1.2, 0.0], eyes.shape)))
    assert checks.turn_rad_s == pytest.approx(math.pi, rel=0.01)
    assert checks.speed_m_s == pytest.approx(2.0 * math.pi, rel=0.01)
    assert checks.acceleration_m_s2 == pytest.approx(2.0 * math.pi**2, rel=0.1)
    assert not checks.gentle(SEARCH)


def test_in_a_cupboard_the_camera_still_is_in_the_cupboard() -> None:
    world = world_of(box_room("cupboard", half=0.55), [(SWAY, AVATAR, (0.0, 0.0, 0.0), 0.3)])
    view, share = plan_reference(world, scene_caster(world.scene))
    assert (np.abs(view.knots[:, [0, 2]]) < 0.55).all()
    assert checks_of(world, view.knots).outside == 0.0
    assert 0.0 <= share <= 1.0


# Planners.


@pytest.mark.parametrize(("yaw", "place"), [(0.0, (0.0, 0.0, 0.0)), (2.0, (0.8, 0.0, -1.1))])
def test_a_planner_says_what_planning_afresh_says(yaw: float, place: Point) -> None:
    pose = compose_pose(yaw_quaternion(yaw), np.array(place))
    world = world_of(box_room("r", half=3.0), [(SWAY, AVATAR, place, yaw)])
    caster = scene_caster(world.scene)
    view, share = planned().plan(pose, caster)
    afresh, share_afresh = plan_reference(world, caster)
    assert (view.azimuth, view.distance_m, view.height_m) == (
        *(afresh.azimuth, afresh.distance_m, afresh.height_m),
    )
    np.testing.assert_allclose(view.knots, afresh.knots, atol=1e-5)
    assert share == pytest.approx(share_afresh, abs=0.01)


def test_planners_are_kept_by_track() -> None:
    track = body_track([standing().target])
    assert reference_planner(track, CAMERA) is reference_planner(track, CAMERA)
    other = ReferenceSearch(heights_m=(1.4,))
    assert reference_planner(track, CAMERA, other) is not reference_planner(track, CAMERA)


def test_a_placed_track_is_the_track_of_who_stands_there() -> None:
    pose = compose_pose(yaw_quaternion(0.7), np.array([1.0, 0.2, -0.5]))
    people = world_of(box_room("r"), [(WALK, AVATAR, (0.0, 0.0, 0.0), 0.0)]).people
    placed = body_track(people).placed(pose)
    there = body_track([dataclasses.replace(people[0], T_world_performance=pose)])
    np.testing.assert_allclose(placed.samples.points, there.samples.points, atol=1e-9)
    np.testing.assert_allclose(placed.path.center, there.path.center, atol=1e-9)
    turned = np.exp(1j * placed.path.heading)
    np.testing.assert_allclose(turned, np.exp(1j * there.path.heading), atol=1e-9)
    np.testing.assert_allclose(placed.joints, there.joints, atol=1e-9)
    assert placed.duration_s == WALK.duration_s


# Searches from a recipe.


def test_a_table_changes_what_it_names() -> None:
    search = ReferenceSearch.from_table(
        {"heights_m": [1.4, 1.6], "weight_alignment": 0.2, "speed_m_s": 2}, where="a.toml"
    )
    assert search == ReferenceSearch(heights_m=(1.4, 1.6), weight_alignment=0.2, speed_m_s=2.0)


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ({"hights_m": [1.0]}, r"a.toml: \[reference\] knows no 'hights_m'; is it 'heights_m'\?"),
        ([1.0], r"a.toml: \[reference\] must be a table, got \[1.0\]"),
        ({"heights_m": 1.0}, r"\[reference\] heights_m must be a list of numbers, got 1.0"),
        ({"heights_m": []}, r"heights_m must be finite numbers, at least one, got \(\)"),
        ({"heights_m": [True]}, "heights_m must be a number, got True"),
        ({"distances_m": [0.0]}, r"distances_m must be above 0, got \(0.0,\)"),
        ({"clearance_m": "far"}, "clearance_m must be a number, got 'far'"),
        ({"clearance_m": 0.0}, "clearance_m must be above 0, got 0"),
        ({"weight_framing": -0.1}, "weight_framing must be 0 or more, got -0.1"),
        ({"weight_framing": 0.3}, "weights must add up to at most 1 and not to 0, got 1.1"),
    ],
)
def test_bad_tables_are_refused(table: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ReferenceSearch.from_table(table, where="a.toml: [reference]")


def test_interpolated_rotations_take_the_shorter_way() -> None:
    knots = still((0.0, 1.2, 2.0))
    flipped = knots.copy()
    flipped[::2, 3:] *= -1.0
    cycles = np.linspace(0.0, 1.0, 41)
    np.testing.assert_allclose(
        interpolate_knots(flipped, cycles)[:, :3, :3], interpolate_knots(knots, cycles)[:, :3, :3]
    )
