"""Plain solids as mesh parts: shapes of a URDF, and boxes that stand for objects without a mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.builders.meshes import MeshPart

__all__ = ["box_part", "cylinder_part", "sphere_part", "with_color"]

Rgb = tuple[int, int, int]
_GREY: Rgb = (196, 198, 200)


def box_part(size: ArrayLike, *, color: Rgb = _GREY) -> MeshPart:
    """A box about the origin with these sides, metres."""
    import trimesh

    return _flat("box", trimesh.creation.box(extents=np.asarray(size, np.float64)), color)


def cylinder_part(radius: float, length: float) -> MeshPart:
    """A cylinder about the origin along Z, as in a URDF."""
    import trimesh

    return _flat("cylinder", trimesh.creation.cylinder(radius, height=length, sections=24), _GREY)


def sphere_part(radius: float) -> MeshPart:
    """A sphere about the origin."""
    import trimesh

    return _flat("sphere", trimesh.creation.icosphere(subdivisions=2, radius=radius), _GREY)


def with_color(part: MeshPart, color: Rgb, name: str) -> MeshPart:
    """The triangles of a part in one plain colour."""
    colors = np.full((len(part.positions), 4), (*color, 255), np.uint8)
    return MeshPart(name, part.node, "", part.positions, part.normals, colors, part.faces)


def _flat(name: str, mesh: object, color: Rgb) -> MeshPart:
    """A trimesh as a part with a normal of its own for every face."""
    vertices: NDArray[np.float64] = np.asarray(mesh.vertices)  # type: ignore[attr-defined]  # untyped library
    faces: NDArray[np.int64] = np.asarray(mesh.faces)  # type: ignore[attr-defined]  # untyped library
    corners = vertices[faces].astype(np.float32)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    count = 3 * len(faces)
    return MeshPart(
        name=name,
        node="",
        material="",
        positions=corners.reshape(-1, 3),
        normals=np.repeat(normals, 3, axis=0).astype(np.float32),
        colors=np.full((count, 4), (*color, 255), np.uint8),
        faces=np.arange(count, dtype=np.uint32).reshape(-1, 3),
    )
