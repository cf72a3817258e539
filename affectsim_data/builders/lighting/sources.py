"""What shines: windows and lamps, and their light on points, with shadows."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.cells import Cells
from affectsim_data.builders.lighting.rays import Array32, LightRays
from affectsim_data.poses import FloatArray

__all__ = ["Lamp", "WindowLight", "direct_light"]

_SKY = np.array([0.97, 1.0, 1.04], np.float32)
"""Radiance of the sky overhead, the unit of all light here; its hue is what a camera leaves of it
when it is balanced between day and lamps."""
_GROUND = np.array([0.33, 0.34, 0.30], np.float32)
"""Radiance of what lies below the horizon: ceilings see that through a window."""
_LAMP = np.array([0.36, 0.325, 0.265], np.float32)
"""Light of a ceiling lamp on a face that looks at it from 1 m."""
_DAYLIT_LAMP = 0.25
"""Power left to a lamp where daylight is bright; all of it where there is none."""
_BRIGHT = 0.06
"""Daylight, on the scale of the light, that counts as bright at a lamp."""
_BEFORE_PANE_M = 0.06
"""Light starts this far before the pane, clear of the bars of the window."""
_COLUMNS, _ROWS = 4, 2
_NEAREST_M = 0.25
"""A sample of a window or a bulb is not a point: nothing is nearer than this."""
_LEAST_LIGHT = np.float32(0.002)
"""Unshadowed light of one sample below which a shadow ray is not worth casting."""


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


def direct_light(
    points: Array32, normals: Array32, large: NDArray[np.bool_], *,
    windows: Sequence[WindowLight], lamps: Sequence[Lamp], rays: LightRays,
) -> Array32:  # fmt: skip
    """Light that comes straight from windows and lamps, linear, `(n, 3)`.

    Args:
        points: A little off their surfaces, metres, `(n, 3)`.
        normals: Unit, `(n, 3)`.
        large: Points of large faces: their shadows get twice the samples, `(n,)`.
        windows: Sources of daylight, as bright as the sky.
        lamps: Point-like sources; in daylight they are turned down.
        rays: Everything that throws shadows.
    """
    light = np.zeros_like(points)
    if not len(points):
        return light
    cells = Cells(points)
    for window in windows:
        grid, area = window.samples(_COLUMNS, _ROWS)
        places = (grid + _BEFORE_PANE_M * window.normal).astype(np.float32)
        near = cells.seeing(places[[0, _COLUMNS - 1, -_COLUMNS, -1]], rays)
        near = near[_face_window(points[near], normals[near], window)]
        large_near, small_near = near[large[near]], near[~large[near]]
        for index, place in enumerate(places):
            _add_pane(light, points, normals, large_near, place, window.normal, area, rays)
            # Every other sample, as on a chess board.
            if (index + index // _COLUMNS) % 2:
                continue
            _add_pane(light, points, normals, small_near, place, window.normal, 2 * area, rays)
    for lamp in lamps:
        place = np.asarray(lamp.position, np.float32)
        power = lamp.power * _lamp_share(place, windows, rays)
        _add_bulb(light, points, normals, cells.seeing(place[None], rays), place, power, rays)
    return light


def _face_window(
    points: Array32, normals: Array32, window: WindowLight
) -> NDArray[np.bool_]:  # fmt: skip
    """Points on the inner side of a window that look at any of it, `(n,)`."""
    across, up, normal = (
        np.asarray(v, np.float32) for v in (window.across, window.up, window.normal)
    )
    corner = np.asarray(window.corner, np.float32)
    middle = corner + (across + up) / np.float32(2.0) + np.float32(_BEFORE_PANE_M) * normal
    ahead = np.einsum("ij,ij->i", middle - points, normals)
    reach = (np.abs(normals @ across) + np.abs(normals @ up)) / np.float32(2.0)
    found: NDArray[np.bool_] = (points @ normal > corner @ normal) & (ahead + reach > 0.0)
    return found


def _add_pane(
    light: Array32, points: Array32, normals: Array32, near: NDArray[np.intp], place: Array32,
    source_normal: FloatArray, area: float, rays: LightRays,
) -> None:  # fmt: skip
    """Adds one sample of a pane to the light of the points it may reach."""
    way = place - points[near]
    squared = np.einsum("ij,ij->i", way, way) + np.float32(_NEAREST_M**2)
    facing = np.einsum("ij,ij->i", way, normals[near])
    leaving = -(way @ source_normal.astype(np.float32))
    weight = np.maximum(facing, 0.0) * np.maximum(leaving, 0.0) / squared**2
    weight *= np.float32(area / np.pi)
    worth = np.flatnonzero(weight > _LEAST_LIGHT)
    reached = worth[~rays.hidden(points[near[worth]], place)]
    # Seen from high up, a window shows the ground.
    high = way[reached, 1] / np.sqrt(squared[reached])
    sky = np.clip(0.5 + 2.0 * high, 0.0, 1.0)[:, None]
    light[near[reached]] += weight[reached, None] * (_GROUND + sky * (_SKY - _GROUND))


def _add_bulb(
    light: Array32, points: Array32, normals: Array32, near: NDArray[np.intp], place: Array32,
    power: float, rays: LightRays,
) -> None:  # fmt: skip
    """Adds a lamp to the light of the points it may reach."""
    way = place - points[near]
    squared = np.einsum("ij,ij->i", way, way)
    facing = np.einsum("ij,ij->i", way, normals[near]) / np.sqrt(squared + np.float32(1e-6))
    weight = np.float32(power) * np.maximum(facing, 0.0) / (squared + np.float32(_NEAREST_M**2))
    worth = np.flatnonzero(weight > _LEAST_LIGHT)
    reached = worth[~rays.hidden(points[near[worth]], place)]
    light[near[reached]] += weight[reached, None] * _LAMP


def _lamp_share(place: Array32, windows: Sequence[WindowLight], rays: LightRays) -> float:
    """How far a lamp is turned up, from the daylight that reaches it."""
    day = 0.0
    for window in windows:
        middles, area = window.samples(2, 1)
        for middle in (middles + _BEFORE_PANE_M * window.normal).astype(np.float32):
            way = middle - place
            squared = float(way @ way)
            leaving = max(-float(way @ window.normal), 0.0) / max(np.sqrt(squared), 1e-6)
            if leaving > 0.0 and not rays.hidden(place[None], middle)[0]:
                day += area * leaving / max(squared, 0.25) / np.pi
    return _DAYLIT_LAMP + (1.0 - _DAYLIT_LAMP) * max(1.0 - day / _BRIGHT, 0.0)
