"""Scenes of Habitat datasets come in where, and only where, their files say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from habitat_files import BED, CHAIR, DEFAULT_CONFIG, SOFA, DatasetFiles, bounds

from affectsim_data.builders.habitat import read_dataset
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene

HALF = float(np.sqrt(0.5))
BOX = ((0.0, 0.0, 0.0), (1.0, 2.0, 4.0))
"""Its middle is at (0.5, 1, 2): every axis and both ends can be told apart."""
TURNED = [HALF, 0.0, HALF, 0.0]
"""A quarter turn about Y, wxyz: +X goes to -Z and +Z to +X."""


@pytest.fixture
def files(tmp_path: Path) -> DatasetFiles:
    """A dataset with a floor and a box."""
    files = DatasetFiles(tmp_path / "data")
    files.stage()
    files.add_object("box", BOX)
    return files


def placed(files: DatasetFiles, **instance: object) -> np.ndarray:
    """The box of the object `box` in the world."""
    files.scene({"template_name": "box", **instance})
    return bounds(files.imported()[0], "box")


# Placement, worked by hand.


def test_the_translation_is_that_of_the_middle_unless_told_otherwise(files: DatasetFiles) -> None:
    assert placed(files, translation=[10, 0, 0]).tolist() == [[9.5, -1, -2], [10.5, 1, 2]]
    moved = placed(files, translation=[10, 0, 0], translation_origin="asset_local")
    assert moved.tolist() == [[10, 0, 0], [11, 2, 4]]


def test_a_scene_says_which_origin_all_its_objects_have(files: DatasetFiles) -> None:
    com = {"template_name": "box", "translation_origin": "COM"}
    files.scene({"template_name": "box"}, com, translation_origin="asset_local")
    scene, _ = files.imported()
    assert bounds(scene, "box_001").tolist() == [[0, 0, 0], [1, 2, 4]]
    assert bounds(scene, "box_002").tolist() == [[-0.5, -1, -2], [0.5, 1, 2]]


def test_a_centre_of_mass_that_is_given_counts_and_is_scaled(files: DatasetFiles) -> None:
    files.add_object("box", BOX, COM=[0, 1, 0], scale=[2, 2, 2])
    assert placed(files).tolist() == [[0, -2, 0], [2, 2, 8]]


def test_things_are_scaled_then_turned_then_moved(files: DatasetFiles) -> None:
    box = placed(
        files, rotation=TURNED, non_uniform_scale=[3, 1, 1], uniform_scale=2,
        translation=[1, 0, 0], translation_origin="asset_local",
    )  # fmt: skip
    # 6 x 4 x 8; its length along X ends up along -Z, the one along Z along X.
    assert box.tolist() == [[1, 0, -6], [9, 4, 0]]


def test_units_and_frames_of_templates(files: DatasetFiles) -> None:
    files.add_object("box", BOX, units_to_meters=0.01, up=[0, 0, 1], front=[0, 1, 0])
    # Z of the file is up and Y its front, which is -Z in the world.
    box = placed(files, translation_origin="asset_local")
    assert box.tolist() == [[0, 0, -0.02], [0.01, 0.04, 0]]


def test_the_given_centre_of_mass_is_in_the_frame_of_the_template(files: DatasetFiles) -> None:
    files.add_object("box", BOX, up=[0, 0, 1], front=[0, 1, 0], COM=[0, 4, 0])
    assert placed(files).tolist() == [[0, -4, -2], [1, 0, 0]]


def test_a_z_up_stage_stands_on_its_floor(files: DatasetFiles) -> None:
    files.stage("room", ((-3, -2, -0.1), (3, 2, 0)), up=[0, 0, 1], front=[0, 1, 0])
    files.scene(stage="room")
    scene, _ = files.imported()
    assert bounds(scene, "room").tolist() == [[-3, -0.1, -2], [3, 0, 2]]
    assert scene.rooms[0].floor_y == pytest.approx(0.0)


def test_a_glb_stage_that_does_not_say_is_z_up_as_in_habitat(files: DatasetFiles) -> None:
    files.mesh("stages/scan.glb", ((-3, -2, -0.1), (3, 2, 0)))
    config = {**DEFAULT_CONFIG, "stages": {"paths": {".glb": ["stages/sc*.glb"]}}}
    files.json("test.scene_dataset_config.json", config)
    scene, report = files.imported("scan")
    assert bounds(scene, "scan").tolist() == [[-3, -0.1, -2], [3, 0, 2]]
    assert any("which way is up" in note for note in report.notes)


def test_a_stage_is_moved_by_its_origin_never_by_its_middle(files: DatasetFiles) -> None:
    files.stage(origin=[0, 1, 0])
    stage = {"template_name": "floor", "translation": [5, 0, 0], "translation_origin": "COM"}
    files.scene(stage_instance=stage)
    assert bounds(files.imported()[0], "floor").tolist() == [[2, 0.9, -2], [8, 1, 2]]


def test_mirrored_things_are_not_inside_out(files: DatasetFiles) -> None:
    files.scene({"template_name": "box", "non_uniform_scale": [-1, 1, 1], "rotation": TURNED})
    scene, report = files.imported()
    surface = next(one for one in scene.surfaces if one.name.startswith("box"))
    corners = surface.positions[surface.faces].astype(float)
    volume = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(8.0, rel=1e-4)
    outward = corners.mean(axis=1) - surface.positions.mean(axis=0)
    assert (np.einsum("ij,ij->i", outward, surface.normals[surface.faces[:, 0]]) > 0.0).all()
    assert report.notes["instances mirrored by a negative scale"] == 1


def test_normals_stay_upright_on_faces_when_scaled_unevenly(files: DatasetFiles) -> None:
    turn = [np.cos(0.3), 0.0, np.sin(0.3), 0.0]
    files.scene({"template_name": "box", "non_uniform_scale": [5, 0.3, 1], "rotation": turn})
    for surface in files.imported()[0].surfaces:
        corners = surface.positions[surface.faces].astype(float)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", normals, surface.normals[surface.faces[:, 0]]).min() > 0.999


def test_rotations_are_normalised_and_said_so(files: DatasetFiles) -> None:
    files.scene({"template_name": "box", "rotation": [2, 0, 2, 0]})
    scene, report = files.imported()
    assert bounds(scene, "box").tolist() == [[-2, -1, -0.5], [2, 1, 0.5]]
    assert report.notes["rotations that were not of length 1, normalised"] == 1


# Datasets and templates.


def test_defaults_copies_and_own_templates_of_a_config(files: DatasetFiles) -> None:
    config = json.loads(json.dumps(DEFAULT_CONFIG))
    config["objects"]["default_attributes"] = {"scale": [2, 2, 2]}
    config["objects"]["configs"] = [
        {"original_file": "objects/box.object_config.json", "template_handle": "flat",
         "attributes": {"scale": [1, 0.5, 1]}},
        {"template_handle": "new", "attributes": {"render_asset": "objects/box.glb"}},
    ]  # fmt: skip
    files.json("test.scene_dataset_config.json", config)
    names = [{"template_name": name} for name in ("box", "flat", "new")]
    files.scene(*names, translation_origin="asset_local")
    scene, _ = files.imported()
    sizes = [bounds(scene, name)[1].tolist() for name in ("box", "flat", "new")]
    assert sizes == [[2, 4, 8], [1, 1, 4], [2, 4, 8]]


def test_wildcards_ranges_and_names_without_ending(files: DatasetFiles) -> None:
    for number in range(12):
        files.add_object(f"kit/{number:02}/cup_{number:02}", BOX)
    paths = ["objects/kit/0[3-5]", "objects/kit/1?/cup_1*", "objects/box"]
    config = {**DEFAULT_CONFIG, "objects": {"paths": {".json": paths}}}
    files.json("test.scene_dataset_config.json", config)
    handles = [name.rsplit("/", 1)[-1].split(".")[0] for name in files.read().objects.handles]
    assert handles == ["box", "cup_03", "cup_04", "cup_05", "cup_10", "cup_11"]


def test_a_mesh_named_in_paths_brings_the_config_beside_it(files: DatasetFiles) -> None:
    files.add_object("big", BOX, scale=[3, 3, 3])
    config = {**DEFAULT_CONFIG, "objects": {"paths": {".glb": ["objects"]}}}
    files.json("test.scene_dataset_config.json", config)
    files.scene({"template_name": "big", "translation_origin": "asset_local"})
    assert bounds(files.imported()[0], "big")[1].tolist() == [3, 6, 12]


def test_templates_match_as_in_habitat(files: DatasetFiles) -> None:
    for name in ("chair_10", "armchair_1", "Chair_1"):
        files.add_object(name, BOX)
    library = files.read().objects
    exact = library.find("objects/chair_10.object_config.json")
    first = library.find("chair_1")
    assert exact is not None
    assert (exact.handle, exact.others) == ("objects/chair_10.object_config.json", 0)
    # The first in the alphabet that contains the name, whatever its case.
    assert first is not None
    assert (first.handle, first.others) == ("objects/Chair_1.object_config.json", 2)
    assert library.find("chair_2") is None
    assert library.find("") is None


def test_a_name_with_several_templates_is_noted(files: DatasetFiles) -> None:
    files.add_object("box_b", BOX)
    files.scene({"template_name": "ox"}, {"template_name": "box"})
    _, report = files.imported()
    notes = [note for note in report.notes if "several handles" in note]
    assert notes == ["'ox' is in several handles: 'objects/box.object_config.json' was taken"]


def test_a_folder_with_several_datasets_lists_them(files: DatasetFiles) -> None:
    files.json("other.scene_dataset_config.json", {})
    with pytest.raises(ValueError, match=r"has 2 datasets.*: other\.scene.*, test\.scene"):
        files.read()
    config = files.root / "test.scene_dataset_config.json"
    assert read_dataset(config).objects.handles == ("objects/box.object_config.json",)


def test_a_folder_without_a_config_is_searched(files: DatasetFiles) -> None:
    files.scene({"template_name": "box"})
    (files.root / "test.scene_dataset_config.json").unlink()
    scene, report = files.imported()
    assert report.total("found", "object") == 1
    assert scene.scene_id == "home"


@pytest.mark.parametrize("name", ["nowhere", "empty"])
def test_what_is_no_dataset_is_told(tmp_path: Path, name: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileNotFoundError, match=r"no such file|no .*scene_instance"):
        read_dataset(tmp_path / name)


def test_an_unknown_scene_lists_those_there_are(files: DatasetFiles) -> None:
    files.scene()
    with pytest.raises(KeyError, match="no scene 'flat'; it has home"):
        files.imported("flat")


def test_a_scene_is_found_by_part_of_its_path(files: DatasetFiles) -> None:
    files.scene(name="home_1")
    files.scene(name="home_0")
    dataset = files.read()
    assert dataset.find_scene("scenes/home") == "home_0"
    assert dataset.scene_handles == ("home_0", "home_1")


# Nothing is read outside the dataset.


@pytest.mark.parametrize("name", ["../out", "/etc", "C:/windows", "file:///etc", "link"])
def test_paths_that_lead_out_are_refused_by_name(files: DatasetFiles, name: str) -> None:
    outside = DatasetFiles(files.root.parent / "out")
    outside.add_object("secret", BOX)
    (files.root / "link").symlink_to(outside.root / "objects", target_is_directory=True)
    paths = {".json": ["objects", name, f"{name}/*"], ".glb": [name]}
    files.json("test.scene_dataset_config.json", {**DEFAULT_CONFIG, "objects": {"paths": paths}})
    dataset = files.read()
    assert dataset.objects.handles == ("objects/box.object_config.json",)
    assert name in dataset.report.names("skipped", "path")


@pytest.mark.parametrize("name", ["../../out.glb", "/out.glb", "link.glb", "a\0.glb"])
def test_meshes_outside_are_not_read(files: DatasetFiles, name: str) -> None:
    outside = files.mesh("../out.glb", BOX)
    (files.root / "objects/link.glb").symlink_to(outside)
    files.add_object("thief", BOX)
    files.json("objects/thief.object_config.json", {"render_asset": name})
    files.scene({"template_name": "thief"}, {"template_name": "box"})
    scene, report = files.imported()
    assert [one.object_id for one in scene.objects] == ["box_001"]
    assert report.names("skipped", "mesh") == (name,)
    assert report.names("skipped", "object") == ("thief",)


def test_a_path_may_go_up_inside_the_dataset(files: DatasetFiles) -> None:
    table = {"render_asset": "../../objects/box.glb"}
    files.json("configs/objects/far.object_config.json", table)
    config = {**DEFAULT_CONFIG, "objects": {"paths": {".json": ["configs/*"]}}}
    files.json("test.scene_dataset_config.json", config)
    files.scene({"template_name": "far"})
    assert files.imported()[1].total("found", "object") == 1


# Missing things.


def test_missing_things_are_named_with_the_file_that_asked(files: DatasetFiles) -> None:
    files.add_object("gone", BOX)
    (files.root / "objects/gone.glb").unlink()
    names = ("box", "gone", "gone", "unknown")
    files.scene(*({"template_name": name} for name in names), stage="nostage")
    scene, report = files.imported()
    missing = {(e.kind, e.name): e for e in report.entries if e.status == "missing"}
    assert missing["object", "gone"].count == 2
    assert missing["mesh", "objects/gone.glb"].asked_by == "objects/gone.object_config.json"
    assert missing["template", "unknown"].asked_by == "scenes/home.scene_instance.json"
    assert missing["stage", "nostage"].count == 1
    assert any("--shell" in note for note in report.notes)
    assert [one.object_id for one in scene.objects] == ["box_001"]
    assert len(scene.rooms) == 1


def test_a_scene_of_which_nothing_is_there_is_one_error(files: DatasetFiles) -> None:
    files.scene({"template_name": "unknown", "translation": [1, 0, 0]}, stage="nostage")
    with pytest.raises(ValueError, match=r"stage 'nostage' cannot be had, nor.*1 obj.*--shell"):
        files.imported()
    files.scene(stage="NONE")
    with pytest.raises(ValueError, match=r"nothing to draw.*no objects"):
        files.imported(shell=True)


def test_a_shell_encloses_the_objects(files: DatasetFiles) -> None:
    where = [[0, 1, 0], [6, 1, 1], [2, 1, 4]]
    files.scene(*({"template_name": "box", "translation": one} for one in where), stage="gone")
    scene, report = files.imported(shell=True)
    room = scene.rooms[0]
    low, high = np.min(room.polygon, axis=0), np.max(room.polygon, axis=0)
    assert (low < [-0.5, -2.0]).all()
    assert (low > [-0.7, -2.2]).all()
    assert (high > [6.5, 6.0]).all()
    assert room.floor_y == pytest.approx(0.0, abs=1e-6)
    assert bounds(scene, "shell/ceiling")[0, 1] == pytest.approx(room.ceiling_y)
    assert all(one.room_id == room.room_id for one in scene.objects)
    assert any("shell" in note for note in report.notes)
    for surface in scene.surfaces:
        if surface.name.startswith("shell"):
            inwards = np.array([3.0, 1.3, 2.0]) - surface.positions
            assert (np.einsum("ij,ij->i", inwards, surface.normals) > 0.0).all()
    navmesh = NavMesh.from_mesh(*scene.mesh())
    # The box is hollow: its inside is an island of its own.
    assert navmesh.island([3.0, 0.0, 4.5]) != navmesh.island([6.0, 0.0, 1.0])


def test_rugs_lie_on_the_floor_of_a_shell(files: DatasetFiles) -> None:
    files.add_object("rug_1", ((-1, -0.01, -1), (1, 0.01, 1)))
    files.scene(
        *({"template_name": "box", "translation": [x, 1.013, 0]} for x in (0, 2, 4)),
        {"template_name": "rug_1"},
        stage="gone",
    )
    scene, _ = files.imported(shell=True)
    assert scene.rooms[0].floor_y < bounds(scene, "rug")[1, 1]


def test_no_shell_where_the_stage_is_there(files: DatasetFiles) -> None:
    files.scene({"template_name": "box"})
    scene, report = files.imported(shell=True)
    assert not any(surface.name.startswith("shell") for surface in scene.surfaces)
    assert report.notes["no shell built: the stage is there"] == 1


def test_stand_ins_are_collision_meshes_then_boxes_of_nominal_size(files: DatasetFiles) -> None:
    for name in ("bike", "chair_1", "gizmo"):
        files.json(f"objects/{name}.object_config.json", {
            "render_asset": "gone.glb", "collision_asset": f"{name}_cv.glb",
        })  # fmt: skip
    files.mesh("objects/bike_cv.glb", ((0, 0, 0), (0.5, 1, 2)))
    files.scene(
        {"template_name": "bike"},
        {"template_name": "chair_1", "translation": [2, 0, 0], "non_uniform_scale": [2, 1, 1],
         "rotation": TURNED},
        {"template_name": "gizmo", "translation": [4, 0, 3]},
        stage="gone", translation_origin="asset_local",
    )  # fmt: skip
    scene, report = files.imported(shell=True)
    assert bounds(scene, "bike").tolist() == [[0, 0, 0], [0.5, 1, 2]]
    assert bounds(scene, "chair").tolist() == [[1.74, 0, -0.48], [2.26, 0.85, 0.48]]
    assert report.total("missing", "object") == 3
    assert report.total("found", "object") == 0
    assert report.notes["stand-in: a box of nominal size for a missing chair"] == 1
    assert "no size is known of missing objects: unknown category" in report.notes
    # A box is no chair: nobody can sit on it. The shell reaches to what has no size, too.
    assert scene.seats == ()
    assert np.max(scene.rooms[0].polygon, axis=0).min() > 3.0
    without, _ = files.imported(shell=True, read_mesh=_no_mesh)
    assert bounds(without, "bike").tolist() == [[-0.3, 0, -0.875], [0.3, 1.05, 0.875]]


def _no_mesh(path: Path) -> Any:
    raise ValueError(f"{path}: cannot be read here")


def test_a_layout_without_any_mesh_still_has_a_floor(files: DatasetFiles) -> None:
    places = [[0, 0, 0], [5, 0, 0], [5, 0, 4], [2, 0.8, 2]]
    files.scene(*({"template_name": "lost", "translation": p} for p in places), stage="gone")
    scene, report = files.imported(shell=True)
    assert NavMesh.from_mesh(*scene.mesh()).area_m2 > 15.0
    assert report.total("missing", "object") == 4


def test_a_mesh_that_cannot_be_read_is_skipped_once_and_named(files: DatasetFiles) -> None:
    files.add_object("bad", BOX)
    files.text("objects/bad.glb", "not a mesh")
    files.scene(*({"template_name": name} for name in ("bad", "box", "bad")))
    _, report = files.imported()
    assert report.names("skipped", "mesh") == ("objects/bad.glb",)
    assert report.total("skipped", "object") == 2
    assert report.total("found", "object") == 1


def test_invisible_things_and_primitives_are_skipped(files: DatasetFiles) -> None:
    files.json("objects/ball.object_config.json", {"render_asset": "icosphereSolid_subdivs_1"})
    hidden = {"template_name": "box", "is_instance_visible": False}
    files.scene(hidden, {"template_name": "ball"})
    _, report = files.imported()
    reasons = {entry.name: entry.reason for entry in report.entries if entry.status == "skipped"}
    assert reasons["box"] == "not visible"
    assert "primitive" in reasons["ball"]


def test_instances_beyond_the_triangle_budget_are_skipped(
    files: DatasetFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("affectsim_data.builders.habitat.things.MAX_TRIANGLES", 36)
    files.scene(*({"template_name": "box"} for _ in range(5)))
    scene, report = files.imported()
    assert scene.num_triangles == 36
    assert report.total("skipped", "object") == 3


# Semantics.


def seated(files: DatasetFiles, name: str, boxes: Any, **instance: object) -> Scene:
    """A scene with one piece of furniture."""
    files.add_object(name, *boxes)
    files.scene({"template_name": name, "translation_origin": "asset_local", **instance})
    return files.imported()[0]


def test_a_chair_has_one_seat_that_looks_away_from_its_back(files: DatasetFiles) -> None:
    scene = seated(files, "dining_chair_3", CHAIR, translation=[1, 0, 0])
    (seat,) = scene.seats
    assert abs(seat.yaw_deg) == pytest.approx(180.0)
    assert seat.height == pytest.approx(0.45, abs=0.01)
    assert seat.position == pytest.approx((1.0, 0.45, -0.05), abs=0.02)
    assert scene.objects[0].category == "chair"
    assert scene.objects[0].size == pytest.approx((0.4, 0.9, 0.45), abs=1e-4)


def test_seats_turn_with_their_furniture(files: DatasetFiles) -> None:
    scene = seated(files, "chair", CHAIR, rotation=TURNED)
    # The front, -Z, goes to -X: a yaw of -90 degrees.
    assert scene.seats[0].yaw_deg == pytest.approx(-90.0)
    assert scene.seats[0].position == pytest.approx((-0.05, 0.45, 0.0), abs=0.02)
    assert scene.objects[0].yaw_deg == pytest.approx(-90.0)


def test_the_back_tells_which_way_a_chair_looks_not_its_template(files: DatasetFiles) -> None:
    swapped = [((-b[2], a[1], a[0]), (-a[2], b[1], b[0])) for a, b in CHAIR]
    scene = seated(files, "chair", swapped)
    # Its back is at -X now.
    assert scene.seats[0].yaw_deg == pytest.approx(90.0)


def test_a_sofa_has_places_side_by_side_on_its_cushions(files: DatasetFiles) -> None:
    scene = seated(files, "couch_1", SOFA)
    assert [seat.height for seat in scene.seats] == pytest.approx([0.42, 0.42], abs=0.01)
    xs = sorted(seat.position[0] for seat in scene.seats)
    assert xs == pytest.approx([-0.4, 0.4], abs=0.05)
    assert scene.objects[0].category == "sofa"


def test_one_sits_on_either_side_of_a_bed(files: DatasetFiles) -> None:
    scene = seated(files, "bed_2", BED)
    assert sorted(seat.yaw_deg for seat in scene.seats) == pytest.approx([-90.0, 90.0])
    assert {round(seat.position[0], 1) for seat in scene.seats} == {-0.6, 0.6}


@pytest.mark.parametrize(
    ("name", "instance"),
    [
        ("table", {}),
        ("chair", {"rotation": [HALF, HALF, 0.0, 0.0], "translation": [0, 0.3, 0]}),
        ("chair", {"translation": [0, 1.0, 0]}),
        ("chair", {"uniform_scale": 0.3}),
    ],
)
def test_nobody_sits_on_tables_or_on_chairs_that_lie_or_hang(
    files: DatasetFiles, name: str, instance: dict[str, Any]
) -> None:
    assert seated(files, name, CHAIR, **instance).seats == ()


def test_categories_come_from_the_lexicon_of_the_scene(files: DatasetFiles) -> None:
    classes = {"classes": [{"id": 7, "name": "indoor_plant"}, {"id": 9, "name": "wardrobe"}]}
    files.json("semantics/words_semantic_lexicon.json", classes)
    config = dict(DEFAULT_CONFIG)
    config["semantic_scene_descriptor_instances"] = {
        "words": "semantics/words_semantic_lexicon.json"
    }
    files.json("test.scene_dataset_config.json", config)
    files.add_object("chair_a", BOX, semantic_id=7)
    files.add_object("thing", BOX, semantic_id=3)
    files.scene(*({"template_name": name} for name in ("chair_a", "thing")))
    scene, _ = files.imported()
    assert [one.category for one in scene.objects] == ["plant", ""]
    other = files.json("other.json", {"classes": [{"id": 3, "name": "Floor Lamp"}]})
    scene, _ = files.imported(lexicon=other)
    assert [one.category for one in scene.objects] == ["chair", "lamp"]


def test_categories_come_from_tables_of_models(files: DatasetFiles) -> None:
    files.text("metadata/objects.csv", "id,main_category\nbox,couch\n")
    files.scene({"template_name": "box"})
    assert files.imported()[0].objects[0].category == "sofa"


def test_a_lexicon_that_is_named_but_missing_is_said(files: DatasetFiles) -> None:
    config = dict(DEFAULT_CONFIG)
    config["semantic_scene_descriptor_instances"] = {"hssd_ssd_map": "semantics/none.json"}
    files.json("test.scene_dataset_config.json", config)
    files.add_object("0f5a", BOX, semantic_id=94)
    files.scene({"template_name": "0f5a"}, semantic_scene_instance="hssd_ssd_map")
    scene, report = files.imported()
    assert report.names("missing", "semantic descriptor") == ("hssd_ssd_map",)
    assert scene.objects[0].category == "sofa"


def region(**changes: object) -> dict[str, object]:
    """A region of two by two metres."""
    loop = [[0, 0.2, 0], [2, 0.2, 0], [2, 0.2, 2], [0, 0.2, 2]]
    return {
        "name": "r1", "label": "bathroom", "poly_loop": loop, "floor_height": 0.2,
        "extrusion_height": 2.4, **changes,
    }  # fmt: skip


def test_rooms_come_from_regions(files: DatasetFiles) -> None:
    broken = region(name="r2", poly_loop=[[0, 0, 0]])
    table = {"region_annotations": [region(), broken, region(label="office")]}
    files.json("semantics/home.semantic_config.json", table)
    config = {**DEFAULT_CONFIG, "semantic_scene_descriptor_instances": {
        "paths": {".json": ["semantics"]}}}  # fmt: skip
    config["scene_instances"] = {
        "paths": {".json": ["scenes"]},
        "default_attributes": {
            "semantic_scene_instance": "%%CONFIG_NAME_AS_ASSET_FILENAME%%.semantic_config.json"
        },
    }
    files.json("test.scene_dataset_config.json", config)
    files.scene({"template_name": "box", "translation": [1, 1, 1]})
    scene, report = files.imported()
    (room,) = scene.rooms
    assert (room.room_id, room.purpose, room.floor_y) == ("r1", "bath", 0.2)
    assert room.ceiling_y == pytest.approx(2.6)
    assert room.polygon[2] == (2.0, 2.0)
    assert scene.objects[0].room_id == "r1"
    reasons = [entry.reason for entry in report.entries if entry.kind == "region"]
    assert any("three or more points" in reason for reason in reasons)
    assert any("a second 'r1'" in reason for reason in reasons)


def test_a_stage_without_regions_has_a_room_per_floor(files: DatasetFiles) -> None:
    roof = ((0, 3, 0), (7, 3.1, 3))
    files.stage("two", ((0, -0.1, 0), (4, 0, 3)), ((5, -0.1, 0), (7, 0, 3)), roof)
    files.scene({"template_name": "box", "translation": [6, 1, 1]}, stage="two")
    scene, _ = files.imported()
    areas = [np.ptp(room.polygon, axis=0).prod() for room in scene.rooms]
    assert areas == pytest.approx([12.0, 6.0])
    assert [room.floor_y for room in scene.rooms] == pytest.approx([0.0, 0.0])
    assert scene.objects[0].room_id == scene.rooms[1].room_id
