"""Distance to a ring around an anchor: how far a robot must go to stand at a given distance.

Let u be the last bend of a shortest way to the ring (its start, or a reflex corner). The way meets
the ring first on its nearer circle: at the foot of u, the point of the circle straight towards or
away from the anchor, or, where that is hidden, where the circle crosses a wall. These are finitely
many points, so no sampling is needed. A hidden foot whose best visible point lies at the edge of a
shadow needs no candidate: the corner that throws the shadow is a bend itself.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.navmesh.roadmap import Roadmap
from affectsim_data.navmesh.walls import TANGENT_M, cross
from affectsim_data.poses import FloatArray

__all__ = ["Ring", "ring_distance"]

BATCH = 16


@dataclasses.dataclass(frozen=True)
class Ring:
    """Points p of the floor with `inner <= |p - anchor| <= outer`, in 3-D."""

    anchor: FloatArray
    """Metres, `(3,)`."""
    inner: float
    """Metres."""
    outer: float
    """Metres."""

    def circles(self, island: Island) -> tuple[float, float]:
        """Inner and outer radius on the plan at the height of an island; `nan` if out of reach."""
        rise2 = (island.median_y - float(self.anchor[1])) ** 2
        if self.outer**2 < rise2:
            return math.nan, math.nan
        inner2 = max(self.inner, 0.0) ** 2 - rise2
        return math.sqrt(max(inner2, 0.0)), math.sqrt(self.outer**2 - rise2)

    def meets(self, island: Island) -> bool:
        """Whether a point of the island is on the ring; an island is connected."""
        inner, outer = self.circles(island)
        center = self.anchor[[0, 2]]
        near = float(np.linalg.norm(island.nearest(center[None])[0] - center))
        far = float(np.linalg.norm(island.walls.start - center, axis=1).max())
        return near <= outer and far >= inner


def ring_distance(roadmap: Roadmap, start: FloatArray, ring: Ring) -> float:
    """Geodesic distance from a point of the roadmap's island, `(3,)`, to a ring that meets it."""
    inner, outer = ring.circles(roadmap.island)
    center = ring.anchor[[0, 2]]
    away = float(np.linalg.norm(start[[0, 2]] - center))
    if inner <= away <= outer:
        return 0.0
    radius = outer if away > outer else inner
    sight = roadmap.sights(start[None])[0]
    bends = np.concatenate([start[None], roadmap.corners])
    reached = np.concatenate([[0.0], roadmap.corner_distances(sight)])
    bend, contact = _candidates(roadmap.island, bends, center, radius, away > outer)
    contact_y = roadmap.island.height_at(contact)
    rise = contact_y - bends[bend, 1]
    leg = np.linalg.norm(contact - bends[bend][:, [0, 2]], axis=1)
    length = reached[bend] + np.hypot(leg, rise)
    return _first_visible(roadmap.island, bends[bend][:, [0, 2]], contact, length)


def _candidates(
    island: Island, bends: FloatArray, center: FloatArray, radius: float, outside: bool
) -> tuple[IntArray, FloatArray]:
    """Last bends and contacts `(x, z)` among which the shortest way to a circle ends.

    `bends` are the start and the reflex corners, `(n, 3)`.
    """
    plan = bends[:, [0, 2]]
    offset = plan - center
    away = np.linalg.norm(offset, axis=1)
    # A way reaches the circle from the side it starts on, so its bends lie on that side.
    there = np.flatnonzero((away >= radius - 1e-9) if outside else (away <= radius + 1e-9))
    # From the anchor itself every direction is as good as any other.
    apart = (away > 1e-9)[:, None]
    outwards = np.where(apart, offset / np.where(apart, away[:, None], 1.0), [1.0, 0.0])
    feet = center + radius * outwards[there]
    crossings = _wall_crossings(island, center, radius)
    bend = np.concatenate([there, np.repeat(there, len(crossings))])
    contact = np.concatenate([feet, np.tile(crossings, (len(there), 1))])
    useful = (bend == 0) | _bends_towards(island, bend - 1, contact)
    return bend[useful], contact[useful]


def _wall_crossings(island: Island, center: FloatArray, radius: float) -> FloatArray:
    """Where a circle crosses or touches walls, `(n, 2)`."""
    walls = island.walls
    along = (walls.end - walls.start) / walls.length[:, None]
    offset = walls.start - center
    middle = -np.sum(offset * along, axis=1)
    half2 = radius**2 - cross(along, offset) ** 2
    half = np.sqrt(np.maximum(half2, 0.0))
    place = np.stack([middle - half, middle + half])
    on_edge = (half2 >= -1e-9) & (place >= -1e-9) & (place <= walls.length + 1e-9)
    edge = np.nonzero(on_edge)[1]
    share = np.clip(place[on_edge] / walls.length[edge], 0.0, 1.0)[:, None]
    crossings: FloatArray = (1.0 - share) * walls.start[edge] + share * walls.end[edge]
    return crossings


def _bends_towards(island: Island, corner: IntArray, contact: FloatArray) -> BoolArray:
    """Whether a shortest way can bend at reflex corners, `(n,)`, towards contacts, `(n, 2)`."""
    walls = island.walls
    if not len(walls.reflex):
        return np.zeros(len(corner), bool)
    index = walls.reflex[corner]
    line = contact - walls.start[index]
    slack = TANGENT_M * np.linalg.norm(line, axis=1)
    before = cross(line, walls.start[walls.previous[index]] - walls.start[index])
    after = cross(line, walls.end[index] - walls.start[index])
    bends: BoolArray = (np.minimum(before, after) >= -slack) | (np.maximum(before, after) <= slack)
    return bends


def _first_visible(
    island: Island, bend: FloatArray, contact: FloatArray, length: FloatArray
) -> float:
    """Shortest of the ways whose last leg, `bend` to `contact`, no wall blocks."""
    order = np.argsort(length, kind="stable")
    order = order[np.isfinite(length[order])]
    low, size = 0, BATCH
    while low < len(order):
        batch = order[low : low + size]
        free = ~island.walls.blocked(bend[batch], contact[batch])
        if np.any(free):
            return float(length[batch[int(np.argmax(free))]])
        low, size = low + size, 2 * size
    return math.inf
