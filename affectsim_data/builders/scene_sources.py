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
from affectsim_data.builders.sources import SourceGiven, find_sources
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
    "found_scenes",
    "read_habitat",
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

    @property
    def name(self) -> str:
        """What `include` and `exclude` match."""
        return self.handle.rsplit("/", 1)[-1]


@dataclasses.dataclass(frozen=True)
class MeshScene:
    """A scene in a mesh file of its own."""

    scene_id: str
    path: Path

    @property
    def name(self) -> str:
        """What `include` and `exclude` match."""
        return self.path.stem


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


def scene_sources(recipe: Recipe, source: SourceGiven) -> list[SceneSource]:
    """The scenes a recipe names, in order.

    Args:
        recipe: Its `[scenes]` say which.
        source: The user's own copy of what is imported.

    Raises:
        FileNotFoundError: There is no such folder, or no such scene in it.
        ValueError: The recipe reads files and no source was given, or there are too few scenes.
    """
    wanted = recipe.scenes
    folder = _folder(recipe, source)
    if wanted.kind == "homes":
        homes = home_recipes(content_path("builders", f"{wanted.files}.toml"))
        found: dict[str, SceneSource] = {one.scene_id: one for one in homes}
    else:
        assert folder is not None
        found = {one.scene_id: one for one in found_scenes(recipe, folder)}
    chosen = wanted.chosen(list(found), recipe.seed)
    if len(chosen) > _MAX_SCENES:
        raise ValueError(f"{folder}: {len(chosen)} scenes, more than {_MAX_SCENES}")
    return [found[scene_id] for scene_id in chosen]


def found_scenes(recipe: Recipe, folder: Path) -> list[HabitatScene | MeshScene]:
    """The scenes in a folder that a recipe lets pass, all of them, in order.

    Raises:
        FileNotFoundError: There is no such folder, or no such scene in it.
    """
    folder, wanted = folder.expanduser().resolve(), recipe.scenes
    habitat = wanted.kind == "habitat"
    found = _habitat_scenes(recipe, folder) if habitat else _files(recipe, folder)
    passing = [one for one in found if wanted.wants(one.name)]
    if not passing:
        names = ", ".join(one.name for one in found[:10]) or "none"
        raise FileNotFoundError(
            f"{folder}: no scene matches include = {list(wanted.include)} of {recipe.path}; "
            f"there are {len(found)}: {names}"
        )
    return passing


def _folder(recipe: Recipe, source: SourceGiven) -> Path | None:
    """The folder that scenes are read from."""
    if not recipe.scenes.needs_source:
        return None
    return find_sources(recipe, source)[recipe.scenes.name].expanduser().resolve()


def _habitat_scenes(recipe: Recipe, folder: Path) -> list[HabitatScene | MeshScene]:
    # A pattern stands for the only config there is; scenes without one are found by their names.
    path = folder if "*" in recipe.scenes.files else folder / recipe.scenes.files
    name = recipe.scenes.name
    return [
        HabitatScene(f"{name}/{handle}", path, handle)
        for handle in read_habitat(path).scene_handles
    ]


@functools.lru_cache(maxsize=2)
def read_habitat(path: Path) -> Dataset:
    """A Habitat dataset, listed once for all of its scenes."""
    return read_dataset(path)


def _files(recipe: Recipe, folder: Path) -> list[HabitatScene | MeshScene]:
    if not folder.is_dir():
        raise FileNotFoundError(f"{folder}: no such folder")
    paths = sorted(
        path for path in folder.glob(recipe.scenes.files) if path.suffix.lower() in MESH_SUFFIXES
    )
    name = recipe.scenes.name
    return [MeshScene(f"{name}/{path.relative_to(folder).with_suffix('')}", path) for path in paths]


def build_scene(
    source: SceneSource, recipe: Recipe, folder: SourceGiven
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


def _home(source: HomeRecipe, recipe: Recipe, folder: SourceGiven) -> Scene:
    catalogue = None
    own = _folder(recipe, folder)
    if recipe.scenes.catalogue and own is not None:
        catalogue = _catalogue(own)
    return build_home(source, rng=np.random.default_rng(source.seed), catalogue=catalogue)


def _imported(source: HabitatScene | MeshScene, recipe: Recipe) -> tuple[Scene, ImportReport]:
    """A scene as its files have it, without light."""
    wanted = recipe.scenes
    if isinstance(source, HabitatScene):
        dataset = read_habitat(source.dataset)
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
