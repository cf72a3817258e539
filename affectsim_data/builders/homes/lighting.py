"""Light baked into vertex colours: sky through windows, ceiling lamps, and what walls throw back.

Lambertian surfaces, one direct bounce plus ambient light that thins out in corners (ambient
occlusion by cosine-weighted hemisphere rays). The same directions are used at every vertex, turned
to its normal, so that the result varies smoothly instead of with noise.
"""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["Lamp", "WindowLight", "bake_light", "lit_colors"]

_AO_REACH_M = 1.6
_LIFT_M = 0.012
"""Rays start this far off their surface."""
_AMBIENT = np.array([0.52, 0.515, 0.50])
_LAMP_POWER = np.array([1.9, 1.75, 1.5])
_SKY_RADIANCE = np.array([2.3, 2.4, 2.5])
_EXPOSURE = 1.7
_LEAST_LIGHT = 0.004
"""Unshadowed irradiance below which a shadow ray is not worth casting."""
_DARKEST = 45
"""sRGB below which nothing falls: a camera's black level, and a person there can still be seen."""


@dataclasses.dataclass(frozen=True)
class WindowLight:
    """A pane that lets daylight in."""

    corner: FloatArray
    """`(3,)`, metres."""
    across: FloatArray
    """From the corner to the next, metres, `(3,)`."""
    up: FloatArray
    """`(3,)`, metres."""
    normal: FloatArray
    """Unit, into the room, `(3,)`."""

    def samples(self, columns: int, rows: int) -> tuple[FloatArray, float]:
        """Points spread over the pane `(columns * rows, 3)` and the area each stands for, m2."""
        u = (np.arange(columns) + 0.5) / columns
        v = (np.arange(rows) + 0.5) / rows
        grid = self.corner + u[None, :, None] * self.across + v[:, None, None] * self.up
        area = float(np.linalg.norm(np.cross(self.across, self.up)))
        return grid.reshape(-1, 3), area / (columns * rows)


@dataclasses.dataclass(frozen=True)
class Lamp:
    """A lamp that shines everywhere."""

    position: FloatArray
    """`(3,)`, metres."""
    power: float = 1.0
    """Of a ceiling lamp's."""


def bake_light(
    positions: FloatArray, normals: FloatArray, *, rays: int,
    windows: list[WindowLight], lamps: list[Lamp], caster: RayCaster,
) -> FloatArray:  # fmt: skip
    """Linear light, 1 for a white wall near a window, at points with normals, `(n, 3)` each.

    Args:
        positions: Metres, `(n, 3)`.
        normals: Unit, `(n, 3)`.
        rays: Ambient rays per point.
        windows: Sources of daylight.
        lamps: Point-like sources.
        caster: Everything that throws shadows.
    """
    starts = positions + _LIFT_M * normals
    # Rays that end nearby meet lit surfaces too: a corner is dim, never black.
    open_share = _open_share(starts, normals, rays, caster)
    light = _AMBIENT * (0.25 + 0.75 * open_share[:, None])
    for window in windows:
        points, area = window.samples(3, 2)
        for point in points:
            weight = _irradiance(positions, normals, point, source_normal=window.normal) * area
            light += _SKY_RADIANCE * _shadowed(weight / np.pi, starts, point, caster)[:, None]
    for lamp in lamps:
        weight = _irradiance(positions, normals, lamp.position, source_normal=None)
        strength = weight * (lamp.power / 2.0)
        light += _LAMP_POWER * _shadowed(strength, starts, lamp.position, caster)[:, None]
    return light


def lit_colors(albedo: FloatArray, light: FloatArray) -> NDArray[np.uint8]:
    """sRGB colours, `(n, 4)`, of sRGB albedo `(n, 3)` in [0, 1] under linear light `(n, 3)`."""
    linear = np.where(albedo <= 0.04045, albedo / 12.92, ((albedo + 0.055) / 1.055) ** 2.4)
    # A soft shoulder, as a camera has: bright places keep their shape instead of clipping.
    exposed = linear * 1.05 * (1.0 - np.exp(-_EXPOSURE * light))
    srgb = np.where(
        exposed <= 0.0031308,
        12.92 * exposed,
        1.055 * np.maximum(exposed, 1e-9) ** (1 / 2.4) - 0.055,
    )
    colors = np.full((len(albedo), 4), 255, np.uint8)
    colors[:, :3] = np.clip(np.round(srgb * 255.0), _DARKEST, 255).astype(np.uint8)
    return colors


def _open_share(
    starts: FloatArray, normals: FloatArray, count: int, caster: RayCaster
) -> FloatArray:
    """Cosine-weighted share of the hemisphere that is free, near hits counting more, `(n,)`."""
    # Fibonacci points on the disc, lifted to the hemisphere: cosine-weighted (Malley's method).
    index = np.arange(count) + 0.5
    radius, angle = np.sqrt(index / count), index * np.pi * (3.0 - np.sqrt(5.0))
    local = np.stack(
        [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius**2)], axis=1
    )
    tangent, bitangent = _tangents(normals)
    total = np.zeros(len(starts))
    for x, y, z in local:
        directions = x * tangent + y * bitangent + z * normals
        distance = caster.distance(starts, directions, limit=_AO_REACH_M)
        total += np.minimum(distance, _AO_REACH_M) / _AO_REACH_M
    share: FloatArray = np.sqrt(total / count)
    return share


def _tangents(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors across each normal, `(n, 3)` each (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0.0, 1.0, -1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return tangent, np.stack([b, sign + y * y * a, -y], axis=1)


def _irradiance(
    positions: FloatArray, normals: FloatArray, point: FloatArray, *,
    source_normal: FloatArray | None,
) -> FloatArray:  # fmt: skip
    """Cosine at the surface (and at the source) over squared distance, 0 if turned away, `(n,)`."""
    way = point - positions
    squared = np.maximum(np.einsum("ij,ij->i", way, way), 0.04)
    length = np.sqrt(squared)
    facing = np.maximum(np.einsum("ij,ij->i", way, normals) / length, 0.0)
    if source_normal is not None:
        facing = facing * np.maximum(-(way @ source_normal) / length, 0.0)
    irradiance: FloatArray = facing / squared
    return irradiance


def _shadowed(
    weight: FloatArray, starts: FloatArray, point: FloatArray, caster: RayCaster
) -> FloatArray:
    """The weights of points that see the source, 0 for the others, `(n,)`."""
    worth = np.flatnonzero(weight > _LEAST_LIGHT)
    lit = np.zeros_like(weight)
    lit[worth] = np.where(caster.hidden(starts[worth], point), 0.0, weight[worth])
    return lit
