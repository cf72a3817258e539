"""Tables, desks and what belongs on them."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.homes.joinery import drawers, hairpins, legs, spread_legs, wooden
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, boxes, lathe
from affectsim_data.builders.homes.pieces import BLACK, DARK, METAL, WHITE, Furniture, Top, piece
from affectsim_data.builders.homes.shapes import oval, rounded, slab, tube
from affectsim_data.builders.homes.trinkets import (
    books,
    dressed,
    fruit_bowl,
    mug,
    place_setting,
    vase,
)

__all__ = [
    "coffee_block", "coffee_oval", "coffee_plain", "coffee_round", "desk", "desk_trestle",
    "dining_oval", "dining_plain", "dining_round", "dining_trestle", "monitor", "side_table",
]  # fmt: skip

TABLE_Y = 0.74
"""Height of dining tables and desks, metres."""


def _laid(
    palette: Palette, *, rng: np.random.Generator, width: float, depth: float, round_top: bool
) -> list[Part]:
    """What stands on a dining table: a bowl or a vase, sometimes laid places."""
    parts: list[Part] = []
    draw = float(rng.random())
    if draw < 0.45:
        parts += [part.moved(y=TABLE_Y) for part in fruit_bowl(palette.accent, rng=rng)]
    elif draw < 0.85:
        parts += [part.moved(y=TABLE_Y) for part in vase(palette.accent, rng=rng)]
    if rng.random() < 0.45:
        reach = depth / 2.0 - 0.22
        xs = (0.0,) if round_top else (-width / 4.0, width / 4.0)
        for x in xs:
            for turn in (0.0, np.pi):
                for part in place_setting(WHITE):
                    set_down = part.moved(0.0, TABLE_Y, reach).moved(yaw=turn)
                    parts.append(set_down.moved(x))
    return parts


def dining_plain(palette: Palette, *, rng: np.random.Generator, width: float = 1.6) -> Furniture:
    """A table on four legs."""
    depth, color = float(rng.uniform(0.85, 0.95)), palette.wood
    parts = [
        wooden((width, 0.035, depth), (0.0, TABLE_Y - 0.0175, 0.0), color, radius=0.01),
        wooden((width - 0.24, 0.07, depth - 0.24), (0.0, TABLE_Y - 0.07, 0.0), color),
        *legs(width, depth, TABLE_Y - 0.03, thick=0.065, color=color, inset=0.02),
        *_laid(palette, rng=rng, width=width, depth=depth, round_top=False),
    ]
    return piece("table", parts, (width, depth, TABLE_Y))


def dining_trestle(palette: Palette, *, rng: np.random.Generator, width: float = 1.8) -> Furniture:
    """A heavy top on two steel frames."""
    depth = float(rng.uniform(0.88, 0.96))
    parts = [
        slab(rounded(width, depth, 0.03), TABLE_Y, 0.045, color=palette.wood, bevel=0.006),
        *_laid(palette, rng=rng, width=width, depth=depth, round_top=False),
    ]
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.1)
        bars = [(0.07, 0.04, depth - 0.14), (0.07, 0.04, depth - 0.14)]
        middles = [(x, 0.02, 0.0), (x, TABLE_Y - 0.065, 0.0)]
        uprights = [(0.068, TABLE_Y - 0.125, 0.04)] * 2
        feet = [(x, (TABLE_Y - 0.045) / 2.0, z * (depth / 2.0 - 0.1)) for z in (-1.0, 1.0)]
        parts.append(boxes([*bars, *uprights], [*middles, *feet], colors=BLACK))
    return piece("table", parts, (width, depth, TABLE_Y))


def _pedestal(color: np.ndarray) -> list[Part]:
    profile = [(0.0, 0.0), (0.3, 0.0), (0.29, 0.02), (0.09, 0.06), (0.05, 0.2), (0.045, 0.5),
               (0.08, 0.66), (0.16, 0.7), (0.0, 0.7)]  # fmt: skip
    return [lathe(profile, color=color, material="wood", segments=26)]


def dining_round(palette: Palette, *, rng: np.random.Generator, width: float = 1.1) -> Furniture:
    """A round table on a turned foot."""
    parts = [
        slab(oval(width, width, count=44), TABLE_Y, 0.032, color=palette.wood, bevel=0.008),
        *_pedestal(palette.wood if rng.random() < 0.6 else palette.dark_wood),
        *_laid(palette, rng=rng, width=width, depth=width, round_top=True),
    ]
    return piece("table", parts, (width, width, TABLE_Y))


def dining_oval(palette: Palette, *, rng: np.random.Generator, width: float = 1.7) -> Furniture:
    """An oval table on two feet."""
    depth = 1.0
    foot = [(0.0, 0.0), (0.24, 0.0), (0.23, 0.02), (0.07, 0.05), (0.05, 0.3), (0.06, 0.62),
            (0.14, 0.7), (0.0, 0.7)]  # fmt: skip
    parts = [
        slab(oval(width, depth, count=48), TABLE_Y, 0.032, color=palette.wood, bevel=0.008),
        *_laid(palette, rng=rng, width=width * 0.8, depth=depth, round_top=True),
    ]
    for sign in (-1.0, 1.0):
        at = (sign * (width / 2.0 - 0.5), 0.0, 0.0)
        parts.append(lathe(foot, color=palette.dark_wood, material="wood", segments=22, center=at))
    return piece("table", parts, (width, depth, TABLE_Y))


def coffee_plain(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A low table with a shelf under its top."""
    width, depth, height = float(rng.uniform(0.95, 1.15)), 0.58, float(rng.uniform(0.4, 0.44))
    color = palette.wood
    parts = [
        wooden((width, 0.03, depth), (0.0, height - 0.015, 0.0), color, radius=0.008),
        wooden((width - 0.13, 0.018, depth - 0.13), (0.0, 0.15, 0.0), color),
        *legs(width, depth, height - 0.028, thick=0.045, color=palette.dark_wood),
        *[part.moved(-0.15, 0.159, 0.0) for part in books(rng=rng)],
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth, share=0.75),
    ]
    return piece("table", parts, (width, depth, height))


def coffee_round(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A round low table on splayed legs."""
    width, height = float(rng.uniform(0.75, 0.9)), float(rng.uniform(0.39, 0.43))
    parts = [
        slab(oval(width, width), height, 0.028, color=palette.wood, bevel=0.008),
        *spread_legs(width - 0.18, width - 0.18, height - 0.026, color=palette.wood, radius=0.022,
                     spread=0.07),
        *dressed(palette, rng=rng, y=height, width=0.5, depth=0.4, share=0.85),
    ]  # fmt: skip
    return piece("table", parts, (width, width, height))


def coffee_oval(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """An oval low table on steel legs."""
    width, depth, height = 1.1, 0.6, 0.41
    parts = [
        slab(oval(width, depth), height, 0.024, color=palette.dark_wood, bevel=0.006),
        *hairpins(width - 0.36, depth - 0.2, height - 0.02),
        *dressed(palette, rng=rng, y=height, width=0.75, depth=0.35, share=0.8),
    ]
    return piece("table", parts, (width, depth, height))


def coffee_block(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A low box of a table with an open compartment."""
    width, depth, height = 0.9, 0.6, 0.38
    color = palette.cabinet
    parts = [
        boxes([(width, 0.03, depth), (width, 0.03, depth), (0.03, height - 0.11, depth - 0.004),
               (0.03, height - 0.11, depth - 0.004)],
              [(0.0, height - 0.015, 0.0), (0.0, 0.065, 0.0),
               (-width / 2.0 + 0.017, height / 2 + 0.025, 0.0),
               (width / 2.0 - 0.017, height / 2 + 0.025, 0.0)], colors=color),
        box((width - 0.1, 0.05, depth - 0.1), (0.0, 0.025, 0.0), color=DARK),
        *[part.moved(0.1, 0.08, 0.0) for part in books(rng=rng)],
        *dressed(palette, rng=rng, y=height, width=width - 0.1, depth=depth, share=0.7),
    ]  # fmt: skip
    return piece("table", parts, (width, depth, height))


def side_table(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A small round table for a cup and a lamp."""
    width, height = float(rng.uniform(0.42, 0.5)), float(rng.uniform(0.48, 0.55))
    parts = [slab(oval(width, width, count=30), height, 0.022, color=palette.wood, bevel=0.006)]
    if rng.random() < 0.5:
        parts += spread_legs(width - 0.1, width - 0.1, height - 0.02, color=palette.wood,
                             radius=0.016, spread=0.06)  # fmt: skip
    else:
        foot = [(0.0, 0.0), (0.15, 0.0), (0.15, 0.012), (0.016, 0.02), (0.016, height - 0.022),
                (0.0, height - 0.022)]  # fmt: skip
        parts.append(lathe(foot, color=BLACK, segments=22))
    return piece(
        "table", parts, (width, width, height), tops=[Top(height, width * 0.6, width * 0.6)]
    )


def desk(palette: Palette, *, rng: np.random.Generator, width: float = 1.4) -> Furniture:
    """A desk with a set of drawers on one side."""
    depth, color = 0.66, palette.wood
    x = width / 2.0 - 0.25
    parts = [
        wooden((width, 0.03, depth), (0.0, TABLE_Y - 0.015, 0.0), color, radius=0.008),
        wooden((0.42, 0.6, depth - 0.1), (x, 0.41, -0.01), palette.cabinet),
        box((0.38, 0.11, depth - 0.16), (x, 0.055, -0.01), color=palette.dark_wood,
            material="wood"),
        *drawers(0.4, 0.13, 0.69, depth / 2.0 - 0.06, count=3, color=palette.cabinet, x=x),
        boxes([(0.04, TABLE_Y - 0.03, 0.04)] * 2,
              [(-width / 2.0 + 0.05, (TABLE_Y - 0.03) / 2.0, z) for z in (-0.28, 0.28)],
              colors=palette.dark_wood, material="wood"),
        wooden((0.02, 0.05, depth - 0.14), (-width / 2.0 + 0.05, 0.69, 0.0), palette.dark_wood),
        *_desktop(palette, rng, width),
    ]  # fmt: skip
    return piece("desk", parts, (width, depth, TABLE_Y), tops=[_screen_place()])


def desk_trestle(palette: Palette, *, rng: np.random.Generator, width: float = 1.5) -> Furniture:
    """A plate on two pairs of crossed legs."""
    depth = 0.7
    parts = [wooden((width, 0.032, depth), (0.0, TABLE_Y - 0.016, 0.0), palette.wood, radius=0.008)]
    for sign in (-1.0, 1.0):
        x = sign * (width / 2.0 - 0.22)
        for lean in (-1.0, 1.0):
            ends = [
                (x, 0.006, lean * 0.272),
                (x, 0.37, lean * 0.17),
                (x, TABLE_Y - 0.05, lean * 0.07),
            ]
            parts.append(tube(ends, 0.018, color=palette.dark_wood, material="wood"))
        parts.append(wooden((0.04, 0.034, 0.5), (x, TABLE_Y - 0.05, 0.0), palette.dark_wood))
        parts.append(wooden((0.024, 0.03, 0.36), (x, 0.34, 0.0), palette.dark_wood))
    parts += _desktop(palette, rng, width)
    return piece("desk", parts, (width, depth, TABLE_Y), tops=[_screen_place()])


def _screen_place() -> Top:
    return Top(TABLE_Y, 0.6, 0.24, x=-0.1, z=-0.17)


def _desktop(palette: Palette, rng: np.random.Generator, width: float) -> list[Part]:
    """Keyboard, mouse and small things; the place of the screen stays free."""
    parts: list[Part] = [
        box((0.42, 0.016, 0.14), (-0.1, TABLE_Y + 0.008, 0.13), color=(0.75, 0.75, 0.75)),
        boxes(
            [(0.022, 0.006, 0.02)] * 48,
            [(-0.1 - 0.19 + 0.0253 * (k % 16), TABLE_Y + 0.018, 0.09 + 0.04 * (k // 16))
             for k in range(48)],
            colors=(0.9, 0.9, 0.9),
        ),
        box((0.06, 0.025, 0.1), (0.2, TABLE_Y + 0.0125, 0.13), color=DARK, radius=0.011),
        *[part.moved(0.33, TABLE_Y, 0.1) for part in mug(palette.accent)],
        *dressed(palette, rng=rng, y=TABLE_Y, width=width - 0.1, depth=0.3, z=-0.12,
                 keep=(-0.4, 0.2), share=0.8),
    ]  # fmt: skip
    return parts


def monitor(palette: Palette, *, rng: np.random.Generator) -> Furniture:
    """A computer screen on its foot."""
    width = float(rng.uniform(0.52, 0.62))
    parts = [
        slab(rounded(0.22, 0.16, 0.02), 0.012, 0.012, color=DARK, material="plain", bevel=0.003),
        box((0.05, 0.17, 0.02), (0.0, 0.0955, -0.03), color=DARK),
        box((width, 0.35, 0.025), (0.0, 0.3, 0.0), color=DARK, step=0.2),
        box((width - 0.03, 0.32, 0.004), (0.0, 0.302, 0.0135), color=(0.36, 0.45, 0.55), step=0.15),
        box((0.12, 0.1, 0.02), (0.0, 0.22, -0.022), color=METAL * 0.6),
    ]  # fmt: skip
    return piece("monitor", parts, (width, 0.2, 0.476))
