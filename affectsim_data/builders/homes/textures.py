"""Materials of homes; their textures are bright and nearly grey, vertex colours give the hue."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from affectsim_data.builders.homes import cloths, floorings, views
from affectsim_data.builders.homes.patterns import Image

__all__ = ["MATERIALS", "Material", "material_texture"]


@dataclasses.dataclass(frozen=True)
class Material:
    """How a surface looks before its vertex colours."""

    paint: Callable[[np.random.Generator], Image] | None = None
    """Makes the texture, one of several variants; none for plain colour."""
    tile_m: float = 1.0
    """Metres one copy of the texture covers; 1 with coordinates already in [0, 1]."""
    glows: bool = False
    """Whether it is drawn as bright as its colour, whatever light falls on it."""
    shadows: bool = True
    """Whether it throws shadows; lamps shine through their own shades."""


MATERIALS: dict[str, Material] = {
    "plain": Material(),
    "lamp": Material(glows=True, shadows=False),
    "wood": Material(floorings.wood, 0.7),
    "planks": Material(floorings.planks, 1.28),
    "tiles": Material(floorings.tiles, 1.2),
    "wall_tiles": Material(floorings.wall_tiles, 0.6),
    "stone": Material(floorings.stone, 0.8),
    "marble": Material(floorings.marble, 1.2),
    "metal": Material(floorings.metal, 0.5),
    "paint": Material(cloths.paint, 2.0),
    "wallpaper": Material(cloths.wallpaper, 0.6),
    "fabric": Material(cloths.fabric, 0.32),
    "leather": Material(cloths.leather, 0.4),
    "wicker": Material(cloths.wicker, 0.12),
    "carpet": Material(cloths.carpet, 0.6),
    "rug": Material(cloths.rug, 0.8),
    "sky": Material(views.sky, glows=True),
    "art": Material(views.art),
}
"""By name: what `Part.material` may be."""


def material_texture(name: str, *, rng: np.random.Generator) -> Image | None:
    """sRGB texture `(height, width, 3)` of a material, or none; `rng` picks among its variants.

    Raises:
        KeyError: No such material.
    """
    if name not in MATERIALS:
        raise KeyError(f"material must be one of {tuple(MATERIALS)}, got {name!r}")
    paint = MATERIALS[name].paint
    return None if paint is None else paint(rng)
