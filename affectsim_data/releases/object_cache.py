"""Files of releases kept on this machine by the hash of their content, up to a number of bytes.

A cache is a folder that any number of processes share:

    objects/ab/SHA256                  a whole, checked file; its mtime is its last use
    objects/ab/SHA256.BYTES.partial    one on its way, locked by the process that fetches it
    size                               bytes of the above; locked while files come and go

The counter in `size` is never too low: what a file will need is added before its first byte is
written. What a killed process had added for nothing is found when room is made, which measures.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import os
import uuid
from collections.abc import Iterator
from pathlib import Path

from affectsim_data.errors import CacheError, IntegrityError
from affectsim_data.releases.cache_contents import Counter, make_room
from affectsim_data.releases.cache_limits import LIMIT_VARIABLE
from affectsim_data.releases.file_locks import LockTimeoutError, exclusive, opened, try_lock
from affectsim_data.releases.manifest import FileEntry
from affectsim_data.releases.part_files import PART_SUFFIX, Delivery, Part, check, locked_part

__all__ = ["CacheBypass", "ObjectCache"]

_READ_ONLY = {errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOTDIR}
_FULL = {errno.ENOSPC, errno.EDQUOT}
_PATIENCE_S = 20.0
_REMEDY = "the local copy is damaged and the Hub cannot be reached; check the network"


class CacheBypass(CacheError):  # not a failure: the content can be had without it
    """The cache cannot take a file now: it is read-only, or all it holds is in use."""


class ObjectCache:
    """A folder of files by hash, at most `max_bytes` of them; the least recently used go first."""

    def __init__(self, root: Path, *, max_bytes: int) -> None:
        self.root = root
        self.max_bytes = max_bytes
        self._measured = False
        self._locks_work: bool | None = None

    def path(self, entry: FileEntry) -> Path:
        """Where the content of an entry is, if it is here."""
        return self.root / "objects" / entry.sha256[:2] / entry.sha256

    def has(self, entry: FileEntry) -> bool:
        """Whether a file of this name and size is here; `read` checks its content."""
        try:
            return self.path(entry).stat().st_size == entry.bytes
        except OSError:
            return False

    def read(self, entry: FileEntry, *, label: str) -> bytes | None:
        """The content of an entry, checked; `None` if it is not here.

        Args:
            entry: What to read.
            label: What errors call it.

        Raises:
            IntegrityError: What was here is damaged; it is removed where that is possible.
        """
        try:
            with opened(self.path(entry), os.O_RDONLY) as fd:
                # A file in use is not removed; where locks are missing, its content outlives it.
                with contextlib.suppress(OSError):
                    try_lock(fd, shared=True)
                with contextlib.suppress(OSError):
                    os.utime(fd)
                payload = _contents_of(fd, entry.bytes + 1)
        except (FileNotFoundError, NotADirectoryError):
            return None
        except OSError as error:
            if error.errno == errno.ESTALE:  # removed by another machine of a network folder
                return None
            raise
        try:
            digest = hashlib.sha256(payload).hexdigest()
            check(entry, len(payload), digest, label=label, remedy=_REMEDY)
        except IntegrityError:
            self._discard(entry)
            raise
        return payload

    def _discard(self, entry: FileEntry) -> None:
        with contextlib.suppress(OSError), self._counter() as counter:
            size = self.path(entry).stat().st_size
            self.path(entry).unlink()
            counter.add(-size)

    def store(self, delivery: Delivery) -> None:
        """Has a file here; what another process is fetching is waited for.

        Raises:
            CacheBypass: The cache is read-only, or all it holds is in use.
            CacheError: The file is larger than the cache may be, or the disk is full.
            IntegrityError: The file is not what it must be; nothing is kept of it.
        """
        entry = delivery.entry
        if entry.bytes > self.max_bytes:
            raise CacheError(
                f"{delivery.label} has {entry.bytes} bytes, more than all of the cache "
                f"{self.root} may hold: {self.max_bytes}; set {LIMIT_VARIABLE} to more"
            )
        with self._clear_errors(delivery.label):
            self.path(entry).parent.mkdir(parents=True, exist_ok=True)
            with locked_part(self._part_path(entry), done=lambda: self.has(entry)) as part:
                if part is not None:
                    self._fill(part, delivery)

    def _part_path(self, entry: FileEntry) -> Path:
        """Of an unfinished file; without locks each attempt has one of its own."""
        own = "" if self._has_locks() else f".{uuid.uuid4().hex[:12]}"
        return self.path(entry).with_name(f"{entry.sha256}.{entry.bytes}{own}{PART_SUFFIX}")

    def _has_locks(self) -> bool:
        """Whether the file system has locks; found out once.

        Not a `cached_property`: in Python 3.11 that holds a lock meanwhile, which a child forked
        at this moment would find locked for ever.
        """
        if self._locks_work is None:
            with opened(self._size_path, os.O_RDWR | os.O_CREAT) as fd:
                self._locks_work = try_lock(fd, shared=True) is not None
        return self._locks_work

    @contextlib.contextmanager
    def _counter(self) -> Iterator[Counter]:
        """The counter of bytes, for this caller alone."""
        with exclusive(self._size_path, patience_s=_PATIENCE_S) as fd:
            yield Counter(fd)

    def _fill(self, part: Part, delivery: Delivery) -> None:
        """Completes an unfinished file and gives it its name."""
        entry, begun = delivery.entry, part.size
        self._reserve(max(entry.bytes - begun, 0), part.path, delivery.label)
        try:
            part.complete(delivery)
        except BaseException as error:
            if not self._has_locks() or (isinstance(error, OSError) and error.errno in _FULL):
                part.clear()  # nobody would find it, or it is in the way
            with contextlib.suppress(OSError), self._counter() as counter:
                counter.add(part.size - max(entry.bytes, begun))
            raise
        with self._counter() as counter:
            if self.has(entry):  # without locks, another may have been faster
                counter.add(-entry.bytes)
            part.path.replace(self.path(entry))

    def _reserve(self, needed: int, own: Path, label: str) -> None:
        """Adds bytes to come to the counter, after making room for them."""
        with self._counter() as counter:
            total = counter.value
            if total is None or not self._measured or total + needed > self.max_bytes:
                total = make_room(self.root / "objects", self.max_bytes, needed, own=own)
                self._measured = True
            if total + needed > self.max_bytes:
                counter.value = total
                raise CacheBypass(
                    f"{label}: no room in the cache {self.root} for {needed} bytes: all of the "
                    f"{total} it holds are in use; set {LIMIT_VARIABLE} to more than "
                    f"{self.max_bytes}"
                )
            counter.value = total + needed

    @contextlib.contextmanager
    def _clear_errors(self, label: str) -> Iterator[None]:
        try:
            yield
        except LockTimeoutError as error:
            raise CacheBypass(f"{label}: {error}; is that process stopped?") from error
        except OSError as error:
            if error.errno in _READ_ONLY:
                raise CacheBypass(
                    f"{label} is not in the cache {self.root}, which cannot be written to "
                    f"({error.strerror}); set AFFECTSIM_CACHE to a folder that can"
                ) from error
            if error.errno in _FULL:
                raise CacheError(
                    f"{label} does not fit on the disk of the cache {self.root} "
                    f"({error.strerror}); make room there, or set AFFECTSIM_CACHE to a larger disk"
                ) from error
            raise

    @property
    def _size_path(self) -> Path:
        return self.root / "size"


def _contents_of(fd: int, most: int) -> bytes:
    """What an open file holds, up to a number of bytes."""
    chunks, size = [], 0
    while size < most and (chunk := os.read(fd, most - size)):
        chunks.append(chunk)
        size += len(chunk)
    return b"".join(chunks)
