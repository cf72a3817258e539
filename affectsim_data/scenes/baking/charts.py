"""What of a texture is used, how finely, and cutting it out."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.baking.merging import with_own_corners
from affectsim_data.scenes.surfaces import Surface

__all__ = ["GUTTER", "Chart", "resized"]

GUTTER = 8
"""Texels around a chart on its page: three mipmaps stay apart from their neighbours."""
_EDGE = 1e-5
"""Texture coordinates this little below a whole number are that number."""


@dataclasses.dataclass(frozen=True, eq=False)
class Chart:
    """A textured surface, and the part of its repeated texture that it shows."""

    surface: Surface
    low: FloatArray
    """Lowest texture coordinates, those of every triangle moved next to 0, `(2,)`."""
    high: FloatArray
    """Highest ones, `(2,)`."""
    texels_per_m: float
    """Of the texture as it is, on average over the surface."""
    max_scale: float = 1.0
    """How much of that it may have at most."""

    @classmethod
    def of(cls, surface: Surface) -> Chart:
        """The chart of a textured surface."""
        uvs = _near_zero(surface)
        low, high = uvs.min(axis=(0, 1)), uvs.max(axis=(0, 1))
        edges = uvs[:, 1:] - uvs[:, :1]
        turn = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
        corners = surface.positions[surface.faces].astype(np.float64)
        sides = corners[:, 1:] - corners[:, :1]
        area = float(np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum())
        chart = cls(surface, low, high, math.inf)
        texels = float(np.abs(turn).sum()) * math.prod(chart.texture.shape[:2])
        density = math.sqrt(texels / area) if area > 0.0 else math.inf
        return dataclasses.replace(chart, texels_per_m=density)

    @property
    def texture(self) -> NDArray[np.uint8]:
        """Its texture, one tile."""
        assert self.surface.texture is not None
        return self.surface.texture

    def tile(self, texels_per_m: float) -> tuple[int, int]:
        """Width and height of its texture at no more than a number of texels per metre."""
        height, width = self.texture.shape[:2]
        scale = self.max_scale
        if self.texels_per_m > texels_per_m:
            scale = min(scale, texels_per_m / self.texels_per_m)
        # Down, so that what repeats often stays within its page; but 0.3 * 10 is 3.
        return max(1, int(width * scale + 1e-6)), max(1, int(height * scale + 1e-6))

    def within(self, max_side: int) -> Chart:
        """The chart, no larger with its gutters than a page unless it is a single texel."""
        height, width = self.texture.shape[:2]
        longest = float(((self.high - self.low) * (width, height)).max())
        # Up to a texel is lost on either side, and up to a gutter to whole gutters.
        room = max_side - 3 * GUTTER - 2
        return dataclasses.replace(self, max_scale=min(1.0, room / max(longest, 1.0)))

    def capped(self, texels_per_m: float) -> Chart:
        """The chart with no more than a number of texels per metre."""
        scale = min(self.max_scale, texels_per_m / self.texels_per_m) if self.texels_per_m else 1.0
        return dataclasses.replace(self, max_scale=scale)

    def region(self, tile: tuple[int, int]) -> tuple[int, int, int, int]:
        """Texels that are shown of tiles of a size, side by side: x0, y0, x1, y1, half open."""
        low = np.floor(self.low * tile + _EDGE).astype(int)
        high = np.ceil(self.high * tile - _EDGE).astype(int)
        # Along an axis of one texel nothing changes, however often it repeats.
        low = np.where(np.equal(tile, 1), 0, low)
        high = np.where(np.equal(tile, 1), 1, np.maximum(high, low + 1))
        return int(low[0]), int(low[1]), int(high[0]), int(high[1])

    def size(self, tile: tuple[int, int]) -> tuple[int, int]:
        """Width and height on a page, gutters included, in whole gutters."""
        x0, y0, x1, y1 = self.region(tile)
        width, height = (-(-(size + 2 * GUTTER) // GUTTER) * GUTTER for size in (x1 - x0, y1 - y0))
        return width, height

    def cut(self, tile: tuple[int, int]) -> NDArray[np.uint8]:
        """Its picture with gutters, which show the texture going on, `(height, width, 3)`."""
        x0, y0, _, _ = self.region(tile)
        width, height = self.size(tile)
        small = resized(self.texture, tile)
        rows = (y0 - GUTTER + np.arange(height)) % tile[1]
        columns = (x0 - GUTTER + np.arange(width)) % tile[0]
        return small[rows[:, None], columns[None, :]]

    def placed(self, tile: tuple[int, int], at: tuple[int, int], page: tuple[int, int]) -> Surface:
        """The surface on a page of a size, on which the chart with its gutters lies `at`."""
        x0, y0, _, _ = self.region(tile)
        start = np.array([at[0] + GUTTER - x0, at[1] + GUTTER - y0])
        uvs = _near_zero(self.surface).reshape(-1, 2)
        texels = np.where(np.equal(tile, 1), 0.5, uvs * np.array(tile, np.float64))
        loose = with_own_corners(self.surface)
        return dataclasses.replace(loose, uvs=((texels + start) / page).astype(np.float32))


def _near_zero(surface: Surface) -> FloatArray:
    """Texture coordinates of every triangle, whole tiles nearer to 0, `(num_faces, 3, 2)`."""
    assert surface.uvs is not None
    uvs: FloatArray = surface.uvs[surface.faces].astype(np.float64)
    uvs -= np.floor(uvs.min(axis=1, keepdims=True) + _EDGE)
    return uvs


def resized(texture: NDArray[np.uint8], size: tuple[int, int]) -> NDArray[np.uint8]:
    """A texture at another `(width, height)`, no larger than it is: means over areas."""
    import cv2

    if (texture.shape[1], texture.shape[0]) == size:
        return texture
    return np.asarray(cv2.resize(texture, size, interpolation=cv2.INTER_AREA), np.uint8)
