"""Moves on an island: up to the first wall, or on along it.

Without sliding a move is a straight line that ends at the first wall. With sliding it has the
meaning of Detour's `moveAlongSurface`: within a disc whose diameter is the asked move, the point
nearest to its end that can be reached without leaving the disc. That point is the end itself or
lies on a wall, because from the rim of the disc one can always go on towards the end.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.poses import FloatArray

__all__ = ["StepResult", "moved", "was_clipped"]

# habitat-sim's rule for a collision; square metres.
CLIP_SLACK_M2 = 1e-5


@dataclasses.dataclass(frozen=True)
class StepResult:
    """Where a move ended."""

    position: FloatArray
    """On the floor, metres, `(3,)`."""
    clipped: bool
    """Whether it ended early: `|moved|^2 + 1e-5 < |asked|^2`, on the plan."""


def moved(
    island: Island, x: float, z: float, to_x: float, to_z: float, *, sliding: bool
) -> tuple[float, float]:
    """Where a move from `(x, z)` on the island towards another point ends."""
    share = island.walls.first_hit(x, z, to_x, to_z)
    if share == 1.0:
        return to_x, to_z
    if sliding:
        return _slid(island, x, z, to_x, to_z)
    return x + share * (to_x - x), z + share * (to_z - z)


def was_clipped(x: float, z: float, to_x: float, to_z: float, new_x: float, new_z: float) -> bool:
    """Whether a move from `(x, z)` that asked for `to` and came to `new` ended early."""
    asked2 = (to_x - x) ** 2 + (to_z - z) ** 2
    return (new_x - x) ** 2 + (new_z - z) ** 2 + CLIP_SLACK_M2 < asked2


def _slid(island: Island, x: float, z: float, to_x: float, to_z: float) -> tuple[float, float]:
    """The nearest point to the end that can be reached within the disc of a move."""
    source, target = np.array([x, z]), np.array([to_x, to_z])
    middle, radius = (source + target) / 2.0, math.hypot(to_x - x, to_z - z) / 2.0
    edge, points, distance = _nearest_on_walls(island, middle, radius, target)
    if len(points) and not island.contains(to_x, to_z):
        # Most often the nearest point is in sight; only walls in the disc can be between.
        best_x, best_z = points[int(np.argmin(distance))].tolist()
        if not island.walls.blocks(x, z, best_x, best_z, edge):
            return best_x, best_z
    points = np.concatenate([target[None], points[np.argsort(distance, kind="stable")]])
    reached = _reached_in_disc(island, source, middle, radius)
    one, two = (grid.ravel() for grid in np.indices((len(reached), len(points))))
    hidden = island.walls.blocked(reached[one], points[two]).reshape(len(reached), -1)
    seen = points[~np.all(hidden, axis=0)]
    return (float(seen[0, 0]), float(seen[0, 1])) if len(seen) else (x, z)


def _nearest_on_walls(
    island: Island, middle: FloatArray, radius: float, target: FloatArray
) -> tuple[IntArray, FloatArray, FloatArray]:
    """Walls in a disc `(n,)`; of each the point nearest to `target` `(n, 2)`, and how near `(n,)`.

    Only the part of a wall inside the disc counts.
    """
    w = island.walls.columns
    from_x, from_z = middle[0] - w.ax, middle[1] - w.az
    along = (from_x * w.dx + from_z * w.dz) / w.length
    half2 = radius * radius - (from_x * w.dz - from_z * w.dx) ** 2 / w.length**2
    half = np.sqrt(np.maximum(half2, 0.0))
    low, high = np.maximum(along - half, 0.0), np.minimum(along + half, w.length)
    edge = np.flatnonzero((half2 >= 0.0) & (low <= high))
    wish = (target[0] - w.ax[edge]) * w.dx[edge] + (target[1] - w.az[edge]) * w.dz[edge]
    length = w.length[edge]
    place = np.minimum(np.maximum(wish / length, low[edge]), high[edge]) / length
    x = (1.0 - place) * w.ax[edge] + place * w.bx[edge]
    z = (1.0 - place) * w.az[edge] + place * w.bz[edge]
    return edge, np.stack([x, z], axis=1), np.hypot(x - target[0], z - target[1])


def _reached_in_disc(
    island: Island, source: FloatArray, middle: FloatArray, radius: float
) -> FloatArray:
    """The source and the corners of the disc that can be reached without leaving it, `(n, 2)`."""
    corners = island.walls.start[island.walls.reflex]
    corners = corners[np.hypot(*(corners - middle).T) <= radius]
    points = np.concatenate([source[None], corners])
    one, two = (grid.ravel() for grid in np.indices((len(points), len(points))))
    sees: BoolArray = ~island.walls.blocked(points[one], points[two]).reshape(len(points), -1)
    reached = np.zeros(len(points), bool)
    reached[0] = True
    for _ in range(len(points)):
        reached |= np.any(sees[reached], axis=0)
    return points[reached]
