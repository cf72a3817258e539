"""What a run of a recognizer has answered so far, on disk beside the table it will become.

OUT.partial.jsonl
    {"affectsim_predictions": 1, "model": ..., "release_sha256": ..., ...}    what is run on what
    [{"episode_id": ..., "condition": ..., "raw_text": ..., ...}, ...]        a batch of answers
    [...]

A line is written in one go and synced before the next batch is taken up, so a run that ends in any
way loses at most the batch it worked on; only the last line of a file can be torn.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from affectsim_data.releases.file_locks import opened, try_lock
from affectsim_data.schemas import SCHEMAS

__all__ = ["Journal", "Key", "RunHeader", "journal_path", "open_journal"]

Key: TypeAlias = tuple[str, str]
"""Episode and condition: what a recognizer answers once."""

_FORMAT = 1
_MARK = "affectsim_predictions"
_COLUMNS = frozenset(SCHEMAS["predictions"].names) - {"model"}
_WAY_OUT = "go on with what it was, choose another --out, or start anew with --overwrite"


@dataclasses.dataclass(frozen=True)
class RunHeader:
    """All that must be the same for answers to stand in one table."""

    model: str
    """Name of the recognizer."""
    release: str
    """Where the release is; for the reader, the hash decides."""
    release_sha256: str
    """Of its content."""
    split: str
    """Its split, and by what it is split if not by group."""
    clip: str
    """Frames and size: `8x224x224`."""
    trajectories: str
    """Hash of the trajectories that a_obs shows; empty where no clip is of a_obs."""
    code_version: str
    """Version of the package, which may draw differently from another."""

    @classmethod
    def from_json(cls, document: Any) -> RunHeader:
        """The header in a document.

        Raises:
            ValueError: It is none.
        """
        names = [field.name for field in dataclasses.fields(cls)]
        if not isinstance(document, dict) or document.get(_MARK) != _FORMAT:
            raise ValueError(f"expected an object with {_MARK!r}: {_FORMAT}")
        if not all(isinstance(document.get(name), str) for name in names):
            raise ValueError(f"expected text for each of {', '.join(names)}")
        return cls(**{name: document[name] for name in names})

    def to_json(self) -> dict[str, Any]:
        """What `from_json` reads."""
        return {_MARK: _FORMAT, **dataclasses.asdict(self)}

    def check(self, other: RunHeader, *, file: Path) -> None:
        """Raises ValueError where a file was made by another run than this.

        Args:
            other: What the file says.
            file: Its name, for the message.
        """
        differences = [
            f"{name} {old!r}, here {new!r}"
            for name, new in dataclasses.asdict(self).items()
            if name != "release" and (old := getattr(other, name)) != new
        ]
        if differences:
            raise ValueError(f"{file}: is of another run: {'; '.join(differences)}; {_WAY_OUT}")


class Journal:
    """The journal of a run, open and locked; made by `open_journal`."""

    def __init__(self, path: Path, fd: int, header: RunHeader, *, replaces: bool) -> None:
        """Reads what is there, or begins a new one.

        Args:
            path: Of the file.
            fd: The file, open for reading and writing, and locked.
            header: Of this run.
            replaces: Whether to forget what is there, and the table beside it.

        Raises:
            ValueError: It is of another run, or a line of it cannot be read.
        """
        self.path = path
        self.answered: dict[Key, dict[str, Any]] = {}
        """Rows of the table without the column `model`, by episode and condition."""
        self.torn = False
        """Whether the last line was half-written, and so is gone."""
        self._fd = fd
        lines = [] if replaces else self._whole_lines()
        if lines:
            self.replaces = self._read(lines, header)
        else:
            os.ftruncate(fd, 0)
            self.replaces = replaces
            self._append({**header.to_json(), "replaces": replaces})

    def _whole_lines(self) -> list[bytes]:
        """Lines that were written to their end; cuts off the rest of the file."""
        with open(os.dup(self._fd), "rb") as stream:
            stream.seek(0)
            content = stream.read()
        *lines, rest = content.split(b"\n")
        if lines and not _is_json(lines[-1]):  # a file system may keep the end and lose the middle
            rest = lines.pop()
        self.torn = bool(rest and lines)
        os.ftruncate(self._fd, sum(len(line) + 1 for line in lines))
        return lines

    def _read(self, lines: Sequence[bytes], header: RunHeader) -> bool:
        """Takes in the lines; whether the run began with `--overwrite`."""
        replaces = False
        for number, line in enumerate(lines, start=1):
            try:
                document = json.loads(line)
                if number > 1:
                    self._take(document)
                else:
                    found = RunHeader.from_json(document)
                    replaces = document.get("replaces") is True
            except (ValueError, TypeError) as error:
                raise ValueError(
                    f"{self.path}, line {number}: not a journal of predictions: {error}; remove "
                    "the file, or start anew with --overwrite"
                ) from error
            if number == 1:
                header.check(found, file=self.path)
        return replaces

    def _take(self, batch: Any) -> None:
        if not isinstance(batch, list) or not batch:
            raise ValueError("expected a list of answers")
        for row in batch:
            if not isinstance(row, dict) or set(row) != _COLUMNS:
                raise ValueError(f"expected an object of {', '.join(sorted(_COLUMNS))}")
            self.answered[row["episode_id"], row["condition"]] = row

    def add(self, rows: Sequence[Mapping[str, Any]]) -> None:
        """Keeps a batch of answers, on disk when this returns."""
        if rows:
            self._append([dict(row) for row in rows])
            for row in rows:
                self.answered[row["episode_id"], row["condition"]] = dict(row)

    def _append(self, document: Any) -> None:
        line = json.dumps(document, ensure_ascii=True, allow_nan=False).encode() + b"\n"
        os.lseek(self._fd, 0, os.SEEK_END)
        while line:
            line = line[os.write(self._fd, line) :]
        os.fsync(self._fd)

    def remove(self) -> None:
        """Once the table holds everything."""
        self.path.unlink(missing_ok=True)


def journal_path(out: Path) -> Path:
    """Where the journal of a table is while answers are missing from it."""
    return out.with_name(f"{out.name}.partial.jsonl")


@contextlib.contextmanager
def open_journal(out: Path, header: RunHeader, *, replaces: bool) -> Iterator[Journal]:
    """The journal of a table, for this process alone; a new one if there is none.

    Args:
        out: The table.
        header: Of this run.
        replaces: Whether to begin anew.

    Raises:
        BlockingIOError: Another process predicts into this table.
        ValueError: The journal is of another run, or damaged.
    """
    path = journal_path(out)
    path.parent.mkdir(parents=True, exist_ok=True)
    while True:
        with opened(path, os.O_RDWR | os.O_CREAT) as fd:
            if try_lock(fd) is False:
                raise BlockingIOError(
                    f"{out}: another process predicts into it now; wait for it, or choose another "
                    "--out"
                )
            if not _is_at(fd, path):  # the run that had it came to its end in between
                continue
            yield Journal(path, fd, header, replaces=replaces)
            return


def _is_at(fd: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(fd), path.stat())
    except FileNotFoundError:
        return False


def _is_json(line: bytes) -> bool:
    try:
        json.loads(line)
    except ValueError:
        return False
    return True
