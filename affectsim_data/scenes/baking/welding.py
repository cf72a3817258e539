"""Vertices on a grid, near-duplicates as one, and triangles that draw nothing left out."""

from __future__ import annotations

import dataclasses
import math
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.chunks import first_use
from affectsim_data.scenes.surfaces import Surface

__all__ = ["GRID_PER_M", "REACH_M", "weld_surface"]

GRID_PER_M = 8192
"""Positions are whole numbers of 2^-13 m, 0.12 mm: exact as float32, and equal where they meet."""
REACH_M = 1000
"""From the origin: further out float32 has no such grid."""
_NORMAL_GRID = 256
"""Normals of this grid are within 0.3 % of unit length, as validators of glTF ask."""
_NORMAL_CELLS = 8
"""Vertices whose normals differ by less than a cell, about 7 degrees, may be one."""
_TEXEL_PARTS = 16
_MAX_REPEATS = 2**15

_IntArray = NDArray[np.int64]


def weld_surface(surface: Surface) -> tuple[Surface, Counter[str]]:
    """The surface with its vertices on grids, welded, and how much was dropped.

    Vertices are one if they are in the same place, look the same (colours within two levels,
    texture coordinates within 1/16 texel) and face about the same way. Triangles keep their order,
    and welding twice changes nothing.

    Raises:
        ValueError: A vertex is too far out, or texture coordinates are too large.
    """
    positions, normals, uvs = _on_grids(surface)
    place, look, vertex, first = _same(positions, normals, surface.colors, uvs)
    faces = surface.faces.astype(np.int64)
    kept, dropped = _drawn(positions, faces, place, look)
    # By first use: neighbours in memory are neighbours on the surface, which also packs better.
    used, corners = first_use(vertex[faces[kept]])
    chosen = first[used]
    welded = dataclasses.replace(
        surface,
        positions=positions[chosen],
        normals=normals[chosen],
        colors=surface.colors[chosen],
        uvs=None if uvs is None else uvs[chosen],
        faces=corners.astype(np.uint32),
    )
    return welded, dropped


def _on_grids(
    surface: Surface,
) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.float32] | None]:
    """Positions, unit normals and texture coordinates, rounded to their grids."""
    reach = float(np.abs(surface.positions).max(initial=0.0))
    if reach > REACH_M:
        raise ValueError(
            f"surface {surface.name!r}: a vertex is {reach:.4g} m from the origin, at most "
            f"{REACH_M} m are possible; is the scene in metres and near the origin?"
        )
    grid = np.float32(GRID_PER_M)
    # Adding zero turns -0 into 0: equal values have equal bytes.
    positions = np.rint(surface.positions.astype(np.float32) * grid) / grid + np.float32(0.0)
    steps = np.float32(_NORMAL_GRID)
    normals = np.rint(_unit(surface) * steps) / steps + np.float32(0.0)
    if surface.uvs is None or surface.texture is None:
        return positions, normals, None
    repeats = float(np.abs(surface.uvs).max(initial=0.0))
    if repeats > _MAX_REPEATS:
        raise ValueError(
            f"surface {surface.name!r}: texture coordinates reach {repeats:.4g}, "
            f"at most {_MAX_REPEATS} are possible"
        )
    # A power of two, so that rounding twice changes nothing.
    parts = 2.0 ** math.ceil(math.log2(_TEXEL_PARTS * max(surface.texture.shape[:2])))
    uvs = np.rint(surface.uvs.astype(np.float64) * parts) / parts + 0.0
    return positions, normals, uvs.astype(np.float32)


def _unit(surface: Surface) -> NDArray[np.float32]:
    """Normals of length one; where there is none, that of a triangle, or straight up."""
    normals = surface.normals.astype(np.float32)
    length = np.linalg.norm(normals, axis=1)
    lost = np.flatnonzero(length < 0.5)
    if len(lost):
        a, b, c = (surface.positions[surface.faces[:, i]].astype(np.float64) for i in range(3))
        across = np.cross(b - a, c - a)
        sums = np.zeros((len(normals), 3))
        for corner in range(3):
            np.add.at(sums, surface.faces[:, corner], across)
        size = np.linalg.norm(sums[lost], axis=1, keepdims=True)
        straight = np.where(size > 0.0, sums[lost] / np.maximum(size, 1e-300), (0.0, 1.0, 0.0))
        normals[lost], length[lost] = straight, 1.0
    # What is on the grid already stays as it is, though its length is not quite one.
    rounded = np.rint(normals * _NORMAL_GRID) == normals * _NORMAL_GRID
    off = ~(rounded.all(axis=1) & (np.abs(length - 1.0) < 1.0 / _NORMAL_GRID))
    normals[off] /= length[off, None]
    return normals


def _same(
    positions: NDArray[np.float32],
    normals: NDArray[np.float32],
    colors: NDArray[np.uint8],
    uvs: NDArray[np.float32] | None,
) -> tuple[_IntArray, _IntArray, _IntArray, _IntArray]:
    """Per vertex a number of its place, of its looks and of itself, and one vertex per number."""
    cells = np.rint(positions.astype(np.float64) * GRID_PER_M).astype(np.int64)
    shade = (colors[:, :3] >> 1).astype(np.int64)
    keys = [(cells[:, 0] << 32) + cells[:, 1]]
    keys.append((cells[:, 2] << 21) + (shade[:, 0] << 14) + (shade[:, 1] << 7) + shade[:, 2])
    if uvs is not None:
        # The bits of equal numbers are equal; their order does not matter.
        keys.append(np.ascontiguousarray(uvs).view(np.int64).reshape(-1))
    facing = np.rint(normals * _NORMAL_CELLS).astype(np.int64) + _NORMAL_CELLS
    keys.append((facing[:, 0] << 10) + (facing[:, 1] << 5) + facing[:, 2])
    order = np.lexsort(keys[::-1])
    changed = [np.append(True, np.diff(key[order]) != 0) for key in keys]
    depth = np.append(True, np.diff(cells[order, 2]) != 0)
    starts = (
        changed[0] | depth,
        np.logical_or.reduce(changed[:-1]),
        np.logical_or.reduce(changed),
    )
    numbers = []
    for start in starts:
        number = np.empty(len(order), np.int64)
        number[order] = np.cumsum(start) - 1
        numbers.append(number)
    return numbers[0], numbers[1], numbers[2], order[starts[2]]


def _drawn(
    positions: NDArray[np.float32], faces: _IntArray, place: _IntArray, look: _IntArray
) -> tuple[_IntArray, Counter[str]]:
    """Indices of triangles that draw something no other one draws, in order, and the rest."""
    spots = place[faces]
    whole = (spots != np.roll(spots, 1, axis=1)).all(axis=1)
    whole[whole] = _have_area(positions, faces[whole])
    kept = np.flatnonzero(whole)
    looks = np.sort(look[faces[kept]], axis=1)
    order = np.lexsort(looks.T[::-1])
    sorted_looks = looks[order]
    first = np.append(True, (sorted_looks[1:] != sorted_looks[:-1]).any(axis=1))[: len(order)]
    dropped = Counter(
        {
            "triangles without area": len(faces) - len(kept),
            "triangles drawn twice": len(kept) - int(first.sum()),
        }
    )
    return np.sort(kept[order[first]]), dropped


def _have_area(positions: NDArray[np.float32], faces: _IntArray) -> NDArray[np.bool_]:
    """Exact: on the grid these are products of whole numbers below 2^53."""
    a, b, c = (np.rint(positions[faces[:, i]].astype(np.float64) * GRID_PER_M) for i in range(3))
    across: FloatArray = np.cross(b - a, c - a)
    return np.asarray((across != 0.0).any(axis=1))
