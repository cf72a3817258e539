"""Where light is computed: once for vertices at the same place that look the same way."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.rays import Array32
from affectsim_data.poses import FloatArray

__all__ = ["LightPoints", "light_points"]

_INWARD, _MOST_INWARD_M = 0.25, 0.05
"""How far a point is taken towards the middle of its triangles: at the very edge of a floor it
would lie inside of the baseboard."""
_LIFT_M = np.float32(0.012)
"""Rays start this far off their surface."""
_SAME_M = 0.001
_LARGEST_STEP_M = 0.5
_NORMAL_STEPS = 14
"""Steps of a normal's coordinates within which vertices count as looking the same way."""


@dataclasses.dataclass(frozen=True)
class LightPoints:
    """Places and normals at which light is computed."""

    positions: Array32
    """Metres, `(num_points, 3)`."""
    normals: Array32
    """Unit, `(num_points, 3)`."""
    of_vertex: NDArray[np.intp]
    """The point of each vertex, `(num_vertices,)`."""
    area: Array32
    """Of the triangles around each point, a third of each, m2, `(num_points,)`."""

    def starts(self, chosen: NDArray[np.intp]) -> Array32:
        """Starts of rays of some points, a little off their surfaces, `(n, 3)`."""
        return self.positions[chosen] + _LIFT_M * self.normals[chosen]


def light_points(
    positions: Array32, normals: Array32, faces: NDArray[np.int32], *, most: int | None = None
) -> LightPoints:
    """The points of a mesh; vertices within a millimetre that look the same way share one.

    Args:
        positions: Metres, `(n, 3)`.
        normals: Unit, `(n, 3)`.
        faces: Triangles, `(m, 3)`.
        most: If there would be more points, vertices further apart share one.
    """
    moved, area = _moved_inwards(positions, faces)
    step = _SAME_M
    first, of_vertex = _same_places(moved, normals, step)
    while most is not None and len(first) > most and step < _LARGEST_STEP_M:
        # Points lie on surfaces: half as many need steps longer by the root of two.
        step *= max(2.0, (len(first) / most) ** 0.5)
        first, of_vertex = _same_places(moved, normals, step)
    shares = np.bincount(of_vertex, area, minlength=len(first)).astype(np.float32)
    return LightPoints(moved[first], normals[first], of_vertex, shares)


def _moved_inwards(positions: Array32, faces: NDArray[np.int32]) -> tuple[Array32, FloatArray]:
    """Vertices, moved a little towards the middle of the triangles around them, and a third of
    the area of those, m2."""
    corners, count = faces.reshape(-1), len(positions)
    a, b, c = (positions[faces[:, k]] for k in range(3))
    number = np.maximum(np.bincount(corners, minlength=count), 1)
    way = np.empty_like(positions)
    for axis in range(3):
        middle = (a[:, axis] + b[:, axis] + c[:, axis]) / np.float32(3.0)
        way[:, axis] = np.bincount(corners, np.repeat(middle, 3), minlength=count) / number
    cross = np.cross(b - a, c - a)
    share = np.sqrt(np.einsum("ij,ij->i", cross, cross)) / 6.0
    area = np.bincount(corners, np.repeat(share, 3), minlength=count).astype(np.float64)
    way -= positions
    way[area == 0.0] = 0.0
    length = np.sqrt(np.einsum("ij,ij->i", way, way))
    moved = np.minimum(_INWARD, _MOST_INWARD_M / np.maximum(length, np.float32(1e-6)))
    places: Array32 = positions + moved.astype(np.float32)[:, None] * way
    return places, area


def _same_places(
    positions: Array32, normals: Array32, step_m: float
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """First vertex of each group of alike ones, and the group of each vertex."""
    low = positions.min(axis=0)
    # 16 bits a coordinate and 5 a direction fit into one integer, which sorts fast.
    step = max(step_m, float((positions.max(axis=0) - low).max()) / 65_000.0)
    places = [np.rint((positions[:, k] - low[k]) / step).astype(np.int64) for k in range(3)]
    key = np.zeros(len(positions), np.int64)
    # Boxes of half a metre first, then the normal: rays that start beside each other and go the
    # same way find what they need in the processor's cache.
    for place in places:
        key = (key << 7) | (place >> 9)
    for axis in range(3):
        key = (key << 5) | np.rint((normals[:, axis] + 1.0) * _NORMAL_STEPS).astype(np.int64)
    for place in places:
        key = (key << 9) | (place & 511)
    _, first, group = np.unique(key, return_index=True, return_inverse=True)
    return first.astype(np.intp), group.reshape(-1).astype(np.intp)
