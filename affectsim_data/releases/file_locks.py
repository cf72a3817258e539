"""Locks between processes on files, and what takes their place where a file system has none."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path

__all__ = ["LockTimeoutError", "exclusive", "opened", "pauses", "try_lock", "unlock"]

_UNSUPPORTED = {errno.ENOSYS, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOLCK, errno.EINVAL}
_ABANDONED_S = 120.0
"""Age at which a lock file is taken for that of a process that died."""

_open_files: set[int] = set()


class LockTimeoutError(TimeoutError):
    """Another process has held a lock for too long."""


def _close_inherited() -> None:
    """A lock lasts while any copy of its descriptor is open: a forked child gives up its own."""
    for fd in _open_files:
        with contextlib.suppress(OSError):
            os.close(fd)
    _open_files.clear()


os.register_at_fork(after_in_child=_close_inherited)


@contextlib.contextmanager
def opened(path: Path, flags: int) -> Iterator[int]:
    """A file descriptor whose lock, if it gets one, ends here and in no forked child."""
    fd = os.open(path, flags | os.O_CLOEXEC, 0o666)
    _open_files.add(fd)
    try:
        yield fd
    finally:
        if fd in _open_files:  # not so in a child that was forked in between
            unlock(fd)
            _open_files.discard(fd)
            os.close(fd)


def try_lock(fd: int, *, shared: bool = False) -> bool | None:
    """Locks an open file unless that means waiting.

    Returns:
        `True` if it is locked now, `False` if somebody else has it, `None` if the file system
        has no locks.
    """
    try:
        fcntl.flock(fd, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError as error:
        if error.errno in _UNSUPPORTED:
            return None
        raise
    return True


def unlock(fd: int) -> None:
    """Gives up the lock of an open file, in copies of the descriptor too."""
    with contextlib.suppress(OSError):
        fcntl.flock(fd, fcntl.LOCK_UN)


def pauses(longest_s: float = 0.05) -> Iterator[None]:
    """Waits between looks at something others will change: short at first, then longer."""
    pause_s = 0.001
    while True:
        yield
        time.sleep(pause_s)
        pause_s = min(1.5 * pause_s, longest_s)


@contextlib.contextmanager
def exclusive(path: Path, *, patience_s: float) -> Iterator[int]:
    """The file at a path, made if need be, open for reading and writing by this caller alone.

    Meant for short work. Where the file system has no locks, a file beside it that only one
    process can make serves instead; one left by a process that died is removed after two minutes.

    Raises:
        LockTimeoutError: Another process has it for longer than `patience_s`.
    """
    with opened(path, os.O_RDWR | os.O_CREAT) as fd:
        deadline = time.monotonic() + patience_s
        for _ in pauses(0.02):
            locked = try_lock(fd)
            if locked is not False:
                break
            if time.monotonic() > deadline:
                raise LockTimeoutError(f"{path}: locked by another process for {patience_s:g} s")
        if locked:
            yield fd
        else:
            with _lock_file(path.with_name(path.name + ".lock"), patience_s=patience_s):
                yield fd


@contextlib.contextmanager
def _lock_file(path: Path, *, patience_s: float) -> Iterator[None]:
    deadline = time.monotonic() + patience_s
    for _ in pauses(0.02):
        with contextlib.suppress(FileExistsError):
            os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666))
            break
        with contextlib.suppress(FileNotFoundError):
            if time.time() - path.stat().st_mtime > _ABANDONED_S:
                # Renamed first: of several that find it abandoned, one succeeds.
                grave = path.with_name(f"{path.name}.{os.getpid()}")
                path.rename(grave)
                grave.unlink()
        if time.monotonic() > deadline:
            raise LockTimeoutError(f"{path}: held by another process for {patience_s:g} s")
    try:
        yield
    finally:
        path.unlink(missing_ok=True)
