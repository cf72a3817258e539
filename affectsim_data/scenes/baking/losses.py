"""How far one mesh is from another, over points drawn on both."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.baking.decimation import barycentric
from affectsim_data.scenes.baking.report import BakeLoss
from affectsim_data.scenes.surfaces import Surface

__all__ = ["measure_loss"]

_POINTS = 5_000
_DENSE = 100_000
_NEAREST = 8


def measure_loss(before: Sequence[Surface], after: Sequence[Surface]) -> BakeLoss:
    """Distances from either mesh to the other, and of the vertex colours there.

    Points are drawn by area from a fixed seed. The triangle nearest to one is looked for among
    those of the dense points nearest to it, so a distance is rather too large than too small.
    """
    rng = np.random.default_rng(0)
    meshes = [_joined(surfaces) for surfaces in (before, after)]
    distances, levels = [], []
    for here, there in (meshes, meshes[::-1]):
        points, colors = _drawn(*here, _POINTS, rng)[:2]
        found, other = _nearest(points, *there, rng)
        distances.append(found)
        levels.append(np.abs(colors - other).mean(axis=1))
    distance, level = np.concatenate(distances), np.concatenate(levels)
    return BakeLoss(
        float(distance.mean()) * 1e3, float(distance.max()) * 1e3, float(level.mean()), len(level)
    )


def _joined(surfaces: Sequence[Surface]) -> tuple[FloatArray, FloatArray]:
    """Corners and their colours, `(n, 3, 3)` each."""
    corners = [one.positions[one.faces].astype(np.float64) for one in surfaces]
    colors = [one.colors[one.faces][..., :3].astype(np.float64) for one in surfaces]
    return np.concatenate(corners), np.concatenate(colors)


def _drawn(
    corners: FloatArray, colors: FloatArray, count: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Points by area, their colours and their triangles."""
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    triangle = rng.choice(len(areas), count, p=areas / areas.sum())
    weights = rng.dirichlet((1.0, 1.0, 1.0), count)
    points = np.einsum("nk,nkc->nc", weights, corners[triangle])
    return points, np.einsum("nk,nkc->nc", weights, colors[triangle]), triangle


def _nearest(
    points: FloatArray, corners: FloatArray, colors: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Distance to the nearest triangle, and the colour there."""
    from scipy.spatial import cKDTree

    dense, _, owner = _drawn(corners, colors, _DENSE, rng)
    # A corner of every triangle too: small ones may have no point at all.
    dense = np.concatenate([dense, corners.mean(axis=1)])
    owner = np.concatenate([owner, np.arange(len(corners))])
    _, near = cKDTree(dense).query(points, k=_NEAREST)
    triangles = owner[near]
    tried = corners[triangles].reshape(-1, 3, 3)
    weights = _closest(np.repeat(points, _NEAREST, axis=0), tried)
    places = np.einsum("nk,nkc->nc", weights, tried).reshape(-1, _NEAREST, 3)
    distance = np.linalg.norm(places - points[:, None], axis=2)
    best = np.argmin(distance, axis=1)
    rows = np.arange(len(points))
    chosen = weights.reshape(-1, _NEAREST, 3)[rows, best]
    shade = np.einsum("nk,nkc->nc", chosen, colors[triangles[rows, best]])
    return distance[rows, best], shade


def _closest(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Weights of the point of each triangle that is closest to a point."""
    weights = barycentric(points, corners)
    outside = (weights < 0.0).any(axis=1)
    best = np.full(len(points), np.inf)
    found = weights.copy()
    for start in range(3):
        end = (start + 1) % 3
        edge = corners[:, end] - corners[:, start]
        along = np.einsum("ij,ij->i", points - corners[:, start], edge)
        share = np.clip(along / np.maximum(np.einsum("ij,ij->i", edge, edge), 1e-30), 0.0, 1.0)
        gap = np.linalg.norm(corners[:, start] + share[:, None] * edge - points, axis=1)
        better = outside & (gap < best)
        best[better] = gap[better]
        found[better] = 0.0
        found[better, start], found[better, end] = 1.0 - share[better], share[better]
    return found
