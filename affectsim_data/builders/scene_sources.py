"""The scenes of a recipe, one by one: generated or imported, lit, baked, with their navmesh."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import Path

import numpy as np

from affectsim_data.builders.habitat import Dataset, import_scene, read_dataset
from affectsim_data.builders.homes import HomeRecipe, build_home, home_recipes
from affectsim_data.builders.homes.catalogue import Catalogue, read_catalogue
from affectsim_data.builders.imports import ImportReport
from affectsim_data.builders.lighting import light_surfaces
from affectsim_data.builders.mesh_scenes import mesh_scene
from affectsim_data.builders.meshes import MESH_SUFFIXES
from affectsim_data.builders.recipes import Recipe
from affectsim_data.content import content_path
from affectsim_data.episodes import Robot
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene
from affectsim_data.scenes.baking import BakeReport, bake_scene

__all__ = [
    "BuiltScene",
    "FailedScene",
    "SceneSource",
    "build_scene",
    "scene_navmesh",
    "scene_sources",
]

_MAX_SCENES = 10_000


@dataclasses.dataclass(frozen=True)
class HabitatScene:
    """A scene of a Habitat dataset."""

    scene_id: str
    dataset: Path
    """Its config, or the folder."""
    handle: str
    """Of the scene."""


@dataclasses.dataclass(frozen=True)
class MeshScene:
    """A scene in a mesh file of its own."""

    scene_id: str
    path: Path


SceneSource = HomeRecipe | HabitatScene | MeshScene


@dataclasses.dataclass(frozen=True)
class BuiltScene:
    """A scene as releases store it, and what became of what it was made from."""

    scene: Scene
    navmesh: NavMesh
    baked: BakeReport
    imported: ImportReport | None = None
    """None for generated homes."""


@dataclasses.dataclass(frozen=True)
class FailedScene:
    """A scene that cannot be used."""

    scene_id: str
    reason: str
    """Names the file; says what to do."""


def scene_sources(recipe: Recipe, source: Path | None) -> list[SceneSource]:
    """The scenes a recipe names, in order.

    Args:
        recipe: Its `[scenes]` say which.
        source: The user's own copy of what is imported.

    Raises:
        FileNotFoundError: There is no such folder, or no such scene in it.
        ValueError: The recipe reads files and no source was given.
    """
    wanted = recipe.scenes
    if wanted.needs_source and source is None:
        raise ValueError(
            f"recipe {recipe.name!r} reads scenes: add --source FOLDER, where your copy of them is"
            + (f" ({wanted.obtain})" if wanted.obtain else "")
        )
    if wanted.kind == "homes":
        return list(home_recipes(content_path("builders", f"{wanted.files}.toml")))
    assert source is not None
    folder = source.expanduser().resolve()
    found = _habitat_scenes(recipe, folder) if wanted.kind == "habitat" else _files(recipe, folder)
    chosen = [one for name, one in found if wanted.wants(name)]
    if not chosen:
        names = ", ".join(name for name, _ in found[:10]) or "none"
        raise FileNotFoundError(
            f"{folder}: no scene matches include = {list(wanted.include)} of {recipe.path}; "
            f"there are {len(found)}: {names}"
        )
    if len(chosen) > _MAX_SCENES:
        raise ValueError(f"{folder}: {len(chosen)} scenes, more than {_MAX_SCENES}")
    return chosen


def _habitat_scenes(recipe: Recipe, folder: Path) -> list[tuple[str, SceneSource]]:
    # A pattern stands for the only config there is; scenes without one are found by their names.
    path = folder if "*" in recipe.scenes.files else folder / recipe.scenes.files
    handles = _dataset(path).scene_handles
    return [
        (handle.rsplit("/", 1)[-1], HabitatScene(f"{recipe.name}/{handle}", path, handle))
        for handle in handles
    ]


@functools.lru_cache(maxsize=2)
def _dataset(path: Path) -> Dataset:
    return read_dataset(path)


def _files(recipe: Recipe, folder: Path) -> list[tuple[str, SceneSource]]:
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: no such folder")
    paths = sorted(
        path for path in folder.glob(recipe.scenes.files) if path.suffix.lower() in MESH_SUFFIXES
    )
    return [
        (path.stem, MeshScene(f"{recipe.name}/{path.relative_to(folder).with_suffix('')}", path))
        for path in paths
    ]


def build_scene(
    source: SceneSource, recipe: Recipe, folder: Path | None
) -> BuiltScene | FailedScene:
    """One scene of `scene_sources`, ready to be stored; the same every time.

    Args:
        source: Which.
        recipe: What is done to it, and for which robot.
        folder: The user's own copy of what is read.
    """
    try:
        if isinstance(source, HomeRecipe):
            imported = None
            baked, report = bake_scene(_home(source, recipe, folder))
        else:
            scene, imported = _imported(source, recipe)
            baked, report = _lit(scene, recipe)
        return BuiltScene(baked, scene_navmesh(baked, recipe.robot), report, imported)
    except (ValueError, OSError) as error:
        return FailedScene(source.scene_id, str(error))


def _home(source: HomeRecipe, recipe: Recipe, folder: Path | None) -> Scene:
    catalogue = None
    if recipe.scenes.catalogue and folder is not None:
        catalogue = _catalogue(folder.expanduser().resolve())
    return build_home(source, rng=np.random.default_rng(source.seed), catalogue=catalogue)


def _imported(source: HabitatScene | MeshScene, recipe: Recipe) -> tuple[Scene, ImportReport]:
    """A scene as its files have it, without light."""
    wanted = recipe.scenes
    if isinstance(source, HabitatScene):
        dataset = _dataset(source.dataset)
        scene, report = import_scene(
            dataset, source.handle, shell=wanted.shell, licence=wanted.licence
        )
    else:
        scene, report = mesh_scene(
            source.path,
            scene_id=source.scene_id,
            drop_nodes=wanted.drop_nodes,
            licence=wanted.licence,
        )
    scene_id = source.scene_id
    return (
        dataclasses.replace(scene, scene_id=scene_id),
        dataclasses.replace(report, scene_id=scene_id),
    )


def _lit(scene: Scene, recipe: Recipe) -> tuple[Scene, BakeReport]:
    """An imported scene with light, ready to draw; simplified before, because light is detail."""
    simple, first = bake_scene(scene, max_triangles=recipe.scenes.max_triangles)
    surfaces = light_surfaces(simple.surfaces, rooms=simple.rooms)
    baked, second = bake_scene(dataclasses.replace(simple, surfaces=surfaces, chunks=None))
    notes = tuple(dict.fromkeys(first.notes + second.notes))
    return baked, dataclasses.replace(first, after=second.after, notes=notes)


@functools.lru_cache(maxsize=1)
def _catalogue(folder: Path) -> Catalogue:
    return read_catalogue(folder)


def scene_navmesh(scene: Scene, robot: Robot) -> NavMesh:
    """The navmesh of a scene for a robot.

    Raises:
        ValueError: The scene has no floor the robot can stand on.
    """
    try:
        return NavMesh.from_mesh(
            *scene.mesh(),
            agent_radius=robot.radius_m,
            agent_height=robot.height_m,
            mesh_sha256=scene.mesh_sha256(),
        )
    except ValueError as error:
        raise ValueError(f"scene {scene.scene_id!r}: {error}") from error
