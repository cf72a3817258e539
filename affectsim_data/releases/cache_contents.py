"""What lies in the cache of Hub files: measured, counted, and removed to make room."""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from affectsim_data.releases.file_locks import opened, try_lock
from affectsim_data.releases.part_files import PART_SUFFIX

__all__ = ["Counter", "make_room"]

_ABANDONED_S = 600.0
"""Without locks: how long an unfinished file has not grown when nobody is at it any more."""


class Counter:
    """A number kept in a small open file."""

    def __init__(self, fd: int) -> None:
        self._fd = fd

    @property
    def value(self) -> int | None:
        """The number; `None` if the file holds none."""
        text = os.pread(self._fd, 32, 0)
        return int(text) if text.strip().isdigit() else None

    @value.setter
    def value(self, number: int) -> None:
        # Always as long: one write, so that a crash leaves the old number or the new one.
        os.pwrite(self._fd, b"%020d\n" % max(number, 0), 0)

    def add(self, number: int) -> None:
        """Adds to the number if there is one."""
        value = self.value
        if value is not None:
            self.value = value + number


class _File(NamedTuple):
    used_at: float
    """Time of last use, seconds since the epoch."""
    path: Path
    size: int
    """Bytes it takes from the limit: of a file on its way, what it will have."""


def make_room(objects: Path, limit: int, needed: int, *, own: Path) -> int:
    """Removes files, least recently used first, until `needed` more bytes fit.

    More go than must, a twentieth of the limit, so that this need not be done for every file.

    Args:
        objects: Folder of the files.
        limit: Bytes the cache may hold.
        needed: Bytes to come.
        own: An unfinished file that counts as it is and stays.

    Returns:
        Bytes of what is left, which may be too many: a file in use stays.
    """
    files = sorted(_files(objects, own))
    total = sum(file.size for file in files)
    if total + needed <= limit:
        return total
    for file in files:
        if total + max(needed, limit // 20) <= limit:
            break
        if file.path != own and _removed(file.path):
            total -= file.size
    return total


def _files(objects: Path, own: Path) -> Iterator[_File]:
    folders = objects.iterdir() if objects.is_dir() else ()
    for folder in folders:
        with (
            contextlib.suppress(FileNotFoundError, NotADirectoryError),
            os.scandir(folder) as found,
        ):
            for entry in found:
                with contextlib.suppress(FileNotFoundError):
                    yield _measured(entry, own)


def _measured(entry: os.DirEntry[str], own: Path) -> _File:
    path, stat = Path(entry.path), entry.stat()
    size = stat.st_size
    if entry.name.endswith(PART_SUFFIX) and path != own and not _abandoned(path):
        with contextlib.suppress(ValueError, IndexError):
            size = max(size, int(entry.name.split(".")[1]))
    return _File(stat.st_mtime, path, size)


def _abandoned(part: Path) -> bool:
    """Whether nobody is at an unfinished file."""
    with opened(part, os.O_RDONLY) as fd:
        free = try_lock(fd)
        if free is None:
            return time.time() - os.fstat(fd).st_mtime > _ABANDONED_S
        return free


def _removed(path: Path) -> bool:
    """Whether a file that nobody uses is gone now."""
    try:
        with opened(path, os.O_RDWR) as fd:
            free = try_lock(fd)
            if free is None:
                free = not path.name.endswith(PART_SUFFIX) or _abandoned(path)
            if free:
                path.unlink()
            return free
    except FileNotFoundError:
        return True
    except OSError:  # of another user, or a folder
        return False
