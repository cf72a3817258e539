"""Where points lie on the islands of a navmesh, and random points on them."""

from __future__ import annotations

import math

import numpy as np
import shapely
from numpy.typing import ArrayLike

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.rasterize import IntArray
from affectsim_data.poses import FloatArray

__all__ = [
    "SNAP_TOLERANCE_M",
    "Point",
    "checked_point",
    "checked_points",
    "nearest_point",
    "nearest_points",
    "off_mesh",
    "plan_region",
    "random_plan_points",
    "snapped_points",
]

# Largest distance of a start or goal to the navmesh, metres.
SNAP_TOLERANCE_M = 0.1
Point = tuple[float, float, float]
# Of the polygon around a disc that area is drawn from before what is outside is thrown away.
DISC_SIDES = 32


def off_mesh(point: FloatArray, offset: float, limit: float) -> ValueError:
    """The error for a point that is too far off."""
    place = ", ".join(f"{value:.3f}" for value in point)
    return ValueError(f"point ({place}) is {offset:.3f} m off the navmesh, more than {limit:g} m")


def checked_point(point: ArrayLike) -> Point:
    """Coordinates of a point, `(3,)`.

    Raises:
        ValueError: Another shape, or a number that is not finite.
    """
    array = np.asarray(point, np.float64)
    if array.shape not in ((3,), (1, 3)):
        raise ValueError(f"a point must be (3,), got {array.shape}")
    x, y, z = array.reshape(3).tolist()
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise ValueError(f"points must be finite, got {array}")
    return x, y, z


def checked_points(points: ArrayLike) -> FloatArray:
    """Points, `(n, 3)`, from `(3,)` or `(n, 3)`.

    Raises:
        ValueError: Another shape, or a number that is not finite.
    """
    array = np.asarray(points, np.float64)
    if array.ndim not in (1, 2) or array.shape[-1] != 3:
        raise ValueError(f"points must be (3,) or (n, 3), got {array.shape}")
    if not np.all(np.isfinite(array)):
        raise ValueError(f"points must be finite, got {array}")
    return array.reshape(-1, 3)


def nearest_point(islands: tuple[Island, ...], x: float, y: float, z: float) -> tuple[Point, int]:
    """The point of the islands nearest to another one, and its island."""
    best, nearest, which = math.inf, (x, y, z), 0
    for number, island in enumerate(islands):
        (low_x, low_y, low_z), (high_x, high_y, high_z) = island.low, island.high
        out_x = max(low_x - x, 0.0, x - high_x)
        out_y = max(low_y - y, 0.0, y - high_y)
        if math.hypot(out_x, out_y, max(low_z - z, 0.0, z - high_z)) >= best:
            continue
        on_x, on_z = island.nearest_here(x, z)
        on_y = island.height_here(on_x, on_z)
        offset = math.dist((on_x, on_y, on_z), (x, y, z))
        if offset < best:
            best, nearest, which = offset, (on_x, on_y, on_z), number
    return nearest, which


def nearest_points(islands: tuple[Island, ...], points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The points of the islands nearest to others, `(n, 3)`, and their islands, `(n,)`."""
    best = np.full(len(points), np.inf)
    nearest, which = points.copy(), np.zeros(len(points), np.int64)
    for number, island in enumerate(islands):
        outside = np.maximum(np.maximum(island.low - points, points - island.high), 0.0)
        near = np.flatnonzero(np.linalg.norm(outside, axis=1) < best)
        if not len(near):
            continue
        found = island.on_floor(island.nearest(points[near][:, [0, 2]]))
        offset = np.linalg.norm(found - points[near], axis=1)
        closer = offset < best[near]
        chosen = near[closer]
        best[chosen], nearest[chosen], which[chosen] = offset[closer], found[closer], number
    return nearest, which


def snapped_points(
    islands: tuple[Island, ...], points: FloatArray, max_offset: float = SNAP_TOLERANCE_M
) -> tuple[FloatArray, IntArray]:
    """`nearest_points` of points that are near enough.

    Raises:
        ValueError: A point is farther off than `max_offset`, metres.
    """
    nearest, which = nearest_points(islands, points)
    offset = np.linalg.norm(nearest - points, axis=1)
    far = np.flatnonzero(offset > max_offset)
    if len(far):
        raise off_mesh(points[far[0]], float(offset[far[0]]), max_offset)
    return nearest, which


def plan_region(within: ArrayLike | None, disc: tuple[ArrayLike, float] | None) -> shapely.Geometry:
    """A polygon `(k, 2)`, a disc's surrounding polygon, or what they have in common."""
    regions = []
    if within is not None:
        corners = np.asarray(within, np.float64)
        if corners.ndim != 2 or corners.shape[1] != 2 or len(corners) < 3:
            raise ValueError(f"within must be corners (x, z), (k, 2), got {corners.shape}")
        regions.append(shapely.make_valid(shapely.Polygon(corners)))
    if disc is not None:
        center, radius = np.asarray(disc[0], np.float64), float(disc[1])
        if center.shape != (3,) or not (math.isfinite(radius) and radius > 0.0):
            raise ValueError(f"disc must be a point (3,) and a radius above 0 m, got {disc}")
        angle = 2.0 * np.pi * np.arange(DISC_SIDES) / DISC_SIDES
        rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        around = center[[0, 2]] + radius / math.cos(math.pi / DISC_SIDES) * rim
        regions.append(shapely.Polygon(around))
    return shapely.intersection_all(regions)


def random_plan_points(
    parts: list[shapely.Geometry],
    count: int,
    rng: np.random.Generator,
    *,
    disc: tuple[ArrayLike, float] | None = None,
) -> tuple[FloatArray, IntArray]:
    """Points `(x, z)` uniform over the area of polygons, and the polygon of each.

    Raises:
        ValueError: The polygons have no area.
    """
    areas = np.array([part.area for part in parts])
    if not areas.sum() > 1e-9:
        raise ValueError("the navmesh has no floor there to draw points from")
    which = rng.choice(len(parts), size=count, p=areas / areas.sum())
    plan = np.empty((count, 2))
    for number, part in enumerate(parts):
        member = np.flatnonzero(which == number)
        if len(member):
            plan[member] = _uniform(part, len(member), rng)
    if disc is not None:
        off = np.hypot(*(plan - np.asarray(disc[0], np.float64)[[0, 2]]).T) > float(disc[1])
        # The surrounding polygon is less than 1 % larger than the disc.
        if np.any(off):
            again = random_plan_points(parts, int(off.sum()), rng, disc=disc)
            plan[off], which[off] = again
    return plan, which


def _uniform(part: shapely.Geometry, count: int, rng: np.random.Generator) -> FloatArray:
    """Points uniform over the area of a polygon, `(count, 2)`."""
    shapely.prepare(part)
    low_x, low_z, high_x, high_z = part.bounds
    found = np.empty((0, 2))
    while len(found) < count:
        # Each round draws a fixed share more than is missing, so that few rounds are needed.
        tries = 16 + int(1.5 * (count - len(found)))
        points = rng.uniform((low_x, low_z), (high_x, high_z), (tries, 2))
        inside = shapely.contains_xy(part, points[:, 0], points[:, 1])
        found = np.concatenate([found, points[inside]])
    return found[:count]
