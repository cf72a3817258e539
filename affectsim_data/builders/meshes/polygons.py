"""Faces of any number of corners to triangles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.poses import FloatArray

__all__ = ["triangulated"]

IntArray = NDArray[np.int64]


def triangulated(
    vertex: IntArray, sizes: IntArray, positions: FloatArray, *, notes: Notes
) -> tuple[IntArray, IntArray]:
    """Cuts every face into fans of triangles, from the corner where no triangle turns over.

    Args:
        vertex: Vertex of every corner, face after face, `(num_corners,)`.
        sizes: Corners of every face, `(num_faces,)`.
        positions: Vertices, `(num_vertices, 3 or more)`.
        notes: Counts faces no such corner was found for.

    Returns:
        Corner numbers `(num_triangles, 3)` and the face each is from `(num_triangles,)`, in order.
    """
    starts = np.cumsum(sizes) - sizes
    corners, faces = [np.zeros((0, 3), np.int64)], [np.zeros(0, np.int64)]
    for size in np.unique(sizes):
        chosen = np.flatnonzero(sizes == size)
        if size < 3:
            notes["faces of fewer than three corners dropped"] += len(chosen)
            continue
        loops = starts[chosen, None] + np.arange(size)
        if size > 3:
            loops = _turned(loops, vertex, positions, notes)
        fans = np.stack(
            [np.repeat(loops[:, :1], size - 2, axis=1), loops[:, 1:-1], loops[:, 2:]], axis=-1
        )
        corners.append(fans.reshape(-1, 3))
        faces.append(np.repeat(chosen, size - 2))
    face = np.concatenate(faces)
    order = np.argsort(face, kind="stable")
    return np.concatenate(corners)[order], face[order]


def _turned(loops: IntArray, vertex: IntArray, positions: FloatArray, notes: Notes) -> IntArray:
    """The loops `(num_faces, size)`, each begun at a corner whose fan covers it, if any."""
    turned = loops.copy()
    open_, size = np.arange(len(loops)), loops.shape[1]
    for first in range(size):
        if not len(open_):
            break
        begun = np.roll(loops[open_], -first, axis=1)
        points = positions[vertex[begun], :3]
        spokes = points[:, 1:] - points[:, :1]
        across = np.cross(spokes[:, :-1], spokes[:, 1:])
        whole = across.sum(axis=1, keepdims=True)
        with np.errstate(invalid="ignore"):
            covers = (np.einsum("fkc,foc->fk", across, whole) >= 0.0).all(axis=1)
        turned[open_[covers]] = begun[covers]
        open_ = open_[~covers]
    if len(open_):
        notes["faces that no fan of triangles covers cut all the same"] += len(open_)
    return turned
