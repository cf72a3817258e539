"""Textures of cloth, leather, wicker, paint and wallpaper. Each makes one variant per call."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.patterns import Image, choose, grey, noise
from affectsim_data.poses import FloatArray

__all__ = ["carpet", "fabric", "leather", "paint", "rug", "wallpaper", "wicker"]


Figure = NDArray[np.bool_]
"""What is drawn on a tile."""


def fabric(rng: np.random.Generator) -> Image:
    """Plain weave, twill, linen or boucle, over 0.32 m."""
    size, kind = 192, choose(rng, 4)
    wave = 2.0 * np.pi * np.arange(size) * 48 / size
    threads = noise(rng, size, reach=(1.0, 8.0)) + noise(rng, size, reach=(8.0, 1.0))
    if kind == 0:
        weave = np.sin(wave)[:, None] * np.sin(wave)[None, :]
        return grey(0.92 + 0.03 * weave + 0.018 * threads)
    if kind == 1:
        twill = np.sin(0.75 * (wave[:, None] + wave[None, :]))
        return grey(0.92 + 0.028 * twill + 0.015 * threads)
    if kind == 2:
        slubs = noise(rng, size, reach=(0.8, 26.0)) + noise(rng, size, reach=(26.0, 0.8))
        return grey(0.91 + 0.026 * slubs + 0.012 * threads)
    loops, soft = noise(rng, size, reach=(2.6, 2.6)), noise(rng, size, reach=(14.0, 14.0))
    return grey(0.91 + 0.045 * np.tanh(loops) + 0.01 * soft)


def carpet(rng: np.random.Generator) -> Image:
    """Cut pile, loops in rows, or a mottled one, over 0.6 m."""
    size, kind = 192, choose(rng, 3)
    soft, fine = noise(rng, size, reach=(20.0, 20.0)), noise(rng, size, reach=(1.5, 1.5))
    if kind == 0:
        return grey(0.9 + 0.02 * soft + 0.035 * fine)
    if kind == 1:
        rows = np.sin(2.0 * np.pi * np.arange(size) * 32 / size)[:, None]
        return grey(0.89 + 0.035 * rows + 0.025 * fine + 0.012 * soft)
    flecks = np.clip(noise(rng, size, reach=(2.5, 2.5)) - 0.8, 0.0, 1.5)
    return grey(0.91 + 0.015 * soft + 0.03 * fine - 0.07 * flecks)


def rug(rng: np.random.Generator) -> Image:
    """Woven figures: stripes, diamonds, crosses, a trellis or waves, over 0.8 m."""
    size, kind = 256, choose(rng, 5)
    down, across = np.mgrid[0:size, 0:size] / size
    dark = float(rng.uniform(0.55, 0.75))
    # Distances of a pixel to the middle of its cell, in cells.
    repeats = int(rng.integers(2, 5))
    v, u = (np.abs((plane * repeats) % 1.0 - 0.5) for plane in (down, across))
    if kind == 0:
        widths = rng.uniform(0.5, 1.5, 8)
        edges = np.cumsum(widths) / widths.sum()
        figure = np.isin(np.searchsorted(edges, down), (1, 3, 4, 6))
    elif kind == 1:
        figure = ((u + v) < 0.38) ^ ((u + v) < 0.24) ^ ((u + v) < 0.1)
    elif kind == 2:
        figure = ((u < 0.07) & (v < 0.26)) | ((v < 0.07) & (u < 0.26))
    elif kind == 3:
        figure = np.abs(u + v - 0.5) < 0.06
    else:
        wave = 0.12 * np.sin(2.0 * np.pi * across * repeats)
        figure = ((down * 2 * repeats + wave * 2) % 1.0) < 0.35
    pile = noise(rng, size, reach=(1.4, 1.4)) + 0.6 * noise(rng, size, reach=(12.0, 12.0))
    soft = _softened(figure)
    return grey(0.95 - (0.95 - dark) * soft + 0.025 * pile, tint=(1.0, 0.985, 0.965))


def wallpaper(rng: np.random.Generator) -> Image:
    """Stripes, leaves, scales, dots or grasscloth, over 0.6 m."""
    size, kind = 256, choose(rng, 5)
    down, across = np.mgrid[0:size, 0:size] / size
    depth = float(rng.uniform(0.06, 0.14))
    fine = 0.006 * noise(rng, size, reach=(1.5, 1.5))
    if kind == 0:
        count = int(rng.choice([4, 6, 10]))
        figure = ((across * count) % 1.0) < 0.5
    elif kind == 1:
        figure = _leaves(rng, down, across)
    elif kind == 2:
        figure = _scales(down, across)
    elif kind == 3:
        shift = 0.5 * (np.floor(down * 10) % 2)
        u, v = (across * 5 + shift) % 1.0 - 0.5, 2.0 * ((down * 10) % 1.0 - 0.5)
        figure = np.hypot(u, 0.25 * v) < 0.13
    else:
        reeds = noise(rng, size, reach=(0.9, 50.0))
        return grey(0.92 + 0.03 * reeds + 0.02 * noise(rng, size, reach=(8.0, 60.0)))
    return grey(0.965 - depth * _softened(figure) + fine)


def _leaves(rng: np.random.Generator, down: FloatArray, across: FloatArray) -> Figure:
    """Pairs of leaves along waving stems, bool."""
    stems = 3
    sway = 0.18 * np.sin(2.0 * np.pi * (down + float(rng.random())))
    u = (across * stems + sway) % 1.0 - 0.5
    figure = np.abs(u) < 0.015
    pairs = 5
    v = (down * pairs) % 1.0
    for side in (-1.0, 1.0):
        # A leaf leans out from its stem: a lens in turned coordinates.
        x, y = side * u - 0.2, (v - 0.5) - 0.9 * (side * u - 0.2)
        lens = np.abs(y) < 0.26 * (1.0 - (x / 0.19) ** 2)
        figure = figure | (lens & (np.abs(x) < 0.19))
    return figure


def _scales(down: FloatArray, across: FloatArray) -> Figure:
    """Overlapping fans, outlined, bool."""
    columns, rows = 4, 8
    figure = np.zeros(down.shape, bool)
    done = np.zeros(down.shape, bool)
    for back in (0, 1, 2):
        row = np.floor(down * rows) - 1.0 + back
        u = (across * columns + 0.5 * (row % 2)) % 1.0 - 0.5
        v = (down * rows - row) / 2.0
        far = np.hypot(u, v)
        inside = (far < 0.5) & ~done
        figure |= inside & ((np.abs(far - 0.46) < 0.035) | (np.abs(far - 0.3) < 0.02))
        done |= inside
    return figure


def _softened(figure: Figure) -> FloatArray:
    """A drawing with edges a pixel and a half wide."""
    values = figure.astype(np.float64)
    for axis in (0, 1):
        values = (np.roll(values, 1, axis) + 2.0 * values + np.roll(values, -1, axis)) / 4.0
    return values


def leather(rng: np.random.Generator) -> Image:
    """Fine pebbles with creases, over 0.4 m."""
    size = 160
    pebbles = np.abs(noise(rng, size, reach=(2.8, 2.8)))
    creases = np.exp(-np.abs(noise(rng, size, reach=(16.0, 22.0))) * 14.0)
    soft = noise(rng, size, reach=(18.0, 18.0))
    return grey(0.9 + 0.03 * np.tanh(2.0 * pebbles - 1.0) - 0.06 * creases + 0.015 * soft)


def paint(rng: np.random.Generator) -> Image:
    """Rolled paint, over 2 m."""
    size = 192
    soft, fine = noise(rng, size, reach=(24.0, 24.0)), noise(rng, size, reach=(1.6, 1.6))
    return grey(0.97 + 0.004 * soft + 0.004 * fine)


def wicker(rng: np.random.Generator) -> Image:
    """Strands over and under, over 0.12 m."""
    size, strands = 96, 8
    v, u = np.mgrid[0:size, 0:size] * strands / size
    over = (np.floor(u) + np.floor(v)) % 2 == 0
    level, upright = np.abs(np.sin(np.pi * v)), np.abs(np.sin(np.pi * u))
    ridge = np.where(over, level * (0.7 + 0.3 * upright), upright * (0.7 + 0.3 * level))
    return grey(0.5 + 0.46 * np.sqrt(ridge) + 0.02 * noise(rng, size, reach=(2.0, 2.0)))
