"""Colours of homes."""

from __future__ import annotations

import dataclasses

from affectsim_data.poses import FloatArray

__all__ = ["Palette"]


@dataclasses.dataclass(frozen=True)
class Palette:
    """Colours of one home, sRGB in [0, 1], `(3,)` each."""

    wall: FloatArray
    accent_wall: FloatArray
    """The wall behind the television and behind beds."""
    floor: FloatArray
    wood: FloatArray
    dark_wood: FloatArray
    sofa: FloatArray
    textile: FloatArray
    """Armchair, curtains, bedding."""
    rug: FloatArray
    accent: FloatArray
    """Throw pillows and small things."""
    cabinet: FloatArray
