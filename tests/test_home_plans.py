"""Floor plans: what every home has, how its rooms join, and what a recipe cannot ask for."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely

from affectsim_data.builders.homes import HomePlan, HomeRecipe, RoomPlan, home_recipes, plan_home
from affectsim_data.builders.homes.doors import leaves_of
from affectsim_data.builders.homes.plans import WALL_THICKNESS, Opening, Rect, overlaps
from affectsim_data.builders.homes.purposes import NEEDS_DAYLIGHT, SIZES, Purpose, room_areas
from affectsim_data.content import content_path

RECIPES = home_recipes(content_path("builders", "homes-full.toml"))


@pytest.fixture(scope="module")
def plans() -> list[HomePlan]:
    return [plan(recipe) for recipe in RECIPES]


def plan(recipe: HomeRecipe, seed: int | None = None) -> HomePlan:
    return plan_home(recipe, rng=np.random.default_rng(recipe.seed if seed is None else seed))


def rect(room: RoomPlan) -> Rect:
    return (room.x0, room.z0, room.x1, room.z1)


def inside(inner: Rect, outer: Rect) -> bool:
    low = inner[0] >= outer[0] - 1e-6 and inner[1] >= outer[1] - 1e-6
    return low and inner[2] <= outer[2] + 1e-6 and inner[3] <= outer[3] + 1e-6


def openings(home: HomePlan, kind: str) -> list[tuple[RoomPlan, Opening]]:
    return [(room, one) for room in home.rooms for one in room.openings if one.kind == kind]


def ways(home: HomePlan) -> dict[str, set[str]]:
    """Rooms that each room opens into."""
    return {
        room.room_id: {one.to_room for one in room.openings if one.kind == "doorway"}
        for room in home.rooms
    }


def reached(joined: dict[str, set[str]], *, without: set[str], start: str) -> set[str]:
    """Rooms one comes to from a room."""
    found, queue = {start}, [start]
    while queue:
        for other in joined[queue.pop()] - found - without:
            found.add(other)
            queue.append(other)
    return found


def test_homes_have_the_rooms_and_the_floor_their_recipes_ask_for(plans: list[HomePlan]) -> None:
    for recipe, home in zip(RECIPES, plans, strict=True):
        assert len(home.rooms) == recipe.rooms
        assert 40.0 <= home.area_m2 <= 180.0
        assert home.area_m2 == pytest.approx(recipe.area_m2, rel=0.021)
        assert len({room.room_id for room in home.rooms}) == len(home.rooms)
    assert {len(home.rooms) for home in plans} == set(range(2, 8))
    assert min(home.area_m2 for home in plans) < 55.0
    assert max(home.area_m2 for home in plans) > 150.0


def test_rooms_have_the_size_of_their_purpose(plans: list[HomePlan]) -> None:
    for home in plans:
        for room in home.rooms:
            size = SIZES[room.purpose]
            short, long = sorted((room.x1 - room.x0, room.z1 - room.z0))
            assert 0.94 * size.least_m2 <= room.area_m2 <= 1.06 * size.most_m2
            assert short >= size.side_m - 0.06
            assert long <= 1.16 * size.aspect * short
            assert 2.5 <= room.ceiling_y <= 2.7


def test_walls_stand_between_rooms(plans: list[HomePlan]) -> None:
    for home in plans:
        for a, b in itertools.combinations(home.rooms, 2):
            apart = shapely.box(*rect(a)).distance(shapely.box(*rect(b)))
            assert apart > WALL_THICKNESS - 0.001


def test_the_living_room_is_the_largest_and_shows_far(plans: list[HomePlan]) -> None:
    for home in plans:
        living = home.living
        assert living.purpose == "living"
        assert living.area_m2 >= 17.1
        assert all(room.area_m2 <= living.area_m2 for room in home.rooms)
        longest = max(living.x1 - living.x0, living.z1 - living.z0)
        for opening in living.openings:
            if opening.is_wide:
                other = home.room(opening.to_room)
                first, last = (0, 2) if opening.side in ("left", "right") else (1, 3)
                ends = [rect(living)[first], rect(other)[first]]
                far = [rect(living)[last], rect(other)[last]]
                longest = max(longest, max(far) - min(ends))
        assert longest >= 6.5 or home.area_m2 < 55.0


def test_living_rooms_keep_floor_free_to_gesture_and_to_walk(plans: list[HomePlan]) -> None:
    for home in plans:
        least = (3.2, 2.2) if home.living.area_m2 >= 20.0 else (2.4, 1.8)
        sizes = [sorted((x1 - x0, z1 - z0)) for x0, z0, x1, z1 in home.living.clear]
        assert any(b >= least[0] - 1e-6 and a >= least[1] - 1e-6 for a, b in sizes)
        assert all(inside(clear, rect(home.living)) for clear in home.living.clear)


def test_every_room_is_reached_and_none_through_a_bath(plans: list[HomePlan]) -> None:
    for home in plans:
        joined, start = ways(home), home.living.room_id
        assert reached(joined, without=set(), start=start) == set(joined)
        assert all(a in joined[b] for a in joined for b in joined[a])
        for room in home.rooms:
            if room.purpose == "bath":
                assert len(joined[room.room_id]) == 1


def test_nobody_walks_through_a_bedroom_where_there_is_a_hall(plans: list[HomePlan]) -> None:
    for home in plans:
        joined = ways(home)
        purposes = {room.room_id: room.purpose for room in home.rooms}
        if "hall" not in purposes.values():
            continue
        for room_id in (name for name, purpose in purposes.items() if purpose == "bedroom"):
            rest = reached(joined, without={room_id}, start=home.living.room_id)
            assert {purposes[one] for one in set(joined) - rest - {room_id}} <= {"bath"}


def test_plans_differ_in_kind(plans: list[HomePlan]) -> None:
    loops = [len(openings(home, "doorway")) // 2 - len(home.rooms) + 1 for home in plans]
    assert sum(loop > 0 for loop in loops) >= 12
    hulls = [
        shapely.union_all([shapely.box(*rect(room)).buffer(0.08) for room in home.rooms])
        for home in plans
    ]
    filled = [hull.area / hull.envelope.area for hull in hulls]
    assert sum(share > 0.97 for share in filled) >= 10
    assert sum(share < 0.92 for share in filled) >= 10
    wide = sum(one.is_wide for home in plans for _, one in openings(home, "doorway")) // 2
    assert wide >= 20
    shapes = {tuple(sorted(rect(home.living))) for home in plans}
    assert len(shapes) == len(plans)


def test_doorways_have_two_faces(plans: list[HomePlan]) -> None:
    for home in plans:
        for room, opening in openings(home, "doorway"):
            other = home.room(opening.to_room)
            (back,) = [
                one
                for one in other.openings
                if one.to_room == room.room_id and one.middle == opening.middle
            ]
            assert (back.width, back.top) == (opening.width, opening.top)
            assert opening.leaf is None or back.leaf is None
            face = room.wall(opening.side).point(room.wall(opening.side).u_of(opening.middle))
            beyond = other.wall(back.side).point(other.wall(back.side).u_of(back.middle))
            assert np.linalg.norm(face - beyond) == pytest.approx(WALL_THICKNESS, abs=0.001)


def test_openings_fit_their_walls_and_do_not_meet(plans: list[HomePlan]) -> None:
    for home in plans:
        for room, wall in [(one, wall) for one in home.rooms for wall in one.walls()]:
            low, high = room.span(wall.side)
            spans = sorted(one.span for one in room.openings_in(wall.side))
            assert all(start >= low + 0.1 and end <= high - 0.1 for start, end in spans)
            assert all(b[0] - a[1] >= 0.1 for a, b in itertools.pairwise(spans))
            for one in room.openings_in(wall.side):
                assert one.top <= room.ceiling_y - 0.2
                if one.kind != "window" and not one.is_wide:
                    assert 0.89 <= one.width <= 1.0
                    assert 2.0 <= one.top <= 2.1
                if one.is_wide:
                    assert 1.6 <= one.width <= 3.0


def test_windows_and_closed_doors_lead_outside(plans: list[HomePlan]) -> None:
    for home in plans:
        rooms = shapely.union_all([shapely.box(*rect(room)) for room in home.rooms])
        for room, opening in openings(home, "window") + openings(home, "door"):
            outside = room.wall(opening.side).rect(opening.span, -0.5)
            assert not shapely.box(*outside).buffer(-0.01).intersects(rooms)
        for room in home.rooms:
            if room.purpose in NEEDS_DAYLIGHT:
                assert any(one.kind == "window" for one in room.openings)


def test_homes_have_an_entrance_and_other_closed_doors_with_floor_before_them(
    plans: list[HomePlan],
) -> None:
    for home in plans:
        closed = openings(home, "door")
        assert 2 <= len(closed) <= 4
        purposes = [room.purpose for room in home.rooms]
        if "hall" in purposes and any(room.purpose == "hall" for room, _ in closed):
            assert closed[0][0].purpose != "bath"
        for room, door in closed:
            assert door.leaf is not None
            assert door.leaf.angle_deg == 0.0
            low, high = door.middle - 0.6, door.middle + 0.6
            free = room.wall(door.side).rect((low, high), 1.1)
            assert inside(free, rect(room))
            assert any(inside(free, clear) for clear in room.clear)
            assert not any(overlaps(free, leaf) for leaf in room.blocked)


def test_open_leaves_stand_against_a_wall_out_of_the_way(plans: list[HomePlan]) -> None:
    number = 0
    for home in plans:
        for room, _, pose in leaves_of(home):
            opening = pose.opening
            if opening.kind != "doorway":
                continue
            number += 1
            assert opening.leaf is not None
            assert 90.0 <= opening.leaf.angle_deg <= 100.0
            assert room.purpose != "hall"
            tip = pose.hinge + pose.width * pose.along
            corners = [pose.hinge, tip, pose.hinge - 0.04 * pose.face, tip - 0.04 * pose.face]
            plan_corners = [(float(point[0]), float(point[2])) for point in corners]
            (blocked,) = [
                leaf for leaf in room.blocked if shapely.box(*leaf).covers(
                    shapely.MultiPoint(plan_corners)
                )
            ]  # fmt: skip
            # The wall that the leaf stands along is right beside it.
            edges = [abs(blocked[k] - rect(room)[k]) for k in range(4)]
            assert sum(edge < 0.011 for edge in edges) >= 2
            clear = opening.width - 0.065 + math.sin(math.radians(opening.leaf.angle_deg - 90.0))
            assert clear >= 0.85
            for other in room.openings:
                if other.kind != "window" and other is not opening:
                    before = room.wall(other.side).rect(other.span, 0.9)
                    assert not overlaps(blocked, before)
    assert number >= 57


def test_the_same_seed_gives_the_same_plan_and_another_does_not() -> None:
    for recipe in RECIPES[::19]:
        assert plan(recipe) == plan(recipe)
        assert plan(recipe) != plan(recipe, seed=recipe.seed + 1)


def test_shares_of_floor_add_up() -> None:
    purposes: tuple[Purpose, ...] = ("living", "hall", "bedroom", "bath")
    areas = room_areas(purposes, 66.0, np.random.default_rng(4))
    assert sum(areas.values()) == pytest.approx(66.0)
    assert all(
        SIZES[purpose].least_m2 <= areas[number] <= SIZES[purpose].most_m2
        for number, purpose in enumerate(purposes)
    )


def test_a_home_that_cannot_be_is_refused() -> None:
    with pytest.raises(ValueError, match="home 'a': rooms must be 2 to 7, got 60"):
        HomeRecipe("a", 1, 60, 40.0)
    with pytest.raises(ValueError, match=r"home 'a': area_m2 of 7 such rooms must be .*, got 40"):
        HomeRecipe("a", 1, 7, 40.0)
    with pytest.raises(ValueError, match="rooms must have one living, got 0"):
        HomeRecipe("a", 1, ("bedroom", "bath"), 40.0)
    with pytest.raises(ValueError, match=r"rooms must be of living, .*, got 'cellar'"):
        HomeRecipe("a", 1, ("living", "cellar"), 40.0)  # type: ignore[arg-type]


def test_a_plan_that_is_not_found_ends_in_one_clear_error() -> None:
    dining: tuple[Purpose, ...] = ("dining",) * 6
    rooms: tuple[Purpose, ...] = ("living", *dining)
    recipe = HomeRecipe("a", 1, rooms, 72.2)
    with pytest.raises(ValueError, match=r"home 'a': found no plan of .* m2 in \d+ tries; change"):
        plan(recipe)
