"""`read_mesh`: any mesh file this can read, within bounds."""

from __future__ import annotations

import collections
import struct
from pathlib import Path, PurePosixPath

from affectsim_data.builders.meshes.asset import MeshAsset, MeshPart, Notes
from affectsim_data.builders.meshes.files import FolderFiles, MeshFiles
from affectsim_data.builders.meshes.gltf import read_gltf
from affectsim_data.builders.meshes.limits import DEFAULT_LIMITS, MeshLimits
from affectsim_data.builders.meshes.obj import read_obj
from affectsim_data.builders.meshes.shaping import RawPart, shaped

__all__ = ["MESH_SUFFIXES", "read_mesh", "read_mesh_from"]

MESH_SUFFIXES = (".glb", ".gltf", ".obj")
"""Formats by the end of their names."""


def read_mesh(path: Path, *, limits: MeshLimits = DEFAULT_LIMITS) -> MeshAsset:
    """The triangles of a GLB, glTF or OBJ file with their colours and textures.

    In the axes and units of the file, its nodes' poses applied. What cannot be drawn is dropped or
    replaced and counted in `MeshAsset.notes`.

    Args:
        path: The file; what it names must lie in its folder.
        limits: Bounds, checked before anything is allocated.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: Broken, over a limit, or without any triangle; the message starts with `path`.
    """
    path = Path(path)
    if not path.is_file():
        raise FileNotFoundError(f"{path}: there is no such mesh file")
    # A link to the file itself may lead anywhere; what it names is looked for where the link is.
    size = path.stat().st_size
    if size > limits.max_file_bytes:
        raise ValueError(f"{path}: has {size} bytes, more than the {limits.max_file_bytes} allowed")
    return _read(path.read_bytes(), path.name, FolderFiles(path.parent), str(path), limits)


def read_mesh_from(
    files: MeshFiles, name: str, *, label: str, limits: MeshLimits = DEFAULT_LIMITS
) -> MeshAsset:
    """The same from a folder or archive.

    Args:
        files: Where it is, and what it names.
        name: Of the mesh file in there.
        label: What messages call it.
        limits: Bounds.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: See `read_mesh`; the message starts with `label`.
    """
    try:
        payload = files.read(name, limit=limits.max_file_bytes)
    except (FileNotFoundError, ValueError) as error:
        raise type(error)(f"{label}: {error}") from error
    return _read(payload, name, files, label, limits)


def _read(payload: bytes, name: str, files: MeshFiles, label: str, limits: MeshLimits) -> MeshAsset:
    suffix = PurePosixPath(name.replace("\\", "/")).suffix.lower()
    if suffix not in MESH_SUFFIXES:
        raise ValueError(f"{label}: must end in {', '.join(MESH_SUFFIXES)}, got {suffix!r}")
    notes: Notes = collections.Counter()
    try:
        if suffix == ".obj":
            raw = read_obj(payload, files, limits=limits, notes=notes)
        else:
            raw = read_gltf(payload, files, limits=limits, notes=notes)
        parts = _shaped_parts(raw, notes)
    except ValueError as error:
        raise ValueError(f"{label}: {error}") from error
    except (
        KeyError, IndexError, TypeError, AttributeError, OSError, OverflowError, struct.error,
        MemoryError, RecursionError,
    ) as error:  # fmt: skip
        # What a file with wrong types or missing members trips over.
        raise ValueError(f"{label}: broken mesh file: {error!r}") from error
    if not parts:
        dropped = ", ".join(f"{count} {note}" for note, count in notes.items()) or "nothing"
        raise ValueError(f"{label}: has no triangle to draw; dropped: {dropped}")
    return MeshAsset(name=label, parts=tuple(parts), notes=+notes)


def _shaped_parts(raw: list[RawPart], notes: Notes) -> list[MeshPart]:
    parts: list[MeshPart] = []
    taken: collections.Counter[str] = collections.Counter()
    for one in raw:
        plain = ":".join(filter(None, [one.node, one.look.name])) or "part"
        taken[plain] += 1
        name = plain if taken[plain] == 1 else f"{plain}#{taken[plain]}"
        part = shaped(one, name=name, notes=notes)
        if part is not None:
            parts.append(part)
    return parts
