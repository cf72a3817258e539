"""Procedural tiling textures; bright and nearly grey, because vertex colours give the hue."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = ["MATERIALS", "Material", "material_texture"]

Image = NDArray[np.uint8]


def _noise(rng: np.random.Generator, size: int, *, reach: tuple[float, float]) -> FloatArray:
    """Tiling noise with zero mean and unit deviation, smooth over `reach` pixels (down, across)."""
    down, across = np.meshgrid(np.fft.fftfreq(size), np.fft.rfftfreq(size), indexing="ij")
    keep = np.exp(-2.0 * ((down * reach[0]) ** 2 + (across * reach[1]) ** 2) * np.pi)
    keep[0, 0] = 0.0
    noise = np.fft.irfft2(np.fft.rfft2(rng.normal(size=(size, size))) * keep, s=(size, size))
    scaled: FloatArray = noise / noise.std()
    return scaled


def _grey(values: FloatArray, *, tint: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Image:
    """Values around 0.9 as an image; coarse steps keep the PNG small."""
    steps = np.round(np.clip(values, 0.0, 1.0) * 63.0) / 63.0
    image: Image = np.round(steps[..., None] * np.asarray(tint) * 255.0).astype(np.uint8)
    return image


def _grain(rng: np.random.Generator, size: int) -> FloatArray:
    """Fibres along texture u with slow figure, zero mean."""
    warp = _noise(rng, size, reach=(24.0, 120.0))
    fibre = _noise(rng, size, reach=(1.5, 90.0))
    rows = np.arange(size)[:, None] / size
    rings = np.sin(2.0 * np.pi * (10.0 * rows + 0.55 * warp))
    return 0.022 * fibre + 0.022 * rings


def _wood(rng: np.random.Generator) -> Image:
    return _grey(0.92 + _grain(rng, 256), tint=(1.0, 0.985, 0.96))


def _planks(rng: np.random.Generator) -> Image:
    """Eight boards, each with two ends, over 1.28 m."""
    size, boards = 512, 8
    height = size // boards
    grain = _grain(rng, size)
    image = np.zeros((size, size))
    for board in range(boards):
        rows = slice(board * height, (board + 1) * height)
        ends = (int(rng.integers(size)) + np.array([0, size // 2 + int(rng.integers(60))])) % size
        shade = 0.05 * rng.uniform(-1.0, 1.0, size=2)
        first = (np.arange(size) - ends[0]) % size < (ends[1] - ends[0]) % size
        shift = int(rng.integers(size))
        image[rows] = 0.9 + np.where(first, shade[0], shade[1]) + np.roll(grain[rows], shift, 1)
        image[rows, ends] -= 0.16
        image[rows.start] -= 0.16
    return _grey(image, tint=(1.0, 0.98, 0.95))


def _tiles(rng: np.random.Generator) -> Image:
    """Three by three stone tiles over 1.2 m."""
    size, tiles = 384, 3
    cell = size // tiles
    shade = np.kron(rng.uniform(-0.015, 0.015, (tiles, tiles)), np.ones((cell, cell)))
    image = 0.94 + shade + 0.012 * _noise(rng, size, reach=(12.0, 12.0))
    edge = np.arange(size) % cell < 3
    image[edge, :], image[:, edge] = 0.78, 0.78
    return _grey(image)


def _fabric(rng: np.random.Generator) -> Image:
    size = 256
    wave = 2.0 * np.pi * np.arange(size) * 64 / size
    weave = np.sin(wave)[:, None] * np.sin(wave)[None, :]
    threads = _noise(rng, size, reach=(1.0, 8.0)) + _noise(rng, size, reach=(8.0, 1.0))
    return _grey(0.92 + 0.025 * weave + 0.018 * threads)


def _carpet(rng: np.random.Generator) -> Image:
    soft, fine = _noise(rng, 256, reach=(20.0, 20.0)), _noise(rng, 256, reach=(1.5, 1.5))
    return _grey(0.9 + 0.02 * soft + 0.035 * fine)


def _paint(rng: np.random.Generator) -> Image:
    soft, fine = _noise(rng, 256, reach=(30.0, 30.0)), _noise(rng, 256, reach=(2.0, 2.0))
    return _grey(0.965 + 0.006 * soft + 0.006 * fine)


def _stone(rng: np.random.Generator) -> Image:
    soft, fine = _noise(rng, 256, reach=(14.0, 20.0)), _noise(rng, 256, reach=(1.2, 1.2))
    return _grey(0.92 + 0.025 * soft + 0.02 * fine)


def _sky(rng: np.random.Generator) -> Image:
    """Daylight over far trees, for the panes of windows; does not tile."""
    size = 256
    height = 1.0 - np.arange(size)[:, None] / (size - 1.0)
    cloud = np.clip(_noise(rng, size, reach=(14.0, 40.0)) * 0.35 + 0.3, 0.0, 1.0) * height
    zenith, haze = np.array([0.72, 0.85, 0.99]), np.array([0.97, 0.98, 1.0])
    air = haze + (zenith - haze) * height[..., None] * (1.0 - 0.8 * cloud[..., None])
    ridge = 0.24 + 0.05 * _noise(rng, size, reach=(1e6, 16.0))[:1]
    bush = 0.12 * _noise(rng, size, reach=(5.0, 7.0))[..., None]
    trees = np.array([0.62, 0.74, 0.60]) * (1.0 + bush)
    cover = np.clip((ridge - height) * 40.0, 0.0, 1.0)[..., None]
    mixed = np.clip(air * (1.0 - cover) + trees * cover, 0.0, 1.0)
    image: Image = np.round(np.round(mixed * 85.0) * 3.0).astype(np.uint8)
    return image


def _art(rng: np.random.Generator) -> Image:
    """Four abstract paintings side by side in a 2 x 2 atlas."""
    size = 256
    image = np.zeros((2 * size, 2 * size, 3))
    inks = np.array(
        [[0.83, 0.45, 0.32], [0.24, 0.38, 0.47], [0.93, 0.76, 0.46], [0.45, 0.56, 0.47]]
    )
    down, across = np.mgrid[0:size, 0:size] / size
    for tile in range(4):
        canvas = np.broadcast_to([0.95, 0.93, 0.88], (size, size, 3)).copy()
        for ink in rng.permutation(inks):
            middle, radius = rng.uniform(0.2, 0.8, 2), rng.uniform(0.12, 0.3)
            round_shape = np.hypot(down - middle[0], across - middle[1]) < radius
            band = np.abs(down - middle[0] - 0.3 * (across - 0.5)) < 0.25 * radius
            canvas[round_shape if rng.random() < 0.6 else band] = ink
        canvas[(np.minimum(down, 1 - down) < 0.06) | (np.minimum(across, 1 - across) < 0.06)] = 0.96
        rows, columns = (tile // 2) * size, (tile % 2) * size
        image[rows : rows + size, columns : columns + size] = canvas
    return np.round(image * 255.0).astype(np.uint8)


@dataclasses.dataclass(frozen=True)
class Material:
    """How a surface looks before its vertex colours."""

    paint: Callable[[np.random.Generator], Image] | None = None
    """Makes the texture; none for plain colour."""
    tile_m: float = 1.0
    """Metres one copy of the texture covers; 1 with coordinates already in [0, 1]."""
    glows: bool = False
    """Whether it is drawn as bright as its colour, whatever light falls on it."""


MATERIALS: dict[str, Material] = {
    "plain": Material(),
    "lamp": Material(glows=True),
    "wood": Material(_wood, 0.7),
    "planks": Material(_planks, 1.28),
    "tiles": Material(_tiles, 1.2),
    "fabric": Material(_fabric, 0.32),
    "carpet": Material(_carpet, 0.6),
    "paint": Material(_paint, 2.0),
    "stone": Material(_stone, 0.8),
    "sky": Material(_sky, glows=True),
    "art": Material(_art),
}


def material_texture(name: str, *, rng: np.random.Generator) -> Image | None:
    """sRGB texture `(height, width, 3)` of a material, or none."""
    paint = MATERIALS[name].paint
    return None if paint is None else paint(rng)
