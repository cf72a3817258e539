"""Placements: what they promise measured again, who they depend on, and why there is none."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from placement_rooms import (
    CHAIR,
    CRATES,
    PARTITION,
    acting,
    bare,
    placed,
    recipe,
    room,
    slot_of,
    swaying,
    talking,
)
from small_release import box_room

from affectsim_data.affordances import clearance, same_room
from affectsim_data.avatars import SurfaceSamples
from affectsim_data.builders.measuring import (
    Performance,
    cycle_instants,
    measure_performance,
    on_floor,
)
from affectsim_data.builders.placement import Placement, Stage, Unplaced, find_placements
from affectsim_data.builders.placement.floor_grid import FloorGrid
from affectsim_data.builders.placement.ledger import Ledger
from affectsim_data.builders.placement.supports import (
    FEET_OFF_FLOOR_M,
    HAND_SHORT_M,
    HAND_THROUGH_M,
    PELVIS_OFF_SEAT_M,
    PELVIS_OFF_SEAT_PLAN_M,
)
from affectsim_data.builders.slots import Slot
from affectsim_data.episodes import Person
from affectsim_data.motions import EMOTIONS
from affectsim_data.observations import head_camera_pose
from affectsim_data.poses import FloatArray, compose_pose, yaw_quaternion
from affectsim_data.schemas import CHALLENGES, Challenge
from affectsim_data.skeletons import JOINT_NAMES
from affectsim_data.visibility import VisibleShare, people_samples, visible_share

ROOMS = {
    "far_visible": (),
    "rear_view": CRATES,
    "partial_occlusion": CRATES,
    "obstacle_detour": (PARTITION,),
}
"""Boxes of a room in which a challenge can be met."""
WRISTS = [JOINT_NAMES.index(f"{side}_wrist") for side in ("left", "right")]


def people_at(placement: Placement, performance: Performance) -> tuple[Person, ...]:
    pose = compose_pose(yaw_quaternion(placement.facing), placement.anchor)
    return performance.people(pose)


def shares_at(stage: Stage, placement: Placement, performance: Performance) -> VisibleShare:
    """Shares at the start, measured as releases are, `(12, 1)` each."""
    camera = head_camera_pose(placement.start, np.array(placement.start_yaw), recipe().robot)
    instants = cycle_instants(performance.motion.duration_s)
    samples = people_samples(people_at(placement, performance), instants)
    return visible_share(samples, camera[None, None], recipe().camera, stage.caster)


def joints_over(placement: Placement, performance: Performance) -> FloatArray:
    """Joints of the target in every frame, world, `(num_frames, 22, 3)`."""
    motion = performance.motion
    frames = people_at(placement, performance)[0].joint_frames(
        np.arange(motion.num_frames) / motion.fps
    )
    return frames[..., :3, 3]


def off(one: FloatArray, two: FloatArray) -> float:
    """Distance on the plan, metres."""
    return float(np.linalg.norm((np.asarray(one) - two)[..., [0, 2]], axis=-1).max())


@pytest.mark.parametrize("challenge", CHALLENGES)
@pytest.mark.parametrize("number", range(4))
def test_challenges_hold_when_measured_again(challenge: Challenge, number: int) -> None:
    stage, limits = room(5.0, ROOMS[challenge]), recipe().thresholds
    found = placed(stage, slot_of("floor", challenge, key=f"{number}"), swaying())
    distance = math.dist(found.start, found.anchor)
    share = shares_at(stage, found, swaying()["sad"])
    visible, in_image = float(share.visible.mean()), float(share.in_image.mean())
    if challenge == "far_visible":
        assert distance >= limits.far_distance_m
        assert visible >= limits.visible
    elif challenge == "rear_view":
        assert limits.near_m <= distance <= limits.far_m
        assert visible >= limits.visible
        x, _, z = found.start - found.anchor
        bearing = math.remainder(math.atan2(x, z) - found.facing, math.tau)
        assert abs(math.degrees(bearing)) >= limits.rear_bearing_deg
    elif challenge == "partial_occlusion":
        assert limits.near_m <= distance <= limits.far_m
        assert limits.occluded_low <= visible <= limits.occluded_high
        assert in_image >= limits.in_image
    else:
        geodesic = stage.navmesh.ring_distance(found.start, found.anchor, 1.0)
        assert geodesic >= limits.detour_ratio * (distance - 1.1)
        lift = np.array([0.0, 0.4, 0.0])
        assert stage.caster.hidden(found.start + lift, found.anchor + lift)


def test_starts_are_on_the_floor_of_the_robot_and_off_the_persons_way() -> None:
    stage = room()
    for number in range(6):
        found = placed(stage, slot_of(key=f"{number}"), swaying())
        assert stage.navmesh.island(found.start) == 0
        assert stage.navmesh.is_navigable(found.start, 0.01)
        assert same_room(stage.scene, found.start, found.anchor)
        way = joints_over(found, swaying()["angry"])[:, 0]
        assert np.linalg.norm((way - found.start)[:, [0, 2]], axis=1).min() >= 0.5


def test_robots_look_at_the_person() -> None:
    found = [placed(room(), slot_of(key=f"{number}"), swaying()) for number in range(8)]
    way = np.array([one.anchor - one.start for one in found])
    ahead = np.array([[-math.sin(one.start_yaw), -math.cos(one.start_yaw)] for one in found])
    cosine = np.sum(way[:, [0, 2]] * ahead, axis=1) / np.hypot(way[:, 0], way[:, 2])
    assert cosine.min() >= math.cos(math.radians(10.0))


def test_a_slot_is_placed_alike_alone_and_among_others() -> None:
    challenges: tuple[Challenge | None, ...] = (None, "rear_view", "far_visible")
    slots = [
        slot_of("floor", challenge, key=f"{challenge}/{number}")
        for challenge in challenges
        for number in range(2)
    ]
    together = find_placements(room(), slots, swaying(), recipe())
    fresh = bare(room().scene)
    for slot, found in reversed(list(zip(slots, together, strict=True))):
        (alone,) = find_placements(fresh, [slot], swaying(), recipe())
        assert isinstance(found, Placement)
        assert isinstance(alone, Placement)
        assert (found.start == alone.start).all()
        assert (found.anchor == alone.anchor).all()
        assert (found.facing, found.start_yaw) == (alone.facing, alone.start_yaw)


def test_placements_are_blind_to_emotion() -> None:
    cast = acting("sit_down")
    turned = dict(zip(EMOTIONS, EMOTIONS[1:] + EMOTIONS[:1], strict=True))
    relabelled = {
        key: dataclasses.replace(
            one, motion=dataclasses.replace(one.motion, emotion=turned[one.motion.emotion])
        )
        for key, one in cast.items()
    }
    first = placed(room(), slot_of("before_seat"), cast)
    second = placed(room(), slot_of("before_seat"), relabelled)
    assert (first.anchor == second.anchor).all()
    assert (first.start == second.start).all()


def test_order_of_motions_does_not_matter() -> None:
    slot = slot_of("door")
    first = placed(room(), slot, acting("knock_door"))
    backwards = dataclasses.replace(slot, motion_ids=slot.motion_ids[::-1])
    second = placed(room(), backwards, acting("knock_door"))
    assert (first.anchor == second.anchor).all()
    assert (first.start == second.start).all()


@pytest.mark.parametrize("body", [0, 3])
def test_sitters_have_the_pelvis_on_the_seat_and_the_feet_near_the_floor(body: int) -> None:
    cast = acting("being_seated", body)
    found = placed(room(), slot_of("seat"), cast)
    seat = room().scene.seats[0]
    assert found.support == "seat 0"
    assert found.facing == pytest.approx(math.radians(seat.yaw_deg), abs=0.05)
    assert abs(found.anchor[1]) <= FEET_OFF_FLOOR_M
    for performance in cast.values():
        pelvis = joints_over(found, performance)[:, 0]
        low = pelvis[pelvis[:, 1].argmin()]
        assert off(low, np.array(seat.position)) <= PELVIS_OFF_SEAT_PLAN_M
        assert low[1] - 0.1 * performance.avatar.motion_scale == pytest.approx(
            seat.height, abs=PELVIS_OFF_SEAT_M
        )


def test_who_sits_down_stands_before_the_seat_first() -> None:
    cast = acting("sit_down")
    found = placed(room(), slot_of("before_seat"), cast)
    seat = room().scene.seats[0]
    assert found.anchor[1] == pytest.approx(0.0, abs=1e-9)
    for performance in cast.values():
        pelvis = joints_over(found, performance)[:, 0]
        low = pelvis[pelvis[:, 1].argmin()]
        assert off(low, np.array(seat.position)) <= PELVIS_OFF_SEAT_PLAN_M
        # The chair's front edge is 0.15 m before the seat's middle, and the person before that.
        assert pelvis[0, 0] > CHAIR[1][0] + 0.05


@pytest.mark.parametrize("body", [0, 3])
def test_hands_knock_on_the_leaf_and_not_through_it(body: int) -> None:
    cast = acting("knock_door", body)
    stage = room()
    found = placed(stage, slot_of("door"), cast)
    door = stage.scene.doors[0]
    assert found.support == "door 0"
    for performance in cast.values():
        person = people_at(found, performance)[0]
        mesh = performance.avatar.meshes[-1]
        heaviest = mesh.joint_weights.argmax(axis=1)[:, None]
        moved_by = np.take_along_axis(mesh.joint_indices, heaviest, axis=1)[:, 0]
        hands = np.isin(moved_by, WRISTS)
        frames = np.arange(performance.motion.num_frames) / performance.motion.fps
        skin = SurfaceSamples(
            mesh.positions[hands].astype(np.float64),
            mesh.joint_indices[hands],
            mesh.joint_weights[hands] / 255.0,
        )
        points = skin.skin(person.joint_matrices(frames))
        gap = points[..., 2].min() - door.knock_point[2]
        # Hands are looked for at the twelve instants at which wrists are farthest.
        assert -HAND_THROUGH_M - 0.01 <= gap <= HAND_SHORT_M + 0.01
        assert off(person.T_world_performance[:3, 3], np.array([0.0, 0.0, found.anchor[2]])) < 0.1


def test_walks_keep_clear_of_furniture_all_the_way() -> None:
    cast = acting("simple_walk")
    found = placed(room(), slot_of(), cast)
    for performance in cast.values():
        way = joints_over(found, performance)[:, 0]
        way[:, 1] = 0.0
        assert clearance(room().navmesh, way).min() >= 0.3


def test_arms_spread_wide_stay_out_of_walls() -> None:
    sway = swaying()["sad"]
    spread = sway.motion.joint_rotations.copy()
    spread[:, [JOINT_NAMES.index(f"{side}_shoulder") for side in ("left", "right")]] = [1, 0, 0, 0]
    motion = dataclasses.replace(sway.motion, joint_rotations=spread)
    cast = {"sad": dataclasses.replace(sway, motion=motion)}
    stage = room(2.2, ())
    for number in range(6):
        found = placed(stage, slot_of(key=f"{number}", motion_ids=("sad",)), cast)
        reach = np.abs(joints_over(found, cast["sad"])[..., [0, 2]]).max()
        assert reach <= 2.2


def test_both_of_a_dyad_have_room_and_the_target_is_seen() -> None:
    cast = talking()
    found = placed(room(), slot_of("pair", motion_ids=tuple(cast)), cast)
    for performance in cast.values():
        for person in people_at(found, performance):
            frames = np.arange(person.motion.num_frames) / person.motion.fps
            way = person.joint_frames(frames)[:, 0, :3, 3]
            way[:, 1] = 0.0
            assert clearance(room().navmesh, way).min() >= 0.3
        share = shares_at(room(), found, performance).visible.mean()
        assert share >= recipe().thresholds.grounded_visible


def why_not(stage: Stage, slot: Slot, cast: dict[str, Performance]) -> Unplaced:
    """Why a slot has no placement, which it must not have."""
    (found,) = find_placements(stage, [slot], cast, recipe())
    assert isinstance(found, Unplaced), found
    counts = list(found.survivors.values())
    assert counts[-1] == 0
    assert found.constraint == list(found.survivors)[counts.index(0)]
    return found


@pytest.mark.parametrize(
    ("half", "challenge", "constraint"),
    [
        (1.6, "far_visible", "a start 5 m or more away"),
        (3.0, "partial_occlusion", "a view partly blocked by walls or furniture"),
        (3.0, "obstacle_detour", "a blocked straight way"),
        (0.9, None, "a start 1.5 to 5 m away"),
    ],
)
def test_impossible_rooms_name_what_they_lack(
    half: float, challenge: Challenge | None, constraint: str
) -> None:
    assert why_not(room(half, ()), slot_of("floor", challenge), swaying()).constraint == constraint


def test_motions_that_cannot_fit_are_told_why() -> None:
    walk = why_not(room(1.3, ()), slot_of("floor"), acting("simple_walk"))
    assert walk.constraint == "floor under the whole motion"
    standing = why_not(room(3.0, ()), slot_of("seat"), swaying())
    assert standing.constraint == "a seat of the right height"


def test_scenes_without_seats_or_closed_doors_say_so() -> None:
    scene = box_room("bare", half=3.0)
    ajar = tuple(dataclasses.replace(door, opening_deg=30.0) for door in scene.doors)
    walled_in = box_room("walled", half=3.0, boxes=[((2.1, 0.0, -1.0), (2.5, 1.0, 1.0))])
    for stage, slot, constraint in (
        (bare(scene, seats=()), slot_of("seat"), "a seat"),
        (bare(scene, doors=()), slot_of("door"), "a door"),
        (bare(scene, doors=ajar), slot_of("door"), "a closed door one can stand before"),
        (bare(walled_in), slot_of("before_seat"), "a seat in reach, with room for legs and trunk"),
    ):
        assert why_not(stage, slot, swaying()).constraint == constraint


def test_ledgers_name_the_first_constraint_that_nothing_meets() -> None:
    ledger = Ledger({"floor": 10})
    left = ledger.keep("light", np.arange(4), np.array([True, False, True, False]))
    assert left.tolist() == [0, 2]
    ledger.keep("light", np.arange(3), np.ones(3, bool))
    assert ledger.binding == "light"
    ledger.keep("air", left, np.zeros(2, bool))
    ledger.note("water", 0)
    assert ledger.binding == "air"
    assert ledger.counts == {"floor": 10, "light": 5, "air": 0, "water": 0}


def test_floor_grid_agrees_with_the_navmesh_to_a_cell() -> None:
    stage = room()
    points = stage.navmesh.random_points(500, np.random.default_rng(1), island=0)
    grid = FloorGrid.of_island(stage.navmesh.islands[0]).around(points)
    exact = stage.navmesh.distance_to_wall(points)
    assert np.abs(grid - exact).max() <= 0.08
    assert (stage.floor.around(points + np.array([20.0, 0.0, 0.0])) == 0.0).all()


def test_measures_find_hands_and_lowest_pelvis() -> None:
    performance = acting("sit_down")["happy"]
    measures = measure_performance(performance)
    pelvis = performance.motion.root_translation * performance.avatar.motion_scale
    low = pelvis[pelvis[:, 1] <= pelvis[:, 1].min() + 0.03].mean(axis=0)
    np.testing.assert_allclose(measures.low_pelvis, low, atol=1e-9)
    assert measure_performance(acting("sit_down")["happy"]) is measures
    wrists = joints_over(
        Placement(np.zeros(3), 0.0, np.zeros(3), 0.0, "room"), acting("knock_door")["sad"]
    )[:, WRISTS, 2]
    hand = measure_performance(acting("knock_door")["sad"]).hand
    assert wrists.max() <= hand[2] <= wrists.max() + 0.25


def test_who_presses_on_the_floor_is_not_in_it() -> None:
    points = np.array([[0.0, -0.02, 1.0], [0.0, 0.001, 0.0], [0.0, -0.07, 0.0], [0.0, 0.4, 0.0]])
    lifted = on_floor(points)
    assert lifted[:2, 1] == pytest.approx(0.005)
    np.testing.assert_array_equal(lifted[2:], points[2:])
    np.testing.assert_array_equal(lifted[:, [0, 2]], points[:, [0, 2]])
