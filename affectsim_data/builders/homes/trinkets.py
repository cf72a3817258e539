"""Small things that stand on tables and shelves, about the middle of their underside."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes, lathe
from affectsim_data.builders.homes.pieces import BLACK, WHITE
from affectsim_data.builders.homes.shapes import ball, leaves, tube
from affectsim_data.poses import FloatArray

__all__ = [
    "BOOK_INKS",
    "book_row",
    "books",
    "dressed",
    "fruit_bowl",
    "mug",
    "place_setting",
    "vase",
]

BOOK_INKS = np.array(
    [
        [0.72, 0.35, 0.28], [0.28, 0.40, 0.50], [0.85, 0.74, 0.52], [0.36, 0.47, 0.38],
        [0.90, 0.88, 0.83], [0.45, 0.33, 0.40], [0.80, 0.55, 0.32], [0.33, 0.33, 0.36],
        [0.62, 0.66, 0.58], [0.55, 0.27, 0.25],
    ]
)  # fmt: skip
"""Spines of books, sRGB in [0, 1]."""
_PAPER = np.array([0.92, 0.9, 0.84])
_VASES = (
    ((0.0, 0.0), (0.045, 0.0), (0.07, 0.06), (0.06, 0.13), (0.03, 0.18), (0.035, 0.21),
     (0.028, 0.21), (0.022, 0.16), (0.0, 0.15)),
    ((0.0, 0.0), (0.05, 0.0), (0.055, 0.05), (0.05, 0.12), (0.035, 0.2), (0.04, 0.26),
     (0.033, 0.26), (0.028, 0.2), (0.0, 0.19)),
    ((0.0, 0.0), (0.03, 0.0), (0.075, 0.05), (0.08, 0.08), (0.06, 0.115), (0.035, 0.12),
     (0.03, 0.11), (0.0, 0.1)),
)  # fmt: skip


def vase(color: FloatArray, *, rng: np.random.Generator) -> list[Part]:
    """A vase, sometimes with twigs in it."""
    profile = np.array(_VASES[int(rng.integers(len(_VASES)))]) * float(rng.uniform(0.85, 1.15))
    rows = [(float(r), float(y)) for r, y in profile]
    parts = [lathe(rows, color=color, segments=20, smooth=True)]
    if rng.random() < 0.4:
        parts.append(_twigs(float(profile[-1, 1]), rng))
    return parts


def _twigs(y: float, rng: np.random.Generator) -> Part:
    count, rows = 9, 5
    t = np.linspace(0.0, 1.0, rows)
    yaw = rng.uniform(0.0, 2.0 * np.pi, count)
    reach, rise = rng.uniform(0.04, 0.11, count), rng.uniform(0.16, 0.28, count)
    spines = np.stack(
        [
            np.outer(reach * np.sin(yaw), t**1.5),
            y + np.outer(rise, t),
            np.outer(reach * np.cos(yaw), t**1.5),
        ],
        axis=-1,
    )
    half = np.tile(0.003 + 0.014 * np.sin(np.pi * t) ** 2, (count, 1))
    green = np.array([0.47, 0.55, 0.38]) * rng.uniform(0.85, 1.15, (count, 1))
    return leaves(spines, half, colors=green)


def books(*, rng: np.random.Generator, most: int = 4) -> list[Part]:
    """A lying pile of books."""
    count = int(rng.integers(2, most + 1))
    widths, deep = rng.uniform(0.2, 0.27, count), rng.uniform(0.14, 0.19, count)
    thick = rng.uniform(0.018, 0.035, count)
    low = np.concatenate([[0.0], np.cumsum(thick)[:-1]])
    parts = []
    for k in range(count):
        cover = BOOK_INKS[int(rng.integers(len(BOOK_INKS)))]
        middle = low[k] + thick[k] / 2.0
        pages = (widths[k] - 0.012, thick[k] - 0.006, deep[k] - 0.004)
        block = boxes(
            [pages, (widths[k], 0.003, deep[k]), (widths[k], 0.003, deep[k]),
             (0.003, thick[k], deep[k])],
            [(0.0, middle, 0.0), (0.0, low[k] + 0.0015, 0.0),
             (0.0, low[k] + thick[k] - 0.0015, 0.0), (-widths[k] / 2.0 + 0.0015, middle, 0.0)],
            colors=[_PAPER, cover, cover, cover],
        )  # fmt: skip
        parts.append(block.moved(yaw=float(rng.uniform(-0.2, 0.2))))
    return parts


def book_row(
    start: float, end: float, *, y: float, z: float, tall: float, rng: np.random.Generator,
    deep: float = 0.19,
) -> list[Part]:  # fmt: skip
    """A row of standing books between two x; the last places stay empty."""
    if end - start < 0.08:
        return []
    most = int((end - start) / 0.018) + 1
    thick = rng.uniform(0.018, 0.045, most)
    right = start + np.cumsum(thick + 0.0015)
    count = int((right < start + (end - start) * float(rng.uniform(0.5, 0.98))).sum())
    if count == 0:
        return []
    thick, right = thick[:count], right[:count]
    heights = tall * rng.uniform(0.68, 0.95, count)
    reach = deep * rng.uniform(0.82, 1.0, count)
    inks = BOOK_INKS[rng.integers(len(BOOK_INKS), size=count)] * rng.uniform(0.9, 1.08, (count, 1))
    centers = np.stack([right - thick / 2.0, y + heights / 2.0, np.full(count, z)], axis=1)
    covers = boxes(np.stack([thick, heights, reach], axis=1), centers, colors=np.clip(inks, 0, 1))
    # The block of pages shows between the covers from above.
    page = np.stack([thick - 0.008, np.full(count, 0.002), reach - 0.004], axis=1)
    upper = centers + np.stack([np.zeros(count), heights / 2.0 + 0.001, np.zeros(count)], axis=1)
    return [covers, boxes(page, upper, colors=_PAPER, sides="xXYzZ")]


def fruit_bowl(color: FloatArray, *, rng: np.random.Generator) -> list[Part]:
    """A bowl with three to five fruits."""
    bowl = [(0.0, 0.0), (0.05, 0.0), (0.09, 0.02), (0.15, 0.085), (0.14, 0.085), (0.08, 0.03),
            (0.0, 0.025)]  # fmt: skip
    parts = [lathe(bowl, color=color, segments=28)]
    inks = np.array([[0.86, 0.60, 0.28], [0.75, 0.28, 0.22], [0.62, 0.68, 0.3]])
    for k in range(int(rng.integers(3, 6))):
        angle = 2.0 * np.pi * k / 5.0
        at = (0.055 * float(np.cos(angle)), 0.072, 0.055 * float(np.sin(angle)))
        parts.append(ball(0.036, at, color=inks[int(rng.integers(3))]))
    return parts


def mug(color: FloatArray) -> list[Part]:
    """A cup with a handle."""
    profile = [(0.0, 0.0), (0.036, 0.0), (0.04, 0.004), (0.04, 0.092), (0.036, 0.092),
               (0.034, 0.012), (0.0, 0.01)]  # fmt: skip
    angle = np.linspace(-0.45 * np.pi, 0.45 * np.pi, 7)
    ear = np.stack([0.036 + 0.026 * np.cos(angle), 0.048 + 0.03 * np.sin(angle), 0.0 * angle], 1)
    return [lathe(profile, color=color, segments=16), tube(ear, 0.005, color=color, segments=6)]


def place_setting(color: FloatArray) -> list[Part]:
    """A plate between knife and fork, with a glass behind it."""
    plate = [(0.0, 0.0), (0.08, 0.0), (0.13, 0.018), (0.127, 0.02), (0.08, 0.005), (0.0, 0.005)]
    glass = [(0.0, 0.0), (0.028, 0.0), (0.036, 0.11), (0.033, 0.11), (0.026, 0.008), (0.0, 0.007)]
    steel = np.array([0.74, 0.74, 0.73])
    cutlery = boxes([(0.016, 0.003, 0.2)] * 2, [(-0.165, 0.0015, 0.0), (0.165, 0.0015, 0.0)],
                    colors=steel)  # fmt: skip
    return [
        lathe(plate, color=color, segments=24), cutlery,
        lathe(glass, color=(0.82, 0.87, 0.88), segments=14, center=(0.12, 0.0, -0.15)),
    ]  # fmt: skip


def _candles(rng: np.random.Generator) -> list[Part]:
    parts = []
    for k in range(2):
        tall, x = float(rng.uniform(0.1, 0.2)), 0.09 * k - 0.045
        parts += [
            lathe([(0.0, 0.0), (0.038, 0.0), (0.038, 0.01), (0.0, 0.012)], color=BLACK,
                  center=(x, 0.0, 0.0), segments=16),
            lathe([(0.0, 0.01), (0.02, 0.01), (0.02, tall), (0.0, tall)], color=_PAPER,
                  center=(x, 0.0, 0.0), segments=12),
        ]  # fmt: skip
    return parts


def _photo(palette: Palette, rng: np.random.Generator) -> list[Part]:
    wide, tall = (0.13, 0.18) if rng.random() < 0.5 else (0.2, 0.15)
    tilt, color = -0.2, palette.dark_wood
    whole = [
        box((wide, tall, 0.014), (0.0, tall / 2.0, 0.0), color=color, material="wood"),
        box((wide - 0.03, tall - 0.03, 0.003), (0.0, tall / 2.0, 0.0088), color=_PAPER),
        box((wide - 0.07, tall - 0.07, 0.002), (0.0, tall / 2.0, 0.0112), color=palette.accent),
    ]
    foot = box((0.03, 0.6 * tall, 0.006), (0.0, 0.3 * tall, 0.0), color=color).tilted(0.35)
    back = float(np.sin(0.2)) * tall * 0.55
    lift = 0.007 * float(np.sin(-tilt))
    return [
        *(part.tilted(tilt).moved(y=lift) for part in whole),
        foot.moved(0.0, 0.0012, -back - 0.03),
    ]


def _box(palette: Palette, rng: np.random.Generator) -> list[Part]:
    """A lidded box."""
    wide, tall, deep = (float(v) for v in rng.uniform((0.16, 0.08, 0.14), (0.28, 0.14, 0.2)))
    return [
        box((wide, tall, deep), (0.0, tall / 2.0, 0.0), color=palette.textile, material="fabric"),
        box((wide + 0.01, 0.03, deep + 0.01), (0.0, tall + 0.012, 0.0), color=palette.textile * 0.9,
            material="fabric"),
    ]  # fmt: skip


def _bowl(palette: Palette) -> list[Part]:
    bowl = [(0.0, 0.0), (0.04, 0.0), (0.07, 0.015), (0.115, 0.07), (0.108, 0.07), (0.06, 0.022),
            (0.0, 0.018)]  # fmt: skip
    return [lathe(bowl, color=palette.accent, segments=24)]


def _herb(palette: Palette, rng: np.random.Generator) -> list[Part]:
    """A small pot with a leafy plant."""
    pot = [(0.0, 0.0), (0.045, 0.0), (0.06, 0.1), (0.053, 0.1), (0.05, 0.085), (0.0, 0.085)]
    count, rows = 18, 4
    t = np.linspace(0.0, 1.0, rows)
    yaw = 2.4 * np.arange(count)
    reach, rise = rng.uniform(0.04, 0.1, count), rng.uniform(0.06, 0.17, count)
    spines = np.stack(
        [
            np.outer(reach * np.sin(yaw), t**1.3),
            0.08 + np.outer(rise, np.sin(2.0 * t) / np.sin(1.57)),
            np.outer(reach * np.cos(yaw), t**1.3),
        ],
        axis=-1,
    )
    half = np.tile(0.004 + 0.02 * np.sin(np.pi * t**0.7), (count, 1))
    green = np.array([0.38, 0.55, 0.32]) * rng.uniform(0.85, 1.15, (count, 1))
    color = palette.accent if rng.random() < 0.5 else WHITE
    return [lathe(pot, color=color, segments=18), leaves(spines, half, colors=green)]


def _trinket(palette: Palette, rng: np.random.Generator) -> list[Part]:
    kind = int(rng.integers(8))
    if kind <= 1:
        return books(rng=rng)
    if kind == 2:
        return vase(palette.accent, rng=rng)
    if kind == 3:
        return _candles(rng)
    if kind == 4:
        return _photo(palette, rng)
    if kind == 5:
        return _box(palette, rng)
    if kind == 6:
        return _bowl(palette)
    return _herb(palette, rng)


_HALF_WIDTH_M = 0.16
"""No small thing reaches further from its middle."""


def dressed(
    palette: Palette, *, rng: np.random.Generator, y: float, width: float, depth: float,
    share: float = 0.5, x: float = 0.0, z: float = 0.0, keep: tuple[float, float] | None = None,
) -> list[Part]:  # fmt: skip
    """Small things on a top, in a row with gaps.

    Args:
        palette: Colours of the home.
        rng: Chooses them.
        y: Height of the top, metres.
        width: Of the top, metres.
        depth: Of the top, metres.
        share: Chance of each place to be taken.
        x: Middle of the top in the piece, metres.
        z: The same for its depth.
        keep: Ends along x to leave free, in the piece, metres.
    """
    places = int(width / (2.0 * _HALF_WIDTH_M))
    parts: list[Part] = []
    for k in range(places):
        at = x + (k + 0.5) * width / places - width / 2.0
        if keep is not None and keep[0] - _HALF_WIDTH_M < at < keep[1] + _HALF_WIDTH_M:
            continue
        if rng.random() >= share:
            continue
        slack = max(depth / 2.0 - 0.15, 0.0)
        shift = float(rng.uniform(-slack, slack))
        parts += [part.moved(at, y, z + shift) for part in _trinket(palette, rng)]
    return parts
