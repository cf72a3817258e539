"""Procedural furnished homes: rooms, doors, windows, furniture and baked light from a recipe."""

from affectsim_data.builders.homes.building import HomeDesign, build_home, design_home
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.plans import HomePlan, RoomPlan, plan_home
from affectsim_data.builders.homes.purposes import Purpose
from affectsim_data.builders.homes.recipes import HomeRecipe, home_recipes

__all__ = [
    "HomeDesign", "HomePlan", "HomeRecipe", "Palette", "Purpose", "RoomPlan",
    "build_home", "design_home", "home_recipes", "plan_home",
]  # fmt: skip
