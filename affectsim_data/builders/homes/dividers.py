"""What divides a large room or stands out in it: shelves and half walls, a piano, a fireplace."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import frame, wooden
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes
from affectsim_data.builders.homes.pieces import BLACK, DARK, WHITE, Furniture, Top, piece
from affectsim_data.builders.homes.shapes import tube
from affectsim_data.builders.homes.storage import shelved
from affectsim_data.builders.homes.trinkets import dressed

__all__ = ["fireplace", "folding_screen", "partition", "piano", "room_divider"]


def room_divider(palette: Palette, *, rng: np.random.Generator, width: float = 1.8) -> Furniture:
    """A free-standing shelf, backed in the middle, with books and boxes on both sides."""
    height, depth, shelves = 1.5, 0.4, 4
    bays = max(round(width / 0.9), 1)
    bay = width / bays
    pitch = (height - 0.072) / shelves
    color = palette.wood if rng.random() < 0.6 else palette.cabinet
    parts: list[Part] = []
    for index in range(bays):
        x = (index + 0.5) * bay - width / 2.0
        body = frame(bay - 0.002, height, depth, shelves=shelves, color=color, back=False)
        panel = wooden((bay - 0.052, height - 0.08, 0.012), (0.0, height / 2.0 + 0.02, 0.0), color)
        parts += [part.moved(x) for part in (*body, panel)]
        for level in range(shelves):
            y, ends = 0.073 + pitch * level, (-bay / 2.0 + 0.04, bay / 2.0 - 0.04)
            for turn in (0.0, np.pi):
                row = shelved(ends, y, pitch - 0.05, palette, rng, z=0.1, deep=0.16)
                inside = [part for part in row if float(part.positions[:, 2].min()) > 0.008]
                parts += [part.moved(yaw=turn).moved(x) for part in inside]
    return piece("divider", parts, (width, depth, height))


def partition(palette: Palette, *, rng: np.random.Generator, width: float = 1.8) -> Furniture:
    """A half-height wall with a wooden cap."""
    height, depth = float(rng.uniform(1.05, 1.25)), 0.16
    parts = [
        box((width, height - 0.04, depth), (0.0, (height - 0.04) / 2.0, 0.0),
            color=palette.accent_wall, material="paint", radius=0.0, step=0.22),
        wooden((width + 0.03, 0.04, depth + 0.06), (0.0, height - 0.02, 0.0), palette.wood),
        box((width + 0.02, 0.08, depth + 0.024), (0.0, 0.04, 0.0), color=(0.93, 0.92, 0.9)),
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth, share=0.25),
    ]  # fmt: skip
    return piece("divider", parts, (width + 0.03, depth + 0.06, height))


def folding_screen(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """Three cloth panels in wooden frames, standing in a zigzag."""
    height, wide, lean = 1.7, 0.5, 0.42
    step = wide * float(np.cos(lean))
    rise = wide * float(np.sin(lean)) / 2.0
    parts: list[Part] = []
    for k in range(3):
        panel = [
            box((wide - 0.05, height - 0.16, 0.012), (0.0, height / 2.0 + 0.02, 0.0),
                color=palette.textile, material="fabric", step=0.3),
            boxes([(0.03, height, 0.03)] * 2 + [(wide - 0.06, 0.04, 0.026)] * 2,
                  [(-wide / 2.0 + 0.016, height / 2.0, 0.0),
                   (wide / 2.0 - 0.016, height / 2.0, 0.0), (0.0, 0.1, 0.0),
                   (0.0, height - 0.025, 0.0)],
                  colors=palette.dark_wood, material="wood"),
        ]  # fmt: skip
        turn = lean if k % 2 == 0 else -lean
        parts += [part.moved(yaw=turn).moved((k - 1.0) * (step + 0.012)) for part in panel]
    return piece("divider", parts, (3.0 * step + 0.06, 2.0 * rise + 0.06, height))


def piano(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """An upright piano."""
    width, height, depth = 1.46, 1.18, 0.6
    color = BLACK * 1.15 if rng.random() < 0.5 else palette.dark_wood
    back = -depth / 2.0
    parts = [
        wooden((width - 0.06, height - 0.03, 0.3), (0.0, (height - 0.03) / 2.0, back + 0.16),
               color),
        wooden((width, 0.03, 0.36), (0.0, height - 0.015, back + 0.185), color),
        wooden((width - 0.06, 0.1, 0.28), (0.0, 0.65, 0.145), color),
        wooden((width - 0.24, 0.16, 0.02), (0.0, 0.86, 0.022), color),
        *dressed(palette, rng=rng, y=height, width=width - 0.2, depth=0.3, z=back + 0.185,
                 share=0.5),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.035)
        parts += [
            wooden((0.05, 0.1, 0.5), (x, 0.05, 0.04), color),
            wooden((0.06, 0.6, 0.06), (x, 0.39, 0.24), color),
            wooden((0.06, 0.13, 0.3), (x, 0.7, 0.14), color),
        ]
    keys = np.arange(52)
    xs = (keys - 25.5) * 0.0235
    white = np.stack([xs, np.full(52, 0.71), np.full(52, 0.2)], axis=1)
    parts.append(boxes(np.tile([0.0222, 0.02, 0.145], (52, 1)), white, colors=WHITE))
    black = xs[np.isin(keys % 7, (0, 2, 3, 5, 6))] + 0.01175
    high = np.stack([black, np.full(len(black), 0.726), np.full(len(black), 0.175)], axis=1)
    parts.append(boxes(np.tile([0.012, 0.014, 0.09], (len(black), 1)), high, colors=BLACK * 0.8))
    sheets = box((0.42, 0.3, 0.004), (0.0, 0.94, 0.04), color=WHITE).tilted(
        -0.15, pivot=(0.0, 0.8, 0.04)
    )
    parts.append(sheets)
    return piece("piano", parts, (width, depth, height))


def fireplace(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A chimney breast's foot: mantel, surround, and logs in the hearth."""
    width, height, depth = 1.4, 1.12, 0.36
    stone = np.array([0.86, 0.84, 0.8]) if rng.random() < 0.6 else palette.accent_wall
    side, opening = 0.28, 0.72
    inner = width - 2.0 * side
    back = -depth / 2.0
    parts: list[Part] = [
        box((side, height - 0.06, depth - 0.06), (x, (height - 0.06) / 2.0, -0.03), color=stone,
            material="stone", step=0.25)
        for x in (-(width - side) / 2.0, (width - side) / 2.0)
    ]  # fmt: skip
    parts += [
        box((inner, height - 0.06 - opening, depth - 0.06),
            (0.0, (height - 0.06 + opening) / 2.0, -0.03), color=stone, material="stone",
            step=0.25),
        box((width + 0.1, 0.06, depth), (0.0, height - 0.03, 0.0), color=palette.wood,
            material="wood", radius=0.01),
        box((inner, opening, 0.04), (0.0, opening / 2.0, back + 0.02), color=DARK, step=0.2),
        box((inner, 0.04, depth - 0.06), (0.0, 0.02, -0.03), color=DARK * 1.3),
        *dressed(palette, rng=rng, y=height, width=width, depth=depth, share=0.7),
    ]  # fmt: skip
    for k, (x, y) in enumerate(
        ((-0.12, 0.1), (0.04, 0.1), (0.18, 0.1), (-0.04, 0.19), (0.1, 0.19))
    ):
        z = -0.06 + 0.02 * (k % 2)
        log = [(x - 0.03, y, z - 0.12), (x, y, z), (x + 0.02, y, z + 0.12)]
        parts.append(tube(log, 0.05, color=palette.dark_wood * 1.1, material="wood", segments=10))
    for sign in (-1.0, 1.0):
        bar = [(sign * 0.2, 0.047, -0.2), (sign * 0.2, 0.047, 0.0), (sign * 0.2, 0.047, 0.1)]
        parts.append(tube(bar, 0.008, color=BLACK))
    return piece("fireplace", parts, (width + 0.1, depth, height), tops=[Top(height, 1.0, 0.2)])
