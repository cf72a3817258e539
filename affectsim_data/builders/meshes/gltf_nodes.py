"""The tree of a glTF's nodes: which mesh stands where in the world."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.gltf_document import GltfDocument
from affectsim_data.builders.meshes.limits import MeshLimits
from affectsim_data.poses import FloatArray, quaternion_matrix

__all__ = ["MeshNode", "mesh_nodes"]


@dataclasses.dataclass(frozen=True)
class MeshNode:
    """A node that has a mesh."""

    name: str
    """Its own name, or the mesh's, or its number."""
    mesh: dict[str, Any]
    """The glTF mesh."""
    T_world_node: FloatArray
    """Any affine map, also scaled, sheared or mirrored, `(4, 4)`."""
    skin: int | None
    """Index of its skin, if it has one."""


def mesh_nodes(
    document: GltfDocument, *, limits: MeshLimits, notes: Notes
) -> tuple[list[MeshNode], dict[int, FloatArray]]:
    """Every node of the scene with a mesh, and the pose `(4, 4)` of every node by its index.

    Raises:
        ValueError: A node is its own ancestor, has two parents, or there are too many.
    """
    nodes = document.entries("nodes")
    if len(nodes) > limits.max_nodes:
        raise ValueError(f"{len(nodes)} nodes, more than the {limits.max_nodes} allowed")
    poses: dict[int, FloatArray] = {}
    found: list[MeshNode] = []
    stack = [(index, np.eye(4)) for index in reversed(_roots(document, notes))]
    while stack:
        index, T_world_parent = stack.pop()
        node = document.entry("nodes", index)
        if index in poses:
            raise ValueError(f"nodes[{index}] is reached twice: nodes must be a tree")
        poses[index] = T_world_parent @ _local_pose(node, index)
        if "mesh" in node:
            mesh = document.entry("meshes", node["mesh"])
            name = str(node.get("name") or mesh.get("name") or f"node{index}")
            found.append(MeshNode(name, mesh, poses[index], node.get("skin")))
        for key in ("camera", "weights"):
            if key in node:
                notes[f"node {key} ignored"] += 1
        children = node.get("children", [])
        if not isinstance(children, list):
            raise ValueError(f"nodes[{index}]: children must be an array, got {children!r}")
        stack += [(child, poses[index]) for child in reversed(children)]
    unused = len(nodes) - len(poses)
    if unused:
        notes["nodes outside the default scene ignored"] += unused
    return found, poses


def _roots(document: GltfDocument, notes: Notes) -> list[Any]:
    scenes = document.entries("scenes")
    if scenes:
        roots = document.entry("scenes", document.json.get("scene", 0)).get("nodes", [])
        if not isinstance(roots, list):
            raise ValueError(f"scene nodes must be an array, got {roots!r}")
        return roots
    notes["no scene: all nodes taken"] += 1
    nodes = [node for node in document.entries("nodes") if isinstance(node, dict)]
    children = {child for node in nodes for child in node.get("children", [])}
    return [index for index in range(len(document.entries("nodes"))) if index not in children]


def _local_pose(node: dict[str, Any], index: int) -> FloatArray:
    where = f"nodes[{index}]"
    if "matrix" in node:
        # Stored by columns.
        return _numbers(node, "matrix", where, [0.0] * 16).reshape(4, 4).T
    pose = np.eye(4)
    x, y, z, w = _numbers(node, "rotation", where, [0.0, 0.0, 0.0, 1.0])
    length = np.sqrt(x * x + y * y + z * z + w * w)
    if length < 1e-6:
        raise ValueError(f"{where}: rotation must be a unit quaternion, got zeros")
    pose[:3, :3] = quaternion_matrix(np.array([w, x, y, z]) / length)
    pose[:3, :3] *= _numbers(node, "scale", where, [1.0, 1.0, 1.0])
    pose[:3, 3] = _numbers(node, "translation", where, [0.0, 0.0, 0.0])
    return pose


def _numbers(node: dict[str, Any], key: str, where: str, default: list[float]) -> FloatArray:
    value = node.get(key, default)
    try:
        numbers = np.asarray(value, np.float64)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{where}: {key} must be numbers, got {value!r}") from error
    if numbers.shape != (len(default),) or not np.isfinite(numbers).all():
        raise ValueError(f"{where}: {key} must be {len(default)} finite numbers, got {value!r}")
    return numbers
