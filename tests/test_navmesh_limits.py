"""Meshes as they come: open, in pieces, too large, and real ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh

from affectsim_data.navmesh import NavMesh, rasterize
from affectsim_data.poses import FloatArray

QUAD = np.array([[0, 2, 1], [0, 3, 2]])


def sheet(x0: float, x1: float, half: float = 2.0, y: float = 0.0) -> FloatArray:
    """Corners of a level rectangle."""
    return np.array([[x0, y, -half], [x1, y, -half], [x1, y, half], [x0, y, half]])


def test_sheets_with_a_gap_of_ten_metres_are_islands() -> None:
    vertices = np.concatenate([sheet(0, 4), sheet(14, 17)])
    navmesh = NavMesh.from_mesh(vertices, np.concatenate([QUAD, QUAD + 4]))
    assert len(navmesh.islands) == 2
    assert navmesh.geodesic_distance((1, 0, 0), (16, 0, 0)) == np.inf
    with pytest.raises(ValueError, match=r"point \(9.000, 0.000, 0.000\) is \d\.\d+ m off"):
        navmesh.geodesic_distance((1, 0, 0), (9, 0, 0))


def test_an_open_box_without_a_lid_or_a_side_is_navigable() -> None:
    box = trimesh.creation.box((4.0, 2.5, 4.0))
    kept = (box.face_normals[:, 1] < -0.5) | (box.face_normals[:, 0] < -0.5)
    navmesh = NavMesh.from_mesh(box.vertices, box.faces[kept][:, ::-1])
    assert navmesh.area_m2 == pytest.approx(3.3**2, rel=0.06)


def test_triangles_without_an_area_change_nothing() -> None:
    vertices = sheet(0, 4)
    plain = NavMesh.from_mesh(vertices, QUAD)
    flat = np.concatenate([QUAD, [[0, 0, 1], [2, 2, 2]]])
    assert NavMesh.from_mesh(vertices, flat).to_bytes() == plain.to_bytes()


@pytest.mark.parametrize("side", [150.0, 1000.0, 1e6])
def test_a_scene_too_large_for_its_cells_is_refused(side: float) -> None:
    with pytest.raises(ValueError, match=r"needs .* columns of 0.05 m, the limit is 4194304"):
        NavMesh.from_mesh(sheet(0, side, side / 2.0), QUAD)


def test_a_large_scene_builds_with_larger_cells() -> None:
    navmesh = NavMesh.from_mesh(sheet(0, 120, 60), QUAD, cell_size=0.5)
    assert navmesh.area_m2 == pytest.approx(118.0**2, rel=0.01)


def test_more_work_than_the_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rasterize, "MAX_PAIRS", 10_000)
    with pytest.raises(ValueError, match=r"8 triangles lie over .* decimate the mesh"):
        NavMesh.from_mesh(sheet(0, 4), np.tile(QUAD, (4, 1)))


def test_dense_meshes_are_thinned_as_they_come(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same navmesh whether all is held at once or not, and however triangles are cut up."""
    sheet_mesh = trimesh.Trimesh(sheet(0, 4), QUAD, process=False)
    for _ in range(4):
        sheet_mesh = sheet_mesh.subdivide()
    vertices, faces = sheet_mesh.vertices, sheet_mesh.faces
    whole = NavMesh.from_mesh(vertices, faces)
    monkeypatch.setattr(rasterize, "MAX_TOUCHES_HELD", 500)
    monkeypatch.setattr(rasterize, "PAIRS_PER_CHUNK", 64)
    assert NavMesh.from_mesh(vertices, faces).to_bytes() == whole.to_bytes()
    assert NavMesh.from_mesh(sheet(0, 4), QUAD).area_m2 == pytest.approx(whole.area_m2)


@pytest.mark.realdata
@pytest.mark.parametrize(
    ("path", "dropped", "is_z_up", "least_m2"),
    [
        ("morse_bsd/tum_kitchen.glb", "Compass", False, 40.0),
        ("habitat_sim_test_assets/data/test_assets/scenes/simple_room.glb", "-", True, 80.0),
    ],
)
def test_real_rooms_build_and_navigate(
    realdata: Path, path: str, dropped: str, is_z_up: bool, least_m2: float
) -> None:
    scene = trimesh.load_scene(realdata / path)
    nodes = [node for node in scene.graph.nodes_geometry if dropped in node]
    scene.delete_geometry([scene.graph[node][1] for node in nodes])
    mesh = scene.to_mesh()
    vertices = mesh.vertices[:, [0, 2, 1]] * [1, 1, -1] if is_z_up else mesh.vertices
    navmesh = NavMesh.from_mesh(vertices, mesh.faces)
    assert navmesh.island_areas_m2[0] >= least_m2
    points = navmesh.random_points(100, np.random.default_rng(0), island=0)
    distances = navmesh.geodesic_distances(points[:50], points[50:])
    assert np.all(distances >= np.linalg.norm(points[:50] - points[50:], axis=1) - 1e-9)
    assert distances.max() < 40.0
