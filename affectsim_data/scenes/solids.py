"""Which triangles belong to closed solids: their back faces need no drawing from outside.

Scenes are drawn two-sided, because walls may be single sheets and rays hit either side. The back of
a closed solid is always behind its front, though, and finely divided furniture is half backs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray

__all__ = ["closed_solids", "weld_places"]

WELD_M = 1e-4
"""Corners this close are one: flat shading repeats them with other normals."""
_REACH = 2**20


def closed_solids(
    positions: FloatArray, faces: NDArray[np.int64]
) -> tuple[NDArray[np.bool_], FloatArray]:
    """Which faces are part of a closed solid that faces outwards, and the box around it.

    Args:
        positions: Vertices, metres, `(num_vertices, 3)`.
        faces: Triangles, `(num_faces, 3)`.

    Returns:
        A mask `(num_faces,)`, and for every face the low and high corner of what it is connected
        to, `(num_faces, 2, 3)`.
    """
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components

    welded = weld_places(positions)
    corners = welded[faces]
    count = int(welded.max()) + 1
    ends = np.roll(corners, -1, axis=1)
    links = coo_matrix((np.ones(corners.size, bool), (corners.ravel(), ends.ravel())), (count,) * 2)
    num_solids, labels = connected_components(links, directed=False)
    solid = labels[corners[:, 0]]
    # Closed: every edge is gone along once in either direction.
    forward = corners < ends
    edges = np.where(forward, corners * count + ends, ends * count + corners).reshape(-1)
    _, edge, uses = np.unique(edges, return_inverse=True, return_counts=True)
    turns = np.bincount(edge, weights=np.where(forward, 1.0, -1.0).reshape(-1))
    paired = (uses == 2) & (turns == 0.0)
    matched = paired[edge].reshape(corners.shape) & (corners != ends)
    open_faces = np.bincount(solid, weights=~matched.all(axis=1), minlength=num_solids)
    a, b, c = (positions[faces[:, i]] for i in range(3))
    volumes = np.bincount(
        solid, weights=np.einsum("ij,ij->i", a, np.cross(b, c)), minlength=num_solids
    )
    closed = (open_faces == 0) & (volumes > 0.0)
    return closed[solid], _boxes(positions, labels[welded], num_solids)[solid]


def weld_places(positions: FloatArray) -> NDArray[np.int64]:
    """One number per place, `(num_vertices,)`."""
    cells = np.round(positions / WELD_M).astype(np.int64)
    if len(cells) and np.abs(cells).max() >= _REACH:
        # More than 100 m out: too far to pack three coordinates into 63 bits.
        return np.arange(len(cells))
    packed = ((cells[:, 0] + _REACH) * 2 * _REACH + cells[:, 1] + _REACH) * 2 * _REACH
    _, numbers = np.unique(packed + cells[:, 2] + _REACH, return_inverse=True)
    return np.asarray(numbers.reshape(-1), np.int64)


def _boxes(positions: FloatArray, labels: NDArray[np.int64], count: int) -> FloatArray:
    boxes = np.empty((count, 2, 3))
    boxes[:, 0], boxes[:, 1] = np.inf, -np.inf
    order = np.argsort(labels, kind="stable")
    starts = np.flatnonzero(np.diff(labels[order], prepend=-1))
    present = labels[order][starts]
    boxes[present, 0] = np.minimum.reduceat(positions[order], starts)
    boxes[present, 1] = np.maximum.reduceat(positions[order], starts)
    return boxes
