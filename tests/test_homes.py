"""Procedural homes: laws of their geometry, ways through them, seats, doors, light and bytes."""

from __future__ import annotations

import functools

import numpy as np
import pytest
import shapely
from scipy import ndimage

from affectsim_data.builders.homes import HomeRecipe, build_home, home_recipes
from affectsim_data.content import content_path
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Doorway, Room, Scene
from affectsim_data.visibility import RayCaster

UP = np.array([0.0, 1.0, 0.0])
RECIPES = {
    recipe.scene_id: recipe for recipe in home_recipes(content_path("builders", "homes-mini.toml"))
}


@pytest.fixture(params=sorted(RECIPES))
def home(request: pytest.FixtureRequest) -> Scene:
    """Every home of the built-in release, built once, without light."""
    return _home(str(request.param))


@functools.cache
def _home(scene_id: str) -> Scene:
    return _build(RECIPES[scene_id])


def _build(recipe: HomeRecipe, *, seed: int | None = None, lit: bool = False) -> Scene:
    rng = np.random.default_rng(recipe.seed if seed is None else seed)
    return build_home(recipe, rng=rng, lit=lit)


@functools.cache
def _caster(scene: Scene) -> RayCaster:
    return RayCaster(*scene.mesh())


@functools.cache
def _navmesh(scene: Scene) -> NavMesh:
    return NavMesh.from_mesh(*scene.mesh(), agent_radius=0.3, agent_height=1.5)


def _polygon(room: Room) -> shapely.Polygon:
    return shapely.Polygon(room.polygon)


def _inside(room: Room, count: int, rng: np.random.Generator) -> FloatArray:
    """Points in a room, on its floor, `(count, 3)`."""
    low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
    x, z = rng.uniform(low + 0.05, high - 0.05, (count, 2)).T
    return np.stack([x, np.zeros(count), z], axis=1)


def _free_floor(room: Room, caster: RayCaster, *, cell: float) -> np.ndarray:
    """Which cells of a room have nothing taller than a rug on them, bool `(rows, columns)`."""
    low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
    x, z = np.meshgrid(
        np.arange(low[0] + cell / 2, high[0], cell), np.arange(low[1] + cell / 2, high[1], cell)
    )
    up = np.stack([x, np.full_like(x, 0.02), z], axis=-1)
    down = up + 1.9 * UP
    # Both ways, because a ray that starts inside of a thing may leave it through its open bottom.
    clear = ~caster.hidden(up, down) & ~caster.hidden(down, up)
    return np.asarray(clear)


def test_homes_are_of_the_size_of_flats(home: Scene) -> None:
    assert 45.0 <= sum(_polygon(room).area for room in home.rooms) <= 110.0
    assert 2 <= len(home.rooms) <= 4
    x0, z0, x1, z1 = _polygon(home.rooms[0]).bounds
    assert max(x1 - x0, z1 - z0) >= 6.5


def test_budgets_hold(home: Scene) -> None:
    assert 60_000 <= home.num_triangles <= 250_000
    assert len(home.surfaces) <= 24
    assert len(home.to_glb()) < 6_000_000


def test_faces_have_an_area_and_look_where_their_normals_look(home: Scene) -> None:
    for surface in home.surfaces:
        a, b, c = (surface.positions[surface.faces[:, k]].astype(np.float64) for k in range(3))
        cross = np.cross(b - a, c - a)
        assert (np.linalg.norm(cross, axis=1) > 1e-9).all(), surface.name
        lengths = np.linalg.norm(surface.normals, axis=1)
        np.testing.assert_allclose(lengths, 1.0, atol=1e-4)
        mean_normals = surface.normals[surface.faces].mean(axis=1)
        agree = np.einsum("ij,ij->i", cross, mean_normals) > 0.0
        assert agree.mean() > 0.999, surface.name


def test_walls_floors_and_ceilings_face_the_inside_of_rooms(home: Scene) -> None:
    shell = [s for s in home.surfaces if s.name in ("paint", "planks")]
    caster = _caster(home)
    inside = shapely.union_all([_polygon(room).buffer(1e-4) for room in home.rooms])
    for surface in shell:
        corners = surface.positions[surface.faces].astype(np.float64)
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        large = np.linalg.norm(cross, axis=1) > 0.004
        corners, outward = corners[large], -surface.normals[surface.faces[large, 0]]
        middles = corners.mean(axis=1) - 0.03 * outward
        # Doorways lie between rooms: their floor is no room's.
        in_room = shapely.contains_xy(inside, middles[:, 0], middles[:, 2])
        assert in_room.mean() > 0.97, surface.name
        back = caster.distance(middles, outward)
        assert (back < 0.031).all(), surface.name


def test_no_ray_escapes(home: Scene) -> None:
    rng, caster = np.random.default_rng(5), _caster(home)
    for room in home.rooms:
        starts = _inside(room, 20_000, rng) + UP
        starts[:, 1] = rng.uniform(0.05, room.ceiling_y - 0.05, len(starts))
        directions = rng.normal(size=starts.shape)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        assert (caster.distance(starts, directions) < 30.0).all()


def test_a_robot_reaches_every_room_and_no_floor_is_cut_off(home: Scene) -> None:
    navmesh = _navmesh(home)
    caster, start = _caster(home), None
    for room in home.rooms:
        free = ndimage.distance_transform_edt(
            np.pad(_free_floor(room, caster, cell=0.1), 1)
        )[1:-1, 1:-1]  # fmt: skip
        row, column = np.unravel_index(int(np.argmax(free)), free.shape)
        low = np.min(room.polygon, axis=0)
        middle = np.array([low[0] + 0.1 * column + 0.05, 0.0, low[1] + 0.1 * row + 0.05])
        assert navmesh.is_navigable(middle), room.room_id
        start = middle if start is None else start
        assert np.isfinite(navmesh.geodesic_distance(start, middle)), room.room_id


def test_living_rooms_have_free_floor_to_gesture_and_to_walk(home: Scene) -> None:
    free = _free_floor(home.rooms[0], _caster(home), cell=0.1)

    def holds(width_m: float, depth_m: float) -> bool:
        shape = np.ones((round(depth_m / 0.1), round(width_m / 0.1)), bool)
        return bool(ndimage.binary_erosion(free, shape).any())

    assert holds(3.2, 2.2) or holds(2.2, 3.2)


def test_a_long_sight_line_crosses_the_living_room(home: Scene) -> None:
    rng, caster = np.random.default_rng(7), _caster(home)
    points = _inside(home.rooms[0], 1200, rng) + 1.2 * UP
    a, b = points[:600], points[600:]
    far = np.linalg.norm(a - b, axis=1) >= 6.5
    assert (far & ~caster.hidden(a, b)).any()


def test_some_ways_are_detours(home: Scene) -> None:
    navmesh = _navmesh(home)
    caster, points = _caster(home), navmesh.random_points(240, np.random.default_rng(9))
    a, b = points[: len(points) // 2], points[len(points) // 2 : 2 * (len(points) // 2)]
    straight = np.linalg.norm(a - b, axis=1)
    hidden = caster.hidden(a + 0.4 * UP, b + 0.4 * UP)
    ways = navmesh.geodesic_distances(a, b)
    detour = hidden & (straight > 1.2) & np.isfinite(ways) & (ways >= 1.4 * straight)
    assert detour.sum() >= 3


def test_seats_can_be_sat_on(home: Scene) -> None:
    caster = _caster(home)
    assert len(home.seats) >= 4
    for seat in home.seats:
        position = np.array(seat.position)
        assert 0.42 <= seat.position[1] <= 0.48
        down = caster.distance(position + 0.1 * UP, -UP)
        assert 0.07 <= float(down) <= 0.13
        yaw = np.radians(seat.yaw_deg)
        forward = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
        aside = np.array([forward[2], 0.0, -forward[0]])
        for shift in (-0.12, 0.0, 0.12):
            start = position + shift * aside
            above = start + 0.08 * UP
            assert float(caster.distance(above, UP)) > 1.0
            assert float(caster.distance(above, forward)) > 0.7
            # In front of the seat's edge, at the height of shins.
            shin = start + 0.32 * forward + (0.2 - seat.position[1]) * UP
            assert float(caster.distance(shin, forward)) > 0.35


def test_closed_doors_can_be_knocked_on(home: Scene) -> None:
    caster = _caster(home)
    closed = [door for door in home.doors if door.is_closed]
    assert 2 <= len(closed) <= 4
    for door in closed:
        point, yaw = np.array(door.knock_point), np.radians(door.yaw_deg)
        out = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
        assert door.knock_point[1] == pytest.approx(1.4)
        assert 1.9 <= door.height <= 2.1
        to_leaf = float(caster.distance(point + 0.3 * out, -out))
        assert to_leaf == pytest.approx(0.3, abs=0.01)
        for height in (0.2, 1.0, 1.7):
            before = np.array([point[0], height, point[2]]) + 0.1 * out
            assert float(caster.distance(before, out)) > 1.0
        (room,) = [room for room in home.rooms if room.room_id == door.room_id]
        assert _polygon(room).contains(shapely.Point((point + 0.3 * out)[[0, 2]]))


def test_open_leaves_are_where_their_semantics_say(home: Scene) -> None:
    caster = _caster(home)
    for door in home.doors:
        if door.is_closed:
            continue
        assert 90.0 <= door.opening_deg <= 100.0
        point, yaw = np.array(door.knock_point), np.radians(door.yaw_deg)
        out = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
        assert float(caster.distance(point + 0.2 * out, -out)) == pytest.approx(0.2, abs=0.01)
        hinge = np.array(door.hinge)
        assert np.linalg.norm((point - hinge)[[0, 2]]) == pytest.approx(door.width / 2.0, abs=1e-6)


def test_doorways_are_the_only_holes_between_rooms(home: Scene) -> None:
    """Rays from room to room pass through the rectangle of a doorway, and those are free."""
    rng, caster = np.random.default_rng(11), _caster(home)
    for doorway in home.doorways:
        yaw, middle = np.radians(doorway.yaw_deg), np.array(doorway.position)
        through = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
        first, second = (
            next(room for room in home.rooms if room.room_id == room_id)
            for room_id in doorway.room_ids
        )
        assert _polygon(first).contains(shapely.Point((middle - 0.3 * through)[[0, 2]]))
        assert _polygon(second).contains(shapely.Point((middle + 0.3 * through)[[0, 2]]))
        across = np.array([through[2], 0.0, -through[0]])
        u, v = rng.uniform(-0.49, 0.49, 200), rng.uniform(0.15, 0.98, 200)
        spots = middle + np.outer(u * doorway.width, across) + np.outer(v * doorway.height, UP)
        starts = spots - 0.5 * doorway.depth * through
        free = caster.distance(starts, np.broadcast_to(through, starts.shape))
        assert (free > doorway.depth).all()
    points = np.concatenate([_inside(room, 3000, rng) for room in home.rooms])
    points[:, 1] = rng.uniform(0.1, 2.4, len(points))
    owner = np.repeat(np.arange(len(home.rooms)), 3000)
    other = rng.permutation(len(points))
    a, b = points, points[other]
    seen = ~caster.hidden(a, b) & (owner != owner[other])
    assert seen.any()
    crosses = np.zeros(len(a), bool)
    for doorway in home.doorways:
        crosses |= _passes(doorway, a, b)
    assert crosses[seen].all()


def _passes(doorway: Doorway, a: FloatArray, b: FloatArray) -> np.ndarray:
    """Which segments `a` to `b` pass the middle of a doorway's rectangle, `(n,)`."""
    yaw, middle = np.radians(doorway.yaw_deg), np.array(doorway.position)
    through = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
    across = np.array([through[2], 0.0, -through[0]])
    start, end = (a - middle) @ through, (b - middle) @ through
    share = np.divide(start, start - end, out=np.full(len(a), -1.0), where=start != end)
    spot = a + share[:, None] * (b - a) - middle
    inside = (np.abs(spot @ across) <= doorway.width / 2.0) & (spot[:, 1] <= doorway.height)
    return np.asarray((share > 0.0) & (share < 1.0) & inside)


def test_furniture_is_told_by_name_and_place(home: Scene) -> None:
    assert len({one.object_id for one in home.objects}) == len(home.objects)
    rooms = {room.room_id: _polygon(room).buffer(0.05) for room in home.rooms}
    assert {one.category for one in home.objects} >= {"bed", "sofa"}
    for one in home.objects:
        assert one.category
        assert rooms[one.room_id].contains(shapely.Polygon(one.footprint)), one.object_id
        assert one.position[1] >= -0.001


def test_baked_colours_are_neither_black_nor_all_white() -> None:
    recipe = RECIPES["mini/flat_b"]
    home, unlit = _build(recipe, lit=True), _home(recipe.scene_id)
    assert home.semantics() == unlit.semantics()
    assert home.num_triangles == unlit.num_triangles
    for surface in home.surfaces:
        assert (surface.colors[:, 3] == 255).all()
        assert int(surface.colors[:, :3].min()) >= 20
    walls = next(surface for surface in home.surfaces if surface.name == "paint")
    bright = walls.colors[:, :3].max(axis=1)
    assert 190 <= np.percentile(bright, 60) <= 235
    assert np.percentile(bright, 1) >= 30


def test_a_glb_round_trip_keeps_everything(home: Scene) -> None:
    again = Scene.from_glb(home.to_glb(), name="home")
    assert again.semantics() == home.semantics()
    assert again.mesh_sha256() == home.mesh_sha256()


def test_the_same_seed_gives_the_same_bytes_and_another_does_not() -> None:
    recipe = RECIPES["mini/flat_b"]
    first = _home(recipe.scene_id).to_glb()
    assert first == _build(recipe).to_glb()
    assert first != _build(recipe, seed=recipe.seed + 1).to_glb()
