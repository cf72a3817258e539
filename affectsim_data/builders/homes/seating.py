"""Sofas and armchairs."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from affectsim_data.builders.homes.joinery import posts, spread_legs, wooden
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, lathe
from affectsim_data.builders.homes.pieces import Furniture, LocalSeat, piece
from affectsim_data.builders.homes.shapes import cushion, rounded, slab, tube
from affectsim_data.poses import FloatArray

__all__ = [
    "armchair_cushioned", "armchair_tub", "armchair_wooden", "pouf", "sofa_boxy", "sofa_corner",
    "sofa_rolled", "sofa_wooden",
]  # fmt: skip

_PLACE_M = 0.62


def _pillow(x: float, y: float, z: float, palette: Palette, rng: np.random.Generator) -> Part:
    """A throw pillow that leans back against the cushion behind it."""
    color = palette.accent if rng.random() < 0.6 else palette.textile
    pillow = cushion((0.4, 0.38, 0.1), (0.0, 0.0, 0.0), color=color, radius=0.045,
                     puff=0.05, axis=2, cells=10)  # fmt: skip
    turn = float(rng.uniform(-0.2, 0.2))
    return pillow.tilted(-0.28).moved(x, y + 0.205, z, yaw=turn)


def _base(width: float, depth: float, color: FloatArray, *, low: float, high: float) -> Part:
    return box((width - 0.04, high - low, depth - 0.06), (0.0, (high + low) / 2.0, 0.0),
               color=color * 0.94, material="fabric", radius=0.02, segments=2)  # fmt: skip


def _places(
    places: int, seat_y: float, color: FloatArray, *, back_z: float, front_z: float, tall: float
) -> tuple[list[Part], list[LocalSeat]]:
    """Seat and back cushions side by side; the seats' upper faces lie at `seat_y`."""
    parts, seats, deep = [], [], front_z - back_z - 0.08
    for index in range(places):
        x = (index - (places - 1) / 2.0) * _PLACE_M
        middle = (x, seat_y - 0.089, front_z - deep / 2.0)
        parts.append(cushion((_PLACE_M - 0.006, 0.15, deep), middle, color=color, radius=0.045,
                             puff=0.016))  # fmt: skip
        middle = (x, seat_y + tall / 2.0 - 0.01, back_z + 0.09)
        back = cushion((_PLACE_M - 0.012, tall, 0.17), middle, color=color * 0.99, radius=0.065,
                       puff=0.04, axis=2)  # fmt: skip
        parts.append(back.tilted(-0.14, pivot=(x, seat_y, back_z + 0.09)))
        seats.append(LocalSeat((x, seat_y, front_z - 0.21), 0.5, edge=0.21))
    return parts, seats


def sofa_boxy(palette: Palette, *, rng: np.random.Generator, places: int = 3) -> Furniture:
    """A block of a sofa with broad arms on short legs."""
    arm, seat_y = float(rng.uniform(0.15, 0.2)), float(rng.uniform(0.43, 0.46))
    width, depth, color = places * _PLACE_M + 2.0 * arm, 0.92, palette.sofa
    parts, seats = _places(places, seat_y, color, back_z=-0.29, front_z=0.45, tall=0.42)
    parts += [
        _base(width, depth, color, low=0.11, high=seat_y - 0.15),
        cushion((width - 2.0 * arm, 0.56, 0.16), (0.0, 0.53, -depth / 2.0 + 0.085), color=color,
                radius=0.05, puff=0.0, axis=2, cells=12),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        parts.append(cushion((arm - 0.004, 0.5, depth), (sign * (width - arm) / 2.0, 0.37, 0.0),
                             color=color, radius=0.05, puff=0.012, axis=0, cells=8))  # fmt: skip
        parts.append(_pillow(sign * (places * _PLACE_M / 2.0 - 0.22), seat_y, -0.0, palette, rng))
    x = np.array([-1.0, -1.0, 1.0, 1.0]) * (width / 2.0 - 0.08)
    z = np.array([-0.38, 0.38, -0.38, 0.38])
    parts.append(posts(x, z, y=(0.0, 0.13), thick=0.05, color=palette.dark_wood))
    return piece("sofa", parts, (width + 0.02, depth, 0.86), seats=seats)


def sofa_rolled(palette: Palette, *, rng: np.random.Generator, places: int = 3) -> Furniture:
    """A sofa with rolled arms and a rolled back on turned legs."""
    arm, seat_y, depth = 0.2, float(rng.uniform(0.44, 0.46)), 0.94
    width, color = places * _PLACE_M + 2.0 * arm, palette.sofa
    parts, seats = _places(places, seat_y, color, back_z=-0.29, front_z=0.45, tall=0.36)
    parts += [
        _base(width - 0.04, depth, color, low=0.1, high=seat_y - 0.15),
        cushion((width - 2.0 * arm + 0.06, 0.48, 0.15), (0.0, 0.5, -0.37), color=color, radius=0.04,
                puff=0.0, axis=2, cells=12),
        tube([(x, 0.75, -0.375) for x in np.linspace(-0.5, 0.5, 5) * (width - 0.2)], 0.09,
             color=color, material="fabric", segments=14),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.11)
        parts += [
            box((0.15, 0.46, 0.84), (x, 0.33, 0.01), color=color * 0.97, material="fabric",
                radius=0.02, segments=2),
            tube([(x, 0.57, z) for z in np.linspace(-0.4, 0.44, 6)], 0.105, color=color,
                 material="fabric", segments=16),
            lathe([(0.0, 0.0), (0.055, 0.0), (0.05, 0.008), (0.0, 0.012)], color=color * 0.9,
                  material="fabric", segments=16).tilted(np.pi / 2.0).moved(x, 0.57, 0.44),
        ]  # fmt: skip
        parts.append(_pillow(sign * (places * _PLACE_M / 2.0 - 0.23), seat_y, 0.0, palette, rng))
    parts += spread_legs(width - 0.2, depth - 0.2, 0.12, color=palette.dark_wood, radius=0.03,
                         spread=0.01)  # fmt: skip
    return piece("sofa", parts, (width, depth, 0.84), seats=seats)


def sofa_wooden(palette: Palette, *, rng: np.random.Generator, places: int = 3) -> Furniture:
    """A light sofa: loose cushions in a wooden frame."""
    arm, seat_y, depth = 0.08, float(rng.uniform(0.42, 0.45)), 0.86
    width = places * _PLACE_M + 2.0 * arm
    parts, seats = _places(places, seat_y, palette.sofa, back_z=-0.28, front_z=0.41, tall=0.44)
    parts += [
        wooden((width - 0.06, 0.06, 0.7), (0.0, seat_y - 0.195, 0.04), palette.wood),
        wooden((width - 0.06, 0.05, 0.03), (0.0, 0.72, -0.395), palette.wood),
        wooden((width - 0.06, 0.05, 0.03), (0.0, 0.52, -0.385), palette.wood),
    ]
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.03)
        parts += [
            posts([x, x], [0.36, -0.39], y=(0.0, 0.6), thick=0.05, color=palette.wood),
            wooden((0.07, 0.03, depth - 0.02), (x, 0.615, 0.0), palette.wood, radius=0.01),
            wooden((0.034, 0.05, 0.7), (x, 0.3, -0.015), palette.wood),
            wooden((0.04, 0.2, 0.035), (x - sign * 0.005, 0.68, -0.4), palette.wood),
        ]  # fmt: skip
    for index in range(places):
        x = (index - (places - 1) / 2.0) * _PLACE_M
        if rng.random() < 0.6:
            parts.append(_pillow(x, seat_y, 0.0, palette, rng))
    return piece("sofa", parts, (width + 0.01, depth, 0.86), seats=seats)


def sofa_corner(
    palette: Palette, *, rng: np.random.Generator, places: int = 2, right: bool = True
) -> Furniture:
    """A sofa with a long seat at one end, its right one from behind unless told otherwise."""
    arm, seat_y, depth, long = 0.16, float(rng.uniform(0.43, 0.45)), 0.92, 1.5
    chaise = 0.85
    width, color = places * _PLACE_M + chaise + 2.0 * arm, palette.sofa
    back_z, middle = -long / 2.0 + 0.17, -long / 2.0 + depth / 2.0
    side = 1.0 if right else -1.0
    sofa, seats = _places(places, seat_y, color, back_z=back_z, front_z=back_z + 0.74, tall=0.42)
    shift = -side * chaise / 2.0
    parts = [part.moved(shift) for part in sofa]
    seats = [
        LocalSeat((s.position[0] + shift, *s.position[1:]), s.depth, edge=s.edge) for s in seats
    ]
    x = side * (places * _PLACE_M) / 2.0
    back = cushion((chaise - 0.012, 0.42, 0.17), (x, seat_y + 0.2, back_z + 0.09),
                   color=color * 0.99, radius=0.065, puff=0.04, axis=2)  # fmt: skip
    deep = long - 0.25
    parts += [
        back.tilted(-0.14, pivot=(x, seat_y, back_z + 0.09)),
        cushion((chaise - 0.006, 0.15, deep), (x, seat_y - 0.089, long / 2.0 - deep / 2.0 - 0.005),
                color=color, radius=0.045, puff=0.016, cells=9),
        _base(width, depth, color, low=0.11, high=seat_y - 0.15).moved(z=middle),
        box((chaise - 0.01, seat_y - 0.26, long - depth + 0.06),
            (x, (seat_y - 0.04) / 2.0, depth / 2.0 - 0.05), color=color * 0.94, material="fabric",
            radius=0.02, segments=2),
        cushion((width - 2.0 * arm, 0.56, 0.16), (0.0, 0.53, -long / 2.0 + 0.085), color=color,
                radius=0.05, puff=0.0, axis=2, cells=12),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        parts.append(cushion((arm - 0.004, 0.48, depth), (sign * (width - arm) / 2.0, 0.36, middle),
                             color=color, radius=0.05, puff=0.01, axis=0, cells=8))  # fmt: skip
    ends = np.array([-1.0, -1.0, 1.0, 1.0]) * (width / 2.0 - 0.08)
    rows = middle + np.array([-0.38, 0.38, -0.38, 0.38])
    feet = np.array([x - 0.3, x + 0.3])
    parts += [
        posts(ends, rows, y=(0.0, 0.13), thick=0.05, color=palette.dark_wood),
        posts(feet, long / 2.0 - 0.1, y=(0.0, 0.13), thick=0.05, color=palette.dark_wood),
        _pillow(-side * (width / 2.0 - arm - 0.22), seat_y, back_z + 0.29, palette, rng),
        _pillow(x, seat_y, back_z + 0.29, palette, rng),
    ]
    made = piece("sofa", parts, (width + 0.02, long, 0.86), seats=seats)
    half, front = made.width / 2.0, made.depth / 2.0
    inner, outer = sorted((side * half, side * (half - arm - chaise)))
    floor = ((-half, -front, half, -front + depth + 0.02), (inner, -front, outer, front))
    return dataclasses.replace(made, footprint=floor)


def armchair_wooden(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A low upholstered chair with a wooden frame."""
    color, width, depth, seat_y = palette.textile, 0.74, 0.8, float(rng.uniform(0.43, 0.45))
    parts = [
        cushion((0.58, 0.15, 0.62), (0.0, seat_y - 0.089, 0.06), color=color, radius=0.05,
                puff=0.016),
        cushion((0.58, 0.54, 0.15), (0.0, seat_y + 0.25, -0.26), color=color, radius=0.06,
                puff=0.03, axis=2).tilted(-0.2, pivot=(0.0, seat_y, -0.26)),
        wooden((0.6, 0.05, 0.62), (0.0, seat_y - 0.185, 0.04), palette.wood),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.035)
        parts += [
            posts([x, x], [0.3, -0.26], y=(0.0, 0.6), thick=0.045, color=palette.wood),
            wooden((0.065, 0.035, 0.68), (x, 0.612, 0.02), palette.wood, radius=0.012),
            wooden((0.025, 0.05, 0.52), (x, 0.3, 0.02), palette.wood),
        ]
    return piece("armchair", parts, (width, depth, 0.95),
                 seats=[LocalSeat((0.0, seat_y, 0.17), 0.5, edge=0.2)])  # fmt: skip


def armchair_cushioned(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small sofa for one, with arms and a pillow."""
    arm, depth, seat_y = 0.13, 0.86, float(rng.uniform(0.43, 0.46))
    width, color = _PLACE_M + 2.0 * arm, palette.textile
    parts, seats = _places(1, seat_y, color, back_z=-0.28, front_z=0.42, tall=0.44)
    parts += [
        _base(width, depth, color, low=0.13, high=seat_y - 0.15),
        cushion((width - 2.0 * arm, 0.6, 0.15), (0.0, 0.54, -depth / 2.0 + 0.08), color=color,
                radius=0.05, puff=0.0, axis=2),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * (width - arm) / 2.0
        parts.append(cushion((arm - 0.004, 0.46, depth - 0.01), (x, 0.37, 0.0), color=color,
                             radius=0.045, puff=0.01, axis=0))  # fmt: skip
    if rng.random() < 0.6:
        parts.append(_pillow(0.0, seat_y, 0.0, palette, rng))
    parts += spread_legs(width - 0.1, depth - 0.14, 0.15, color=palette.dark_wood, radius=0.022,
                         spread=0.03)  # fmt: skip
    return piece("armchair", parts, (width + 0.01, depth, 0.9), seats=seats)


def armchair_tub(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A round chair whose back runs into its arms."""
    color, seat_y = palette.accent if rng.random() < 0.4 else palette.textile, 0.44
    angle = np.linspace(-0.62 * np.pi, 0.62 * np.pi, 17)
    across, parts = 0.335, []
    # Back and arms: padded staves side by side, lower towards the arms' ends.
    for k, (start, end) in enumerate(itertools.pairwise(angle)):
        turn = (start + end) / 2.0
        fall = abs(k - 7.5) / 7.5
        tall = 0.52 - 0.22 * fall**2
        stave = cushion((0.098, tall, 0.1), (0.0, 0.24 + tall / 2.0, -across), color=color,
                        radius=0.035, puff=0.012, axis=2, cells=4)  # fmt: skip
        parts.append(stave.moved(yaw=float(-turn)))
    parts += [
        slab(rounded(0.6, 0.6, 0.28, segments=7), seat_y, 0.13, color=color, material="fabric",
             bevel=0.025),
        lathe([(0.0, 0.24), (0.26, 0.24), (0.31, 0.3), (0.31, 0.315), (0.0, 0.315)],
              color=color * 0.9, material="fabric", segments=24),
    ]  # fmt: skip
    parts += spread_legs(0.52, 0.52, 0.26, color=palette.dark_wood, radius=0.02, spread=0.06)
    return piece("armchair", parts, (0.8, 0.8, 0.78),
                 seats=[LocalSeat((0.0, seat_y, 0.1), 0.46, edge=0.2)])  # fmt: skip


def pouf(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A round stuffed stool."""
    tall, color = 0.43, palette.accent if rng.random() < 0.5 else palette.rug
    profile = [(0.0, 0.0), (0.2, 0.0), (0.255, 0.05), (0.27, 0.2), (0.262, 0.33), (0.23, 0.4),
               (0.12, tall - 0.003), (0.0, tall)]  # fmt: skip
    rim = lathe([(0.25, 0.195), (0.282, 0.205), (0.25, 0.215)], color=color * 0.85,
                material="fabric", segments=26)  # fmt: skip
    body = lathe(profile, color=color, material="fabric", segments=26, smooth=True)
    return piece("stool", [body, rim], (0.56, 0.56, tall),
                 seats=[LocalSeat((0.0, tall, 0.04), 0.44, edge=0.22)])  # fmt: skip
