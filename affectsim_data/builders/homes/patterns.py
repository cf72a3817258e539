"""What procedural textures are made of: tiling noise, grain, cells and grey images."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import cKDTree

from affectsim_data.poses import FloatArray

__all__ = ["Image", "choose", "colored", "grain", "grey", "noise", "scattered", "speckled"]

Image = NDArray[np.uint8]


def noise(
    rng: np.random.Generator, size: int | tuple[int, int], *, reach: tuple[float, float]
) -> FloatArray:
    """Tiling noise with zero mean and unit deviation, smooth over `reach` pixels (down, across)."""
    shape = (size, size) if isinstance(size, int) else size
    down, across = np.meshgrid(np.fft.fftfreq(shape[0]), np.fft.rfftfreq(shape[1]), indexing="ij")
    keep = np.exp(-2.0 * ((down * reach[0]) ** 2 + (across * reach[1]) ** 2) * np.pi)
    keep[0, 0] = 0.0
    smooth = np.fft.irfft2(np.fft.rfft2(rng.normal(size=shape)) * keep, s=shape)
    scaled: FloatArray = smooth / smooth.std()
    return scaled


def grey(values: FloatArray, *, tint: ArrayLike = (1.0, 1.0, 1.0)) -> Image:
    """Values in [0, 1] as an image of one hue; coarse steps keep the PNG small."""
    steps = np.round(np.clip(values, 0.0, 1.0) * 63.0) / 63.0
    image: Image = np.round(steps[..., None] * np.asarray(tint) * 255.0).astype(np.uint8)
    return image


def colored(values: FloatArray) -> Image:
    """Colours in [0, 1] as an image, in coarse steps."""
    image: Image = np.round(np.round(np.clip(values, 0.0, 1.0) * 85.0) * 3.0).astype(np.uint8)
    return image


def choose(rng: np.random.Generator, count: int) -> int:
    """One of `count` variants."""
    return int(rng.integers(count))


def grain(
    rng: np.random.Generator, size: int | tuple[int, int], *, rings: float = 10.0,
    figure: float = 0.55, fibre: float = 0.022, depth: float = 0.022,
) -> FloatArray:  # fmt: skip
    """Wood that runs along texture u, zero mean.

    Args:
        rng: Where the figure comes from.
        size: Pixels.
        rings: Year rings across the texture; a whole number, so that it tiles.
        figure: How far rings wander, in rings.
        fibre: Contrast of the fine fibres.
        depth: Contrast of the rings.
    """
    shape = (size, size) if isinstance(size, int) else size
    scale = shape[0] / 256.0
    warp = noise(rng, shape, reach=(24.0 * scale, 120.0 * scale))
    fibres = noise(rng, shape, reach=(1.4, 70.0 * scale))
    rows = np.arange(shape[0])[:, None] / shape[0]
    wave = np.sin(2.0 * np.pi * (rings * rows + figure * warp))
    # Late wood is a thin dark line: sharper than a sine.
    return fibre * fibres + depth * (wave - 0.5 * np.maximum(wave, 0.0) ** 3)


def scattered(
    rng: np.random.Generator, size: int, count: int, *, reach: tuple[float, float]
) -> tuple[NDArray[np.intp], FloatArray]:
    """Chips strewn over a tile: whose cell each pixel lies in, and how much of the chip is left
    between the pixel and its edge, pixels, `(size, size)` each; `reach` bounds chips' radii."""
    places = rng.uniform(0.0, size, (count, 2))
    radii = rng.uniform(*reach, count)
    rows, columns = np.mgrid[0:size, 0:size]
    grid = np.stack([rows, columns], axis=-1).reshape(-1, 2)
    distance, near = cKDTree(places, boxsize=size).query(grid, k=2)
    # Chips end a little before the border to the next, and at their radius.
    border = (distance[:, 1] - distance[:, 0]) / 2.0 - 0.8
    depth = np.minimum(border, radii[near[:, 0]] - distance[:, 0])
    return near[:, 0].reshape(size, size), depth.reshape(size, size)


def speckled(rng: np.random.Generator, size: int, *, share: float) -> NDArray[np.bool_]:
    """Grains two or three pixels wide that cover a share of the tile, `(size, size)`."""
    field = noise(rng, size, reach=(1.6, 1.6))
    covered: NDArray[np.bool_] = field > np.quantile(field, 1.0 - share)
    return covered
