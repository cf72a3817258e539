"""What a mesh file holds: parts of one material each, in the axes and units of the file."""

from __future__ import annotations

import collections
import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Surface

__all__ = ["MeshAsset", "MeshPart", "Notes"]

Notes = collections.Counter[str]
"""What was dropped, replaced or not decoded, with how often."""


@dataclasses.dataclass(frozen=True, eq=False)
class MeshPart:
    """The triangles of one material of one node."""

    name: str
    """Unique in its file: node and material."""
    node: str
    """The node of a glTF or the object or group of an OBJ it belongs to; may be empty."""
    material: str
    """Name of its material; may be empty."""
    positions: NDArray[np.float32]
    """Vertices, `(num_vertices, 3)`."""
    normals: NDArray[np.float32]
    """Unit vertex normals, `(num_vertices, 3)`."""
    colors: NDArray[np.uint8]
    """sRGB: base colour times vertex colour, opaque, `(num_vertices, 4)`."""
    faces: NDArray[np.uint32]
    """Triangles, counter-clockwise from outside, `(num_faces, 3)`."""
    uvs: NDArray[np.float32] | None = None
    """Texture coordinates, v down from the top left, `(num_vertices, 2)`."""
    texture: NDArray[np.uint8] | None = None
    """sRGB texture multiplied by the colours, repeated, `(height, width, 3)`; may be shared."""

    def to_surface(self, name: str) -> Surface:
        """The part as a surface of a scene, unlit.

        Args:
            name: Of the surface; unique in its scene.
        """
        return Surface(
            name=name,
            positions=self.positions,
            normals=self.normals,
            colors=self.colors,
            faces=self.faces,
            uvs=self.uvs if self.texture is not None else None,
            texture=self.texture,
        )


@dataclasses.dataclass(frozen=True, eq=False)
class MeshAsset:
    """All triangles of a mesh file, its nodes' poses applied."""

    name: str
    """What messages call it: its path."""
    parts: tuple[MeshPart, ...]
    """At least one, each with at least one triangle."""
    notes: Notes
    """What was dropped, replaced or not decoded, with how often."""

    @property
    def num_triangles(self) -> int:
        """Triangles of all parts."""
        return sum(len(part.faces) for part in self.parts)

    @property
    def bounds(self) -> FloatArray:
        """Lowest and highest corner, `(2, 3)`."""
        low = np.min([part.positions.min(axis=0) for part in self.parts], axis=0)
        high = np.max([part.positions.max(axis=0) for part in self.parts], axis=0)
        return np.stack([low, high]).astype(np.float64)

    @property
    def textures(self) -> tuple[NDArray[np.uint8], ...]:
        """Each texture once, in the order of the parts."""
        found = {id(part.texture): part.texture for part in self.parts}
        return tuple(texture for texture in found.values() if texture is not None)

    def mesh(self) -> tuple[FloatArray, NDArray[np.int64]]:
        """All vertices `(n, 3)` and triangles `(m, 3)` as one mesh."""
        starts = np.cumsum([0, *(len(part.positions) for part in self.parts[:-1])])
        faces = [
            part.faces.astype(np.int64) + k for part, k in zip(self.parts, starts, strict=True)
        ]
        positions = np.concatenate([part.positions for part in self.parts])
        return positions.astype(np.float64), np.concatenate(faces)
