"""A static place: its surfaces, its rooms and what they hold."""

from __future__ import annotations

import dataclasses
import hashlib
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.chunks import Chunks, check_chunks
from affectsim_data.scenes.semantics import Door, Doorway, Room, SceneObject, Seat
from affectsim_data.scenes.surfaces import Surface

__all__ = ["Scene"]


@dataclasses.dataclass(frozen=True, eq=False)
class Scene:
    """A static place: what is drawn, what blocks rays and robots, and its semantics."""

    scene_id: str
    """Unique in a release."""
    surfaces: tuple[Surface, ...]
    """What is drawn, one draw call each."""
    rooms: tuple[Room, ...]
    """At least one."""
    seats: tuple[Seat, ...] = ()
    """Where one can sit."""
    doors: tuple[Door, ...] = ()
    """Leaves, closed ones to knock at and open ones."""
    doorways: tuple[Doorway, ...] = ()
    """Holes between rooms. If there is any, rooms are told to be closed but for these."""
    objects: tuple[SceneObject, ...] = ()
    """Things that stand, lie or hang in it."""
    chunks: Chunks | None = None
    """Runs of triangles to draw; present in a baked scene."""
    source: str = ""
    """Where the scene comes from."""
    licence: str = ""
    """Its licence, SPDX."""

    def __post_init__(self) -> None:
        if not self.surfaces or not any(len(surface.faces) for surface in self.surfaces):
            raise ValueError(f"scene {self.scene_id!r}: has no triangles")
        if not self.rooms:
            raise ValueError(f"scene {self.scene_id!r}: has no room, so nobody can stand in it")
        names = [surface.name for surface in self.surfaces]
        if len(set(names)) != len(names):
            raise ValueError(f"scene {self.scene_id!r}: surface names repeat: {names}")
        if self.chunks is not None:
            try:
                check_chunks(self.chunks, self.surfaces, len(self.rooms))
            except ValueError as error:
                raise ValueError(f"scene {self.scene_id!r}: {error}") from error

    @property
    def num_triangles(self) -> int:
        """Triangles of all surfaces."""
        return sum(len(surface.faces) for surface in self.surfaces)

    def mesh(self) -> tuple[FloatArray, NDArray[np.int64]]:
        """All vertices `(n, 3)` and triangles `(m, 3)` as one mesh: for rays and the navmesh."""
        positions, faces, start = [], [], 0
        for surface in self.surfaces:
            positions.append(surface.positions.astype(np.float64))
            faces.append(surface.faces.astype(np.int64) + start)
            start += len(surface.positions)
        return np.concatenate(positions), np.concatenate(faces)

    def mesh_sha256(self) -> str:
        """Hash of the merged geometry; a navmesh stores it to say what it was built from."""
        vertices, faces = self.mesh()
        digest = hashlib.sha256(vertices.astype("<f4").tobytes())
        digest.update(faces.astype("<u4").tobytes())
        return digest.hexdigest()

    def semantics(self) -> dict[str, Any]:
        """Everything but the geometry, as JSON."""
        return {
            "scene_id": self.scene_id,
            "rooms": [dataclasses.asdict(room) for room in self.rooms],
            "seats": [dataclasses.asdict(seat) for seat in self.seats],
            "doors": [dataclasses.asdict(door) for door in self.doors],
            "doorways": [dataclasses.asdict(doorway) for doorway in self.doorways],
            "objects": [dataclasses.asdict(one) for one in self.objects],
            "source": self.source,
            "licence": self.licence,
        }

    def to_glb(self) -> bytes:
        """A glTF any viewer opens; everything but the geometry is its `extras`."""
        from affectsim_data.scenes.storage import scene_to_glb

        return scene_to_glb(self)

    @classmethod
    def from_glb(cls, payload: bytes, *, name: str) -> Scene:
        """Reads what `to_glb` wrote.

        Raises:
            ValueError: Not such a GLB; the message starts with `name`.
        """
        from affectsim_data.scenes.storage import scene_from_glb

        return scene_from_glb(payload, name=name)
