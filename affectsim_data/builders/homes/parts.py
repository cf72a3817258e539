"""Mesh primitives of furniture and walls: boxes with round edges, cushions, turned shapes, sheets.

Every shape has texture coordinates in metres, so that a texture keeps its scale on all of them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.poses import FloatArray, quaternion_rotate, yaw_quaternion

__all__ = ["Part", "box", "cushion", "grid_faces", "lathe", "merged", "sheet", "smooth_normals"]

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
        turn = yaw_quaternion(yaw)
        return dataclasses.replace(
            self,
            positions=quaternion_rotate(turn, self.positions) + np.array([x, y, z]),
            normals=quaternion_rotate(turn, self.normals),
        )

    def tilted(self, angle: float, *, pivot: Point = (0.0, 0.0, 0.0)) -> Part:
        """Turned by `angle` radians about the +X axis through `pivot`; positive leans +Y to +Z."""
        turn = np.array([np.cos(angle / 2.0), np.sin(angle / 2.0), 0.0, 0.0])
        return dataclasses.replace(
            self,
            positions=quaternion_rotate(turn, self.positions - pivot) + pivot,
            normals=quaternion_rotate(turn, self.normals),
        )


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
    _, same = np.unique(np.round(positions, 6), axis=0, return_inverse=True)
    same = same.reshape(-1)
    a, b, c = (positions[faces[:, k]] for k in range(3))
    face_normals = np.cross(b - a, c - a)
    sums = np.zeros((int(same.max()) + 1, 3))
    for k in range(3):
        np.add.at(sums, same[faces[:, k]], face_normals)
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    unit: FloatArray = (sums / np.maximum(length, 1e-12))[same]
    return unit


ROUND_FROM_M = 0.008
"""Rounder edges are modelled; finer ones are below a pixel of 224 from 2 m, and cost nine times
the triangles of a sharp box."""


def _lines(half: float, radius: float, segments: int, step: float) -> FloatArray:
    """Grid lines across one side of a box: its round edges and its flat middle."""
    if radius <= 0.0:
        inner = np.array([half])
    else:
        inner = half - radius + radius * np.tan(np.linspace(0.0, np.pi / 4.0, segments + 1))
    count = max(int(np.ceil(2.0 * inner[0] / step)), 1)
    middle = np.linspace(-inner[0], inner[0], count + 1)
    return np.concatenate([-inner[:0:-1], middle, inner[1:]])


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
    half = np.asarray(size, np.float64) / 2.0
    radius = min(radius, 0.98 * float(half.min())) if radius >= ROUND_FROM_M else 0.0
    pieces: list[tuple[FloatArray, FloatArray, FloatArray, IntArray]] = []
    for side in sides:
        axis, sign = "xyz".index(side.lower()), 1.0 if side.isupper() else -1.0
        pieces.append(_box_side(half, axis, sign, radius, segments, step))
    starts = np.cumsum([0, *(len(piece[0]) for piece in pieces[:-1])])
    return _part(
        material,
        color,
        np.concatenate([piece[0] for piece in pieces]) + center,
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


def cushion(
    size: Point, center: Point, *, color: ArrayLike, material: str = "fabric",
    radius: float = 0.06, puff: float = 0.03, axis: int = 1, cells: int = 7,
) -> Part:  # fmt: skip
    """A stuffed box whose two faces across `axis` bulge by `puff` metres in the middle."""
    step = max(size) / cells
    part = box(
        size, (0.0, 0.0, 0.0), color=color, material=material,
        radius=radius, segments=2, step=step,
    )  # fmt: skip
    half = np.asarray(size) / 2.0
    share = part.positions / half
    others = [k for k in range(3) if k != axis]
    bulge = np.prod(np.clip(1.0 - share[:, others] ** 2, 0.0, 1.0), axis=1)
    positions = part.positions.copy()
    positions[:, axis] += puff * bulge * share[:, axis]
    normals = smooth_normals(positions, part.faces)
    return dataclasses.replace(part, positions=positions + center, normals=normals)


def lathe(
    profile: Sequence[tuple[float, float]], *, color: ArrayLike, material: str = "plain",
    center: Point = (0.0, 0.0, 0.0), segments: int = 20, smooth: bool = False,
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
