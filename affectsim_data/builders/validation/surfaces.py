"""How far points are from the surfaces of a scene, exactly, and which are inside closed things."""

from __future__ import annotations

import functools

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.scenes.solids import closed_solids

__all__ = ["SceneSurface", "scene_surface"]

_PAIRS_AT_ONCE = 1 << 20
_THIN = 1e-12


class SceneSurface:
    """All triangles of a scene, found by where they lie on the plan."""

    def __init__(self, scene: Scene) -> None:
        vertices, faces = scene.mesh()
        corners = vertices[faces]
        is_closed, _ = closed_solids(vertices, faces)
        low, high = corners.min(axis=1), corners.max(axis=1)
        self._corners, self._low_y, self._high_y = corners, low[:, 1], high[:, 1]
        self._tree = shapely.STRtree(shapely.box(*low[:, [0, 2]].T, *high[:, [0, 2]].T))
        # Seen from above, faces that look up turn one way and those that look down the other.
        edges = corners[:, 1:] - corners[:, :1]
        self._turn = np.where(is_closed, np.sign(np.cross(edges[:, 0], edges[:, 1])[:, 1]), 0.0)

    def distance(self, points: FloatArray, *, limit: float) -> FloatArray:
        """To the nearest surface, metres, `(n,)` for `(n, 3)`; `limit` where none is as near."""
        nearest = np.full(len(points), limit)
        x, y, z = points.T
        boxes = shapely.box(x - limit, z - limit, x + limit, z + limit)
        pairs = self._tree.query(boxes)
        place, face = pairs
        near = (self._low_y[face] <= y[place] + limit) & (self._high_y[face] >= y[place] - limit)
        place, face = pairs[:, near]
        for low in range(0, len(place), _PAIRS_AT_ONCE):
            part = slice(low, low + _PAIRS_AT_ONCE)
            gaps = _triangle_distance(points[place[part]], self._corners[face[part]])
            np.minimum.at(nearest, place[part], gaps)
        return nearest

    def inside(self, points: FloatArray) -> NDArray[np.bool_]:
        """Whether points `(n, 3)` are in a closed solid, `(n,)`: more ways out than in above."""
        place, face = self._tree.query(shapely.points(points[:, [0, 2]]))
        above = (self._turn[face] != 0.0) & (self._high_y[face] >= points[place, 1])
        place, face = place[above], face[above]
        height = _height_over(points[place], self._corners[face])
        crossed = height > 0.0
        depth = np.bincount(place[crossed], self._turn[face[crossed]], minlength=len(points))
        return np.asarray(depth > 0.0)


@functools.lru_cache(maxsize=2)
def scene_surface(scene: Scene) -> SceneSurface:
    """The surface of a scene; that of the last ones is kept."""
    return SceneSurface(scene)


def _height_over(points: FloatArray, corners: FloatArray) -> FloatArray:
    """How far above each point its triangle is, metres, `(n,)`; `-inf` if it is beside it."""
    a, b, c = (corners[:, i] for i in range(3))
    u, v, w = b - a, c - a, points - a
    area = u[:, 0] * v[:, 2] - u[:, 2] * v[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (w[:, 0] * v[:, 2] - w[:, 2] * v[:, 0]) / area
        t = (u[:, 0] * w[:, 2] - u[:, 2] * w[:, 0]) / area
        height: FloatArray = a[:, 1] + s * u[:, 1] + t * v[:, 1] - points[:, 1]
    beside = ~((s >= 0.0) & (t >= 0.0) & (s + t <= 1.0))
    height[beside] = -np.inf
    return height


def _triangle_distance(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Distance of each point `(n, 3)` to its own triangle `(n, 3, 3)`, `(n,)`.

    To the plane where its foot is inside the triangle, else to the nearest edge.
    """
    a = corners[:, 0]
    u, v, w = corners[:, 1] - a, corners[:, 2] - a, points - a
    normal = np.cross(u, v)
    doubled = np.einsum("ni,ni->n", normal, normal)
    safe = np.maximum(doubled, _THIN)
    s = np.einsum("ni,ni->n", np.cross(w, v), normal) / safe
    t = np.einsum("ni,ni->n", np.cross(u, w), normal) / safe
    over = (doubled > _THIN) & (s >= 0.0) & (t >= 0.0) & (s + t <= 1.0)
    plane = np.abs(np.einsum("ni,ni->n", w, normal)) / np.sqrt(safe)
    ends = np.roll(corners, -1, axis=1)
    along, off = ends - corners, points[:, None] - corners
    length = np.maximum(np.einsum("nki,nki->nk", along, along), _THIN)
    share = np.clip(np.einsum("nki,nki->nk", off, along) / length, 0.0, 1.0)
    edge = np.linalg.norm(off - share[..., None] * along, axis=2).min(axis=1)
    nearest: FloatArray = np.where(over, plane, edge)
    return nearest
