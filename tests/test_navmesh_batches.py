"""Many points at once: the same answers as one by one, and points drawn where one asks."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from numpy.typing import ArrayLike

from affectsim_data.navmesh import NavMesh


def two_rooms() -> NavMesh:
    """Two rooms that a wall cuts apart, with some boxes; the left one is larger."""
    corners = [[-5, 0, -3], [4, 0, -3], [4, 0, 3], [-5, 0, 3]]
    mesh = trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)
    for x, z, width, depth in [
        (0, 0, 0.2, 6),
        (-3, 1, 0.8, 1.2),
        (-2, -1.4, 1.5, 0.4),
        (2, 1, 1, 1),
    ]:
        box = trimesh.creation.box((width, 2.0, depth))
        mesh = mesh + box.apply_translation([x, 1.0, z])
    return NavMesh.from_mesh(mesh.vertices, mesh.faces)


ROOMS = two_rooms()
POINTS = ROOMS.random_points(60, np.random.default_rng(0))


def test_islands_of_points_are_those_of_each() -> None:
    each = [ROOMS.island(point) for point in POINTS]
    np.testing.assert_array_equal(ROOMS.island_numbers(POINTS), each)
    assert set(each) == {0, 1}
    off = np.array([[0.0, 0.0, 0.0], [-2.0, 1.0, 0.0], [-2.0, 0.0, 0.5]])
    np.testing.assert_array_equal(ROOMS.island_numbers(off), [-1, -1, 0])


def test_navigable_points_are_those_of_each() -> None:
    points = np.random.default_rng(1).uniform([-6, -0.2, -4], [5, 0.2, 4], (200, 3))
    many = ROOMS.navigable(points)
    np.testing.assert_array_equal(many, [ROOMS.is_navigable(point) for point in points])
    assert 20 < many.sum() < 180


def test_a_matrix_of_distances_holds_all_pairs() -> None:
    starts, ends = POINTS[:20], POINTS[20:50]
    matrix = ROOMS.distance_matrix(starts, ends)
    each = [[ROOMS.geodesic_distance(start, end) for end in ends] for start in starts]
    np.testing.assert_allclose(matrix, each, rtol=1e-12)
    assert np.isinf(matrix).any()
    np.testing.assert_array_equal(matrix[3], ROOMS.geodesic_distances(starts[3], ends))


def test_a_straight_way_is_a_way_as_long_as_the_line() -> None:
    starts, ends = POINTS[:30], POINTS[30:]
    straight = ROOMS.has_straight_way(starts, ends)
    lines = np.linalg.norm(starts - ends, axis=1)
    ways = ROOMS.geodesic_distances(starts, ends)
    np.testing.assert_array_equal(straight, ways <= lines + 1e-9)
    assert 0 < straight.sum() < 30
    assert not ROOMS.has_straight_way((-1, 0, 0), (1, 0, 0))[0]


@pytest.mark.parametrize("island", [0, 1])
def test_points_of_one_island(island: int) -> None:
    points = ROOMS.random_points(50, np.random.default_rng(3), island=island)
    assert np.all(ROOMS.island_numbers(points) == island)


def test_points_in_a_room_and_around_a_place() -> None:
    rng = np.random.default_rng(4)
    corner = [(-5.0, -3.0), (-3.0, -3.0), (-3.0, 0.0), (-5.0, 0.0)]
    inside = ROOMS.random_points(400, rng, within=corner)
    assert np.all((inside[:, 0] <= -3.0) & (inside[:, 2] <= 0.0))
    assert np.all(ROOMS.navigable(inside, 1e-9))
    near = ROOMS.random_points(2000, rng, disc=((-4.0, 0.0, 0.0), 0.5))
    away = np.hypot(near[:, 0] + 4.0, near[:, 2])
    assert away.max() <= 0.5
    # Uniform in a free disc: half of the points lie within r / sqrt(2).
    assert np.mean(away < 0.5 / math.sqrt(2.0)) == pytest.approx(0.5, abs=0.04)
    both = ROOMS.random_points(20, rng, within=corner, disc=((-3.0, 0.0, -1.0), 0.4))
    assert np.all(both[:, 0] <= -3.0)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"island": 7}, "island must be 0 to 1, got 7"),
        ({"within": [(9, 9), (10, 9), (10, 10)]}, "no floor there"),
        ({"within": [(0, 0), (1, 1)]}, r"within must be corners \(x, z\)"),
        ({"disc": ((0, 0, 0), -1.0)}, "radius above 0 m"),
    ],
)
def test_points_that_cannot_be_drawn(asked: dict[str, ArrayLike], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ROOMS.random_points(5, np.random.default_rng(0), **asked)  # type: ignore[arg-type]
