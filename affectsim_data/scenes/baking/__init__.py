"""Scenes made ready to draw: few surfaces, welded vertices, textures within a budget, chunks."""

from affectsim_data.scenes.baking.baking import TEXTURE_BUDGET, bake_scene
from affectsim_data.scenes.baking.report import BakeCounts, BakeLoss, BakeReport

__all__ = ["TEXTURE_BUDGET", "BakeCounts", "BakeLoss", "BakeReport", "bake_scene"]
