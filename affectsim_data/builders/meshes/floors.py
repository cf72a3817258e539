"""Where the floor of a place in one mesh is, how far it reaches and how high it is above it."""

from __future__ import annotations

import dataclasses

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["Floor", "find_floor"]

_LEVEL = 0.9
"""Least upward part of the normal of a floor."""
_BIN_M = 0.05
_LEAST_SHARE = 0.35
"""A floor has this share of the area of the largest level with headroom."""
_HEADROOM_M = 1.7
LEAST_FLOOR_M2 = 2.0
"""A smaller floor is no room."""
_JOINT_M = 0.06
"""Gaps between pieces of floor up to twice this are closed."""
_SIMPLIFIED_M = 0.02
_MOST_TRIANGLES = 60_000
"""Of a floor whose outline is taken triangle by triangle; finer ones by squares of `_SQUARE_M`."""
_SQUARE_M = 0.1
_SAMPLES = 400


@dataclasses.dataclass(frozen=True)
class Floor:
    """A floor of one height."""

    y: float
    """Metres."""
    outlines: tuple[shapely.Polygon, ...]
    """On the plan `(x, z)`, largest first; one per part that is not connected to the others."""
    ceiling_y: float | None
    """Height of what is above it; none if there is only sky."""
    upside_down: NDArray[np.bool_]
    """Its triangles that face downwards, `(num_faces,)` of the mesh."""

    @property
    def area_m2(self) -> float:
        """Of all its parts on the plan."""
        return float(sum(outline.area for outline in self.outlines))


def find_floor(positions: FloatArray, faces: NDArray[np.int64]) -> Floor:
    """The lowest of the large level surfaces one can stand on.

    Args:
        positions: Metres, Y up, `(n, 3)`.
        faces: Triangles `(m, 3)`.

    Raises:
        ValueError: There is none of `LEAST_FLOOR_M2` with headroom.
    """
    corners = positions[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(across, axis=1) / 2.0
    with np.errstate(invalid="ignore", divide="ignore"):
        up = np.where(areas > 1e-9, across[:, 1] / (2.0 * areas), 0.0)
    level = np.abs(up) > _LEVEL
    heights = corners[:, :, 1].mean(axis=1)
    caster = RayCaster(positions, faces)
    best = _lowest_large(corners, areas, heights, level, up, caster)
    near = level & (np.abs(heights - best) <= 0.08)
    # Where a slab has a top and an underside, the top counts.
    if areas[near & (up > 0.0)].sum() >= 0.3 * areas[near].sum():
        near &= up > 0.0
    y = float(np.average(heights[near], weights=areas[near]))
    outlines = _outlines(corners[near][:, :, [0, 2]])
    if not outlines:
        raise ValueError(f"no floor: its pieces at y = {y:.2f} m are all too small to stand on")
    return Floor(y, outlines, _ceiling(caster, outlines, y), near & (up < 0.0))


def _lowest_large(
    corners: FloatArray, areas: FloatArray, heights: FloatArray, level: NDArray[np.bool_],
    up: FloatArray, caster: RayCaster,
) -> float:  # fmt: skip
    """Height of the lowest level surface that is large and has headroom."""
    chosen = np.flatnonzero(level & (areas > 1e-4))
    if not len(chosen):
        raise ValueError("no floor: no triangle is level; is another axis up (up='z')?")
    middles = corners[chosen].mean(axis=1) + np.array([0.0, 0.02, 0.0])
    free = caster.distance(middles, np.array([0.0, 1.0, 0.0])) >= _HEADROOM_M
    weights = areas[chosen] * free * np.where(up[chosen] > 0.0, 1.0, 0.5)
    bins = np.round(heights[chosen] / _BIN_M).astype(np.int64)
    low = int(bins.min())
    totals = np.bincount(np.clip(bins - low, 0, 200_000), weights=weights)
    # A floor may lie on the border of two bins.
    both = totals + np.concatenate([totals[1:], [0.0]])
    most = float(both.max())
    if most < LEAST_FLOOR_M2:
        raise ValueError(
            f"no floor: the largest level surface with {_HEADROOM_M} m above it has {most:.2f} m2, "
            f"{LEAST_FLOOR_M2} m2 are needed; is another axis up (up='z') or another unit meant "
            "(metres_per_unit)?"
        )
    first = int(np.flatnonzero(both >= _LEAST_SHARE * most)[0])
    if first + 1 < len(totals) and totals[first + 1] > totals[first]:
        first += 1
    inside = bins == low + first
    return float(np.average(heights[chosen][inside], weights=weights[inside] + 1e-12))


def _outlines(triangles: FloatArray) -> tuple[shapely.Polygon, ...]:
    """Outer outlines of triangles `(n, 3, 2)` on the plan, largest first."""
    if len(triangles) > _MOST_TRIANGLES:
        shapes = _squares(triangles)
    else:
        shapes = shapely.polygons(triangles)
    whole = shapely.union_all(shapely.set_precision(shapes, 0.0005))
    joined = whole.buffer(_JOINT_M, join_style="mitre").buffer(-_JOINT_M, join_style="mitre")
    found = []
    for part in getattr(joined, "geoms", [joined]):
        outline = shapely.Polygon(part.exterior) if not part.is_empty else shapely.Polygon()
        outline = outline.simplify(_SIMPLIFIED_M)
        # A strip is no room however long it is.
        if outline.area >= LEAST_FLOOR_M2 and not outline.buffer(-0.3).is_empty:
            found.append(shapely.orient_polygons(outline))
    return tuple(sorted(found, key=lambda one: -one.area))


def _squares(triangles: FloatArray) -> NDArray[np.object_]:
    """Squares of `_SQUARE_M` around the middles of finely cut floors."""
    cells = np.unique(np.floor(triangles.mean(axis=1) / _SQUARE_M).astype(np.int64), axis=0)
    low = cells * _SQUARE_M
    return np.asarray(shapely.box(*low.T, *(low + _SQUARE_M).T))


def _ceiling(caster: RayCaster, outlines: tuple[shapely.Polygon, ...], y: float) -> float | None:
    """Median height above points on the floor; none if most of them see the sky."""
    outline = outlines[0]
    low, high = np.array(outline.bounds[:2]), np.array(outline.bounds[2:])
    side = int(np.sqrt(_SAMPLES))
    grid = (np.stack(np.meshgrid(np.arange(side), np.arange(side)), -1).reshape(-1, 2) + 0.5) / side
    points = low + grid * (high - low)
    inside = shapely.contains_xy(outline, points[:, 0], points[:, 1])
    if not inside.any():
        return None
    origins = np.column_stack(
        [points[inside, 0], np.full(inside.sum(), y + 1.8), points[inside, 1]]
    )
    ways = caster.distance(origins, np.array([0.0, 1.0, 0.0]))
    if np.isfinite(ways).mean() < 0.5:
        return None
    return float(y + 1.8 + np.median(ways[np.isfinite(ways)]))
