"""Baking: a baked scene looks and blocks as before, within its limits, and bakes to itself."""

from __future__ import annotations

import dataclasses
import functools
import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest
import shapely
import trimesh
from baking_scenes import looks, picture, points_on, tile, wall_of_pictures
from hypothesis import given, settings
from hypothesis import strategies as st
from render_scenes import CAMERA, clip, furnished_room, grid, one_room, scene_of
from small_release import box_quads, box_room, surface

from affectsim_data.builders.homes import build_home, home_recipes
from affectsim_data.cameras import CameraTrajectory
from affectsim_data.content import content_path
from affectsim_data.errors import MissingExtraError
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.render.rasterizer import EglRenderer
from affectsim_data.scenes import Room, Scene, Surface
from affectsim_data.scenes.baking import BakeReport, bake_scene, baking
from affectsim_data.scenes.baking.losses import measure_loss
from affectsim_data.scenes.baking.packing import pack_rectangles
from affectsim_data.scenes.baking.welding import weld_surface
from affectsim_data.scenes.face_rooms import face_rooms
from affectsim_data.visibility import RayCaster

ROOM = furnished_room(num_triangles=12_000, rng=np.random.default_rng(3))
SHEET = grid((0, 0, 0), (2, 0, 0), (0, 0, -2), 20, color=(200, 180, 160), name="sheet")


def _corners(scene: Scene) -> FloatArray:
    vertices, faces = scene.mesh()
    return vertices[faces]


def _area(scene: Scene) -> float:
    a, b, c = np.moveaxis(_corners(scene), 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def _same_place(before: Scene, after: Scene) -> float:
    """Largest distance between the corners of triangles that belong together, metres."""
    from scipy.spatial import cKDTree

    old, new = _corners(before), _corners(after)
    assert len(old) == len(new)
    _, partner = cKDTree(new.mean(axis=1)).query(old.mean(axis=1))
    gaps = np.linalg.norm(old[:, :, None] - new[partner][:, None], axis=3).min(axis=2)
    return float(gaps.max())


@functools.cache
def _home() -> Scene:
    """A home of the built-in release; its light does not matter here."""
    recipe = home_recipes(content_path("builders", "homes-mini.toml"))[1]
    return build_home(recipe, rng=np.random.default_rng(recipe.seed), lit=False)


@functools.cache
def _baked_home() -> tuple[Scene, BakeReport]:
    return bake_scene(_home())


@pytest.mark.egl
@pytest.mark.parametrize("name", ["room", "home"])
def test_a_baked_scene_is_drawn_as_before(name: str) -> None:
    scene = ROOM if name == "room" else _home()
    baked = bake_scene(ROOM)[0] if name == "room" else _baked_home()[0]
    eyes, targets = [], []
    for room in scene.rooms:
        low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
        x, z = np.clip(low + 0.5, low, high)
        eyes.append((x, 1.6, z))
        targets.append((*(low + high) / 2.0, 0.9))
    path = CameraTrajectory(look_at(np.array(eyes), np.array(targets)[:, [0, 2, 1]]))
    renderer = EglRenderer(cache_bytes=2**28)
    before, after = (renderer.render(clip(one, path, camera=CAMERA)) for one in (scene, baked))
    renderer.close()
    # Silhouettes may move by the 0.06 mm of the grid: now and then a pixel falls on another thing.
    np.testing.assert_array_equal(np.isfinite(before.depth), np.isfinite(after.depth))
    gaps = np.abs(np.where(np.isfinite(before.depth), before.depth - after.depth, 0.0))
    assert np.mean(gaps > 1e-3) < 3e-3
    difference = np.abs(before.rgb.astype(int) - after.rgb)
    assert difference.mean() < 0.15
    assert np.mean(difference.max(axis=3) > 8) < 3e-3


def test_a_baked_home_is_a_home_of_few_calls() -> None:
    (baked, report), scene = _baked_home(), _home()
    assert len(baked.surfaces) < len(scene.surfaces) <= 32
    assert [one.name for one in baked.surfaces if one.texture is None] == ["plain"]
    assert report.after.num_bytes < 1.2 * report.before.num_bytes
    assert _area(baked) == pytest.approx(_area(scene), rel=1e-3)
    assert baked.semantics() == scene.semantics()
    assert bake_scene(baked)[0].to_glb() == baked.to_glb()


def test_chunks_of_a_home_are_inside_their_rooms() -> None:
    baked, _ = _baked_home()
    chunks = baked.chunks
    assert chunks is not None
    inside = np.bincount(chunks.room + 1, weights=chunks.count, minlength=len(baked.rooms) + 1)
    assert inside[0] < 0.1 * baked.num_triangles
    assert (inside[1:] > 0).all()
    for index, room in enumerate(baked.rooms):
        mine = chunks.room == index
        low, high = np.min(room.polygon, axis=0) - 0.021, np.max(room.polygon, axis=0) + 0.021
        assert (chunks.low[mine][:, [0, 2]] >= low).all()
        assert (chunks.high[mine][:, [0, 2]] <= high).all()


def test_rays_go_as_far_as_before() -> None:
    baked, _ = bake_scene(ROOM)
    rng = np.random.default_rng(5)
    origins = rng.uniform((-4.0, 1.3, -4.0), (4.0, 2.4, 4.0), (4000, 3))
    ways = rng.normal(size=(4000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    before, after = (RayCaster(*s.mesh()).distance(origins, ways) for s in (ROOM, baked))
    assert np.isfinite(before).all()
    # Grazing rays go further for the 0.06 mm a face may move.
    assert np.mean(np.abs(before - after) > 1e-3) < 2e-3


def test_triangles_keep_their_places_and_their_area() -> None:
    baked, report = bake_scene(ROOM)
    assert _same_place(ROOM, baked) < 1.1e-4
    assert _area(baked) == pytest.approx(_area(ROOM), rel=1e-4)
    assert report.loss is None
    assert report.after.triangles == ROOM.num_triangles


def test_positions_lie_on_the_grid_and_normals_are_unit() -> None:
    for one in bake_scene(ROOM)[0].surfaces:
        cells = one.positions.astype(np.float64) * 8192
        np.testing.assert_array_equal(cells, np.rint(cells))
        np.testing.assert_allclose(np.linalg.norm(one.normals, axis=1), 1.0, atol=4e-3)


@pytest.mark.parametrize(
    "scene", [ROOM, one_room(), wall_of_pictures(9), box_room("box"), scene_of(SHEET)]
)
def test_baking_twice_is_baking_once(scene: Scene) -> None:
    once, _ = bake_scene(scene, max_draw_calls=4, texture_budget=2**15)
    twice, report = bake_scene(once, max_draw_calls=4, texture_budget=2**15)
    assert twice.to_glb() == once.to_glb()
    assert report.before == report.after
    assert not report.notes


def test_the_same_scene_gives_the_same_bytes() -> None:
    limits = {"max_draw_calls": 3, "texture_budget": 2**14, "max_triangles": 100}
    first, second = (bake_scene(wall_of_pictures(12), **limits)[0] for _ in range(2))
    assert first.to_glb() == second.to_glb()


def test_trimesh_opens_a_baked_scene() -> None:
    baked, _ = bake_scene(wall_of_pictures(20), max_draw_calls=3)
    opened = trimesh.load_scene(io.BytesIO(baked.to_glb()), file_type="glb")
    assert sum(len(mesh.faces) for mesh in opened.geometry.values()) == 40
    assert len(opened.geometry) == 3
    assert Scene.from_glb(baked.to_glb(), name="file").to_glb() == baked.to_glb()


# ------------------------------------------------------------------------ merging and atlases


def test_surfaces_that_look_alike_become_one() -> None:
    wood = picture(16, 1)
    parts = [tile(f"t{i}", (2.0 * i, 0, 0), wood.copy()) for i in range(5)]
    plain = [tile(f"p{i}", (2.0 * i, 3, 0), None) for i in range(5)]
    baked, report = bake_scene(scene_of(*parts, *plain))
    assert [one.name for one in baked.surfaces] == ["p0", "t0"]
    assert (report.before.surfaces, report.after.surfaces) == (10, 2)
    assert report.after.textures == 1


def test_a_texture_of_one_colour_becomes_vertex_colours() -> None:
    flat = np.full((8, 8, 3), (200, 100, 50), np.uint8)
    scene = scene_of(tile("flat", (0, 0, 0), flat))
    baked, report = bake_scene(scene)
    assert baked.surfaces[0].texture is None
    points = points_on(scene, 20)
    np.testing.assert_allclose(looks(baked, points), looks(scene, points), atol=1.0)
    assert report.notes == ("1 textures of one colour became vertex colours",)


@pytest.mark.parametrize(
    "uv",
    [
        (0.0, 0.0, 1.0, 1.0),
        (0.25, 0.5, 0.5, 0.75),
        (0.0, 0.0, 3.0, 2.0),
        (-2.6, -1.3, -0.4, 0.2),
        (7.9, 100.2, 8.1, 99.6),
        (0.3, 0.3, 0.3, 0.3),
    ],
)
def test_an_atlas_shows_what_textures_showed(uv: tuple[float, float, float, float]) -> None:
    tiles = [tile(f"t{i}", (1.5 * i, 0, 0), picture(32, i), uv=uv) for i in range(8)]
    scene = scene_of(*tiles)
    baked, report = bake_scene(scene, max_draw_calls=4)
    assert len(baked.surfaces) == 4
    assert sum(one.name.startswith("atlas") for one in baked.surfaces) == 1
    assert report.notes[0] == "5 textures share 1 atlas pages with gutters of 8 texels"
    points = points_on(scene, 400)
    # Half a step of the grid of texture coordinates is 1/32 texel, over 8 levels a texel.
    np.testing.assert_allclose(looks(baked, points), looks(scene, points), atol=1.6)


def test_mipmaps_of_a_page_stay_apart() -> None:
    import cv2

    white, black = np.full((32, 32, 3), 255, np.uint8), np.zeros((32, 32, 3), np.uint8)
    white[0, 0] = black[0, 0] = (0, 255, 0)  # not of one colour
    tiles = [tile(f"t{i}", (2.0 * i, 0, 0), (white, black)[i % 2].copy()) for i in range(2)]
    tiles[1] = dataclasses.replace(tiles[1], texture=np.where(black == 255, 254, black))
    extra = [tile(f"e{i}", (2.0 * i, 3, 0), picture(64, i), uv=(0, 0, 4, 4)) for i in range(2)]
    baked, _ = bake_scene(scene_of(*tiles, *extra), max_draw_calls=3)
    page = baked.surfaces[-1]
    assert page.name == "atlas_0"
    assert page.texture is not None
    assert page.uvs is not None
    height, width = page.texture.shape[:2]
    small = cv2.resize(page.texture, (width // 8, height // 8), interpolation=cv2.INTER_AREA)
    for one, level in zip(tiles, (255, 0), strict=True):
        near = np.abs(page.positions[:, 0] - one.positions[:, 0].mean()) < 0.6
        middle = page.uvs[near].mean(axis=0)
        x, y = (middle * (width // 8, height // 8)).astype(int)
        # The chart is 4 x 4 texels there: all but the corner with the odd texel are pure.
        block = small[y - 1 : y + 2, x - 1 : x + 2].reshape(-1, 3)
        assert (block == level).all()


def test_a_texture_that_repeats_often_keeps_its_own_call() -> None:
    floor = tile("floor", (0, 5, 0), picture(64, 99), uv=(0, 0, 40, 40), size=8.0)
    scene = wall_of_pictures(12)
    scene = dataclasses.replace(scene, surfaces=(*scene.surfaces, floor))
    baked, _ = bake_scene(scene, max_draw_calls=2)
    names = [one.name for one in baked.surfaces]
    assert names == ["floor", "atlas_0"]
    np.testing.assert_array_equal(baked.surfaces[0].texture, floor.texture)


@pytest.mark.parametrize(("repeats", "is_lost"), [(30, False), (550, False), (3000, True)])
def test_textures_that_repeat_too_often_for_a_page_are_made_smaller(
    repeats: float, is_lost: bool
) -> None:
    floors = [
        tile(f"floor{i}", (0, 5.0 * i, 0), picture(64, i), uv=(0, 0, 400, repeats), size=4.0)
        for i in range(3)
    ]
    baked, report = bake_scene(scene_of(*floors), max_draw_calls=2)
    assert [one.name for one in baked.surfaces] == ["floor0", "atlas_0"]
    assert all(max(one.texture.shape) <= 2048 for one in baked.surfaces if one.texture is not None)
    assert "textures were made smaller, to at most" in report.notes[1]
    assert any("2 of them are hardly more than" in note for note in report.notes) == is_lost


def test_textures_on_no_area_are_no_trouble() -> None:
    flat = tile("line", (0, 0, 0), picture(64, 1))
    line = dataclasses.replace(flat, positions=flat.positions * np.array([1, 0, 0], np.float32))
    baked, report = bake_scene(scene_of(line, tile("t", (3, 0, 0), None)), texture_budget=100)
    assert [one.name for one in baked.surfaces] == ["t"]
    assert report.notes[0] == "1 textures were made smaller, to at most 0 texels a metre"


def test_what_pages_cannot_hold_leaves_other_textures_alone() -> None:
    floors = [
        tile(f"f{i}", (0, 9.0 * i, 0), picture(256, i), uv=(0, 0, 9, 9), size=8.0) for i in range(4)
    ]
    baked, report = bake_scene(scene_of(*floors), max_draw_calls=3, texture_budget=2**23)
    shapes = [one.texture.shape for one in baked.surfaces if one.texture is not None]
    assert shapes[:2] == [(256, 256, 3)] * 2
    assert "2 textures were made smaller" in report.notes[1]


def test_the_budget_takes_from_the_finest_first() -> None:
    fine = tile("fine", (0, 0, 0), picture(256, 1), size=0.25)
    coarse = tile("coarse", (2, 0, 0), picture(128, 2), size=4.0)
    baked, report = bake_scene(scene_of(fine, coarse), texture_budget=128 * 128 + 64 * 64)
    assert report.after.texels <= 128 * 128 + 64 * 64
    shapes = {one.name: one.texture.shape for one in baked.surfaces if one.texture is not None}
    assert shapes["coarse"] == (128, 128, 3)
    assert 60 <= shapes["fine"][0] <= 64
    points = points_on(scene_of(fine, coarse), 200)
    gap = np.abs(looks(baked, points) - looks(scene_of(fine, coarse), points))
    assert gap.mean() < 3.0


@pytest.mark.parametrize("max_draw_calls", [2, 5, 32])
def test_hundreds_of_surfaces_become_few(max_draw_calls: int) -> None:
    scene = wall_of_pictures(300, side=16)
    plain = [tile(f"p{i}", (-3.0, 1.5 * i, 0), None) for i in range(200)]
    scene = dataclasses.replace(scene, surfaces=(*scene.surfaces, *plain))
    baked, report = bake_scene(scene, max_draw_calls=max_draw_calls)
    assert len(baked.surfaces) <= max_draw_calls
    assert report.after.triangles == 1000
    points = points_on(scene, 100)
    # 20 levels a texel here, 1/32 of it away.
    np.testing.assert_allclose(looks(baked, points), looks(scene, points), atol=3.0)


@given(
    st.lists(st.tuples(st.integers(1, 200), st.integers(1, 200)), min_size=1, max_size=60),
    st.sampled_from([256, 512]),
)
@settings(max_examples=40)
def test_packed_rectangles_lie_apart_on_their_pages(
    sizes: list[tuple[int, int]], max_side: int
) -> None:
    packing = pack_rectangles(sizes, max_side=max_side)
    covered = [np.zeros((height, width), int) for width, height in packing.pages]
    for (width, height), (page, x, y) in zip(sizes, packing.places, strict=True):
        assert y + height <= covered[page].shape[0]
        assert x + width <= covered[page].shape[1]
        covered[page][y : y + height, x : x + width] += 1
    assert all(one.max() == 1 for one in covered)
    assert all(one.shape[0] & (one.shape[0] - 1) == 0 for one in covered)
    assert packing.area == sum(one.size for one in covered)


def test_a_rectangle_larger_than_a_page_is_refused() -> None:
    with pytest.raises(ValueError, match="a rectangle of 300 does not fit a page of 256"):
        pack_rectangles([(10, 300)], max_side=256)


# ------------------------------------------------------------------------ welding


def _soup(one: Surface, *, jitter: float, shade: int) -> Surface:
    """Three vertices to every triangle, moved and recoloured a little, each in its own way."""
    rng = np.random.default_rng(7)
    corners = one.faces.reshape(-1)
    moved = one.positions[corners] + rng.uniform(-jitter, jitter, (len(corners), 3))
    colors = one.colors[corners].astype(int)
    colors[:, :3] = colors[:, :3] // 2 * 2 + rng.integers(0, shade + 1, (len(corners), 1))
    return Surface(
        name=one.name,
        positions=moved.astype(np.float32),
        normals=one.normals[corners],
        colors=colors.astype(np.uint8),
        faces=np.arange(len(corners), dtype=np.uint32).reshape(-1, 3),
    )


def test_near_duplicates_are_welded() -> None:
    # A grid of 2^-3 m, so that no corner lies between two places of the baked grid.
    sheet = grid((0, 0, 0), (2, 0, 0), (0, 0, -2), 16, color=(200, 180, 160), name="sheet")
    soup = _soup(sheet, jitter=4e-5, shade=1)
    welded, dropped = weld_surface(soup)
    assert len(soup.positions) == 3 * 512
    assert len(welded.positions) == 17 * 17
    assert not sum(dropped.values())
    gaps = np.abs(welded.colors[welded.faces].astype(int) - soup.colors[soup.faces])
    assert gaps.max() <= 1
    moved = welded.positions[welded.faces] - soup.positions[soup.faces]
    assert np.abs(moved).max() < 1.1e-4


def test_what_looks_different_is_not_welded() -> None:
    one = _soup(grid((0, 0, 0), (1, 0, 0), (0, 0, -1), 4, color=(99, 99, 99), name="s"),
                jitter=0.0, shade=0)  # fmt: skip
    striped = one.colors.copy()
    striped[::2, :3] += 10
    welded, _ = weld_surface(dataclasses.replace(one, colors=striped))
    np.testing.assert_array_equal(welded.colors[welded.faces], striped[one.faces])
    crate, _ = weld_surface(surface("crate", box_quads((0, 0, 0), (1, 1, 1))))
    assert len(crate.positions) == 24  # its normals differ


def test_triangles_that_draw_nothing_are_left_out() -> None:
    faces = np.array([[0, 1, 2], [1, 2, 0], [2, 1, 0], [0, 0, 1], [0, 1, 3], [0, 2, 4]], np.uint32)
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 0, 1], [2, 0, 0], [0, 1, 0]], np.float32)
    one = Surface(
        "s",
        positions,
        np.tile(np.array([0, 1, 0], np.float32), (5, 1)),
        np.full((5, 4), 99, np.uint8),
        faces,
    )
    baked, report = bake_scene(scene_of(one))
    assert report.after.triangles == 2
    assert report.after.vertices == 4
    assert report.notes == (
        "2 triangles drawn twice left out",
        "2 triangles without area left out",
    )
    assert _area(baked) == pytest.approx(1.0)


def test_lost_normals_are_those_of_their_triangles() -> None:
    zero = dataclasses.replace(SHEET, normals=np.zeros_like(SHEET.normals))
    welded, _ = weld_surface(zero)
    np.testing.assert_allclose(welded.normals, [[0.0, 1.0, 0.0]] * len(welded.normals))


# ------------------------------------------------------------------------ chunks and rooms


def test_every_triangle_is_in_one_chunk_inside_its_box() -> None:
    baked, _ = bake_scene(ROOM)
    chunks = baked.chunks
    assert chunks is not None
    seen = [np.zeros(len(one.faces), int) for one in baked.surfaces]
    for index in range(len(chunks)):
        first, one = chunks.first[index], baked.surfaces[chunks.surface[index]]
        chosen = slice(first, first + chunks.count[index])
        seen[chunks.surface[index]][chosen] += 1
        points = one.positions[one.faces[chosen]].reshape(-1, 3)
        np.testing.assert_array_equal(points.min(axis=0), chunks.low[index])
        np.testing.assert_array_equal(points.max(axis=0), chunks.high[index])
    assert all((one == 1).all() for one in seen)


L_SHAPE = ((0.0, 0.0), (6.0, 0.0), (6.0, 2.0), (3.0, 2.0), (3.0, 5.0), (0.0, 5.0))
SQUARE = ((3.1, 2.1), (6.0, 2.1), (6.0, 5.0), (3.1, 5.0))


def _two_rooms(count: int, size: float, seed: int) -> Scene:
    """Small and large triangles all over two rooms, their walls and what is around them."""
    rng = np.random.default_rng(seed)
    middles = rng.uniform((-1.0, -0.5, -1.0), (7.0, 3.0, 6.0), (count, 1, 3))
    corners = (middles + rng.normal(size=(count, 3, 3)) * size).astype(np.float32)
    mess = Surface(
        name="mess",
        positions=corners.reshape(-1, 3),
        normals=np.tile(np.array([0, 1, 0], np.float32), (3 * count, 1)),
        colors=rng.integers(0, 256, (3 * count, 4), dtype=np.uint8),
        faces=np.arange(3 * count, dtype=np.uint32).reshape(-1, 3),
    )
    rooms = (Room("l", "living", L_SHAPE), Room("s", "study", SQUARE))
    return dataclasses.replace(scene_of(mess), rooms=rooms)


@pytest.mark.parametrize("size", [0.01, 0.2, 1.0])
def test_a_chunk_has_a_room_only_if_all_of_it_is_inside(size: float) -> None:
    baked, _ = bake_scene(_two_rooms(4000, size, 11))
    chunks, one = baked.chunks, baked.surfaces[0]
    assert chunks is not None
    outlines = [shapely.Polygon(room.polygon).buffer(0.021) for room in baked.rooms]
    counts = dict.fromkeys((-1, 0, 1), 0)
    for index in range(len(chunks)):
        first, room = chunks.first[index], int(chunks.room[index])
        corners = one.positions[one.faces[first : first + chunks.count[index]]].astype(np.float64)
        counts[room] += len(corners)
        if room < 0:
            # None of these could be told to be in a room.
            inside = [shapely.covers(o, shapely.polygons(corners[:, :, [0, 2]])) for o in outlines]
            low = (corners[:, :, 1] > 0.021).all(axis=1) & (corners[:, :, 1] < 2.57).all(axis=1)
            strictly = [shapely.Polygon(r.polygon).buffer(0.0) for r in baked.rooms]
            sure = [shapely.covers(o, shapely.polygons(corners[:, :, [0, 2]])) for o in strictly]
            assert not (low & (sure[0] ^ sure[1]) & (inside[0] ^ inside[1])).any()
            continue
        assert shapely.covers(outlines[room], shapely.polygons(corners[:, :, [0, 2]])).all()
        assert corners[:, :, 1].min() > -0.021
        assert corners[:, :, 1].max() < 2.621
    assert all(counts.values()) or size == 1.0


def test_rooms_by_hand() -> None:
    rooms = (Room("l", "living", L_SHAPE), Room("s", "study", SQUARE))
    corners = np.array(
        [
            [[1, 0, 1], [2, 0, 1], [1, 2.6, 4]],  # in the L
            [[0.5, 0, 4.5], [5.5, 0, 0.5], [0.5, 0, 0.5]],  # corners in the L, its long side not
            [[4, 1, 3], [5, 1, 3], [4, 2, 4]],  # in the square
            [[2.9, 1, 3], [3.2, 1, 3], [3, 1, 4]],  # through the wall between them
            [[3.05, 1, 3], [3.05, 2, 3], [3.05, 1, 4]],  # in the wall
            [[3.015, 0, 3], [3.015, 2, 3], [3.015, 0, 4]],  # on the wall: within the slack
            [[1, 2.5, 1], [2, 2.7, 1], [1, 2.5, 2]],  # through the ceiling
            [[8, 0, 1], [9, 0, 1], [8, 0, 2]],  # outside
        ],
        np.float64,
    )
    assert face_rooms(corners, rooms).tolist() == [0, -1, 1, -1, -1, 0, -1, -1]
    storeys = (rooms[0], dataclasses.replace(rooms[0], floor_y=2.8, ceiling_y=5.4))
    assert face_rooms(corners + np.array([0, 2.8, 0]), storeys).tolist()[:2] == [1, -1]
    # What two rooms hold belongs to neither.
    assert face_rooms(corners, (rooms[0], rooms[0])).tolist() == [-1] * 8
    crossed = Room("x", "living", ((0, 0), (6, 5), (6, 0), (0, 5)))
    assert face_rooms(corners, (crossed,)).tolist() == [-1] * 8


# ------------------------------------------------------------------------ decimation


def test_decimation_keeps_to_the_budget_and_tells_the_loss() -> None:
    pytest.importorskip("fast_simplification")
    baked, report = bake_scene(ROOM, max_triangles=5000)
    assert 4500 <= baked.num_triangles <= 5000
    assert report.before.triangles == ROOM.num_triangles
    loss = report.loss
    assert loss is not None
    assert 0.0 < loss.mean_mm < 1.0
    assert loss.mean_mm < loss.max_mm < 60.0
    # Boxes stay boxes: rays agree but for few.
    rng = np.random.default_rng(2)
    ways = rng.normal(size=(1000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    origins = np.tile([0.0, 1.3, 0.0], (1000, 1))
    before, after = (RayCaster(*s.mesh()).distance(origins, ways) for s in (ROOM, baked))
    assert np.mean(np.abs(before - after) > 0.01) < 0.03


def test_decimation_of_a_flat_picture_changes_no_point_of_it() -> None:
    pytest.importorskip("fast_simplification")
    scene = scene_of(tile("picture", (0, 0, 0), picture(64, 4), uv=(0, 0, 2, 2), steps=24))
    flat = dataclasses.replace(
        scene.surfaces[0], colors=np.full_like(scene.surfaces[0].colors, 255)
    )
    scene = scene_of(flat)
    baked, report = bake_scene(scene, max_triangles=200)
    assert baked.num_triangles <= 200
    assert _area(baked) == pytest.approx(1.0)
    assert report.loss is not None
    assert report.loss.max_mm < 2.0
    points = points_on(scene, 300)
    np.testing.assert_allclose(looks(baked, points), looks(scene, points), atol=4.0)


def test_light_on_a_wall_is_decimated_last() -> None:
    pytest.importorskip("fast_simplification")
    lit = SHEET.colors.copy()
    near = np.hypot(SHEET.positions[:, 0] - 1.0, SHEET.positions[:, 2] + 1.0) < 0.5
    lit[near, :3] = 255
    scene = scene_of(dataclasses.replace(SHEET, colors=lit))
    baked, _ = bake_scene(scene, max_triangles=500)
    assert baked.num_triangles <= 500
    points = points_on(scene, 300)
    assert np.abs(looks(baked, points) - looks(scene, points)).max() < 2.0


def test_the_loss_of_a_raised_sheet_is_its_rise() -> None:
    raised = dataclasses.replace(
        SHEET, positions=SHEET.positions + np.array([0, 0.01, 0], np.float32)
    )
    loss = measure_loss([SHEET], [raised])
    assert loss.mean_mm == pytest.approx(10.0, abs=0.1)
    assert loss.max_mm == pytest.approx(10.0, abs=1.0)
    assert loss.mean_levels == pytest.approx(0.0, abs=1e-6)
    assert measure_loss([SHEET], [SHEET]).mean_mm == pytest.approx(0.0, abs=0.02)


def test_decimation_names_its_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "fast_simplification", None)
    with pytest.raises(MissingExtraError, match=r"fast_simplification.*affectsim-data\[build\]"):
        bake_scene(ROOM, max_triangles=1000)
    assert bake_scene(one_room(), max_triangles=10_000)[1].loss is None


# ------------------------------------------------------------------------ reports and refusals


def test_a_report_reads_well() -> None:
    _, report = bake_scene(wall_of_pictures(12), max_draw_calls=3)
    assert isinstance(report, BakeReport)
    lines = report.lines()
    assert lines[0] == "gallery: baked"
    assert any("surfaces" in line and "12 ->" in line and line.endswith(" 3") for line in lines)
    assert lines[-1] == "  10 textures share 1 atlas pages with gutters of 8 texels"
    table = json.loads(json.dumps(report.to_json()))
    assert table["before"]["surfaces"] == 12
    assert table["loss"] is None


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"max_draw_calls": 1}, "max_draw_calls must be at least 2, got 1"),
        ({"texture_budget": 0}, "texture_budget must be at least 1, got 0"),
        ({"max_triangles": 5}, "max_triangles must be at least 32, got 5"),
        ({"max_draw_calls": 3, "texture_budget": 5000}, "12 textures do not fit 3 draw calls"),
    ],
)
def test_limits_that_cannot_be_kept_are_refused(limits: dict[str, int], message: str) -> None:
    with pytest.raises(ValueError, match=f"scene 'gallery': {message}"):
        bake_scene(wall_of_pictures(12), **limits)


def test_scenes_that_cannot_be_baked_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    far = dataclasses.replace(SHEET, positions=SHEET.positions + np.float32(2000))
    with pytest.raises(ValueError, match=r"surface 'sheet': a vertex is 200\d m from the origin"):
        bake_scene(scene_of(far))
    wild = tile("wild", (0, 0, 0), picture(16, 0), uv=(0, 0, 1e9, 1))
    with pytest.raises(ValueError, match=r"surface 'wild': texture coordinates reach 1e\+09"):
        bake_scene(scene_of(wild))
    point = dataclasses.replace(SHEET, positions=SHEET.positions * np.float32(1e-9))
    with pytest.raises(ValueError, match="no triangle has an area"):
        bake_scene(scene_of(point))
    monkeypatch.setattr(baking, "MAX_INPUT_TRIANGLES", 100)
    with pytest.raises(ValueError, match="800 triangles are more than baking takes, 100"):
        bake_scene(scene_of(SHEET))


@pytest.mark.realdata
def test_real_objects_share_pages(realdata: Path) -> None:
    from affectsim_data.builders.meshes import read_mesh

    paths = sorted((realdata / "replica_cad" / "objects").glob("*.glb"))[::6]
    parts: list[Surface] = []
    for number, path in enumerate(paths):
        for part in read_mesh(path).parts:
            one = part.to_surface(f"{len(parts)}")
            parts.append(
                dataclasses.replace(
                    one, positions=one.positions + np.array([number, 0, 0], np.float32)
                )
            )
    scene = scene_of(*parts)
    baked, report = bake_scene(scene, max_draw_calls=4, texture_budget=2**18)
    assert report.before.texels > 2**20
    assert len(baked.surfaces) <= 4
    assert report.after.texels <= 2**18
    assert _area(baked) == pytest.approx(_area(scene), rel=2e-3)
