"""Building, distances and storage: cases worked by hand, laws, and refusals."""

from __future__ import annotations

import contextlib
import math
import pickle
import struct

import numpy as np
import pytest
import shapely
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse.csgraph import dijkstra

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray


def slab(x0: float, z0: float, x1: float, z1: float, y: float = 0.0) -> trimesh.Trimesh:
    """A level rectangle that faces up."""
    corners = [[x0, y, z0], [x1, y, z0], [x1, y, z1], [x0, y, z1]]
    return trimesh.Trimesh(corners, [[0, 2, 1], [0, 3, 2]], process=False)


def box(x: float, z: float, width: float, depth: float, height: float) -> trimesh.Trimesh:
    """A closed box that stands on y = 0."""
    mesh: trimesh.Trimesh = trimesh.creation.box((width, height, depth))
    mesh.apply_translation([x, height / 2.0, z])
    return mesh


def build(*parts: trimesh.Trimesh, cell_size: float = 0.05) -> NavMesh:
    mesh = trimesh.Trimesh()
    for part in parts:
        mesh = mesh + part
    return NavMesh.from_mesh(mesh.vertices, mesh.faces, cell_size=cell_size)


def furnished(seed: int) -> NavMesh:
    rng = np.random.default_rng(seed)
    places, sizes = rng.uniform(-3, 3, (15, 2)), rng.uniform(0.2, 1.5, (15, 2))
    boxes = [
        box(x, z, width, depth, rng.choice([0.5, 2.0]))
        for (x, z), (width, depth) in zip(places, sizes, strict=True)
    ]
    return build(slab(-4, -4, 4, 4), *boxes)


BLOCK = build(slab(-5, -5, 5, 5), box(0, 0, 2, 2, 2))
FURNISHED = [furnished(seed) for seed in range(3)]
ALIGNED = build(
    slab(-4, -4, 4, 4),
    *(box(x, z, 0.75, 0.5, 1.0) for x in (-2.5, -0.75, 1.0, 2.5) for z in (-2.5, -1.0, 0.75, 2.5)),
)
# A room cut in two by a wall without a door.
CUT = build(slab(-4, -2, 4, 2), box(0, 0, 0.2, 4, 2.5))


@pytest.mark.parametrize(
    ("start", "end", "expected"),
    [((-4, 0, 0), (4, 0, 0), 8.5461), ((-4, 0, -1), (4, 0, 1.5), 8.7984)],
)
def test_way_around_a_block_has_its_analytic_length(
    start: tuple[float, ...], end: tuple[float, ...], expected: float
) -> None:
    assert BLOCK.geodesic_distance(start, end) == pytest.approx(expected, rel=0.003)


def test_free_floor_is_the_floor_less_the_radius() -> None:
    plain = build(slab(-5, -5, 5, 5))
    # One cell at the rim counts as ledge, as in Recast.
    assert plain.area_m2 == pytest.approx(9.3**2, rel=1e-6)
    assert len(plain.polygons) == 1
    assert plain.geodesic_distance((-4, 0, -4), (4, 0, 4)) == pytest.approx(math.hypot(8, 8))


def test_no_way_through_a_wall() -> None:
    assert CUT.geodesic_distance((-2, 0, 0), (2, 0, 0)) == math.inf
    assert CUT.shortest_path((-2, 0, 0), (2, 0, 0)) is None
    assert CUT.island((-2, 0, 0)) != CUT.island((2, 0, 0))


@pytest.mark.parametrize(("height", "reachable"), [(0.15, True), (0.3, False)])
def test_steps_up_to_max_climb_are_floor(height: float, reachable: bool) -> None:
    navmesh = build(slab(-4, -4, 4, 4), box(0, 0, 3, 3, height))
    distance = navmesh.geodesic_distance((-3, 0, 0), (0, height, 0))
    assert math.isfinite(distance) == reachable


def test_low_table_leaves_no_way_under_it() -> None:
    room, top = slab(-3, -1, 3, 1), trimesh.creation.box((0.5, 0.05, 2.0))
    assert math.isinf(
        build(room, top.copy().apply_translation([0, 1.3, 0])).geodesic_distance(
            (-2, 0, 0), (2, 0, 0)
        )
    )
    assert build(room, top.apply_translation([0, 1.8, 0])).geodesic_distance(
        (-2, 0, 0), (2, 0, 0)
    ) == pytest.approx(4.0)


def test_a_slope_is_followed_in_height() -> None:
    ramp = trimesh.Trimesh(
        [[0, 0, -2], [4, 1, -2], [4, 1, 2], [0, 0, 2]], [[0, 2, 1], [0, 3, 2]], process=False
    )
    navmesh = build(slab(-4, -2, 0, 2), ramp, slab(4, -2, 8, 2, y=1.0))
    assert navmesh.snap((2, 0.5, 0))[1] == pytest.approx(0.5, abs=0.005)
    assert navmesh.snap((6, 1, 0))[1] == pytest.approx(1.0, abs=0.002)
    assert math.isfinite(navmesh.geodesic_distance((-2, 0, 0), (6, 1, 0)))


def test_storeys_without_stairs_are_islands_of_their_own() -> None:
    navmesh = build(slab(-3, -3, 3, 3), slab(-3, -3, 3, 3, y=3.0))
    assert navmesh.island((0, 0, 0)) != navmesh.island((0, 3, 0))
    assert math.isinf(navmesh.geodesic_distance((0, 0, 0), (0, 3, 0)))


def test_storeys_joined_by_a_ramp_are_refused() -> None:
    ramp = trimesh.Trimesh(
        [[3, 0, -3], [9, 3, -3], [9, 3, 3], [3, 0, 3]], [[0, 2, 1], [0, 3, 2]], process=False
    )
    with pytest.raises(ValueError, match=r"storeys .* overlap near x .* split the mesh by height"):
        build(
            slab(-3, -3, 3, 3),
            ramp,
            slab(9, -3, 12, 3, 3.0),
            slab(-3, 3, 12, 6, 3.0),
            slab(-3, -3, 3, 3, 3.0),
        )


@settings(max_examples=30, deadline=None)
@given(scene=st.integers(0, 2), seed=st.integers(0, 10**6))
def test_distances_are_a_metric(scene: int, seed: int) -> None:
    navmesh = FURNISHED[scene]
    a, b, c = navmesh.random_points(3, np.random.default_rng(seed))
    ab, ba = navmesh.geodesic_distance(a, b), navmesh.geodesic_distance(b, a)
    assert ab == ba or ab == pytest.approx(ba, rel=1e-12)
    assert ab >= np.linalg.norm(a - b) - 1e-9
    assert ab <= navmesh.geodesic_distance(a, c) + navmesh.geodesic_distance(c, b) + 1e-9
    assert navmesh.geodesic_distance(a, a) == 0.0


@pytest.mark.parametrize("navmesh", FURNISHED)
def test_path_is_as_long_as_the_distance_and_stays_on_the_mesh(navmesh: NavMesh) -> None:
    points = navmesh.random_points(40, np.random.default_rng(0))
    for start, end in zip(points[:20], points[20:], strict=True):
        path = navmesh.shortest_path(start, end)
        distance = navmesh.geodesic_distance(start, end)
        if path is None:
            assert math.isinf(distance)
            continue
        legs = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert legs.sum() == pytest.approx(distance)
        share = np.linspace(0, 1, 50)[:, None, None]
        along = (1 - share) * path[:-1] + share * path[1:]
        assert np.all(navmesh.navigable(along.reshape(-1, 3), 1e-6))


@pytest.mark.parametrize("navmesh", [FURNISHED[2], ALIGNED])
def test_distances_equal_a_naive_visibility_graph(navmesh: NavMesh) -> None:
    """All corners, all pairs, sight by polygon containment: slow and without any pruning.

    On a grid many corners lie on one line, and lines of sight run along walls.
    """
    island, polygon = navmesh.islands[0], navmesh.polygons[0]
    points = navmesh.random_points(30, np.random.default_rng(2))
    points = points[[navmesh.island(point) == 0 for point in points]][:, [0, 2]]
    walls = island.walls
    points = np.concatenate([points, walls.start[::5], (walls.start + walls.end)[::4] / 2.0])
    nodes = np.concatenate([points, walls.start])
    one, two = np.triu_indices(len(nodes), 1)
    length = np.linalg.norm(nodes[one] - nodes[two], axis=1)
    wide = polygon.buffer(1e-7, join_style="mitre")
    shapely.prepare(wide)
    lines = shapely.linestrings(np.stack([nodes[one], nodes[two]], axis=1))
    seen = shapely.covers(wide, lines) | (length < 1e-9)
    graph = np.zeros((len(nodes), len(nodes)))
    graph[one[seen], two[seen]] = np.maximum(length[seen], 1e-7)  # 0 would mean no edge
    expected = dijkstra(graph, directed=False)[: len(points), : len(points)]
    places = island.on_floor(points)
    found = [navmesh.geodesic_distances(place, places) for place in places]
    np.testing.assert_allclose(found, expected, atol=1e-6)


def test_batch_and_single_distances_agree() -> None:
    points = FURNISHED[0].random_points(30, np.random.default_rng(1))
    batch = FURNISHED[0].geodesic_distances(points[0], points)
    single = [FURNISHED[0].geodesic_distance(points[0], point) for point in points]
    np.testing.assert_allclose(batch, single, rtol=1e-12)


@settings(max_examples=50, deadline=None)
@given(x=st.floats(-4.5, 4.5), z=st.floats(-4.5, 4.5))
def test_snap_is_idempotent(x: float, z: float) -> None:
    navmesh = FURNISHED[1]
    once = navmesh.snap((x, 0.0, z), max_offset=math.inf)
    np.testing.assert_array_equal(navmesh.snap(once, max_offset=0.0), once)


def test_distances_from_a_corner_of_the_mesh() -> None:
    """A start on a corner sees what lies beside the walls that meet there."""
    ring = BLOCK.islands[0].rings[1].astype(np.float64)
    for x, z in ring:
        corner = np.array([x, 0.0, z])
        outwards = corner * 1.5
        straight = float(np.linalg.norm(outwards - corner))
        assert BLOCK.geodesic_distance(corner, outwards) == pytest.approx(straight)
        assert BLOCK.geodesic_distance(outwards, corner) == pytest.approx(straight)
        assert BLOCK.geodesic_distance(corner, -corner) > 2.5


def test_random_points_are_uniform_over_the_area() -> None:
    points = BLOCK.random_points(4000, np.random.default_rng(0))
    assert np.all(BLOCK.navigable(points, 1e-9))
    share = BLOCK.island_areas_m2[0] / BLOCK.area_m2
    outer = np.max(np.abs(points[:, [0, 2]]), axis=1) > 1.0
    assert np.mean(outer) == pytest.approx(share, abs=0.02)
    left = points[outer, 0] < 0.0
    assert np.mean(left) == pytest.approx(0.5, abs=0.03)
    again = BLOCK.random_points(4000, np.random.default_rng(0))
    np.testing.assert_array_equal(points, again)


def test_distance_to_wall_by_hand() -> None:
    assert float(BLOCK.distance_to_wall((-3, 0, 0))) == pytest.approx(1.65, abs=0.051)
    assert BLOCK.distance_to_wall(np.array([[-3.0, 0, 0], [-4.0, 0, 0]])).shape == (2,)


@pytest.mark.parametrize("navmesh", [*FURNISHED, BLOCK, CUT])
def test_a_reloaded_mesh_answers_exactly_alike(navmesh: NavMesh) -> None:
    payload = navmesh.to_bytes()
    copy = NavMesh.from_bytes(payload, name="copy")
    assert copy.to_bytes() == payload
    assert copy.settings == navmesh.settings
    points = navmesh.random_points(20, np.random.default_rng(5))
    np.testing.assert_array_equal(copy.random_points(20, np.random.default_rng(5)), points)
    for a, b in zip(points[:10], points[10:], strict=True):
        assert copy.geodesic_distance(a, b) == navmesh.geodesic_distance(a, b)
        asked = copy.ring_distance(a, b, 1.0), navmesh.ring_distance(a, b, 1.0)
        np.testing.assert_equal(*asked)
    assert pickle.loads(pickle.dumps(navmesh)).to_bytes() == payload


def test_save_keeps_the_hash_of_the_mesh(tmp_path: object) -> None:
    navmesh = NavMesh(CUT.settings, CUT.islands, "ab" * 32)
    path = f"{tmp_path}/room.navmesh"
    navmesh.save(path)
    assert NavMesh.load(path).mesh_sha256 == "ab" * 32


def test_broken_bytes_are_refused_by_name() -> None:
    payload = CUT.to_bytes()
    for size in range(0, len(payload), 7):
        with pytest.raises(ValueError, match=r"^room: "):
            NavMesh.from_bytes(payload[:size], name="room")
    with pytest.raises(ValueError, match=r"^room: 1 bytes follow"):
        NavMesh.from_bytes(payload + b"x", name="room")
    with pytest.raises(ValueError, match=r"^room: not a navmesh"):
        NavMesh.from_bytes(b"GLTF" + payload[4:], name="room")
    with pytest.raises(ValueError, match=r"^room: number of islands"):
        NavMesh.from_bytes(payload[:120] + struct.pack("<I", 1 << 31), name="room")


def test_flipped_bytes_never_crash() -> None:
    payload = CUT.to_bytes()
    rng = np.random.default_rng(0)
    for _ in range(300):
        broken = bytearray(payload)
        broken[rng.integers(len(broken))] ^= int(rng.integers(1, 256))
        # A flipped coordinate may still be a polygon; anything else is a named error.
        with contextlib.suppress(ValueError):
            NavMesh.from_bytes(bytes(broken), name="room")


def test_a_scene_without_floor_says_what_was_looked_for() -> None:
    flipped = slab(-3, -3, 3, 3)
    with pytest.raises(ValueError, match=r"no walkable surface: .* 1.5 m of free .* 0 of 2 tri"):
        NavMesh.from_mesh(flipped.vertices, flipped.faces[:, ::-1])
    with pytest.raises(ValueError, match=r"2 face down: .* reverse the corners of all faces"):
        NavMesh.from_mesh(flipped.vertices, flipped.faces[:, ::-1])
    with pytest.raises(ValueError, match="no walkable surface"):
        build(slab(-0.5, -0.5, 0.5, 0.5))


@pytest.mark.parametrize(
    ("vertices", "faces", "message"),
    [
        ([[0.0, 0.0]], [[0, 0, 0]], r"vertices must be \(n, 3\)"),
        ([[0.0] * 3, [0.0, np.nan, 0.0]], [[0, 0, 0]], "finite: 1 of 2 are not, .* number 1"),
        ([[0.0, 0.0, 0.0]], [[0, 0, 1]], "faces name vertices 0 to 1, but there are 1"),
        ([[0.0, 0.0, 0.0]], [[0.5, 0, 0]], "faces must be whole numbers"),
        ([[0.0, 0.0, 0.0]], np.zeros((0, 3), int), "without triangles"),
        ([[0.0, 0.0, 0.0], [1e6, 0.0, 1e6]], [[0, 1, 1]], "unit is the metre"),
    ],
)
def test_malformed_meshes_are_refused(vertices: FloatArray, faces: object, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        NavMesh.from_mesh(vertices, np.asarray(faces))


def test_malformed_settings_and_points_are_refused() -> None:
    with pytest.raises(ValueError, match="cell_size must be at least"):
        build(slab(-3, -3, 3, 3), cell_size=0.0)
    with pytest.raises(ValueError, match=r"point \(0.000, 0.000, 0.000\) is 0\.\d+ m off"):
        CUT.geodesic_distance((0, 0, 0), (2, 0, 0))
    with pytest.raises(ValueError, match="must be finite"):
        CUT.snap((0, np.nan, 0))
    with pytest.raises(ValueError, match=r"a point must be \(3,\)"):
        CUT.island(np.zeros((2, 3)))
    with pytest.raises(ValueError, match="mesh_sha256 must be 64 hex digits"):
        NavMesh(CUT.settings, CUT.islands, "abc")
