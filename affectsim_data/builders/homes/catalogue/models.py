"""Models of a catalogue as furniture: upright, to size, light enough, in our materials."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.homes.catalogue.entries import CatalogueEntry
from affectsim_data.builders.homes.parts import IntArray, Part
from affectsim_data.builders.meshes import MeshAsset, MeshPart
from affectsim_data.builders.meshes.looks import Look
from affectsim_data.builders.meshes.rows import unique_rows
from affectsim_data.builders.meshes.shaping import RawPart, creased
from affectsim_data.errors import require_extra
from affectsim_data.poses import FloatArray

__all__ = ["Shape", "fitted", "lightened", "to_parts", "triangle_budget"]

MAX_TRIANGLES = 8_000
"""Of a piece."""
_LEAST_TRIANGLES = 24
_LONGEST_EDGE_M, _THIN_M = 0.5, 0.06
"""Light is stored per vertex; larger triangles are cut unless they are thin."""
_COARSE_TEXELS = 16
"""A texture is looked at in so many texels a side: finer is less than a vertex can show."""
_MATERIALS = (
    ("lamp", re.compile(r"bulb|shade|abat|ampoule|lightsource|^light$")),
    ("wood", re.compile(r"wood|oak|pine|walnut|mahogany|teak|beech|birch|bois|legno|madera")),
    ("fabric", re.compile(r"fabric|cloth|cotton|textil|tissu|linen|cushion|pillow|mattress|blanket"
                          r"|sheet|duvet|velvet|wool|leather|upholst|coussin|seat")),
    ("stone", re.compile(r"marble|granit|stone|slate|concrete")),
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Shape:
    """Triangles of one material, in the axes of the piece, metres."""

    material: str
    """Key of `textures.MATERIALS`."""
    positions: FloatArray
    normals: FloatArray
    colors: FloatArray
    """sRGB in [0, 1], `(num_vertices, 3)`."""
    faces: IntArray


def triangle_budget(size: tuple[float, float, float]) -> int:
    """How many triangles a piece of that size may have: more the more of it one sees."""
    width, depth, height = size
    area = 2.0 * (width * depth + width * height + depth * height)
    return int(min(800 + 900 * area, 0.9 * MAX_TRIANGLES))


def fitted(
    asset: MeshAsset, entry: CatalogueEntry
) -> tuple[list[Shape], tuple[float, float, float]]:
    """The parts of a model about the middle of its underside, and its width, depth and height.

    Raises:
        ValueError: It is flat where the catalogue gives it a size.
    """
    turn = np.eye(3) if entry.rotation is None else np.array(entry.rotation).reshape(3, 3)
    turned = [part.positions.astype(np.float64) @ turn.T for part in asset.parts]
    low = np.min([one.min(axis=0) for one in turned], axis=0)
    extent = np.max([one.max(axis=0) for one in turned], axis=0) - low
    if entry.size is None:
        scale, size = np.ones(3), (float(extent[0]), float(extent[2]), float(extent[1]))
    else:
        size = entry.size
        wanted = np.array([size[0], size[2], size[1]])
        if (extent < 1e-9 * max(extent.max(), 1e-9)).any():
            raise ValueError(f"the model is flat: {extent[0]:g} x {extent[1]:g} x {extent[2]:g}")
        scale = wanted / extent
    foot = np.array([size[0] / 2.0, -entry.elevation_m, size[1] / 2.0])
    shapes = []
    for part, positions in zip(asset.parts, turned, strict=True):
        normals = part.normals.astype(np.float64) @ turn.T / scale
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        faces = part.faces.astype(np.int64)
        if np.linalg.det(turn) < 0.0:
            faces = faces[:, ::-1]
        shapes.append(
            Shape(_material(part), (positions - low) * scale - foot, normals, _colors(part), faces)
        )
    return shapes, size


def _material(part: MeshPart) -> str:
    name = f"{part.material} {part.node}".lower()
    return next((key for key, words in _MATERIALS if words.search(name)), "plain")


def _colors(part: MeshPart) -> FloatArray:
    """Vertex colours with the texture multiplied in, as coarse as vertices can show it."""
    base = part.colors[:, :3].astype(np.float64) / 255.0
    if part.texture is None or part.uvs is None:
        return base
    import cv2

    side = (min(_COARSE_TEXELS, part.texture.shape[1]), min(_COARSE_TEXELS, part.texture.shape[0]))
    coarse = np.asarray(cv2.resize(part.texture, side, interpolation=cv2.INTER_AREA))
    uvs = part.uvs - np.floor(part.uvs)
    columns = np.minimum((uvs[:, 0] * side[0]).astype(np.int64), side[0] - 1)
    rows = np.minimum((uvs[:, 1] * side[1]).astype(np.int64), side[1] - 1)
    sampled: FloatArray = coarse[rows, columns] / 255.0
    if float(coarse.reshape(-1, 3).std(axis=0).max()) < 25.0:
        # An even texture is one colour: its own, not that of the texels vertices happen to be on.
        sampled = np.broadcast_to(part.texture.reshape(-1, 3).mean(axis=0) / 255.0, base.shape)
    return base * sampled


def lightened(shapes: list[Shape], budget: int) -> list[Shape]:
    """The shapes with about `budget` triangles in all.

    Raises:
        MissingExtraError: There are more and the extra `build` is not installed.
    """
    if sum(len(shape.faces) for shape in shapes) > budget:
        shapes = [_once(shape) for shape in shapes]
        shares = _shares(shapes, budget)
        shapes = [_simplified(one, share) for one, share in zip(shapes, shares, strict=True)]
    return shapes


def _shares(shapes: list[Shape], budget: int) -> list[int]:
    """Triangles for each shape: the more, the more it has and the larger it is."""
    counts = np.array([len(shape.faces) for shape in shapes], np.float64)
    weights = np.sqrt(counts * np.array([_area(shape) for shape in shapes]) + 1e-9)
    shares = np.zeros(len(shapes))
    for _ in range(4):
        # What a small shape does not need goes to the others.
        room = np.where(shares < counts, weights, 0.0)
        shares = np.minimum(shares + (budget - shares.sum()) * room / max(room.sum(), 1e-9), counts)
    return [max(int(share), _LEAST_TRIANGLES) for share in shares]


def _area(shape: Shape) -> float:
    a, b, c = (shape.positions[shape.faces[:, k]] for k in range(3))
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)


def _once(shape: Shape) -> Shape:
    """Without triangles that are there twice: everything is drawn two-sided."""
    _, place = unique_rows(*np.round(shape.positions, 5).T)
    first, _ = unique_rows(*np.sort(place[shape.faces], axis=1).T)
    return dataclasses.replace(shape, faces=shape.faces[np.sort(first)])


def _simplified(shape: Shape, num_faces: int) -> Shape:
    if len(shape.faces) <= num_faces:
        return shape
    simplification = require_extra("fast_simplification", extra="build")
    from scipy.spatial import cKDTree

    kept, place = unique_rows(*np.round(shape.positions, 5).T)
    unique, welded = shape.positions[kept], place[shape.faces]
    welded = welded[(welded != np.roll(welded, 1, axis=1)).all(axis=1)]
    # Kept borders keep thin sheets whole, but not everything gets small enough with them.
    for keep, force in ((True, 4.0), (False, 7.0)):
        points, faces = simplification.simplify(
            unique.astype(np.float32), welded.astype(np.int32), target_count=num_faces,
            agg=force, preserve_border=keep,
        )  # fmt: skip
        if len(faces) <= 1.3 * num_faces:
            break
    if not len(faces):
        return shape
    points, faces = points.astype(np.float64), faces.astype(np.int64)
    _, nearest = cKDTree(shape.positions).query(points)
    colors = np.concatenate([shape.colors[nearest], np.ones((len(points), 1))], axis=1)
    sharp = creased(RawPart("", Look(), points, faces, colors=colors))
    assert sharp.normals is not None
    assert sharp.colors is not None
    return Shape(shape.material, sharp.positions, sharp.normals, sharp.colors[:, :3], sharp.faces)


def to_parts(shapes: list[Shape]) -> list[Part]:
    """Parts of a piece, their texture coordinates in metres along their sides.

    Raises:
        ValueError: There are more triangles than a piece may have.
    """
    parts = [_part(_cut(shape)) for shape in shapes if len(shape.faces)]
    total = sum(len(part.faces) for part in parts)
    if not 0 < total <= MAX_TRIANGLES:
        raise ValueError(f"simplifies to {total} triangles, 1 to {MAX_TRIANGLES} are allowed")
    return parts


def _part(shape: Shape) -> Part:
    extent = np.ptp(shape.positions, axis=0)
    axis = np.abs(shape.normals).argmax(axis=1)
    # The grain of wood, along texture u, follows the longer side.
    along = np.array([[1, 2], [0, 2], [0, 1]])
    longer = np.array([a if extent[a] >= extent[b] else b for a, b in along])
    other = np.array([3 - k - int(longer[k]) for k in range(3)])
    rows = np.arange(len(axis))
    uvs = np.stack(
        [shape.positions[rows, longer[axis]], -shape.positions[rows, other[axis]]], axis=1
    )
    return Part(shape.material, shape.positions, shape.normals, uvs, shape.colors, shape.faces)


def _cut(shape: Shape) -> Shape:
    """Triangles with edges of more than `_LONGEST_EDGE_M` cut in halves until none is."""
    values = np.concatenate([shape.positions, shape.normals, shape.colors], axis=1)
    faces = shape.faces
    for _ in range(12):
        ends = values[faces, :3]
        lengths = np.linalg.norm(np.roll(ends, -1, axis=1) - ends, axis=2)
        across = np.linalg.norm(np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0]), axis=1)
        longest = lengths.max(axis=1)
        long = (longest > _LONGEST_EDGE_M) & (across > _THIN_M * longest)
        if not long.any():
            break
        values, faces = _halved(values, faces, long, lengths.argmax(axis=1))
    normals = values[:, 3:6] / np.maximum(
        np.linalg.norm(values[:, 3:6], axis=1, keepdims=True), 1e-12
    )
    return Shape(shape.material, values[:, :3], normals, values[:, 6:], faces)


def _halved(
    values: FloatArray, faces: IntArray, long: NDArray[np.bool_], edge: IntArray
) -> tuple[FloatArray, IntArray]:
    """Cuts the chosen triangles across their longest edge."""
    chosen, first = faces[long], edge[long]
    rows = np.arange(len(chosen))
    a, b, c = (chosen[rows, (first + k) % 3] for k in range(3))
    pairs, middle = np.unique(
        np.sort(np.stack([a, b], axis=1), axis=1), axis=0, return_inverse=True
    )
    new = values[pairs].mean(axis=1)
    m = middle.reshape(-1) + len(values)
    halves = np.concatenate([np.stack([a, m, c], axis=1), np.stack([m, b, c], axis=1)])
    return np.concatenate([values, new]), np.concatenate([faces[~long], halves])
