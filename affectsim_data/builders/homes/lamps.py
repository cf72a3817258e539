"""Lamps for floors, tables and ceilings."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, lathe
from affectsim_data.builders.homes.pieces import BLACK, METAL, Furniture, piece
from affectsim_data.builders.homes.shapes import ball, tube

__all__ = [
    "floor_lamp", "floor_lamp_arc", "floor_lamp_tripod", "pendant_cone", "pendant_drum",
    "pendant_globe", "table_lamp", "table_lamp_ball",
]  # fmt: skip

_SHADE = np.array([1.0, 0.95, 0.84])
_METAL = np.array([0.33, 0.32, 0.31])


def _shade(low: float, high: float, y0: float, y1: float) -> Part:
    """A closed cloth shade that glows."""
    profile = [(0.0, y0), (low, y0), (high, y1), (0.0, y1)]
    return lathe(profile, color=_SHADE, material="lamp", segments=28)


def floor_lamp(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A standing lamp with a cloth shade."""
    tall = float(rng.uniform(1.5, 1.65))
    low = float(rng.uniform(0.18, 0.21))
    stem = [(0.0, 0.0), (0.15, 0.0), (0.15, 0.02), (0.014, 0.03), (0.012, tall - 0.22),
            (0.0, tall - 0.22)]  # fmt: skip
    parts = [lathe(stem, color=_METAL), _shade(low, low * 0.75, tall - 0.3, tall)]
    return piece("lamp", parts, (0.43, 0.43, tall), lamp_y=tall - 0.15)


def floor_lamp_tripod(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A drum of a shade on three wooden legs."""
    hub = [(0.0, 1.1), (0.03, 1.1), (0.03, 1.22), (0.0, 1.22)]
    parts = [_shade(0.2, 0.2, 1.2, 1.48), lathe(hub, color=BLACK, segments=12)]
    for k in range(3):
        yaw = 2.0 * np.pi * k / 3.0 + 0.3
        foot = np.array([0.26 * np.sin(yaw), 0.008, 0.26 * np.cos(yaw)])
        top = np.array([0.02 * np.sin(yaw), 1.14, 0.02 * np.cos(yaw)])
        parts.append(tube([foot, (foot + top) / 2.0, top], [0.011, 0.014, 0.014],
                          color=palette.wood, material="wood"))  # fmt: skip
    return piece("lamp", parts, (0.55, 0.55, 1.48), lamp_y=1.34)


def floor_lamp_arc(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A lamp whose stem bends over to the front."""
    angle = np.linspace(0.0, 0.92 * np.pi, 16)
    bow = np.stack([0.0 * angle, 1.4 + 0.24 * np.sin(angle), -0.03 - 0.24 * np.cos(angle)], axis=1)
    stem = np.concatenate([[(0.0, 0.03, -0.27), (0.0, 0.7, -0.27)], bow])
    end = stem[-1]
    foot = [(0.0, 0.0), (0.14, 0.0), (0.14, 0.025), (0.0, 0.035)]
    cup = [(0.0, -0.14), (0.115, -0.14), (0.1, -0.06), (0.045, -0.004), (0.0, 0.0)]
    parts = [
        lathe(foot, color=_METAL, center=(0.0, 0.0, -0.27), segments=24),
        tube(stem, 0.011, color=_METAL, segments=8),
        lathe(cup, color=_SHADE, material="lamp", segments=24,
              center=(0.0, float(end[1]), float(end[2]))),
    ]  # fmt: skip
    return piece("lamp", parts, (0.29, 0.82, 1.66), lamp_y=float(end[1]) - 0.1)


def table_lamp(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small lamp with a turned foot and a cloth shade."""
    color = palette.accent if rng.random() < 0.5 else METAL
    foot = [(0.0, 0.0), (0.06, 0.0), (0.065, 0.02), (0.045, 0.06), (0.06, 0.12), (0.03, 0.19),
            (0.012, 0.21), (0.012, 0.26), (0.0, 0.26)]  # fmt: skip
    parts = [lathe(foot, color=color, segments=18, smooth=True), _shade(0.115, 0.08, 0.22, 0.4)]
    return piece("lamp", parts, (0.24, 0.24, 0.4), lamp_y=0.31)


def table_lamp_ball(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A glass ball on a low foot."""
    foot = [(0.0, 0.0), (0.065, 0.0), (0.06, 0.025), (0.035, 0.045), (0.0, 0.045)]
    parts = [
        lathe(foot, color=palette.wood, material="wood", segments=18),
        ball(0.095, (0.0, 0.132, 0.0), color=_SHADE, material="lamp", segments=20),
    ]
    return piece("lamp", parts, (0.2, 0.2, 0.228), lamp_y=0.13)


def _cord(height: float, top: float) -> list[Part]:
    """Cord and ceiling cup; the piece hangs from `top`, its underside is its origin."""
    return [
        tube([(0.0, height, 0.0), (0.0, (height + top) / 2.0, 0.0), (0.0, top - 0.02, 0.0)], 0.004,
             color=BLACK, segments=6),
        lathe([(0.0, top - 0.035), (0.03, top - 0.035), (0.05, top), (0.0, top)], color=_METAL,
              segments=16),
    ]  # fmt: skip


def pendant_cone(palette: Palette, *, rng: np.random.Generator, drop: float = 1.0) -> Furniture:
    """A metal cone on a cord of which `drop` metres show in all."""
    color = BLACK if rng.random() < 0.5 else palette.accent
    cone = [(0.0, 0.012), (0.17, 0.012), (0.17, 0.0), (0.18, 0.0), (0.18, 0.02), (0.05, 0.15),
            (0.035, 0.2), (0.0, 0.2)]  # fmt: skip
    glow = [(0.0, 0.004), (0.165, 0.004), (0.165, 0.0125), (0.0, 0.0125)]
    parts = [
        lathe(cone, color=color, segments=28),
        lathe(glow, color=_SHADE, material="lamp", segments=28),
        *_cord(0.19, drop),
    ]
    return piece("pendant lamp", parts, (0.37, 0.37, drop), lamp_y=-0.02)


def pendant_globe(palette: Palette, *, rng: np.random.Generator, drop: float = 1.0) -> Furniture:
    """A glass ball on a cord."""
    parts = [ball(0.15, (0.0, 0.15, 0.0), color=_SHADE, material="lamp", segments=24),
             *_cord(0.295, drop)]  # fmt: skip
    return piece("pendant lamp", parts, (0.31, 0.31, drop), lamp_y=0.15)


def pendant_drum(palette: Palette, *, rng: np.random.Generator, drop: float = 1.0) -> Furniture:
    """A broad cloth drum on a cord."""
    parts = [_shade(0.24, 0.24, 0.0, 0.2), *_cord(0.195, drop)]
    return piece("pendant lamp", parts, (0.49, 0.49, drop), lamp_y=0.1)
