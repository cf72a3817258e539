"""Surfaces that are drawn alike as one."""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.scenes.surfaces import Surface

__all__ = ["fold_flat_textures", "merge_alike", "merged", "with_own_corners"]


def fold_flat_textures(surfaces: Sequence[Surface]) -> tuple[list[Surface], int]:
    """Textures of a single colour multiplied into the vertex colours, and how many there were."""
    folded, found = [], set()
    for surface in surfaces:
        texture = surface.texture
        if texture is None:
            folded.append(dataclasses.replace(surface, uvs=None))
        elif (texture == texture[0, 0]).all():
            found.add(id(texture))
            colors = surface.colors.copy()
            colors[:, :3] = np.rint(colors[:, :3] * (texture[0, 0] / 255.0))
            folded.append(dataclasses.replace(surface, colors=colors, uvs=None, texture=None))
        else:
            folded.append(surface)
    return folded, len(found)


def merge_alike(surfaces: Sequence[Surface]) -> list[Surface]:
    """One surface for all without a texture, and one for each different texture, in order."""
    groups: dict[bytes, list[Surface]] = {}
    known: dict[int, bytes] = {}
    for surface in surfaces:
        if not len(surface.faces):
            continue
        texture = surface.texture
        if id(texture) not in known:
            known[id(texture)] = b"" if texture is None else _digest(texture)
        groups.setdefault(known[id(texture)], []).append(surface)
    return [merged(group, name=group[0].name) for group in groups.values()]


def _digest(texture: NDArray[np.uint8]) -> bytes:
    digest = hashlib.sha256(str(texture.shape).encode())
    digest.update(np.ascontiguousarray(texture).data)
    return digest.digest()


def merged(
    surfaces: Sequence[Surface], *, name: str, texture: NDArray[np.uint8] | None = None
) -> Surface:
    """Surfaces as one, under `texture` if it is given, else under that of the first."""
    if len(surfaces) == 1 and texture is None:
        return dataclasses.replace(surfaces[0], name=name)
    texture = surfaces[0].texture if texture is None else texture
    starts = np.cumsum([0, *(len(one.positions) for one in surfaces)])
    if starts[-1] >= 2**32:
        raise ValueError(f"surface {name!r}: {starts[-1]:,} vertices are more than faces can name")
    uvs = None
    if texture is not None:
        uvs = np.concatenate([one.uvs for one in surfaces if one.uvs is not None])
    return Surface(
        name=name,
        positions=np.concatenate([one.positions for one in surfaces]),
        normals=np.concatenate([one.normals for one in surfaces]),
        colors=np.concatenate([one.colors for one in surfaces]),
        faces=np.concatenate(
            [one.faces + np.uint32(start) for one, start in zip(surfaces, starts, strict=False)]
        ),
        uvs=uvs,
        texture=texture,
    )


def with_own_corners(surface: Surface) -> Surface:
    """The surface with three vertices to every triangle, `(3 * num_faces, 3)` in order."""
    corners = surface.faces.reshape(-1)
    return dataclasses.replace(
        surface,
        positions=surface.positions[corners],
        normals=surface.normals[corners],
        colors=surface.colors[corners],
        faces=np.arange(len(corners), dtype=np.uint32).reshape(-1, 3),
        uvs=None if surface.uvs is None else surface.uvs[corners],
    )
