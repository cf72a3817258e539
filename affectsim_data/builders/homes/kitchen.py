"""Counters, islands and fridges. Every piece stands on the floor and faces +Z."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import box, lathe
from affectsim_data.builders.homes.pieces import DARK, METAL, Furniture
from affectsim_data.builders.homes.storage import cabinet_doors
from affectsim_data.builders.homes.tables import vase

__all__ = ["counter", "fridge", "island"]


def counter(palette: Palette, *, width: float, upper: bool) -> Furniture:
    """Base cabinets under a stone top with sink, tap and stove; wall cabinets if asked."""
    height, depth = 0.9, 0.62
    count = max(round(width / 0.55), 2)
    parts = [
        box((width, height - 0.14, depth - 0.04), (0.0, height / 2.0 + 0.03, -0.02),
            color=palette.cabinet),
        box((width, 0.1, depth - 0.12), (0.0, 0.05, -0.04), color=DARK),
        *cabinet_doors(width, 0.12, height - 0.06, depth / 2.0 - 0.04, count=count,
                color=palette.cabinet),
        box((width, 0.04, depth), (0.0, height - 0.02, 0.0), color=(0.86, 0.85, 0.83),
            material="stone", step=0.25),
        box((0.5, 0.006, 0.4), (-width / 4.0, height + 0.003, 0.01), color=METAL),
        box((0.44, 0.004, 0.33), (-width / 4.0, height + 0.007, 0.01), color=METAL * 0.75),
        lathe([(0.022, 0.0), (0.018, 0.26)], color=METAL, segments=14,
              center=(-width / 4.0, height, -0.22)),
        box((0.024, 0.024, 0.2), (-width / 4.0, height + 0.25, -0.13), color=METAL,
            radius=0.01),
        box((0.56, 0.008, 0.48), (width / 4.0, height + 0.004, 0.0), color=DARK),
    ]  # fmt: skip
    for dx, dz in ((-0.13, -0.11), (0.13, -0.11), (-0.13, 0.11), (0.13, 0.11)):
        ring = [(0.085, 0.0), (0.08, 0.004), (0.0, 0.004)]
        at = (width / 4.0 + dx, height + 0.008, dz)
        parts.append(lathe(ring, color=DARK * 1.5, center=at, segments=24))
    if not upper:
        return Furniture(tuple(parts), width, depth, height)
    wall_depth, z = 0.34, -depth / 2.0 + 0.17
    parts += [
        box((width, 0.68, wall_depth - 0.02), (0.0, 1.82, z - 0.01), color=palette.cabinet),
        *cabinet_doors(width, 1.5, 2.15, z + wall_depth / 2.0 - 0.02, count=count,
                color=palette.cabinet),
        box((width, 0.58, 0.012), (0.0, 1.19, -depth / 2.0 + 0.006), color=(0.88, 0.89, 0.88),
            material="tiles", step=0.3, sides="xXyYZ"),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, 2.16)


def island(palette: Palette, *, width: float) -> Furniture:
    """A kitchen island with an overhanging stone top, cabinets to the front."""
    height, depth = 0.92, 0.85
    count = max(round(width / 0.55), 2)
    parts = [
        box((width - 0.1, height - 0.04, depth - 0.3), (0.0, (height - 0.04) / 2.0, 0.06),
            color=palette.accent_wall, step=0.3),
        *cabinet_doors(width - 0.12, 0.1, height - 0.07, 0.06 + (depth - 0.3) / 2.0, count=count,
                color=palette.cabinet),
        box((width, 0.04, depth), (0.0, height - 0.02, 0.0), color=(0.88, 0.87, 0.85),
            material="stone", step=0.25),
        vase(palette.accent, (width / 4.0, height, 0.0)),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, height)


def fridge() -> Furniture:
    """A fridge with a freezer below."""
    color = np.array([0.82, 0.83, 0.84])
    parts = [
        box((0.6, 1.85, 0.6), (0.0, 0.925, -0.02), color=color * 0.95),
        box((0.596, 1.1, 0.04), (0.0, 1.285, 0.3), color=color, radius=0.012, segments=2),
        box((0.596, 0.64, 0.04), (0.0, 0.4, 0.3), color=color, radius=0.012, segments=2),
        box((0.02, 0.5, 0.025), (-0.24, 1.1, 0.335), color=METAL),
        box((0.02, 0.3, 0.025), (-0.24, 0.52, 0.335), color=METAL),
    ]
    return Furniture(tuple(parts), 0.62, 0.7, 1.86)
