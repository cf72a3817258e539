"""Shelves, cabinets and dividers. Every piece stands on the floor and faces +Z."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, lathe
from affectsim_data.builders.homes.pieces import DARK, METAL, Furniture
from affectsim_data.builders.homes.tables import BOOK_INKS, table_legs, vase, wooden

__all__ = [
    "bookshelf",
    "cabinet_doors",
    "nightstand",
    "partition",
    "room_divider",
    "sideboard",
    "tv_stand",
    "wardrobe",
]


def _frame(
    width: float, height: float, depth: float, *, shelves: int, color: ArrayLike, back: bool
) -> list[Part]:
    """Sides, boards and, on request, the back of a shelf."""
    thick = 0.024
    side = (thick, height, depth)
    parts = [
        wooden(side, (sign * (width - thick) / 2.0, height / 2.0, 0.0), color)
        for sign in (-1.0, 1.0)
    ]
    for index in range(shelves + 1):
        y = 0.06 + (height - 0.06 - thick / 2.0) * index / shelves
        parts.append(wooden((width - 2.0 * thick, thick, depth), (0.0, y, 0.0), color))
    parts.append(wooden((width - 2.0 * thick, 0.06, depth - 0.03), (0.0, 0.03, 0.0), color))
    if back:
        size = (width - 2.0 * thick, height - 0.06, 0.01)
        parts.append(wooden(size, (0.0, height / 2.0 + 0.03, -depth / 2.0 + 0.008), color))
    return parts


def _books(
    start: float, end: float, *, y: float, z: float, tall: float, rng: np.random.Generator
) -> list[Part]:
    """A row of books between two x; the last few places stay empty or hold a lying pile."""
    parts, x = [], start
    stop = start + (end - start) * float(rng.uniform(0.55, 0.98))
    while x < stop - 0.05:
        thick, height = float(rng.uniform(0.018, 0.045)), tall * float(rng.uniform(0.68, 0.95))
        deep = float(rng.uniform(0.16, 0.21))
        ink = BOOK_INKS[int(rng.integers(len(BOOK_INKS)))] * float(rng.uniform(0.9, 1.08))
        parts.append(
            box((thick, height, deep), (x + thick / 2.0, y + height / 2.0, z),
                color=np.clip(ink, 0.0, 1.0), radius=0.0)
        )  # fmt: skip
        x += thick + 0.0015
    return parts


def bookshelf(palette: Palette, *, width: float, rng: np.random.Generator) -> Furniture:
    """A tall shelf filled with books."""
    height, depth, shelves = 1.9, 0.3, 5
    parts = _frame(width, height, depth, shelves=shelves, color=palette.wood, back=True)
    pitch = (height - 0.072) / shelves
    for index in range(shelves):
        y = 0.06 + pitch * index + 0.013
        limits = (-width / 2.0 + 0.04, width / 2.0 - 0.04)
        parts += _books(*limits, y=y, z=-0.01, tall=pitch - 0.04, rng=rng)
    return Furniture(tuple(parts), width, depth, height)


def room_divider(palette: Palette, *, width: float, rng: np.random.Generator) -> Furniture:
    """A free-standing shelf to 1.5 m, backed in the middle, with books and boxes on both sides."""
    height, depth, shelves = 1.5, 0.36, 4
    bays = max(round(width / 0.9), 1)
    bay = width / bays
    pitch = (height - 0.072) / shelves
    parts: list[Part] = []
    for index in range(bays):
        x = (index + 0.5) * bay - width / 2.0
        frame = _frame(bay - 0.002, height, depth, shelves=shelves, color=palette.wood, back=False)
        panel = wooden((bay - 0.05, height - 0.1, 0.012), (0.0, height / 2.0, 0.0), palette.wood)
        parts += [part.moved(x) for part in (*frame, panel)]
        for level in range(shelves):
            y, ends = 0.06 + pitch * level + 0.013, (-bay / 2.0 + 0.04, bay / 2.0 - 0.04)
            row = _shallow(ends, y, pitch - 0.05, palette, rng)
            behind = _shallow(ends, y, pitch - 0.05, palette, rng)
            parts += [part.moved(x) for part in row]
            parts += [part.moved(yaw=np.pi).moved(x) for part in behind]
    return Furniture(tuple(parts), width, depth, height)


def _shallow(
    ends: tuple[float, float], y: float, tall: float, palette: Palette, rng: np.random.Generator
) -> list[Part]:
    """What stands on one side of a divider's board: books, a storage box or a vase."""
    kind = rng.random()
    if kind < 0.3:
        size = (ends[1] - ends[0] - 0.04, tall * 0.85, 0.15)
        return [box(size, (0.0, y + size[1] / 2.0, 0.09), color=palette.textile,
                    material="fabric", radius=0.012, segments=2)]  # fmt: skip
    if kind < 0.45:
        return [vase(palette.accent, (float(rng.uniform(-0.2, 0.2)), y, 0.09))]
    books = _books(*ends, y=y, z=0.0, tall=tall, rng=rng)
    return [_thinner(book).moved(z=0.09) for book in books]


def _thinner(book: Part) -> Part:
    positions = book.positions.copy()
    positions[:, 2] *= 0.7
    return dataclasses.replace(book, positions=positions)


def partition(palette: Palette, *, width: float) -> Furniture:
    """A half-height wall with a wooden cap."""
    height, depth = 1.1, 0.16
    parts = [
        box((width, height - 0.04, depth), (0.0, (height - 0.04) / 2.0, 0.0),
            color=palette.accent_wall, material="paint", radius=0.004, step=0.22),
        wooden((width + 0.03, 0.04, depth + 0.06), (0.0, height - 0.02, 0.0), palette.wood),
        box((width + 0.02, 0.08, depth + 0.024), (0.0, 0.04, 0.0), color=(0.93, 0.92, 0.9)),
    ]  # fmt: skip
    return Furniture(tuple(parts), width + 0.03, depth + 0.06, height)


def cabinet_doors(
    width: float, y0: float, y1: float, z: float, *, count: int, color: ArrayLike
) -> list[Part]:
    """Cabinet fronts side by side with bar handles."""
    parts, each, middle = [], width / count, (y0 + y1) / 2.0
    for index in range(count):
        x = (index + 0.5) * each - width / 2.0
        inward = 1.0 if index % 2 == 0 else -1.0
        grip = x + inward * (each / 2.0 - 0.05)
        parts.append(box((each - 0.006, y1 - y0, 0.02), (x, middle, z + 0.01), color=color))
        size = (0.014, min(0.18, 0.5 * (y1 - y0)), 0.018)
        parts.append(box(size, (grip, middle, z + 0.03), color=METAL))
    return parts


def wardrobe(palette: Palette, *, width: float) -> Furniture:
    """A wardrobe with hinged doors."""
    height, depth = 2.05, 0.6
    count = max(round(width / 0.5), 2)
    parts = [
        box((width, height - 0.06, depth - 0.03), (0.0, height / 2.0 + 0.03, -0.015),
            color=palette.cabinet),
        box((width - 0.04, 0.06, depth - 0.08), (0.0, 0.03, -0.015), color=palette.dark_wood),
        *cabinet_doors(width - 0.02, 0.09, height - 0.03, depth / 2.0 - 0.03, count=count,
                color=palette.cabinet),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, height)


def sideboard(palette: Palette, *, width: float = 1.5) -> Furniture:
    """A low cabinet on legs with a vase on top."""
    height, depth = 0.78, 0.42
    parts = [
        wooden((width, height - 0.16, depth - 0.02), (0.0, height / 2.0 + 0.08, -0.01),
                palette.wood),
        *cabinet_doors(width - 0.06, 0.19, height - 0.04, depth / 2.0 - 0.02, count=3,
                color=palette.cabinet),
        *table_legs(width, depth, 0.16, thick=0.04, color=palette.dark_wood),
        vase(palette.accent, (width / 2.0 - 0.3, height, 0.0)),
        box((0.26, 0.035, 0.2), (-0.3, height + 0.0175, 0.0), color=BOOK_INKS[0]),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, height)


def nightstand(palette: Palette) -> Furniture:
    """A small cabinet with a lamp."""
    size, height = 0.44, 0.5
    parts = [
        wooden((size, height - 0.12, 0.38), (0.0, height / 2.0 + 0.06, 0.0), palette.wood),
        *cabinet_doors(size - 0.03, 0.15, height - 0.03, 0.19, count=1, color=palette.cabinet),
        *table_legs(size, 0.4, 0.12, thick=0.035, color=palette.dark_wood),
        lathe([(0.06, 0.0), (0.055, 0.015), (0.012, 0.02), (0.012, 0.22)], color=METAL,
              center=(0.0, height, 0.0), segments=18),
        lathe([(0.12, 0.2), (0.085, 0.38)], color=(1.0, 0.95, 0.85), material="lamp",
              center=(0.0, height, 0.0), segments=24),
        lathe([(0.085, 0.38), (0.0, 0.38)], color=(1.0, 0.95, 0.85), material="lamp",
              center=(0.0, height, 0.0), segments=24),
        lathe([(0.0, 0.2), (0.12, 0.2)], color=(0.9, 0.85, 0.75), material="lamp",
              center=(0.0, height, 0.0), segments=24),
    ]  # fmt: skip
    return Furniture(tuple(parts), size, 0.42, 0.9, lamp_y=height + 0.3)


def tv_stand(palette: Palette, *, width: float = 1.6) -> Furniture:
    """A low board with a television on it."""
    height, depth = 0.46, 0.42
    screen_y = height + 0.48
    parts = [
        wooden((width, height - 0.1, depth - 0.02), (0.0, height / 2.0 + 0.05, -0.01),
                palette.wood),
        *cabinet_doors(width - 0.04, 0.13, height - 0.03, depth / 2.0 - 0.02, count=4,
                color=palette.cabinet),
        box((width - 0.1, 0.1, depth - 0.1), (0.0, 0.05, -0.01), color=palette.dark_wood),
        box((0.5, 0.012, 0.22), (0.0, height + 0.006, 0.0), color=DARK),
        box((0.12, 0.1, 0.03), (0.0, height + 0.05, -0.02), color=DARK),
        box((1.26, 0.73, 0.035), (0.0, screen_y, 0.0), color=DARK, step=0.2),
        box((1.22, 0.69, 0.004), (0.0, screen_y, 0.019), color=(0.29, 0.31, 0.34), step=0.15),
        vase(palette.accent, (width / 2.0 - 0.14, height, 0.02)),
    ]  # fmt: skip
    return Furniture(tuple(parts), width, depth, 1.35)
