"""Pictures that do not tile: what is seen out of windows, and paintings."""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.patterns import Image, choose, colored, noise
from affectsim_data.poses import FloatArray

__all__ = ["art", "sky"]

_SIZE = 256
_PAINTING = 192
_INKS = np.array(
    [
        [[0.83, 0.45, 0.32], [0.24, 0.38, 0.47], [0.93, 0.76, 0.46], [0.45, 0.56, 0.47]],
        [[0.20, 0.27, 0.36], [0.55, 0.66, 0.71], [0.87, 0.83, 0.75], [0.76, 0.52, 0.40]],
        [[0.36, 0.42, 0.30], [0.66, 0.69, 0.52], [0.88, 0.80, 0.64], [0.71, 0.44, 0.33]],
        [[0.18, 0.18, 0.19], [0.55, 0.54, 0.52], [0.82, 0.80, 0.77], [0.79, 0.62, 0.34]],
        [[0.72, 0.36, 0.42], [0.90, 0.70, 0.66], [0.44, 0.47, 0.60], [0.95, 0.86, 0.74]],
    ]
)
"""Schemes of four inks, sRGB, `(num_schemes, 4, 3)`."""


def sky(rng: np.random.Generator) -> Image:
    """Daylight over trees, hills, houses across the street, or roofs of a town."""
    height = 1.0 - (np.arange(_SIZE)[:, None] + 0.5) / _SIZE
    image = _air(rng, height)
    kind = choose(rng, 4)
    if kind == 1:
        for level, near in ((0.38, 0.0), (0.32, 0.2), (0.25, 0.45)):
            ink = _far([0.40, 0.52, 0.40], near)
            _ridge(image, rng, height, level, bumps=50.0, ink=ink, rough=0.02)
    elif kind == 2:
        _houses(image, rng, ground=0.06, tall=(0.24, 0.40), count=4)
    elif kind == 3:
        _houses(image, rng, ground=0.0, tall=(0.18, 0.42), count=9)
    if kind != 3:
        crowns = 0.30 if kind == 0 else 0.17
        _ridge(image, rng, height, crowns, bumps=12.0, ink=_far([0.36, 0.48, 0.31], 0.55))
        _ridge(image, rng, height, 0.10, bumps=30.0, ink=_far([0.50, 0.62, 0.38], 0.75))
    # Outdoors is brighter than any room: a camera set for the room washes it out.
    return colored(0.36 + 0.64 * image)


def _air(rng: np.random.Generator, height: FloatArray) -> FloatArray:
    """Blue above, haze below, and clouds, `(size, size, 3)`."""
    zenith, haze = np.array([0.42, 0.63, 0.90]), np.array([0.88, 0.92, 0.96])
    share = np.clip((height - 0.15) / 0.85, 0.0, 1.0) ** 0.8
    air = haze + (zenith - haze) * share[..., None]
    field = noise(rng, _SIZE, reach=(16.0, 46.0)) + 0.35 * noise(rng, _SIZE, reach=(5.0, 11.0))
    cover = np.clip(0.55 * field + float(rng.uniform(-0.6, 0.3)), 0.0, 1.0)
    whole: FloatArray = air + cover[..., None] * 0.9 * (np.array([0.97, 0.97, 0.98]) - air)
    return whole


def _far(ink: list[float], nearness: float) -> FloatArray:
    """A colour with haze before it."""
    haze = np.array([0.80, 0.86, 0.92])
    mixed: FloatArray = haze + (0.35 + 0.65 * nearness) * (np.array(ink) - haze)
    return mixed


def _ridge(
    image: FloatArray, rng: np.random.Generator, height: FloatArray, level: float, *,
    bumps: float, ink: FloatArray, rough: float = 0.1,
) -> None:  # fmt: skip
    """Paints hills or the crowns of trees, `bumps` pixels wide, up to about `level`."""
    line = noise(rng, (1, _SIZE), reach=(1.0, bumps))
    line += 0.3 * noise(rng, (1, _SIZE), reach=(1.0, 0.35 * bumps))
    top = level + 0.03 * line
    cover = np.clip((top - height) * 90.0, 0.0, 1.0)[..., None]
    leaves = noise(rng, _SIZE, reach=(3.0, 3.5)) + noise(rng, _SIZE, reach=(9.0, 12.0))
    lit = 1.0 + rough * leaves + 0.5 * np.clip(height - top + 0.08, 0.0, 0.08)
    image += cover * (ink * lit[..., None] - image)


def _houses(
    image: FloatArray, rng: np.random.Generator, *, ground: float, tall: tuple[float, float],
    count: int,
) -> None:  # fmt: skip
    """Paints a row of fronts with gabled or flat roofs and windows."""
    fronts = np.array([[0.86, 0.80, 0.70], [0.80, 0.62, 0.52], [0.90, 0.88, 0.84],
                       [0.74, 0.76, 0.76], [0.85, 0.74, 0.60]])  # fmt: skip
    roofs = np.array([[0.58, 0.36, 0.30], [0.42, 0.40, 0.42], [0.50, 0.42, 0.36]])
    edges = np.round(np.linspace(0.0, _SIZE, count + 1)).astype(int)
    edges[1:-1] += rng.integers(-6, 7, count - 1)
    bottom = round((1.0 - ground) * _SIZE)
    for left, right in itertools.pairwise(edges.tolist()):
        top = bottom - round(float(rng.uniform(*tall)) * _SIZE)
        wall = _far(list(rng.choice(fronts) * rng.uniform(0.9, 1.03)), 0.7)
        _roof(
            image, left, right, top, _far(list(rng.choice(roofs)), 0.7), gabled=rng.random() < 0.6
        )
        image[top:bottom, left:right] = wall
        image[top:bottom, right - 1 : right] = 0.88 * wall
        wide, high = int(rng.integers(7, 10)), int(rng.integers(10, 14))
        for y in range(top + 6, bottom - high, high + 9):
            for x in range(left + 5, right - wide - 3, wide + 7):
                image[y - 1 : y + high + 1, x - 1 : x + wide + 1] = 1.06 * wall
                image[y : y + high, x : x + wide] = _far([0.34, 0.40, 0.46], 0.6)


def _roof(
    image: FloatArray, left: int, right: int, top: int, ink: FloatArray, *, gabled: bool
) -> None:
    if not gabled:
        image[top - 4 : top, left:right] = 0.9 * ink
        return
    rise = min((right - left) // 3, 26, top - 1)
    for row in range(rise):
        inset = round((rise - row) / rise * 0.5 * (right - left))
        image[top - rise + row, left + inset : right - inset] = ink


def art(rng: np.random.Generator) -> Image:
    """Four paintings side by side in a 2 x 2 atlas: abstract, landscape, plant, lines."""
    image = np.zeros((2 * _PAINTING, 2 * _PAINTING, 3))
    kinds = rng.permutation(len(_PAINTERS))[:4]
    for tile, kind in enumerate(kinds):
        inks = rng.permutation(_INKS[choose(rng, len(_INKS))])
        canvas = _PAINTERS[kind](rng, inks)
        rows, columns = (tile // 2) * _PAINTING, (tile % 2) * _PAINTING
        # A mat of white card around it.
        image[rows : rows + _PAINTING, columns : columns + _PAINTING] = 0.96
        edge = int(rng.choice([0, 12, 24]))
        inner = canvas[edge : _PAINTING - edge, edge : _PAINTING - edge]
        image[rows + edge : rows + _PAINTING - edge,
              columns + edge : columns + _PAINTING - edge] = inner  # fmt: skip
    return colored(image)


def _canvas(color: FloatArray) -> FloatArray:
    paper: FloatArray = np.broadcast_to(color, (_PAINTING, _PAINTING, 3)).copy()
    return paper


def _grid() -> tuple[FloatArray, FloatArray]:
    down, across = np.mgrid[0:_PAINTING, 0:_PAINTING] / _PAINTING
    return down, across


def _paint_over(canvas: FloatArray, shape: NDArray[np.bool_], ink: FloatArray) -> None:
    canvas[shape] = ink


def _shapes(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """Discs and slanted bands."""
    canvas, (down, across) = _canvas(np.array([0.95, 0.93, 0.88])), _grid()
    for ink in inks:
        middle, radius = rng.uniform(0.2, 0.8, 2), float(rng.uniform(0.12, 0.3))
        disc = np.hypot(down - middle[0], across - middle[1]) < radius
        band = np.abs(down - middle[0] - 0.3 * (across - 0.5)) < 0.25 * radius
        _paint_over(canvas, disc if rng.random() < 0.6 else band, ink)
    return canvas


def _landscape(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """Layers of hills under a sun."""
    down, across = _grid()
    bright = inks[np.argsort(inks.sum(axis=1))[::-1]]
    canvas = _canvas(0.5 * bright[0] + 0.5)
    sun = np.hypot(down - 0.3, across - float(rng.uniform(0.25, 0.75))) < 0.11
    _paint_over(canvas, sun, np.array([0.96, 0.82, 0.60]))
    for layer, ink in enumerate(bright[1:]):
        wave = np.sin(2.0 * np.pi * (across * float(rng.uniform(0.7, 1.6)) + float(rng.random())))
        _paint_over(canvas, down > 0.45 + 0.17 * layer + 0.07 * wave, ink)
    return canvas


def _sprig(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """A stem with leaves."""
    canvas, (down, across) = _canvas(np.array([0.95, 0.94, 0.91])), _grid()
    lean = float(rng.uniform(-0.2, 0.2))
    stem = 0.5 + lean * (0.9 - down) ** 2
    _paint_over(canvas, (np.abs(across - stem) < 0.007) & (down > 0.14) & (down < 0.9), inks[0])
    for index, y in enumerate(np.linspace(0.2, 0.78, 7)):
        side = 1.0 if index % 2 else -1.0
        u = side * (across - (0.5 + lean * (0.9 - y) ** 2))
        x, z = u - 0.14, (down - y) + 0.6 * u
        leaf = (np.abs(z) < 0.055 * (1.0 - (x / 0.14) ** 2)) & (np.abs(x) < 0.14)
        _paint_over(canvas, leaf, inks[index % 3])
    return canvas


def _fields(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """Two or three soft rectangles."""
    canvas, (down, across) = _canvas(inks[0] * 0.9), _grid()
    count = int(rng.integers(2, 4))
    for index in range(count):
        top, bottom = 0.07 + 0.88 * index / count, 0.88 * (index + 1) / count + 0.02
        edge = np.minimum(
            np.minimum(down - top, bottom - down), np.minimum(across, 1 - across) - 0.08
        )
        cover = np.clip(edge / 0.03 + 0.1 * noise(rng, _PAINTING, reach=(6.0, 6.0)), 0.0, 1.0)
        canvas += cover[..., None] * (inks[index + 1] - canvas)
    return canvas


def _lines(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """Concentric arches."""
    canvas, (down, across) = _canvas(np.array([0.94, 0.91, 0.86])), _grid()
    middle = float(rng.uniform(0.4, 0.6))
    far = np.where(down < 0.6, np.hypot(across - middle, down - 0.6), np.abs(across - middle))
    for ring, ink in enumerate(inks):
        outer = 0.40 - 0.09 * ring
        _paint_over(canvas, (far < outer) & (far > outer - 0.055) & (down < 0.9), ink)
    return canvas


def _photograph(rng: np.random.Generator, inks: FloatArray) -> FloatArray:
    """Sea under clouds, nearly without colour."""
    down, _ = _grid()
    horizon = float(rng.uniform(0.45, 0.65))
    cloud = noise(rng, _PAINTING, reach=(8.0, 26.0))
    waves = noise(rng, _PAINTING, reach=(1.5, 14.0))
    tone = np.where(
        down < horizon, 0.78 - 0.2 * (horizon - down) + 0.06 * cloud, 0.42 + 0.04 * waves
    )
    picture: FloatArray = tone[..., None] * (0.75 + 0.25 * inks[0] / inks[0].max())
    return picture


_PAINTERS = (_shapes, _landscape, _sprig, _fields, _lines, _photograph)
