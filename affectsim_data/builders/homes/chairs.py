"""Chairs at tables and desks, stools and benches."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import posts, spread_legs, wooden
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes, lathe
from affectsim_data.builders.homes.pieces import BLACK, METAL, Furniture, LocalSeat, piece
from affectsim_data.builders.homes.shapes import (
    ball,
    cushion,
    oval,
    rounded,
    slab,
    tube,
    two_sided,
)
from affectsim_data.poses import FloatArray

__all__ = [
    "CHAIR_DEPTH", "CHAIR_WIDTH", "bar_stool", "bench", "chair_padded", "chair_shell",
    "chair_slatted", "chair_spindle", "chair_steel", "desk_chair", "office_chair", "stool",
]  # fmt: skip

CHAIR_WIDTH, CHAIR_DEPTH = 0.47, 0.5
"""No chair for tables is larger; their backs are their rearmost tenth of a metre."""


def _chair(parts: list[Part], seat_y: float, *, height: float, front: float = 0.235) -> Furniture:
    """A chair for a table whose seat ends `front` metres before its middle."""
    seat = LocalSeat((0.0, seat_y, front - 0.125), 0.42, edge=0.125)
    return piece("chair", parts, (CHAIR_WIDTH, CHAIR_DEPTH, height), seats=[seat])


def chair_slatted(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A wooden chair with a padded seat and level slats."""
    wood, seat_y = palette.dark_wood, 0.46
    count = int(rng.integers(2, 5))
    rows = np.linspace(0.6, 0.86, count)
    tall = min(0.09, 0.2 / count + 0.01)
    parts = [
        cushion((0.44, 0.05, 0.43), (0.0, seat_y - 0.031, 0.015), color=palette.textile,
                radius=0.02, puff=0.006),
        wooden((0.4, 0.05, 0.38), (0.0, seat_y - 0.08, 0.0), wood),
        posts([-0.19, 0.19], 0.19, y=(0.0, seat_y - 0.06), thick=0.035, color=wood),
        posts([-0.19, 0.19], -0.215, y=(0.0, 0.92), thick=0.035, color=wood),
        boxes([(0.02, 0.03, 0.37)] * 2, [(-0.19, 0.2, -0.012), (0.19, 0.2, -0.012)], colors=wood,
              material="wood"),
        boxes([(0.345, tall, 0.018)] * count, [(0.0, float(y), -0.215) for y in rows], colors=wood,
              material="wood"),
    ]  # fmt: skip
    return _chair(parts, seat_y, height=0.92)


def chair_shell(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A moulded shell on four splayed wooden legs."""
    color = palette.accent if rng.random() < 0.35 else np.array([0.93, 0.92, 0.9])
    seat_y = 0.45
    # Side view of the shell from its front edge over the seat up its back.
    line = np.array(
        [(0.235, -0.025), (0.215, -0.004), (0.15, 0.0), (0.02, -0.006), (-0.1, 0.0),
         (-0.165, 0.03), (-0.195, 0.1), (-0.212, 0.2), (-0.222, 0.3), (-0.228, 0.38)]
    )  # fmt: skip
    half = np.array([0.19, 0.205, 0.215, 0.215, 0.21, 0.205, 0.2, 0.19, 0.165, 0.13])
    across = np.linspace(-1.0, 1.0, 9)
    points = np.zeros((len(line), len(across), 3))
    points[..., 0] = half[:, None] * across
    cup = across**4
    points[..., 1] = seat_y + line[:, 1, None] + 0.05 * cup * (line[:, 1, None] < 0.05)
    points[..., 2] = line[:, 0, None] + 0.06 * cup * (line[:, 1, None] >= 0.05)
    shell = two_sided(points, color=color, material="plain", thickness=0.009)
    parts = [shell, box((0.22, 0.03, 0.24), (0.0, seat_y - 0.03, 0.02), color=BLACK)]
    parts += spread_legs(0.43, 0.43, seat_y - 0.035, color=palette.wood, radius=0.017, spread=0.09)
    return _chair(parts, seat_y, height=0.84)


def chair_spindle(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A turned chair: a saddle of a seat, round legs and a back of thin rods."""
    wood, seat_y = palette.wood, 0.45
    rods = int(rng.integers(5, 8))
    parts: list[Part] = [
        slab(rounded(0.43, 0.42, 0.09), seat_y, 0.035, color=wood, bevel=0.008),
        *spread_legs(0.42, 0.4, seat_y - 0.02, color=wood, radius=0.019, spread=0.05),
    ]
    for x in np.linspace(-0.17, 0.17, rods):
        top = np.array([1.08 * x, 0.86, -0.225 + 0.6 * x**2])
        foot = np.array([x, seat_y - 0.01, -0.17 + 0.6 * x**2])
        parts.append(
            tube([foot, (foot + top) / 2.0, top], 0.0075, color=wood, material="wood", segments=6)
        )
    rail = [(x, 0.87, -0.227 + 0.6 * x**2) for x in np.linspace(-0.205, 0.205, 9)]
    parts.append(tube(rail, 0.017, color=wood, material="wood"))
    parts.append(tube([(-0.17, 0.2, 0.0), (0.0, 0.2, 0.0), (0.17, 0.2, 0.0)], 0.01, color=wood,
                      material="wood"))  # fmt: skip
    return _chair(parts, seat_y, height=0.89, front=0.21)


def chair_padded(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A chair covered in cloth to its high back."""
    color = palette.sofa if rng.random() < 0.5 else palette.textile
    seat_y, tall = 0.47, float(rng.uniform(0.44, 0.52))
    back = cushion((0.44, tall, 0.07), (0.0, seat_y + tall / 2.0, -0.185), color=color, radius=0.03,
                   puff=0.012, axis=2, cells=8)  # fmt: skip
    parts = [
        cushion((0.45, 0.09, 0.44), (0.0, seat_y - 0.053, 0.012), color=color, radius=0.03,
                puff=0.008, cells=8),
        back.tilted(-0.06, pivot=(0.0, seat_y, -0.185)),
        posts([-0.185, 0.185, -0.185, 0.185], [0.19, 0.19, -0.18, -0.18], y=(0.0, seat_y - 0.09),
              thick=0.036, color=palette.dark_wood),
    ]  # fmt: skip
    return _chair(parts, seat_y, height=seat_y + tall)


def chair_steel(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """Bent steel tube with a wooden seat and back."""
    color = BLACK if rng.random() < 0.6 else METAL
    seat_y, wood = 0.46, palette.wood
    parts: list[Part] = [
        slab(rounded(0.41, 0.41, 0.07), seat_y, 0.016, color=wood, bevel=0.004).moved(z=0.02),
        box((0.37, 0.19, 0.016), (0.0, 0.77, -0.203), color=wood, material="wood", radius=0.008,
            segments=2),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        x = sign * 0.2
        side = np.array(
            [(x, 0.002, 0.211), (x, 0.25, 0.2), (x, seat_y - 0.06, 0.18), (x, seat_y - 0.027, 0.14),
             (x, seat_y - 0.027, 0.0), (x, seat_y - 0.027, -0.12), (x, seat_y, -0.165),
             (x, 0.65, -0.2), (x, 0.85, -0.222)]
        )  # fmt: skip
        rear = [(x, 0.003, -0.217), (x, 0.22, -0.18), (x, seat_y - 0.027, -0.1)]
        parts += [tube(side, 0.011, color=color), tube(rear, 0.011, color=color)]
    for z in (0.12, -0.08):
        bar = [(-0.2, seat_y - 0.027, z), (0.0, seat_y - 0.027, z), (0.2, seat_y - 0.027, z)]
        parts.append(tube(bar, 0.01, color=color))
    return _chair(parts, seat_y, height=0.87, front=0.225)


def bar_stool(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A bar stool; too high to be a `Seat`."""
    height = 0.66
    top = [(0.0, -0.04), (0.16, -0.04), (0.175, -0.02), (0.17, 0.0), (0.0, 0.0)]
    ring = np.linspace(0.0, 2.0 * np.pi, 21)
    loop = np.stack([0.135 * np.cos(ring), 0.22 + 0.0 * ring, 0.135 * np.sin(ring)], axis=1)
    color = palette.dark_wood if rng.random() < 0.5 else palette.wood
    parts = [
        lathe(top, color=color, material="wood", center=(0.0, height, 0.0), segments=24),
        tube(loop, 0.008, color=METAL),
        *spread_legs(0.3, 0.3, height - 0.03, color=color, radius=0.016, spread=0.06),
    ]
    return piece("stool", parts, (0.36, 0.36, height))


def stool(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A low wooden stool."""
    seat_y = 0.45
    outline = oval(0.34, 0.34, count=24) if rng.random() < 0.6 else rounded(0.36, 0.3, 0.03)
    parts = [
        slab(outline, seat_y, 0.03, color=palette.wood, bevel=0.008),
        *spread_legs(0.32, 0.28, seat_y - 0.02, color=palette.wood, radius=0.018, spread=0.05),
    ]
    return piece("stool", parts, (0.37, 0.36, seat_y),
                 seats=[LocalSeat((0.0, seat_y, 0.03), 0.32, edge=0.13)])  # fmt: skip


def bench(palette: Palette, *, rng: np.random.Generator, width: float = 1.1) -> Furniture:
    """A bench with a pad on it."""
    seat_y, depth, wood = 0.46, 0.38, palette.wood
    parts: list[Part] = [
        wooden((width, 0.035, depth), (0.0, seat_y - 0.0655, 0.0), wood),
        cushion((width - 0.04, 0.045, depth - 0.03), (0.0, seat_y - 0.0255, 0.0),
                color=palette.textile, radius=0.018, puff=0.003, cells=10),
        wooden((width - 0.1, 0.02, depth - 0.08), (0.0, 0.15, 0.0), wood),
    ]  # fmt: skip
    for sign in (-1.0, 1.0):
        size = (0.035, seat_y - 0.084, depth - 0.03)
        parts.append(wooden(size, (sign * (width / 2.0 - 0.06), size[1] / 2.0, 0.0), wood))
    count = max(int((width - 0.2) / 0.5), 1)
    seats = [
        LocalSeat((float(x), seat_y, 0.03), 0.36, edge=0.16)
        for x in (np.arange(count) - (count - 1) / 2.0) * 0.5
    ]
    shoes = int(rng.integers(0, 3))
    for k in range(shoes):
        x = -width / 2.0 + 0.25 + 0.3 * k
        color = palette.dark_wood * float(rng.uniform(0.6, 1.1))
        parts += [_shoe(x - 0.05, 0.16, color), _shoe(x + 0.05, 0.16, color)]
    return piece("bench", parts, (width, depth, seat_y), seats=seats)


def _shoe(x: float, y: float, color: FloatArray) -> Part:
    return cushion((0.085, 0.07, 0.25), (x, y + 0.035, 0.0), color=color, material="plain",
                   radius=0.03, puff=0.01, cells=5)  # fmt: skip


def _star(color: FloatArray) -> list[Part]:
    """Five castors on spokes around a column."""
    parts: list[Part] = [
        lathe([(0.0, 0.06), (0.03, 0.06), (0.03, 0.24), (0.02, 0.24), (0.02, 0.4), (0.0, 0.4)],
              color=color, segments=14)
    ]  # fmt: skip
    for spoke in range(5):
        yaw = 2.0 * np.pi * spoke / 5.0
        bar = box((0.04, 0.028, 0.22), (0.0, 0.078, 0.16), color=color, radius=0.01)
        castor = ball(0.03, (0.0, 0.03, 0.255), color=color * 0.8, segments=12)
        parts += [bar.moved(yaw=yaw), castor.moved(yaw=yaw)]
    return parts


def desk_chair(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A swivel chair on five castors."""
    dark, seat_y = np.array([0.27, 0.27, 0.28]), 0.465
    color = palette.sofa if rng.random() < 0.6 else dark * 1.3
    parts = [
        *_star(dark),
        cushion((0.48, 0.09, 0.47), (0.0, seat_y - 0.055, 0.02), color=color, radius=0.035,
                puff=0.01, cells=9),
        cushion((0.44, 0.5, 0.07), (0.0, seat_y + 0.36, -0.22), color=color, radius=0.03,
                puff=0.02, axis=2, cells=9).tilted(-0.1, pivot=(0.0, seat_y, -0.22)),
        box((0.06, 0.34, 0.025), (0.0, seat_y + 0.08, -0.25), color=dark),
        box((0.06, 0.025, 0.26), (0.0, seat_y - 0.105, -0.13), color=dark),
    ]  # fmt: skip
    if rng.random() < 0.6:
        for sign in (-1.0, 1.0):
            x = sign * 0.265
            parts += [
                box((0.06, 0.03, 0.26), (x, seat_y + 0.21, 0.0), color=dark, radius=0.012),
                box((0.03, 0.26, 0.05), (x, seat_y + 0.07, -0.03), color=dark),
                box((0.08, 0.025, 0.05), (x - sign * 0.035, seat_y - 0.06, -0.03), color=dark),
            ]
    return piece("chair", parts, (0.6, 0.6, 1.08),
                 seats=[LocalSeat((0.0, seat_y, 0.12), 0.44, edge=0.14)])  # fmt: skip


def office_chair(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A light swivel chair: a bent wooden shell on castors."""
    seat_y, color = 0.46, palette.wood
    line = np.array(
        [(0.22, -0.02), (0.19, 0.0), (0.0, -0.004), (-0.13, 0.004), (-0.19, 0.05), (-0.215, 0.16),
         (-0.228, 0.28), (-0.235, 0.36)]
    )  # fmt: skip
    across = np.linspace(-1.0, 1.0, 7)
    half = np.array([0.2, 0.22, 0.225, 0.22, 0.21, 0.2, 0.19, 0.16])
    points = np.zeros((len(line), len(across), 3))
    points[..., 0] = half[:, None] * across
    points[..., 1] = seat_y - 0.006 + line[:, 1, None]
    points[..., 2] = line[:, 0, None] + 0.05 * across**2 * (line[:, 1, None] > 0.02)
    pad = palette.accent if rng.random() < 0.5 else palette.sofa
    parts = [
        *_star(np.array([0.5, 0.5, 0.5])),
        two_sided(points, color=color, material="wood", thickness=0.012),
        lathe([(0.0, 0.39), (0.12, 0.39), (0.12, seat_y - 0.016), (0.0, seat_y - 0.016)],
              color=BLACK, segments=16),
        slab(rounded(0.38, 0.36, 0.1), seat_y + 0.012, 0.024, color=pad, material="fabric",
             bevel=0.008).moved(z=0.02),
    ]  # fmt: skip
    return piece("chair", parts, (0.6, 0.6, 0.84),
                 seats=[LocalSeat((0.0, seat_y + 0.012, 0.1), 0.42, edge=0.13)])  # fmt: skip
