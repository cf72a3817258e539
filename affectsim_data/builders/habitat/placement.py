"""Where the points of an asset come to lie: frame, scale, rotation, translation, as in Habitat.

The world of Habitat is right-handed, metres, Y up, and its front is -Z: the axes are ours.
"""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.instances import Instance
from affectsim_data.builders.meshes import MeshPart
from affectsim_data.poses import FloatArray, quaternion_matrix
from affectsim_data.scenes import Surface

__all__ = ["AssetFrame", "asset_frame", "place", "placed_surface"]

_UP, _FRONT = (0.0, 1.0, 0.0), (0.0, 0.0, -1.0)
_STAGE_UP, _STAGE_FRONT = (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)
"""What habitat-sim takes a `.glb` stage to have that does not say (Matterport scans)."""
_ORTHOGONAL = 1e-3


@dataclasses.dataclass(frozen=True)
class AssetFrame:
    """How a template turns and scales its asset."""

    rotation: FloatArray
    """Takes directions of the asset into the template's frame, Y up and -Z front, `(3, 3)`."""
    scale: FloatArray
    """Along the axes of that frame, units to metres included, `(3,)`."""
    com: FloatArray | None
    """Centre of mass in that frame before scaling; `None` for the middle of the bounding box."""
    offset: FloatArray
    """Added after scaling: the origin of a stage, `(3,)`."""
    assumed_up: bool = False
    """Whether a stage did not say which way is up."""


def asset_frame(table: Table, *, is_stage: bool) -> AssetFrame:
    """The frame that the attributes of a template give its asset.

    Raises:
        ValueError: A field is wrong; the message names it.
    """
    # habitat-sim knows this default for .glb alone; other formats are Y up.
    assumed = is_stage and "up" not in table and "front" not in table
    assumed = assumed and table.text("render_asset").lower().endswith(".glb")
    up = table.vector("up", _STAGE_UP if assumed else _UP)
    front = table.vector("front", _STAGE_FRONT if assumed else _FRONT)
    scale = table.vector("scale", (1.0, 1.0, 1.0)) * table.number("units_to_meters", 1.0)
    if not scale.all():
        raise ValueError(f"{table.where}: scale times units_to_meters must not be zero")
    return AssetFrame(
        rotation=_frame_rotation(table, up, front),
        scale=scale,
        com=table.vector("COM", (0.0,) * 3) if "COM" in table else None,
        offset=table.vector("origin", (0.0,) * 3) if is_stage else np.zeros(3),
        assumed_up=assumed,
    )


def _frame_rotation(table: Table, up: FloatArray, front: FloatArray) -> FloatArray:
    lengths = float(np.linalg.norm(up)), float(np.linalg.norm(front))
    if min(lengths) < _ORTHOGONAL:
        raise ValueError(f"{table.where}: up and front must not be zero")
    up, front = up / lengths[0], front / lengths[1]
    if abs(float(up @ front)) > _ORTHOGONAL:
        raise ValueError(
            f"{table.where}: up {up.tolist()} and front {front.tolist()} must be at right angles; "
            "give both"
        )
    # Rows: the asset's axes that become our X, Y and Z; -Z is the front.
    return np.stack([np.cross(front, up), up, -front])


def place(instance: Instance, frame: AssetFrame, bounds: FloatArray) -> FloatArray:
    """The map of an asset's points into the world, `(4, 4)`; it may scale and mirror.

    Args:
        instance: Where it stands.
        frame: What its template says.
        bounds: Box of the asset in its own axes, `(2, 3)`.
    """
    scale = instance.scale * frame.scale
    turn = quaternion_matrix(instance.rotation)
    shift = frame.offset
    if instance.com_origin:
        middle = frame.com if frame.com is not None else frame.rotation @ bounds.mean(axis=0)
        shift = shift - scale * middle
    pose = np.eye(4)
    pose[:3, :3] = turn @ (scale[:, None] * frame.rotation)
    pose[:3, 3] = instance.translation + turn @ shift
    return pose


def placed_surface(part: MeshPart, pose: FloatArray, name: str) -> Surface:
    """A part of a mesh in the world; normals and the sense of its triangles stay right."""
    linear = pose[:3, :3]
    positions = part.positions.astype(np.float64) @ linear.T + pose[:3, 3]
    # Cofactors are the inverse transpose times the determinant: fine for flat scales, too.
    cofactors = np.stack([np.cross(linear[(k + 1) % 3], linear[(k + 2) % 3]) for k in range(3)])
    normals = part.normals.astype(np.float64) @ cofactors.T
    faces = part.faces
    if np.linalg.det(linear) < 0.0:
        normals, faces = -normals, faces[:, ::-1]
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    normals[lengths[:, 0] <= 0.0] = (0.0, 1.0, 0.0)
    return Surface(
        name=name,
        positions=positions.astype(np.float32),
        normals=normals.astype(np.float32),
        colors=part.colors,
        faces=np.ascontiguousarray(faces),
        uvs=part.uvs if part.texture is not None else None,
        texture=part.texture,
    )
