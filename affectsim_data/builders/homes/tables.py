"""Tables and what stands on them. Every piece stands on the floor and faces +Z."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, Point, box, lathe
from affectsim_data.builders.homes.pieces import DARK, METAL, Furniture
from affectsim_data.poses import FloatArray

__all__ = ["BOOK_INKS", "coffee_table", "desk", "dining_table", "table_legs", "vase", "wooden"]

BOOK_INKS = np.array(
    [
        [0.72, 0.35, 0.28], [0.28, 0.40, 0.50], [0.85, 0.74, 0.52], [0.36, 0.47, 0.38],
        [0.90, 0.88, 0.83], [0.45, 0.33, 0.40], [0.80, 0.55, 0.32], [0.33, 0.33, 0.36],
    ]
)  # fmt: skip
"""Spines of books, sRGB in [0, 1]."""


def wooden(size: Point, center: Point, color: ArrayLike, *, radius: float = 0.004) -> Part:
    """A wooden box."""
    return box(size, center, color=color, material="wood", radius=radius)


def table_legs(
    width: float, depth: float, height: float, *, thick: float, color: ArrayLike
) -> list[Part]:
    """Four square legs under a top."""
    xs, zs = (width - thick) / 2.0 - 0.04, (depth - thick) / 2.0 - 0.04
    size = (thick, height, thick)
    return [
        wooden(size, (x, height / 2.0, z), color) for x in (-xs, xs) for z in (-zs, zs)
    ]  # fmt: skip


def vase(color: FloatArray, at: Point) -> Part:
    """A small vase standing at a place."""
    profile = [(0.0, 0.0), (0.045, 0.0), (0.07, 0.06), (0.06, 0.13), (0.03, 0.18), (0.035, 0.21),
               (0.028, 0.21), (0.022, 0.16), (0.0, 0.15)]  # fmt: skip
    return lathe(profile, color=color, center=at, segments=22, smooth=True)


def dining_table(palette: Palette, *, width: float = 1.6) -> Furniture:
    """A table for four with a fruit bowl."""
    depth, height, color = 0.9, 0.74, palette.wood
    parts = [
        wooden((width, 0.035, depth), (0.0, height - 0.0175, 0.0), color, radius=0.01),
        wooden((width - 0.2, 0.07, depth - 0.2), (0.0, height - 0.07, 0.0), color),
        *table_legs(width, depth, height - 0.035, thick=0.065, color=color),
    ]
    bowl = [(0.0, 0.012), (0.05, 0.0), (0.09, 0.02), (0.15, 0.085), (0.14, 0.085), (0.08, 0.03),
            (0.0, 0.025)]  # fmt: skip
    parts.append(lathe(bowl, color=palette.accent, center=(0.1, height, 0.0), segments=28))
    for angle in (0.3, 2.4, 4.5):
        at = (0.1 + 0.045 * float(np.cos(angle)), height + 0.025, 0.045 * float(np.sin(angle)))
        parts.append(_fruit(at))
    return Furniture(tuple(parts), width, depth, height)


def _fruit(at: Point) -> Part:
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, 8)
    profile = [(0.038 * float(np.cos(a)), 0.038 + 0.038 * float(np.sin(a))) for a in angle]
    return lathe(profile, color=(0.86, 0.60, 0.28), center=at, segments=16, smooth=True)


def coffee_table(palette: Palette) -> Furniture:
    """A low table with a shelf, a few books and a vase."""
    width, depth, height = 1.05, 0.58, 0.41
    color = palette.wood
    parts = [
        wooden((width, 0.03, depth), (0.0, height - 0.015, 0.0), color, radius=0.008),
        wooden((width - 0.12, 0.018, depth - 0.12), (0.0, 0.15, 0.0), color),
        *table_legs(width, depth, height - 0.03, thick=0.045, color=palette.dark_wood),
        box((0.27, 0.03, 0.2), (-0.25, height + 0.015, 0.02), color=BOOK_INKS[1]),
        box((0.23, 0.025, 0.17), (-0.24, height + 0.0425, 0.01), color=BOOK_INKS[4]),
        vase(palette.accent, (0.28, height, -0.03)),
    ]
    return Furniture(tuple(parts), width, depth, height)


def desk(palette: Palette) -> Furniture:
    """A desk with drawers, a monitor and a keyboard."""
    width, depth, height = 1.4, 0.66, 0.74
    wood = palette.wood
    parts = [
        wooden((width, 0.03, depth), (0.0, height - 0.015, 0.0), wood, radius=0.008),
        wooden((0.42, 0.6, depth - 0.08), (width / 2.0 - 0.25, 0.4, 0.0), palette.cabinet),
        *table_legs(width, depth, height - 0.03, thick=0.05, color=palette.dark_wood),
    ]
    for index in range(3):
        y = 0.2 + 0.19 * index
        parts.append(
            box((0.39, 0.17, 0.015), (width / 2.0 - 0.25, y, depth / 2.0 - 0.035),
                color=palette.cabinet)
        )  # fmt: skip
        parts.append(
            box((0.1, 0.012, 0.02), (width / 2.0 - 0.25, y + 0.03, depth / 2.0 - 0.02),
                color=METAL)
        )  # fmt: skip
    parts += [
        box((0.22, 0.012, 0.16), (-0.15, height + 0.006, -0.18), color=DARK),
        box((0.05, 0.16, 0.02), (-0.15, height + 0.09, -0.2), color=DARK),
        box((0.6, 0.35, 0.025), (-0.15, height + 0.32, -0.18), color=DARK, step=0.2),
        box((0.57, 0.32, 0.004), (-0.15, height + 0.32, -0.166), color=(0.36, 0.45, 0.55),
            step=0.15),
        box((0.42, 0.018, 0.14), (-0.15, height + 0.009, 0.1), color=(0.75, 0.75, 0.75)),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, 1.25)
