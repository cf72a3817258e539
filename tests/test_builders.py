"""Recipes, corpora and composing: what is refused, what is reported, what real clips become."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import numpy as np
import pytest
from small_release import box_room

from affectsim_data import AffectSimDataset, open_release
from affectsim_data.affordances import rooms_of
from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.building import build_release
from affectsim_data.builders.casting import Cast, make_cast
from affectsim_data.builders.composer import SceneEpisodes, SceneWork, compose_scene
from affectsim_data.builders.monitors import plan_monitor
from affectsim_data.builders.placement import Stage
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.scene_sources import (
    BuiltScene,
    build_scene,
    scene_navmesh,
    scene_sources,
)
from affectsim_data.builders.slots import Slot, make_slots
from affectsim_data.content import content_path
from affectsim_data.episodes import Robot
from affectsim_data.releases.rows import scene_row
from affectsim_data.scenes import Surface
from affectsim_data.visibility import scene_caster


def changed_recipe(tmp_path: Path, old: str, new: str, *, recipe: str = "mini") -> Path:
    text = content_path("builders", f"{recipe}.toml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "changed.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def test_unknown_recipe_lists_the_known_ones() -> None:
    with pytest.raises(
        FileNotFoundError, match=r"no recipe 'maxi'.*bandai_namco, full, habitat, homes, .*mini"
    ):
        read_recipe("maxi")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[camera]", "[kamera]", r"changed\.toml: unknown entries: kamera"),
        ('family = "dyadic"', 'family = "crowd"', r"family must be one of .*got 'crowd'"),
        ("far_visible", "very_far", r"challenge must be one of .*got 'very_far'"),
        (
            'placement = "seat"',
            'placement = "bed"',
            r"floor, seat, before_seat, door, pair, got 'bed'",
        ),
        ("seed = 20260826", "seed = = 3", r"changed\.toml: not TOML"),
        ("seed = 20260826", "", r"changed\.toml: 'seed' is missing"),
        ("hfov_deg = 60.0", "hfov_deg = 190.0", r"hfov must be between 0 and 180 degrees, got 190"),
    ],
)
def test_broken_recipes_are_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read_recipe(changed_recipe(tmp_path, old, new))


@pytest.fixture(scope="module")
def mini_cast() -> Cast:
    recipe = read_recipe("mini")
    return make_cast(recipe, load_avatars(recipe))


def test_recipe_without_motions_of_an_action_is_refused(tmp_path: Path, mini_cast: Cast) -> None:
    path = changed_recipe(tmp_path, 'actions = ["scenario"]', 'actions = ["juggle"]')
    recipe = read_recipe(path)
    with pytest.raises(ValueError, match=r"wants action 'juggle'.*there is: being_seated"):
        make_slots(recipe, mini_cast.performances)


def test_performer_without_a_split_is_named(tmp_path: Path, mini_cast: Cast) -> None:
    recipe = read_recipe(changed_recipe(tmp_path, 'test = ["p4"]', "test = []"))
    with pytest.raises(ValueError, match=r"names no split for performer 'p4'"):
        make_slots(recipe, mini_cast.performances)


def test_failed_build_leaves_nothing_behind(tmp_path: Path) -> None:
    path = changed_recipe(tmp_path, 'actions = ["scenario"]', 'actions = ["juggle"]')
    with pytest.raises(ValueError, match="juggle"):
        build_release(path, tmp_path / "out", jobs=1)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["changed.toml"]


def test_scene_without_floor_is_refused_by_name() -> None:
    room = box_room("gallery")
    walls = tuple(surface for surface in room.surfaces if "floor" not in surface.name)
    standing = tuple(_upright(surface) for surface in walls)
    with pytest.raises(ValueError, match=r"scene 'gallery': .*walkable"):
        scene_navmesh(dataclasses.replace(room, surfaces=standing), Robot())


def _upright(surface: Surface) -> Surface:
    """Only the faces of a surface that nobody can stand on."""
    corners = surface.positions[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    steep = np.abs(normal[:, 1]) < 0.5 * np.linalg.norm(normal, axis=1)
    return dataclasses.replace(surface, faces=surface.faces[steep])


@pytest.fixture(scope="module")
def built() -> BuiltScene:
    recipe = read_recipe("mini")
    result = build_scene(scene_sources(recipe, None)[0], recipe, None)
    assert isinstance(result, BuiltScene)
    return result


@pytest.fixture(scope="module")
def stage(built: BuiltScene) -> Stage:
    return Stage.prepare(built.scene, built.navmesh, read_recipe("mini"))


def composed(slot: Slot, built: BuiltScene, cast: Cast, recipe: Recipe) -> SceneEpisodes:
    performances = {one.motion.motion_id: one for one in cast.performances}
    row = scene_row(built.scene, built.navmesh)
    work = SceneWork(row["scene_id"], "train", row["glb"], row["navmesh"], (slot,))
    return compose_scene(work, performances, recipe)


def test_monitors_hang_in_their_room_and_see_its_floor(stage: Stage) -> None:
    for room in stage.scene.rooms:
        monitor = stage.monitors[room.room_id]
        assert stage.scene.rooms[rooms_of(stage.scene, monitor.position)] == room
        assert 1.8 < monitor.position[1] < room.ceiling_y
        assert monitor.pitch < 0.0
        assert monitor.floor_share > 0.25
        again = plan_monitor(room, read_recipe("mini").camera, scene_caster(stage.scene))
        assert again == monitor


def test_slots_share_their_placement_and_depend_on_the_seed(
    built: BuiltScene, mini_cast: Cast
) -> None:
    recipe = read_recipe("mini")
    slot = next(s for s in make_slots(recipe, mini_cast.performances) if s.challenge == "rear_view")
    first = composed(slot, built, mini_cast, recipe).episodes
    assert len({episode.emotion for episode in first}) == 5
    assert len({(e.target.anchor, e.start_position, e.start_yaw) for e in first}) == 1
    assert {episode.placement_id for episode in first} == {slot.key}
    assert len({episode.phase_s for episode in first}) == 5
    again = composed(slot, built, mini_cast, recipe).episodes
    assert [episode.to_row() for episode in again] == [episode.to_row() for episode in first]
    other = composed(slot, built, mini_cast, dataclasses.replace(recipe, seed=1)).episodes
    assert other[0].start_position != first[0].start_position


def test_impossible_challenge_is_a_shortfall_not_a_loosened_one(
    built: BuiltScene, mini_cast: Cast
) -> None:
    recipe = read_recipe("mini")
    limits = dataclasses.replace(recipe.thresholds, far_distance_m=60.0)
    strict = dataclasses.replace(recipe, thresholds=limits)
    slot = next(
        s for s in make_slots(recipe, mini_cast.performances) if s.challenge == "far_visible"
    )
    result = composed(slot, built, mini_cast, strict)
    assert not result.episodes
    assert [one.key for one in result.unplaced] == [slot.key]


def test_corpus_recipe_needs_a_source(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"'bandai_namco' reads a corpus: add --source FOLDER"):
        build_release("bandai_namco", tmp_path / "out", jobs=1)
    with pytest.raises(FileNotFoundError, match=r"expected a folder with the corpus"):
        build_release("bandai_namco", tmp_path / "out", source=tmp_path / "none", jobs=1)


@pytest.mark.realdata
@pytest.mark.slow
@pytest.mark.egl
def test_real_clips_become_a_release_that_renders(realdata: Path, tmp_path: Path) -> None:
    out = tmp_path / "bandai"
    report = build_release("bandai_namco", out, source=realdata / "bandai_namco")
    assert report.manifest.num_rows("episodes") >= 20
    assert "CC-BY-NC-4.0" in report.manifest.licences
    release = open_release(out)
    emotions = set(release.episode_table("train").column("emotion").to_pylist())
    assert emotions == {"angry", "happy", "neutral", "sad"}
    for split in ("train", "validation", "test"):
        dataset = AffectSimDataset(release, split=split, condition="p_ref", instances=True)
        sample = dataset[0]
        person = (sample["instances"] == 1).float().mean(dim=(1, 2, 3))
        assert person.min() > 0.02
        assert person.max() < 0.5


@pytest.mark.realdata
def test_one_corrupt_clip_fails_the_build_by_name(realdata: Path, tmp_path: Path) -> None:
    source = tmp_path / "source"
    shutil.copytree(realdata / "bandai_namco" / "dataset-1", source)
    broken = source / "dataset-1_bow_sad_001.bvh"
    broken.write_bytes(broken.read_bytes()[:-4000])
    with pytest.raises(ValueError, match=r"dataset-1_bow_sad_001\.bvh"):
        build_release("bandai_namco", tmp_path / "out", source=source, jobs=1)
    # The clips that could be read are kept for a build that skips the broken one.
    assert sorted(entry.name for entry in tmp_path.iterdir()) == [".out.partial", "source"]
