"""Distance to a ring around an anchor: how far a robot must go to stand at a given distance.

Let u be the last bend of a shortest way to the ring (its start, or a reflex corner). The way meets
the ring first on its nearer circle: at the foot of u, the point of the circle straight towards or
away from the anchor, or, where that is hidden, where the circle crosses a wall. These are finitely
many points, so no sampling is needed. A hidden foot whose best visible point lies at the edge of a
shadow needs no candidate: the corner that throws the shadow is a bend itself.

On a floor that rises the ring is no circle. There the contacts are moved along their rays and walls
to the distance they must have in 3-D, and the choice among them is as good as the floor is even.
"""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import IntArray
from affectsim_data.navmesh.roadmap import Roadmap
from affectsim_data.navmesh.ways import reach_of
from affectsim_data.poses import FloatArray

__all__ = ["Ring", "ring_distance", "ring_distances"]

BATCH = 16
# Below this change of height over an island a ring is a circle; metres.
EVEN_M = 0.05
# Corrections of a contact for the height of the floor under it.
ROUNDS = 4


@dataclasses.dataclass(frozen=True)
class Ring:
    """Points p of the floor with `inner <= |p - anchor| <= outer`, in 3-D."""

    anchor: FloatArray
    """Metres, `(3,)`."""
    inner: float
    """Metres."""
    outer: float
    """Metres."""

    @classmethod
    def around(cls, anchor: tuple[float, float, float], distance: float, tolerance: float) -> Ring:
        """Points at a distance from an anchor, give or take a tolerance, metres.

        Raises:
            ValueError: A number is not finite or is negative.
        """
        for name, value in (("distance", distance), ("tolerance", tolerance)):
            if not (math.isfinite(value) and value >= 0.0):
                raise ValueError(f"{name} must be at least 0 m, got {value}")
        return cls(np.array(anchor), distance - tolerance, distance + tolerance)

    @functools.cached_property
    def center(self) -> FloatArray:
        """The anchor on the plan, `(2,)`."""
        return self.anchor[[0, 2]]

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
        x, z = self.center.tolist()
        near_x, near_z = island.nearest_here(x, z)
        far = math.sqrt(float(np.max(np.sum((island.walls.start - self.center) ** 2, axis=1))))
        return math.hypot(near_x - x, near_z - z) <= outer and far >= inner

    def away(self, island: Island, plan: FloatArray) -> FloatArray:
        """Distance of points of an island, `(n, 2)`, that the ring asks for, metres, `(n,)`.

        On the plan at the median height of an even floor, else in 3-D as seen from there.
        """
        flat: FloatArray = np.hypot(*(plan - self.center).T)
        if _is_even(island):
            return flat
        rise2 = (island.height_at(plan) - self.anchor[1]) ** 2
        level2 = (island.median_y - self.anchor[1]) ** 2
        away: FloatArray = np.sqrt(np.maximum(flat**2 + rise2 - level2, 0.0))
        return away


def ring_distance(roadmap: Roadmap, start: FloatArray, ring: Ring) -> float:
    """Geodesic distance from a point of the roadmap's island, `(2,)`, to a ring that meets it."""
    island = roadmap.island
    inner, outer = ring.circles(island)
    away = float(ring.away(island, start[None])[0])
    if inner <= away <= outer:
        return 0.0
    sight = roadmap.sight(float(start[0]), float(start[1]))
    distance, first = roadmap.corner_distances(sight)
    bends = np.concatenate([start[None], roadmap.corners])
    reached = np.concatenate([[0.0], distance])
    bend, contact = _candidates(island, bends, ring, outer if away > outer else inner, away > outer)
    way = reached[bend] + np.hypot(*(contact - bends[bend]).T)
    corner = np.where(bend > 0, island.walls.reflex[bend - 1], -1) if len(first) else bend - 1
    corner[bend == 0] = island.walls.corner_here(*start.tolist())
    best = _first_visible(island, bends[bend], contact, way, corner)
    if best < 0:
        return math.inf
    if island.is_level:
        return float(way[best])
    if bend[best] == 0:
        return float(island.floor_lengths(start[None], contact[[best]])[0])
    last = int(bend[best]) - 1
    return roadmap.length_between(start, int(first[last]), last, contact[best])


def ring_distances(roadmap: Roadmap, starts: FloatArray, ring: Ring) -> FloatArray:
    """`ring_distance` of many points, `(n, 2)`, metres, `(n,)`."""
    inner, outer = ring.circles(roadmap.island)
    away = ring.away(roadmap.island, starts)
    distance = np.zeros(len(starts))
    for outside in (True, False):
        there = np.flatnonzero(away > outer if outside else away < inner)
        radius = outer if outside else inner
        distance[there] = _from_one_side(roadmap, starts[there], ring, radius, outside)
    return distance


def _from_one_side(
    roadmap: Roadmap, starts: FloatArray, ring: Ring, radius: float, outside: bool
) -> FloatArray:
    """Distances of starts that all lie outside or all inside the ring, metres, `(n,)`."""
    island, count = roadmap.island, len(starts)
    points = np.concatenate([starts, roadmap.corners])
    bend, contact = _candidates(island, points, ring, radius, outside, num_starts=count)
    leg = np.hypot(*(contact - points[bend]).T)
    over = bend >= count
    last = _visible_smallest(island, points, bend[over], contact[over], leg[over], len(points))
    leg_of = np.full(len(points), np.inf)
    leg_of[last >= 0] = leg[over][last[last >= 0]]
    reach = reach_of(roadmap, starts)
    ways = reach.distance + leg_of[count:]
    corner = np.argmin(ways, axis=1) if ways.shape[1] else np.zeros(count, np.int64)
    row = np.arange(count)
    shortest = ways[row, corner] if ways.shape[1] else np.full(count, np.inf)
    # A straight way is looked at only where it would be shorter than the one over corners.
    direct = np.flatnonzero(~over)
    direct = direct[leg[direct] < shortest[bend[direct]]]
    straight = _visible_smallest(
        island, points, bend[direct], contact[direct], leg[direct], len(points)
    )[:count]
    if island.is_level:
        shortest[straight >= 0] = leg[direct][straight[straight >= 0]]
        return shortest
    turned = np.flatnonzero((straight < 0) & np.isfinite(shortest))
    end = contact[over][last[count + corner[turned]]]
    shortest[turned] = reach.lengths(roadmap, turned, corner[turned])
    shortest[turned] += island.floor_lengths(roadmap.corners[corner[turned]], end)
    ahead = np.flatnonzero(straight >= 0)
    shortest[ahead] = island.floor_lengths(starts[ahead], contact[direct][straight[ahead]])
    return shortest


def _visible_smallest(
    island: Island,
    points: FloatArray,
    bend: IntArray,
    contact: FloatArray,
    leg: FloatArray,
    num_points: int,
) -> IntArray:
    """Index of the shortest free leg of every point, -1 for none, `(num_points,)`."""
    free = np.flatnonzero(~island.walls.blocked(points[bend], contact))
    free = free[np.lexsort((leg[free], bend[free]))]
    found, first = np.unique(bend[free], return_index=True)
    best = np.full(num_points, -1)
    best[found] = free[first]
    return best


def _candidates(
    island: Island,
    bends: FloatArray,
    ring: Ring,
    radius: float,
    outside: bool,
    num_starts: int = 1,
) -> tuple[IntArray, FloatArray]:
    """Last bends and contacts `(x, z)` among which the shortest way to a circle ends.

    `bends` are the starts and then the reflex corners, `(n, 2)`.
    """
    offset = bends - ring.center
    away = ring.away(island, bends)
    # A way reaches the circle from the side it starts on, so its bends lie on that side.
    there = np.flatnonzero((away >= radius - 1e-9) if outside else (away <= radius + 1e-9))
    # From the anchor itself every direction is as good as any other.
    flat = np.hypot(*offset.T)
    apart = (flat > 1e-9)[:, None]
    outwards = np.where(apart, offset / np.where(apart, flat[:, None], 1.0), [1.0, 0.0])
    feet = ring.center + radius * outwards[there]
    if not _is_even(island):
        for _ in range(ROUNDS):
            feet = ring.center + _radius_at(island, ring, radius, feet)[:, None] * outwards[there]
    crossings = _wall_crossings(island, ring, radius)
    bend = np.concatenate([there, np.repeat(there, len(crossings))])
    contact = np.concatenate([feet, np.tile(crossings, (len(there), 1))])
    useful = bend < num_starts
    over = np.flatnonzero(~useful)
    if len(over):
        corner = bend[over] - num_starts
        useful[over] = island.walls.bends(corner, contact[over] - bends[bend[over]])
    return bend[useful], contact[useful]


def _is_even(island: Island) -> bool:
    return island.rise <= EVEN_M


def _radius_at(island: Island, ring: Ring, radius: float, plan: FloatArray) -> FloatArray:
    """Radius on the plan of a circle given at median height, where the floor is as at points."""
    rise2 = (island.height_at(plan) - ring.anchor[1]) ** 2
    level2 = (island.median_y - ring.anchor[1]) ** 2
    there: FloatArray = np.sqrt(np.maximum(radius**2 + level2 - rise2, 0.0))
    return there


def _wall_crossings(island: Island, ring: Ring, radius: float) -> FloatArray:
    """Where a circle crosses or touches walls, `(n, 2)`."""
    walls, points = island.walls, np.empty((0, 2))
    w, (x, z) = island.walls.columns, ring.center
    off = (w.dx * (w.az - z) - w.dz * (w.ax - x)) / w.length
    # On a floor that rises the radius may grow by as much.
    slack = 0.0 if _is_even(island) else island.rise
    near = np.flatnonzero(np.abs(off) <= radius + slack + 1e-9)
    edge, sign = np.concatenate([near, near]), np.repeat([-1.0, 1.0], len(near))
    length, off2 = w.length[edge], off[edge] ** 2
    middle = ((x - w.ax[edge]) * w.dx[edge] + (z - w.az[edge]) * w.dz[edge]) / length
    half2 = radius**2 - off2
    for round_ in range(1 if _is_even(island) else ROUNDS):
        if round_:
            half2 = _radius_at(island, ring, radius, points) ** 2 - off2
        place = middle + sign * np.sqrt(np.maximum(half2, 0.0))
        share = np.minimum(np.maximum(place / length, 0.0), 1.0)[:, None]
        points = (1.0 - share) * walls.start[edge] + share * walls.end[edge]
    crossings: FloatArray = points[(half2 >= -1e-9) & (place >= -1e-9) & (place <= length + 1e-9)]
    return crossings


def _first_visible(
    island: Island, bend: FloatArray, contact: FloatArray, length: FloatArray, corner: IntArray
) -> int:
    """Index of the shortest way whose last leg, `bend` to `contact`, no wall blocks; -1 if none.

    `corner` says which corner each bend lies on, as `Walls.corner_at`.
    """
    order = np.argsort(length, kind="stable")
    order = order[np.isfinite(length[order])]
    low, size = 0, BATCH
    while low < len(order):
        batch = order[low : low + size]
        free = ~island.walls.blocked(bend[batch], contact[batch], corner[batch])
        if np.any(free):
            return int(batch[int(np.argmax(free))])
        low, size = low + size, 2 * size
    return -1
