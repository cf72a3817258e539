"""Cells to polygons: outlines along cell borders, simplified as Recast does."""

from __future__ import annotations

import numpy as np
import shapely

from affectsim_data.navmesh.rasterize import BoolArray, IntArray
from affectsim_data.poses import FloatArray

__all__ = ["cell_outlines", "simplify_rings"]

# Where two cells meet at a corner only, the outline is drawn back into its cell; cells.
PINCH_CELLS = 0.02
# Directions of border edges, counter-clockwise: +x, +z, -x, -z.
STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


def cell_outlines(mask: BoolArray) -> list[FloatArray]:
    """Borders of 4-connected cells, the outer one first.

    Args:
        mask: Which cells belong, `(depth, width)`, indexed `[z, x]`.

    Returns:
        Rings of corners `(x, z)` in cells, `(n, 2)` each, not closed, with the cells on their
        left: the outer ring runs counter-clockwise, holes clockwise.
    """
    padded = np.pad(mask, 1)
    width = padded.shape[1]
    starts, directions = [], []
    # The neighbour across each side of a cell, and the corner where that side starts.
    for side, (across, corner) in enumerate(
        [((-1, 0), (0, 0)), ((0, 1), (0, 1)), ((1, 0), (1, 1)), ((0, -1), (1, 0))]
    ):
        z, x = np.nonzero(padded & ~np.roll(padded, (-across[0], -across[1]), (0, 1)))
        starts.append((z + corner[0]) * width + x + corner[1])
        directions.append(np.full(len(z), side))
    start, direction = np.concatenate(starts), np.concatenate(directions)
    end = start + STEPS[direction, 1] * width + STEPS[direction, 0]
    leaving = np.full((4, padded.size + width + 2), -1)
    leaving[direction, start] = np.arange(len(start))
    # Turning left first keeps cells apart that touch at a corner only.
    options = [leaving[(direction + turn) % 4, end] for turn in (1, 0, 3)]
    following = np.where(options[0] >= 0, options[0], np.maximum(options[1], options[2]))
    pinched = (options[0] >= 0) & (options[2] >= 0)
    z, x = np.divmod(end, width)
    corners = np.stack([x, z], axis=1) - 1.0
    inward = STEPS[(direction + 1) % 4] - STEPS[direction]
    corners = corners + PINCH_CELLS * inward * pinched[:, None]
    turns = direction[following] != direction
    rings = [corners[loop][turns[loop]] for loop in _loops(following)]
    rings.sort(key=lambda ring: -_signed_area(ring))
    return rings


def simplify_rings(rings: list[FloatArray], *, tolerance: float) -> list[FloatArray]:
    """Rings with fewer corners that neither cross nor leave the original by `tolerance`.

    Douglas-Peucker for all rings at once; where simplified rings cross, as in passages narrower
    than the tolerance, corners are put back until they do not.

    Args:
        rings: As from `cell_outlines`, any unit.
        tolerance: Largest distance of a dropped corner to the simplified ring, same unit.
    """
    turned = [_from_lowest_corner(ring) for ring in rings]
    points = np.concatenate([np.concatenate([ring, ring[:1]]) for ring in turned])
    sizes = np.array([len(ring) + 1 for ring in turned])
    first = np.cumsum(sizes) - sizes
    kept = np.zeros(len(points), bool)
    kept[first] = kept[first + sizes - 1] = True
    # Recast starts from the lower left and the upper right corner.
    kept[first + [int(np.lexsort((ring[:, 1], ring[:, 0]))[-1]) for ring in turned]] = True
    while True:
        split = _farthest(points, kept, tolerance)
        if not len(split):
            split = _put_back(points, kept, first, sizes)
        if not len(split):
            break
        kept[split] = True
    ends = first + sizes - 1
    return [points[a:b][kept[a:b]] for a, b in zip(first, ends, strict=True)]


def _loops(following: IntArray) -> list[list[int]]:
    """Cycles of a permutation."""
    successor = following.tolist()
    seen = bytearray(len(successor))
    loops = []
    for start in range(len(successor)):
        loop = []
        while not seen[start]:
            seen[start] = 1
            loop.append(start)
            start = successor[start]
        if loop:
            loops.append(loop)
    return loops


def _signed_area(ring: FloatArray) -> float:
    x, z = ring[:, 0], ring[:, 1]
    return float(np.sum(x * np.roll(z, -1) - np.roll(x, -1) * z)) / 2.0


def _from_lowest_corner(ring: FloatArray) -> FloatArray:
    return np.roll(ring, -int(np.lexsort((ring[:, 1], ring[:, 0]))[0]), axis=0)


def _deviations(points: FloatArray, kept: BoolArray) -> tuple[IntArray, FloatArray]:
    """Segment of kept points each point belongs to, and its distance to that segment."""
    index = np.flatnonzero(kept)
    segment = np.minimum(np.cumsum(kept) - 1, len(index) - 2)
    a, b = points[index[segment]], points[index[segment + 1]]
    along = b - a
    length2 = np.maximum(np.sum(along * along, axis=1), 1e-300)
    share = np.clip(np.sum((points - a) * along, axis=1) / length2, 0.0, 1.0)
    deviation = np.linalg.norm(points - a - share[:, None] * along, axis=1)
    deviation[kept] = 0.0
    return segment, deviation


def _farthest(points: FloatArray, kept: BoolArray, tolerance: float) -> IntArray:
    """The farthest dropped point of every segment that deviates by more than `tolerance`."""
    segment, deviation = _deviations(points, kept)
    far = np.flatnonzero(deviation > tolerance)
    far = far[np.lexsort((-deviation[far], segment[far]))]
    _, first = np.unique(segment[far], return_index=True)
    return far[first]


def _put_back(points: FloatArray, kept: BoolArray, first: IntArray, sizes: IntArray) -> IntArray:
    """Dropped corners on segments that cross another one, or of rings without an area."""
    index = np.flatnonzero(kept)
    ring = np.searchsorted(first, index, side="right") - 1
    real = np.flatnonzero(ring[1:] == ring[:-1])
    lines = shapely.linestrings(np.stack([points[index[real]], points[index[real + 1]]], axis=1))
    one, two = shapely.STRtree(lines).query(lines, predicate="intersects")
    count = np.bincount(ring[real], minlength=len(first))
    size = count[ring[real[one]]]
    same = ring[real[one]] == ring[real[two]]
    apart = np.abs(one - two)
    neighbours = same & ((apart <= 1) | (apart == size - 1))
    bad = np.zeros(len(index), bool)
    bad[real[one[~neighbours]]] = True
    bad[real[count[ring[real]] < 3]] = True
    segment, deviation = _deviations(points, kept)
    dropped = np.flatnonzero(~kept & bad[segment])
    dropped = dropped[np.lexsort((-deviation[dropped], segment[dropped]))]
    _, farthest = np.unique(segment[dropped], return_index=True)
    return dropped[farthest]
