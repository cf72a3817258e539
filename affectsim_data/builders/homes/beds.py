"""Beds, their head at the back."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import posts, wooden
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box
from affectsim_data.builders.homes.pieces import BLACK, WHITE, Furniture, LocalSeat, piece
from affectsim_data.builders.homes.shapes import cushion, tube

__all__ = ["BED_LENGTH", "bed_boards", "bed_padded", "bed_steel"]

BED_LENGTH = 2.12
_LYING_Y = 0.47
"""Height of the made bed, metres."""
_MATTRESS_M = 0.19


def _made(
    width: float, palette: Palette, rng: np.random.Generator, *, single: bool
) -> tuple[list[Part], list[LocalSeat]]:
    """Mattress, duvet, pillows and often a throw; seats at both long edges."""
    low = _LYING_Y - 0.06 - _MATTRESS_M
    cover = palette.textile if rng.random() < 0.6 else palette.accent
    parts = [
        cushion((width, _MATTRESS_M, 2.0), (0.0, low + _MATTRESS_M / 2.0, 0.02), color=WHITE,
                radius=0.05, puff=0.0, cells=10),
        cushion((width + 0.05, 0.11, 1.42), (0.0, _LYING_Y - 0.063, 0.315), color=cover,
                radius=0.05, puff=0.012, cells=16),
        cushion((width + 0.045, 0.05, 0.22), (0.0, _LYING_Y + 0.008, -0.29), color=WHITE * 0.98,
                radius=0.022, puff=0.004, cells=14),
    ]  # fmt: skip
    if rng.random() < 0.6:
        other = palette.accent if cover is palette.textile else palette.rug
        parts.append(cushion((width + 0.085, 0.1, 0.5), (0.0, _LYING_Y - 0.042, 0.72), color=other,
                             radius=0.045, puff=0.01, cells=14))  # fmt: skip
    places = (0.0,) if single else (-width / 4.0, width / 4.0)
    for x in places:
        pillow = cushion((0.6, 0.12, 0.4), (0.0, 0.0, 0.0), color=WHITE, radius=0.05, puff=0.035)
        parts.append(pillow.tilted(-0.3).moved(x, _LYING_Y + 0.09, -0.74))
        if rng.random() < 0.5:
            small = cushion((0.42, 0.1, 0.3), (0.0, 0.0, 0.0), color=palette.accent, radius=0.045,
                            puff=0.035)  # fmt: skip
            parts.append(small.tilted(-0.75).moved(x, _LYING_Y + 0.16, -0.52))
    seats = [
        LocalSeat(
            (sign * (width / 2.0 - 0.2), _LYING_Y, 0.25), 0.5, yaw=sign * np.pi / 2.0, edge=0.22
        )
        for sign in (-1.0, 1.0)
    ]
    return parts, seats


def bed_boards(
    palette: Palette, *, rng: np.random.Generator, width: float = 1.6, foot: bool = True
) -> Furniture:
    """A wooden bed with a high head and, if asked, a low foot board."""
    wood = palette.wood if rng.random() < 0.6 else palette.dark_wood
    half = BED_LENGTH / 2.0
    parts, seats = _made(width, palette, rng, single=width < 1.3)
    parts += [
        wooden((width + 0.06, 0.16, BED_LENGTH - 0.09), (0.0, 0.2, 0.0), wood),
        wooden((width + 0.08, 0.5, 0.045), (0.0, 0.66, -half + 0.0225), wood, radius=0.012),
        wooden((width + 0.08, 0.03, 0.06), (0.0, 0.925, -half + 0.03), wood, radius=0.01),
    ]
    x = width / 2.0 + 0.02
    parts.append(posts([-x, x], -half + 0.03, y=(0.0, 0.92), thick=0.055, color=wood))
    if foot:
        parts += [
            wooden((width + 0.06, 0.34, 0.04), (0.0, 0.34, half - 0.03), wood, radius=0.01),
            posts([-x, x], half - 0.03, y=(0.0, 0.56), thick=0.055, color=wood),
        ]
    else:
        parts.append(
            posts([-x + 0.03, x - 0.03], half - 0.1, y=(0.0, 0.14), thick=0.05, color=wood)
        )
    return piece("bed", parts, (width + 0.1, BED_LENGTH, 0.96), seats=seats)


def bed_padded(palette: Palette, *, rng: np.random.Generator, width: float = 1.6) -> Furniture:
    """A bed covered in cloth, with a head of upright or square pads."""
    color, half = palette.sofa if rng.random() < 0.5 else palette.rug, BED_LENGTH / 2.0
    parts, seats = _made(width, palette, rng, single=width < 1.3)
    parts += [
        box((width + 0.06, 0.2, BED_LENGTH - 0.11), (0.0, 0.2, 0.03), color=color,
            material="fabric", radius=0.02, segments=2),
        box((width + 0.08, 0.96, 0.05), (0.0, 0.5, -half + 0.026), color=color * 0.95,
            material="fabric", radius=0.02, segments=2),
    ]  # fmt: skip
    count = max(round(width / 0.28), 2)
    each = (width + 0.06) / count
    for k in range(count):
        x = (k + 0.5) * each - (width + 0.06) / 2.0
        parts.append(cushion((each - 0.002, 0.52, 0.05), (x, 0.71, -half + 0.07), color=color,
                             radius=0.02, puff=0.012, axis=2, cells=5))  # fmt: skip
    x = width / 2.0 - 0.06
    parts.append(posts([-x, x, -x, x], [half - 0.12, half - 0.12, -half + 0.2, -half + 0.2],
                       y=(0.0, 0.11), thick=0.05, color=palette.dark_wood))  # fmt: skip
    return piece("bed", parts, (width + 0.1, BED_LENGTH, 0.98), seats=seats)


def bed_steel(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A bed of steel tube with bars at its head and foot."""
    half, x = BED_LENGTH / 2.0, width / 2.0 + 0.02
    color = BLACK if rng.random() < 0.5 else WHITE
    parts, seats = _made(width, palette, rng, single=width < 1.3)
    for z, tall in ((-half + 0.025, 0.95), (half - 0.025, 0.6)):
        arch = [(-x, 0.0, z), (-x, tall - 0.1, z), (-x + 0.03, tall - 0.03, z), (-x + 0.1, tall, z),
                (0.0, tall, z), (x - 0.1, tall, z), (x - 0.03, tall - 0.03, z), (x, tall - 0.1, z),
                (x, 0.0, z)]  # fmt: skip
        parts.append(tube(arch, 0.018, color=color, segments=10))
        for bar in np.linspace(-x + 0.12, x - 0.12, max(int(width / 0.13), 4)):
            rod = [(bar, 0.3, z), (bar, tall / 2.0 + 0.15, z), (bar, tall, z)]
            parts.append(tube(rod, 0.008, color=color, segments=6))
        parts.append(tube([(-x, 0.3, z), (0.0, 0.3, z), (x, 0.3, z)], 0.012, color=color))
    for sign in (-1.0, 1.0):
        parts.append(box((0.03, 0.07, BED_LENGTH - 0.06), (sign * x, 0.26, 0.0), color=color))
    parts.append(box((width, 0.03, BED_LENGTH - 0.1), (0.0, 0.22, 0.0), color=palette.wood,
                     material="wood"))  # fmt: skip
    return piece("bed", parts, (width + 0.1, BED_LENGTH, 0.97), seats=seats)
