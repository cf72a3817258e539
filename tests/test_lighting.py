"""Baked light: laws of windows, lamps, shade and bounces; imported scenes; cuts of quads."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from affectsim_data.builders.homes.parts import Part, box, sheet
from affectsim_data.builders.homes.surfaces import lit_surfaces, unlit_surfaces
from affectsim_data.builders.lighting import (
    Lamp,
    LightMesh,
    WindowLight,
    bake_light,
    exposed,
    light_surfaces,
)
from affectsim_data.builders.lighting.quads import turned_diagonals
from affectsim_data.builders.lighting.subdividing import longest_edge, subdivided
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room, Surface
from affectsim_data.visibility import RayCaster

_X, _Y, _Z = np.eye(3)
_SIZE = np.array([4.0, 2.6, 5.0])
"""Of the test room, from the origin."""
_WINDOW = WindowLight(np.array([1.2, 0.9, 5.0]), 1.6 * _X, 1.2 * _Y, -_Z)
_LAMP = Lamp(np.array([2.0, 2.4, 2.5]))


def _lines(length: float) -> FloatArray:
    return np.linspace(0.0, length, round(length / 0.2) + 1)


def _wall(origin: FloatArray, u: FloatArray, v: FloatArray, *, material: str = "paint") -> Part:
    """A rectangle seen from u x v."""
    wide, tall = float(np.linalg.norm(u)), float(np.linalg.norm(v))
    return sheet(
        origin, u / wide, v / tall, _lines(wide), _lines(tall), color=(0.8, 0.8, 0.8),
        material=material,
    )  # fmt: skip


def _room(*things: Part) -> list[Part]:
    """A closed room of 4 x 5 m, and things in it."""
    w, h, d = _SIZE[0] * _X, _SIZE[1] * _Y, _SIZE[2] * _Z
    return [
        _wall(d, w, -d, material="planks"),
        _wall(h, w, d),
        _wall(np.zeros(3), w, h),
        _wall(w + d, -w, h),
        _wall(d, -d, h),
        _wall(w, d, h),
        *things,
    ]


def _baked(
    parts: list[Part], *, windows: list[WindowLight] | None = None,
    lamps: list[Lamp] | None = None,
) -> tuple[LightMesh, FloatArray]:  # fmt: skip
    """The mesh of parts and the mean light of its vertices."""
    mesh = LightMesh.of(unlit_surfaces(parts, rng=np.random.default_rng(0)))
    light, _ = bake_light(mesh, windows=windows or [], lamps=lamps or [])
    return mesh, light.mean(axis=1).astype(np.float64)


def _at(mesh: LightMesh, light: FloatArray, place: FloatArray, normal: FloatArray) -> float:
    """Light of the vertex nearest to a place among those that look along `normal`."""
    alike = np.flatnonzero(mesh.normals @ normal > 0.99)
    distance = np.linalg.norm(mesh.positions[alike] - place, axis=1)
    return float(light[alike[int(np.argmin(distance))]])


@pytest.fixture(scope="module")
def daylight() -> tuple[LightMesh, FloatArray]:
    """A room with a window and a box in its middle."""
    thing = box((0.8, 0.8, 0.8), (2.0, 0.41, 2.5), color=(0.8, 0.8, 0.8), step=0.2)
    return _baked(_room(thing), windows=[_WINDOW])


def test_faces_towards_a_window_are_lighter(daylight: tuple[LightMesh, FloatArray]) -> None:
    towards = _at(*daylight, np.array([2.0, 0.6, 2.9]), _Z)
    away = _at(*daylight, np.array([2.0, 0.6, 2.1]), -_Z)
    assert towards > 2.0 * away > 0.0


def test_daylight_falls_with_distance(daylight: tuple[LightMesh, FloatArray]) -> None:
    near, middle, far = (
        _at(*daylight, np.array([3.0, 0.0, z]), _Y) for z in (4.0, 2.6, 0.6)
    )  # fmt: skip
    assert near > 1.3 * middle
    assert middle > 1.1 * far


def test_floors_get_the_sky_and_ceilings_the_ground(
    daylight: tuple[LightMesh, FloatArray],
) -> None:
    floor = _at(*daylight, np.array([2.0, 0.0, 3.9]), _Y)
    ceiling = _at(*daylight, np.array([2.0, 2.6, 3.9]), -_Y)
    assert floor > 1.2 * ceiling


def test_corners_and_places_under_things_are_in_shade() -> None:
    table = box((1.6, 0.05, 1.6), (2.0, 0.4, 1.6), color=(0.7, 0.6, 0.5), step=0.2)
    room = _baked(_room(table), lamps=[Lamp(np.array([2.0, 2.4, 4.0]))])
    corner = _at(*room, np.array([0.0, 2.6, 0.0]), -_Y)
    open_ceiling = _at(*room, np.array([0.8, 2.6, 0.8]), -_Y)
    assert corner < 0.75 * open_ceiling
    assert _at(*room, np.array([2.0, 0.0, 1.6]), _Y) < 0.3 * _at(*room, np.array([2, 0, 2.8]), _Y)


def test_lamps_light_what_they_see() -> None:
    screen = _wall(np.array([0.0, 0.0, 1.2]), 4.0 * _X, 1.8 * _Y)
    back = dataclasses.replace(
        screen, positions=screen.positions - 0.05 * _Z, normals=-screen.normals,
        faces=screen.faces[:, ::-1],
    )  # fmt: skip
    room = _baked(_room(screen, back), lamps=[_LAMP])
    assert _at(*room, np.array([2.0, 0.8, 1.2]), _Z) > 2.5 * _at(*room, np.array([2, 0.8, 0]), _Z)


def test_a_closed_room_without_a_source_is_dark_but_not_black() -> None:
    _, dark = _baked(_room())
    _, lit = _baked(_room(), lamps=[_LAMP])
    assert dark.min() > 0.0
    assert dark.max() < 0.2 * lit.mean()


def test_light_bounces_around_corners() -> None:
    """A wall that no lamp sees gets a tenth and more of the light of one that a lamp sees."""
    screen = box((2.6, 2.6, 0.1), (1.3, 1.3, 1.8), color=(0.8, 0.8, 0.8), step=0.2)
    mesh, light = _baked(_room(screen), lamps=[Lamp(np.array([1.0, 2.2, 3.6]))])
    hidden = _at(mesh, light, np.array([0.2, 1.2, 0.0]), _Z)
    seen = _at(mesh, light, np.array([1.0, 1.2, 5.0]), -_Z)
    assert 0.05 * seen < hidden < 0.7 * seen


def test_floor_under_a_skirting_board_is_not_black() -> None:
    board = box((4.0, 0.08, 0.3), (2.0, 0.04, 0.15), color=(0.9, 0.9, 0.9), sides="xXyYZ")
    mesh, light = _baked(_room(board), lamps=[_LAMP])
    covered = _at(mesh, light, np.array([2.0, 0.0, 0.2]), _Y)
    beside = _at(mesh, light, np.array([2.0, 0.0, 0.6]), _Y)
    assert 0.4 * beside < covered < beside


def test_light_does_not_depend_on_how_faces_are_ordered() -> None:
    mesh, light = _baked(_room(), windows=[_WINDOW], lamps=[_LAMP])
    order = np.random.default_rng(0).permutation(len(mesh.faces))
    shuffled = dataclasses.replace(mesh, faces=mesh.faces[order])
    again, _ = bake_light(shuffled, windows=[_WINDOW], lamps=[_LAMP])
    np.testing.assert_allclose(again.mean(axis=1), light, rtol=0.02, atol=1e-3)


def test_same_parts_give_the_same_bytes() -> None:
    parts = _room(box((1.0, 0.5, 0.4), (1.0, 0.25, 1.0), color=(0.4, 0.5, 0.6), radius=0.03))
    first, second = (
        lit_surfaces(parts, [_WINDOW], [_LAMP], rng=np.random.default_rng(3)) for _ in range(2)
    )
    for one, other in zip(first, second, strict=True):
        assert one.colors.tobytes() == other.colors.tobytes()
        assert one.faces.tobytes() == other.faces.tobytes()


def test_lit_surfaces_have_the_geometry_of_unlit_ones() -> None:
    parts = _room(box((1.0, 0.5, 0.4), (1.0, 0.25, 1.0), color=(0.4, 0.5, 0.6)))
    lit = lit_surfaces(parts, [_WINDOW], [_LAMP], rng=np.random.default_rng(3))
    unlit = unlit_surfaces(parts, rng=np.random.default_rng(3))
    assert [surface.name for surface in lit] == [surface.name for surface in unlit]
    for one, other in zip(lit, unlit, strict=True):
        assert np.array_equal(one.positions, other.positions)
        assert _area(one) == pytest.approx(_area(other), rel=1e-6)
        if one.texture is not None and other.texture is not None:
            assert np.array_equal(one.texture, other.texture)


def test_what_glows_keeps_its_colour() -> None:
    pane = _wall(np.array([1.2, 0.9, 4.9]) + 1.6 * _X, -1.6 * _X, 1.2 * _Y, material="sky")
    lit = lit_surfaces(_room(pane), [], [_LAMP], rng=np.random.default_rng(3))
    (sky,) = (surface for surface in lit if surface.name == "sky")
    assert (sky.colors[:, :3] == 204).all()


def test_unknown_materials_are_refused() -> None:
    part = dataclasses.replace(_room()[0], material="slime")
    with pytest.raises(KeyError, match="slime"):
        lit_surfaces([part], [], [], rng=np.random.default_rng(0))


def test_exposure_puts_the_median_in_the_middle_and_clips_nothing() -> None:
    rng = np.random.default_rng(0)
    light = np.repeat(rng.uniform(0.001, 3.0, (4001, 1)), 3, axis=1).astype(np.float32)
    area = np.ones(len(light), np.float32)
    dim, bright = exposed(light, area), exposed(40.0 * light, area)
    np.testing.assert_allclose(dim, bright, rtol=1e-4)
    assert 0.55 < float(np.median(dim)) < 0.7
    assert float(dim.max()) < 1.06
    order = np.argsort(light[:, 0])
    assert (np.diff(dim[order, 1]) >= -1e-6).all()


def _area(surface: Surface) -> float:
    a, b, c = (surface.positions[surface.faces[:, k]].astype(np.float64) for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def test_quads_are_cut_where_their_corners_are_alike() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    dark_corner = np.array([0.0, 1.0, 1.0, 1.0], np.float32)
    turned = turned_diagonals(corners, faces, dark_corner, corners[:, :2])
    assert {frozenset(face.tolist()) for face in turned} == {
        frozenset((0, 1, 3)),
        frozenset((1, 2, 3)),
    }
    a, b, c = (corners[turned[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    dark_side = np.array([1.0, 0.0, 1.0, 1.0], np.float32)
    assert np.array_equal(turned_diagonals(corners, faces, dark_side, corners[:, :2]), faces)


def test_quads_that_are_bent_or_whose_texture_is_are_left_alone() -> None:
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    values, flat = np.array([0.0, 1.0, 1.0, 1.0], np.float32), corners[:, :2]
    for corner in range(4):
        bent, stretched = corners.copy(), flat.copy()
        bent[corner, 2], stretched[corner, 0] = 0.1, 0.4
        assert np.array_equal(turned_diagonals(bent, faces, values, flat), faces)
        assert np.array_equal(turned_diagonals(corners, faces, values, stretched), faces)


def _plain(name: str, part: Part) -> Surface:
    colors = np.full((len(part.positions), 4), 190, np.uint8)
    return Surface(
        name, part.positions.astype(np.float32), part.normals.astype(np.float32), colors,
        part.faces.astype(np.uint32),
    )  # fmt: skip


def _imported() -> list[Surface]:
    """A floor of two triangles, a ceiling, one wall and a table."""
    floor = sheet((0, 0, 5), _X, -_Z, np.array([0, 4.0]), np.array([0, 5.0]),
                  color=(0.7, 0.7, 0.7), material="plain")  # fmt: skip
    wall = sheet((0, 0, 0), _X, _Y, np.array([0, 4.0]), np.array([0, 2.6]),
                 color=(0.7, 0.7, 0.7), material="plain")  # fmt: skip
    table = box((1.6, 0.05, 1.0), (2.0, 0.4, 2.5), color=(0.6, 0.5, 0.4))
    return [_plain("floor", floor), _plain("wall", wall), _plain("table", table)]


def _brightness(surface: Surface) -> FloatArray:
    mean: FloatArray = surface.colors[:, :3].mean(axis=1, dtype=np.float64)
    return mean


def test_imported_scenes_get_shape_from_light() -> None:
    floor, wall, table = light_surfaces(_imported())
    under = np.hypot(floor.positions[:, 0] - 2.0, floor.positions[:, 2] - 2.5) < 0.5
    beside = np.abs(floor.positions[:, 2] - 4.2) < 0.5
    assert _brightness(floor)[under].mean() < 0.85 * _brightness(floor)[beside].mean()
    top, bottom = (
        _brightness(table)[sign * table.normals[:, 1] > 0.9].mean() for sign in (1.0, -1.0)
    )
    assert top > 1.15 * bottom
    assert all((surface.colors[:, 3] == 190).all() for surface in (floor, wall, table))


def test_large_triangles_of_imported_scenes_are_cut_and_stay_closed() -> None:
    surfaces = _imported()
    lit = light_surfaces(surfaces)
    for before, after in zip(surfaces, lit, strict=True):
        corners = after.positions[after.faces]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        assert sides.max() <= 0.5
        assert _area(after) == pytest.approx(_area(before), rel=1e-5)
        np.testing.assert_allclose(np.linalg.norm(after.normals, axis=1), 1.0, atol=1e-5)
    vertices, faces = lit[0].positions, lit[0].faces.astype(np.int64)
    x, z = np.random.default_rng(0).uniform(0.01, 3.99, (2, 500))
    down = np.broadcast_to(-_Y, (500, 3))
    hits = RayCaster(vertices, faces).distance(np.stack([x, np.ones(500), z], axis=1), down)
    np.testing.assert_allclose(hits, 1.0, atol=1e-5)


def test_textures_keep_their_place_when_triangles_are_cut() -> None:
    floor = _imported()[0]
    uvs = floor.positions[:, [0, 2]] * np.float32(0.25)
    floor = dataclasses.replace(floor, uvs=uvs, texture=np.full((4, 4, 3), 99, np.uint8))
    fine = subdivided(floor, 0.3)
    assert len(fine.faces) > 100
    assert fine.uvs is not None
    np.testing.assert_allclose(fine.uvs, fine.positions[:, [0, 2]] * 0.25, atol=1e-6)


def test_cutting_is_bounded() -> None:
    rng = np.random.default_rng(0)
    places = rng.uniform(-40.0, 40.0, (3000, 3)).astype(np.float32)
    colors = np.full((3000, 4), 200, np.uint8)
    faces = np.arange(3000, dtype=np.uint32).reshape(-1, 3)
    soup = Surface("soup", places, np.zeros_like(places), colors, faces)
    limit = longest_edge([soup], 0.5)
    assert limit > 0.5
    assert len(subdivided(soup, limit).faces) < 45_000


def test_both_sides_of_a_sheet_are_lit_alike() -> None:
    """A wall that is wound the wrong way is as light as one that is not."""
    floor, wall, table = _imported()
    lamps = [Lamp(np.array([2.0, 2.2, 2.5]))]
    right = light_surfaces([floor, wall, table], lamps=lamps)[1]
    turned = dataclasses.replace(wall, normals=-wall.normals, faces=wall.faces[:, ::-1].copy())
    wrong = light_surfaces([floor, turned, table], lamps=lamps)[1]
    assert abs(_brightness(right).mean() - _brightness(wrong).mean()) < 6.0


def test_missing_normals_are_made() -> None:
    floor, wall, table = _imported()
    bare = dataclasses.replace(table, normals=np.zeros_like(table.normals))
    lit = light_surfaces([floor, wall, bare])[2]
    np.testing.assert_allclose(np.linalg.norm(lit.normals, axis=1), 1.0, atol=1e-5)
    assert _brightness(lit).std() > 5.0


def test_degenerate_triangles_and_empty_surfaces_do_no_harm() -> None:
    floor, wall, table = _imported()
    line = np.zeros((3, 3), np.float32)
    line[:, 0] = [0.0, 1.0, 2.0]
    colors = np.full((3, 4), 100, np.uint8)
    faces = np.array([[0, 1, 2], [0, 0, 1]], np.uint32)
    thin = Surface("thin", line, np.zeros_like(line), colors, faces)
    empty = Surface("empty", line[:0], line[:0], colors[:0], faces[:0])
    lit = light_surfaces([floor, wall, table, thin, empty])
    assert [surface.name for surface in lit] == ["floor", "wall", "table", "thin", "empty"]
    assert all(np.isfinite(surface.normals).all() for surface in lit)
    assert len(light_surfaces([empty])[0].faces) == 0
    assert light_surfaces([]) == ()


def test_lamps_hang_in_the_rooms() -> None:
    """With one room of two, the other half of the floor is darker."""
    surfaces = _imported()
    half = Room("half", "living", ((0.0, 2.5), (4.0, 2.5), (4.0, 5.0), (0.0, 5.0)))
    floor = light_surfaces(surfaces, rooms=[half])[0]
    far, near = (np.abs(floor.positions[:, 2] - z) < 0.4 for z in (0.6, 4.0))
    assert _brightness(floor)[near].mean() > 1.04 * _brightness(floor)[far].mean()


def test_imported_light_is_the_same_every_time() -> None:
    first, second = light_surfaces(_imported()), light_surfaces(_imported())
    for one, other in zip(first, second, strict=True):
        assert one.colors.tobytes() == other.colors.tobytes()
        assert one.positions.tobytes() == other.positions.tobytes()
