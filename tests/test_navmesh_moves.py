"""Distances to rings and moves, by hand and against dense sampling."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
import trimesh

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray


def room(*boxes: tuple[float, float, float, float], half: float = 5.0) -> NavMesh:
    """A square floor with boxes `(x, z, width, depth)`, 2 m high."""
    corners = [[-half, 0, -half], [half, 0, -half], [half, 0, half], [-half, 0, half]]
    mesh = trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)
    for x, z, width, depth in boxes:
        part = trimesh.creation.box((width, 2.0, depth))
        mesh = mesh + part.apply_translation([x, 1.0, z])
    return NavMesh.from_mesh(mesh.vertices, mesh.faces)


def clutter(seed: int) -> NavMesh:
    rng = np.random.default_rng(seed)
    return room(*np.concatenate([rng.uniform(-4, 4, (18, 2)), rng.uniform(0.2, 1.5, (18, 2))], 1))


PLAIN = room()
CUT = room((0, 0, 0.2, 10))
CLUTTERED = [clutter(seed) for seed in range(4)]


@pytest.mark.parametrize("distance", [1.0, 3.0, 5.0])
def test_ring_on_a_free_plane(distance: float) -> None:
    start, anchor = np.array([-4.0, 0.0, 0.5]), np.array([0.3, 0.0, 0.2])
    expected = max(0.0, abs(np.linalg.norm(start - anchor) - distance) - 0.1)
    assert PLAIN.ring_distance(start, anchor, distance) == pytest.approx(expected)


def test_start_on_the_ring_is_there() -> None:
    assert PLAIN.ring_distance((1.05, 0, 0), (0, 0, 0), 1.0) == 0.0


def test_start_at_the_anchor_leaves_by_the_radius() -> None:
    assert PLAIN.ring_distance((0, 0, 0), (0, 0, 0), 1.0) == pytest.approx(0.9)


def test_ring_off_the_mesh_is_nan() -> None:
    assert math.isnan(PLAIN.ring_distance((0, 0, 0), (0, 0, 0), 20.0))
    assert math.isnan(PLAIN.ring_distance((0, 0, 0), (30, 0, 0), 3.0))


def test_ring_on_another_island_only_is_inf() -> None:
    assert CUT.ring_distance((-2, 0, 0), (3, 0, 0), 1.0) == math.inf
    assert CUT.ring_distance((2, 0, 0), (3, 0, 0), 0.5) == pytest.approx(0.4)


def test_ring_in_the_height_of_the_anchor() -> None:
    # Of a sphere of 1.1 m radius around a point 0.9 m up, a circle of 0.632 m is on the floor.
    expected = 3.0 - math.sqrt(1.1**2 - 0.9**2)
    assert PLAIN.ring_distance((3, 0, 0), (0, 0.9, 0), 1.0) == pytest.approx(expected)


def test_hidden_foot_is_reached_around_the_block() -> None:
    """The ring's near side lies inside a block; the way bends around the block's corner."""
    navmesh = room((0, 0, 2, 2))
    direct = 4.0 - 1.1
    found = navmesh.ring_distance((-4, 0, 0), (0, 0, 0), 1.0)
    assert found > direct or math.isnan(found)
    assert navmesh.ring_distance((-4, 0, 0), (1.5, 0, 0), 0.5) > 5.5 - 0.6


@pytest.mark.parametrize("navmesh", CLUTTERED)
def test_no_sampled_point_of_a_ring_is_nearer(navmesh: NavMesh) -> None:
    rng = np.random.default_rng(7)
    angle = np.linspace(0, 2 * np.pi, 800, endpoint=False)
    circle = np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    for start in navmesh.random_points(5, rng):
        anchor = np.array([rng.uniform(-5, 5), 0.0, rng.uniform(-5, 5)])
        for distance in (1.0, 3.0):
            ring = np.concatenate([anchor + r * circle for r in (distance - 0.1, distance + 0.1)])
            ring = ring[navmesh.navigable(ring, 1e-6)]
            found = navmesh.ring_distance(start, anchor, distance)
            sampled = np.min(navmesh.geodesic_distances(start, ring), initial=math.inf)
            if found == 0.0 or math.isinf(sampled):
                continue
            assert found <= sampled + 1e-9
            # Samples lie 7 to 24 mm apart; only a grazing ring lets them miss by more.
            assert sampled - found < 0.7


def test_ring_needs_sane_numbers() -> None:
    with pytest.raises(ValueError, match="distance must be at least 0 m, got nan"):
        PLAIN.ring_distance((0, 0, 0), (0, 0, 0), math.nan)
    with pytest.raises(ValueError, match="tolerance must be at least 0 m"):
        PLAIN.ring_distance((0, 0, 0), (0, 0, 0), 1.0, tolerance=-0.1)
    with pytest.raises(ValueError, match="m off the navmesh"):
        PLAIN.ring_distance((9, 0, 0), (0, 0, 0), 1.0)


def test_free_step_arrives() -> None:
    result = PLAIN.step((0, 0, 0), (0.25, 0, 0))
    np.testing.assert_allclose(result.position, [0.25, 0, 0])
    assert not result.clipped


@pytest.mark.parametrize("sliding", [False, True])
def test_step_of_no_length_stays(sliding: bool) -> None:
    result = PLAIN.step((1, 0, 2), (1, 0, 2), sliding=sliding)
    np.testing.assert_array_equal(result.position, [1, 0, 2])
    assert not result.clipped


def test_step_stops_at_a_wall_and_slides_along_it_if_asked() -> None:
    edge = float(PLAIN.polygons[0].bounds[2])
    start, end = (edge - 0.1, 0, 0), (edge + 0.1, 0, 0.2)
    stopped = PLAIN.step(start, end)
    np.testing.assert_allclose(stopped.position, [edge, 0, 0.1], atol=1e-9)
    slid = PLAIN.step(start, end, sliding=True)
    # The half disc around the middle of the move ends a little before the foot of the end.
    np.testing.assert_allclose(slid.position, [edge, 0, 0.2], atol=0.003)
    assert stopped.clipped
    assert slid.clipped


def test_step_into_a_wall_from_the_wall_stays() -> None:
    edge = float(PLAIN.polygons[0].bounds[2])
    result = PLAIN.step((edge, 0, 0), (edge + 0.25, 0, 0))
    np.testing.assert_allclose(result.position, [edge, 0, 0], atol=1e-9)
    assert result.clipped


@pytest.mark.parametrize("sliding", [False, True])
@pytest.mark.parametrize("navmesh", CLUTTERED[:2])
def test_steps_never_leave_the_island(navmesh: NavMesh, sliding: bool) -> None:
    rng = np.random.default_rng(3)
    position = navmesh.random_points(1, rng)[0]
    island = navmesh.island(position)
    for _ in range(400):
        # Multiples of 45 degrees run along walls and into corners.
        angle = rng.integers(8) * np.pi / 4 if rng.random() < 0.5 else rng.uniform(0, 2 * np.pi)
        change = rng.choice([0.1, 0.25, 1.0]) * np.array([np.cos(angle), 0.0, np.sin(angle)])
        result = navmesh.step(position, position + change, sliding=sliding)
        assert navmesh.is_navigable(result.position, 1e-6)
        assert navmesh.island(result.position) == island
        moved = np.linalg.norm(result.position - position)
        assert moved <= np.linalg.norm(change) + 1e-6
        assert result.clipped == (moved**2 + 1e-5 < np.sum(change**2))
        position = result.position


def test_step_leaves_a_corner_that_sticks_out() -> None:
    navmesh = room((0, 0, 2, 2))
    for x, z in navmesh.islands[0].rings[1].astype(np.float64):
        away = 0.25 * np.array([x, 0.0, z]) / math.hypot(x, z)
        result = navmesh.step((x, 0, z), np.array([x, 0, z]) + away)
        assert not result.clipped
        assert navmesh.step((x, 0, z), np.array([x, 0, z]) - away).clipped


def left_in_disc(navmesh: NavMesh, start: FloatArray, end: FloatArray, scale: float) -> float:
    """Distance to the end of a move from what of the island is connected in its disc."""
    source, target = shapely.Point(start[[0, 2]]), shapely.Point(end[[0, 2]])
    radius = scale * source.distance(target) / 2.0
    disc = shapely.Point((start + end)[[0, 2]] / 2.0).buffer(radius, quad_segs=256)
    parts = shapely.get_parts(navmesh.polygons[0] & disc)
    here = [part.distance(target) for part in parts if part.distance(source) < 1e-5]
    return float(min(here, default=source.distance(target)))


@pytest.mark.parametrize("navmesh", CLUTTERED)
def test_sliding_ends_as_near_as_the_disc_of_the_move_allows(navmesh: NavMesh) -> None:
    """Against polygon clipping: the part of the island in the disc that holds the start."""
    rng = np.random.default_rng(11)
    island = navmesh.islands[0]
    starts = navmesh.random_points(300, rng, island=0)
    # Starts in niches, at corners and on walls as well.
    starts[:100] = island.on_floor(island.nearest(rng.uniform(-5, 5, (100, 2))))
    angle, length = rng.uniform(0, 2 * np.pi, 300), rng.choice([0.25, 0.6, 1.5], 300)
    ends = starts + length[:, None] * np.stack([np.cos(angle), 0 * angle, np.sin(angle)], axis=1)
    num_clipped = 0
    for start, end in zip(starts, ends, strict=True):
        result = navmesh.step(start, end, sliding=True)
        left = float(np.linalg.norm((result.position - end)[[0, 2]]))
        # One disc a little too small and one too large: a sliver may lie in one of them only.
        assert left <= left_in_disc(navmesh, start, end, 1.0) + 2e-5
        assert left >= left_in_disc(navmesh, start, end, 1.0001) - 2e-5
        num_clipped += result.clipped
    assert num_clipped > 60


def test_rings_of_many_starts_are_those_of_each() -> None:
    rng = np.random.default_rng(5)
    for navmesh in CLUTTERED:
        starts = navmesh.random_points(40, rng)
        for distance, anchor in ((0.5, (0, 0, 0)), (2.0, (1, 0, -2)), (4.0, (-3, 0.4, 1))):
            many = navmesh.ring_distances(starts, anchor, distance)
            each = [navmesh.ring_distance(start, anchor, distance) for start in starts]
            np.testing.assert_allclose(many, each, rtol=1e-12, atol=1e-12)
    assert np.all(np.isnan(PLAIN.ring_distances(PLAIN.random_points(3, rng), (30, 0, 0), 3.0)))
    sides = np.array([[-2.0, 0, 0], [2.0, 0, 0]])
    np.testing.assert_allclose(CUT.ring_distances(sides, (3, 0, 0), 0.5), [math.inf, 0.4])
