"""Toilets, basins, baths and showers."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import drawers
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes, grid_faces, lathe, smooth_normals
from affectsim_data.builders.homes.pieces import DARK, METAL, WHITE, Furniture, piece
from affectsim_data.builders.homes.shapes import oval, rounded, slab, tube, two_sided
from affectsim_data.builders.homes.trinkets import mug
from affectsim_data.poses import FloatArray

__all__ = [
    "basin_cabinet", "basin_pillar", "bathtub", "bin_pedal", "shower", "toilet", "towel_rail",
    "washing_machine",
]  # fmt: skip

_CHROME = METAL * 1.15
_WATER = np.array([0.86, 0.92, 0.93])


def _loft(rings: list[FloatArray], heights: list[float], *, color: FloatArray) -> Part:
    """A smooth skin through outlines `(n, 2)` at heights, closed flat at both ends.

    Rings run upwards with the outside on their right, as the profile of a `lathe` does.
    """
    rows = [
        np.stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]], axis=1)
        for ring, y in zip(rings, heights, strict=True)
    ]
    rows = [rows[0] * [0.0, 1.0, 0.0] + _middle(rows[0]), *rows]
    rows.append(rows[-1] * [0.0, 1.0, 0.0] + _middle(rows[-1]))
    grid = np.stack([np.concatenate([row, row[:1]]) for row in rows])
    flat = grid.reshape(-1, 3)
    faces = grid_faces(*grid.shape[:2])
    a, b, c = (flat[faces[:, k]] for k in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-10]
    normals = smooth_normals(flat, faces)
    lost = np.linalg.norm(normals, axis=1) < 0.5
    normals[lost] = [0.0, 1.0, 0.0]
    colors = np.broadcast_to(color, flat.shape).copy()
    return Part("plain", flat, normals, flat[:, [0, 1]].copy(), colors, faces)


def _middle(row: FloatArray) -> FloatArray:
    middle: FloatArray = row.mean(axis=0) * np.array([1.0, 0.0, 1.0])
    return middle


def toilet(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A toilet with its cistern; the lid is down."""

    def egg(scale: float, z: float) -> FloatArray:
        outline: FloatArray = oval(0.36, 0.46, count=32) * scale + np.array([0.0, z])
        return outline

    bowl = _loft(
        [egg(0.62, 0.0), egg(0.6, 0.0), egg(0.55, 0.0), egg(0.75, 0.04), egg(0.97, 0.08),
         egg(1.0, 0.085), egg(0.99, 0.085)],
        [0.0, 0.02, 0.14, 0.26, 0.36, 0.385, 0.4], color=WHITE,
    )  # fmt: skip
    lid = slab(
        oval(0.37, 0.47, count=32), 0.43, 0.028, color=WHITE * 1.02, material="plain", bevel=0.01
    )
    parts = [
        bowl,
        lid.moved(z=0.085),
        box((0.26, 0.4, 0.2), (0.0, 0.2, -0.2), color=WHITE, radius=0.03, segments=2),
        box((0.36, 0.36, 0.17), (0.0, 0.6, -0.26), color=WHITE, radius=0.02, segments=2),
        box((0.375, 0.03, 0.185), (0.0, 0.795, -0.26), color=WHITE, radius=0.012, segments=2),
        lathe([(0.0, 0.0), (0.025, 0.0), (0.022, 0.008), (0.0, 0.008)], color=_CHROME,
              center=(0.0, 0.81, -0.26), segments=14),
    ]  # fmt: skip
    return piece("toilet", parts, (0.38, 0.71, 0.82))


def _tap(x: float, y: float, z: float) -> list[Part]:
    bow = [(x, y, z), (x, y + 0.1, z), (x, y + 0.14, z + 0.03), (x, y + 0.135, z + 0.09),
           (x, y + 0.11, z + 0.12)]  # fmt: skip
    lever = [(x, y + 0.13, z), (x, y + 0.16, z - 0.005), (x, y + 0.17, z - 0.04)]
    return [tube(bow, 0.012, color=_CHROME), tube(lever, 0.007, color=_CHROME, segments=6)]


def _bowl(width: float, depth: float, top: float, *, tall: float) -> Part:
    """A basin: outer skin up, over the rim and down into the hollow."""
    outer, rim = (
        rounded(width, depth, 0.12, segments=6),
        rounded(width - 0.03, depth - 0.03, 0.11, segments=6),
    )
    hollow = rounded(width - 0.09, depth - 0.11, 0.1, segments=6)
    floor = rounded(width - 0.2, depth - 0.2, 0.06, segments=6)
    return _loft(
        [outer * 0.7, outer * 0.97, outer, rim, hollow, floor],
        [top - tall, top - 0.04, top, top + 0.003, top - 0.02, top - 0.09], color=WHITE,
    )  # fmt: skip


def basin_cabinet(palette: Palette, *, rng: np.random.Generator, width: float = 0.7) -> Furniture:
    """A washbasin on a cabinet with drawers."""
    depth, top = 0.46, 0.85
    color = palette.cabinet if rng.random() < 0.6 else palette.wood
    parts = [
        box((width - 0.03, 0.48, depth - 0.04), (0.0, 0.5, -0.02), color=color * 0.98),
        *drawers(width - 0.05, 0.28, 0.72, depth / 2.0 - 0.04, count=2, color=color),
        box((width, 0.03, depth), (0.0, 0.752, 0.0), color=WHITE, radius=0.01),
        _bowl(min(width - 0.1, 0.56), 0.38, top, tall=0.088),
        *_tap(0.0, 0.767, -0.205),
        *(part.moved(width / 2.0 - 0.06, 0.767, -0.17) for part in mug(palette.accent)),
        boxes([(0.04, 0.26, 0.04)] * 4,
              [(x * (width / 2.0 - 0.06), 0.13, z) for x in (-1, 1) for z in (-0.19, 0.15)],
              colors=palette.dark_wood),
    ]  # fmt: skip
    return piece("washbasin", parts, (width, depth + 0.02, top + 0.09))


def basin_pillar(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A washbasin on a china foot."""
    top = 0.84
    foot = [
        (0.0, 0.0),
        (0.11, 0.0),
        (0.1, 0.03),
        (0.07, 0.2),
        (0.075, 0.5),
        (0.12, 0.7),
        (0.0, 0.7),
    ]
    parts = [
        _bowl(0.56, 0.44, top, tall=0.18),
        lathe(foot, color=WHITE, segments=20, smooth=True, center=(0.0, 0.0, -0.06)),
        box((0.3, 0.1, 0.06), (0.0, 0.78, -0.2), color=WHITE),
        *_tap(0.0, top - 0.012, -0.19),
    ]
    return piece("washbasin", parts, (0.57, 0.47, top + 0.16))


def bathtub(palette: Palette, *, rng: np.random.Generator, width: float = 1.7) -> Furniture:
    """A built-in bath along the wall, with a tap and a bottle or two."""
    depth, top = 0.75, 0.57
    rim = rounded(width - 0.04, depth - 0.04, 0.03, segments=2)
    hollow = rounded(width - 0.16, depth - 0.16, 0.2, segments=8)
    steps = len(hollow)
    outer = _resampled(rim, steps)
    inside = _loft(
        [outer * 0.9, outer * 0.95, outer, _resampled(hollow, steps),
         _resampled(hollow * [0.97, 0.93], steps),
         _resampled(hollow * [0.88, 0.8], steps)],
        [0.1, top - 0.04, top, top + 0.001, top - 0.1, top - 0.38], color=WHITE,
    )  # fmt: skip
    tall, middle = top - 0.03, (top - 0.03) / 2.0
    thick = 0.022
    skirt = boxes(
        [(width, tall, thick), (width, tall, thick), (thick, tall, depth - 0.046),
         (thick, tall, depth - 0.046)],
        [(0.0, middle, depth / 2.0 - thick / 2.0), (0.0, middle, thick / 2.0 - depth / 2.0),
         (width / 2.0 - thick / 2.0, middle, 0.0), (thick / 2.0 - width / 2.0, middle, 0.0)],
        colors=(0.9, 0.9, 0.88), material="wall_tiles",
    )  # fmt: skip
    parts = [
        inside,
        skirt,
        *(part.moved(yaw=np.pi / 2.0) for part in _tap(0.0, top, -width / 2 + 0.05)),
    ]
    for k in range(int(rng.integers(1, 4))):
        tint = (palette.accent, palette.sofa, palette.rug)[k]
        bottle = [
            (0.0, 0.0),
            (0.028, 0.0),
            (0.028, 0.13),
            (0.012, 0.15),
            (0.012, 0.17),
            (0.0, 0.17),
        ]
        at = (width / 2.0 - 0.12 - 0.08 * k, top, -depth / 2.0 + 0.055)
        parts.append(lathe(bottle, color=tint, segments=14, center=at))
    return piece("bathtub", parts, (width, depth, 0.74))


def _resampled(outline: FloatArray, count: int) -> FloatArray:
    """A closed outline as `count` points by the angle about its middle, so that rings match."""
    angle = np.arctan2(outline[:, 0], outline[:, 1]) % (2.0 * np.pi)
    order = np.argsort(angle)
    wanted = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    angles, points = angle[order], outline[order]
    ends = np.concatenate([[angles[-1] - 2.0 * np.pi], angles, [angles[0] + 2.0 * np.pi]])
    closed = np.concatenate([points[-1:], points, points[:1]])
    return np.stack([np.interp(wanted, ends, closed[:, k]) for k in range(2)], axis=1)


def shower(palette: Palette, *, rng: np.random.Generator, width: float = 0.9) -> Furniture:
    """A shower corner: tray, frame with a curtain drawn halfway, and a hand shower."""
    depth, top, half = 0.9, 2.0, width / 2.0
    bar = top - 0.03
    parts = [
        box((width, 0.05, depth), (0.0, 0.025, 0.0), color=WHITE, radius=0.012, segments=2),
        lathe([(0.0, 0.05), (0.045, 0.05), (0.045, 0.053), (0.0, 0.053)], color=METAL, segments=16),
        boxes([(0.03, top - 0.05, 0.03)] * 2,
              [(sign * (half - 0.02), (top + 0.05) / 2.0, depth / 2.0 - 0.02) for sign in (-1, 1)],
              colors=_CHROME),
        boxes([(width - 0.07, 0.025, 0.025)], [(0.0, bar, depth / 2.0 - 0.02)], colors=_CHROME),
        boxes([(0.025, 0.025, depth - 0.07)] * 2,
              [(sign * (half - 0.02), bar, -0.018) for sign in (-1, 1)], colors=_CHROME),
        box((0.02, top - 0.12, depth - 0.06), (half - 0.02, (top + 0.0) / 2.0, -0.02), color=_WATER,
            step=0.3),
        tube([(0.0, 1.05, -depth / 2 + 0.04), (0.0, 1.5, -depth / 2 + 0.04),
              (0.0, 1.92, -depth / 2 + 0.04)], 0.011, color=_CHROME),
        box((0.14, 0.05, 0.06), (0.0, 1.05, -depth / 2 + 0.04), color=_CHROME),
    ]  # fmt: skip
    rose = [(0.0, 0.0), (0.06, 0.0), (0.05, 0.025), (0.012, 0.03), (0.0, 0.03)]
    head = lathe(rose, color=_CHROME, segments=18)
    parts.append(head.tilted(-0.5).moved(0.0, 1.85, -depth / 2 + 0.11))
    across = np.linspace(-half + 0.05, 0.1, 31)
    heights = np.array([0.12, 0.7, 1.3, bar - 0.02])
    fold = 0.028 * np.sin(across * 38.0)
    points = np.stack(
        np.broadcast_arrays(across, heights[:, None], fold * np.ones((4, 1))), axis=-1
    )
    cloth = two_sided(points, color=palette.textile, material="fabric", thickness=0.005)
    parts.append(cloth.moved(z=depth / 2.0 - 0.06))
    return piece("shower", parts, (width, depth, top))


def towel_rail(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A warm rail of level bars with towels over it, on the wall."""
    width, height, depth = 0.5, 1.1, 0.12
    side, z = width / 2.0 - 0.02, 0.0
    parts: list[Part] = [
        tube([(s * side, 0.0, z), (s * side, height / 2.0, z), (s * side, height, z)], 0.016,
             color=WHITE)
        for s in (-1.0, 1.0)
    ]  # fmt: skip
    rows = np.concatenate([np.linspace(0.06, 0.4, 5), np.linspace(0.6, 1.04, 6)])
    parts += [
        tube([(-side, float(y), z), (0.0, float(y), z), (side, float(y), z)], 0.011, color=WHITE,
             segments=6)
        for y in rows
    ]  # fmt: skip
    parts += [
        boxes([(0.02, 0.02, depth / 2.0)] * 4,
              [(s * side, y, -depth / 4.0) for s in (-1, 1) for y in (0.1, height - 0.1)],
              colors=WHITE),
        *_towel(palette.accent, y=0.78, width=0.34, drop=0.34, z=z),
    ]  # fmt: skip
    if rng.random() < 0.6:
        parts += _towel(palette.textile, y=0.4, width=0.3, drop=0.26, z=z)
    return piece("towel rail", parts, (width, depth, height))


def _towel(color: FloatArray, *, y: float, width: float, drop: float, z: float) -> list[Part]:
    """A cloth hung over a bar at height `y`."""
    turn = np.linspace(0.0, np.pi, 7)
    over = np.stack([y + 0.02 * np.sin(turn), z + 0.02 * np.cos(turn)], axis=1)
    line = np.concatenate([[(y - drop, z + 0.024), (y - drop / 2.0, z + 0.022)], over,
                           [(y - 0.6 * drop, z - 0.022)]])  # fmt: skip
    across = np.linspace(-width / 2.0, width / 2.0, 5)
    points = np.zeros((len(line), 5, 3))
    points[..., 0] = across
    points[..., 1:] = line[:, None]
    return [two_sided(points, color=color, material="fabric", thickness=0.012)]


def washing_machine(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A washing machine with a round door."""
    width, height, depth = 0.6, 0.86, 0.6
    z = depth / 2.0 - 0.03
    ring = [(0.0, 0.0), (0.185, 0.0), (0.18, 0.02), (0.13, 0.024), (0.12, 0.014), (0.0, 0.014)]
    door = lathe(ring, color=METAL, segments=30).tilted(np.pi / 2.0)
    glass = lathe([(0.12, 0.0), (0.08, 0.02), (0.0, 0.026)], color=DARK * 1.2,
                  segments=26, smooth=True).tilted(np.pi / 2.0)  # fmt: skip
    parts = [
        box((width, height - 0.015, depth - 0.06), (0.0, height / 2.0 + 0.0075, -0.03),
            color=WHITE, radius=0.01),
        boxes([(0.05, 0.015, 0.05)] * 4,
              [(x, 0.0075, w) for x in (-0.24, 0.24) for w in (-0.24, 0.18)], colors=DARK),
        door.moved(0.0, 0.42, z), glass.moved(0.0, 0.42, z + 0.0145),
        box((width - 0.02, 0.11, 0.012), (0.0, height - 0.075, z + 0.006), color=WHITE * 0.95),
        box((0.16, 0.07, 0.012), (-0.19, height - 0.075, z + 0.014), color=WHITE),
        box((0.12, 0.05, 0.004), (0.06, height - 0.075, z + 0.0142), color=DARK),
        lathe([(0.0, 0.0), (0.032, 0.0), (0.027, 0.022), (0.0, 0.022)], color=METAL,
              segments=18).tilted(np.pi / 2.0).moved(0.2, height - 0.075, z + 0.012),
    ]  # fmt: skip
    return piece("washing machine", parts, (width, depth, height))


def bin_pedal(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small bin with a domed lid."""
    body = [(0.0, 0.0), (0.1, 0.0), (0.11, 0.02), (0.11, 0.26), (0.115, 0.262), (0.11, 0.29),
            (0.06, 0.31), (0.0, 0.315)]  # fmt: skip
    parts = [lathe(body, color=METAL * 1.1, segments=22),
             box((0.05, 0.015, 0.05), (0.0, 0.02, 0.12), color=DARK)]  # fmt: skip
    return piece("bin", parts, (0.24, 0.29, 0.315))
