"""What hangs on walls, and screens: pictures, mirrors, clocks, boards, hooks, televisions."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, Point, box, boxes, lathe, sheet
from affectsim_data.builders.homes.pieces import BLACK, DARK, METAL, WHITE, Furniture, piece
from affectsim_data.builders.homes.shapes import ball, oval, slab, tube, two_sided
from affectsim_data.builders.homes.trinkets import book_row, dressed

__all__ = [
    "clock",
    "coat_rack",
    "mirror",
    "mirror_round",
    "picture",
    "radiator",
    "tv",
    "wall_board",
]

_GLASS = np.array([0.8, 0.85, 0.87])
PAINTINGS = 4
"""In the atlas of the material `art`, two by two."""


def _bars(
    width: float, height: float, thick: float, deep: float
) -> tuple[list[Point], list[Point]]:
    """Sizes and middles of the four bars of a frame whose underside is at 0."""
    x, tall = (width - thick) / 2.0, height - 2.0 * thick
    sizes = [(width, thick, deep), (width, thick, deep), (thick, tall, deep), (thick, tall, deep)]
    middles = [(0.0, thick / 2.0, 0.0), (0.0, height - thick / 2.0, 0.0), (-x, height / 2.0, 0.0),
               (x, height / 2.0, 0.0)]  # fmt: skip
    return sizes, middles


def picture(
    palette: Palette, *, rng: np.random.Generator, width: float = 0.7, height: float = 0.9
) -> Furniture:
    """A framed picture, its back to the wall."""
    depth, thick = 0.026, 0.022
    inks = (palette.dark_wood, BLACK, WHITE, palette.wood)
    color = inks[int(rng.integers(len(inks)))]
    inner = (width - 2.0 * thick, height - 2.0 * thick)
    canvas = sheet(
        (-inner[0] / 2.0, thick, 0.004), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0),
        np.linspace(0.0, inner[0], 3), np.linspace(0.0, inner[1], 3), color=(1.0, 1.0, 1.0),
        material="art",
    )  # fmt: skip
    painting = int(rng.integers(PAINTINGS))
    # A little inside its quarter of the atlas, so that filtering does not reach the next painting.
    share = 0.02 + 0.96 * (canvas.uvs / inner + (0.0, 1.0))
    corner = np.array([painting % 2, painting // 2])
    sizes, middles = _bars(width, height, thick, depth)
    parts = [
        boxes(sizes, middles, colors=color),
        box((*inner, 0.01), (0.0, height / 2.0, -depth / 2.0 + 0.005), color=color),
        dataclasses.replace(canvas, uvs=0.5 * (share + corner)),
    ]
    return piece("picture", parts, (width, depth, height))


def mirror(
    palette: Palette, *, rng: np.random.Generator, width: float = 0.6, height: float = 0.8
) -> Furniture:
    """A looking-glass in a frame."""
    depth, thick = 0.03, 0.025
    sizes, middles = _bars(width, height, thick, depth)
    parts = [
        boxes(sizes, middles, colors=palette.wood, material="wood"),
        box((width - 2.0 * thick, height - 2.0 * thick, 0.012), (0.0, height / 2.0, -0.005),
            color=_GLASS, step=0.2),
    ]  # fmt: skip
    return piece("mirror", parts, (width, depth, height))


def mirror_round(palette: Palette, *, rng: np.random.Generator, width: float = 0.65) -> Furniture:
    """A round looking-glass."""
    rim = lathe([(0.0, -0.015), (width / 2.0, -0.015), (width / 2.0, 0.015),
                 (width / 2.0 - 0.018, 0.015), (width / 2.0 - 0.018, 0.006), (0.0, 0.006)],
                color=palette.dark_wood, segments=40)  # fmt: skip
    glass = slab(oval(width - 0.05, width - 0.05, count=36), 0.0095, 0.005, color=_GLASS,
                 material="plain", bevel=0.001)  # fmt: skip
    parts = [part.tilted(np.pi / 2.0).moved(y=width / 2.0) for part in (rim, glass)]
    return piece("mirror", parts, (width, 0.03, width))


def clock(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A round wall clock."""
    reach, y = 0.15, 0.15
    rim = lathe([(0.0, -0.02), (reach, -0.02), (reach, 0.02), (reach - 0.015, 0.02),
                 (reach - 0.015, 0.008), (0.0, 0.008)], color=BLACK, segments=32)  # fmt: skip
    face = slab(oval(0.264, 0.264, count=30), 0.0115, 0.005, color=WHITE, material="plain",
                bevel=0.001)  # fmt: skip
    marks = [(0.11 * np.sin(a), y + 0.11 * np.cos(a), 0.0125) for a in np.arange(12) * np.pi / 6.0]
    turn = float(rng.uniform(0.0, 2.0 * np.pi))
    parts = [part.tilted(np.pi / 2.0).moved(y=y) for part in (rim, face)]
    parts.append(boxes([(0.012, 0.012, 0.003)] * 12, marks, colors=BLACK))
    for length, angle, z in ((0.065, turn, 0.0155), (0.1, 5.0 * turn, 0.0185)):
        hand = box((0.008, length, 0.002), (0.0, length / 2.0 - 0.01, z), color=BLACK)
        parts.append(hand.tilted(angle, axis=2).moved(y=y))
    return piece("clock", parts, (0.3, 0.04, 0.3))


def wall_board(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A board on the wall with books and small things."""
    depth, thick = 0.24, 0.028
    parts: list[Part] = [
        box((width, thick, depth), (0.0, 0.06 + thick / 2.0, 0.0), color=palette.wood,
            material="wood"),
        boxes([(0.02, 0.06, 0.16)] * 2,
              [(s * (width / 2.0 - 0.15), 0.03, -depth / 2.0 + 0.08) for s in (-1, 1)],
              colors=BLACK),
    ]  # fmt: skip
    y = 0.06 + thick
    split = float(rng.uniform(-0.1, 0.2)) * width
    parts += book_row(-width / 2.0 + 0.03, split, y=y, z=-0.01, tall=0.27, rng=rng)
    parts += dressed(palette, rng=rng, y=y, width=width / 2.0 - split - 0.04, depth=depth,
                     share=0.9, x=(width / 2.0 + split) / 2.0)  # fmt: skip
    return piece("shelf", parts, (width, depth, 0.42))


def coat_rack(palette: Palette, *, rng: np.random.Generator, width: float = 0.8) -> Furniture:
    """A board with hooks and coats that hang from them."""
    depth, height = 0.22, 1.15
    back = -depth / 2.0
    board = box((width, 0.1, 0.022), (0.0, height - 0.05, back + 0.011), color=palette.wood,
                material="wood")  # fmt: skip
    parts: list[Part] = [board]
    count = int(width / 0.2)
    for k in range(count):
        x = (k + 0.5) * width / count - width / 2.0
        hook = [(x, height - 0.03, back + 0.02), (x, height - 0.05, back + 0.05),
                (x, height - 0.06, back + 0.075), (x, height - 0.035, back + 0.09)]  # fmt: skip
        parts += [tube(hook, 0.006, color=BLACK, segments=6),
                  ball(0.011, (x, height - 0.03, back + 0.092), color=BLACK,
                       segments=8)]  # fmt: skip
        if rng.random() < 0.75:
            inks = (palette.sofa, palette.accent, palette.dark_wood, DARK, palette.textile)
            parts.append(_coat(x, height - 0.06, back + 0.1, inks[int(rng.integers(5))], rng))
    return piece("coat rack", parts, (width, depth, height))


def _coat(x: float, top: float, z: float, color: np.ndarray, rng: np.random.Generator) -> Part:
    """A hanging coat as a soft flat bag."""
    drop, rows, around = float(rng.uniform(0.7, 0.95)), 7, 17
    t = np.linspace(0.0, 1.0, rows)
    half = np.array([0.02, 0.07, 0.085, 0.083, 0.088, 0.094, 0.097])
    deep = np.array([0.015, 0.045, 0.055, 0.055, 0.06, 0.065, 0.068])
    angle = np.linspace(0.0, 2.0 * np.pi, around)
    wave = 1.0 + 0.12 * np.sin(5.0 * angle)[None, :] * t[:, None]
    points = np.stack(
        [
            x + half[:, None] * np.sin(angle) * wave,
            np.broadcast_to((top - drop * t)[:, None], (rows, around)),
            z + deep[:, None] * np.cos(angle) * wave,
        ],
        axis=-1,
    )
    return two_sided(points[::-1], color=color, material="fabric", thickness=0.004)


def radiator(palette: Palette, *, rng: np.random.Generator, width: float = 1.0) -> Furniture:
    """A ribbed radiator that hangs low on a wall."""
    height, depth = 0.55, 0.1
    count = max(int(width / 0.06), 4)
    xs = (np.arange(count) + 0.5) * width / count - width / 2.0
    ribs = np.stack([xs, np.full(count, height / 2.0), np.full(count, 0.01)], axis=1)
    parts = [
        boxes(np.tile([0.7 * width / count, height, 0.07], (count, 1)), ribs, colors=WHITE),
        boxes([(width, 0.03, 0.03)] * 2, [(0.0, 0.06, -0.01), (0.0, height - 0.06, -0.01)],
              colors=WHITE * 0.97),
        boxes([(0.03, 0.03, 0.04)] * 2, [(s * width / 3.0, height - 0.06, -0.03) for s in (-1, 1)],
              colors=METAL),
    ]  # fmt: skip
    return piece("radiator", parts, (width, depth, height))


def tv(palette: Palette, *, rng: np.random.Generator, width: float = 1.2) -> Furniture:
    """A television on its foot."""
    tall = width * 0.57
    y = 0.06 + tall / 2.0
    parts = [
        box((0.4, 0.012, 0.22), (0.0, 0.006, 0.0), color=DARK),
        box((0.12, 0.08, 0.03), (0.0, 0.05, -0.02), color=DARK),
        box((width, tall, 0.035), (0.0, y, 0.0), color=DARK, step=0.2),
        box((width - 0.03, tall - 0.03, 0.004), (0.0, y, 0.0195), color=(0.29, 0.31, 0.34),
            step=0.15),
    ]  # fmt: skip
    return piece("tv", parts, (width, 0.22, 0.06 + tall))
