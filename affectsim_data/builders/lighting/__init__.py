"""Light baked into vertex colours: windows, lamps, shadows, and what surfaces throw back."""

from affectsim_data.builders.lighting.baking import LightMesh, bake_light, relit
from affectsim_data.builders.lighting.colors import exposed
from affectsim_data.builders.lighting.imported import light_surfaces
from affectsim_data.builders.lighting.sources import Lamp, WindowLight

__all__ = [
    "Lamp",
    "LightMesh",
    "WindowLight",
    "bake_light",
    "exposed",
    "light_surfaces",
    "relit",
]
