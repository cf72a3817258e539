"""Where a mesh file and what it names are read from: its folder, or a zip archive."""

from __future__ import annotations

import dataclasses
import functools
import os
import re
import zipfile
import zlib
from pathlib import Path, PurePosixPath
from typing import Protocol

__all__ = ["FolderFiles", "MeshFiles", "ZipFiles", "safe_name"]

_SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]*:")


class MeshFiles(Protocol):
    """The files a mesh may name: those in its own folder and below."""

    def read(self, name: str, *, limit: int) -> bytes:
        """The bytes of a file.

        Raises:
            FileNotFoundError: There is no such file.
            ValueError: It lies outside, or has more than `limit` bytes.
        """
        ...


def safe_name(name: str) -> str:
    """A relative name with forward slashes that cannot leave its folder.

    Raises:
        ValueError: It is absolute, has `..` in it or names another scheme or drive.
    """
    forward = name.strip().replace("\\", "/")
    parts = PurePosixPath(forward).parts
    if not parts or "\0" in forward:
        raise ValueError(f"{name!r} names no file")
    if forward.startswith("/") or ".." in parts or _SCHEME.match(forward):
        raise ValueError(f"{name!r} is outside the folder of the file that names it")
    return str(PurePosixPath(*parts))


def _check_size(name: str, size: int, limit: int) -> None:
    if size > limit:
        raise ValueError(f"{name} has {size} bytes, more than the {limit} allowed")


@dataclasses.dataclass(frozen=True)
class FolderFiles:
    """Files in a folder on disk; links that lead out of it are refused."""

    folder: Path
    """All names are relative to it."""

    def read(self, name: str, *, limit: int) -> bytes:
        """See `MeshFiles.read`."""
        safe = safe_name(name)
        path = self.folder / safe
        if not path.resolve().is_relative_to(self.folder.resolve()):
            raise ValueError(f"{safe} is a link that leads out of {self.folder}")
        if not path.is_file():
            raise FileNotFoundError(f"{safe} is not there")
        with path.open("rb") as file:
            payload = file.read(limit + 1)
        _check_size(safe, max(len(payload), path.stat().st_size), limit)
        return payload


@functools.lru_cache(maxsize=8)
def _archive(path: Path, process: int) -> zipfile.ZipFile:
    """An open archive, one per process: its table takes longer to read than most members."""
    return zipfile.ZipFile(path)


@dataclasses.dataclass(frozen=True)
class ZipFiles:
    """Files in one folder of a zip archive, read without unpacking it."""

    archive: Path
    """The zip."""
    folder: str = ""
    """All names are relative to it."""

    def read(self, name: str, *, limit: int) -> bytes:
        """See `MeshFiles.read`."""
        safe = safe_name(name)
        try:
            archive = _archive(self.archive, os.getpid())
            entry = archive.getinfo(str(PurePosixPath(self.folder) / safe))
            _check_size(safe, entry.file_size, limit)
            with archive.open(entry) as file:
                # The header may lie about the size; reading stops whatever it says.
                payload = file.read(limit + 1)
        except KeyError as error:
            raise FileNotFoundError(f"{safe} is not there") from error
        except (zipfile.BadZipFile, zlib.error, NotImplementedError, RuntimeError) as error:
            # Broken, of an unknown compression, or encrypted.
            raise ValueError(f"{safe} cannot be unpacked: {error}") from error
        _check_size(safe, len(payload), limit)
        return payload
