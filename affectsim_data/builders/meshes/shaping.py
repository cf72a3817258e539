"""Raw triangles of any format to clean parts: finite, indexed, with normals and opaque colours."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.meshes.alpha import cleared
from affectsim_data.builders.meshes.asset import MeshPart, Notes
from affectsim_data.builders.meshes.images import Pixels
from affectsim_data.builders.meshes.looks import Look
from affectsim_data.builders.meshes.rows import unique_rows
from affectsim_data.poses import FloatArray

__all__ = ["RawPart", "creased", "shaped"]

_FAR = 1e5
"""Coordinates beyond are no place: 100 km."""
_FINE_TRIANGLES = 500_000
_CREASE_COS = 0.7
"""Corners whose face leans more than 45 degrees from the smooth normal keep the face's normal."""


@dataclasses.dataclass(frozen=True)
class RawPart:
    """Triangles as a file has them, in world axes."""

    node: str
    look: Look
    positions: FloatArray
    """`(num_vertices, 3)`; may hold nan."""
    faces: NDArray[np.int64]
    """`(num_faces, 3)`, checked against the number of vertices."""
    normals: FloatArray | None = None
    """`(num_vertices, 3)`, any length."""
    uvs: FloatArray | None = None
    """v down, `(num_vertices, 2)`."""
    colors: FloatArray | None = None
    """sRGB and opacity in [0, 1] that multiply the look, `(num_vertices, 4)`."""


def shaped(raw: RawPart, *, name: str, notes: Notes) -> MeshPart | None:
    """The part ready to draw, or none if nothing of it is left."""
    raw = _with_real_faces(raw, notes)
    if raw.normals is None and len(raw.faces):
        raw = creased(raw)
    texture, uvs = raw.look.texture, raw.uvs
    if texture is not None and (uvs is None or not np.isfinite(uvs).all()):
        notes["textured parts without texture coordinates, mean colour instead"] += 1
        raw = dataclasses.replace(raw, look=_with_mean_color(raw.look, texture), uvs=None)
    elif texture is not None and uvs is not None:
        raw = dataclasses.replace(raw, uvs=_texture_places(raw.look, uvs, notes))
        if np.array_equal(texture, np.broadcast_to(texture[:1, :1], texture.shape)):
            raw = dataclasses.replace(raw, look=_with_mean_color(raw.look, texture), uvs=None)
    faces, colors, picture = cleared(
        raw.look, raw.faces, _colors(raw), raw.uvs, notes=notes
    )  # fmt: skip
    if not len(faces):
        return None
    used, faces = np.unique(faces, return_inverse=True)
    textured = picture is not None and raw.uvs is not None
    faces = faces.reshape(-1, 3)
    positions = raw.positions[used].astype(np.float32)
    return MeshPart(
        name=name,
        node=raw.node,
        material=raw.look.name,
        positions=positions,
        normals=_unit_normals(raw, used, positions, faces),
        colors=np.round(colors[used] * 255.0).astype(np.uint8),
        faces=faces.astype(np.uint32),
        uvs=raw.uvs[used].astype(np.float32) if textured and raw.uvs is not None else None,
        texture=picture,
    )


def _texture_places(look: Look, uvs: FloatArray, notes: Notes) -> FloatArray:
    """Texture coordinates as the material moves them, for a texture that repeats."""
    if look.uv_transform is not None:
        rows = np.asarray(look.uv_transform)
        uvs = uvs @ rows[:, :2].T + rows[:, 2]
    if look.wrap == "repeat" or (np.abs(uvs - 0.5) <= 0.501).all():
        return uvs
    if look.wrap == "mirror":
        notes["mirrored textures repeated unmirrored"] += 1
        return uvs
    notes["texture coordinates outside of clamped textures cut off"] += 1
    return np.asarray(np.clip(uvs, 0.0, 1.0))


def _with_real_faces(raw: RawPart, notes: Notes) -> RawPart:
    """Without triangles that have a corner nowhere or no area."""
    with np.errstate(invalid="ignore"):
        sound = np.all(np.abs(raw.positions) < _FAR, axis=1)
    placed = sound[raw.faces].all(axis=1)
    if not placed.all():
        notes["triangles with vertices that are nan or beyond 100 km dropped"] += int(
            (~placed).sum()
        )
    faces = raw.faces[placed]
    a, b, c = faces.T
    flat = (a == b) | (b == c) | (c == a)
    same = [(raw.positions[i] == raw.positions[j]).all(axis=1) for i, j in ((a, b), (b, c), (c, a))]
    flat |= np.logical_or.reduce(same)
    if flat.any():
        notes["triangles without area dropped"] += int(flat.sum())
    return dataclasses.replace(raw, faces=faces[~flat])


def _with_mean_color(look: Look, texture: Pixels) -> Look:
    flat = texture.reshape(-1, texture.shape[-1])
    mean = flat.mean(axis=0) / 255.0
    tint = [look.color[k] * float(mean[k]) for k in range(3)]
    opacity = look.color[3] * (float(mean[3]) if texture.shape[-1] == 4 else 1.0)
    return dataclasses.replace(look, color=(tint[0], tint[1], tint[2], opacity), texture=None)


def _colors(raw: RawPart) -> FloatArray:
    """Base colour times vertex colours, `(num_vertices, 4)` in [0, 1]."""
    base = np.broadcast_to(np.asarray(raw.look.color), (len(raw.positions), 4))
    if raw.colors is None:
        return base
    return base * np.nan_to_num(np.clip(raw.colors, 0.0, 1.0), nan=1.0)


def _unit_normals(
    raw: RawPart, used: NDArray[Any], positions: NDArray[np.float32], faces: NDArray[Any]
) -> NDArray[np.float32]:
    """The file's normals where they are normals, else those of the triangles around."""
    normals = np.zeros((len(used), 3)) if raw.normals is None else raw.normals[used]
    with np.errstate(invalid="ignore", over="ignore"):
        length = np.linalg.norm(normals, axis=1, keepdims=True)
    bad = ~np.isfinite(length[:, 0]) | (length[:, 0] < 1e-6)
    unit = normals / np.where(bad[:, None], 1.0, length)
    if bad.any():
        unit[bad] = _smooth_normals(positions.astype(np.float64), faces)[bad]
    return unit.astype(np.float32)


def _smooth_normals(
    positions: FloatArray, faces: NDArray[Any], *, by_angle: bool = True
) -> FloatArray:
    """By vertex; up where the triangles cancel out, `(num_vertices, 3)`.

    Weighted by angle, the corner of a box does not care how its sides are cut; weighted by area is
    cheaper.
    """
    across = _face_normals(positions, faces)
    corners, count = faces.reshape(-1), len(positions)
    if by_angle:
        across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
        thrice = (across[:, None] * _angles(positions, faces)[..., None]).reshape(-1, 3)
    else:
        thrice = np.repeat(across, 3, axis=0)
    sums = np.stack(
        [np.bincount(corners, thrice[:, axis], minlength=count) for axis in range(3)], axis=1
    )
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    up = np.array([0.0, 1.0, 0.0])
    return np.where(length > 0.0, sums / np.where(length > 0.0, length, 1.0), up)


def _angles(positions: FloatArray, faces: NDArray[Any]) -> FloatArray:
    """Inner angles of triangles, radians, `(num_faces, 3)`."""
    ends = positions[faces]
    sides = np.roll(ends, -1, axis=1) - ends
    sides /= np.maximum(np.linalg.norm(sides, axis=2, keepdims=True), 1e-30)
    cosines = -np.einsum("fkc,fkc->fk", sides, np.roll(sides, 1, axis=1))
    return np.asarray(np.arccos(np.clip(cosines, -1.0, 1.0)))


def _face_normals(positions: FloatArray, faces: NDArray[Any]) -> FloatArray:
    """As long as twice the area, `(num_faces, 3)`."""
    a, b, c = (positions[faces[:, k]] for k in range(3))
    across: FloatArray = np.cross(b - a, c - a)
    return across


def creased(raw: RawPart) -> RawPart:
    """The part with normals: smooth over gentle bends, sharp over edges.

    Vertices at one place count as one, and are split where their triangles differ. Parts of more
    than `_FINE_TRIANGLES` are so fine that smooth normals do.
    """
    if len(raw.faces) > _FINE_TRIANGLES:
        normals = _smooth_normals(raw.positions, raw.faces, by_angle=False)
        return dataclasses.replace(raw, normals=normals)
    kept, place = unique_rows(*raw.positions.T)
    corners = raw.faces.reshape(-1)
    across = _face_normals(raw.positions, raw.faces)
    flat = across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-30)
    smooth = _smooth_normals(raw.positions[kept], place[raw.faces])[place[raw.faces]]
    gentle = np.einsum("fkc,fc->fk", smooth, flat) > _CREASE_COS
    normals = np.where(gentle[..., None], smooth, flat[:, None]).reshape(-1, 3)
    steps = np.round(normals * 512.0).astype(np.int16)
    first, faces = unique_rows(corners, *steps.T)
    kept = corners[first]
    return dataclasses.replace(
        raw,
        positions=raw.positions[kept],
        faces=faces.reshape(-1, 3),
        normals=normals[first],
        uvs=None if raw.uvs is None else raw.uvs[kept],
        colors=None if raw.colors is None else raw.colors[kept],
    )
