"""Triangle surfaces while an avatar is baked: cut along a level, simplify, smooth, hem, colour."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from trimesh import triangles

from affectsim_data.avatars import AvatarMesh
from affectsim_data.errors import require_extra
from affectsim_data.poses import FloatArray

__all__ = ["Level", "Surface", "merge", "normalized", "to_mesh"]

IntArray = NDArray[np.int64]
Level = Callable[[FloatArray], FloatArray]
"""A signed distance or the like of points `(n, 3)`, `(n,)`."""

# trimesh leaves these two without types.
_closest_point: Any = triangles.closest_point
_barycentric: Any = triangles.points_to_barycentric


def normalized(vectors: FloatArray) -> FloatArray:
    """Vectors `(..., 3)` at unit length; zero stays zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    unit: FloatArray = vectors / np.maximum(length, 1e-12)
    return unit


@dataclasses.dataclass(frozen=True)
class Surface:
    """A triangle mesh whose vertices carry joint weights and named scalars."""

    positions: FloatArray
    """Metres, `(num_vertices, 3)`."""
    faces: IntArray
    """Counter-clockwise from outside, `(num_faces, 3)`."""
    weights: FloatArray
    """Share of every joint, `(num_vertices, num_joints)`."""
    scalars: Mapping[str, FloatArray] = dataclasses.field(default_factory=dict)
    """Values per vertex, by name; `cut` and `simplify` carry them along."""
    normals: FloatArray | None = None
    """Unit normals `(num_vertices, 3)`, where fixed: cuts keep them, so seams stay invisible."""

    def moved(self, positions: FloatArray) -> Surface:
        """The surface with other positions and no fixed normals."""
        return dataclasses.replace(self, positions=positions, normals=None)

    def vertex_normals(self) -> FloatArray:
        """Area-weighted unit normals, `(num_vertices, 3)`."""
        corners = self.positions[self.faces]
        cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        total = np.zeros_like(self.positions)
        for corner in range(3):
            np.add.at(total, self.faces[:, corner], cross)
        return normalized(total)

    def with_normals(self) -> Surface:
        """The surface with its present smooth normals fixed."""
        return dataclasses.replace(self, normals=self.vertex_normals())

    def posed(self, matrices: FloatArray, *, back: bool = False) -> Surface:
        """The surface under joint matrices `(num_joints, 4, 4)`, or brought back from there."""
        blended = np.einsum("vj,jab->vab", self.weights, matrices)
        if back:
            blended = np.linalg.inv(blended)
        turned = np.einsum("vab,vb->va", blended[:, :3, :3], self.positions)
        return self.moved(turned + blended[:, :3, 3])

    def subdivided(self) -> Surface:
        """The surface with every triangle split into four at the middles of its sides."""
        sides = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, inverse = np.unique(sides, axis=0, return_inverse=True)
        middles = self._gather(edges[:, 0], edges[:, 1], np.full(len(edges), 0.5))
        a, b, c = self.faces.T
        ab, bc, ca = len(self.positions) + inverse.reshape(-1, 3).T
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = np.concatenate([np.stack(corners, axis=1) for corners in quarters])
        return dataclasses.replace(_append(self, middles), faces=faces)

    def _gather(self, first: IntArray, second: IntArray, share: FloatArray) -> Surface:
        """Vertices between pairs of vertices, without faces; `share` of the second one."""

        def mix(values: FloatArray) -> FloatArray:
            part = share.reshape(-1, *[1] * (values.ndim - 1))
            mixed: FloatArray = values[first] * (1.0 - part) + values[second] * part
            return mixed

        return Surface(
            mix(self.positions),
            np.zeros((0, 3), np.int64),
            mix(self.weights),
            {name: mix(values) for name, values in self.scalars.items()},
            None if self.normals is None else normalized(mix(self.normals)),
        )

    def with_faces(self, faces: IntArray) -> Surface:
        """Only these faces and the vertices they use."""
        used, inverse = np.unique(faces, return_inverse=True)
        same = self._gather(used, used, np.zeros(len(used)))
        return dataclasses.replace(same, faces=inverse.reshape(-1, 3).astype(np.int64))

    def cut(self, level: FloatArray) -> tuple[Surface, Surface]:
        """The parts where `level` `(num_vertices,)` is positive and where not, cut sharply at 0."""
        value = np.where(np.abs(level) < 1e-9, 1e-9, level)
        positive = value > 0
        edges = np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges = np.unique(edges[positive[edges[:, 0]] != positive[edges[:, 1]]], axis=0)
        first, second = edges[:, 0], edges[:, 1]
        share = value[first] / (value[first] - value[second])
        extended = _append(self, self._gather(first, second, share))
        index = {(int(a), int(b)): len(value) + i for i, (a, b) in enumerate(edges)}
        kept: dict[bool, list[tuple[int, int, int]]] = {True: [], False: []}
        for face in self.faces.tolist():
            signs = [bool(positive[vertex]) for vertex in face]
            if len(set(signs)) == 1:
                kept[signs[0]].append((face[0], face[1], face[2]))
                continue
            alone = next(i for i in range(3) if signs.count(signs[i]) == 1)
            a, b, c = face[alone], face[(alone + 1) % 3], face[(alone + 2) % 3]
            ab, ac = index[min(a, b), max(a, b)], index[min(a, c), max(a, c)]
            kept[signs[alone]].append((a, ab, ac))
            kept[not signs[alone]] += [(ab, b, c), (ab, c, ac)]
        inside, outside = (
            extended.with_faces(np.array(kept[side], np.int64).reshape(-1, 3))
            for side in (True, False)
        )
        return inside, outside

    def carve(self, levels: Sequence[Level]) -> tuple[Surface, Surface]:
        """The part where all levels are positive, and the rest. Cut by one after the other, so
        that a part thinner than a triangle is found."""
        rest = []
        inside = self
        for level in levels:
            inside, outside = inside.cut(level(inside.positions))
            rest.append(outside)
        return inside, merge(rest)

    def boundary(self) -> IntArray:
        """Directed edges that only one face has, `(num_edges, 2)`."""
        edges = self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
        _, index, count = np.unique(
            np.sort(edges, axis=1), axis=0, return_index=True, return_counts=True
        )
        border: IntArray = edges[np.sort(index[count == 1])]
        return border

    def welded(self, other: Surface, rim: IntArray) -> Surface:
        """Both surfaces as one; the first vertices of `other` are those in `rim` here."""
        whole = _append(self, other)
        places = np.concatenate(
            [rim, len(self.positions) + np.arange(len(rim), len(other.positions))]
        )
        joined = np.concatenate([self.faces, places[other.faces]])
        return whole.with_faces(joined)

    def hem(self, depth_m: float) -> Surface:
        """A strip that turns every border inwards, so that a thin shell looks like cloth."""
        normals = self.normals if self.normals is not None else self.vertex_normals()
        return self.strip(self.boundary(), -normals * depth_m)

    def strip(self, edges: IntArray, offset: FloatArray) -> Surface:
        """Quads from directed border edges `(n, 2)` to the same moved by `offset`.

        Args:
            edges: Vertex pairs as `boundary` gives them.
            offset: Metres, `(3,)` or `(num_vertices, 3)`.
        """
        rim, inverse = np.unique(edges, return_inverse=True)
        start, end = inverse.reshape(-1, 2).T
        near = self._gather(rim, rim, np.zeros(len(rim)))
        shift = np.broadcast_to(offset, self.positions.shape)[rim]
        both = _append(near, dataclasses.replace(near, positions=near.positions + shift))
        count = len(rim)
        quads = np.stack([end, start, start + count, end + count], axis=1)
        faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        return dataclasses.replace(both, faces=faces, normals=None).with_normals()

    def smooth(self, passes: int, share: float = 0.5) -> Surface:
        """Every vertex drawn `share` of the way to the mean of its neighbours; borders stay."""
        edges = np.unique(np.sort(self.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)), axis=0)
        pairs = np.concatenate([edges, edges[:, ::-1]])
        degree = np.bincount(pairs[:, 0], minlength=len(self.positions))[:, None]
        fixed = np.isin(np.arange(len(self.positions)), self.boundary())[:, None]
        positions = self.positions
        for _ in range(passes):
            total = np.zeros_like(positions)
            np.add.at(total, pairs[:, 0], positions[pairs[:, 1]])
            target = total / np.maximum(degree, 1)
            positions = np.where(fixed, positions, positions + share * (target - positions))
        return self.moved(positions)

    def simplify(self, num_faces: int, *, keep_borders: bool = False) -> Surface:
        """About `num_faces` triangles; weights and scalars come from the nearest point."""
        if len(self.faces) <= num_faces:
            return self
        simplification = require_extra("fast_simplification", extra="build")
        points, faces = simplification.simplify(
            self.positions.astype(np.float32),
            self.faces.astype(np.int32),
            target_count=num_faces,
            agg=4.0,
            preserve_border=keep_borders,
        )
        points, faces = points.astype(np.float64), faces.astype(np.int64)
        whole = self.carried(points, faces)
        first, second = points[faces[:, 1:]].swapaxes(0, 1) - points[faces[:, 0]]
        area = np.linalg.norm(np.cross(first, second), axis=1)
        return whole.with_faces(faces[area > 1e-12])

    def carried(self, points: FloatArray, faces: IntArray) -> Surface:
        """Another mesh, its weights and scalars those of the nearest points of this surface."""
        corners, shares = self._nearest(points)

        def take(values: FloatArray) -> FloatArray:
            taken: FloatArray = np.einsum("nk,nk...->n...", shares, values[corners])
            return taken

        scalars = {name: take(values) for name, values in self.scalars.items()}
        return Surface(points, faces, take(self.weights), scalars)

    def _nearest(self, points: FloatArray) -> tuple[IntArray, FloatArray]:
        """Corners `(n, 3)` of the nearest triangle and barycentric shares `(n, 3)` in it."""
        corners = self.positions[self.faces]
        _, candidates = cKDTree(corners.mean(axis=1)).query(points, k=min(24, len(corners)))
        found = corners[candidates]
        flat = found.reshape(-1, 3, 3)
        closest = _closest_point(flat, np.repeat(points, candidates.shape[1], axis=0))
        distance = np.linalg.norm(
            closest.reshape(*candidates.shape, 3) - points[:, None], axis=2
        ).round(9)
        best = distance.argmin(axis=1)
        rows = np.arange(len(points))
        chosen = candidates[rows, best]
        point = closest.reshape(*candidates.shape, 3)[rows, best]
        shares = _barycentric(corners[chosen], point)
        shares = np.nan_to_num(shares, nan=1.0 / 3.0).clip(0.0, 1.0)
        return self.faces[chosen], shares / shares.sum(axis=1, keepdims=True)


def _append(first: Surface, second: Surface) -> Surface:
    """Vertices of both, faces of both; fixed normals and scalars where both have them."""
    normals = None
    if first.normals is not None and second.normals is not None:
        normals = np.concatenate([first.normals, second.normals])
    return Surface(
        np.concatenate([first.positions, second.positions]),
        np.concatenate([first.faces, second.faces + len(first.positions)]),
        np.concatenate([first.weights, second.weights]),
        {
            name: np.concatenate([first.scalars[name], second.scalars[name]])
            for name in sorted(first.scalars.keys() & second.scalars.keys())
        },
        normals,
    )


def merge(surfaces: list[Surface]) -> Surface:
    """One surface of several, in their order; those without fixed normals get smooth ones."""
    whole = surfaces[0] if surfaces[0].normals is not None else surfaces[0].with_normals()
    for surface in surfaces[1:]:
        whole = _append(whole, surface if surface.normals is not None else surface.with_normals())
    return whole


def _on_grid(values: FloatArray) -> NDArray[np.float32]:
    """Values on a grid of 2^-14, so that what differs between processors is rounded away."""
    return np.asarray(np.round(values * 2.0**14) / 2.0**14 + 0.0, np.float32)


def to_mesh(parts: list[tuple[Surface, NDArray[np.uint8]]]) -> AvatarMesh:
    """The drawable mesh of parts with an sRGB colour `(3,)` or colours `(num_vertices, 3)` each."""
    parts = [part for part in parts if len(part[0].faces)]
    whole = merge([surface for surface, _ in parts])
    rows = [np.broadcast_to(color, (len(surface.positions), 3)) for surface, color in parts]
    colors = np.concatenate([np.concatenate(rows), np.full((len(whole.positions), 1), 255)], axis=1)
    indices = np.argsort(-whole.weights, axis=1, kind="stable")[:, :4]
    weights = np.take_along_axis(whole.weights, indices, axis=1)
    weights = weights / weights.sum(axis=1, keepdims=True) * 255.0
    whole_weights = np.floor(weights)
    missing = (255 - whole_weights.sum(axis=1)).astype(np.int64)
    rank = np.argsort(np.argsort(whole_weights - weights, axis=1, kind="stable"), axis=1)
    whole_weights += rank < missing[:, None]
    assert whole.normals is not None
    normals = normalized(whole.normals)
    normals[np.linalg.norm(normals, axis=1) < 0.5] = (0.0, 1.0, 0.0)
    return AvatarMesh(
        positions=_on_grid(whole.positions),
        normals=_on_grid(normals),
        colors=colors.astype(np.uint8),
        joint_indices=np.where(whole_weights > 0, indices, 0).astype(np.uint8),
        joint_weights=whole_weights.astype(np.uint8),
        faces=whole.faces.astype(np.uint32),
    )
