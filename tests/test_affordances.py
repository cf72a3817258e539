"""What small rooms worked by hand, and the homes of the built-in release, let one do."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
import trimesh

from affectsim_data.affordances import (
    clearance,
    curved_runs,
    fits,
    footprint_fits,
    knockable_doors,
    line_of_sight,
    reachable_seats,
    rooms_of,
    same_room,
    straight_runs,
)
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Door, Room, Scene, Seat, Surface

Box = tuple[float, float, float, float, float, float]

# A closed leaf in the wall between the rooms, knocked on from the kitchen: it faces -X.
DOOR = Door((-0.1, 1.4, 1.5), -90.0, 0.8, 2.0, (-0.1, 0.0, 1.9), room_id="kitchen")
# Seats on boxes: one free, one with a table over its knees, one with a shelf at head height.
SEATS = tuple(Seat((x, 0.45, 1.6), 180.0, 0.4, 0.45) for x in (1.0, 2.5, 4.0))
ROOMS = (
    Room("kitchen", "kitchen", ((-4, -2), (0, -2), (0, 2), (-4, 2))),
    Room("living", "living", ((0, -2), (5, -2), (5, 2), (0, 2))),
)
WALL = [(0.0, -1.35, 0.1, 1.3, 2.5, 0.0), (0.0, 1.1, 0.1, 1.8, 2.5, 0.0)]
FURNITURE = [
    *((x, 1.8, 0.5, 0.5, 0.45, 0.0) for x in (1.0, 2.5, 4.0)),
    (2.5, 1.1, 0.8, 0.3, 0.2, 0.45),
    (4.0, 1.7, 0.8, 0.5, 0.3, 1.0),
]


def scene(*boxes: Box, doors: tuple[Door, ...] = (DOOR,)) -> Scene:
    """Kitchen and living room, joined by a doorway 0.9 m wide, with boxes (x, z, sizes, foot)."""
    corners = [[-4, 0, -2], [5, 0, -2], [5, 0, 2], [-4, 0, 2]]
    mesh = trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)
    for x, z, width, depth, height, foot in (*WALL, *boxes):
        part = trimesh.creation.box((width, height, depth))
        mesh = mesh + part.apply_translation([x, foot + height / 2.0, z])
    count = len(mesh.vertices)
    surface = Surface(
        "all",
        np.asarray(mesh.vertices, np.float32),
        np.tile(np.array([0, 1, 0], np.float32), (count, 1)),
        np.full((count, 4), 200, np.uint8),
        np.asarray(mesh.faces, np.uint32),
    )
    return Scene("rooms", (surface,), ROOMS, seats=SEATS, doors=doors)


HOME = scene(*FURNITURE)
FLOOR = NavMesh.from_mesh(*HOME.mesh())


def test_points_are_in_the_room_around_them() -> None:
    points = np.array([[-1, 0, 0], [1, 1, 1], [1, 5, 1], [9, 0, 0], [1, -0.2, 0]], np.float64)
    np.testing.assert_array_equal(rooms_of(HOME, points), [0, 1, -1, -1, 1])
    assert rooms_of(HOME, points.reshape(5, 1, 3)).shape == (5, 1)
    assert int(rooms_of(HOME, points[0])) == 0


def test_outside_every_room_nothing_is_in_one_room() -> None:
    points = np.array([[-1, 0, 0], [-1, 0, 0], [9, 0, 0]])
    others = np.array([[-3, 0, 1], [1, 0, 0], [9, 0, 0]])
    np.testing.assert_array_equal(same_room(HOME, points, others), [True, False, False])


def test_a_wall_ends_a_line_of_sight_and_a_doorway_does_not() -> None:
    eyes = np.array([-2.0, 1.2, 0.0])
    targets = np.array([[2.0, 1.2, 1.5], [2.0, 1.2, -1.8], [-3.0, 1.2, 1.0]])
    through_the_doorway = np.array([[-2.0, 1.2, -0.5]])
    np.testing.assert_array_equal(line_of_sight(HOME, eyes, targets), [False, False, True])
    assert line_of_sight(HOME, through_the_doorway, [[2.0, 1.2, -0.5]])[0]


def test_clearance_is_the_distance_to_what_stands_there() -> None:
    points = np.array(
        [[-2, 0, 0], [-3, 0, 0], [-3.65, 0, 0], [-3.95, 0, 0], [-2, 1, 0]], np.float64
    )
    # The nearest: the wall 1.95 m off, then the edge of the floor; off the mesh nothing is free.
    free = clearance(FLOOR, points)
    np.testing.assert_allclose(free[:3], [1.95, 1.0, 0.35], atol=0.08)
    np.testing.assert_array_equal(free[3:], 0.0)
    np.testing.assert_array_equal(fits(FLOOR, points, radius_m=0.6), [True, True, *[False] * 3])
    with pytest.raises(ValueError, match=r"radius_m must be at least 0\.3, .* got 0\.2"):
        fits(FLOOR, points, radius_m=0.2)


def test_a_motion_fits_where_all_of_its_way_does() -> None:
    """Two metres straight on, from the middle of the kitchen towards and along its walls."""
    ahead = np.stack([0 * np.arange(9), 0 * np.arange(9), 0.25 * np.arange(9)], axis=1)
    anchors = np.array([[-2.0, 0, -1.0], [-2.0, 0, -1.0], [-2.0, 0, 0.5]])
    facings = np.radians([0.0, 180.0, 0.0])
    free = footprint_fits(FLOOR, ahead, anchors, facings, radius_m=0.4)
    np.testing.assert_array_equal(free, [True, False, False])


def test_seats_need_room_for_legs_and_body() -> None:
    access = reachable_seats(HOME, FLOOR)
    np.testing.assert_array_equal(access.legs_free, [True, False, True])
    np.testing.assert_array_equal(access.body_free, [True, True, False])
    np.testing.assert_array_equal(access.is_usable, [True, False, False])
    # The floor before the first sitter's knees is free, so the robot comes to it.
    np.testing.assert_allclose(access.approach[0], [1.0, 0.0, 1.15], atol=0.11)
    assert np.all(access.is_near)


def test_seats_on_another_island_or_behind_a_wall_are_not_near() -> None:
    blocked = scene(*FURNITURE, (0.0, -0.25, 0.1, 0.9, 2.5, 0.0))
    floor = NavMesh.from_mesh(*blocked.mesh())
    assert len(floor.islands) == 2
    kitchen, living = (-2.0, 0.0, 0.0), (3.0, 0.0, -0.5)
    assert not np.any(reachable_seats(blocked, floor, start=kitchen).is_near)
    assert np.all(reachable_seats(blocked, floor, start=living).is_near)
    assert not np.any(reachable_seats(HOME, FLOOR, within_m=0.0001).is_near[1:2])


def test_a_closed_door_is_knocked_on_from_its_free_side() -> None:
    access = knockable_doors(HOME, FLOOR)
    assert access.is_knockable.tolist() == [True]
    np.testing.assert_allclose(access.stand[0], [-0.75, 0.0, 1.5], atol=1e-9)


@pytest.mark.parametrize(
    ("change", "boxes"),
    [
        ({"opening_deg": 80.0}, ()),
        ({"room_id": "living"}, ()),
        (
            {"yaw_deg": 90.0, "knock_point": (0.1, 1.4, 1.5), "room_id": ""},
            ((0.6, 1.5, 0.9, 0.9, 0.9, 0.0),),
        ),
        ({}, ((-0.6, 1.5, 0.9, 0.9, 0.9, 0.0),)),
        ({}, ((-0.3, 1.5, 0.02, 0.6, 0.6, 1.2),)),
    ],
    ids=["open", "other room", "blocked other side", "blocked", "screen before the leaf"],
)
def test_doors_that_cannot_be_knocked_on(change: dict[str, object], boxes: tuple[Box, ...]) -> None:
    door = dataclasses.replace(DOOR, **change)  # type: ignore[arg-type]
    place = scene(*boxes, doors=(door,))
    access = knockable_doors(place, NavMesh.from_mesh(*place.mesh()))
    assert access.is_knockable.tolist() == [False]


def test_a_scene_without_seats_and_doors_has_none_to_use() -> None:
    empty = dataclasses.replace(HOME, seats=(), doors=())
    assert reachable_seats(empty, FLOOR).is_usable.shape == (0,)
    assert knockable_doors(empty, FLOOR).is_knockable.shape == (0,)


@pytest.mark.parametrize("turn_radius_m", [math.inf, 1.5])
def test_runs_are_free_of_their_length_and_sorted_by_width(turn_radius_m: float) -> None:
    rng = np.random.default_rng(0)
    if math.isinf(turn_radius_m):
        runs = straight_runs(FLOOR, 3.0, rng=rng)
    else:
        runs = curved_runs(FLOOR, 3.0, turn_radius_m, rng=rng)
    assert len(runs) > 5
    assert np.all(np.diff(runs.free_width_m) <= 0.0)
    assert runs.free_width_m[-1] >= 0.6
    along = np.linspace(0.0, 3.0, 40)
    # The way by summing up small steps along the heading.
    step = (along[1:] + along[:-1]) / 2.0
    heading = runs.heading[:, None] + runs.curvature[:, None] * step
    steps = 3.0 / 39.0 * np.stack([np.sin(heading), 0.0 * heading, np.cos(heading)], axis=-1)
    way = np.cumsum(np.concatenate([runs.start[:, None], steps], axis=1), axis=1)
    np.testing.assert_allclose(way[:, -1], runs.end, atol=0.005)
    free = clearance(FLOOR, way[:, :-1].reshape(-1, 3)).reshape(len(runs), -1).min(axis=1)
    free = np.minimum(free, clearance(FLOOR, runs.end))
    np.testing.assert_allclose(2.0 * free, runs.free_width_m, atol=0.05)
    np.testing.assert_allclose(np.abs(runs.curvature), 1.0 / turn_radius_m)


def test_runs_within_a_room_stay_in_it() -> None:
    kitchen = ROOMS[0].polygon
    runs = straight_runs(FLOOR, 2.0, rng=np.random.default_rng(1), within=kitchen)
    assert len(runs) > 10
    ends = np.concatenate([runs.start, runs.end])
    np.testing.assert_array_equal(rooms_of(HOME, ends), 0)
    assert len(straight_runs(FLOOR, 6.0, rng=np.random.default_rng(1), within=kitchen)) == 0


def test_the_same_seed_gives_the_same_runs() -> None:
    one, two = (curved_runs(FLOOR, 3.0, 2.0, rng=np.random.default_rng(7)) for _ in range(2))
    np.testing.assert_array_equal(one.start, two.start)
    assert {-0.5, 0.5} == set(one.curvature.tolist())


def test_runs_need_a_length_and_a_radius() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="length_m and num_tries must be above 0, got 0"):
        straight_runs(FLOOR, 0.0, rng=rng)
    with pytest.raises(ValueError, match="turn_radius_m must be above 0, got -1"):
        curved_runs(FLOOR, 3.0, -1.0, rng=rng)
