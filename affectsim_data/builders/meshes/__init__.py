"""Mesh files in: GLB, glTF and OBJ with their colours and textures, within bounds."""

from affectsim_data.builders.meshes.asset import MeshAsset, MeshPart, Notes
from affectsim_data.builders.meshes.files import FolderFiles, MeshFiles, ZipFiles
from affectsim_data.builders.meshes.limits import DEFAULT_LIMITS, MeshLimits
from affectsim_data.builders.meshes.reading import MESH_SUFFIXES, read_mesh, read_mesh_from

__all__ = [
    "DEFAULT_LIMITS",
    "MESH_SUFFIXES",
    "FolderFiles",
    "MeshAsset",
    "MeshFiles",
    "MeshLimits",
    "MeshPart",
    "Notes",
    "ZipFiles",
    "read_mesh",
    "read_mesh_from",
]
