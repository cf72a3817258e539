"""Broken, hostile and odd Habitat datasets end in one clear error, or in a counted note."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from habitat_files import DEFAULT_CONFIG, DatasetFiles, bounds

from affectsim_data.builders.imports import ImportReport

BOX = ((0.0, 0.0, 0.0), (1.0, 2.0, 4.0))
CONFIG = "test.scene_dataset_config.json"
SCENE = "scenes/home.scene_instance.json"


@pytest.fixture
def files(tmp_path: Path) -> DatasetFiles:
    """A dataset with a floor, a box and a scene with both."""
    files = DatasetFiles(tmp_path / "data")
    files.stage()
    files.add_object("box", BOX)
    files.scene({"template_name": "box"})
    return files


def reasons(report: ImportReport, status: str = "skipped") -> list[str]:
    """Why things came to this."""
    return [entry.reason for entry in report.entries if entry.status == status]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no valid JSON"),
        ("{", "no valid JSON"),
        ("[1]", "must be a JSON object, got"),
        ('{"a": NaN}', "no valid JSON: NaN is no number"),
        ('{"a": -Infinity}', "no valid JSON: -Infinity is no number"),
        ("[" * 200_000, "nested too deeply"),
        ('{"a": ' + "9" * 5000 + "}", "no valid JSON"),
    ],
)
def test_broken_files_are_named(files: DatasetFiles, text: str, message: str) -> None:
    files.text(SCENE, text)
    with pytest.raises(ValueError, match=rf"^{SCENE}.*{message}"):
        files.imported()
    files.text(CONFIG, text)
    with pytest.raises(ValueError, match=rf"test\.scene_dataset_config\.json.*{message}"):
        files.read()


def test_files_that_are_too_large_are_not_read(
    files: DatasetFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("affectsim_data.builders.habitat.files.MAX_JSON_BYTES", 1000)
    files.text(SCENE, "{" + " " * 2000 + "}")
    with pytest.raises(ValueError, match="2002 bytes, more than the 1000 allowed"):
        files.imported()


def test_scenes_with_too_many_instances_are_refused(
    files: DatasetFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("affectsim_data.builders.habitat.instances.MAX_INSTANCES", 3)
    files.scene(*({"template_name": "box"} for _ in range(4)))
    with pytest.raises(ValueError, match="4 instances, more than the 3 allowed"):
        files.imported()


def test_folders_with_too_many_files_are_refused(
    files: DatasetFiles, monkeypatch: pytest.MonkeyPatch
) -> None:
    (files.root / CONFIG).unlink()
    monkeypatch.setattr("affectsim_data.builders.habitat.files.MAX_FILES", 2)
    with pytest.raises(ValueError, match="more than 2 files"):
        files.read()


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"stages": []}, "stages must be a JSON object"),
        ({"objects": {"paths": {".json": "objects"}}}, "json must be a list"),
        ({"objects": {"paths": {".json": [1]}}}, "json must be a list of texts"),
        ({"objects": {"configs": {}}}, "configs must be a list"),
        ({"semantic_scene_descriptor_instances": {"a": 1}}, "a must be the path of a file"),
    ],
)
def test_configs_of_the_wrong_form_are_told(
    files: DatasetFiles, config: dict[str, Any], message: str
) -> None:
    files.json(CONFIG, {**DEFAULT_CONFIG, **config})
    with pytest.raises(ValueError, match=rf"^{CONFIG}.*{message}"):
        files.read()


def test_entries_of_configs_that_name_nothing_are_skipped(files: DatasetFiles) -> None:
    rows = [
        {"attributes": {}},
        {"original_file": "none.json", "template_handle": "a"},
        {"template_handle": "b", "attributes": 3},
        4,
    ]
    objects = {"paths": {".json": ["objects", "nothing/*"]}, "configs": rows}
    files.json(CONFIG, {**DEFAULT_CONFIG, "objects": objects})
    report = files.read().report
    assert report.total("skipped", "template") == 4
    assert "nothing/*" in report.names("missing", "path")
    assert any("original_file 'none.json' is no known template" in why for why in reasons(report))


@pytest.mark.parametrize(
    ("instance", "message"),
    [
        ({"template_name": 3}, "template_name must be a text, got 3"),
        ({"template_name": ""}, "needs a template_name"),
        ({"translation": [0, 0]}, "translation must be a list of 3 finite numbers, got [0, 0]"),
        ({"translation": [0, 0, "1"]}, "translation must be a list of 3 finite numbers"),
        ({"translation": [0, 0, True]}, "translation must be a list of 3 finite numbers"),
        ({"translation": [0, 0, 10**400]}, "translation must be a list of 3 finite numbers"),
        ({"translation": [0, 0, 1e30]}, "translation must be within 100000 m of the origin"),
        ({"rotation": [0, 0, 0, 0]}, "rotation must be a quaternion wxyz of length 1"),
        ({"rotation": {"w": 1}}, "rotation must be a list of 4 finite numbers"),
        ({"uniform_scale": 0}, "scale must not be zero"),
        ({"non_uniform_scale": [1, 1e9, 1]}, "scale must not be zero nor above 10000"),
        ({"is_instance_visible": "no"}, "is_instance_visible must be true or false"),
        ("box", "must be a JSON object, got 'box'"),
    ],
)
def test_broken_instances_are_skipped_with_place_and_field(
    files: DatasetFiles, instance: Any, message: str
) -> None:
    good: dict[str, Any] = {"template_name": "box"}
    broken = {**good, **instance} if isinstance(instance, dict) else instance
    files.scene(good, broken)
    scene, report = files.imported()
    assert len(scene.objects) == 1
    (reason,) = reasons(report)
    assert reason.startswith(f"{SCENE}: object_instances[1]")
    assert message in reason


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ({"up": [0, 1, 0], "front": [0, 1, 0]}, "must be at right angles; give both"),
        ({"up": [0, 0, 0]}, "up and front must not be zero"),
        ({"scale": [1, 0, 1]}, "scale times units_to_meters must not be zero"),
        ({"units_to_meters": "cm"}, "units_to_meters must be a finite number, got 'cm'"),
        ({"render_asset": 5}, "render_asset must be a text"),
        ({"COM": [0]}, "COM must be a list of 3 finite numbers"),
        ({"semantic_id": 1.5}, "semantic_id must be a whole number"),
    ],
)
def test_broken_templates_are_told_with_file_and_field(
    files: DatasetFiles, attributes: dict[str, Any], message: str
) -> None:
    files.add_object("bad", BOX, **attributes)
    files.scene({"template_name": "bad"}, {"template_name": "box"})
    scene, report = files.imported()
    assert [one.object_id for one in scene.objects] == ["box_001"]
    (reason,) = reasons(report)
    assert reason.startswith("objects/bad.object_config.json")
    assert message in reason


def test_scene_fields_of_the_wrong_type_are_one_error(files: DatasetFiles) -> None:
    files.scene(object_instances={})
    with pytest.raises(ValueError, match=rf"^{SCENE}: object_instances must be a list"):
        files.imported()
    files.scene(default_lighting=3)
    with pytest.raises(ValueError, match=rf"^{SCENE}: default_lighting must be a text"):
        files.imported()


def test_joint_positions_of_the_wrong_type_are_told(files: DatasetFiles) -> None:
    rows = [{"template_name": "a", "initial_joint_pose": pose} for pose in ("x", {"j": None})]
    files.scene({"template_name": "box"}, articulated_object_instances=rows)
    why = " ".join(reasons(files.imported()[1]))
    assert "initial_joint_pose must be a list or a table of numbers" in why
    assert "j must be a finite number" in why


def test_broken_lexicons_and_regions_are_skipped_and_said(files: DatasetFiles) -> None:
    files.json("semantics/w.json", {"classes": [{"name": "chair"}]})
    files.text("semantics/home.semantic_config.json", "{")
    table = {"words": "semantics/w.json", "home": "semantics/home.semantic_config.json"}
    files.json(CONFIG, {**DEFAULT_CONFIG, "semantic_scene_descriptor_instances": table})
    scene, report = files.imported()
    assert scene.rooms[0].room_id == "room-0"
    why = " ".join(reasons(report))
    assert "classes[0] needs an id and a name" in why
    assert "semantics/home.semantic_config.json: no valid JSON" in why


def test_descriptors_of_scans_are_ignored(files: DatasetFiles) -> None:
    files.text("semantics/scan.house", "ASCII 1.1")
    table = {"scan": "semantics/scan.house"}
    files.json(CONFIG, {**DEFAULT_CONFIG, "semantic_scene_descriptor_instances": table})
    assert files.imported()[1].names("ignored", "semantic descriptor") == ("scan",)


def test_lights_and_navmeshes_are_ignored_with_a_count(files: DatasetFiles) -> None:
    files.json("lights/a.lighting_config.json", {"lights": {}})
    config = {
        **DEFAULT_CONFIG,
        "light_setups": {"paths": {".json": ["lights"]}},
        "navmesh_instances": {"a": "a.navmesh", "b": "b.navmesh"},
    }
    files.json(CONFIG, config)
    files.scene(default_lighting="lights/a", navmesh_instance="a")
    dataset = files.read()
    assert dataset.report.total("ignored", "light setups") == 1
    assert dataset.report.total("ignored", "navmeshes") == 2
    _, report = files.imported()
    assert report.names("ignored") == ("lights/a", "a")


@pytest.mark.parametrize(
    ("text", "spdx"),
    [
        ("CC BY-NC 4.0 License (https://creativecommons.org)", "CC-BY-NC-4.0"),
        ("Creative Commons Attribution-NonCommercial 4.0 International", "CC-BY-NC-4.0"),
        ("Attribution-NonCommercial-ShareAlike 4.0 International", "CC-BY-NC-SA-4.0"),
        ("Attribution 4.0 International", "CC-BY-4.0"),
        ("MIT License\n\nCopyright", "MIT"),
        ("Apache License\n   Version 2.0, January 2004", "Apache-2.0"),
        ("ask me", "LicenseRef-LICENSE.txt"),
    ],
)
def test_the_licence_is_that_of_the_file(files: DatasetFiles, text: str, spdx: str) -> None:
    files.text("LICENSE.txt", text)
    scene, report = files.imported()
    assert scene.licence == spdx
    assert not any("licence" in note for note in report.notes)
    assert files.imported(licence="CC0-1.0")[0].licence == "CC0-1.0"


def test_no_licence_is_said(files: DatasetFiles) -> None:
    scene, report = files.imported()
    assert scene.licence == ""
    assert any("no licence" in note for note in report.notes)


def test_templates_without_a_mesh_far_away_or_flat_do_no_harm(files: DatasetFiles) -> None:
    files.add_object("sheet", ((0, 0, 0), (1, 1, 0)))
    files.scene({"template_name": "sheet"}, {"template_name": "box", "translation": [0, -50, 0]},
                {"template_name": "box"}, {"template_name": "box"}, stage="gone")  # fmt: skip
    scene, report = files.imported(shell=True)
    assert bounds(scene, "shell")[0, 1] > -2.0
    assert report.notes["objects far above or below the floor: the shell is not for them"] == 1
    files.scene({"template_name": "box"}, {"template_name": "box", "translation": [500, 0, 0]},
                stage="gone")  # fmt: skip
    with pytest.raises(ValueError, match="objects stand 501 m apart"):
        files.imported(shell=True)
