"""Procedural furnished homes: rooms, doors, windows, furniture and baked light from a recipe."""

from affectsim_data.builders.homes.building import build_home
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.recipes import HomeRecipe, Strip, home_recipes

__all__ = ["HomeRecipe", "Palette", "Strip", "build_home", "home_recipes"]
