"""Shelves, wardrobes and cabinets that stand against walls."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import (
    cabinet_doors,
    drawers,
    frame,
    legs,
    posts,
    spread_legs,
    wooden,
)
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes
from affectsim_data.builders.homes.pieces import BLACK, METAL, Furniture, Top, piece
from affectsim_data.builders.homes.shapes import cushion, tube
from affectsim_data.builders.homes.trinkets import book_row, books, dressed

__all__ = [
    "bookshelf", "cube_shelf", "dresser", "glass_cabinet", "ladder_shelf", "laundry_basket",
    "nightstand",
    "nightstand_open", "shelved", "shoe_cabinet", "sideboard", "sideboard_open", "tv_board",
    "tv_frame",
    "wardrobe", "wardrobe_sliding",
]  # fmt: skip

_GRIPS = ("bar", "knob", "none")


def _grip(rng: np.random.Generator) -> str:
    return _GRIPS[int(rng.integers(len(_GRIPS)))]


def shelved(
    ends: tuple[float, float], y: float, tall: float, palette: Palette, rng: np.random.Generator,
    *, z: float = 0.0, deep: float = 0.2,
) -> list[Part]:  # fmt: skip
    """What stands on one board of a shelf: books, a box, or small things."""
    kind, width = float(rng.random()), ends[1] - ends[0]
    middle = (ends[0] + ends[1]) / 2.0
    if kind < 0.55:
        return book_row(*ends, y=y, z=z, tall=tall, rng=rng, deep=deep)
    if kind < 0.68 and width > 0.25:
        size = (min(width - 0.05, 0.5), tall * 0.8, deep - 0.02)
        return [box(size, (middle, y + size[1] / 2.0, z), color=palette.textile, material="fabric",
                    radius=0.012, segments=2)]  # fmt: skip
    if kind < 0.92:
        row = dressed(palette, rng=rng, y=y, width=width, depth=deep, share=0.8, x=middle, z=z)
        return [part for part in row if float(part.positions[:, 1].max()) < y + tall]
    return []


def bookshelf(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A tall closed shelf filled with books."""
    height, depth = float(rng.uniform(1.8, 2.05)), float(rng.uniform(0.28, 0.32))
    shelves = int(rng.integers(5, 7))
    color = palette.wood if rng.random() < 0.6 else palette.cabinet
    parts = frame(width, height, depth, shelves=shelves, color=color, back=True)
    pitch = (height - 0.072) / shelves
    ends = (-width / 2.0 + 0.03, width / 2.0 - 0.03)
    for index in range(shelves):
        y = 0.072 + pitch * index
        parts += shelved(ends, y, pitch - 0.045, palette, rng, deep=depth - 0.06)
    return piece("shelf", parts, (width, depth, height))


def ladder_shelf(palette: Palette, *, rng: np.random.Generator, width: float = 0.85) -> Furniture:
    """Open boards in a steel frame."""
    height, depth, levels = float(rng.uniform(1.6, 1.9)), 0.34, 5
    side, z = width / 2.0 - 0.012, depth / 2.0 - 0.012
    parts: list[Part] = [
        posts([-side, -side, side, side], [-z, z, -z, z], y=(0.0, height), thick=0.022,
              color=BLACK, material="plain"),
    ]  # fmt: skip
    rows = 0.12 + (height - 0.16) * np.arange(levels) / (levels - 1)
    parts.append(
        boxes(np.tile([width - 0.05, 0.024, depth - 0.002], (levels, 1)),
              np.stack([0.0 * rows, rows, 0.0 * rows], 1), colors=palette.wood, material="wood")
    )  # fmt: skip
    bars = np.tile([0.016, 0.014, depth - 0.03], (2 * levels, 1))
    middles = [(s * side, float(y) - 0.02, 0.0) for y in rows for s in (-1.0, 1.0)]
    parts.append(boxes(bars, middles, colors=BLACK))
    pitch = float(rows[1] - rows[0])
    for y in rows[:-1]:
        parts += shelved((-width / 2.0 + 0.06, width / 2.0 - 0.06), float(y) + 0.012, pitch - 0.07,
                         palette, rng, deep=depth - 0.1)  # fmt: skip
    return piece("shelf", parts, (width, depth, height))


def cube_shelf(
    palette: Palette, *, rng: np.random.Generator, columns: int = 2, rows: int = 4
) -> Furniture:
    """Square compartments with books, baskets and things."""
    cell, depth, thick = 0.37, 0.38, 0.03
    width, height = columns * cell + thick, rows * cell + thick
    color = palette.cabinet if rng.random() < 0.6 else palette.wood
    xs = (np.arange(columns + 1) - columns / 2.0) * cell
    ys = np.arange(rows + 1) * cell + thick / 2.0
    uprights = np.stack([xs, np.full(columns + 1, height / 2.0), 0.0 * xs], axis=1)
    boards = np.array([((x + cell / 2.0), y, 0.0) for x in xs[:-1] for y in ys])
    parts = [
        boxes(np.tile([thick, height, depth], (columns + 1, 1)), uprights, colors=color),
        boxes(np.tile([cell - thick, thick, depth - 0.004], (len(boards), 1)), boards,
              colors=color),
        box((width - 0.01, height - 0.01, 0.006), (0.0, height / 2.0, -depth / 2.0 + 0.006),
            color=color * 0.96, step=0.4),
    ]  # fmt: skip
    for x in xs[:-1]:
        for y in ys[:-1]:
            low, ends = float(y) + thick / 2.0, (float(x) + 0.025, float(x) + cell - 0.025)
            if rng.random() < 0.3:
                tint = palette.textile * float(rng.uniform(0.85, 1.0))
                size = (cell - thick - 0.03, cell - thick - 0.05, depth - 0.06)
                at = (float(x) + cell / 2.0, low + size[1] / 2.0, 0.01)
                parts.append(box(size, at, color=tint, material="fabric", radius=0.012, segments=2))
                grip = (0.1, 0.02, 0.012)
                parts.append(box(grip, (at[0], at[1] + 0.08, 0.172), color=tint * 0.7))
            else:
                parts += shelved(ends, low, cell - thick - 0.03, palette, rng, deep=0.26)
    parts += dressed(palette, rng=rng, y=height, width=width - 0.05, depth=depth, share=0.5)
    return piece("shelf", parts, (width, depth, height))


def glass_cabinet(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A cabinet: doors below, boards with china above."""
    height, depth, split = 1.95, 0.4, 0.8
    lower = box((width, split - 0.08, depth - 0.03), (0.0, (split + 0.08) / 2.0, -0.015),
                color=palette.cabinet)  # fmt: skip
    upper = frame(width - 0.02, height - split, depth - 0.1, shelves=3, color=palette.cabinet,
                  back=True, foot=0.012)  # fmt: skip
    pitch = (height - split - 0.024) / 3.0
    parts = [
        lower,
        wooden((width + 0.02, 0.025, depth), (0.0, split + 0.0125, 0.0), palette.wood),
        box((width - 0.06, 0.08, depth - 0.1), (0.0, 0.04, -0.02), color=palette.dark_wood),
        *cabinet_doors(width - 0.02, 0.1, split - 0.02, depth / 2.0 - 0.03, count=2,
                       color=palette.cabinet, grip=_grip(rng)),
        *(part.moved(0.0, split + 0.025, -0.048) for part in upper),
    ]  # fmt: skip
    ends = (-width / 2.0 + 0.06, width / 2.0 - 0.06)
    for index in range(3):
        y = split + 0.025 + 0.024 + pitch * index
        row = dressed(
            palette, rng=rng, y=y, width=ends[1] - ends[0], depth=0.24, share=0.9, z=-0.04
        )
        parts += [part for part in row if float(part.positions[:, 1].max()) < y + pitch - 0.04]
    return piece("cabinet", parts, (width + 0.02, depth, height + 0.025))


def wardrobe(palette: Palette, *, rng: np.random.Generator, width: float = 1.5) -> Furniture:
    """A wardrobe with hinged doors."""
    height, depth = float(rng.uniform(1.95, 2.15)), 0.6
    count = max(round(width / 0.5), 1)
    color = palette.cabinet if rng.random() < 0.6 else palette.wood
    material = "wood" if color is palette.wood else "plain"
    parts = [
        box((width, height - 0.08, depth - 0.03), (0.0, height / 2.0 + 0.02, -0.015), color=color,
            material=material),
        box((width + 0.008, 0.02, depth), (0.0, height - 0.01, 0.0), color=color * 0.96,
            material=material),
        box((width - 0.04, 0.06, depth - 0.08), (0.0, 0.03, -0.015), color=palette.dark_wood),
        *cabinet_doors(width - 0.02, 0.08, height - 0.04, depth / 2.0 - 0.03, count=count,
                       color=color * 1.01, grip="bar" if rng.random() < 0.6 else "knob"),
    ]  # fmt: skip
    if rng.random() < 0.5:
        each = (width - 0.02) / count
        for k in range(count):
            x = (k + 0.5) * each - (width - 0.02) / 2.0
            for y, tall in ((0.32 * height, 0.36 * height), (0.74 * height, 0.36 * height)):
                panel = (each - 0.15, tall, 0.006)
                parts.append(box(panel, (x, y, depth / 2.0 - 0.008), color=color * 0.97))
    return piece("wardrobe", parts, (width + 0.01, depth + 0.03, height))


def wardrobe_sliding(
    palette: Palette, *, rng: np.random.Generator, width: float = 1.8
) -> Furniture:
    """A wardrobe with two sliding doors, one of them with a looking-glass."""
    height, depth, each = 2.15, 0.62, width / 2.0
    color = palette.wood
    tall = height - 0.1
    parts = [
        wooden((width, height, depth - 0.08), (0.0, height / 2.0, -0.04), color),
        boxes([(width, 0.04, 0.07), (width, 0.04, 0.07)],
              [(0.0, height - 0.02, depth / 2.0 - 0.047), (0.0, 0.02, depth / 2.0 - 0.047)],
              colors=METAL),
        box((each + 0.02, tall, 0.018), (-each / 2.0 + 0.01, height / 2.0, depth / 2.0 - 0.07),
            color=palette.cabinet),
        box((each + 0.02, tall, 0.018), (each / 2.0 - 0.01, height / 2.0, depth / 2.0 - 0.04),
            color=palette.cabinet),
    ]  # fmt: skip
    glass = (each - 0.1, tall - 0.16, 0.005)
    parts.append(box(glass, (each / 2.0 - 0.01, height / 2.0, depth / 2.0 - 0.029),
                     color=(0.78, 0.83, 0.85), step=0.3))  # fmt: skip
    return piece("wardrobe", parts, (width, depth, height))


def dresser(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A chest of drawers with small things on it."""
    rows, depth = int(rng.integers(3, 5)), 0.45
    height = 0.12 + 0.2 * rows + 0.03
    color = palette.cabinet if rng.random() < 0.5 else palette.wood
    parts = [
        box((width - 0.02, height - 0.13, depth - 0.04), (0.0, (height + 0.09) / 2.0, -0.02),
            color=color),
        wooden((width, 0.025, depth), (0.0, height - 0.0125, 0.0), palette.wood),
        *legs(width, depth - 0.04, 0.11, thick=0.045, color=palette.dark_wood, inset=0.02),
        *dressed(palette, rng=rng, y=height, width=width - 0.05, depth=depth, share=0.6),
    ]  # fmt: skip
    columns, grip = (2 if width > 0.85 else 1), _grip(rng)
    for k in range(columns):
        each = (width - 0.05) / columns
        x = (k + 0.5) * each - (width - 0.05) / 2.0
        parts += drawers(each, 0.13, height - 0.04, depth / 2.0 - 0.04, count=rows, color=color,
                         x=x, grip="bar" if grip == "none" else grip)  # fmt: skip
    return piece("cabinet", parts, (width, depth, height), tops=[Top(height, width - 0.1, 0.3)])


def sideboard(palette: Palette, *, rng: np.random.Generator, width: float = 1.5) -> Furniture:
    """A low cabinet on legs with small things on it."""
    height, depth = float(rng.uniform(0.74, 0.84)), 0.42
    count = max(round(width / 0.5), 1)
    parts = [
        wooden((width, height - 0.17, depth - 0.02), (0.0, height / 2.0 + 0.085, -0.01),
               palette.wood),
        *cabinet_doors(width - 0.06, 0.2, height - 0.04, depth / 2.0 - 0.02, count=count,
                       color=palette.cabinet, grip=_grip(rng)),
        *spread_legs(width - 0.14, depth - 0.1, 0.175, color=palette.dark_wood, spread=0.02),
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth, share=0.6),
    ]  # fmt: skip
    return piece("cabinet", parts, (width, depth + 0.02, height))


def sideboard_open(palette: Palette, *, rng: np.random.Generator, width: float = 1.4) -> Furniture:
    """A low cabinet, half of it open boards with books."""
    height, depth, half = 0.78, 0.4, width / 2.0
    body = frame(half, height, depth, shelves=2, color=palette.wood, back=True)
    parts = [part.moved(-half / 2.0) for part in body]
    pitch = (height - 0.072) / 2.0
    for k in range(2):
        parts += shelved((-half + 0.03, -0.03), 0.072 + pitch * k, pitch - 0.045, palette, rng,
                         deep=0.26)  # fmt: skip
    parts += [
        wooden((half - 0.001, height, depth - 0.025), (half / 2.0 + 0.0005, height / 2.0, -0.0125),
               palette.wood),
        *drawers(half - 0.03, 0.05, height - 0.02, depth / 2.0 - 0.025, count=3,
                 color=palette.cabinet, x=half / 2.0),
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth - 0.05, share=0.6),
    ]  # fmt: skip
    return piece("cabinet", parts, (width, depth + 0.04, height))


def shoe_cabinet(palette: Palette, *, rng: np.random.Generator, width: float = 0.8) -> Furniture:
    """A shallow cabinet with tilting fronts."""
    height, depth = 1.0, 0.26
    parts = [
        box((width, height - 0.03, depth - 0.03), (0.0, (height - 0.03) / 2.0, -0.015),
            color=palette.cabinet),
        wooden((width + 0.01, 0.03, depth), (0.0, height - 0.015, 0.0), palette.wood),
        *drawers(width - 0.02, 0.06, height - 0.04, depth / 2.0 - 0.03, count=2,
                 color=palette.cabinet, grip="knob"),
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth, share=0.5),
    ]  # fmt: skip
    return piece("cabinet", parts, (width + 0.01, depth + 0.02, height))


def nightstand(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small cabinet with a drawer."""
    size, height = 0.44, float(rng.uniform(0.48, 0.55))
    parts = [
        wooden((size, height - 0.13, 0.38), (0.0, height / 2.0 + 0.065, 0.0), palette.wood),
        *drawers(size - 0.03, 0.16, height - 0.03, 0.19, count=int(rng.integers(1, 3)),
                 color=palette.cabinet, grip="knob"),
        *legs(size, 0.38, 0.14, thick=0.035, color=palette.dark_wood),
    ]  # fmt: skip
    return piece("cabinet", parts, (size, 0.46, height), tops=[Top(height, 0.34, 0.3)])


def nightstand_open(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small open table with a board for books."""
    size, height, depth = 0.42, 0.52, 0.38
    parts = [
        wooden((size, 0.024, depth), (0.0, height - 0.012, 0.0), palette.wood),
        wooden((size - 0.05, 0.02, depth - 0.05), (0.0, 0.2, 0.0), palette.wood),
        *legs(size, depth, height - 0.022, thick=0.03, color=palette.wood, inset=0.01),
        *[part.moved(0.0, 0.21, 0.0) for part in books(rng=rng)],
    ]
    return piece("table", parts, (size, depth, height), tops=[Top(height, 0.34, 0.3)])


def tv_board(palette: Palette, *, rng: np.random.Generator, width: float = 1.6) -> Furniture:
    """A long low board with doors."""
    height, depth = float(rng.uniform(0.42, 0.5)), 0.42
    parts = [
        wooden((width, height - 0.1, depth - 0.02), (0.0, height / 2.0 + 0.05, -0.01),
               palette.wood),
        *cabinet_doors(width - 0.04, 0.13, height - 0.03, depth / 2.0 - 0.02,
                       count=max(round(width / 0.45), 2), color=palette.cabinet, grip="none"),
        box((width - 0.1, 0.1, depth - 0.1), (0.0, 0.05, -0.01), color=palette.dark_wood),
        *dressed(palette, rng=rng, y=height, width=width - 0.04, depth=depth, share=0.8,
                 keep=(-0.66, 0.66)),
    ]  # fmt: skip
    return piece("cabinet", parts, (width, depth, height), tops=[Top(height, 1.3, depth)])


def tv_frame(palette: Palette, *, rng: np.random.Generator, width: float = 1.5) -> Furniture:
    """An open low frame with boards for boxes and books."""
    height, depth = 0.48, 0.4
    x, z = width / 2.0 - 0.02, depth / 2.0 - 0.02
    parts = [
        wooden((width, 0.03, depth), (0.0, height - 0.015, 0.0), palette.wood),
        wooden((width - 0.06, 0.025, depth - 0.02), (0.0, 0.14, 0.0), palette.wood),
        posts([-x, -x, x, x, 0.0], [-z, z, -z, z, -z], y=(0.0, height - 0.028), thick=0.03,
              color=BLACK, material="plain"),
        box((0.42, 0.06, 0.26), (-0.3, 0.1825, 0.02), color=BLACK * 1.2),
        *book_row(0.1, width / 2.0 - 0.1, y=0.1525, z=0.03, tall=0.24, rng=rng),
        *dressed(palette, rng=rng, y=height, width=width - 0.04, depth=depth, share=0.8,
                 keep=(-0.66, 0.66)),
    ]  # fmt: skip
    return piece("cabinet", parts, (width, depth, height), tops=[Top(height, 1.3, depth)])


def laundry_basket(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A stuffed cloth basket with two loops."""
    parts: list[Part] = [
        cushion((0.4, 0.5, 0.34), (0.0, 0.25, 0.0), color=palette.textile, radius=0.05, puff=0.02,
                axis=0),
    ]  # fmt: skip
    angle = np.linspace(0.0, np.pi, 9)
    for sign in (-1.0, 1.0):
        loop = np.stack(
            [np.full(9, sign * 0.19), 0.47 + 0.07 * np.sin(angle), 0.06 * np.cos(angle)], axis=1
        )
        parts.append(tube(loop, 0.009, color=palette.dark_wood))
    return piece("basket", parts, (0.45, 0.36, 0.55))
