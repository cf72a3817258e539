"""A place in one mesh file as a scene: its floor, rooms, things and seats, and what is off."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mesh_files import boxes_obj, write

from affectsim_data.builders.imports import ImportReport
from affectsim_data.builders.mesh_scenes import mesh_scene
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene

Boxes = dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]]
ROOM: Boxes = {
    "floor": ((0, -0.1, 0), (5, 0, 4)),
    "wall_west": ((-0.1, 0, 0), (0, 2.5, 4)),
    "wall_east": ((5, 0, 0), (5.1, 2.5, 4)),
    "ceiling": ((0, 2.5, 0), (5, 2.6, 4)),
    "Kitchen_Table.001": ((1, 0, 1), (2.6, 0.74, 1.9)),
}
CHAIR: Boxes = {
    # One object each in the file; `chair` shows what a node of several parts is, below.
    "seat": ((3, 0, 2), (3.45, 0.45, 2.5)),
    "back": ((3, 0.45, 2), (3.05, 0.9, 2.5)),
}


def imported(folder: Path, text: str, **options: Any) -> tuple[Scene, ImportReport]:
    """A scene from an OBJ."""
    return mesh_scene(write(folder / "kitchen.obj", text), scene_id="test/kitchen", **options)


def corners(scene: Scene, room: int = 0) -> set[tuple[float, float]]:
    """Of a room, to the centimetre."""
    return {(round(x, 2), round(z, 2)) for x, z in scene.rooms[room].polygon}


def test_a_room_has_the_outline_of_its_floor_and_its_ceiling(tmp_path: Path) -> None:
    scene, report = imported(tmp_path, boxes_obj(ROOM))
    (room,) = scene.rooms
    assert corners(scene) == {(0, 0), (5, 0), (5, 4), (0, 4)}
    assert room.purpose == "kitchen"
    assert room.floor_y == pytest.approx(0.0, abs=1e-6)
    assert room.ceiling_y == pytest.approx(2.5, abs=1e-4)
    (table,) = scene.objects
    assert (table.object_id, table.category, table.room_id) == ("table_01", "table", room.room_id)
    np.testing.assert_allclose(table.position, [1.8, 0.0, 1.45], atol=1e-6)
    np.testing.assert_allclose(table.size, [1.6, 0.74, 0.9], atol=1e-6)
    assert report.names("found", "structure") == ("ceiling", "floor", "wall_east", "wall_west")
    assert report.triangles == scene.num_triangles == 60
    assert scene.source == "kitchen.obj"
    navmesh = NavMesh.from_mesh(*scene.mesh())
    # One island inside, and the top of the ceiling.
    assert 10.0 < min(navmesh.island_areas_m2) <= max(navmesh.island_areas_m2) < 18.0


def test_chairs_have_seats_that_look_away_from_their_backs(tmp_path: Path) -> None:
    text = (
        boxes_obj({**ROOM, **CHAIR}).replace("o seat", "o Dining Chair.002").replace("o back", "")
    )
    scene, _ = imported(tmp_path, text)
    (seat,) = scene.seats
    # The back is at its low x: a sitter looks along +X, which is a yaw of 90 degrees.
    assert seat.yaw_deg == 90.0
    assert seat.height == pytest.approx(0.45, abs=0.01)
    assert seat.position[0] == pytest.approx(3.33, abs=0.04)
    assert seat.position[2] == pytest.approx(2.25, abs=0.03)
    (chair,) = (one for one in scene.objects if one.category == "chair")
    assert chair.yaw_deg == 90.0
    np.testing.assert_allclose(chair.size, [0.5, 0.9, 0.45], atol=1e-6)


def test_floors_that_are_not_connected_are_rooms_of_their_own(tmp_path: Path) -> None:
    second = {"floor2": ((5.4, -0.1, 0.0), (8.0, 0.0, 2.0)), "mat": ((9, -0.1, 0), (9.5, 0, 0.5))}
    scene, _ = imported(tmp_path, boxes_obj({**ROOM, **second}))
    assert [room.room_id for room in scene.rooms] == ["kitchen_1", "kitchen_2"]
    assert corners(scene, 1) == {(5.4, 0), (8, 0), (8, 2), (5.4, 2)}


def test_far_nodes_are_told_and_can_be_dropped(tmp_path: Path) -> None:
    text = boxes_obj(
        {**ROOM, "Compass_x": ((0, 18, 0), (1, 19, 1)), "sign": ((40, 0, 0), (41, 1, 1))}
    )
    _, report = imported(tmp_path, text)
    notes = " ".join(report.notes)
    assert "'Compass_x' is 15.5 m away from the rooms; drop_nodes leaves it out" in notes
    assert "'sign' is 35.0 m away" in notes
    scene, report = imported(tmp_path, text, drop_nodes=("Compass*", "sign", "lamp*"))
    assert scene.mesh()[0][:, 1].max() < 3.0
    assert report.names("skipped", "node") == ("Compass_x", "sign")
    assert "drop_nodes pattern 'lamp*' matches no node" in report.notes
    assert "away from" not in " ".join(report.notes)
    with pytest.raises(ValueError, match=r"kitchen.obj: drop_nodes \['\*'\] leave nothing"):
        imported(tmp_path, text, drop_nodes=("*",))


def test_another_axis_or_unit_is_said_or_found(tmp_path: Path) -> None:
    upright = imported(tmp_path, boxes_obj(ROOM))[0]
    # The same place with Z up, in centimetres: x, y, z are 100 x, -100 z, 100 y.
    turned = {
        name: (
            (100 * low[0], -100 * high[2], 100 * low[1]),
            (100 * high[0], -100 * low[2], 100 * high[1]),
        )
        for name, (low, high) in ROOM.items()
    }
    scene, report = imported(tmp_path, boxes_obj(turned), metres_per_unit=0.01)
    assert any(note.startswith("taken as z up") for note in report.notes)
    assert corners(scene) == corners(upright)
    assert scene.mesh()[0].min() == pytest.approx(upright.mesh()[0].min(), abs=1e-5)
    said, report = imported(tmp_path, boxes_obj(turned), metres_per_unit=0.01, up="z")
    assert corners(said) == corners(upright)
    assert not any("z up" in note for note in report.notes)
    with pytest.raises(ValueError, match=r"kitchen.obj: no floor: .*is another axis up"):
        imported(tmp_path, boxes_obj({"wall": ((0, 0, 0), (0.05, 3, 4))}), up="y")
    with pytest.raises(ValueError, match="520 m across, more than the 500 m of any place"):
        imported(tmp_path, boxes_obj(ROOM), metres_per_unit=100.0)


def test_a_floor_that_faces_down_is_turned_round(tmp_path: Path) -> None:
    floor = "o floor\nv 0 0 0\nv 4 0 0\nv 4 0 3\nv 0 0 3\nf 1 2 3 4\n"
    scene, report = imported(tmp_path, floor)
    assert report.notes["floor triangles that faced down turned round"] == 2
    assert NavMesh.from_mesh(*scene.mesh()).area_m2 > 5.0
    assert scene.rooms[0].ceiling_y == pytest.approx(2.6)
    assert imported(tmp_path, floor, ceiling_y=3.0)[0].rooms[0].ceiling_y == 3.0


def test_the_lowest_large_level_with_headroom_is_the_floor(tmp_path: Path) -> None:
    # A slab in the ground under the floor, and a table top.
    more = {"slab": ((0, -0.8, 0), (5, -0.7, 4)), "cupboard": ((0, 0, 0), (2, 1, 1))}
    scene, _ = imported(tmp_path, boxes_obj({**ROOM, **more}))
    assert scene.rooms[0].floor_y == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("boxes", "options", "match"),
    [
        (
            {"stone": ((0, 0, 0), (1, 1, 1))},
            {},
            "no floor: the largest level surface .* has 1.00 m2",
        ),
        ({"beam": ((0, 0, 0), (40, 0.1, 0.2))}, {}, "no floor: its pieces .* are all too small"),
        (ROOM, {"up": "x"}, "up must be one of"),
        (ROOM, {"metres_per_unit": 0.0}, "metres_per_unit must be above 0"),
        (ROOM, {"metres_per_unit": float("nan")}, "metres_per_unit must be above 0"),
    ],
)
def test_what_is_no_place_is_told(
    tmp_path: Path, boxes: Boxes, options: dict[str, Any], match: str
) -> None:
    with pytest.raises(ValueError, match=match):
        imported(tmp_path, boxes_obj(boxes), **options)


def test_vertices_that_are_nowhere_are_counted_in_the_report(tmp_path: Path) -> None:
    text = boxes_obj(ROOM) + "v nan 0 0\nf -1 -2 -3\n"
    _, report = imported(tmp_path, text)
    assert report.notes["triangles with vertices that are nan or beyond 100 km dropped"] == 1


@pytest.mark.realdata
def test_a_real_kitchen_can_be_walked_in(realdata: Path) -> None:
    path = realdata / "morse_bsd/tum_kitchen.glb"
    scene, report = mesh_scene(path, scene_id="tum/kitchen", drop_nodes=("Compass_*",))
    (room,) = scene.rooms
    assert room.purpose == "kitchen"
    low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
    np.testing.assert_allclose(high - low, [8.2, 11.75], atol=0.1)
    assert len(scene.seats) == 4
    assert {seat.yaw_deg for seat in scene.seats} == {180.0}
    assert report.names("skipped", "node") == ("Compass",)
    assert not any("away from" in note for note in report.notes)
    navmesh = NavMesh.from_mesh(*scene.mesh())
    assert 40.0 < navmesh.area_m2 < 50.0


@pytest.mark.realdata
def test_a_real_room_with_z_up_stands_upright(realdata: Path) -> None:
    path = realdata / "habitat_sim_test_assets/data/test_assets/scenes/simple_room.glb"
    scene, report = mesh_scene(path, scene_id="habitat/simple_room")
    assert any(note.startswith("taken as z up") for note in report.notes)
    assert scene.rooms[0].floor_y == pytest.approx(0.15, abs=0.01)
    assert 85.0 < NavMesh.from_mesh(*scene.mesh()).area_m2 < 100.0
