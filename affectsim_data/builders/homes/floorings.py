"""Textures of hard floors, tiled walls, worktops and wood. Each makes one variant per call."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.patterns import (
    Image,
    choose,
    colored,
    grain,
    grey,
    noise,
    scattered,
    speckled,
)
from affectsim_data.poses import FloatArray

__all__ = ["marble", "metal", "planks", "stone", "tiles", "wall_tiles", "wood"]

_GAP = 0.17
"""Darkness of the joint between two boards."""


def wood(rng: np.random.Generator) -> Image:
    """Oak, walnut, pine, ash or beech, over 0.7 m."""
    kind, shape = choose(rng, 5), (256, 192)
    base, tint = 0.92, (1.0, 0.985, 0.96)
    if kind == 0:
        image = base + grain(rng, shape, rings=9.0, figure=0.5, depth=0.03)
    elif kind == 1:
        shade = noise(rng, shape, reach=(40.0, 90.0))
        image = 0.89 + grain(rng, shape, rings=6.0, figure=1.1, depth=0.04) + 0.025 * shade
        tint = (1.0, 0.97, 0.93)
    elif kind == 2:
        image = 0.93 + grain(rng, shape, rings=7.0, figure=0.7, depth=0.035, fibre=0.012)
        image -= _knots(rng, shape)
        tint = (1.0, 0.98, 0.93)
    elif kind == 3:
        image = 0.92 + grain(rng, shape, rings=14.0, figure=0.8, depth=0.035, fibre=0.03)
    else:
        flecks = noise(rng, shape, reach=(1.0, 7.0))
        image = 0.93 + grain(rng, shape, rings=5.0, depth=0.01) - 0.02 * (flecks > 1.4)
        tint = (1.0, 0.975, 0.955)
    return grey(image, tint=tint)


def _knots(rng: np.random.Generator, shape: tuple[int, int]) -> FloatArray:
    """Dark ovals in pine."""
    down, across = np.mgrid[0 : shape[0], 0 : shape[1]]
    dark = np.zeros(shape)
    for _ in range(4):
        y, x = rng.uniform(0.0, shape[0]), rng.uniform(0.0, shape[1])
        v = (down - y + shape[0] / 2.0) % shape[0] - shape[0] / 2.0
        u = (across - x + shape[1] / 2.0) % shape[1] - shape[1] / 2.0
        far = np.hypot(v, u / 1.5) / float(rng.uniform(4.0, 7.0))
        dark += 0.2 * np.exp(-(far**2)) + 0.04 * np.exp(-((far - 1.8) ** 2) * 3.0)
    return dark


def planks(rng: np.random.Generator) -> Image:
    """Narrow or wide boards, herringbone, or mosaic parquet, over 1.28 m."""
    kind = choose(rng, 5)
    if kind < 3:
        return _boards(rng, boards=(8, 6, 10)[kind])
    return _herringbone(rng) if kind == 3 else _mosaic(rng)


def _boards(rng: np.random.Generator, *, boards: int) -> Image:
    """Boards along u, each with two ends."""
    size = 384 - 384 % boards
    height = size // boards
    figure = grain(rng, size, rings=float(boards), figure=0.8, depth=0.03)
    image = np.zeros((size, size))
    for board in range(boards):
        rows = slice(board * height, (board + 1) * height)
        start = int(rng.integers(size))
        ends = (start + np.array([0, size // 2 + int(rng.integers(-50, 50))])) % size
        shade = 0.055 * rng.uniform(-1.0, 1.0, size=2)
        first = (np.arange(size) - ends[0]) % size < (ends[1] - ends[0]) % size
        figures = np.roll(figure[rows], int(rng.integers(size)), axis=1)
        image[rows] = 0.9 + np.where(first, shade[0], shade[1]) + figures
        image[rows, ends] -= _GAP
        image[rows.start] -= _GAP
    return grey(image, tint=(1.0, 0.98, 0.95))


def _herringbone(rng: np.random.Generator) -> Image:
    """Blocks of 1 to 4, laid in a zigzag."""
    width, cells = 24, 16
    size = cells * width
    y, x = np.mgrid[0:size, 0:size]
    j, i = y // width, x // width
    # The zigzag repeats after eight widths: four of a level block, four of an upright one.
    step = (i - j) % 8
    level = step < 4
    start = np.where(level, i - step, j - (7 - step)) % cells
    block = np.where(level, 0, cells**2) + start * cells + np.where(level, j, i)
    along = (np.where(level, x, y) - start * width) % size
    crosswise = np.where(level, y, x) % width
    shades = 0.06 * rng.uniform(-1.0, 1.0, 2 * cells**2)
    figure = grain(rng, (width, size), rings=1.0, figure=0.5, depth=0.02)
    shifts = rng.integers(size, size=2 * cells**2)
    image = 0.9 + shades[block] + figure[crosswise, (along + shifts[block]) % size]
    image -= 0.8 * _GAP * ((crosswise == 0) | (along == 0))
    return grey(image, tint=(1.0, 0.98, 0.95))


def _mosaic(rng: np.random.Generator) -> Image:
    """Squares of five strips each, every other one turned."""
    strips, width, squares = 5, 12, 6
    cell = strips * width
    size = squares * cell
    down, across = np.mgrid[0:size, 0:size]
    row, column = down // cell, across // cell
    turned = (row + column) % 2 == 1
    along, crosswise = np.where(turned, down, across) % cell, np.where(turned, across, down) % cell
    strip = (row * squares + column) * strips + crosswise // width
    shades = 0.05 * rng.uniform(-1.0, 1.0, squares * squares * strips)
    figure = grain(rng, (cell, cell), rings=5.0, figure=0.4, depth=0.02)
    image = 0.9 + shades[strip] + figure[crosswise, (along + 7 * strip) % cell]
    image -= 0.6 * _GAP * ((crosswise % width == 0) | (along == 0))
    return grey(image, tint=(1.0, 0.98, 0.95))


def tiles(rng: np.random.Generator) -> Image:
    """Square, long, chequered or small tiles, terrazzo or slabs, over 1.2 m."""
    kind = choose(rng, 6)
    if kind == 4:
        return _terrazzo(rng)
    rows, columns, bond = ((3, 3, 0), (4, 2, 1), (4, 4, 0), (6, 6, 0), (0, 0, 0), (2, 2, 0))[kind]
    size = 312
    image, tile = _laid(size, rows, columns, bond=bond, joint=3)
    shade = rng.uniform(-0.018, 0.018, rows * columns)
    values = 0.93 + shade[tile] + 0.014 * noise(rng, size, reach=(12.0, 12.0))
    if kind == 2:
        dark = (tile // columns + tile % columns) % 2 == 1
        values = np.where(dark, values * float(rng.uniform(0.42, 0.72)), values)
    return grey(np.where(image, float(rng.choice([0.74, 0.8, 0.62])), values))


def wall_tiles(rng: np.random.Generator) -> Image:
    """Glazed metro, square, stacked or small tiles, over 0.6 m."""
    rows, columns, bond = ((8, 4, 1), (4, 4, 0), (2, 8, 0), (12, 12, 0))[choose(rng, 4)]
    size = 192
    joint, tile = _laid(size, rows, columns, bond=bond, joint=2)
    shade = rng.uniform(-0.02, 0.015, rows * columns)
    # Glazes pool: a little lighter towards the upper edge of each tile.
    fall = (np.arange(size)[:, None] * rows / size) % 1.0
    values = 0.955 + shade[tile] + 0.02 * (0.5 - fall) + 0.004 * noise(rng, size, reach=(9.0, 9.0))
    return grey(np.where(joint, float(rng.choice([0.8, 0.86, 0.7])), values))


def _laid(
    size: int, rows: int, columns: int, *, bond: int, joint: int
) -> tuple[NDArray[np.bool_], NDArray[np.intp]]:
    """Joints of tiles, bool, and the number of the tile, `(size, size)` each; with `bond` every
    other row is shifted by half a tile."""
    y = np.arange(size) * rows / size
    row = np.floor(y).astype(np.intp)
    x = (np.arange(size)[None, :] * columns / size + 0.5 * bond * (row[:, None] % 2)) % columns
    edge = ((y % 1.0) * size / rows < joint)[:, None] | ((x % 1.0) * size / columns < joint)
    return edge, row[:, None] * columns + np.floor(x).astype(np.intp)


def _terrazzo(rng: np.random.Generator) -> Image:
    size, count = 312, 900
    owner, depth = scattered(rng, size, count, reach=(1.5, 7.0))
    inks = np.array([[0.80, 0.78, 0.75], [0.88, 0.82, 0.75], [0.84, 0.85, 0.85], [1.0, 0.99, 0.97]])
    chips = inks[rng.choice(len(inks), size=count, p=[0.2, 0.25, 0.25, 0.3])]
    ground = np.array([0.93, 0.92, 0.90]) + 0.008 * noise(rng, size, reach=(2.0, 2.0))[..., None]
    cover = np.clip(depth + 0.5, 0.0, 1.0)[..., None]
    return colored(ground + cover * (chips[owner] - ground))


def stone(rng: np.random.Generator) -> Image:
    """Granite, concrete or slate, over 0.8 m."""
    size, kind = 192, choose(rng, 3)
    soft, fine = noise(rng, size, reach=(14.0, 20.0)), noise(rng, size, reach=(1.2, 1.2))
    if kind == 0:
        dark, light = speckled(rng, size, share=0.12), speckled(rng, size, share=0.1)
        return grey(0.88 + 0.02 * soft + 0.02 * fine - 0.22 * dark + 0.08 * light)
    if kind == 1:
        return grey(0.91 + 0.03 * soft + 0.012 * fine - 0.2 * speckled(rng, size, share=0.006))
    layers = noise(rng, size, reach=(3.0, 30.0))
    return grey(0.9 + 0.02 * soft + 0.02 * layers + 0.012 * fine)


def marble(rng: np.random.Generator) -> Image:
    """Bright stone with soft slanted veins, over 1.2 m."""
    size = 256
    cloud = noise(rng, size, reach=(30.0, 30.0))
    veins = np.zeros((size, size))
    for long, wide, strength in ((80.0, 26.0, 0.2), (50.0, 14.0, 0.1), (30.0, 9.0, 0.05)):
        field = noise(rng, size, reach=(long, wide)) + 0.06 * noise(rng, size, reach=(5.0, 5.0))
        fade = np.clip(0.4 + 0.6 * noise(rng, size, reach=(long, long)), 0.0, 1.2)
        veins += strength * fade * np.exp(-np.abs(field) * 9.0)
    # Slanted by whole pixels a row, so that it still tiles.
    rows, columns = np.mgrid[0:size, 0:size]
    slant = int(rng.choice([-1, 1]))
    return grey((0.95 + 0.015 * cloud - veins)[rows, (columns + slant * rows) % size])


def metal(rng: np.random.Generator) -> Image:
    """Brushed along u, over 0.5 m."""
    streaks = noise(rng, (192, 64), reach=(0.8, 60.0))
    sheen = noise(rng, (192, 64), reach=(30.0, 1e6))
    return grey(0.91 + 0.022 * streaks + 0.03 * sheen)
