"""How well a layout would serve as a home: shapes of rooms, ways between them, daylight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.homes.plans.layout import Layout
from affectsim_data.builders.homes.plans.links import (
    Link,
    choose_links,
    outside_spans,
    shared_walls,
)
from affectsim_data.builders.homes.plans.model import SIDES, Rect
from affectsim_data.builders.homes.purposes import NEEDS_DAYLIGHT, SIZES, Purpose

__all__ = ["judge"]

_LONG_SIGHT_M = 6.5
"""How far one can look in the living room of a home of `_SIGHT_FROM_M2` or more."""
_SIGHT_FROM_M2 = 55.0
_WINDOW_WALL_M = 1.6


def judge(
    purposes: Sequence[Purpose], areas: dict[int, float], layout: Layout, *,
    rng: np.random.Generator,
) -> tuple[float, list[Link]] | None:  # fmt: skip
    """How unlike a home a layout is, 0 at best, and its doorways; none if it cannot be one."""
    rects = {number: layout.inner(number) for number in layout.cells}
    shapes = _shapes(purposes, areas, rects)
    if shapes is None:
        return None
    outside = _outside(purposes, layout)
    if outside is None:
        return None
    linked = choose_links(purposes, shared_walls(layout), rng=rng)
    if linked is None:
        return None
    links, cost = linked
    if layout.area_m2() >= _SIGHT_FROM_M2 and _long_sight_m(rects, links, purposes) < _LONG_SIGHT_M:
        return None
    return shapes + outside + cost - (len(purposes) - 1), links


def _long_sight_m(
    rects: dict[int, Rect], links: Sequence[Link], purposes: Sequence[Purpose]
) -> float:
    """Longest straight look along a wall of the living room, also through wide openings, metres."""
    living = purposes.index("living")
    x0, z0, x1, z1 = rects[living]
    longest = max(x1 - x0, z1 - z0)
    for link in links:
        if living not in link.wall.rooms or link.width <= 1.5:
            continue
        a, b = rects[link.wall.first], rects[link.wall.second]
        axis = 0 if link.wall.side in ("left", "right") else 1
        longest = max(longest, max(a[axis + 2], b[axis + 2]) - min(a[axis], b[axis]))
    return longest


def _shapes(
    purposes: Sequence[Purpose], areas: dict[int, float], rects: dict[int, Rect]
) -> float | None:
    """Penalty of rooms that are too narrow, too long or of another size than wanted."""
    penalty, largest = 0.0, 0.0
    for number, (x0, z0, x1, z1) in rects.items():
        size = SIZES[purposes[number]]
        short, long = sorted((x1 - x0, z1 - z0))
        area = short * long
        if short < size.side_m - 0.05 or long > 1.15 * size.aspect * short:
            return None
        if not 0.95 * size.least_m2 <= area <= 1.05 * size.most_m2:
            return None
        penalty += 4.0 * max(long / short / (0.75 * size.aspect) - 1.0, 0.0)
        penalty += 2.0 * abs(np.log(area / areas[number])) if purposes[number] != "hall" else 0.0
        if purposes[number] != "living":
            largest = max(largest, area)
    x0, z0, x1, z1 = rects[purposes.index("living")]
    if (x1 - x0) * (z1 - z0) < max(SIZES["living"].least_m2, 1.02 * largest):
        return None
    return penalty


def _outside(purposes: Sequence[Purpose], layout: Layout) -> float | None:
    """Penalty of rooms without windows; none if one that needs them has no outer wall."""
    penalty = 0.0
    for number in layout.cells:
        spans = [span for side in SIDES for span in outside_spans(layout, number, side)]
        longest = max((end - start for start, end in spans), default=0.0)
        if purposes[number] in NEEDS_DAYLIGHT and longest < _WINDOW_WALL_M:
            return None
        if purposes[number] in ("bath", "hall") and longest < 1.25:
            penalty += 1.0 if purposes[number] == "bath" else 2.0
    return penalty
