"""Plants in pots for floors."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, lathe
from affectsim_data.builders.homes.pieces import WHITE, Furniture, piece
from affectsim_data.builders.homes.shapes import leaves, tube
from affectsim_data.poses import FloatArray

__all__ = ["plant_bladed", "plant_fig", "plant_palm", "plant_sword"]

_GREEN = np.array([0.36, 0.52, 0.30])
_SOIL = np.array([0.33, 0.26, 0.21])


def _pot(palette: Palette, rng: np.random.Generator, *, tall: float, reach: float) -> list[Part]:
    """A pot with soil; its rim is `reach` from its axis."""
    inks = (WHITE * 0.93, np.array([0.72, 0.47, 0.34]), palette.accent, np.array([0.4, 0.4, 0.4]))
    color = inks[int(rng.integers(len(inks)))]
    if rng.random() < 0.5:
        profile = [(0.0, 0.0), (reach * 0.72, 0.0), (reach, tall), (reach * 0.9, tall),
                   (reach * 0.86, tall - 0.04), (0.0, tall - 0.04)]  # fmt: skip
    else:
        profile = [(0.0, 0.0), (reach * 0.9, 0.0), (reach, 0.03), (reach, tall),
                   (reach * 0.9, tall), (reach * 0.9, tall - 0.04), (0.0, tall - 0.04)]  # fmt: skip
    soil = lathe([(reach * 0.84, tall - 0.035), (0.0, tall - 0.03)], color=_SOIL, segments=24)
    return [lathe(profile, color=color, segments=26), soil]


def _greens(count: int, rng: np.random.Generator, base: FloatArray = _GREEN) -> FloatArray:
    """Slightly different greens, `(count, 3)`."""
    colors: FloatArray = base * rng.uniform(0.82, 1.2, (count, 1))
    return colors


def plant_bladed(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """Long arching blades out of the pot."""
    tall, pot = float(rng.uniform(0.95, 1.4)), 0.32
    count, rows = 34, 9
    t = np.linspace(0.0, 1.0, rows)
    share = (np.arange(count) + 1.0) / count
    yaw = 2.4 * np.arange(count) + rng.uniform(-0.3, 0.3, count)
    rise = (tall - pot) * (0.45 + 0.5 * share)
    reach = 0.26 * (1.1 - 0.75 * share) + 0.04
    spines = np.stack(
        [
            np.outer(reach * np.sin(yaw), t**1.6),
            pot - 0.05 + np.outer(rise, np.sin(1.75 * t)),
            np.outer(reach * np.cos(yaw), t**1.6),
        ],
        axis=-1,
    )
    half = np.tile(0.042 * np.sin(np.pi * t**0.8) + 0.003, (count, 1))
    parts = [
        *_pot(palette, rng, tall=pot, reach=0.165),
        leaves(spines, half, colors=_greens(count, rng)),
    ]
    return piece("plant", parts, (0.66, 0.66, tall))


def plant_sword(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """Stiff upright leaves."""
    tall, pot, count, rows = float(rng.uniform(0.75, 1.0)), 0.26, 16, 6
    t = np.linspace(0.0, 1.0, rows)
    yaw = 2.4 * np.arange(count)
    start = 0.02 + 0.006 * np.arange(count)
    reach = start + rng.uniform(0.02, 0.07, count)
    rise = (tall - pot) * rng.uniform(0.65, 1.0, count)
    along = start[:, None] + np.outer(reach - start, t**1.5)
    spines = np.stack(
        [
            along * np.sin(yaw)[:, None],
            pot - 0.05 + np.outer(rise, t),
            along * np.cos(yaw)[:, None],
        ],
        axis=-1,
    )
    half = np.tile(0.034 * (1.0 - t**3) + 0.002, (count, 1))
    colors = _greens(count, rng, np.array([0.42, 0.54, 0.36]))
    parts = [
        *_pot(palette, rng, tall=pot, reach=0.15),
        leaves(spines, half, colors=colors, fold=0.2),
    ]
    return piece("plant", parts, (0.42, 0.42, tall))


def plant_fig(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small tree: a stem or three with broad leaves."""
    tall, pot = float(rng.uniform(1.3, 1.8)), 0.3
    stems, parts = int(rng.integers(1, 4)), _pot(palette, rng, tall=0.3, reach=0.17)
    roots, ways = [], []
    for k in range(stems):
        yaw = 2.0 * np.pi * k / stems + float(rng.uniform(-0.4, 0.4))
        lean = 0.05 if stems == 1 else 0.12
        top = (tall - 0.12) * (1.0 - 0.18 * k)
        t = np.linspace(0.0, 1.0, 6)
        out = lean * t + 0.02 * np.sin(5.0 * t)
        line = np.stack(
            [out * np.sin(yaw), pot - 0.06 + (top - pot) * t, out * np.cos(yaw)], axis=1
        )
        parts.append(tube(line, np.linspace(0.014, 0.006, 6), color=(0.5, 0.42, 0.33), segments=7))
        number = 26 if stems == 1 else 15
        places = rng.uniform(0.3, 1.0, number) if stems == 1 else rng.uniform(0.35, 1.0, number)
        at = np.stack([np.interp(places, t, line[:, axis]) for axis in range(3)], axis=1)
        roots.append(at)
        ways.append(2.4 * np.arange(number) + k)
    root, yaw_all = np.concatenate(roots), np.concatenate(ways)
    count, rows = len(root), 6
    t = np.linspace(0.0, 1.0, rows)
    long = rng.uniform(0.17, 0.25, count)
    lift = rng.uniform(-0.2, 0.5, count)
    flat = np.outer(long, t)
    height = np.outer(long * lift, t) - 0.35 * long[:, None] * t**2
    spines = root[:, None] + np.stack(
        [flat * np.sin(yaw_all)[:, None], height, flat * np.cos(yaw_all)[:, None]], axis=-1
    )
    half = 0.36 * long[:, None] * np.sin(np.pi * np.clip(t, 0.06, 1.0) ** 1.3) + 0.002
    parts.append(leaves(spines, half, colors=_greens(count, rng, np.array([0.33, 0.48, 0.29]))))
    return piece("plant", parts, (0.68, 0.68, tall))


def plant_palm(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """Feathered fronds that bend outwards."""
    tall, pot, fronds = float(rng.uniform(1.1, 1.6)), 0.3, 9
    spines, halves = [], []
    t = np.linspace(0.0, 1.0, 10)
    parts = _pot(palette, rng, tall=pot, reach=0.17)
    for k in range(fronds):
        yaw = 2.4 * k + float(rng.uniform(-0.3, 0.3))
        reach, rise = float(rng.uniform(0.22, 0.34)), (tall - pot) * (0.72 + 0.28 * (k % 3) / 2.0)
        out, up = reach * t**1.4, rise * np.sin(1.75 * t)
        stem = np.stack([out * np.sin(yaw), pot - 0.06 + up, out * np.cos(yaw)], axis=1)
        parts.append(tube(stem, np.linspace(0.006, 0.002, 10), color=_GREEN * 0.9, segments=5))
        for share in np.linspace(0.4, 0.98, 9):
            root = np.array([np.interp(share, t, stem[:, axis]) for axis in range(3)])
            for side in (-1.0, 1.0):
                way = yaw + side * (1.25 - 0.6 * share)
                long = 0.2 * float(np.sin(np.pi * (0.25 + 0.6 * share)))
                s = np.linspace(0.0, 1.0, 4)
                drop = 0.1 * s - 0.45 * s**2
                spines.append(
                    root + long * np.stack([s * np.sin(way), drop, s * np.cos(way)], axis=1)
                )
                halves.append(0.012 * np.sin(np.pi * np.clip(s, 0.15, 1.0)) + 0.001)
    count = len(spines)
    colors = _greens(count, rng, np.array([0.38, 0.54, 0.3]))
    parts.append(leaves(np.stack(spines), np.stack(halves), colors=colors, fold=0.1))
    return piece("plant", parts, (0.86, 0.86, tall))
