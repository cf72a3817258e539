"""How a part looks, whatever format said so: colour, texture, and what to do where it is clear."""

from __future__ import annotations

import dataclasses
from typing import Literal

import numpy as np

from affectsim_data.builders.meshes.images import Pixels
from affectsim_data.poses import FloatArray

__all__ = ["AlphaMode", "Look", "Wrap", "linear_to_srgb"]

AlphaMode = Literal["OPAQUE", "MASK", "BLEND"]
Wrap = Literal["repeat", "clamp", "mirror"]


@dataclasses.dataclass(frozen=True)
class Look:
    """A material as a fast unlit shader can draw it."""

    name: str = ""
    """Of the material; may be empty."""
    color: tuple[float, float, float, float] = (1.0, 1.0, 1.0, 1.0)
    """sRGB base colour that multiplies the texture, and its opacity."""
    texture: Pixels | None = None
    """With alpha where it has any."""
    uv_set: int = 0
    """Which texture coordinates it uses."""
    uv_transform: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None
    """Affine map of texture coordinates, two rows of three."""
    wrap: Wrap = "repeat"
    """What is beyond the borders of the texture."""
    alpha_mode: AlphaMode = "OPAQUE"
    """`MASK` is all or nothing at `alpha_cutoff`, `BLEND` is glass."""
    alpha_cutoff: float = 0.5
    """Opacity below which a masked texel is not there."""


def linear_to_srgb(linear: FloatArray) -> FloatArray:
    """Encodes linear light in [0, 1] as sRGB in [0, 1]; clips what lies outside."""
    clipped = np.clip(linear, 0.0, 1.0)
    low, high = 12.92 * clipped, 1.055 * clipped ** (1.0 / 2.4) - 0.055
    return np.where(clipped <= 0.0031308, low, high)
