"""What a run of a recognizer has answered so far, on disk beside the table it will become.

OUT.partial.jsonl
    {"affectsim_predictions": 1, "model": ..., "release_sha256": ..., ...}    what is run on what
    [{"episode_id": ..., "condition": ..., "raw_text": ..., ...}, ...]        a batch of answers
    [...]

A line is on disk before the next batch is taken up, so a run that ends in any way loses at most the
batch it worked on.
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeAlias

from affectsim_data.releases.journals import JournalFile, journal_path, open_journal_file
from affectsim_data.schemas import SCHEMAS

__all__ = ["Journal", "Key", "RunHeader", "open_journal"]

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

    def __init__(self, file: JournalFile, header: RunHeader, *, replaces: bool) -> None:
        """Reads what is there, or begins a new one.

        Args:
            file: The file.
            header: Of this run.
            replaces: Whether to forget what is there, and the table beside it.

        Raises:
            ValueError: It is of another run, or a line of it cannot be read.
        """
        self.answered: dict[Key, dict[str, Any]] = {}
        """Rows of the table without the column `model`, by episode and condition."""
        self._file = file
        lines = iter(()) if replaces else file.lines()
        first = next(lines, None)
        self.torn = file.torn and first is not None
        """Whether the last batch was half-written, and so is gone."""
        if first is None:
            file.clear()
            file.append({**header.to_json(), "replaces": replaces})
            self.replaces = replaces
            """Whether the run began with `--overwrite`."""
            return
        try:
            found = RunHeader.from_json(first)
        except ValueError as error:
            raise file.damaged(1, error) from error
        header.check(found, file=file.path)
        self.replaces = first.get("replaces") is True
        for number, batch in enumerate(lines, start=2):
            try:
                self._take(batch)
            except (ValueError, TypeError) as error:
                raise file.damaged(number, error) from error

    @property
    def path(self) -> Path:
        """Of the file."""
        return self._file.path

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
            batch = [dict(row) for row in rows]
            self._file.append(batch)
            self._take(batch)

    def remove(self) -> None:
        """Once the table holds everything."""
        self._file.remove()


@contextlib.contextmanager
def open_journal(out: Path, header: RunHeader, *, replaces: bool) -> Iterator[Journal]:
    """The journal of a table, for this process alone; without an answer in it, it is removed.

    Args:
        out: The table.
        header: Of this run.
        replaces: Whether to begin anew.

    Raises:
        BlockingIOError: Another process predicts into this table.
        ValueError: The journal is of another run, or damaged.
    """
    busy = f"{out}: another process predicts into it now; wait for it, or choose another --out"
    with open_journal_file(journal_path(out), kind="predictions", busy=busy) as file:
        journal = Journal(file, header, replaces=replaces)
        try:
            yield journal
        finally:
            if not journal.answered:
                journal.remove()
