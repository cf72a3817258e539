"""Baked bodies, as the recipe of a release names them."""

from __future__ import annotations

from affectsim_data.avatars import Avatar
from affectsim_data.builders.recipes import Recipe
from affectsim_data.content import content_path

__all__ = ["load_avatars"]


def load_avatars(recipe: Recipe) -> list[Avatar]:
    """The baked bodies a recipe names, as releases store them."""
    avatars = []
    for avatar_id in recipe.avatar_ids:
        path = content_path("builders", f"avatars/{avatar_id}.glb")
        avatars.append(Avatar.from_glb(path.read_bytes(), name=str(path)).rounded())
    return avatars
