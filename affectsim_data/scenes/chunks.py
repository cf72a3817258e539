"""Runs of triangles that are culled and drawn as one, each with a run of vertices of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.solids import closed_solids
from affectsim_data.scenes.surfaces import Surface

__all__ = ["Chunks", "chunk_surfaces", "split_faces"]

CHUNK_TRIANGLES = 768
"""Small enough that most of a furnished flat is culled, large enough that calls do not count."""


@dataclasses.dataclass(frozen=True, eq=False)
class Chunks:
    """Where each chunk lies in its surface, and what bounds it; arrays over `n` chunks."""

    surface: NDArray[np.int32]
    """Index of its surface, `(n,)`."""
    first: NDArray[np.int32]
    """Its first triangle among those of the surface, `(n,)`."""
    count: NDArray[np.int32]
    """Its triangles, `(n,)`."""
    room: NDArray[np.int32]
    """Index of the room that all of it is in, -1 if it is in none or in several, `(n,)`."""
    low: FloatArray
    """Low corner of its box, metres, `(n, 3)`."""
    high: FloatArray
    """High corner, `(n, 3)`."""
    solid_low: FloatArray
    """Low corner of the box around the closed solids it is part of; -inf for none, `(n, 3)`."""
    solid_high: FloatArray
    """High corner; +inf for none, `(n, 3)`."""

    def __len__(self) -> int:
        return len(self.surface)


def chunk_surfaces(surfaces: Sequence[Surface]) -> tuple[tuple[Surface, ...], Chunks]:
    """Orders triangles and vertices by chunk; a chunk is all of closed solids or has none of them.

    Vertices that several chunks share are repeated, so that drawing a chunk reads memory in order.
    Rooms are not known here: every `room` is -1.
    """
    ordered, rows = [], []
    for index, surface in enumerate(surfaces):
        vertices, faces, first, start = [], [], 0, 0
        for chosen, solid_box in _parts(surface):
            used, local = np.unique(surface.faces[chosen], return_inverse=True)
            box = surface.positions[used].min(axis=0), surface.positions[used].max(axis=0)
            rows.append((index, first, len(chosen), -1, *box, *solid_box))
            vertices.append(used)
            faces.append(local.reshape(-1, 3) + start)
            first, start = first + len(chosen), start + len(used)
        if vertices:
            surface = _taken(surface, np.concatenate(vertices), np.concatenate(faces))
        ordered.append(surface)
    columns: list[Any] = list(zip(*rows, strict=True)) or [()] * 8
    numbers = [np.array(column, np.int32) for column in columns[:4]]
    boxes = [np.array(column, np.float64).reshape(-1, 3) for column in columns[4:]]
    return tuple(ordered), Chunks(
        numbers[0], numbers[1], numbers[2], numbers[3], boxes[0], boxes[1], boxes[2], boxes[3]
    )


def _taken(surface: Surface, vertices: NDArray[np.int64], faces: NDArray[np.int64]) -> Surface:
    return dataclasses.replace(
        surface,
        positions=surface.positions[vertices],
        normals=surface.normals[vertices],
        colors=surface.colors[vertices],
        uvs=None if surface.uvs is None else surface.uvs[vertices],
        faces=faces.astype(np.uint32),
    )


def split_faces(centroids: FloatArray, max_faces: int) -> Iterator[NDArray[np.int64]]:
    """Indices of triangles by place, at most `max_faces` each: halved along the longest side."""
    stack = [np.arange(len(centroids))]
    while stack:
        chosen = stack.pop()
        if len(chosen) <= max_faces:
            yield np.sort(chosen)
            continue
        points = centroids[chosen]
        axis = int(np.argmax(np.ptp(points, axis=0)))
        order = chosen[np.argsort(points[:, axis], kind="stable")]
        half = len(order) // 2
        stack += [order[half:], order[:half]]


def _parts(surface: Surface) -> Iterator[tuple[NDArray[np.int64], FloatArray]]:
    """Faces of each chunk of a surface, and the box of the solids they belong to."""
    if not len(surface.faces):
        return
    positions = surface.positions.astype(np.float64)
    centroids = positions[surface.faces].mean(axis=1)
    closed, boxes = closed_solids(positions, surface.faces.astype(np.int64))
    for wanted in (True, False):
        group = np.flatnonzero(closed == wanted)
        for chosen in split_faces(centroids[group], CHUNK_TRIANGLES):
            if not len(chosen):
                continue
            box = np.array([[-np.inf] * 3, [np.inf] * 3])
            if wanted:
                around = boxes[group[chosen]]
                box = np.array([around[:, 0].min(axis=0), around[:, 1].max(axis=0)])
            yield group[chosen], box
