"""Light on the vertices of a mesh in a closed home."""

from __future__ import annotations

import dataclasses
from collections.abc import Container, Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.lighting.bounces import bounced, cast_hemispheres
from affectsim_data.builders.lighting.colors import linear_from_srgb, lit_colors
from affectsim_data.builders.lighting.points import LightPoints, light_points
from affectsim_data.builders.lighting.quads import turned_diagonals
from affectsim_data.builders.lighting.rays import Array32, LightRays
from affectsim_data.builders.lighting.sources import Lamp, WindowLight, direct_light
from affectsim_data.scenes import Surface

__all__ = ["LightMesh", "bake_light", "relit"]

_RAYS = ((0.0, 8), (0.0005, 13), (0.003, 22), (0.015, 48))
"""Least area around a point, m2, and the rays it gets: on large faces every step shows."""
_LARGE_M2 = 0.015
_AMBIENT = 0.012
"""Light of all bounces that are not computed."""
_BOUNCES = 3


@dataclasses.dataclass(frozen=True)
class LightMesh:
    """Surfaces as one mesh for light to fall on."""

    positions: Array32
    """Metres, `(num_vertices, 3)`."""
    normals: Array32
    """Unit, `(num_vertices, 3)`."""
    colors: Array32
    """Linear albedo before the texture, `(num_vertices, 3)`."""
    albedo: Array32
    """With the mean of the texture, linear, `(num_vertices, 3)`; 0 throws nothing back."""
    faces: NDArray[np.int32]
    """Triangles, counter-clockwise from outside, `(num_faces, 3)`."""

    @classmethod
    def of(cls, surfaces: Sequence[Surface], *, dark: Container[str] = ()) -> LightMesh:
        """All triangles of the surfaces; those named in `dark` throw nothing back."""
        starts = np.cumsum([0, *(len(surface.positions) for surface in surfaces[:-1])])
        faces = [
            surface.faces.astype(np.int32) + np.int32(start)
            for surface, start in zip(surfaces, starts, strict=True)
        ]
        tints = [_texture_mean(s) * np.float32(s.name not in dark) for s in surfaces]
        colors = linear_from_srgb(np.concatenate([surface.colors[:, :3] for surface in surfaces]))
        counts = [len(surface.positions) for surface in surfaces]
        return cls(
            positions=np.concatenate([surface.positions for surface in surfaces]),
            normals=np.concatenate([surface.normals for surface in surfaces]),
            colors=colors,
            albedo=colors * np.repeat(np.stack(tints), counts, axis=0),
            faces=np.concatenate(faces),
        )

    @property
    def face_albedo(self) -> Array32:
        """Mean albedo of each triangle, `(num_faces, 3)`."""
        a, b, c = (self.albedo[self.faces[:, k]] for k in range(3))
        mean: Array32 = (a + b + c) / np.float32(3.0)
        return mean

    @property
    def face_normals(self) -> Array32:
        """Of the length of twice each triangle's area, `(num_faces, 3)`."""
        a, b, c = (self.positions[self.faces[:, k]] for k in range(3))
        return np.cross(b - a, c - a)


def _texture_mean(surface: Surface) -> Array32:
    """Mean linear colour of the texture, `(3,)`."""
    if surface.texture is None:
        return np.ones(3, np.float32)
    mean: Array32 = linear_from_srgb(surface.texture[::4, ::4]).mean(axis=(0, 1))
    return mean


def relit(surfaces: Sequence[Surface], mesh: LightMesh, light: Array32) -> tuple[Surface, ...]:
    """The surfaces of a mesh with exposed light of its vertices, `(num_vertices, 3)`, multiplied
    into their colours, and quads cut where it interpolates best."""
    colors = lit_colors(mesh.colors, light)
    colors[:, 3] = np.concatenate([surface.colors[:, 3] for surface in surfaces])
    uvs = [
        np.zeros((len(s.positions), 2), np.float32) if s.uvs is None else s.uvs for s in surfaces
    ]
    faces = turned_diagonals(mesh.positions, mesh.faces, light.mean(axis=1), np.concatenate(uvs))
    lit, vertex, face = [], 0, 0
    for surface in surfaces:
        ends = vertex + len(surface.positions), face + len(surface.faces)
        own = faces[face : ends[1]] - np.int32(vertex)
        lit.append(
            dataclasses.replace(
                surface, colors=colors[vertex : ends[0]], faces=own.astype(np.uint32)
            )
        )
        vertex, face = ends
    return tuple(lit)


def bake_light(
    mesh: LightMesh, *, windows: Sequence[WindowLight], lamps: Sequence[Lamp]
) -> tuple[Array32, Array32]:
    """Linear light of vertices `(num_vertices, 3)`, the sky being 1, and their areas, m2.

    Radiosity: light straight from windows and lamps, then four bounces over one set of
    hemisphere rays. Equal input gives equal bytes.
    """
    points = light_points(mesh.positions, mesh.normals, mesh.faces)
    rays = LightRays(mesh.positions, mesh.faces)
    gathering = cast_hemispheres(points, _ray_counts(points), rays, mesh.face_normals)
    free = np.flatnonzero(~gathering.buried)
    direct = np.zeros_like(points.positions)
    direct[free] = direct_light(
        points.starts(free), points.normals[free], points.area[free] > _LARGE_M2,
        windows=windows, lamps=lamps, rays=rays,
    )  # fmt: skip
    light = bounced(
        gathering, points, direct, mesh.face_albedo, mesh.faces,
        ambient=_AMBIENT, beyond=np.zeros((2, 3), np.float32), bounces=_BOUNCES,
    )  # fmt: skip
    return light[points.of_vertex], points.area[points.of_vertex]


def _ray_counts(points: LightPoints) -> NDArray[np.intp]:
    least, counts = np.array(_RAYS).T
    chosen: NDArray[np.intp] = counts.astype(np.intp)[
        np.searchsorted(least, points.area, side="right") - 1
    ]
    return chosen
