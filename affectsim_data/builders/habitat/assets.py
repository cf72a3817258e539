"""The meshes of a scene, each read once, and what was lost on reading them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np

from affectsim_data.builders.habitat.files import DatasetFolder, OutsideError
from affectsim_data.builders.imports import ImportLog
from affectsim_data.builders.meshes import MeshAsset, MeshLimits, MeshPart, read_mesh

__all__ = ["AssetError", "Assets", "MeshReader"]

MeshReader = Callable[[Path], MeshAsset]
OBJECT_LIMITS = MeshLimits(texture_side=1024)
"""A scene has hundreds of textures, and most of its objects are small on screen."""
MAX_TEXTURE_BYTES = 2**31
"""Of all textures of a scene together; later ones become their mean colour."""
_REPLACED = "colour instead"
"""Notes of mesh files on textures that were not decoded hold these words."""


class AssetError(ValueError):
    """A mesh cannot be had.

    Attributes:
        missing: Whether it is not there, rather than broken or refused.
    """

    def __init__(self, message: str, *, missing: bool) -> None:
        super().__init__(message)
        self.missing = missing


class Assets:
    """Reads the meshes that templates name; the same file is read once."""

    def __init__(self, folder: DatasetFolder, log: ImportLog, read: MeshReader | None) -> None:
        self._folder = folder
        self._log = log
        self._read = read or _read_object
        self._known: dict[Path, MeshAsset | AssetError] = {}
        self._texture_bytes = 0
        self.textures = 0
        """Decoded so far."""
        self.replaced = 0
        """Textures that became a plain colour."""

    def get(self, base: Path, name: str, *, asked_by: str) -> MeshAsset:
        """The mesh that a file in `base` calls `name`.

        Raises:
            AssetError: It is not there, outside the dataset, or cannot be read; logged once.
        """
        try:
            path = self._folder.inside(base, name)
        except OutsideError as error:
            self._log.add("skipped", "mesh", name, reason=str(error), asked_by=asked_by)
            raise AssetError("its mesh is outside the dataset", missing=False) from error
        if path not in self._known:
            self._known[path] = self._load(path, asked_by)
        found = self._known[path]
        if isinstance(found, AssetError):
            raise found
        return found

    def _load(self, path: Path, asked_by: str) -> MeshAsset | AssetError:
        where = self._folder.relative(path)
        if not path.is_file():
            self._log.add("missing", "mesh", where, reason="no such file", asked_by=asked_by)
            return AssetError("its mesh is missing", missing=True)
        try:
            asset = self._read(path)
        except (ValueError, OSError) as error:
            text = str(error).replace(str(path), where)
            self._log.add("skipped", "mesh", where, reason=text, asked_by=asked_by)
            return AssetError("its mesh cannot be read", missing=False)
        self._log.add("found", "mesh", where)
        for text, count in asset.notes.items():
            self._log.note(text.replace(str(path), where), count)
            self.replaced += count if _REPLACED in text else 0
        return self._within_budget(asset)

    def _within_budget(self, asset: MeshAsset) -> MeshAsset:
        size = sum(texture.nbytes for texture in asset.textures)
        if self._texture_bytes + size <= MAX_TEXTURE_BYTES:
            self._texture_bytes += size
            self.textures += len(asset.textures)
            return asset
        self.replaced += len(asset.textures)
        text = f"textures beyond {MAX_TEXTURE_BYTES} bytes in a scene, mean colour instead"
        self._log.note(text, len(asset.textures))
        return dataclasses.replace(asset, parts=tuple(_untextured(part) for part in asset.parts))


def _read_object(path: Path) -> MeshAsset:
    return read_mesh(path, limits=OBJECT_LIMITS)


def _untextured(part: MeshPart) -> MeshPart:
    """The part in the mean colour of its texture."""
    if part.texture is None:
        return part
    mean = part.texture.reshape(-1, 3).mean(axis=0) / 255.0
    colors = part.colors.copy()
    colors[:, :3] = np.rint(colors[:, :3] * mean)
    return dataclasses.replace(part, colors=colors, uvs=None, texture=None)
