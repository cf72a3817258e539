"""Light that faces throw on each other: hemisphere rays once, then as many bounces as wanted."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from affectsim_data.builders.lighting.hemisphere import cosine_directions, tangents
from affectsim_data.builders.lighting.points import LightPoints
from affectsim_data.builders.lighting.rays import Array32, LightRays

__all__ = ["Gathering", "bounced", "cast_hemispheres"]

_BURIED = 0.55
"""Points from which a smaller share of the rays meets fronts of faces lie inside of something."""
_IN_A_GAP = 0.11
"""Openness below which a point lies in a gap that nobody looks into, as behind a wardrobe; its own
darkness would only blur into what is seen beside it."""
_COVERED = np.float32(0.7)
"""Light of buried points, of that beside them: edges of faces that others stand on are in shade."""
_NORMAL_REACH_M = np.float32(0.25)
"""How far away a point that looks the same way is as near as one that looks across."""
_PROBES = 5
"""Rays after which points that met nothing but backs, or only what is very near, get no more."""
_CLOSE_M = np.float32(0.5)
"""Faces nearer than this throw back less: the shade in corners and under things, which few rays
would otherwise miss."""
_CLOSEST = np.float32(0.3)


@dataclasses.dataclass(frozen=True)
class Gathering:
    """What the hemisphere of each point is made of."""

    groups: tuple[tuple[NDArray[np.intp], NDArray[np.int32]], ...]
    """Points `(n,)` that share a number of rays, and what their rays met, `(num_rays, n)`: a face,
    or `num_faces` for its back, or `num_faces + 1` and 2 for nothing, above and below level."""
    fronts: Array32
    """Share of each point's rays that did not meet backs, `(num_points,)`."""
    openness: Array32
    """How far away the met faces are, from `_CLOSEST` to 1, `(num_points,)`."""

    @property
    def buried(self) -> NDArray[np.bool_]:
        """Points inside of something or in a narrow gap, `(num_points,)`."""
        closed = _CLOSEST + (1.0 - _CLOSEST) * _IN_A_GAP
        return (self.fronts < _BURIED) | (self.openness < closed)

    def gathered(self, radiance: Array32) -> Array32:
        """Mean radiance over each hemisphere, `(num_points, 3)`, of that of faces and of what
        else rays met, `(num_faces + 3, 3)`."""
        light = np.zeros((len(self.fronts), 3), np.float32)
        for chosen, met in self.groups:
            total = np.zeros((len(chosen), 3), np.float32)
            for row in met:
                total += radiance.take(row, axis=0)
            light[chosen] = total / np.float32(len(met))
        scale = self.openness / np.maximum(self.fronts, np.float32(1e-3))
        light *= scale[:, None]
        return light


def cast_hemispheres(
    points: LightPoints, counts: NDArray[np.intp], rays: LightRays, face_normals: Array32,
    *, two_sided: bool = False,
) -> Gathering:  # fmt: skip
    """Casts cosine-weighted rays from every point.

    Args:
        points: Where light is wanted.
        counts: Rays of each point, `(num_points,)`; few different numbers.
        rays: The mesh.
        face_normals: Of its faces, of any length, `(num_faces, 3)`.
        two_sided: Whether backs of faces shine like their fronts.
    """
    groups = []
    fronts, openness = np.zeros((2, len(counts)), np.float32)
    for count in np.unique(counts):
        chosen = np.flatnonzero(counts == count)
        directions = cosine_directions(int(count))
        first, near = _cast(points, chosen, directions[:_PROBES], rays, face_normals, two_sided)
        free = (first != len(face_normals)).any(axis=0)
        if not two_sided:
            free &= near > _PROBES * _IN_A_GAP / 2.0
        chosen = chosen[free]
        rest, far = _cast(points, chosen, directions[_PROBES:], rays, face_normals, two_sided)
        met = np.concatenate([first[:, free], rest])
        distance = (near[free] + far) / np.float32(count)
        fronts[chosen] = 1.0 - (met == len(face_normals)).mean(axis=0)
        openness[chosen] = _CLOSEST + (1.0 - _CLOSEST) * distance
        groups.append((chosen, met))
    return Gathering(tuple(groups), fronts, openness)


def _cast(
    points: LightPoints, chosen: NDArray[np.intp], local: Array32, rays: LightRays,
    face_normals: Array32, two_sided: bool,
) -> tuple[NDArray[np.int32], Array32]:  # fmt: skip
    """What rays of some points meet, `(num_rays, n)` as in `Gathering.groups`, and the sum of how
    far away that is, each of `_CLOSE_M` and at most 1, `(n,)`."""
    starts, normals = points.starts(chosen), points.normals[chosen]
    tangent, bitangent = tangents(normals)
    met = np.empty((len(local), len(chosen)), np.int32)
    distances = np.zeros(len(chosen), np.float32)
    for row, (x, y, z) in zip(met, local, strict=True):
        directions = x * tangent + y * bitangent + z * normals
        found, distance = rays.first_hits(starts, directions)
        row[:] = _met(found, directions, face_normals, two_sided=two_sided)
        distances += np.minimum(distance / _CLOSE_M, np.float32(1.0))
    return met, distances


def _met(
    found: NDArray[np.int32], directions: Array32, face_normals: Array32, *, two_sided: bool
) -> NDArray[np.int32]:
    count = np.int32(len(face_normals))
    beyond = np.where(directions[:, 1] >= 0.0, count + 1, count + 2)
    if two_sided:
        return np.where(found < 0, beyond, found)
    facing = np.einsum("ij,ij->i", face_normals.take(found, axis=0), directions)
    return np.where(found < 0, beyond, np.where(facing > 0.0, count, found))


class _Filling:
    """Takes the light of buried points from open ones near them that look the same way."""

    def __init__(self, points: LightPoints, buried: NDArray[np.bool_]) -> None:
        self._buried = np.flatnonzero(buried)
        open_ones = np.flatnonzero(~buried)
        places = np.concatenate([points.positions, _NORMAL_REACH_M * points.normals], axis=1)
        neighbours = min(2, len(open_ones))
        if not len(self._buried) or not neighbours:
            self._buried = self._buried[:0]
            return
        tree = cKDTree(places[open_ones], leafsize=32, compact_nodes=False, balanced_tree=False)
        distance, near = tree.query(places[self._buried], k=np.arange(1, neighbours + 1), eps=0.2)
        weight = (1.0 / (distance + 0.01)).astype(np.float32)
        self._weight = _COVERED * weight / weight.sum(axis=1, keepdims=True)
        self._near = open_ones[near]

    def fill(self, light: Array32) -> Array32:
        """The light `(num_points, 3)`, changed in place."""
        if len(self._buried):
            light[self._buried] = np.einsum("nk,nkc->nc", self._weight, light[self._near])
        return light


def bounced(
    gathering: Gathering, points: LightPoints, direct: Array32, albedo: Array32,
    faces: NDArray[np.int32], *, ambient: float, beyond: Array32, bounces: int,
) -> Array32:  # fmt: skip
    """Direct light and what faces throw back, `(num_points, 3)`.

    Args:
        gathering: What the points see.
        points: The points and which vertices they stand for.
        direct: Light straight from the sources, `(num_points, 3)`.
        albedo: Of faces, linear, `(num_faces, 3)`.
        faces: Vertices of the faces that rays meet, `(num_faces, 3)`.
        ambient: Light of all further bounces, added to that of faces.
        beyond: Radiance where rays meet nothing, above and below level, `(2, 3)`.
        bounces: How often light is thrown back.
    """
    filling = _Filling(points, gathering.buried)
    a, b, c = points.of_vertex[faces].T
    rest = np.concatenate([np.zeros((1, 3), np.float32), beyond])
    light = filling.fill(direct.copy())
    for _ in range(bounces):
        at_faces = (light[a] + light[b] + light[c]) / np.float32(3.0) + np.float32(ambient)
        radiance = np.concatenate([albedo * at_faces, rest])
        light = filling.fill(direct + gathering.gathered(radiance))
    return light
