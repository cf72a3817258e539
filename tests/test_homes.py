"""Procedural homes: laws of their geometry, ways through them, seats, doors, light and bytes."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import shapely
from scipy import ndimage

from affectsim_data.builders.homes import HomeRecipe, build_home, home_recipes
from affectsim_data.content import content_path
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room, Scene
from affectsim_data.visibility import RayCaster

UP = np.array([0.0, 1.0, 0.0])
RECIPES = {
    recipe.scene_id: recipe for recipe in home_recipes(content_path("builders", "homes-mini.toml"))
}
_BUILT: dict[str, Scene] = {}


@pytest.fixture(params=sorted(RECIPES))
def home(request: pytest.FixtureRequest) -> Scene:
    """Every home of the built-in release, built once."""
    scene_id = str(request.param)
    if scene_id not in _BUILT:
        _BUILT[scene_id] = _build(RECIPES[scene_id])
    return _BUILT[scene_id]


def _build(recipe: HomeRecipe, seed: int | None = None) -> Scene:
    return build_home(recipe, rng=np.random.default_rng(recipe.seed if seed is None else seed))


def _caster(scene: Scene) -> RayCaster:
    return RayCaster(*scene.mesh())


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
    assert x1 - x0 >= 6.0
    assert z1 - z0 >= 5.0
    assert np.hypot(x1 - x0, z1 - z0) >= 8.5


def test_rooms_do_not_overlap(home: Scene) -> None:
    polygons = [_polygon(room) for room in home.rooms]
    for index, polygon in enumerate(polygons):
        assert polygon.is_valid
        assert all(polygon.distance(other) > 0.05 for other in polygons[index + 1 :])


def test_budgets_hold(home: Scene) -> None:
    assert 30_000 <= home.num_triangles <= 150_000
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
    shell = [s for s in home.surfaces if s.name in ("paint", "planks", "tiles")]
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
        assert in_room.mean() > 0.99, surface.name
        back = caster.distance(middles, outward)
        assert (back < 0.031).all(), surface.name


def test_no_ray_escapes(home: Scene) -> None:
    rng, caster = np.random.default_rng(5), _caster(home)
    for room in home.rooms:
        starts = _inside(room, 20_000, rng) + UP
        starts[:, 1] = rng.uniform(0.05, 2.55, len(starts))
        directions = rng.normal(size=starts.shape)
        directions /= np.linalg.norm(directions, axis=1, keepdims=True)
        assert (caster.distance(starts, directions) < 30.0).all()


def test_a_robot_reaches_every_room_and_no_floor_is_cut_off(home: Scene) -> None:
    navmesh = NavMesh.from_mesh(*home.mesh(), agent_radius=0.3, agent_height=1.5)
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


def test_living_area_has_free_floor_to_gesture_and_to_walk(home: Scene) -> None:
    free = _free_floor(home.rooms[0], _caster(home), cell=0.1)

    def holds(width_m: float, depth_m: float) -> bool:
        shape = np.ones((round(depth_m / 0.1), round(width_m / 0.1)), bool)
        return bool(ndimage.binary_erosion(free, shape).any())

    assert holds(2.5, 2.5)
    assert holds(4.0, 1.6)


def test_a_long_sight_line_crosses_the_living_area(home: Scene) -> None:
    rng, caster = np.random.default_rng(7), _caster(home)
    points = _inside(home.rooms[0], 1200, rng) + 1.2 * UP
    a, b = points[:600], points[600:]
    far = np.linalg.norm(a - b, axis=1) >= 7.0
    assert (far & ~caster.hidden(a, b)).any()


def test_the_divider_makes_detours(home: Scene) -> None:
    navmesh = NavMesh.from_mesh(*home.mesh(), agent_radius=0.3, agent_height=1.5)
    rng = np.random.default_rng(9)
    points = navmesh.random_points(400, rng)
    living = _polygon(home.rooms[0])
    points = points[shapely.contains_xy(living, points[:, 0], points[:, 2])]
    a, b = points[: len(points) // 2], points[len(points) // 2 : 2 * (len(points) // 2)]
    straight = np.linalg.norm(a - b, axis=1)
    ways = np.array([navmesh.geodesic_distance(p, q) for p, q in zip(a, b, strict=True)])
    detour = (straight > 1.2) & (straight < 5.0) & (ways >= 1.4 * straight)
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


def test_doors_can_be_knocked_on(home: Scene) -> None:
    caster = _caster(home)
    assert len(home.doors) >= 2
    for door in home.doors:
        point, yaw = np.array(door.knock_point), np.radians(door.yaw_deg)
        out = np.array([np.sin(yaw), 0.0, np.cos(yaw)])
        assert 1.2 <= door.knock_point[1] <= 1.6
        to_leaf = float(caster.distance(point + 0.3 * out, -out))
        assert to_leaf == pytest.approx(0.3, abs=0.015)
        for height in (0.2, 1.0, 1.7):
            before = np.array([point[0], height, point[2]]) + 0.1 * out
            assert float(caster.distance(before, out)) > 0.75


def test_colours_are_neither_black_nor_all_white(home: Scene) -> None:
    for surface in home.surfaces:
        assert (surface.colors[:, 3] == 255).all()
        assert int(surface.colors[:, :3].min()) >= 45
    walls = next(surface for surface in home.surfaces if surface.name == "paint")
    bright = walls.colors[:, :3].max(axis=1)
    assert 190 <= np.percentile(bright, 60) <= 235
    assert np.percentile(bright, 1) >= 60


def test_a_glb_round_trip_keeps_everything(home: Scene) -> None:
    again = Scene.from_glb(home.to_glb(), name="home")
    assert again.semantics() == home.semantics()
    assert again.mesh_sha256() == home.mesh_sha256()


def test_the_same_seed_gives_the_same_bytes_and_another_does_not() -> None:
    recipe = RECIPES["mini/flat_b"]
    first = _build(recipe).to_glb()
    assert first == _build(recipe).to_glb()
    assert first != _build(recipe, seed=recipe.seed + 1).to_glb()


def test_mirroring_turns_the_plan_over() -> None:
    recipe = RECIPES["mini/flat_b"]
    straight = _build(dataclasses.replace(recipe, mirror=False))
    mirrored = _build(dataclasses.replace(recipe, mirror=True))
    for a, b in zip(straight.seats, mirrored.seats, strict=True):
        assert b.position == (-a.position[0], *a.position[1:])
        assert b.yaw_deg == -a.yaw_deg


def test_a_recipe_that_is_too_small_is_refused() -> None:
    recipe = RECIPES["mini/flat_b"]
    with pytest.raises(ValueError, match="at least 8 x 5 m"):
        dataclasses.replace(recipe, living=(5.0, 5.0))


def test_a_broken_recipe_file_says_what_is_missing(tmp_path: Path) -> None:
    path = tmp_path / "homes.toml"
    path.write_text("[palettes]\n[[home]]\nscene_id = 'a'\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"homes\.toml: 'living' is missing"):
        home_recipes(path)
