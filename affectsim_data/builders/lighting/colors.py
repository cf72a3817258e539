"""Linear light and albedo to the sRGB colours that are stored."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.rays import Array32

__all__ = ["exposed", "linear_from_srgb", "lit_colors"]

_DARKEST = 26
"""sRGB below which nothing falls: a camera's black level, and a person there can still be seen."""
_MIDDLE = 0.6
"""Light, after exposure, of the median face."""
_CONTRAST = 0.95
"""Exponent of the light: a room's range does not fit into a picture's as it is."""
_COLOURED = 0.5
"""Share that is left of the colour of light: eyes and cameras see walls as white."""
_WARM = np.array([1.015, 1.0, 0.975], np.float32)
"""Hue of the mean light of a home, after balancing."""

_ENCODED = np.arange(256) / 255.0
_LINEAR = np.where(
    _ENCODED <= 0.04045, _ENCODED / 12.92, ((_ENCODED + 0.055) / 1.055) ** 2.4
).astype(np.float32)
"""Linear value of every sRGB byte."""


def linear_from_srgb(values: NDArray[np.uint8]) -> Array32:
    """Linear values in [0, 1] of sRGB bytes, any shape."""
    return _LINEAR[values]


def exposed(light: Array32, area: Array32) -> Array32:
    """Light `(n, 3)` as a camera takes it: the median by `area` `(n,)` in the middle, the rest
    drawn towards it, with a soft shoulder below 1."""
    brightness = light.mean(axis=1)
    order = np.argsort(brightness, kind="stable")
    share = np.cumsum(area[order].astype(np.float64))
    median = float(brightness[order[int(np.searchsorted(share, share[-1] / 2.0))]])
    relative = np.maximum(brightness / np.float32(max(median, 1e-6)), np.float32(1e-6))
    drawn = relative ** np.float32(_CONTRAST - 1.0)
    grey = brightness[:, None]
    balanced = grey + np.float32(_COLOURED) * (light * (grey.mean() / light.mean(axis=0)) - grey)
    scaled = balanced * (drawn / np.float32(max(median, 1e-6)))[:, None]
    # Through 0 and through the middle; 1.05 leaves white walls near windows white.
    stretch = -np.log(1.0 - _MIDDLE / 1.05)
    scaled *= _WARM
    shoulder: Array32 = np.float32(1.05) * (1.0 - np.exp(np.float32(-stretch) * scaled))
    return shoulder


def lit_colors(albedo: Array32, light: Array32) -> NDArray[np.uint8]:
    """sRGB colours, `(n, 4)`, of linear albedo `(n, 3)` under exposed light `(n, 3)`."""
    linear = np.clip(albedo * light, 0.0, 1.0)
    high = np.float32(1.055) * np.maximum(linear, np.float32(1e-9)) ** np.float32(1.0 / 2.4)
    srgb = np.where(linear <= 0.0031308, np.float32(12.92) * linear, high - np.float32(0.055))
    colors = np.full((len(albedo), 4), 255, np.uint8)
    colors[:, :3] = np.clip(np.round(srgb * 255.0), _DARKEST, 255).astype(np.uint8)
    return colors
