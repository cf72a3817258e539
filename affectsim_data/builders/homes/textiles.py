"""Rugs and curtains."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes
from affectsim_data.builders.homes.pieces import Furniture, piece
from affectsim_data.builders.homes.shapes import ball, oval, slab, tube, two_sided

__all__ = [
    "CURTAIN_DEPTH", "CURTAIN_WIDTH", "RUG_Y", "bath_mat", "curtain", "curtain_rod",
    "rug", "rug_round",
]  # fmt: skip

CURTAIN_WIDTH, CURTAIN_DEPTH = 0.36, 0.17
"""Of a drawn-back curtain with its rod, metres."""
RUG_Y = 0.008
"""Height of the upper side of a rug, metres."""


def rug(
    palette: Palette, *, rng: np.random.Generator, width: float = 2.0, depth: float = 1.4
) -> Furniture:
    """A flat rug: plain with a border, striped, or with fields."""
    border = (palette.textile, palette.accent, palette.sofa)[int(rng.integers(3))]
    low, draw = 0.0055, float(rng.random())
    parts: list[Part] = [
        box((width, low, depth), (0.0, low / 2.0, 0.0), color=border, material="carpet",
            radius=0.0, step=0.15),
    ]  # fmt: skip
    if draw < 0.45:
        edge = 0.09
        parts.append(box((width - 2.0 * edge, RUG_Y, depth - 2.0 * edge), (0.0, RUG_Y / 2.0, 0.0),
                         color=palette.rug, material="carpet", radius=0.0, step=0.15))  # fmt: skip
    elif draw < 0.75:
        count = max(int(width / 0.24), 3)
        xs = (np.arange(count) + 0.5) * width / count - width / 2.0
        middles = np.stack([xs, np.full(count, RUG_Y / 2.0), 0.0 * xs], axis=1)
        stripes = np.tile([0.6 * width / count, RUG_Y, depth - 0.06], (count, 1))
        tints = np.where((np.arange(count) % 3 == 1)[:, None], palette.accent, palette.rug)
        parts.append(boxes(stripes, middles, colors=tints, material="carpet"))
    else:
        across, down = max(int(width / 0.4), 2), max(int(depth / 0.4), 2)
        x = (np.arange(across) + 0.5) * (width - 0.1) / across - (width - 0.1) / 2.0
        z = (np.arange(down) + 0.5) * (depth - 0.1) / down - (depth - 0.1) / 2.0
        places = np.array([(a, RUG_Y / 2.0, b) for a in x for b in z])
        size = [(width - 0.1) / across - 0.03, RUG_Y, (depth - 0.1) / down - 0.03]
        tints = palette.rug * rng.uniform(0.92, 1.04, (len(places), 1))
        parts.append(boxes(np.tile(size, (len(places), 1)), places, colors=np.clip(tints, 0, 1),
                           material="carpet"))  # fmt: skip
    return piece("rug", parts, (width, depth, RUG_Y))


def rug_round(palette: Palette, *, rng: np.random.Generator, width: float = 1.6) -> Furniture:
    """A round rug with a border."""
    parts = [
        slab(oval(width, width, count=48), 0.0055, 0.0055, color=palette.accent,
             material="carpet", bevel=0.001),
        slab(oval(width - 0.2, width - 0.2, count=48), RUG_Y, 0.006, color=palette.rug,
             material="carpet", bevel=0.001),
    ]  # fmt: skip
    return piece("rug", parts, (width, width, RUG_Y))


def bath_mat(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small mat with ribs."""
    width, depth, count = 0.75, 0.48, 11
    xs = (np.arange(count) + 0.5) * width / count - width / 2.0
    ribs = np.stack([xs, np.full(count, RUG_Y / 2.0), 0.0 * xs], axis=1)
    color = palette.textile if rng.random() < 0.5 else palette.accent
    parts = [
        box((width, 0.005, depth), (0.0, 0.0025, 0.0), color=color * 0.95, material="carpet"),
        boxes(np.tile([0.05, RUG_Y, depth - 0.03], (count, 1)), ribs, colors=color,
              material="carpet"),
    ]  # fmt: skip
    return piece("rug", parts, (width, depth, RUG_Y))


def curtain(palette: Palette, *, rng: np.random.Generator, height: float = 2.2) -> Furniture:
    """One drawn-back curtain in folds."""
    color = palette.textile if rng.random() < 0.7 else palette.rug
    folds = int(rng.integers(4, 7))
    across = np.linspace(-CURTAIN_WIDTH / 2.0, CURTAIN_WIDTH / 2.0, 8 * folds + 1)
    heights = np.linspace(0.0, height - 0.004, 7)
    spread = 1.0 - 0.12 * np.sin(np.pi * heights / height)[:, None]
    wave = 0.03 * np.sin(across * (2.0 * np.pi * folds / CURTAIN_WIDTH))
    points = np.stack(
        np.broadcast_arrays(across * spread, heights[:, None], wave * np.ones((7, 1))), axis=-1
    )
    cloth = two_sided(points, color=color, material="fabric", thickness=0.006)
    return piece("curtain", [cloth], (CURTAIN_WIDTH + 0.01, 0.07, height))


def curtain_rod(palette: Palette, *, rng: np.random.Generator, width: float = 2.0) -> Furniture:
    """A rod with balls at its ends, held from the wall behind it."""
    tint, y, z, half = np.array([0.33, 0.32, 0.31]), 0.018, 0.04, width / 2.0
    rod = [(0.02 - half, y, z), (0.0, y, z), (half - 0.02, y, z)]
    parts: list[Part] = [tube(rod, 0.01, color=tint)]
    for sign in (-1.0, 1.0):
        parts += [
            ball(0.018, (sign * (half - 0.018), y, z), color=tint, segments=10),
            box((0.012, 0.012, 0.1), (sign * (half - 0.06), y, z - 0.05), color=tint),
        ]
    return piece("curtain rod", parts, (width, 0.14, 0.036))
