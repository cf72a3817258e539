"""How much a mesh file may make this program read, allocate and draw."""

from __future__ import annotations

import dataclasses

__all__ = ["DEFAULT_LIMITS", "MeshLimits"]


@dataclasses.dataclass(frozen=True)
class MeshLimits:
    """Bounds that are checked against counts and headers, before anything is allocated."""

    max_file_bytes: int = 2**30
    """Of a file and of all buffers it names together."""
    max_json_bytes: int = 2**26
    """Of the JSON of a glTF and the text of an MTL."""
    max_nodes: int = 100_000
    """Nodes of a glTF, materials and groups of an OBJ."""
    max_triangles: int = 8_000_000
    """Of all instances together."""
    max_vertices: int = 24_000_000
    """Of all instances together."""
    max_texture_side: int = 8192
    """Pixels a side, as the header of the image says."""
    texture_side: int = 2048
    """Larger textures are scaled down to this on reading, pixels a side."""
    max_texture_bytes: int = 2**30
    """Of all decoded textures of a file together; the rest become their base colour."""


DEFAULT_LIMITS = MeshLimits()
"""What `read_mesh` allows unless told otherwise."""
