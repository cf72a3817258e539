"""Plans, views and recordings of scenes, and the table of them."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from small_release import box_room
from test_navmesh import box

from affectsim_data.cli import main
from affectsim_data.inspection.scene_plans import draw_plan, scene_sheet
from affectsim_data.inspection.scene_recording import record_scene
from affectsim_data.inspection.scene_summary import scene_lines
from affectsim_data.inspection.scene_views import standing_views, view_from_above, without_ceiling
from affectsim_data.navmesh import NavMesh
from affectsim_data.render import process_renderer
from affectsim_data.scenes import Scene, SceneObject

SIZE = 470
"""Of the room of 8 m with margins: 50 pixels a metre, plus what the walls take."""


@pytest.fixture(scope="module")
def crate() -> tuple[Scene, NavMesh]:
    """A room of 8 x 8 m with a crate of 2 x 1 m to the east."""
    scene = box_room("a room", boxes=[((1.0, 0.0, -0.5), (3.0, 1.0, 0.5))])
    thing = SceneObject("crate_01", "crate", (2.0, 0.0, 0.0), (2.0, 1.0, 1.0), 0.0, "room")
    scene = dataclasses.replace(scene, objects=(thing,))
    return scene, NavMesh.from_mesh(*scene.mesh())


def _pixel(x: float, z: float) -> tuple[int, int]:
    """Where a place of the plan is: the room of 8 m and its margin of 0.35 m fill the picture."""
    scale = SIZE / 8.7
    return round((x + 4.35) * scale), round((z + 4.35) * scale)


def test_plans_show_floor_robot_furniture_and_walls_in_their_places(
    crate: tuple[Scene, NavMesh],
) -> None:
    plan = draw_plan(*crate, width=SIZE, height=SIZE)
    at = {
        name: np.array(plan.getpixel(_pixel(x, z)), int)
        for name, (x, z) in {
            "robot": (-2.0, 1.0), "too near": (3.85, 2.0), "crate": (2.6, 0.3),
            "wall": (-4.07, 1.0), "outside": (-4.28, 1.0), "seat": (2.1, 0.0),
        }.items()
    }  # fmt: skip
    # Where the robot can be the floor is greener, and darker than the paper; the wall is dark.
    assert at["robot"][1] > at["robot"][0] + 5
    assert at["too near"][0] > at["too near"][2] + 20
    assert at["wall"].max() < 90
    assert at["outside"].min() > 240
    np.testing.assert_allclose(at["crate"], (214, 206, 196), atol=2)
    assert at["seat"][0] > at["seat"][1] + 60


@pytest.mark.egl
def test_views_from_above_look_through_the_ceiling(crate: tuple[Scene, NavMesh]) -> None:
    scene, _ = crate
    view = view_from_above(scene, process_renderer("egl"), width=200, height=200)
    floor, thing = view[150, 60].astype(int), view[96, 140].astype(int)
    assert floor[0] > floor[2] + 40, "oak"
    assert thing[2] > thing[0] + 30, "the crate's blue"
    cut = without_ceiling(scene)
    assert 0 < cut.num_triangles < scene.num_triangles
    assert max(
        surface.positions[surface.faces, 1].min(axis=1).max() for surface in cut.surfaces
    ) < (2.4)


@pytest.mark.egl
def test_floors_of_halls_are_seen_from_above_too() -> None:
    view = view_from_above(
        box_room("hall", half=20.0), process_renderer("egl"), width=90, height=60
    ).astype(int)
    assert view[30, 45, 0] > view[30, 45, 2] + 40, "oak"


@pytest.mark.egl
def test_every_room_is_seen_from_standing_height(crate: tuple[Scene, NavMesh]) -> None:
    views = standing_views(*crate, process_renderer("egl"), width=64, height=48)
    assert list(views) == ["room"]
    assert views["room"].shape == (48, 64, 3)
    assert np.ptp(views["room"]) > 50


@pytest.mark.egl
def test_sheets_and_recordings_hold_both_pictures(
    tmp_path: Path, crate: tuple[Scene, NavMesh]
) -> None:
    alone, both = (
        scene_sheet(*crate, size=200),
        scene_sheet(*crate, process_renderer("egl"), size=200),
    )
    assert both.width == 2 * alone.width
    record_scene(*crate, tmp_path / "room.rrd", plan=both)
    assert (tmp_path / "room.rrd").read_bytes()[:4] == b"RRF2"


def test_islands_are_told_apart() -> None:
    scene = box_room("cut")
    parts = [box(0.0, 0.0, 0.2, 8.0, 2.5)]
    vertices, faces = scene.mesh()
    for part in parts:
        faces = np.concatenate([faces, np.asarray(part.faces) + len(vertices)])
        vertices = np.concatenate([vertices, np.asarray(part.vertices)])
    navmesh = NavMesh.from_mesh(vertices, faces)
    assert len(navmesh.islands) == 2
    plan = draw_plan(scene, navmesh, width=SIZE, height=SIZE)
    left, right = (np.array(plan.getpixel(_pixel(x, 3.0)), int) for x in (-2.0, 2.0))
    assert np.abs(left - right).max() > 15


def test_table_of_scenes_has_a_row_each_and_totals(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], small_release_path: Path
) -> None:
    assert main(["info", str(small_release_path), "--scenes", "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)
    lines = scene_lines(rows)
    assert len(lines) == len(rows) + 2
    assert lines[-1].startswith(f"{len(rows)} scenes, ")
    assert all(row["scene_id"] in line for row, line in zip(rows, lines[1:-1], strict=True))
    for row in rows:
        assert 0.0 < row["robot_m2"] < row["floor_m2"]
        assert row["largest_island"] == 1.0


def test_scenes_and_motions_are_asked_for_one_at_a_time(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["info", "--scenes", "--motions"]) == 1
    assert "give one of them" in capsys.readouterr().err
    assert main(["info", "--scenes", "--split", "test"]) == 1
    assert "--scenes describes all of them" in capsys.readouterr().err
