"""Wavefront OBJ and MTL to raw parts.

trimesh reads OBJ too, but resolves negative indices from the end of the file, knows one material
library, drops a material it cannot find in silence, and decodes textures before their size is
known.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.files import MeshFiles
from affectsim_data.builders.meshes.limits import MeshLimits
from affectsim_data.builders.meshes.looks import Look
from affectsim_data.builders.meshes.mtl import ObjMaterials
from affectsim_data.builders.meshes.obj_text import IntArray, ObjText, numbers, words
from affectsim_data.builders.meshes.polygons import triangulated
from affectsim_data.builders.meshes.rows import unique_rows
from affectsim_data.builders.meshes.shaping import RawPart
from affectsim_data.poses import FloatArray

__all__ = ["read_obj"]

_SLASH = ord("/")


def read_obj(
    payload: bytes, files: MeshFiles, *, limits: MeshLimits, notes: Notes
) -> list[RawPart]:
    """The parts of an OBJ: one per object or group and material.

    Raises:
        ValueError: Broken or over a limit.
    """
    text = ObjText.from_bytes(payload)
    vertices = [_rows(text, keyword, limits) for keyword in (b"v", b"vt", b"vn")]
    if not len(vertices[0]):
        raise ValueError("an OBJ must have vertices, got none")
    corners = _corners(text, [len(one) for one in vertices])
    if len(corners.vertex) - 2 * len(corners.sizes) > limits.max_triangles:
        raise ValueError(
            f"its {len(corners.sizes)} faces make more than {limits.max_triangles} triangles; "
            "decimate it first"
        )
    triangles, polygon = triangulated(corners.vertex, corners.sizes, vertices[0], notes=notes)
    for keyword in (b"l", b"p"):
        count = len(text.lines_of(keyword))
        if count:
            notes["lines and points dropped"] += count
    materials = ObjMaterials(files, limits=limits, notes=notes)
    for line in text.text_of(text.lines_of(b"mtllib"), b"mtllib"):
        materials.add_library(line.decode("utf-8", "replace"))
    return _parts(text, vertices, corners, triangles, polygon, materials, limits)


def _rows(text: ObjText, keyword: bytes, limits: MeshLimits) -> FloatArray:
    """All `v`, `vt` or `vn` lines as rows as wide as the first; texture coordinates get two."""
    lines = text.lines_of(keyword)
    what = keyword.decode()
    if len(lines) > limits.max_vertices:
        raise ValueError(f"{len(lines)} {what} lines, more than the {limits.max_vertices} allowed")
    if not len(lines):
        return np.zeros((0, 3))
    joined = text.joined(lines, keyword)
    _, row = words(joined)
    widths = np.bincount(row, minlength=len(lines))
    width = int(widths.min())
    least = 1 if keyword == b"vt" else 3
    if width < least:
        raise ValueError(f"a {what} line must have {least} numbers or more, got {width}")
    values = numbers(joined.tobytes(), what=f"{what} lines")
    # Lines may be of several widths; the columns they share are read.
    place = np.cumsum(widths) - widths
    columns = min(width, 6 if keyword == b"v" else 3)
    rows: FloatArray = values[place[:, None] + np.arange(columns)]
    if keyword == b"vt":
        rows = np.concatenate([rows[:, :2], np.zeros((len(rows), 2 - min(columns, 2)))], axis=1)
    return rows


@dataclasses.dataclass(frozen=True)
class _Corners:
    """The corners of all faces, one after the other; -1 where a corner names none."""

    vertex: IntArray
    uv: IntArray
    normal: IntArray
    sizes: IntArray
    """Corners of every face, `(num_faces,)`."""
    lines: IntArray
    """Line of every face."""


def _corners(text: ObjText, counts: list[int]) -> _Corners:
    lines = text.lines_of(b"f")
    joined = text.joined(lines, b"f")
    starts, row = words(joined)
    sizes = np.bincount(row, minlength=len(lines))
    if not len(lines) or int(sizes.min(initial=3)) < 1:
        raise ValueError(f"an OBJ must have faces with corners, got {len(lines)} faces")
    slashes = np.flatnonzero(joined == _SLASH)
    per_word = np.bincount(
        np.searchsorted(starts, slashes, side="right") - 1, minlength=len(starts)
    )
    if int(per_word.max(initial=0)) > 2:
        raise ValueError("a corner of a face must be v, v/vt, v//vn or v/vt/vn")
    flat = joined.tobytes().replace(b"//", b"/0/").replace(b"/", b" ")
    values = numbers(flat, what="f lines")
    if len(values) != len(starts) + len(slashes) or (values != np.round(values)).any():
        raise ValueError("a corner of a face must be whole numbers v, v/vt, v//vn or v/vt/vn")
    first = np.cumsum(per_word + 1) - (per_word + 1)
    named = []
    for k, keyword in enumerate((b"v", b"vt", b"vn")):
        there = per_word >= k
        index = np.zeros(len(starts), np.int64)
        index[there] = values[first[there] + k]
        before = np.searchsorted(text.lines_of(keyword), lines)[row]
        named.append(_absolute(index, before, counts[k], keyword.decode(), needed=k == 0))
    return _Corners(named[0], named[1], named[2], sizes, lines)


def _absolute(
    index: IntArray, before: IntArray, count: int, what: str, *, needed: bool
) -> IntArray:
    """Indices from 0; negative ones count back from what stood before their line, 0 is none."""
    place = np.where(index > 0, index - 1, np.where(index < 0, before + index, -1))
    wrong = (place >= count) | ((index != 0) & (place < 0)) | (needed & (index == 0))
    if wrong.any():
        worst = int(index[np.argmax(wrong)])
        raise ValueError(f"a face names {what} {worst}, the file has {count}")
    return place


def _parts(
    text: ObjText, vertices: list[FloatArray], corners: _Corners, triangles: IntArray,
    polygon: IntArray, materials: ObjMaterials, limits: MeshLimits,
) -> list[RawPart]:  # fmt: skip
    """Triangles `(n, 3)` of corner numbers, sorted into parts by group and material."""
    lines = corners.lines[polygon]
    group_names, group = _states(text, (b"o", b"g"), lines, limits)
    look_names, look = _states(text, (b"usemtl",), lines, limits)
    keys, first, number = np.unique(
        np.stack([group, look]), axis=1, return_index=True, return_inverse=True
    )
    number = number.reshape(-1)
    order = np.argsort(number, kind="stable")
    ends = np.cumsum(np.bincount(number, minlength=keys.shape[1]))
    parts = []
    for k in np.argsort(first, kind="stable"):
        chosen = triangles[order[ends[k - 1] if k else 0 : ends[k]]]
        node, material = group_names[keys[0, k]], look_names[keys[1, k]]
        parts.append(_part(node, materials.look(material), vertices, corners, chosen))
    return parts


def _states(
    text: ObjText, keywords: tuple[bytes, ...], lines: IntArray, limits: MeshLimits
) -> tuple[list[str], IntArray]:
    """Names set by `keywords`, and which of them holds at each of `lines`; the first is empty."""
    found = [(text.lines_of(keyword), keyword) for keyword in keywords]
    where = np.concatenate([one for one, _ in found])
    if len(where) > limits.max_nodes:
        raise ValueError(f"{len(where)} groups, more than the {limits.max_nodes} allowed")
    names = [name for one, keyword in found for name in text.text_of(one, keyword)]
    order = np.argsort(where, kind="stable")
    said = ["", *(names[k].decode("utf-8", "replace") for k in order)]
    unique = list(dict.fromkeys(said))
    numbers_of = {name: k for k, name in enumerate(unique)}
    table = np.array([numbers_of[name] for name in said], np.int64)
    return unique, table[np.searchsorted(where[order], lines)]


def _part(
    node: str, look: Look, vertices: list[FloatArray], corners: _Corners, triangles: IntArray
) -> RawPart:
    """One part: a vertex for every different corner."""
    flat = triangles.reshape(-1)
    named = np.stack([corners.vertex[flat], corners.uv[flat], corners.normal[flat]], axis=1)
    has_uv, has_normal = (bool((named[:, k] >= 0).all()) for k in (1, 2))
    named[:, 1] *= has_uv
    named[:, 2] *= has_normal
    first, faces = unique_rows(*named.T)
    unique = named[first]
    rows = vertices[0][unique[:, 0]]
    return RawPart(
        node=node,
        look=look,
        positions=np.ascontiguousarray(rows[:, :3]),
        faces=faces.reshape(-1, 3),
        normals=vertices[2][unique[:, 2]] if has_normal else None,
        uvs=vertices[1][unique[:, 1]] * [1.0, -1.0] + [0.0, 1.0] if has_uv else None,
        colors=_vertex_colors(rows),
    )


def _vertex_colors(rows: FloatArray) -> FloatArray | None:
    """Colours after the coordinates, as some scanners write them; in [0, 1] or up to 255."""
    if rows.shape[1] < 6:
        return None
    colors = rows[:, 3:6] / (255.0 if rows[:, 3:6].max(initial=0.0) > 1.0 else 1.0)
    return np.concatenate([colors, np.ones((len(rows), 1))], axis=1)
