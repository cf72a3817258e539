"""Colours of homes."""

from __future__ import annotations

import colorsys
import dataclasses

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["Palette", "random_palette"]


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


_FIELDS = tuple(field.name for field in dataclasses.fields(Palette))
_SCHEMES = (
    # wall accent_wall floor wood dark_wood sofa textile rug accent cabinet
    "f1ece2 c9d2cb c9a67c c79f6f 7d5c41 7f8f9c d9cdb8 e4ddd0 c9764f eeebe4",
    "efece8 b9c4cf a27d5c 96704f 5f4734 b9ab97 8d9f91 c3ccd2 dcae55 e6e1d8",
    "f3f1ec e2cdb8 dcc7a5 dcbf93 957553 5f7f80 e3d5c3 d8b9a0 d39a8a a9b8ac",
    "ecebe8 a8b5a2 b8997a b98c5e 4f443c a3563f c8c4ba 8fa0a8 3f5d66 5f7178",
    # Nordic grey with mustard; sand with terracotta; sage with oak.
    "f0f0ee c3c8cb cdb08a d2b284 6e6258 a7abae dfddd6 c9c9c6 d6a23e f2f1ee",
    "f2e9dc d9a98a c69a6c bd8d5d 74513a c6a98c ead9c3 b9694a 8c4a35 efe5d6",
    "eef0e8 aebb9f c4a57b c6a274 6a5440 8c9a80 dcdccb d5d0bb c08a4e d9ddcf",
    # Deep blue with brass; blush with grey; teal with cognac.
    "eceef0 5c7389 b7906a a87c52 54402f 4a6079 cfd4d8 9fb0bf c79a45 dde2e6",
    "f4ece9 e0bfb6 cfb395 cba680 7b6353 9d9a9b e9d6cf d2c3be b5716a f0e8e4",
    "eef0ed 6f938f ad8560 9e744c 573f2e 9b6239 c9d1c8 5f8683 d08a52 e4e6df",
    # Dark walnut with cream; white with primary accents; olive with rust.
    "f3efe6 d8cbb2 84614a 75533c 46342a e2d8c5 cbb99c ad9a80 8a5a3c e9e0cf",
    "f6f6f4 d9dfe3 d7c4a4 d9bd92 8a7460 6b7f94 e8e8e3 c94f44 e0b63c ffffff",
    "f0ede1 9a9c78 bb9468 ad8453 5c4630 7d7f55 d9d2b6 b89f76 b55f36 c9c7ad",
    # Lavender with ash; stone with black; aqua with pine; warm plaster with indigo.
    "f1eff2 c4bccf d3bd9c cfb690 7d6a5a 8a829b ded8e2 b6adc0 9a6d86 e9e6ec",
    "e9e7e3 b8b2a8 a8917a 9a8066 3d3834 5b5853 cdc8bf 8d8880 c2a06a 47474a",
    "eef3f1 b7d3cf d8b780 d9b276 8d6a44 78a19f e3e6dc b9d2cd e08a63 dfeae6",
    "f3ebe1 e4cdb6 bd9568 b08657 65492f 46507a e3d6c6 6b74a0 d58b52 eadfd0",
)
"""Colours of whole homes, `rrggbb` in the order of the fields of `Palette`."""
_PLAIN_ACCENT = 0.3
"""Share of homes in which all walls are alike."""
_FIXED_HUE = ("wall", "floor", "wood", "dark_wood")
"""What keeps its hue, but for a little: wood is never green."""


def random_palette(rng: np.random.Generator) -> Palette:
    """The colours of a home: one of seventeen schemes, moved a little as a whole and by piece."""
    scheme = _SCHEMES[int(rng.integers(len(_SCHEMES)))]
    turn, cloth = float(rng.normal(0.0, 0.02)), float(rng.uniform(0.85, 1.15))
    warmth, light = float(rng.normal(0.0, 0.004)), float(rng.normal(0.0, 0.035))
    plain, swap = bool(rng.random() < _PLAIN_ACCENT), bool(rng.random() < 0.35)
    colors = {}
    for name, code in zip(_FIELDS, scheme.split(), strict=True):
        hue, saturation, value = colorsys.rgb_to_hsv(*_rgb(code))
        if name in _FIXED_HUE:
            hue += warmth
            value += 0.25 * light if name == "wall" else light
        else:
            hue += turn + float(rng.normal(0.0, 0.008))
            saturation *= cloth
            value += float(rng.normal(0.0, 0.02))
        bounded = (hue % 1.0, min(max(saturation, 0.0), 1.0), min(max(value, 0.05), 0.985))
        colors[name] = np.array(colorsys.hsv_to_rgb(*bounded))
    if plain:
        colors["accent_wall"] = colors["wall"]
    if swap:
        # The same hues, worn by other pieces.
        colors["textile"], colors["rug"] = colors["rug"], colors["textile"]
    return Palette(**colors)


def _rgb(code: str) -> tuple[float, float, float]:
    red, green, blue = (int(code[k : k + 2], 16) / 255.0 for k in (0, 2, 4))
    return red, green, blue
