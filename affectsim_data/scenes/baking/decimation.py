"""Fewer triangles, and how far that moves the surface."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.errors import require_extra
from affectsim_data.poses import FloatArray
from affectsim_data.scenes.baking.merging import with_own_corners
from affectsim_data.scenes.solids import weld_places
from affectsim_data.scenes.surfaces import Surface

__all__ = ["decimate_surfaces"]

_ROUNDS = (
    (4, 1.5, True),
    (12, 1.5, True),
    (40, 2.0, True),
    (255, 2.0, True),
    (255, 4.0, True),
    (255, 4.0, False),
)
"""Each takes what the ones before left too many: the colour difference from which triangles stay
as they are, how far the library goes (its error bound ends at 1e-9 * 103^x, square metres), and
whether open edges stay."""
_MAX_STRETCH = 16.0
"""How far outside its old triangle a corner takes its texture coordinates from."""


def decimate_surfaces(surfaces: Sequence[Surface], max_triangles: int) -> list[Surface]:
    """Surfaces with at most `max_triangles` in all; those come first that are missed least.

    Quadric edge collapses (fast-simplification) over all surfaces at once. Vertices of a surface
    are one where they are in the same place, so that it does not tear. Triangles whose colour
    changes, because light falls on them, and open edges stay as they are as long as that is
    enough. Every corner takes its colour and texture coordinates from the plane of the triangle it
    was in, so pictures stay in place.

    Raises:
        MissingExtraError: fast-simplification is not installed.
    """
    if sum(len(surface.faces) for surface in surfaces) <= max_triangles:
        return list(surfaces)
    points, corners = _welded(surfaces)
    owner = np.repeat(np.arange(len(surfaces)), [len(one.faces) for one in surfaces])
    number = np.concatenate([np.arange(len(one.faces)) for one in surfaces])
    kept = np.flatnonzero((corners != np.roll(corners, 1, axis=1)).all(axis=1))
    corners = corners[kept]
    contrast = np.concatenate([_contrast(surface) for surface in surfaces])
    for max_contrast, reach, keep_borders in _ROUNDS:
        free = contrast[kept] <= max_contrast
        target = max_triangles - int((~free).sum())
        if len(corners) <= max_triangles or target <= 0:
            continue
        points, moved, chosen = _collapsed(
            points, corners[free], target, reach=reach, keep_borders=keep_borders
        )
        corners = np.concatenate([corners[~free], moved])
        kept = np.concatenate([kept[~free], kept[free][chosen]])
    if len(corners) > max_triangles:
        # A tangle does not go below a number of triangles: the smallest ones are left out.
        largest = np.argsort(-_areas(points[corners]), kind="stable")[:max_triangles]
        corners, kept = corners[largest], kept[largest]
    corners, kept, small = corners[np.argsort(kept)], np.sort(kept), []
    for index, surface in enumerate(surfaces):
        mine = owner[kept] == index
        old = dataclasses.replace(surface, faces=surface.faces[number[kept[mine]]])
        small.append(_moved(with_own_corners(old), points[corners[mine]].reshape(-1, 3)))
    return [one for one in small if len(one.faces)]


def _welded(surfaces: Sequence[Surface]) -> tuple[FloatArray, NDArray[np.int64]]:
    """One point for each place of each surface `(n, 3)`, and triangles over them `(m, 3)`."""
    points, corners, start = [], [], 0
    for surface in surfaces:
        place = weld_places(surface.positions.astype(np.float64))
        spots = np.zeros((int(place.max(initial=-1)) + 1, 3))
        spots[place] = surface.positions
        points.append(spots)
        corners.append(place[surface.faces.astype(np.int64)] + start)
        start += len(spots)
    return np.concatenate(points), np.concatenate(corners)


def _collapsed(
    points: FloatArray,
    corners: NDArray[np.int64],
    max_faces: int,
    *,
    reach: float,
    keep_borders: bool,
) -> tuple[FloatArray, NDArray[np.int64], NDArray[np.int64]]:
    """The points where they are now, the triangles left over them, and which those were."""
    simplification = require_extra("fast_simplification", extra="build")
    new_points, new_corners, collapses = simplification.simplify(
        points,
        corners,
        target_count=max_faces,
        agg=reach,
        return_collapses=True,
        preserve_border=keep_borders,
    )
    into = np.arange(len(points))
    into[collapses[:, 1]] = collapses[:, 0]
    while not np.array_equal(into[into], into):
        into = into[into]
    moved = into[corners]
    chosen = np.flatnonzero((moved != np.roll(moved, 1, axis=1)).all(axis=1))
    # Triangles and points keep their order, so those that are left are told by their place.
    left, ranks = np.unique(moved[chosen], return_inverse=True)
    assert np.array_equal(ranks.reshape(-1, 3), new_corners), "triangles were dropped unasked"
    points = points.copy()
    points[left] = new_points
    return points, moved[chosen], chosen


def _contrast(surface: Surface) -> NDArray[np.uint8]:
    """How much the vertex colours of each triangle differ, of 255, `(num_faces,)`."""
    colors = surface.colors[surface.faces][..., :3]
    differences: NDArray[np.uint8] = np.ptp(colors, axis=1).max(axis=1)
    return differences


def _areas(corners: FloatArray) -> FloatArray:
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas: FloatArray = np.linalg.norm(across, axis=1) / 2.0
    return areas


def _moved(old: Surface, points: FloatArray) -> Surface:
    """A surface of loose triangles with its corners at `points`, its looks staying in place."""
    weights = barycentric(points, np.repeat(old.positions[old.faces], 3, axis=0))
    inside = np.clip(weights, 0.0, None)
    inside /= inside.sum(axis=1, keepdims=True)
    own = np.repeat(old.faces, 3, axis=0)
    colors = np.einsum("nk,nkc->nc", inside, old.colors[own].astype(np.float64))
    uvs = None
    if old.uvs is not None:
        far = np.abs(weights - 0.5).max(axis=1) > 0.5 + _MAX_STRETCH
        weights[far] = inside[far]
        uvs = np.einsum("nk,nkc->nc", weights, old.uvs[own].astype(np.float64)).astype(np.float32)
    return dataclasses.replace(
        old, positions=points.astype(np.float32), colors=np.rint(colors).astype(np.uint8), uvs=uvs
    )


def barycentric(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Weights `(n, 3)` of triangle corners `(n, 3, 3)` at points dropped on their planes."""
    corners = corners.astype(np.float64)
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    w = points - corners[:, 0]
    uu, vv, uv = (np.einsum("ij,ij->i", a, b) for a, b in ((u, u), (v, v), (u, v)))
    wu, wv = (np.einsum("ij,ij->i", w, a) for a in (u, v))
    # Triangles without area were dropped before.
    bottom = np.maximum(uu * vv - uv * uv, 1e-30)
    second, third = (vv * wu - uv * wv) / bottom, (uu * wv - uv * wu) / bottom
    return np.stack([1.0 - second - third, second, third], axis=1)
