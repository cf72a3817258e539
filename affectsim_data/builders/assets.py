"""The assets a recipe names: homes with their navmeshes, and baked bodies."""

from __future__ import annotations

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.builders.homes import HomeRecipe, build_home, home_recipes
from affectsim_data.builders.recipes import Recipe
from affectsim_data.content import content_path
from affectsim_data.episodes import Robot
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene

__all__ = [
    "build_stage_assets",
    "load_avatars",
    "recipe_homes",
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
