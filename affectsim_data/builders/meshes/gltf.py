"""glTF 2.0 and GLB to raw parts in world axes."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.files import MeshFiles
from affectsim_data.builders.meshes.gltf_document import GltfDocument
from affectsim_data.builders.meshes.gltf_materials import GltfMaterials
from affectsim_data.builders.meshes.gltf_nodes import MeshNode, mesh_nodes
from affectsim_data.builders.meshes.images import Textures
from affectsim_data.builders.meshes.limits import MeshLimits
from affectsim_data.builders.meshes.looks import linear_to_srgb
from affectsim_data.builders.meshes.shaping import RawPart
from affectsim_data.poses import FloatArray

__all__ = ["read_gltf"]

_READ = {
    "KHR_texture_basisu", "KHR_texture_transform", "EXT_texture_webp", "KHR_mesh_quantization",
    "KHR_materials_pbrSpecularGlossiness", "KHR_materials_transmission",
}  # fmt: skip
_HARMLESS = {
    "KHR_materials_unlit", "KHR_materials_clearcoat", "KHR_materials_ior", "KHR_materials_sheen",
    "KHR_materials_specular", "KHR_materials_emissive_strength", "KHR_materials_volume",
    "KHR_xmp_json_ld", "KHR_materials_anisotropy", "KHR_materials_iridescence",
}  # fmt: skip
"""They change how a surface shines, not what it is."""
_MODES = {0: "points", 1: "lines", 2: "lines", 3: "lines"}
_TRIANGLES, _STRIP, _FAN = 4, 5, 6


def read_gltf(
    payload: bytes, files: MeshFiles, *, limits: MeshLimits, notes: Notes
) -> list[RawPart]:
    """The parts of a glTF or GLB, its nodes' poses applied.

    Raises:
        ValueError: Broken, over a limit, or it needs an extension this cannot read.
    """
    document = GltfDocument(payload, files, limits=limits)
    _check_extensions(document, notes)
    nodes, poses = mesh_nodes(document, limits=limits, notes=notes)
    _check_counts(document, nodes, limits)
    textures = Textures(limits=limits, notes=notes)
    materials = GltfMaterials(document, textures, notes=notes)
    parts = []
    for node in nodes:
        if node.skin is not None:
            notes["skinned meshes in their rest pose"] += 1
        for primitive in _primitives(node):
            part = _raw_part(document, primitive, node, poses, materials, notes)
            if part is not None:
                parts.append(part)
    return parts


def _check_extensions(document: GltfDocument, notes: Notes) -> None:
    required = {str(name) for name in document.entries("extensionsRequired")}
    unread = sorted(required - _READ - _HARMLESS)
    if unread:
        raise ValueError(
            f"it needs {', '.join(unread)}, which cannot be read; convert the file, for example "
            "with `gltf-transform copy` after `gltf-transform dequantize` or decompression"
        )
    for name in document.entries("extensionsUsed"):
        if str(name) not in _READ | _HARMLESS:
            notes[f"extension {name} ignored"] += 1


def _primitives(node: MeshNode) -> list[dict[str, Any]]:
    primitives = node.mesh.get("primitives", [])
    if not isinstance(primitives, list) or not all(isinstance(one, dict) for one in primitives):
        raise ValueError(f"the mesh of node {node.name!r} must have an array of primitives")
    return primitives


def _check_counts(document: GltfDocument, nodes: list[MeshNode], limits: MeshLimits) -> None:
    """Counts as the accessors state them, before any of them is decoded."""
    num_triangles = num_vertices = 0
    for node in nodes:
        for primitive in _primitives(node):
            count = document.count(primitive.get("attributes", {}).get("POSITION"))
            num_vertices += count
            if "indices" in primitive:
                count = document.count(primitive["indices"])
            mode = primitive.get("mode", _TRIANGLES)
            num_triangles += count // 3 if mode == _TRIANGLES else count
    if num_triangles > limits.max_triangles or num_vertices > limits.max_vertices:
        raise ValueError(
            f"it has {num_triangles} triangles and {num_vertices} vertices, more than the "
            f"{limits.max_triangles} and {limits.max_vertices} allowed; decimate it first"
        )


def _raw_part(
    document: GltfDocument, primitive: dict[str, Any], node: MeshNode,
    poses: dict[int, FloatArray], materials: GltfMaterials, notes: Notes,
) -> RawPart | None:  # fmt: skip
    attributes, mode = primitive["attributes"], primitive.get("mode", _TRIANGLES)
    if mode in _MODES:
        notes[f"primitives of {_MODES[mode]} dropped"] += 1
        return None
    if "targets" in primitive:
        notes["morph targets ignored"] += 1
    positions = _attribute(document, attributes, "POSITION", 3)
    assert positions is not None
    faces = _faces(document, primitive, mode, len(positions))
    normals = _attribute(document, attributes, "NORMAL", 3, like=positions)
    if node.skin is None:
        positions, normals, faces = _moved(node.T_world_node, positions, normals, faces)
    else:
        positions, normals = _skinned(document, attributes, node.skin, poses, positions, normals)
    look = materials.look(primitive.get("material"))
    uvs = _attribute(document, attributes, f"TEXCOORD_{look.uv_set}", 2, like=positions)
    colors = _attribute(document, attributes, "COLOR_0", None, like=positions)
    return RawPart(
        node.name, look, positions, faces, normals, uvs,
        None if colors is None else _srgb_colors(colors),
    )  # fmt: skip


def _attribute(
    document: GltfDocument, attributes: dict[str, Any], key: str, width: int | None,
    *, like: FloatArray | None = None,
) -> FloatArray | None:  # fmt: skip
    """A vertex attribute as float64, or none where there is none."""
    if key not in attributes:
        if key == "POSITION":
            raise ValueError("a primitive has no POSITION")
        return None
    values = document.array(attributes[key])
    if width is not None and values.shape[1] != width:
        raise ValueError(f"{key} must be ({len(values)}, {width}), got {values.shape}")
    if like is not None and len(values) != len(like):
        raise ValueError(f"{key} has {len(values)} elements for {len(like)} vertices")
    if key.startswith("COLOR") and values.dtype.kind == "u":
        values = values / np.iinfo(values.dtype).max
    return values.astype(np.float64)


def _srgb_colors(colors: FloatArray) -> FloatArray:
    """Linear colours of three or four channels as sRGB and opacity, `(n, 4)`."""
    if colors.shape[1] not in (3, 4):
        raise ValueError(f"COLOR_0 must have 3 or 4 channels, got {colors.shape[1]}")
    opacity = colors[:, 3:] if colors.shape[1] == 4 else np.ones((len(colors), 1))
    return np.concatenate([linear_to_srgb(colors[:, :3]), opacity], axis=1)


def _faces(
    document: GltfDocument, primitive: dict[str, Any], mode: Any, num_vertices: int
) -> NDArray[np.int64]:
    if "indices" in primitive:
        indices = document.array(primitive["indices"])
        if indices.shape[1] != 1 or indices.dtype.kind != "u":
            raise ValueError(f"indices must be unsigned scalars, got {indices.dtype}")
        indices = indices[:, 0].astype(np.int64)
    else:
        indices = np.arange(num_vertices, dtype=np.int64)
    if len(indices) and int(indices.max()) >= num_vertices:
        raise ValueError(f"index {int(indices.max())} is beyond its {num_vertices} vertices")
    if mode == _TRIANGLES:
        return indices[: len(indices) // 3 * 3].reshape(-1, 3)
    if mode == _STRIP:
        strip = np.stack([indices[:-2], indices[1:-1], indices[2:]], axis=1)
        strip[1::2] = strip[1::2, [1, 0, 2]]
        return strip
    if mode == _FAN:
        first = np.broadcast_to(indices[:1], (max(len(indices) - 2, 0),))
        return np.stack([first, indices[1:-1], indices[2:]], axis=1)
    raise ValueError(f"primitive mode must be 0 to 6, got {mode!r}")


def _moved(
    pose: FloatArray, positions: FloatArray, normals: FloatArray | None, faces: NDArray[np.int64]
) -> tuple[FloatArray, FloatArray | None, NDArray[np.int64]]:
    """Positions, normals and winding in the world; a mirrored node turns its triangles round."""
    linear = pose[:3, :3]
    determinant = float(np.linalg.det(linear))
    if determinant < 0.0:
        faces = faces[:, ::-1]
    if normals is not None:
        # Cofactors, so that a flat scale needs no inverse; their sign is that of the determinant.
        cofactors = np.stack([np.cross(linear[(i + 1) % 3], linear[(i + 2) % 3]) for i in range(3)])
        normals = normals @ cofactors.T * (1.0 if determinant >= 0.0 else -1.0)
    with np.errstate(invalid="ignore", over="ignore"):
        moved = positions @ linear.T + pose[:3, 3]
    return moved, normals, faces


def _skinned(
    document: GltfDocument, attributes: dict[str, Any], skin: int, poses: dict[int, FloatArray],
    positions: FloatArray, normals: FloatArray | None,
) -> tuple[FloatArray, FloatArray | None]:  # fmt: skip
    """A skinned mesh as its joints stand; its own node's pose does not count."""
    entry = document.entry("skins", skin)
    joints = [poses.get(joint, np.eye(4)) for joint in entry.get("joints", [])]
    matrices = np.stack(joints)
    if "inverseBindMatrices" in entry:
        inverse = document.array(entry["inverseBindMatrices"])
        matrices = matrices @ np.swapaxes(inverse.reshape(-1, 4, 4), 1, 2)[: len(joints)]
    numbers = document.array(attributes["JOINTS_0"]).astype(np.int64)
    weights = document.array(attributes["WEIGHTS_0"]).astype(np.float64)
    if int(numbers.max(initial=0)) >= len(matrices):
        raise ValueError(f"skins[{skin}] has {len(matrices)} joints, JOINTS_0 names more")
    blend = np.einsum("nk,nkij->nij", weights, matrices[numbers])
    moved = np.einsum("nij,nj->ni", blend[:, :3, :3], positions) + blend[:, :3, 3]
    if normals is not None:
        normals = np.einsum("nij,nj->ni", blend[:, :3, :3], normals)
    return moved, normals
