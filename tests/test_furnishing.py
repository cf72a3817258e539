"""Furniture and its places: pieces alone, then rooms of every purpose, drawn by seed."""

from __future__ import annotations

import inspect
import itertools
from collections.abc import Callable

import numpy as np
import pytest
import shapely
from furniture_laws import bounds_of, crossing_meshes, mesh_of, outline_of, overlapping_boxes
from furniture_rooms import PALETTE, PURPOSES, drawn_room

from affectsim_data.builders.homes import (
    bathroom,
    beds,
    chairs,
    decor,
    dividers,
    kitchen,
    lamps,
    plants,
    seating,
    storage,
    tables,
    textiles,
)
from affectsim_data.builders.homes.furnish import furnish_home
from affectsim_data.builders.homes.parts import merged
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.placed import Placed
from affectsim_data.builders.homes.plans import HomePlan, RoomPlan
from affectsim_data.builders.homes.purposes import Purpose
from affectsim_data.scenes.solids import closed_solids
from affectsim_data.visibility import RayCaster

_MODULES = (
    seating, chairs, tables, storage, dividers, beds, kitchen, bathroom, lamps, plants, decor,
    textiles,
)  # fmt: skip
_NEEDED = {"counter": {"width": 2.4, "uppers": ((-1.2, 1.2),)}}
_SEEDS = 3
_FURNISHED: dict[tuple[str, int], tuple[RoomPlan, tuple[Placed, ...]]] = {}


def _designs() -> dict[str, Callable[..., Furniture]]:
    return {
        name: made
        for module in _MODULES
        for name, made in vars(module).items()
        if name in module.__all__
        and inspect.isfunction(made)
        and inspect.signature(made).return_annotation == "Furniture"
    }


DESIGNS = _designs()


def _piece(name: str, seed: int = 0) -> Furniture:
    rng = np.random.default_rng(seed)
    return DESIGNS[name](PALETTE, rng=rng, **_NEEDED.get(name, {}))


@pytest.fixture(params=list(itertools.product(PURPOSES, range(_SEEDS))), ids=str)
def furnished(request: pytest.FixtureRequest) -> tuple[RoomPlan, tuple[Placed, ...]]:
    """A drawn room and what was put into it, made once."""
    key = request.param
    if key not in _FURNISHED:
        _FURNISHED[key] = _furnish(*key)
    return _FURNISHED[key]


def _furnish(purpose: Purpose, seed: int) -> tuple[RoomPlan, tuple[Placed, ...]]:
    rng = np.random.default_rng([seed, PURPOSES.index(purpose)])
    room = drawn_room(purpose, rng)
    return room, furnish_home(HomePlan((room,)), PALETTE, rng=rng).placed


def _rectangle(rect: tuple[float, float, float, float]) -> shapely.Polygon:
    return shapely.box(*rect)


@pytest.mark.parametrize("name", sorted(DESIGNS))
def test_a_piece_is_a_sound_mesh_in_its_box(name: str) -> None:
    for seed in range(2):
        piece = _piece(name, seed)
        assert piece.category
        positions, faces = mesh_of(piece.parts)
        normals = merged(piece.parts).normals
        assert 60 <= len(faces) <= 12_000
        half = np.array([piece.width, piece.depth]) / 2.0
        assert (np.abs(positions[:, ::2]) <= half + 1e-6).all()
        if name != "coat_rack":
            assert positions[:, 1].min() == pytest.approx(0.0, abs=1e-3)
        a, b, c = (positions[faces[:, k]] for k in range(3))
        cross = np.cross(b - a, c - a)
        assert (np.linalg.norm(cross, axis=1) > 1e-9).all()
        agree = np.einsum("ij,ij->i", cross, normals[faces].mean(axis=1)) > 0.0
        assert agree.mean() > 0.995
        # Turned over, what is closed would have to be inside out.
        inside_out, _ = closed_solids(positions, faces[:, ::-1])
        assert not inside_out.any()


@pytest.mark.parametrize("name", sorted(DESIGNS))
def test_no_two_faces_of_a_piece_fight(name: str) -> None:
    """Seen from outside, no second front face lies less than a millimetre behind the first."""
    positions, faces = mesh_of(_piece(name).parts)
    rng = np.random.default_rng(1)
    middle = (positions.min(axis=0) + positions.max(axis=0)) / 2.0
    starts = rng.normal(size=(6000, 3))
    starts *= 4.0 / np.linalg.norm(starts, axis=1, keepdims=True)
    goals = middle + rng.uniform(-0.5, 0.5, (6000, 3)) * np.ptp(positions, axis=0)
    ways = goals - (middle + starts)
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    a, b, c = (positions[faces[:, k]] for k in range(3))
    facing = np.cross(b - a, c - a)
    import trimesh

    mesh = trimesh.Trimesh(positions, faces, process=False)
    hits, ray, triangle = mesh.ray.intersects_location(middle + starts, ways, multiple_hits=True)
    front = np.einsum("ij,ij->i", facing[triangle], ways[ray]) < 0.0
    away = np.einsum("ij,ij->i", hits - (middle + starts)[ray], ways[ray])
    order = np.lexsort((away, ray))
    ray, away, front = ray[order], away[order], front[order]
    first = np.diff(ray, prepend=-1) != 0
    both = first[:-1] & (ray[1:] == ray[:-1]) & front[:-1] & front[1:]
    # What lies on the floor or hangs on a wall is not seen from there.
    hidden = (hits[order, 1] < positions[:, 1].min() + 1e-3)[1:]
    hidden |= (hits[order, 2] < positions[:, 2].min() + 1e-3)[1:]
    assert (both & (np.diff(away) < 1e-3) & ~hidden).mean() < 5e-3


def test_seats_have_the_height_of_seats_and_a_surface_under_them() -> None:
    count = 0
    for name in sorted(DESIGNS):
        piece = _piece(name)
        if not piece.seats:
            continue
        caster = RayCaster(*mesh_of(piece.parts))
        for seat in piece.seats:
            count += 1
            assert 0.42 <= seat.position[1] <= 0.475, name
            down = float(caster.distance(np.add(seat.position, (0.0, 0.1, 0.0)), (0.0, -1.0, 0.0)))
            assert down == pytest.approx(0.1, abs=0.025), name
    assert count > 25


def test_sizes_are_those_of_real_furniture() -> None:
    heights = {
        "table": {"dining_plain": (0.73, 0.76), "coffee_plain": (0.35, 0.45)},
        "wardrobe": {"wardrobe": (1.8, 2.2)}, "counter": {"island": (0.88, 0.95)},
        "desk": {"desk": (0.72, 0.76)},
    }  # fmt: skip
    for names in heights.values():
        for name, (low, high) in names.items():
            assert low <= _piece(name).height <= high, name


def test_no_two_boxes_overlap(furnished: tuple[RoomPlan, tuple[Placed, ...]]) -> None:
    assert not overlapping_boxes(furnished[1])


def test_no_two_meshes_cross(furnished: tuple[RoomPlan, tuple[Placed, ...]]) -> None:
    assert not crossing_meshes(furnished[1])


def test_everything_is_inside_and_leaves_doors_and_kept_floor_free(
    furnished: tuple[RoomPlan, tuple[Placed, ...]],
) -> None:
    room, placed = furnished
    assert len(placed) >= 3
    kept = [_rectangle(rect) for rect in (*room.clear, *room.blocked)]
    for opening in room.openings:
        if opening.kind != "window":
            wall = room.wall(opening.side)
            kept.append(_rectangle(wall.rect(opening.span, 0.85)))
    for p in placed:
        low, high = bounds_of(p)
        assert (low > (room.x0, -1e-3, room.z0)).all(), p.piece.category
        assert (high < (room.x1, room.ceiling_y + 1e-6, room.z1)).all(), p.piece.category
        if p.support in ("floor", "piece"):
            outline = outline_of(p, shrink=0.002)
            assert not any(outline.intersects(rect) for rect in kept), p.piece.category


def test_a_robot_gets_to_all_doors_and_almost_all_floor(
    furnished: tuple[RoomPlan, tuple[Placed, ...]],
) -> None:
    room, placed = furnished
    taken = [
        _rectangle(rect)
        for p in placed
        if p.piece.category != "rug" and p.support in ("floor", "wall") and p.y < 1.5
        for rect in p.footprint()
    ]
    free = _rectangle((room.x0, room.z0, room.x1, room.z1)).difference(shapely.union_all(taken))
    fits = free.buffer(-0.3)
    islands = list(fits.geoms) if isinstance(fits, shapely.MultiPolygon) else [fits]
    main = max(islands, key=lambda island: island.area)
    assert main.area >= 0.95 * fits.area
    for opening in room.openings:
        if opening.kind != "window":
            wall = room.wall(opening.side)
            x, _, z = wall.point(wall.u_of(opening.middle), 0.0, 0.5)
            assert main.distance(shapely.Point(x, z)) < 0.12


def test_seats_have_room_for_knees(furnished: tuple[RoomPlan, tuple[Placed, ...]]) -> None:
    room, placed = furnished
    inside = _rectangle((room.x0, room.z0, room.x1, room.z1)).buffer(1e-6)
    for p in placed:
        for seat in p.piece.seats:
            assert 0.42 <= p.y + seat.position[1] <= 0.48
            knees = _rectangle(p.knees(seat)).buffer(-0.01)
            assert inside.contains(knees)
            for q in placed:
                if q is not p and q.support == "floor" and q.piece.category != "rug":
                    assert not knees.intersects(outline_of(q)), (p.piece.category, q.piece.category)


def test_nothing_floats_or_sinks(furnished: tuple[RoomPlan, tuple[Placed, ...]]) -> None:
    room, placed = furnished
    walls = shapely.box(room.x0, room.z0, room.x1, room.z1).exterior
    for p in placed:
        low, high = bounds_of(p)
        if p.support == "floor":
            ground = max(
                (
                    q.piece.height
                    for q in placed
                    if q.piece.category == "rug"
                    and q is not p
                    and outline_of(q).contains(outline_of(p))
                ),
                default=0.0,
            )
            assert low[1] == pytest.approx(ground, abs=1e-3), p.piece.category
        elif p.support == "wall":
            back = shapely.Point(p.world(0.0, -p.piece.depth / 2.0))
            # Curtains hang from their rod.
            assert walls.distance(back) < (0.09 if p.piece.category == "curtain" else 0.005)
        elif p.support == "ceiling":
            assert high[1] == pytest.approx(room.ceiling_y, abs=2e-3)
        else:
            bases = [
                q.y + top.y
                for q in placed
                for top in q.piece.tops
                if outline_of(q).buffer(0.02).contains(outline_of(p).centroid)
            ]
            assert min(abs(base - low[1]) for base in bases) < 1e-3, p.piece.category


@pytest.mark.parametrize("purpose", ["living", "bath"])
def test_the_same_seed_gives_the_same_bytes(purpose: Purpose) -> None:
    (_, first), (_, second), (_, other) = (_furnish(purpose, seed) for seed in (0, 0, 1))

    def content(placed: tuple[Placed, ...]) -> bytes:
        return b"".join(part.positions.tobytes() for p in placed for part in p.parts())

    assert content(first) == content(second)
    assert content(first) != content(other)
