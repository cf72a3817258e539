"""The stored form of a navmesh: little-endian bytes, checked on the way in.

Layout: `AFNM`, version, the settings it was built with, the hash of the mesh, then per island its
base height, the corner of its height grid, its rings and its heights as runs along the rows.
"""

from __future__ import annotations

import dataclasses
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.navmesh.islands import Island
from affectsim_data.navmesh.settings import Settings

__all__ = ["pack", "unpack"]

MAGIC = b"AFNM"
VERSION = 1
MAX_ISLANDS = 1 << 12
MAX_RINGS = 1 << 16
MAX_CORNERS = 1 << 20
MAX_HEIGHTS = 1 << 24
HEADER = struct.Struct("<4sHH6d64sI")
ISLAND = struct.Struct("<3dIIII")


def pack(settings: Settings, mesh_sha256: str, islands: tuple[Island, ...]) -> bytes:
    """Bytes that `unpack` turns into equal settings, hash and islands."""
    numbers = dataclasses.astuple(settings)
    parts = [HEADER.pack(MAGIC, VERSION, 0, *numbers, mesh_sha256.encode("ascii"), len(islands))]
    for island in islands:
        depth, width = island.heights.shape
        value, count = _runs(island.heights.reshape(-1))
        place = (island.base_y, *island.height_origin)
        parts.append(ISLAND.pack(*place, len(island.rings), depth, width, len(value)))
        parts.append(np.array([len(ring) for ring in island.rings], "<u4").tobytes())
        parts += [ring.astype("<f4").tobytes() for ring in island.rings]
        parts += [value.astype("<i2").tobytes(), count.astype("<u4").tobytes()]
    return b"".join(parts)


def unpack(payload: bytes, *, name: str) -> tuple[Settings, str, tuple[Island, ...]]:
    """Settings, hash of the mesh, and islands.

    Args:
        payload: What `pack` made.
        name: Starts error messages, for example a file name.

    Raises:
        ValueError: Not such bytes, cut short, or beyond the limits of the format.
    """
    reader = _Reader(payload, name)
    magic, version, _, *numbers, digest, num_islands = reader.fields(HEADER)
    if magic != MAGIC:
        raise ValueError(f"{name}: not a navmesh: starts with {magic!r}, expected {MAGIC!r}")
    if version != VERSION:
        raise ValueError(f"{name}: navmesh version {version}; this code reads version {VERSION}")
    reader.check("islands", num_islands, MAX_ISLANDS)
    try:
        settings = Settings(*numbers)
        mesh_sha256 = digest.rstrip(b"\0").decode("ascii")
        islands = tuple(_island(reader, settings.cell_size) for _ in range(num_islands))
    except ValueError as error:
        message = str(error)
        raise ValueError(message if message.startswith(name) else f"{name}: {message}") from error
    reader.finish()
    return settings, mesh_sha256, islands


class _Reader:
    """Takes typed pieces off the front of bytes, never more than there are."""

    def __init__(self, payload: bytes, name: str) -> None:
        self.payload = payload
        self.name = name
        self.offset = 0

    def take(self, size: int) -> bytes:
        end = self.offset + size
        if end > len(self.payload):
            raise ValueError(
                f"{self.name}: navmesh is cut short: needs {end} bytes, got {len(self.payload)}"
            )
        piece = self.payload[self.offset : end]
        self.offset = end
        return piece

    def fields(self, layout: struct.Struct) -> tuple[Any, ...]:
        return layout.unpack(self.take(layout.size))

    def array(self, dtype: str, count: int) -> NDArray[Any]:
        return np.frombuffer(self.take(count * np.dtype(dtype).itemsize), dtype)

    def check(self, what: str, count: int, limit: int) -> None:
        if not 1 <= count <= limit:
            raise ValueError(f"{self.name}: number of {what} must be 1 to {limit}, got {count}")

    def finish(self) -> None:
        extra = len(self.payload) - self.offset
        if extra:
            raise ValueError(f"{self.name}: {extra} bytes follow the navmesh")


def _island(reader: _Reader, cell_size: float) -> Island:
    *place, num_rings, depth, width, num_runs = reader.fields(ISLAND)
    reader.check("rings", num_rings, MAX_RINGS)
    reader.check("heights", depth * width, MAX_HEIGHTS)
    reader.check("runs of heights", num_runs, depth * width)
    sizes = reader.array("<u4", num_rings).astype(np.int64)
    reader.check("corners", int(sizes.sum()), MAX_CORNERS)
    if int(sizes.min()) < 3:
        raise ValueError(f"a ring needs 3 corners, got {int(sizes.min())}")
    rings = tuple(
        reader.array("<f4", 2 * int(size)).reshape(-1, 2).astype(np.float32) for size in sizes
    )
    value = reader.array("<i2", num_runs).astype(np.int16)
    count = reader.array("<u4", num_runs).astype(np.int64)
    if int(count.sum()) != depth * width:
        raise ValueError(f"heights must fill {depth} x {width} cells, got {int(count.sum())}")
    if not (np.all(np.isfinite(place)) and all(np.all(np.isfinite(ring)) for ring in rings)):
        raise ValueError("a corner or height is not finite")
    base_y, origin_x, origin_z = place
    heights = np.repeat(value, count).reshape(depth, width)
    return Island(rings, heights, (origin_x, origin_z), base_y, cell_size)


def _runs(values: NDArray[np.int16]) -> tuple[NDArray[np.int16], NDArray[np.int64]]:
    """Values and lengths of runs of equal values."""
    first = np.flatnonzero(np.concatenate([[True], values[1:] != values[:-1]]))
    return values[first], np.diff(np.append(first, len(values)))
