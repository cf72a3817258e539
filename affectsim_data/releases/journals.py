"""Journals: lines of JSON, each on disk before its writer goes on; a kill loses one at most.

Only the last line of such a file can be torn; it is cut off when the file is opened again. The
file is locked for as long as it is open.
"""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from affectsim_data.releases.file_locks import opened, try_lock

__all__ = ["JournalFile", "journal_path", "open_journal_file"]


class JournalFile:
    """A journal, open and locked; made by `open_journal_file`."""

    def __init__(self, path: Path, fd: int, *, kind: str) -> None:
        """Cuts off what a kill left of a last line.

        Args:
            path: Of the file.
            fd: The file, open for reading and writing, and locked.
            kind: What it is a journal of, for messages.
        """
        self.path = path
        self._fd, self._kind = fd, kind
        self.torn = self._mend()
        """Whether the last line was half-written, and so is gone."""

    def _mend(self) -> bool:
        size = os.fstat(self._fd).st_size
        whole, last = 0, b""
        for line in self._raw_lines():
            if line.endswith(b"\n"):
                whole, last = whole + len(line), line
        # A file system may keep the end of a line and lose its middle.
        if last and not _is_json(last):
            whole -= len(last)
        os.ftruncate(self._fd, whole)
        return whole < size

    def _raw_lines(self) -> Iterator[bytes]:
        with open(os.dup(self._fd), "rb") as stream:
            stream.seek(0)
            yield from stream

    def lines(self) -> Iterator[Any]:
        """The documents in it, in order.

        Raises:
            ValueError: A line is no JSON; the message names it.
        """
        for number, line in enumerate(self._raw_lines(), start=1):
            try:
                yield json.loads(line)
            except (ValueError, RecursionError) as error:
                raise self.damaged(number, f"not JSON: {error}") from error

    def damaged(self, number: int, why: object) -> ValueError:
        """The error for a line, counted from 1, that is not what it must be."""
        return ValueError(
            f"{self.path}, line {number}: not a journal of {self._kind}: {why}; remove the file, "
            "or start anew with --overwrite"
        )

    def append(self, document: Any) -> None:
        """Adds a line, on disk when this returns."""
        line = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
        left = line.encode() + b"\n"
        os.lseek(self._fd, 0, os.SEEK_END)
        while left:
            left = left[os.write(self._fd, left) :]
        os.fsync(self._fd)

    def clear(self) -> None:
        """Forgets all lines."""
        os.ftruncate(self._fd, 0)

    def remove(self) -> None:
        """Takes the file away, once what it stands for is elsewhere."""
        self.path.unlink(missing_ok=True)


def journal_path(out: Path) -> Path:
    """Where the journal of a table is while rows are missing from it."""
    return out.with_name(f"{out.name}.partial.jsonl")


@contextlib.contextmanager
def open_journal_file(path: Path, *, kind: str, busy: str) -> Iterator[JournalFile]:
    """A journal for this process alone, an empty one if there is none.

    Args:
        path: Of the file; its folder is made if need be.
        kind: What it is a journal of, for messages.
        busy: What the error says if another process has it.

    Raises:
        BlockingIOError: Another process has it.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        with opened(path, os.O_RDWR | os.O_CREAT) as fd:
            if try_lock(fd) is False:
                raise BlockingIOError(busy)
            if not _is_at(fd, path):  # whoever had it came to its end in between
                continue
            yield JournalFile(path, fd, kind=kind)
            return


def _is_at(fd: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(fd), path.stat())
    except FileNotFoundError:
        return False


def _is_json(line: bytes) -> bool:
    try:
        json.loads(line)
    except (ValueError, RecursionError):
        return False
    return True
