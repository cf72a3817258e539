"""Textures and colours of homes: they tile, stay in their budget, vary, and go together."""

from __future__ import annotations

import colorsys
import dataclasses
import functools

import numpy as np
import pytest

from affectsim_data.builders.homes.palettes import Palette, random_palette
from affectsim_data.builders.homes.textures import MATERIALS, material_texture

_PICTURES = ("sky", "art")
"""Textures that are shown once."""
_TILING = [name for name, one in MATERIALS.items() if one.paint and name not in _PICTURES]
_SEEDS = range(6)


@functools.cache
def _texture(name: str, seed: int) -> np.ndarray:
    return _made(name, seed)


def _made(name: str, seed: int) -> np.ndarray:
    texture = material_texture(name, rng=np.random.default_rng(seed))
    assert texture is not None
    return texture


def test_homes_need_few_materials_and_little_memory() -> None:
    assert len(MATERIALS) <= 20
    images = [material_texture(name, rng=np.random.default_rng(0)) for name in MATERIALS]
    sizes = [image.nbytes for image in images if image is not None]
    assert sum(sizes) < 3_000_000
    assert all(max(image.shape) <= 512 for image in images if image is not None)


@pytest.mark.parametrize("name", [*_TILING, *_PICTURES])
def test_textures_are_rgb_bytes_and_the_same_for_the_same_seed(name: str) -> None:
    first, second = _texture(name, 5), _made(name, 5)
    assert first.dtype == np.uint8
    assert first.ndim == 3
    assert first.shape[2] == 3
    assert first.tobytes() == second.tobytes()


@pytest.mark.parametrize("name", [*_TILING, *_PICTURES])
def test_every_home_has_its_own(name: str) -> None:
    assert len({_texture(name, seed).tobytes() for seed in _SEEDS}) == len(_SEEDS)


@pytest.mark.parametrize("name", _TILING)
@pytest.mark.parametrize("axis", [0, 1])
def test_textures_tile(name: str, axis: int) -> None:
    """The step over the edge is like steps inside: hardly larger than the largest of those."""
    for seed in _SEEDS:
        image = np.moveaxis(_texture(name, seed).astype(np.float64), axis, 0)
        steps = np.abs(np.roll(image, -1, axis=0) - image).mean(axis=(1, 2))
        assert steps[-1] <= 1.25 * np.sort(steps[:-1])[-2] + 2.0, (name, seed)


@pytest.mark.parametrize("name", _TILING)
def test_textures_are_bright_and_nearly_grey(name: str) -> None:
    """Vertex colours give hue and brightness; the texture takes little of them away."""
    for seed in _SEEDS:
        mean = _texture(name, seed).mean(axis=(0, 1)) / 255.0
        assert mean.mean() > (0.6 if name in ("tiles", "wicker", "rug") else 0.82), (name, seed)
        assert np.ptp(mean) < 0.09, (name, seed)


@pytest.mark.parametrize("name", _TILING)
def test_textures_show_something(name: str) -> None:
    least = 0.5 if name == "paint" else 2.0
    assert all(_texture(name, seed).std(axis=(0, 1)).max() > least for seed in _SEEDS)


def test_the_view_is_bright_above_and_greener_below() -> None:
    for seed in _SEEDS:
        image = _texture("sky", seed).astype(np.float64)
        above, below = image[:64].mean(axis=(0, 1)), image[-48:].mean(axis=(0, 1))
        assert above.mean() > below.mean()
        assert above[2] - above[0] > below[2] - below[0]


def test_paintings_fill_four_quarters_that_differ() -> None:
    atlas = _texture("art", 3)
    half = len(atlas) // 2
    quarters = [atlas[y : y + half, x : x + half] for y in (0, half) for x in (0, half)]
    assert len({quarter.tobytes() for quarter in quarters}) == 4
    assert all(quarter.std() > 8.0 for quarter in quarters)


def test_an_unknown_material_names_those_there_are() -> None:
    with pytest.raises(KeyError, match=r"planks.*got 'slime'"):
        material_texture("slime", rng=np.random.default_rng(0))


def _palettes() -> list[Palette]:
    return [random_palette(np.random.default_rng(seed)) for seed in range(200)]


def test_palettes_are_colours_and_repeat_for_the_same_seed() -> None:
    for palette, again in zip(_palettes(), _palettes(), strict=True):
        for field in dataclasses.fields(Palette):
            color = getattr(palette, field.name)
            assert color.shape == (3,)
            assert (color >= 0.0).all()
            assert (color <= 1.0).all()
            assert np.array_equal(color, getattr(again, field.name))


def test_most_walls_are_light_and_some_accents_are_not() -> None:
    palettes = _palettes()
    assert all(palette.wall.min() > 0.8 for palette in palettes)
    accents = np.array([palette.accent_wall for palette in palettes])
    plain = np.array([np.array_equal(p.wall, p.accent_wall) for p in palettes])
    assert 0.15 < plain.mean() < 0.45
    assert (np.ptp(accents, axis=1) > 0.12).mean() > 0.2


def test_wood_has_the_hue_of_wood() -> None:
    for palette in _palettes():
        for color in (palette.wood, palette.floor):
            hue, saturation, _ = colorsys.rgb_to_hsv(*color)
            assert 0.03 < hue < 0.14
            assert saturation > 0.15


def test_palettes_vary() -> None:
    sofas = np.array([palette.sofa for palette in _palettes()])
    assert (sofas.std(axis=0) > 0.1).all()
    assert len(np.unique(np.round(sofas, 3), axis=0)) > 150
