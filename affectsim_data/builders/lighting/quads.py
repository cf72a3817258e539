"""Diagonals of quads: turned to where light interpolates better."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.rays import Array32

__all__ = ["turned_diagonals"]

_EXACT_M = 1e-4
"""How far a quad may be off a parallelogram, in metres and in texture coordinates."""
_LEAST_CUT_M = 0.04
"""Shorter diagonals are not worth a look."""


def turned_diagonals(
    positions: Array32, faces: NDArray[np.int32], values: Array32, uvs: Array32 | None = None
) -> NDArray[np.int32]:
    """The faces `(m, 3)` with each parallelogram cut where its corners' values differ least.

    Values of vertices are interpolated along the cut, so it should join the two that are alike.

    Args:
        positions: Metres, `(n, 3)`.
        faces: Triangles, `(m, 3)`.
        values: Brightness of vertices, `(n,)`.
        uvs: Texture coordinates, which must stay as they are, `(n, 2)`.
    """
    first, second, a, b, c, d = _quads(positions, faces)
    better = np.abs(values[b] - values[d]) < np.abs(values[a] - values[c]) - 1e-3
    old, new = positions[c] - positions[a], positions[d] - positions[b]
    # Of a slanted quad the short diagonal stays: long thin triangles light worse.
    better &= np.einsum("ij,ij->i", new, new) < 1.1 * np.einsum("ij,ij->i", old, old)
    for field in (positions, uvs):
        if field is not None:
            bend = np.abs(field[a] + field[c] - field[b] - field[d])
            better &= bend.max(axis=1) < _EXACT_M
    turned = faces.copy()
    turned[first[better]] = np.stack([a, b, d], axis=1)[better]
    turned[second[better]] = np.stack([b, c, d], axis=1)[better]
    return turned


def _quads(positions: Array32, faces: NDArray[np.int32]) -> tuple[NDArray[np.int32], ...]:
    """Pairs of triangles for both of which the same edge is the longest: the two faces, and
    corners such that they are `(a, b, c)` and `(a, c, d)`, `(num_quads,)` each."""
    corners = positions[faces]
    sides = np.roll(corners, -1, axis=1) - corners
    squared = np.einsum("fkc,fkc->fk", sides, sides)
    longest = np.argmax(squared, axis=1)
    row = np.flatnonzero(squared.max(axis=1) > _LEAST_CUT_M**2)
    c, a, b = (faces[row, (longest[row] + k) % 3] for k in range(3))
    edge = np.minimum(a, c).astype(np.int64) * len(positions) + np.maximum(a, c)
    order = np.argsort(edge, kind="stable")
    new = np.diff(edge[order], prepend=-1, append=-1) != 0
    starts = np.flatnonzero(new[:-1])
    starts = starts[np.diff(np.append(starts, len(order))) == 2]
    first, second = order[starts], order[starts + 1]
    # A quad is wound one way: along the cut its triangles run in opposite directions.
    sound = (a[first] == c[second]) & (c[first] == a[second])
    first, second = first[sound], second[sound]
    return row[first], row[second], a[first], b[first], c[first], b[second]
