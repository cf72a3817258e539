"""Floors that rise: ways are measured along them, rings are spheres cut by them."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from affectsim_data.navmesh import NavMesh

Profile = list[tuple[float, float]]


def strip(
    profile: Profile, *boxes: tuple[float, float, float, float], half: float = 2.0
) -> NavMesh:
    """A floor whose height along x is a polyline `(x, y)`, with boxes 2 m high on it."""
    x, y = np.array(profile).T
    low = np.stack([x, y, np.full(len(x), -half)], axis=1)
    high = low * [1.0, 1.0, -1.0]
    n = len(x)
    first = np.arange(n - 1)
    faces = [
        np.stack([first, first + n + 1, first + 1], 1),
        np.stack([first, first + n, first + n + 1], 1),
    ]
    mesh = trimesh.Trimesh(np.concatenate([low, high]), np.concatenate(faces), process=False)
    for at, z, width, depth in boxes:
        height = float(np.interp(at, x, y))
        mesh = mesh + trimesh.creation.box((width, 2.0, depth)).apply_translation(
            [at, height + 0.6, z]
        )
    return NavMesh.from_mesh(mesh.vertices, mesh.faces)


HUMP: Profile = [(-5, 0), (-2, 0), (0, 1), (2, 0), (5, 0)]


def test_a_way_over_a_hump_is_as_long_as_the_floor() -> None:
    expected = 2.0 + 2.0 * math.hypot(2.0, 1.0)
    assert strip(HUMP).geodesic_distance((-3, 0, 0), (3, 0, 0)) == pytest.approx(
        expected, rel=0.003
    )


def test_a_stair_is_as_long_as_its_slope() -> None:
    steps: Profile = [(-4, 0), (0, 0)]
    for k in range(8):
        steps += [(0.3 * k + 0.001, 0.15 * (k + 1)), (0.3 * (k + 1), 0.15 * (k + 1))]
    navmesh = strip([*steps, (6, 1.2)])
    found = navmesh.geodesic_distance((-2, 0, 0), (4, 1.2, 0))
    assert found == pytest.approx(6.0 - 2.4 + math.hypot(2.4, 1.2), rel=0.01)


def test_a_way_around_a_block_on_a_slope_is_measured_along_it() -> None:
    level = strip([(-5, 0), (5, 0)], (0, 0, 1, 1.5))
    slope = strip([(-5, 0), (5, 2)], (0, 0, 1, 1.5))
    flat = level.shortest_path((-3, 0, 0), (3, 0, 0))
    assert flat is not None
    legs = np.abs(np.diff(flat, axis=0))
    expected = np.hypot(legs[:, 0] * math.hypot(1.0, 0.2), legs[:, 2]).sum()
    found = slope.geodesic_distance((-3, 0.4, 0), (3, 1.6, 0))
    assert found == pytest.approx(expected, rel=0.004)
    assert found > level.geodesic_distance((-3, 0, 0), (3, 0, 0)) * 1.01


@pytest.mark.parametrize("boxes", [(), ((0, 0, 1, 1.5), (2.5, 0.6, 0.5, 1.5))])
def test_a_path_is_as_long_as_its_distance_and_lies_on_the_floor(
    boxes: tuple[tuple[float, float, float, float], ...],
) -> None:
    navmesh = strip(HUMP, *boxes)
    points = navmesh.random_points(40, np.random.default_rng(0), island=0)
    distances = navmesh.geodesic_distances(points[:20], points[20:])
    for start, end, distance in zip(points[:20], points[20:], distances, strict=True):
        path = navmesh.shortest_path(start, end)
        assert path is not None
        np.testing.assert_allclose(path[[0, -1]], [start, end])
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(distance)
        assert distance == pytest.approx(navmesh.geodesic_distance(start, end), rel=1e-12)
        np.testing.assert_allclose(navmesh.snap(path), path, atol=1e-6)


def test_a_level_path_has_its_bends_only() -> None:
    navmesh = strip([(-5, 0), (5, 0)], (0, 0, 1, 1.5))
    path = navmesh.shortest_path((-3, 0, 0), (3, 0, 0))
    assert path is not None
    assert 3 <= len(path) <= 6


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_ring_on_a_slope_is_cut_from_a_sphere(side: float) -> None:
    navmesh = strip([(-5, -1.25), (5, 1.25)])
    start = (3.0 * side, 0.75 * side, 0.0)
    expected = 3.0 * math.hypot(1.0, 0.25) - 1.1
    found = navmesh.ring_distance(start, (0, 0, 0), 1.0)
    assert found == pytest.approx(expected, abs=0.01)
    assert navmesh.ring_distances([start], (0, 0, 0), 1.0)[0] == pytest.approx(found)


def test_no_sampled_point_of_a_ring_on_a_hump_is_much_nearer() -> None:
    navmesh = strip(HUMP, (0, 1.2, 1, 1), (-2.5, -0.5, 0.6, 1.4))
    rng = np.random.default_rng(2)
    dense = navmesh.random_points(20_000, rng, island=0)
    for start in navmesh.random_points(12, rng, island=0):
        anchor = navmesh.random_points(1, rng, island=0)[0]
        away = np.linalg.norm(dense - anchor, axis=1)
        ring = dense[(away >= 1.9) & (away <= 2.1)]
        found = navmesh.ring_distance(start, anchor, 2.0)
        nearest = np.min(navmesh.geodesic_distances(start, ring)) if len(ring) else math.nan
        if abs(np.linalg.norm(start - anchor) - 2.0) <= 0.1:
            assert found == 0.0
        else:
            # Points lie about 4 cm apart; the choice of contact is not exact on a rising floor.
            assert nearest - 0.08 <= found <= nearest + 0.03
