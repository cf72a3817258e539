"""Articulated objects of Habitat datasets stand with their joints where the scene holds them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from habitat_files import DatasetFiles, bounds

from affectsim_data.builders.habitat.urdf import read_urdf

BOX = ((0.0, 0.0, 0.0), (1.0, 2.0, 4.0))
CUPBOARD = """<?xml version="1.0"?>
<robot name="cupboard">
  <link name="root"><visual><geometry><box size="1 2 1"/></geometry></visual></link>
  <joint name="rail" type="prismatic">
    <origin xyz="0 1 0"/><parent link="root"/><child link="drawer"/><axis xyz="0 0 2"/>
  </joint>
  <link name="drawer">
    <visual><origin xyz="0 0 1"/><geometry><box size="0.5 0.5 0.5"/></geometry></visual>
    <visual><geometry><sphere radius="0.1"/></geometry></visual>
    <collision><geometry><box size="9 9 9"/></geometry></collision>
  </link>
  <joint name="hinge" type="revolute">
    <origin xyz="0.5 0 0" rpy="0 0 1.5707963267948966"/>
    <parent link="root"/><child link="door"/><axis xyz="1 0 0"/>
  </joint>
  <link name="door">
    <visual><geometry><mesh filename="door.glb" scale="1 0.5 1"/></geometry></visual>
  </link>
</robot>
"""


@pytest.fixture
def files(tmp_path: Path) -> DatasetFiles:
    """A dataset with a floor and a cupboard."""
    files = DatasetFiles(tmp_path / "data")
    files.stage()
    files.text("urdf/cupboard.urdf", CUPBOARD)
    files.mesh("urdf/door.glb", BOX)
    return files


def test_joints_at_zero_and_at_given_positions(files: DatasetFiles) -> None:
    one = {"template_name": "cupboard", "translation": [10, 0, 0], "translation_origin": "COM"}
    by_name = {"hinge": np.pi / 2, "rail": 0.25, "unknown": 3.0}
    files.scene(
        articulated_object_instances=[
            one, {**one, "initial_joint_pose": [0.25, 0]}, {**one, "initial_joint_pose": by_name},
        ]
    )  # fmt: skip
    scene, report = files.imported()
    assert report.total("found", "articulated object") == 3
    closed, listed, named = (bounds(scene, f"cupboard_00{k}/1") for k in (1, 2, 3))
    # The drawer's middle is at (10, 1, 1); its rail runs along Z, whatever the length of its axis.
    assert closed.tolist() == [[9.75, 0.75, 0.75], [10.25, 1.25, 1.25]]
    assert (listed - closed).tolist() == [[0, 0, 0.25]] * 2
    assert named.tolist() == listed.tolist()
    # The door: 1 x 1 x 4 by its own scale, turned so that its +X is up, at (10.5, 0, 0).
    assert bounds(scene, "cupboard_001/3").tolist() == [[9.5, 0, 0], [10.5, 1, 4]]
    # A quarter turn about that upright axis takes +Z to +X.
    assert bounds(scene, "cupboard_003/3").tolist() == [[10.5, 0, 0], [14.5, 1, 1]]


def test_scale_and_rotation_of_the_whole(files: DatasetFiles) -> None:
    turned = {"template_name": "cupboard", "rotation": [0, 0, 1, 0], "uniform_scale": 0.5}
    files.json(
        "urdf/cupboard.ao_config.json", {"uniform_scale": 4.0, "urdf_filepath": "cupboard.urdf"}
    )
    files.scene(articulated_object_instances=[turned])
    scene, _ = files.imported()
    # Twice the size and half round: the drawer's middle goes to (0, 2, -2).
    assert bounds(scene, "cupboard_001/1").tolist() == [[-0.5, 1.5, -2.5], [0.5, 2.5, -1.5]]


def test_a_link_without_its_mesh_is_named_and_the_rest_stands(files: DatasetFiles) -> None:
    (files.root / "urdf/door.glb").unlink()
    files.scene(articulated_object_instances=[{"template_name": "cupboard"}])
    scene, report = files.imported()
    assert len([one for one in scene.surfaces if one.name.startswith("cupboard")]) == 3
    assert report.names("missing", "link") == ("urdf/cupboard.urdf: door",)
    entry = next(e for e in report.entries if e.kind == "mesh" and e.status == "missing")
    assert (entry.name, entry.asked_by) == ("urdf/door.glb", "urdf/cupboard.urdf")


def test_articulated_objects_may_be_missing_or_hidden(files: DatasetFiles) -> None:
    files.json("urdf/gone.ao_config.json", {"urdf_filepath": "gone.urdf"})
    files.text("urdf/gone.urdf", CUPBOARD)
    files.json("urdf/hidden.ao_config.json", {"render_mode": "none"})
    files.text("urdf/hidden.urdf", CUPBOARD)
    dataset = files.read()
    (files.root / "urdf/gone.urdf").unlink()
    assert len(dataset.articulated) == 3
    files.json("urdf/gone.ao_config.json", {"urdf_filepath": "away.urdf"})
    files.text("urdf/gone.urdf", CUPBOARD)
    names = [{"template_name": name} for name in ("gone", "hidden", "unknown")]
    files.scene(articulated_object_instances=names)
    _, report = files.imported()
    assert report.names("missing", "urdf") == ("urdf/away.urdf",)
    assert set(report.names("missing", "articulated object")) == {"gone", "unknown"}
    assert report.names("skipped", "articulated object") == ("hidden",)


@pytest.mark.parametrize("name", ["../../out.urdf", "/etc/out.urdf"])
def test_urdfs_and_their_meshes_outside_are_not_read(files: DatasetFiles, name: str) -> None:
    files.text("../out.urdf", CUPBOARD)
    files.mesh("../out.glb", BOX)
    files.json("urdf/thief.ao_config.json", {"urdf_filepath": name})
    files.text("urdf/thief.urdf", CUPBOARD)
    files.text("urdf/fence.urdf", CUPBOARD.replace("door.glb", "../../out.glb"))
    names = [{"template_name": name} for name in ("thief", "fence")]
    files.scene(articulated_object_instances=names)
    _, report = files.imported()
    assert report.names("skipped", "articulated object") == ("thief",)
    assert report.names("skipped", "mesh") == ("../../out.glb",)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<robot", "no valid XML"),
        ("<model/>", "its root must be <robot>, got <model>"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><robot>&b;</robot>", "declares XML entities"),
        (CUPBOARD.replace('xyz="0 1 0"', 'xyz="0 nan 0"'), "xyz must be 3 finite numbers"),
        (CUPBOARD.replace('radius="0.1"', 'radius="-1"'), "radius must be above 0"),
        (CUPBOARD.replace('xyz="0 0 2"', 'xyz="0 0 0"'), "'rail' has an axis of length 0"),
        (CUPBOARD.replace('<child link="door"/>', '<child link="dor"/>'), "names link 'dor'"),
        (CUPBOARD.replace('<child link="door"/>', '<child link="drawer"/>'), "has two parents"),
        (CUPBOARD.replace('<parent link="root"/>', '<parent link="door"/>'), "hang on no root"),
        (CUPBOARD.replace("<sphere", "<torus"), "shape <torus>"),
        (CUPBOARD.replace('<link name="door">', "<link>"), "<link> needs name"),
        (CUPBOARD.replace('<child link="door"/>', ""), "'hinge' needs a parent and a child"),
        (CUPBOARD.replace('<sphere radius="0.1"/>', ""), "needs one geometry, got 0"),
        (CUPBOARD + " " * 5 * 2**20, "more than the 4194304 allowed"),
        ("<robot>" + "<a/>" * 100_001 + "</robot>", "more than 100000 elements"),
    ],
)
def test_broken_urdfs_are_told(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=rf"^a\.urdf: .*{message}"):
        read_urdf(path, where="a.urdf")


def test_a_broken_urdf_is_skipped_with_its_reason(files: DatasetFiles) -> None:
    files.text("urdf/cupboard.urdf", "<robot")
    files.scene(articulated_object_instances=[{"template_name": "cupboard"}])
    _, report = files.imported()
    (entry,) = [e for e in report.entries if e.status == "skipped"]
    assert entry.reason.startswith("urdf/cupboard.urdf: no valid XML")
