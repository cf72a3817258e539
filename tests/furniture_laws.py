"""Laws of furniture in its places: what may share room with what. For tests."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import shapely

from affectsim_data.builders.homes.parts import Part, merged
from affectsim_data.builders.homes.placed import Placed
from affectsim_data.poses import FloatArray
from affectsim_data.visibility import RayCaster

__all__ = ["bounds_of", "crossing_meshes", "mesh_of", "outline_of", "overlapping_boxes"]

_MAY_OVERLAP = ({"chair", "table"}, {"stool", "counter"})


def mesh_of(parts: Sequence[Part]) -> tuple[FloatArray, np.ndarray]:
    """Vertices and triangles of parts as one mesh."""
    whole = merged(parts)
    return whole.positions, whole.faces


def bounds_of(placed: Placed) -> FloatArray:
    """Least and greatest corner of its mesh in the world, `(2, 3)`."""
    parts = placed.parts()
    return np.array(
        [
            np.min([part.positions.min(axis=0) for part in parts], axis=0),
            np.max([part.positions.max(axis=0) for part in parts], axis=0),
        ]
    )


def outline_of(placed: Placed, *, shrink: float = 0.0) -> shapely.Polygon:
    """Its oriented box on the plan."""
    w, d = placed.piece.width / 2.0 - shrink, placed.piece.depth / 2.0 - shrink
    return shapely.Polygon([placed.world(x, z) for x, z in ((-w, -d), (w, -d), (w, d), (-w, d))])


def overlapping_boxes(placed: Sequence[Placed]) -> list[tuple[str, str]]:
    """Pairs whose boxes overlap by more than a centimetre, by category.

    Chairs go under tables, stools under islands, rugs under anything, and things stand on things.
    """
    boxes = [(outline_of(p, shrink=0.005), bounds_of(p)) for p in placed]
    wrong = []
    for (p, (outline, bounds)), (q, (other, others)) in itertools.combinations(
        zip(placed, boxes, strict=True), 2
    ):
        pair = {p.piece.category, q.piece.category}
        apart = bounds[0, 1] > others[1, 1] - 2e-3 or others[0, 1] > bounds[1, 1] - 2e-3
        if apart or pair in _MAY_OVERLAP or "rug" in pair or "piece" in (p.support, q.support):
            continue
        if outline.intersection(other).area >= 1e-6:
            wrong.append((p.piece.category, q.piece.category))
    return wrong


def crossing_meshes(placed: Sequence[Placed]) -> list[tuple[str, str]]:
    """Pairs of which an edge of one goes through a face of the other, by category."""
    bounds = [bounds_of(p) for p in placed]
    return [
        (p.piece.category, q.piece.category)
        for (p, box), (q, other) in itertools.combinations(zip(placed, bounds, strict=True), 2)
        if not ((box[0] > other[1] - 2e-3).any() or (other[0] > box[1] - 2e-3).any())
        and (_crosses(p, q, box, other) or _crosses(q, p, box, other))
    ]


def _crosses(one: Placed, two: Placed, box: FloatArray, other: FloatArray) -> bool:
    positions, faces = mesh_of(one.parts())
    ends = positions[faces[:, [0, 1, 1, 2, 2, 0]]].reshape(-1, 2, 3)
    near = np.minimum(box[1], other[1]) + 0.01, np.maximum(box[0], other[0]) - 0.01
    inside = (ends.min(axis=1) <= near[0]).all(axis=1) & (ends.max(axis=1) >= near[1]).all(axis=1)
    ends = ends[inside]
    if len(ends) == 0:
        return False
    # Feet stand on their ground exactly: they are lifted off it a little.
    lift = np.array([0.0, 1.5e-3 if one.y > two.y else -1.5e-3, 0.0])
    caster = RayCaster(*mesh_of(two.parts()))
    return bool(caster.hidden(ends[:, 0] + lift, ends[:, 1] + lift).any())
