"""Large triangles cut small enough to carry light at their corners."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.rays import Array32
from affectsim_data.scenes import Surface

__all__ = ["longest_edge", "subdivided"]

_FREE_TRIANGLES = 40_000
"""Even a scene of few triangles may grow by so many."""
_STEP = 2.0**0.5
_PASSES = 16


def longest_edge(surfaces: Sequence[Surface], wanted_m: float) -> float:
    """Length to which edges can be cut, metres: `wanted_m`, or more where all surfaces together
    would otherwise more than double their triangles (small scenes may grow by 40,000)."""
    large = [surface for surface in surfaces if _extent(surface) > wanted_m]
    sides = [_sides(surface.positions, surface.faces) for surface in large]
    budget = max(_FREE_TRIANGLES, sum(len(surface.faces) for surface in surfaces))
    limit = wanted_m
    while sum(_growth(lengths, limit) for lengths in sides) > budget:
        limit *= _STEP
    return limit


def _sides(positions: Array32, faces: NDArray[np.integer[Any]]) -> Array32:
    """Lengths of each triangle's sides, `(num_faces, 3)`; side k starts at corner k."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    return np.stack([_length(b - a), _length(c - b), _length(a - c)], axis=1)


def _extent(surface: Surface) -> float:
    """No edge of the surface is longer than this, metres."""
    if not len(surface.positions):
        return 0.0
    return float(np.linalg.norm(surface.positions.max(axis=0) - surface.positions.min(axis=0)))


def _length(way: Array32) -> Array32:
    squared: Array32 = np.einsum("ij,ij->i", way, way)
    return np.sqrt(squared)


def _growth(sides: Array32, limit: float) -> float:
    """About how many triangles cutting adds, rather too many."""
    longest = np.maximum(np.maximum(sides[:, 0], sides[:, 1]), sides[:, 2])
    long = sides[longest > limit].astype(np.float64)
    if not len(long):
        return 0.0
    half = long.sum(axis=1) / 2.0
    area = np.sqrt(np.maximum(half * np.prod(half[:, None] - long, axis=1), 0.0))
    longest = long.max(axis=1)
    rows, columns = (
        2.0 ** np.ceil(np.log2(np.maximum(size / limit, 1.0)))
        for size in (2.0 * area / longest, longest)
    )
    return float((2.0 * rows * columns - 1.0).sum())


def subdivided(surface: Surface, limit_m: float) -> Surface:
    """The surface with every edge longer than `limit_m` halved until none is left.

    An edge is cut because of its own length alone, so neighbours stay joined.
    """
    if _extent(surface) <= limit_m:
        return surface
    parts = _Corners.of(surface)
    faces = surface.faces.astype(np.int64)
    for _ in range(_PASSES):
        long = _sides(parts.positions, faces) > limit_m
        if not long.any():
            break
        parts, faces = _cut(parts, faces, long)
    if len(faces) == len(surface.faces):
        return surface
    return dataclasses.replace(
        surface,
        positions=parts.positions,
        normals=parts.normals,
        colors=np.round(parts.colors).astype(np.uint8),
        uvs=parts.uvs,
        faces=faces.astype(np.uint32),
    )


@dataclasses.dataclass(frozen=True)
class _Corners:
    """What a surface has at its vertices, all `(num_vertices, ...)`, single precision."""

    positions: Array32
    normals: Array32
    colors: Array32
    uvs: Array32 | None

    @classmethod
    def of(cls, surface: Surface) -> _Corners:
        colors = surface.colors.astype(np.float32)
        return cls(surface.positions, surface.normals, colors, surface.uvs)

    def with_middles(self, a: NDArray[np.int64], b: NDArray[np.int64]) -> _Corners:
        """These, and vertices halfway between some `(n,)` and others `(n,)`."""

        def longer(values: Array32) -> Array32:
            return np.concatenate([values, (values[a] + values[b]) * np.float32(0.5)])

        normals = longer(self.normals)
        length = np.maximum(_length(normals), np.float32(1e-9))[:, None]
        uvs = None if self.uvs is None else longer(self.uvs)
        unit = (normals / length).astype(np.float32)
        return _Corners(longer(self.positions), unit, longer(self.colors), uvs)


def _cut(
    corners: _Corners, faces: NDArray[np.int64], long: NDArray[np.bool_]
) -> tuple[_Corners, NDArray[np.int64]]:
    """Halves the long sides, `(num_faces, 3)`: one to four triangles out of each."""
    count = len(corners.positions)
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1)
    low, high = ends.min(axis=-1), ends.max(axis=-1)
    keys, places = np.unique((low * count + high)[long], return_inverse=True)
    middle = np.full(faces.shape, -1, np.int64)
    middle[long] = count + places.reshape(-1)
    cuts = long.sum(axis=1)
    pieces = [faces[cuts == 0]]
    # Turned so that with one cut it is side 0, and with two that side 2 is whole.
    turn = np.where(cuts == 1, long.argmax(axis=1), (long.argmin(axis=1) + 1) % 3)
    order = (turn[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, order, axis=1).T
    ab, bc, ca = np.take_along_axis(middle, order, axis=1).T
    for number, triangles in (
        (1, ((a, ab, c), (ab, b, c))),
        (2, ((ab, b, bc), (a, ab, bc), (a, bc, c))),
        (3, ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))),
    ):
        chosen = cuts == number
        pieces += [np.stack(triangle, axis=1)[chosen] for triangle in triangles]
    return corners.with_middles(keys // count, keys % count), np.concatenate(pieces)
