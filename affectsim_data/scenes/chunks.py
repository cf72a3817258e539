"""Runs of triangles that are culled and drawn as one, each with a run of vertices of its own."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.face_rooms import face_rooms
from affectsim_data.scenes.semantics import Room
from affectsim_data.scenes.solids import closed_solids
from affectsim_data.scenes.surfaces import Surface

__all__ = ["Chunks", "check_chunks", "chunk_surfaces", "first_use", "split_faces"]

_NUMBERS = ("surface", "first", "count", "room")
CHUNK_TRIANGLES = 192
"""Small enough that most of a furnished home is culled, large enough that calls do not count."""


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

    def __post_init__(self) -> None:
        count = len(self.surface)
        for field in dataclasses.fields(self):
            values = getattr(self, field.name)
            numbers = field.name in _NUMBERS
            shape, kind = ((count,), "i") if numbers else ((count, 3), "f")
            if values.shape != shape or values.dtype.kind != kind:
                raise ValueError(
                    f"chunks: {field.name} must be {'integers' if numbers else 'floats'} {shape}, "
                    f"got {values.dtype} {values.shape}"
                )
        if not (np.isfinite(self.low) & (self.low <= self.high) & np.isfinite(self.high)).all():
            raise ValueError("chunks: low and high must be finite, low <= high")
        if not (self.solid_low <= self.solid_high).all():
            raise ValueError("chunks: solid_low must be <= solid_high")

    def __len__(self) -> int:
        return len(self.surface)


def check_chunks(chunks: Chunks, surfaces: Sequence[Surface], num_rooms: int) -> None:
    """Raises `ValueError` unless every triangle is in exactly one chunk and every room exists."""
    sizes = np.array([len(surface.faces) for surface in surfaces], np.int64)
    surface = chunks.surface.astype(np.int64)
    bad = np.flatnonzero((surface < 0) | (surface >= len(sizes)))
    if len(bad):
        raise ValueError(
            f"chunk {bad[0]} is of surface {surface[bad[0]]}, there are {len(sizes)} surfaces"
        )
    first, end = chunks.first.astype(np.int64), chunks.first.astype(np.int64) + chunks.count
    bad = np.flatnonzero((first < 0) | (chunks.count < 1) | (end > sizes[surface]))
    if len(bad):
        raise ValueError(
            f"chunk {bad[0]} has triangles {first[bad[0]]} to {end[bad[0]]} of a surface of "
            f"{sizes[surface[bad[0]]]}"
        )
    bad = np.flatnonzero((chunks.room < -1) | (chunks.room >= num_rooms))
    if len(bad):
        raise ValueError(
            f"chunk {bad[0]} is in room {chunks.room[bad[0]]}, there are {num_rooms} rooms"
        )
    starts = np.concatenate([[0], np.cumsum(sizes)])
    order = np.argsort(starts[surface] + first)
    begins, ends = (starts[surface] + first)[order], (starts[surface] + end)[order]
    if not np.array_equal(np.append(begins, starts[-1]), np.insert(ends, 0, 0)):
        raise ValueError(f"chunks do not hold each of {starts[-1]} triangles exactly once")


def chunk_surfaces(
    surfaces: Sequence[Surface], rooms: Sequence[Room] = ()
) -> tuple[tuple[Surface, ...], Chunks]:
    """Orders triangles and vertices by chunk; a chunk is all of closed solids or has none of them.

    A chunk lies in one of `rooms` or has room -1. Vertices that several chunks share are repeated,
    so that drawing a chunk reads memory in order.
    """
    ordered, rows = [], []
    for index, surface in enumerate(surfaces):
        vertices, faces, first, start = [], [], 0, 0
        for chosen, room, solid_box in _parts(surface, rooms):
            used, local = first_use(surface.faces[chosen])
            box = surface.positions[used].min(axis=0), surface.positions[used].max(axis=0)
            rows.append((index, first, len(chosen), room, *box, *solid_box))
            vertices.append(used)
            faces.append(local + start)
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


def first_use(faces: NDArray[Any]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The vertices that faces use, in the order they first do, and the faces over those."""
    used, place, corners = np.unique(faces.reshape(-1), return_index=True, return_inverse=True)
    order = np.argsort(place)
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    return used[order].astype(np.int64), rank[corners.reshape(-1)].reshape(faces.shape)


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


def _parts(
    surface: Surface, rooms: Sequence[Room]
) -> Iterator[tuple[NDArray[np.int64], int, FloatArray]]:
    """Faces of each chunk of a surface, its room, and the box of the solids they belong to."""
    if not len(surface.faces):
        return
    positions = surface.positions.astype(np.float64)
    corners = positions[surface.faces]
    centroids = corners.mean(axis=1)
    closed, boxes = closed_solids(positions, surface.faces.astype(np.int64))
    inside = face_rooms(corners, rooms)
    for room in np.unique(inside).tolist():
        for wanted in (True, False):
            group = np.flatnonzero((inside == room) & (closed == wanted))
            for chosen in split_faces(centroids[group], CHUNK_TRIANGLES):
                if not len(chosen):
                    continue
                box = np.array([[-np.inf] * 3, [np.inf] * 3])
                if wanted:
                    around = boxes[group[chosen]]
                    box = np.array([around[:, 0].min(axis=0), around[:, 1].max(axis=0)])
                yield group[chosen], room, box
