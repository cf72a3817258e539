"""Counters, islands, fridges and what is cooked with. Every piece stands on the floor."""

from __future__ import annotations

import itertools

import numpy as np

from affectsim_data.builders.homes.joinery import cabinet_doors, drawers
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes, lathe
from affectsim_data.builders.homes.pieces import DARK, METAL, WHITE, Furniture, Top, piece
from affectsim_data.builders.homes.shapes import ball, tube
from affectsim_data.builders.homes.trinkets import dressed, fruit_bowl, mug

__all__ = ["COUNTER_ROOM", "COUNTER_Y", "counter", "fridge", "fridge_steel", "island"]

COUNTER_DEPTH, COUNTER_ROOM = 0.62, 0.65
"""Depth of its top, and with handles, metres."""
COUNTER_Y = 0.9
_STONE = np.array([0.86, 0.85, 0.83])
_GLASS = np.array([0.2, 0.2, 0.22])
_UPPER = (1.46, 2.14)
"""Lower and upper edge of wall cabinets, metres."""


def _sink(x: float) -> list[Part]:
    """A steel basin let into the top, and a bent tap behind it."""
    angle = np.linspace(0.0, np.pi, 9)
    bow = np.stack([0.0 * angle, 0.24 + 0.07 * np.sin(angle), -0.15 - 0.07 * np.cos(angle)], axis=1)
    spout = np.concatenate([[(0.0, 0.0, -0.22), (0.0, 0.12, -0.22)], bow, [(0.0, 0.2, -0.08)]])
    rim = boxes(
        [(0.52, 0.008, 0.03), (0.52, 0.008, 0.03), (0.03, 0.008, 0.36), (0.03, 0.008, 0.36)],
        [(x, 0.004, -0.165), (x, 0.004, 0.215), (x - 0.245, 0.004, 0.025),
         (x + 0.245, 0.004, 0.025)],
        colors=METAL * 1.1,
    )  # fmt: skip
    drain = lathe([(0.0, 0.0025), (0.035, 0.0025), (0.035, 0.005), (0.0, 0.005)], segments=16,
                  color=METAL * 0.5, center=(x, 0.0, 0.02))  # fmt: skip
    basin = box((0.465, 0.0025, 0.355), (x, 0.00125, 0.025), color=METAL * 0.72)
    tap = tube(spout, 0.011, color=METAL * 1.1).moved(x)
    lever = tube([(x, 0.06, -0.22), (x + 0.03, 0.075, -0.22), (x + 0.07, 0.1, -0.22)], 0.006,
                 color=METAL * 1.1, segments=6)  # fmt: skip
    return [part.moved(y=COUNTER_Y) for part in (rim, basin, drain, tap, lever)]


def _hob(x: float, rng: np.random.Generator) -> list[Part]:
    """A glass hob with four rings, often a pot on it."""
    y = COUNTER_Y + 0.008
    parts = [box((0.57, 0.008, 0.5), (x, COUNTER_Y + 0.004, 0.0), color=_GLASS)]
    for dx, dz in itertools.product((-0.13, 0.13), (-0.11, 0.11)):
        ring = [(0.075, 0.0), (0.09, 0.0), (0.09, 0.0025), (0.075, 0.0025)]
        parts.append(lathe(ring, color=_GLASS * 1.9, center=(x + dx, y, dz), segments=22))
    if rng.random() < 0.7:
        parts += _pot(x + 0.13, y + 0.0025, -0.11, rng)
    if rng.random() < 0.35:
        parts += _pot(x - 0.13, y + 0.0025, 0.11, rng)
    return parts


def _pot(x: float, y: float, z: float, rng: np.random.Generator) -> list[Part]:
    wide, tall = float(rng.uniform(0.085, 0.11)), float(rng.uniform(0.09, 0.15))
    color = METAL * 1.1 if rng.random() < 0.6 else np.array([0.62, 0.24, 0.2])
    body = [(0.0, 0.0), (wide, 0.0), (wide, tall), (wide * 0.97, tall + 0.008), (0.02, tall + 0.02),
            (0.0, tall + 0.02)]  # fmt: skip
    parts = [lathe(body, color=color, segments=24, center=(x, y, z)),
             ball(0.014, (x, y + tall + 0.03, z), color=DARK, segments=10)]  # fmt: skip
    for sign in (-1.0, 1.0):
        ear = [(x + sign * wide * 0.98, y + tall * 0.75, z - 0.03),
               (x + sign * (wide + 0.03), y + tall * 0.75, z),
               (x + sign * wide * 0.98, y + tall * 0.75, z + 0.03)]  # fmt: skip
        parts.append(tube(ear, 0.006, color=DARK, segments=6))
    return parts


def _oven(x: float, z: float) -> list[Part]:
    """The front of an oven: glass door, rail, knobs."""
    bar = [(x - 0.22, 0.68, z + 0.05), (x, 0.68, z + 0.05), (x + 0.22, 0.68, z + 0.05)]
    parts = [
        box((0.585, 0.6, 0.02), (x, 0.42, z + 0.01), color=_GLASS),
        box((0.44, 0.32, 0.004), (x, 0.42, z + 0.022), color=_GLASS * 1.6),
        box((0.585, 0.11, 0.02), (x, 0.785, z + 0.01), color=METAL),
        tube(bar, 0.009, color=METAL),
        boxes([(0.012, 0.012, 0.034)] * 2, [(x - 0.2, 0.68, z + 0.035), (x + 0.2, 0.68, z + 0.035)],
              colors=METAL),
    ]  # fmt: skip
    for k in range(4):
        knob = lathe([(0.0, 0.0), (0.019, 0.0), (0.016, 0.022), (0.0, 0.022)], color=DARK,
                     segments=12)  # fmt: skip
        at = x - 0.18 + 0.12 * k
        parts.append(knob.tilted(np.pi / 2.0).moved(at, 0.785, z + 0.02))
    return parts


def counter(
    palette: Palette, *, rng: np.random.Generator, width: float, sink: bool = True,
    hob: bool = True, uppers: tuple[tuple[float, float], ...] = (),
) -> Furniture:  # fmt: skip
    """Base cabinets under a stone top.

    Args:
        palette: Colours of the home.
        rng: Chooses its units and what stands on it.
        width: Metres.
        sink: Whether it has a sink.
        hob: Whether it has a hob with an oven under it.
        uppers: Spans along x with wall cabinets, metres.
    """
    depth, color = COUNTER_DEPTH, palette.cabinet
    front = depth / 2.0 - 0.04
    count = max(round(width / 0.6), 1)
    each = width / count
    xs = (np.arange(count) + 0.5) * each - width / 2.0
    at_hob = int(3 * count / 4) if hob and width > 1.15 else -1
    at_sink = (count - 1 if at_hob >= 0 and at_hob < count / 2 else int(count / 4)) if sink else -1
    parts = [
        box((width - 0.004, COUNTER_Y - 0.14, depth - 0.04), (0.0, 0.48, -0.02),
            color=color * 0.98),
        box((width - 0.02, 0.1, depth - 0.12), (0.0, 0.05, -0.04), color=DARK),
        box((width, 0.04, depth), (0.0, COUNTER_Y - 0.02, 0.0), color=_STONE, material="stone",
            step=0.25),
    ]  # fmt: skip
    for k, x in enumerate(xs):
        if k == at_hob:
            parts += _oven(float(x), front)
        elif k != at_sink and rng.random() < 0.4:
            parts += drawers(each, 0.11, COUNTER_Y - 0.05, front, count=3, color=color, x=float(x))
        else:
            parts += cabinet_doors(each, 0.11, COUNTER_Y - 0.05, front, count=1, color=color,
                                   x=float(x))  # fmt: skip
    busy = []
    if at_hob >= 0:
        parts += _hob(float(xs[at_hob]), rng)
        busy.append(float(xs[at_hob]))
    if at_sink >= 0:
        parts += _sink(float(xs[at_sink]))
        busy.append(float(xs[at_sink]))
    for x in xs:
        if all(abs(float(x) - other) > 0.45 for other in busy) and rng.random() < 0.7:
            parts += _counter_thing(float(x), palette, rng)
    height = COUNTER_Y
    hob_x = float(xs[at_hob]) if at_hob >= 0 else None
    for low, high in uppers:
        parts += _upper_run(low, high, hob_x, palette)
        height = _UPPER[1]
    return piece("counter", parts, (width, depth, height))


def _upper_run(low: float, high: float, hob_x: float | None, palette: Palette) -> list[Part]:
    """Wall cabinets from `low` to `high` with a hood over the hob, and tiles below them."""
    deep, back = 0.34, -COUNTER_DEPTH / 2.0
    tall, middle = _UPPER[1] - _UPPER[0], (_UPPER[0] + _UPPER[1]) / 2.0
    spans = [(low, high)]
    parts: list[Part] = [
        box((high - low, _UPPER[0] - COUNTER_Y - 0.004, 0.012),
            ((low + high) / 2.0, (_UPPER[0] + COUNTER_Y) / 2.0, back + 0.006),
            color=(0.88, 0.89, 0.88), material="wall_tiles", step=0.3)
    ]  # fmt: skip
    if hob_x is not None and low + 0.3 <= hob_x <= high - 0.3:
        parts += _hood(hob_x, back)
        spans = [(low, hob_x - 0.305), (hob_x + 0.305, high)]
    for start, end in spans:
        if end - start < 0.25:
            continue
        x, width = (start + end) / 2.0, end - start - 0.002
        parts.append(box((width, tall, deep - 0.02), (x, middle, back + deep / 2.0 - 0.01),
                         color=palette.cabinet * 0.98))  # fmt: skip
        count = max(round(width / 0.5), 1)
        parts += cabinet_doors(width, _UPPER[0] + 0.005, _UPPER[1] - 0.005, back + deep - 0.02,
                               count=count, color=palette.cabinet, x=x)  # fmt: skip
    return parts


def _hood(x: float, back: float) -> list[Part]:
    """A steel hood with a chimney."""
    return [
        box((0.6, 0.06, 0.46), (x, 1.6, back + 0.23), color=METAL * 1.1),
        box((0.5, 0.02, 0.36), (x, 1.563, back + 0.23), color=METAL * 0.6),
        box((0.28, 0.51, 0.24), (x, 1.885, back + 0.12), color=METAL * 1.08),
        boxes([(0.016, 0.008, 0.006)] * 4,
              [(x - 0.06 + 0.04 * k, 1.6, back + 0.463) for k in range(4)], colors=DARK),
    ]  # fmt: skip


def _counter_thing(x: float, palette: Palette, rng: np.random.Generator) -> list[Part]:
    kind = int(rng.integers(5))
    z = float(rng.uniform(-0.14, -0.08))
    if kind == 0:
        made = _kettle()
    elif kind == 1:
        made = [box((0.3, 0.19, 0.19), (0.0, 0.107, 0.0), color=METAL, radius=0.03, segments=2),
                boxes([(0.24, 0.002, 0.03)] * 2, [(0.0, 0.204, -0.035), (0.0, 0.204, 0.035)],
                      colors=DARK),
                box((0.26, 0.012, 0.16), (0.0, 0.006, 0.0), color=DARK)]  # fmt: skip
    elif kind == 2:
        made = [*(part.moved(-0.09) for part in mug(palette.accent)),
                *(part.moved(0.06, 0.0, 0.05) for part in mug(WHITE))]  # fmt: skip
    elif kind == 3:
        made = fruit_bowl(palette.accent, rng=rng)
    else:
        made = _block(palette)
    return [part.moved(x, COUNTER_Y, z) for part in made]


def _kettle() -> list[Part]:
    body = [(0.0, 0.0), (0.085, 0.0), (0.08, 0.03), (0.065, 0.17), (0.05, 0.2), (0.02, 0.215),
            (0.0, 0.215)]  # fmt: skip
    ear = [(0.06, 0.18, 0.0), (0.12, 0.19, 0.0), (0.13, 0.12, 0.0), (0.085, 0.05, 0.0)]
    return [lathe(body, color=METAL * 1.1, segments=20), tube(ear, 0.011, color=DARK),
            ball(0.014, (0.0, 0.225, 0.0), color=DARK, segments=10)]  # fmt: skip


def _block(palette: Palette) -> list[Part]:
    """Boards and jars."""
    board = box((0.24, 0.32, 0.018), (0.0, 0.16, 0.0), color=palette.wood, material="wood")
    parts = [board.tilted(-0.14).moved(0.0, 0.0015, -0.06)]
    for k in range(3):
        tall = 0.16 - 0.03 * k
        jar = [(0.0, 0.0), (0.045, 0.0), (0.045, tall), (0.048, tall), (0.048, tall + 0.02),
               (0.0, tall + 0.02)]  # fmt: skip
        parts.append(
            lathe(jar, color=WHITE * 0.97, segments=16, center=(-0.12 + 0.11 * k, 0.0, 0.06))
        )
    return parts


def island(palette: Palette, *, rng: np.random.Generator, width: float = 1.8) -> Furniture:
    """A kitchen island with an overhanging stone top behind, cabinets to the front."""
    height, depth = 0.92, 0.9
    count = max(round(width / 0.55), 2)
    body, z = depth - 0.32, 0.14
    parts = [
        box((width - 0.1, height - 0.04, body), (0.0, (height - 0.04) / 2.0, z),
            color=palette.accent_wall, step=0.3),
        *cabinet_doors(width - 0.12, 0.1, height - 0.06, z + body / 2.0, count=count,
                       color=palette.cabinet),
        box((width, 0.04, depth), (0.0, height - 0.02, 0.0), color=(0.88, 0.87, 0.85),
            material="stone", step=0.25),
        *dressed(palette, rng=rng, y=height, width=width - 0.2, depth=depth - 0.3, share=0.4),
    ]  # fmt: skip
    return piece("counter", parts, (width, depth, height), tops=[Top(height, width - 0.2, 0.5)])


def fridge(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A fridge with a freezer below."""
    color = np.array([0.9, 0.9, 0.89]) if rng.random() < 0.6 else np.array([0.82, 0.83, 0.84])
    height = float(rng.uniform(1.75, 1.95))
    split = 0.68
    parts = [
        box((0.6, height - 0.02, 0.58), (0.0, height / 2.0 + 0.01, -0.035), color=color * 0.95),
        box((0.55, 0.02, 0.5), (0.0, 0.01, -0.035), color=DARK),
        box((0.596, height - split - 0.01, 0.045), (0.0, (height + split) / 2.0, 0.28), color=color,
            radius=0.012, segments=2),
        box((0.596, split - 0.06, 0.045), (0.0, split / 2.0 + 0.02, 0.28), color=color,
            radius=0.012, segments=2),
    ]  # fmt: skip
    for y0, y1 in ((split + 0.1, split + 0.55), (split - 0.38, split - 0.06)):
        bar = [(-0.25, y0, 0.325), (-0.25, (y0 + y1) / 2.0, 0.325), (-0.25, y1, 0.325)]
        parts.append(tube(bar, 0.009, color=METAL))
        stubs = [(-0.25, y0 + 0.02, 0.31), (-0.25, y1 - 0.02, 0.31)]
        parts.append(boxes([(0.012, 0.012, 0.03)] * 2, stubs, colors=METAL))
    return piece("fridge", parts, (0.62, 0.68, height))


def fridge_steel(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A broad steel fridge with two doors and a drawer."""
    width, height, color = 0.8, 1.8, np.array([0.72, 0.73, 0.74])
    parts = [
        box((width - 0.01, height - 0.03, 0.6), (0.0, height / 2.0 + 0.015, -0.035),
            color=color * 0.8),
        box((width - 0.06, 0.03, 0.54), (0.0, 0.015, -0.035), color=DARK),
        box((width - 0.01, 0.56, 0.045), (0.0, 0.35, 0.29), color=color, radius=0.012, segments=2),
    ]  # fmt: skip
    half = (width - 0.016) / 2.0
    for sign in (-1.0, 1.0):
        x = sign * (half / 2.0 + 0.003)
        parts.append(box((half, height - 0.66, 0.045), (x, (height + 0.64) / 2.0, 0.29),
                         color=color, radius=0.012, segments=2))  # fmt: skip
        bar = [(sign * 0.05, 0.95, 0.34), (sign * 0.05, 1.2, 0.34), (sign * 0.05, 1.45, 0.34)]
        parts.append(tube(bar, 0.009, color=METAL * 1.2))
        parts.append(boxes([(0.012, 0.012, 0.034)] * 2,
                           [(sign * 0.05, 0.97, 0.325), (sign * 0.05, 1.43, 0.325)],
                           colors=METAL * 1.2))  # fmt: skip
    parts.append(tube([(-0.25, 0.56, 0.34), (0.0, 0.56, 0.34), (0.25, 0.56, 0.34)], 0.009,
                      color=METAL * 1.2))  # fmt: skip
    return piece("fridge", parts, (width, 0.7, height))
