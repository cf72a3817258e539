"""Releases of scenes alone: built from a user's own files, reported, described, and refused."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow.parquet as pq
import pytest
from habitat_files import DatasetFiles
from small_release import box_room

from affectsim_data import AffectSimDataset, open_release
from affectsim_data.builders.building import build_release
from affectsim_data.cli import main

TABLE = ((-0.5, 0.0, -0.4), (0.5, 0.75, 0.4))


def table_at(x: float, z: float) -> dict[str, object]:
    return {
        "template_name": "table",
        "translation": [x, 0.0, z],
        "translation_origin": "asset_local",
    }


@pytest.fixture
def habitat(tmp_path: Path) -> Path:
    """A dataset of two scenes with tables; the stage of the second is missing."""
    files = DatasetFiles(tmp_path / "data")
    files.stage()
    files.add_object("table", TABLE)
    files.scene(table_at(-2.0, 0.0), table_at(2.0, 1.0))
    whole = files.root / "scenes"
    first = next(iter(sorted(whole.glob("*.scene_instance.json"))))
    document = json.loads(first.read_text())
    document["stage_instance"] = {"template_name": "attic"}
    first.with_name("bare.scene_instance.json").write_text(json.dumps(document))
    return files.root


def build(source: Path, out: Path, *options: str) -> int:
    return main(["build", "habitat", "--source", str(source), "--out", str(out), *options])


def test_a_scene_without_its_stage_stops_the_build_and_says_how_to_go_on(
    tmp_path: Path, habitat: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert build(habitat, tmp_path / "out") == 1
    error = capsys.readouterr().err
    assert "stage missing for 1 of 2 scenes: bare" in error
    assert "--shell builds floor and walls" in error
    assert "--skip-broken" in error
    assert not (tmp_path / "out").exists()


def test_what_is_broken_is_left_out_on_request(
    tmp_path: Path, habitat: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert build(habitat, tmp_path / "out", "--skip-broken") == 0
    assert "scene left out: habitat/bare: " in capsys.readouterr().out
    assert open_release(tmp_path / "out").asset_ids("scenes") == ["habitat/home"]


def test_a_shell_makes_it_a_place_and_everything_missing_is_told(
    tmp_path: Path, habitat: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, table = tmp_path / "out", tmp_path / "scenes.parquet"
    assert build(habitat, out, "--shell", "--scene-report", str(table)) == 0
    assert "missing in 1 scenes: template attic" in capsys.readouterr().out
    rows = pq.read_table(table).to_pylist()
    missing = {(row["scene_id"], row["name"]) for row in rows if row["status"] == "missing"}
    assert ("habitat/bare", "attic") in missing
    assert {row["scene_id"] for row in rows if row["status"] == "after"} == {
        "habitat/bare",
        "habitat/home",
    }
    release = open_release(out)
    assert not release.manifest.redistribution
    for scene_id in release.asset_ids("scenes"):
        scene, navmesh = release.scene(scene_id), release.navmesh(scene_id)
        assert scene.chunks is not None
        assert len(scene.surfaces) <= 32
        assert [thing.category for thing in scene.objects] == ["table", "table"]
        assert navmesh.mesh_sha256 == scene.mesh_sha256()
        assert not navmesh.is_navigable(scene.objects[0].position)
    assert main(["info", str(out)]) == 0
    assert "no episodes; --scenes describes" in capsys.readouterr().out
    assert "release.scene(" in (out / "README.md").read_text()
    with pytest.raises(ValueError, match="split 'test' is empty"):
        AffectSimDataset(out, split="test", condition="p_ref")


def test_scenes_are_the_same_bytes_on_any_number_of_processes(
    tmp_path: Path, habitat: Path
) -> None:
    for jobs in (1, 2):
        build_release("habitat", tmp_path / str(jobs), source=habitat, jobs=jobs, shell=True)
    one, two = (sorted((tmp_path / name / "scenes").iterdir()) for name in "12")
    assert [path.read_bytes() for path in one] == [path.read_bytes() for path in two]


def test_places_are_the_mesh_files_of_a_folder(tmp_path: Path) -> None:
    (tmp_path / "own" / "flats").mkdir(parents=True)
    (tmp_path / "own" / "flats" / "one.glb").write_bytes(box_room("any").to_glb())
    (tmp_path / "own" / "readme.txt").write_text("not a mesh")
    build_release("places", tmp_path / "out", source=tmp_path / "own", jobs=1)
    release = open_release(tmp_path / "out")
    assert release.asset_ids("scenes") == ["places/flats/one"]
    assert release.navmesh("places/flats/one").area_m2 == pytest.approx(7.4**2, rel=0.05)


def test_sources_that_do_not_fit_are_refused(tmp_path: Path, habitat: Path) -> None:
    with pytest.raises(ValueError, match=r"'hssd' reads scenes: add --source FOLDER.*hssd-hab"):
        build_release("hssd", tmp_path / "out")
    with pytest.raises(FileNotFoundError, match="no such folder"):
        build_release("places", tmp_path / "out", source=tmp_path / "nothing")
    (tmp_path / "empty").mkdir()
    with pytest.raises(FileNotFoundError, match=r"no scene matches include.*there are 0: none"):
        build_release("places", tmp_path / "out", source=tmp_path / "empty")
    with pytest.raises(ValueError, match="--shell is for scenes of Habitat datasets"):
        build_release("homes", tmp_path / "out", shell=True)
    assert not (tmp_path / "out").exists()
