"""Files on their way: begun by one process, resumed by another, whole and checked or not there."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import os
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from affectsim_data.errors import IntegrityError
from affectsim_data.releases.file_locks import LockTimeoutError, opened, pauses, try_lock
from affectsim_data.releases.manifest import FileEntry

__all__ = [
    "PART_SUFFIX",
    "REMEDY",
    "Content",
    "Delivery",
    "Part",
    "Progress",
    "check",
    "locked_part",
]

PART_SUFFIX = ".partial"
"""Ends the name of an unfinished file."""
Content = Callable[[int], Iterable[bytes]]
"""Gives the bytes of a file from a place on; called with the place."""
Progress = Callable[[int], None]
"""Called with a number of new bytes; a negative one when they had to be thrown away."""

_READ_AT_ONCE = 1 << 20
_STALL_S = 60.0
REMEDY = "what the Hub serves is not what the manifest says; tell the publisher"
"""Way out of a file that is broken at its source."""


@dataclasses.dataclass(frozen=True)
class Delivery:
    """A file to be had."""

    entry: FileEntry
    """What it must be."""
    content: Content
    """Where its bytes come from."""
    label: str
    """What errors call it."""
    progress: Progress | None = None
    """Told of its bytes as they come."""


@dataclasses.dataclass(frozen=True)
class Part:
    """An unfinished file that this caller alone may write."""

    path: Path
    fd: int
    """Open for reading and writing."""

    @property
    def size(self) -> int:
        """Bytes that are there."""
        return os.fstat(self.fd).st_size

    def clear(self) -> None:
        """Empties it."""
        os.ftruncate(self.fd, 0)

    def complete(self, delivery: Delivery) -> None:
        """Writes what it lacks, so that it is what it must be.

        Raises:
            IntegrityError: It became something else; it is empty again.
        """
        most, tell = delivery.entry.bytes, delivery.progress or (lambda _: None)
        if self.size > most:
            self.clear()
        digest, size = self._begun()
        told = 0
        for chunk in delivery.content(size) if size < most else ():
            self._append(chunk[: most + 1 - size])
            digest.update(chunk)
            size, told = size + len(chunk), told + len(chunk)
            tell(len(chunk))
            if size > most:
                break
        try:
            check(delivery.entry, size, digest.hexdigest(), label=delivery.label, remedy=REMEDY)
        except IntegrityError:
            self.clear()
            tell(-told)
            raise

    def _begun(self) -> tuple[hashlib._Hash, int]:
        """Hash and length of what is there; the next write goes behind it."""
        os.lseek(self.fd, 0, os.SEEK_SET)
        digest, length = hashlib.sha256(), 0
        while chunk := os.read(self.fd, _READ_AT_ONCE):
            digest.update(chunk)
            length += len(chunk)
        return digest, length

    def _append(self, chunk: bytes) -> None:
        rest = memoryview(chunk)
        while rest:
            rest = rest[os.write(self.fd, rest) :]


def check(entry: FileEntry, size: int, sha256: str, *, label: str, remedy: str) -> None:
    """Nothing, if a content of this size and hash is what the manifest promises.

    Raises:
        IntegrityError: It is not.
    """
    if size != entry.bytes:
        got = f"truncated: {size} bytes" if size < entry.bytes else f"more than {entry.bytes} bytes"
        raise IntegrityError(label, expected=f"{entry.bytes} bytes", got=got, remedy=remedy)
    if sha256 != entry.sha256:
        expected, got = f"SHA-256 {entry.sha256}", f"SHA-256 {sha256}"
        raise IntegrityError(label, expected=expected, got=got, remedy=remedy)


@contextlib.contextmanager
def locked_part(path: Path, *, done: Callable[[], bool]) -> Iterator[Part | None]:
    """The unfinished file at a path, made if need be, for this caller alone.

    Another process that has it is waited for as long as the file grows. An empty one is removed.

    Args:
        path: The unfinished file.
        done: Whether what it becomes is there already.

    Yields:
        The file, or `None` if somebody else has finished it.

    Raises:
        LockTimeoutError: Another process has it and did not get on with it for a minute.
    """
    size, since = -1, time.monotonic()
    for _ in pauses():
        with opened(path, os.O_RDWR | os.O_CREAT) as fd:
            if try_lock(fd) is not False and _is_at(fd, path):
                if not done():
                    try:
                        yield Part(path, fd)
                    finally:
                        if not os.fstat(fd).st_size and _is_at(fd, path):
                            path.unlink()
                    return
                path.unlink(missing_ok=True)
            if os.fstat(fd).st_size != size:
                size, since = os.fstat(fd).st_size, time.monotonic()
        if done():
            yield None
            return
        if time.monotonic() - since > _STALL_S:
            raise LockTimeoutError(
                f"{path}: another process has not got on with it for {_STALL_S:g} s"
            )


def _is_at(fd: int, path: Path) -> bool:
    """Whether an open file still has its name, which another may have taken away meanwhile."""
    try:
        return os.path.samestat(os.fstat(fd), path.stat())
    except FileNotFoundError:
        return False
