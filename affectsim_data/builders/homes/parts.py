"""Mesh primitives of furniture and walls: boxes with round edges, turned shapes, flat sheets.

Every shape has texture coordinates in metres, so that a texture keeps its scale on all of them.
"""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.poses import FloatArray, quaternion_rotate

__all__ = [
    "IntArray", "Part", "Point", "box", "boxes", "grid_faces", "lathe", "merged", "sheet",
    "smooth_normals",
]  # fmt: skip

IntArray = NDArray[np.int64]
Point = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Part:
    """A mesh of one material before light falls on it."""

    material: str
    """A key of `textures.MATERIALS`."""
    positions: FloatArray
    """Metres, `(num_vertices, 3)`."""
    normals: FloatArray
    """Unit, `(num_vertices, 3)`."""
    uvs: FloatArray
    """Metres along the surface, `(num_vertices, 2)`."""
    colors: FloatArray
    """sRGB in [0, 1] that multiplies the texture, `(num_vertices, 3)`."""
    faces: IntArray
    """Triangles, counter-clockwise from outside, `(num_faces, 3)`."""

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0, *, yaw: float = 0.0) -> Part:
        """Turned by `yaw` radians about +Y, then shifted by metres."""
        shift = np.array([x, y, z])
        if yaw == 0.0:
            return dataclasses.replace(self, positions=self.positions + shift)
        c, s = np.cos(yaw), np.sin(yaw)
        turn = np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])
        return dataclasses.replace(
            self, positions=self.positions @ turn + shift, normals=self.normals @ turn
        )

    def tilted(self, angle: float, *, pivot: Point = (0.0, 0.0, 0.0), axis: int = 0) -> Part:
        """Turned by `angle` radians about an axis through `pivot`; about +X, +Y leans to +Z."""
        turn = np.zeros(4)
        turn[0], turn[1 + axis] = np.cos(angle / 2.0), np.sin(angle / 2.0)
        return dataclasses.replace(
            self,
            positions=quaternion_rotate(turn, self.positions - pivot) + pivot,
            normals=quaternion_rotate(turn, self.normals),
        )

    def stretched(self, x: float = 1.0, y: float = 1.0, z: float = 1.0) -> Part:
        """Scaled about the origin by positive factors."""
        factor = np.array([x, y, z])
        normals = self.normals / factor
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        return dataclasses.replace(self, positions=self.positions * factor, normals=normals)


def merged(parts: Iterable[Part]) -> Part:
    """One part out of several of the same material."""
    group = list(parts)
    starts = np.cumsum([0, *(len(part.positions) for part in group[:-1])])
    return Part(
        material=group[0].material,
        positions=np.concatenate([part.positions for part in group]),
        normals=np.concatenate([part.normals for part in group]),
        uvs=np.concatenate([part.uvs for part in group]),
        colors=np.concatenate([part.colors for part in group]),
        faces=np.concatenate([part.faces + k for part, k in zip(group, starts, strict=True)]),
    )


def _part(
    material: str, color: ArrayLike, positions: FloatArray, normals: FloatArray,
    uvs: FloatArray, faces: IntArray,
) -> Part:  # fmt: skip
    colors = np.broadcast_to(np.asarray(color, np.float64), positions.shape).copy()
    return Part(material, positions, normals, uvs, colors, faces)


def grid_faces(rows: int, columns: int) -> IntArray:
    """Triangles of a grid of `rows * columns` vertices, row by row, `(2 (rows-1)(columns-1), 3)`.

    Counter-clockwise where columns run along u, rows along v and the normal is u x v.
    """
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    quads = np.stack([a, b, c, a, c, d], axis=-1)
    return quads.reshape(-1, 3)


def smooth_normals(positions: FloatArray, faces: IntArray) -> FloatArray:
    """Area-weighted vertex normals, shared by vertices at the same place, `(num_vertices, 3)`."""
    cells = np.round((positions - positions.mean(axis=0)) * 1e5).astype(np.int64) + (1 << 20)
    _, same = np.unique((cells @ (1 << 42, 1 << 21, 1)), return_inverse=True)
    same = same.reshape(-1)
    a, b, c = (positions[faces[:, k]] for k in range(3))
    face_normals = np.cross(b - a, c - a)
    corners, count = same[faces].T.ravel(), int(same.max()) + 1
    tiled = np.tile(face_normals, (3, 1))
    sums = np.stack([np.bincount(corners, tiled[:, k], count) for k in range(3)], axis=1)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    unit: FloatArray = (sums / np.maximum(length, 1e-12))[same]
    return unit


ROUND_FROM_M = 0.008
"""Rounder edges are modelled; finer ones are below a pixel of 224 from 2 m, and cost nine times
the triangles of a sharp box."""


def _lines(half: float, radius: float, segments: int, step: float) -> FloatArray:
    """Grid lines across one side of a box: its round edges and its flat middle."""
    flat = half - radius if radius > 0.0 else half
    count = max(int(np.ceil(2.0 * flat / step)), 1)
    middle = flat * (2.0 * np.arange(count + 1) / count - 1.0)
    if radius <= 0.0:
        return np.asarray(middle)
    bend = half - radius + radius * np.tan(0.25 * np.pi * np.arange(1, segments + 1) / segments)
    return np.concatenate([-bend[::-1], middle, bend])


def box(
    size: Point, center: Point, *, color: ArrayLike, material: str = "plain",
    radius: float = 0.004, segments: int = 1, step: float = 0.45, sides: str = "xXyYzZ",
) -> Part:  # fmt: skip
    """A box with round edges of `radius` metres; sharp ones below `ROUND_FROM_M`.

    Args:
        size: Extents, metres.
        center: Its middle, metres.
        color: sRGB in [0, 1].
        material: Key of `textures.MATERIALS`.
        radius: Of the edges.
        segments: Quads across half an edge.
        step: Longest quad of the flat faces: light is stored per vertex.
        sides: Faces to build, lower case towards minus; leave out what stands against something.
    """
    if radius < ROUND_FROM_M and max(size) <= step:
        return boxes([size], [center], colors=color, material=material, sides=sides)
    mesh = _box_mesh(tuple(map(float, size)), radius, segments, step, sides)
    return _part(material, color, mesh[0] + center, *mesh[1:])


@functools.lru_cache(maxsize=256)
def _box_mesh(
    size: Point, radius: float, segments: int, step: float, sides: str
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    """Positions about the middle, normals, uvs and triangles of a box; nobody changes them."""
    half = np.asarray(size) / 2.0
    radius = min(radius, 0.98 * float(half.min())) if radius >= ROUND_FROM_M else 0.0
    pieces = [
        _box_side(half, "xyz".index(side.lower()), 1.0 if side.isupper() else -1.0, radius,
                  segments, step)
        for side in sides
    ]  # fmt: skip
    starts = np.cumsum([0, *(len(piece[0]) for piece in pieces[:-1])])
    return (
        np.concatenate([piece[0] for piece in pieces]),
        np.concatenate([piece[1] for piece in pieces]),
        np.concatenate([piece[2] for piece in pieces]),
        np.concatenate([piece[3] + k for piece, k in zip(pieces, starts, strict=True)]),
    )


def _box_side(
    half: FloatArray, axis: int, sign: float, radius: float, segments: int, step: float
) -> tuple[FloatArray, FloatArray, FloatArray, IntArray]:
    u, v = (axis + 1) % 3, (axis + 2) % 3
    u_lines = _lines(half[u], radius, segments, step)
    v_lines = _lines(half[v], radius, segments, step)
    grid = np.zeros((len(v_lines), len(u_lines), 3))
    grid[..., u], grid[..., v] = u_lines[None, :], v_lines[:, None]
    grid[..., axis] = sign * half[axis]
    points = grid.reshape(-1, 3)
    # A point of the sharp box goes to the nearest point at `radius` from the box's core.
    core = np.clip(points, radius - half, half - radius)
    normals = points - core if radius > 0.0 else np.zeros_like(points)
    if radius <= 0.0:
        normals[:, axis] = sign
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    # The grain of wood, along texture u, follows the longer side.
    along, across = (u, v) if half[u] >= half[v] else (v, u)
    uvs = np.stack([points[:, along] + half[along], half[across] - points[:, across]], axis=1)
    faces = grid_faces(len(v_lines), len(u_lines))
    return core + radius * normals, normals, uvs, faces if sign > 0.0 else faces[:, ::-1]


_CUBE_SIDES = "xXyYzZ"


def _cube() -> tuple[FloatArray, FloatArray, IntArray]:
    """Corners in [-1, 1], normals and triangles of a cube, side by side as in `_CUBE_SIDES`."""
    sides = [
        _box_side(np.ones(3), "xyz".index(side.lower()), 1.0 if side.isupper() else -1.0, 0.0, 1, 9)
        for side in _CUBE_SIDES
    ]
    faces = np.concatenate([side[3] + 4 * k for k, side in enumerate(sides)])
    return np.concatenate([s[0] for s in sides]), np.concatenate([s[1] for s in sides]), faces


def boxes(
    sizes: ArrayLike, centers: ArrayLike, *, colors: ArrayLike, material: str = "plain",
    sides: str = "xXyYzZ",
) -> Part:  # fmt: skip
    """Many sharp boxes at once.

    Args:
        sizes: Extents, metres, `(num_boxes, 3)`.
        centers: Their middles, metres, `(num_boxes, 3)`.
        colors: sRGB in [0, 1], `(num_boxes, 3)` or one for all.
        material: Key of `textures.MATERIALS`.
        sides: Faces to build, as for `box`.
    """
    half = np.asarray(sizes, np.float64).reshape(-1, 1, 3) / 2.0
    corners, normals, faces = _UNIT_CUBE
    if sides != _CUBE_SIDES:
        places = np.array([_CUBE_SIDES.index(side) for side in sides])
        rows = (4 * places[:, None] + np.arange(4)).ravel()
        shift = 4 * (np.arange(len(sides)) - places)
        faces = faces.reshape(6, 2, 3)[places] + shift[:, None, None]
        corners, normals, faces = corners[rows], normals[rows], faces.reshape(-1, 3)
    count, each = len(half), len(corners)
    positions = corners * half + np.asarray(centers, np.float64).reshape(-1, 1, 3)
    # The grain of wood, along texture u, follows the longer side.
    axis = np.abs(normals).argmax(axis=1)
    u, v = (axis + 1) % 3, (axis + 2) % 3
    swap = np.take_along_axis(half, v[None, :, None] * np.ones((count, 1, 1), int), 2) > (
        np.take_along_axis(half, u[None, :, None] * np.ones((count, 1, 1), int), 2)
    )
    along, across = np.where(swap[..., 0], v, u), np.where(swap[..., 0], u, v)
    local, wide = corners * half, np.broadcast_to(half, (count, each, 3))
    uvs = np.stack(
        [
            np.take_along_axis(local + wide, along[..., None], 2)[..., 0],
            np.take_along_axis(wide - local, across[..., None], 2)[..., 0],
        ],
        axis=-1,
    )
    tint = np.broadcast_to(np.asarray(colors, np.float64).reshape(-1, 1, 3), positions.shape)
    shifted = faces[None] + each * np.arange(count)[:, None, None]
    return Part(
        material, positions.reshape(-1, 3),
        np.broadcast_to(normals, positions.shape).reshape(-1, 3).copy(),
        uvs.reshape(-1, 2), tint.reshape(-1, 3).copy(), shifted.reshape(-1, 3),
    )  # fmt: skip


_UNIT_CUBE = _cube()


def lathe(
    profile: Sequence[tuple[float, float]], *, color: ArrayLike, material: str = "plain",
    center: Point = (0.0, 0.0, 0.0), segments: int = 26, smooth: bool = False,
) -> Part:  # fmt: skip
    """A turned shape: the profile of (radius, height) from bottom to top, spun about +Y.

    Args:
        profile: Metres; a radius of 0 closes an end. Rising with the outside on its right.
        color: sRGB in [0, 1].
        material: Key of `textures.MATERIALS`.
        center: Where radius 0, height 0 comes to lie, metres.
        segments: Around.
        smooth: Whether the profile is a curve rather than a row of straight pieces.
    """
    radii, heights = np.asarray(profile, np.float64).T
    if not smooth:
        radii, heights = np.repeat(radii, 2)[1:-1], np.repeat(heights, 2)[1:-1]
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    ring = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    positions = radii[:, None, None] * ring + heights[:, None, None] * np.array([0.0, 1.0, 0.0])
    slope = _profile_normals(radii, heights, smooth=smooth)
    normals = slope[:, :1, None] * ring + slope[:, 1:, None] * np.array([0.0, 1.0, 0.0])
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(radii), np.diff(heights)))])
    u = angle * max(float(radii.max()), 0.05)
    uvs = np.stack(np.broadcast_arrays(u[None, :], -arc[:, None]), axis=-1)
    faces = grid_faces(len(radii), segments + 1)
    positions = positions.reshape(-1, 3)
    a, b, c = (positions[faces[:, k]] for k in range(3))
    real = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-12
    return _part(
        material, color, positions + center, normals.reshape(-1, 3), uvs.reshape(-1, 2), faces[real]
    )


def _profile_normals(radii: FloatArray, heights: FloatArray, *, smooth: bool) -> FloatArray:
    """Outward normals (along radius, along height) of profile points, `(num_points, 2)`."""
    pieces = np.stack([np.diff(heights), -np.diff(radii)], axis=1)
    if smooth:
        sums = np.concatenate([pieces[:1], pieces[:-1] + pieces[1:], pieces[-1:]])
    else:
        sums = np.repeat(pieces[::2], 2, axis=0)
    unit: FloatArray = sums / np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    return unit


def sheet(
    origin: ArrayLike, along_u: ArrayLike, along_v: ArrayLike, u_lines: FloatArray,
    v_lines: FloatArray, *, color: ArrayLike, material: str, keep: NDArray[np.bool_] | None = None,
) -> Part:  # fmt: skip
    """A flat grid seen from u x v.

    Args:
        origin: Where u = v = 0, metres.
        along_u: Unit direction of u.
        along_v: Unit direction of v.
        u_lines: Grid lines, metres, ascending, `(num_u,)`.
        v_lines: The same for v, `(num_v,)`.
        color: sRGB in [0, 1].
        material: Key of `textures.MATERIALS`.
        keep: Cells to build, `(num_v - 1, num_u - 1)`; the others are holes.
    """
    u, v = np.asarray(along_u, np.float64), np.asarray(along_v, np.float64)
    positions = (
        np.asarray(origin, np.float64)
        + u_lines[None, :, None] * u
        + v_lines[:, None, None] * v
    ).reshape(-1, 3)  # fmt: skip
    uvs = np.stack(np.broadcast_arrays(u_lines[None, :], -v_lines[:, None]), axis=-1)
    faces = grid_faces(len(v_lines), len(u_lines))
    if keep is not None:
        faces = faces.reshape(-1, 6)[keep.reshape(-1)].reshape(-1, 3)
    used, faces = np.unique(faces, return_inverse=True)
    normals = np.broadcast_to(np.cross(u, v), positions.shape).copy()
    return _part(
        material, color, positions[used], normals[used], uvs.reshape(-1, 2)[used],
        faces.reshape(-1, 3).astype(np.int64),
    )  # fmt: skip
