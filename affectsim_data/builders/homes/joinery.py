"""What cabinets and tables are joined of: boards, legs, doors, drawers, grips and frames."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.parts import Part, Point, box, boxes, lathe
from affectsim_data.builders.homes.pieces import BLACK, METAL
from affectsim_data.builders.homes.shapes import tube

__all__ = [
    "cabinet_doors", "drawers", "frame", "hairpins", "legs", "posts", "round_leg", "spread_legs",
    "wooden",
]  # fmt: skip


def wooden(size: Point, center: Point, color: ArrayLike, *, radius: float = 0.004) -> Part:
    """A wooden box."""
    return box(size, center, color=color, material="wood", radius=radius)


def posts(
    xs: ArrayLike, zs: ArrayLike, *, y: tuple[float, float], thick: float, color: ArrayLike,
    material: str = "wood",
) -> Part:  # fmt: skip
    """Square posts at places `(xs, zs)` from the lower to the upper height."""
    x, z = np.broadcast_arrays(np.asarray(xs, np.float64), np.asarray(zs, np.float64))
    centers = np.stack([x, np.full(x.shape, (y[0] + y[1]) / 2.0), z], axis=-1)
    sizes = np.tile([thick, y[1] - y[0], thick], (x.size, 1))
    return boxes(sizes, centers, colors=color, material=material)


def legs(
    width: float, depth: float, height: float, *, thick: float, color: ArrayLike,
    inset: float = 0.04, material: str = "wood",
) -> list[Part]:  # fmt: skip
    """Four square legs under a top."""
    x, z = (width - thick) / 2.0 - inset, (depth - thick) / 2.0 - inset
    places = np.array([(-x, -z), (-x, z), (x, -z), (x, z)])
    return [
        posts(places[:, 0], places[:, 1], y=(0.0, height), thick=thick, color=color,
              material=material)
    ]  # fmt: skip


def round_leg(x: float, z: float, height: float, *, color: ArrayLike, radius: float = 0.02) -> Part:
    """A turned leg that tapers to the floor."""
    profile = [(0.0, 0.0), (radius * 0.65, 0.0), (radius, height), (0.0, height)]
    return lathe(profile, color=color, material="wood", center=(x, 0.0, z), segments=12)


def spread_legs(
    width: float, depth: float, height: float, *, color: ArrayLike, radius: float = 0.018,
    spread: float = 0.05, material: str = "wood",
) -> list[Part]:  # fmt: skip
    """Four round legs whose feet stand `spread` metres further out than their tops."""
    parts = []
    for x, z in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
        foot = np.array([x * width / 2.0, 0.0, z * depth / 2.0])
        top = foot + np.array([-x * spread, height, -z * spread])
        # The foot is cut level: it stands on the floor with its lower edge.
        lean = radius * 0.6 * spread * 1.42 / height
        parts.append(
            tube([foot + np.array([0.0, lean, 0.0]), (foot + top) / 2.0, top],
                 [radius * 0.6, radius * 0.85, radius], color=color, material=material)
        )  # fmt: skip
    return parts


def cabinet_doors(
    width: float, y0: float, y1: float, z: float, *, count: int, color: ArrayLike,
    x: float = 0.0, grip: str = "bar",
) -> list[Part]:  # fmt: skip
    """Cabinet fronts side by side on the plane `z`, with `bar`, `knob` or `none` as grips."""
    each, tall = width / count, y1 - y0
    middles = x + (np.arange(count) + 0.5) * each - width / 2.0
    sizes = np.tile([each - 0.006, tall, 0.02], (count, 1))
    centers = np.stack([middles, np.full(count, (y0 + y1) / 2.0), np.full(count, z + 0.01)], 1)
    parts = [boxes(sizes, centers, colors=color)]
    inward = np.where(np.arange(count) % 2 == 0, 1.0, -1.0) if count > 1 else np.array([1.0])
    places = np.stack(
        [middles + inward * (each / 2.0 - 0.05), centers[:, 1], np.full(count, z + 0.032)], axis=1
    )
    return parts + _grips(places, min(0.18, 0.5 * tall), grip, upright=True)


def drawers(
    width: float, y0: float, y1: float, z: float, *, count: int, color: ArrayLike,
    x: float = 0.0, grip: str = "bar",
) -> list[Part]:  # fmt: skip
    """Drawer fronts above one another on the plane `z`."""
    each = (y1 - y0) / count
    middles = y0 + (np.arange(count) + 0.5) * each
    sizes = np.tile([width - 0.006, each - 0.008, 0.02], (count, 1))
    centers = np.stack([np.full(count, x), middles, np.full(count, z + 0.01)], axis=1)
    places = centers + np.array([0.0, 0.18 * each, 0.022])
    return [
        boxes(sizes, centers, colors=color),
        *_grips(places, min(0.4 * width, 0.22), grip, upright=False),
    ]


def _grips(places: np.ndarray, length: float, grip: str, *, upright: bool) -> list[Part]:
    if grip == "none":
        return []
    if grip == "knob":
        profile = [(0.0, -0.012), (0.007, -0.012), (0.014, 0.004), (0.012, 0.012), (0.0, 0.014)]
        knob = lathe(profile, color=METAL * 0.9, segments=10, smooth=True).tilted(np.pi / 2.0)
        return [knob.moved(*(float(value) for value in place)) for place in places]
    size = (0.012, length, 0.014) if upright else (length, 0.012, 0.014)
    stub = (0.01, 0.01, 0.016)
    shift = np.array(
        [0.0, length / 2.0 - 0.02, 0.0] if upright else [length / 2.0 - 0.02, 0.0, 0.0]
    )
    back = np.array([0.0, 0.0, -0.008])
    centers = np.concatenate(
        [places + np.array([0.0, 0.0, 0.004]), places + shift + back, places - shift + back]
    )
    sizes = np.repeat(np.array([size, stub, stub]), len(places), axis=0)
    return [boxes(sizes, centers, colors=METAL * 0.95)]


def frame(
    width: float, height: float, depth: float, *, shelves: int, color: ArrayLike, back: bool,
    foot: float = 0.06,
) -> list[Part]:  # fmt: skip
    """Sides, boards and, on request, the back of a shelf; `shelves` compartments."""
    thick = 0.024
    side = (width - thick) / 2.0
    inner = width - 2.0 * thick
    rows = foot + (height - foot - thick / 2.0) * np.arange(shelves + 1) / shelves
    sizes = [(thick, height, depth)] * 2 + [(inner, thick, depth - 0.004)] * (shelves + 1)
    centers = [(-side, height / 2.0, 0.0), (side, height / 2.0, 0.0)]
    centers += [(0.0, float(y), 0.0) for y in rows]
    if foot > 0.03:
        sizes.append((inner, foot - 0.012, depth - 0.03))
        centers.append((0.0, (foot - 0.012) / 2.0, 0.0))
    parts = [boxes(sizes, centers, colors=color, material="wood")]
    if back:
        size = (inner, height - foot, 0.01)
        parts.append(
            wooden(size, (0.0, (height + foot) / 2.0 - 0.002, -depth / 2.0 + 0.008), color)
        )
    return parts


def hairpins(width: float, depth: float, height: float) -> list[Part]:
    """Bent steel legs at four corners."""
    parts = []
    for x, z in ((-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)):
        foot = np.array([x * width / 2.0, 0.001, z * depth / 2.0])
        for shift in ((-0.09 * x, 0.0), (0.0, -0.09 * z)):
            top = foot + np.array([shift[0], height - 0.001, shift[1]])
            parts.append(tube([foot, (foot + top) / 2.0, top], 0.006, color=BLACK, segments=6))
    return parts
