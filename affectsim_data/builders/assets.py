"""The assets a recipe names: homes with their navmeshes, baked bodies, performances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.builders.corpora import read_corpus
from affectsim_data.builders.homes import HomeRecipe, build_home, home_recipes
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.performances import perform, perform_pair
from affectsim_data.builders.recipes import Recipe
from affectsim_data.content import content_path
from affectsim_data.episodes import Robot
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene

__all__ = [
    "build_stage_assets",
    "load_avatars",
    "make_performances",
    "scene_navmesh",
]


def build_stage_assets(home: HomeRecipe, recipe: Recipe) -> tuple[Scene, NavMesh]:
    """A home and where the robot can go in it."""
    scene = build_home(home, rng=np.random.default_rng(home.seed))
    return scene, scene_navmesh(scene, recipe.robot)


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


def recipe_homes(recipe: Recipe) -> list[HomeRecipe]:
    """The homes of a recipe's homes file."""
    return list(home_recipes(content_path("builders", f"{recipe.homes}.toml")))


def load_avatars(recipe: Recipe) -> list[Avatar]:
    """The baked bodies a recipe names, as releases store them."""
    avatars = []
    for avatar_id in recipe.avatar_ids:
        path = content_path("builders", f"avatars/{avatar_id}.glb")
        avatars.append(Avatar.from_glb(path.read_bytes(), name=str(path)).rounded())
    return avatars


def make_performances(
    recipe: Recipe,
    avatars: Sequence[Avatar],
    *,
    source: Path | None,
    progress: Callable[[str], Any] = lambda message: None,
) -> list[Performance]:
    """All performances of a recipe: its corpus, its procedural ones, or both.

    Raises:
        ValueError: The recipe has a corpus and no source was given, or the corpus is broken.
    """
    performances: list[Performance] = []
    if "corpus" in recipe.document:
        if source is None:
            raise ValueError(
                f"recipe {recipe.name!r} reads a corpus: add --source FOLDER, where your copy of "
                f"{recipe.document['corpus']['name']!r} is"
            )
        motions = read_corpus(recipe.path, source)
        # A corpus that does not name its actors counts as one performer; bodies still vary, by
        # action and never by emotion.
        roles = sorted({(motion.performer_id, motion.action) for motion in motions})
        bodies = {role: avatars[i % len(avatars)] for i, role in enumerate(roles)}
        performances += [
            Performance(m.rounded(), bodies[m.performer_id, m.action]) for m in motions
        ]
    if "performances" in recipe.document:
        performances += _procedural(recipe, avatars)
    return performances


def _procedural(recipe: Recipe, avatars: Sequence[Avatar]) -> list[Performance]:
    table = recipe.document["performances"]
    performers = list(table["performers"])
    bodies = {name: avatars[i % len(avatars)] for i, name in enumerate(performers)}
    performances = []
    for number, performer in enumerate(performers):
        for action_number, action in enumerate(table["actions"]):
            for emotion in EMOTIONS:
                # Emotion stays out of the seed: performers differ, emotions differ by style only.
                rng = np.random.default_rng([recipe.seed, 1, number, action_number])
                motion = perform(action, emotion, performer, rng=rng).rounded()
                performances.append(Performance(motion, bodies[performer]))
    for number, (target, partner) in enumerate(table.get("pairs", ())):
        for emotion in EMOTIONS:
            rng = np.random.default_rng([recipe.seed, 2, number])
            first, second = _rounded(perform_pair(emotion, (target, partner), rng=rng))
            performances.append(Performance(first, bodies[target], (second, bodies[partner])))
    return performances


def _rounded(pair: tuple[Motion, Motion]) -> tuple[Motion, Motion]:
    return pair[0].rounded(), pair[1].rounded()
