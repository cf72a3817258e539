"""Soft, bent and flat shapes of furniture: cushions, tubes, table tops, balls and leaves."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.parts import (
    Part,
    Point,
    box,
    grid_faces,
    lathe,
    smooth_normals,
)
from affectsim_data.poses import FloatArray

__all__ = ["ball", "cushion", "leaves", "oval", "rounded", "slab", "tube", "two_sided"]


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


def ball(
    radius: float, center: Point, *, color: ArrayLike, segments: int = 18, material: str = "plain"
) -> Part:
    """A ball about its centre."""
    angle = np.linspace(-np.pi / 2.0, np.pi / 2.0, segments // 2 + 1)
    profile = [
        (radius * max(float(np.cos(a)), 0.0) * (abs(a) < 1.57), radius * float(np.sin(a)))
        for a in angle
    ]
    return lathe(
        profile, color=color, center=center, segments=segments, smooth=True, material=material
    )


def tube(
    path: ArrayLike, radius: ArrayLike, *, color: ArrayLike, material: str = "plain",
    segments: int = 12,
) -> Part:  # fmt: skip
    """A closed round bar along a path.

    Args:
        path: Points of its middle, metres, `(num_points, 3)`.
        radius: Metres, one or `(num_points,)`.
        color: sRGB in [0, 1].
        material: Key of `textures.MATERIALS`.
        segments: Around.
    """
    points = np.asarray(path, np.float64)
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # One direction that no piece of the path runs along keeps the rings from twisting.
    axis = np.eye(3)[int(np.abs(along).max(axis=0).argmin())]
    side = np.cross(axis, along)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(along, side)
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    out = (
        np.cos(angle)[None, :, None] * side[:, None] + np.sin(angle)[None, :, None] * other[:, None]
    )
    reach = np.broadcast_to(np.asarray(radius, np.float64), len(points))
    rings = points[:, None] + reach[:, None, None] * out
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    uvs = np.stack(np.broadcast_arrays(arc[:, None], angle[None, :] * float(reach.max())), axis=-1)
    faces = grid_faces(len(points), segments + 1)
    count = len(points) * (segments + 1)
    caps: list[FloatArray] = []
    cap_normals, cap_faces, start = [], [], count
    for end, way, turn in ((0, -along[0], -1), (-1, along[-1], 1)):
        caps.append(np.concatenate([points[end][None], rings[end][:-1]]))
        cap_normals.append(np.broadcast_to(way, caps[-1].shape))
        rim = np.arange(segments)
        fan = np.stack([np.zeros(segments, int), 1 + rim, 1 + (rim + 1) % segments], axis=1)
        cap_faces.append(start + fan[:, ::turn])
        start += len(caps[-1])
    positions = np.concatenate([rings.reshape(-1, 3), *caps])
    colors = np.broadcast_to(np.clip(color, 0.0, 1.0), positions.shape).copy()
    flat = np.zeros((len(positions) - count, 2))
    return Part(
        material, positions, np.concatenate([out.reshape(-1, 3), *cap_normals]),
        np.concatenate([uvs.reshape(-1, 2), flat]), colors, np.concatenate([faces, *cap_faces]),
    )  # fmt: skip


def oval(width: float, depth: float, *, count: int = 52) -> FloatArray:
    """Outline `(x, z)` of an ellipse, `(count, 2)`."""
    angle = np.linspace(0.0, 2.0 * np.pi, count, endpoint=False)
    return np.stack([np.sin(angle) * width, np.cos(angle) * depth], axis=1) / 2.0


def rounded(width: float, depth: float, radius: float, *, segments: int = 5) -> FloatArray:
    """Outline `(x, z)` of a rectangle with round corners, `(4 (segments + 1), 2)`."""
    corners = []
    for k, (x, z) in enumerate(((1.0, 1.0), (1.0, -1.0), (-1.0, -1.0), (-1.0, 1.0))):
        angle = np.pi / 2.0 * (k + np.linspace(0.0, 1.0, segments + 1))
        middle = np.array([x * (width / 2.0 - radius), z * (depth / 2.0 - radius)])
        corners.append(middle + radius * np.stack([np.sin(angle), np.cos(angle)], axis=1))
    return np.concatenate(corners)


def slab(
    outline: FloatArray, top: float, thickness: float, *, color: ArrayLike, material: str = "wood",
    bevel: float = 0.004,
) -> Part:  # fmt: skip
    """A flat plate of a convex outline about the origin, its upper face at height `top`.

    Args:
        outline: Corners `(x, z)` counter-clockwise from above, metres, `(n, 2)`.
        top: Metres.
        thickness: Metres.
        color: sRGB in [0, 1].
        material: Key of `textures.MATERIALS`.
        bevel: Of both rims, metres.
    """
    loop = np.concatenate([outline, outline[:1]])
    inner = loop * (1.0 - bevel / np.maximum(np.linalg.norm(loop, axis=1, keepdims=True), 1e-9))
    low, high = top - thickness, top
    heights = (low, low, low, low + bevel, high - bevel, high, high, high)
    lines = (inner * 0.0, inner * 0.5, inner, loop, loop, inner, inner * 0.5, inner * 0.0)
    rows = list(zip(lines, heights, strict=True))
    pairs = [(rows[k], rows[k + 1]) for k in range(len(rows) - 1)]
    pieces, normals, uvs, faces, start = [], [], [], [], 0
    for (lower, y0), (upper, y1) in pairs:
        grid = np.stack([_at(lower, y0), _at(upper, y1)])
        flat, triangles = grid.reshape(-1, 3), grid_faces(2, len(loop))
        a, b, c = (flat[triangles[:, k]] for k in range(3))
        triangles = triangles[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-10]
        arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(loop, axis=0), axis=1))])
        level = abs(y1 - y0) < 1e-9
        pieces.append(flat)
        normals.append(smooth_normals(flat, triangles))
        upright = np.stack([np.tile(arc, 2), -flat[:, 1]], axis=1)
        uvs.append(flat[:, [0, 2]] if level else upright)
        faces.append(triangles + start)
        start += len(flat)
    positions, directions = np.concatenate(pieces), np.concatenate(normals)
    short = np.linalg.norm(directions, axis=1) < 0.5
    directions[short] = [0.0, 1.0, 0.0]
    colors = np.broadcast_to(np.clip(color, 0.0, 1.0), positions.shape).copy()
    return Part(material, positions, directions, np.concatenate(uvs), colors, np.concatenate(faces))


def _at(plane: FloatArray, y: float) -> FloatArray:
    return np.stack([plane[:, 0], np.full(len(plane), y), plane[:, 1]], axis=1)


def two_sided(
    points: FloatArray, *, color: ArrayLike, material: str, thickness: float
) -> Part:  # fmt: skip
    """A thin bent sheet, `(rows, columns, 3)`, as two skins so that both sides are drawn."""
    rows, columns = points.shape[:2]
    flat, faces = points.reshape(-1, 3), grid_faces(rows, columns)
    normals = smooth_normals(flat, faces)
    along = np.cumsum(np.linalg.norm(np.diff(points, axis=1, prepend=points[:, :1]), axis=2), 1)
    up = np.cumsum(np.linalg.norm(np.diff(points, axis=0, prepend=points[:1]), axis=2), axis=0)
    uvs = np.stack([along, -up], axis=-1).reshape(-1, 2)
    shift = normals * (thickness / 2.0)
    positions = np.concatenate([flat + shift, flat - shift])
    return Part(
        material=material,
        positions=positions,
        normals=np.concatenate([normals, -normals]),
        uvs=np.concatenate([uvs, uvs]),
        colors=np.broadcast_to(np.clip(color, 0.0, 1.0), positions.shape).copy(),
        faces=np.concatenate([faces, faces[:, ::-1] + len(flat)]),
    )


def leaves(
    spines: FloatArray, half_widths: FloatArray, *, colors: FloatArray, fold: float = 0.3
) -> Part:
    """Bent leaves with a fold along the middle, drawn from both sides.

    Args:
        spines: Middle lines from stalk to tip, metres, `(num_leaves, rows, 3)`.
        half_widths: Along the middle line, metres, `(num_leaves, rows)`.
        colors: sRGB in [0, 1], `(num_leaves, 3)`.
        fold: Rise of the rims as a share of their half width.
    """
    count, rows = spines.shape[:2]
    along = np.gradient(spines, axis=1)
    side = np.cross(along, [0.0, 1.0, 0.0])
    steep = np.linalg.norm(side, axis=2, keepdims=True) < 1e-6
    side = np.where(steep, [1.0, 0.0, 0.0], side)
    side /= np.linalg.norm(side, axis=2, keepdims=True)
    across = np.array([1.0, 0.0, -1.0])[:, None]
    reach = half_widths[..., None, None]
    points = spines[:, :, None] + reach * across * side[:, :, None]
    points[..., 1] += fold * half_widths[..., None] * np.abs(across[:, 0])
    flat = points.reshape(-1, 3)
    each = grid_faces(rows, 3)
    faces = (each[None] + 3 * rows * np.arange(count)[:, None, None]).reshape(-1, 3)
    a, b, c = (flat[faces[:, k]] for k in range(3))
    faces = faces[np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-8]
    normals = smooth_normals(flat, faces)
    shift = 0.0012 * normals
    positions = np.concatenate([flat + shift, flat - shift])
    tint = np.repeat(np.clip(colors, 0.0, 1.0), 3 * rows, axis=0)
    uvs = np.zeros((len(positions), 2))
    return Part(
        "plain", positions, np.concatenate([normals, -normals]), uvs,
        np.concatenate([tint, tint]), np.concatenate([faces, faces[:, ::-1] + len(flat)]),
    )  # fmt: skip
