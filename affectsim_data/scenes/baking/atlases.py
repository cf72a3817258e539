"""Textures within a number of draw calls and texels: smaller, and several on one page."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from affectsim_data.scenes.baking.charts import GUTTER, Chart, resized
from affectsim_data.scenes.baking.merging import merged
from affectsim_data.scenes.baking.packing import Packing, pack_rectangles
from affectsim_data.scenes.baking.report import BakeCounts
from affectsim_data.scenes.surfaces import Surface

__all__ = ["PAGE_SIDE", "fit_textures"]

PAGE_SIDE = 2048
_PAGE_SHARE = 4
"""One draw call in so many may be a page; the others are textures that repeat or are large."""
_STEPS = 24
_FEWEST_TEXELS_PER_M = 1e-3


@dataclasses.dataclass(frozen=True)
class _Fit:
    """How textures are drawn at a resolution."""

    own: Mapping[int, Chart]
    """By the place of its surface."""
    paged: tuple[Chart, ...]
    texels_per_m: float
    """At most, of any of them."""
    packing: Packing
    paged_texels_per_m: float = math.inf
    """At most, of those on pages."""

    @property
    def fineness(self) -> float:
        """Texels per metre that the coarsest may have."""
        return min(self.texels_per_m, self.paged_texels_per_m)

    @property
    def texels(self) -> int:
        tiles = (chart.tile(self.texels_per_m) for chart in self.own.values())
        return self.packing.area + sum(width * height for width, height in tiles)


def fit_textures(
    surfaces: Sequence[Surface], *, max_calls: int, max_texels: int, taken: Collection[str] = ()
) -> tuple[list[Surface], list[str]]:
    """Textured surfaces as at most `max_calls` with at most `max_texels` texels, and notes.

    Where they are too many, those that need most texels, because they are large or repeat often,
    stay as they are, and the others share pages. Then all are made as much smaller as the budget
    asks, those with most texels per metre first. Pages get names that are not `taken`.

    Raises:
        ValueError: Even single texels would be too many.
    """
    if len(surfaces) <= max_calls and BakeCounts.of(surfaces).texels <= max_texels:
        return list(surfaces), []
    charts = [Chart.of(surface) for surface in surfaces]
    num_pages = max(1, max_calls // _PAGE_SHARE) if len(charts) > max_calls else 0
    limits = (max_calls - num_pages if num_pages else len(charts), num_pages, max_texels)
    fit = _shared_out(charts, math.inf, *limits)
    if num_pages and _smaller(fit):
        # Which need most texels depends on how fine they are in the end: look once more.
        again = _shared_out(charts, fit.fineness, *limits)
        fit = max(fit, again, key=lambda one: one.fineness)
    return _drawn(surfaces, fit, taken), _notes(fit)


def _shared_out(
    charts: Sequence[Chart], texels_per_m: float, num_own: int, num_pages: int, max_texels: int
) -> _Fit:
    """The finest way to draw with textures of their own for those largest at a resolution."""
    areas = [math.prod(chart.size(chart.tile(texels_per_m))) for chart in charts]
    order = sorted(range(len(charts)), key=lambda i: (-areas[i], i))
    own = {i: charts[i] for i in sorted(order[:num_own])}
    paged = tuple(charts[i].within(PAGE_SIDE) for i in sorted(order[num_own:]))
    if not paged:
        return _finest(own, paged, num_pages, max_texels)
    # What the pages cannot hold is no reason to make the other textures smaller.
    limit = _finest({}, paged, num_pages, num_pages * PAGE_SIDE**2).texels_per_m
    paged = tuple(chart.capped(limit) for chart in paged)
    fit = _finest(own, paged, num_pages, max_texels)
    return dataclasses.replace(fit, paged_texels_per_m=limit)


def _finest(
    own: Mapping[int, Chart], paged: tuple[Chart, ...], num_pages: int, max_texels: int
) -> _Fit:
    """The highest resolution that fits, to a few percent."""
    known = [c.texels_per_m for c in (*own.values(), *paged) if np.isfinite(c.texels_per_m)]
    highest = max([1.0, *known]) * 1.01
    fit = _at(own, paged, highest, num_pages, max_texels)
    if fit is not None:
        return fit
    low, high = _FEWEST_TEXELS_PER_M, highest
    best = _at(own, paged, low, num_pages, max_texels)
    if best is None:
        raise ValueError(
            f"{len(own) + len(paged)} textures do not fit {len(own) + num_pages} draw calls and "
            f"{max_texels:,} texels even as single texels; raise max_draw_calls or texture_budget"
        )
    for _ in range(_STEPS):
        middle = float(np.sqrt(low * high))
        fit = _at(own, paged, middle, num_pages, max_texels)
        low, high, best = (low, middle, best) if fit is None else (middle, high, fit)
    return best


def _at(
    own: Mapping[int, Chart],
    paged: tuple[Chart, ...],
    texels_per_m: float,
    num_pages: int,
    max_texels: int,
) -> _Fit | None:
    """How textures are drawn at a resolution, `None` if they do not fit."""
    sizes = [chart.size(chart.tile(texels_per_m)) for chart in paged]
    if any(max(size) > PAGE_SIDE for size in sizes):
        return None
    if sum(width * height for width, height in sizes) > num_pages * PAGE_SIDE**2:
        return None
    packing = pack_rectangles(sizes, max_side=PAGE_SIDE) if sizes else Packing((), ())
    fit = _Fit(own, paged, texels_per_m, packing)
    return fit if len(packing.pages) <= num_pages and fit.texels <= max_texels else None


def _drawn(surfaces: Sequence[Surface], fit: _Fit, taken: Collection[str]) -> list[Surface]:
    """The surfaces that keep a texture of their own, and one for each page."""
    found = []
    for index, chart in fit.own.items():
        texture = resized(chart.texture, chart.tile(fit.texels_per_m))
        found.append(dataclasses.replace(surfaces[index], texture=texture))
    free = (f"atlas_{i}" for i in itertools.count() if f"atlas_{i}" not in taken)
    pages = range(len(fit.packing.pages))
    return found + [_page(fit, page, name) for page, name in zip(pages, free, strict=False)]


def _page(fit: _Fit, page: int, name: str) -> Surface:
    width, height = fit.packing.pages[page]
    pixels = np.zeros((height, width, 3), np.uint8)
    parts = []
    for chart, (number, x, y) in zip(fit.paged, fit.packing.places, strict=True):
        if number != page:
            continue
        tile = chart.tile(fit.texels_per_m)
        picture = chart.cut(tile)
        pixels[y : y + picture.shape[0], x : x + picture.shape[1]] = picture
        parts.append(chart.placed(tile, (x, y), (width, height)))
    return merged(parts, name=name, texture=pixels)


def _smaller(fit: _Fit) -> list[Chart]:
    """Those whose textures do not keep their size."""
    charts = (*fit.own.values(), *fit.paged)
    return [one for one in charts if one.tile(fit.texels_per_m) != one.texture.shape[1::-1]]


def _notes(fit: _Fit) -> list[str]:
    notes = []
    if fit.paged:
        notes.append(
            f"{len(fit.paged)} textures share {len(fit.packing.pages)} atlas pages "
            f"with gutters of {GUTTER} texels"
        )
    smaller = _smaller(fit)
    if smaller:
        # A texture that covers no area has no texels per metre.
        sizes = (
            (chart.texels_per_m, chart.tile(fit.texels_per_m)[0] / chart.texture.shape[1])
            for chart in smaller
            if math.isfinite(chart.texels_per_m)
        )
        finest = max((density * scale for density, scale in sizes), default=0.0)
        notes.append(
            f"{len(smaller)} textures were made smaller, to at most {finest:.0f} texels a metre"
        )
    lost = [c.surface.name for c in smaller if max(c.tile(fit.texels_per_m)) <= 2]
    if lost:
        shown = ", ".join(lost[:4]) + (", ..." if len(lost) > 4 else "")
        notes.append(f"{len(lost)} of them are hardly more than a mean colour: {shown}")
    return notes
