"""Assets as rows of their tables, and back."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.motions.motion import Motion, Uncut
from affectsim_data.scenes import Scene
from affectsim_data.schemas import array_columns, read_array

if TYPE_CHECKING:
    from affectsim_data.navmesh import NavMesh

__all__ = ["avatar_row", "motion_row", "navmesh_sha256", "read_motion", "scene_row"]

_MOTION_FIELDS = (
    *("motion_id", "performer_id", "group_id", "emotion", "action", "fps"),
    *("performance", "take", "source", "licence"),
)
_MOTION_ARRAYS = ("root_translation", "joint_rotations")


def motion_row(motion: Motion) -> dict[str, Any]:
    """The row of the motions table; arrays become float32."""
    row = {name: getattr(motion, name) for name in (*_MOTION_FIELDS, "num_frames", "duration_s")}
    for name in _MOTION_ARRAYS:
        row |= array_columns(name, getattr(motion, name).astype("<f4"))
    uncut = motion.uncut
    row["provenance"] = json.dumps(motion.provenance, sort_keys=True)
    row["original_before"] = uncut.before if uncut else 0
    row["kept_start"] = uncut.start if uncut else 0
    row["kept_stop"] = uncut.stop if uncut else motion.num_frames
    for name in _MOTION_ARRAYS:
        lacking = getattr(uncut, name) if uncut else getattr(motion, name)[:0]
        row |= array_columns(f"original_{name}", lacking.astype("<f4"))
    return row


def read_motion(row: dict[str, Any], where: str) -> Motion:
    """The motion of a row; `where` names the row in errors.

    Raises:
        ValueError: An array is malformed or not finite, or the provenance is no JSON object.
    """
    fields: dict[str, Any] = {name: row[name] for name in _MOTION_FIELDS}
    for name in _MOTION_ARRAYS:
        fields[name] = read_array(row, name, where=where).astype(np.float64)
    fields["provenance"] = _read_provenance(row["provenance"], where)
    return Motion(**fields, uncut=_read_uncut(row, where))


def _read_provenance(text: str, where: str) -> dict[str, Any]:
    try:
        provenance = json.loads(text)
    except json.JSONDecodeError as error:
        raise ValueError(f"{where}: provenance must be JSON, got {text[:40]!r}") from error
    if not isinstance(provenance, dict):
        raise ValueError(f"{where}: provenance must be a JSON object, got {text[:40]!r}")
    return provenance


def _read_uncut(row: dict[str, Any], where: str) -> Uncut | None:
    """How to undo the loop; none if the cycle is the original. Frames stay float32: few ask."""
    root, rotations = (read_array(row, f"original_{name}", where=where) for name in _MOTION_ARRAYS)
    whole = (0, 0, row["num_frames"])
    kept = row["original_before"], row["kept_start"], row["kept_stop"]
    if not len(root) and kept == whole:
        return None
    try:
        return Uncut(*kept, root_translation=root, joint_rotations=rotations)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def navmesh_sha256(navmesh: NavMesh) -> str:
    """Hash of a navmesh's stored bytes: names what an episode's distances were measured on."""
    return hashlib.sha256(navmesh.to_bytes()).hexdigest()


def scene_row(scene: Scene, navmesh: NavMesh) -> dict[str, Any]:
    """The row of the scenes table."""
    return {
        "scene_id": scene.scene_id,
        "glb": scene.to_glb(),
        "num_triangles": scene.num_triangles,
        "rooms": [room.purpose for room in scene.rooms],
        "num_seats": len(scene.seats),
        "num_doors": len(scene.doors),
        "area_m2": navmesh.area_m2,
        "navmesh": navmesh.to_bytes(),
        "navmesh_sha256": navmesh_sha256(navmesh),
        "mesh_sha256": scene.mesh_sha256(),
        "agent_radius_m": navmesh.settings.agent_radius,
        "source": scene.source,
        "licence": scene.licence,
    }


def avatar_row(avatar: Avatar) -> dict[str, Any]:
    """The row of the avatars table."""
    mesh = avatar.mesh()
    return {
        "avatar_id": avatar.avatar_id,
        "glb": avatar.to_glb(),
        "height_m": float(np.ptp(mesh.positions[:, 1])),
        "num_triangles": len(mesh.faces),
        "source": avatar.source,
        "licence": avatar.licence,
    }
