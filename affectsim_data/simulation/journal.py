"""What a run over many episodes has recorded so far, on disk beside the table it will become.

OUT.partial.jsonl
    {"affectsim_trajectories": 1, "policy": ..., "release_sha256": ..., ...}   what is run on what
    {"episode_id": ..., "ending": ..., "rows": {"step": [...], ...}, ...}      an episode
    {...}
"""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from affectsim_data.releases.journals import JournalFile, journal_path, open_journal_file
from affectsim_data.simulation.recording import EpisodeRecord

__all__ = ["RunHeader", "RunJournal", "open_run_journal"]

_FORMAT = 1
_MARK = "affectsim_trajectories"
_WAY_OUT = "go on with what it was, choose another --out, or start anew with --overwrite"


@dataclasses.dataclass(frozen=True)
class RunHeader:
    """All that must be the same for trajectories to stand in one table."""

    policy: str
    """Its name."""
    release: str
    """Where the release is; for the reader, the hash decides."""
    release_sha256: str
    """Of its content, without the trajectories that it carries."""
    split: str
    """Its split, and by what it is split if not by group."""
    seed: int
    """Of the run."""
    max_policy_time_s: float
    """What the policy may take in an episode."""
    code: str
    """Fingerprint of the package, which may act differently from another."""

    def to_json(self) -> dict[str, Any]:
        """The first line of a journal."""
        return {_MARK: _FORMAT, **dataclasses.asdict(self)}

    def check(self, document: Any, *, file: Path) -> None:
        """Raises ValueError unless what a file says of its run is said of this one.

        Args:
            document: The first line of a journal, or the metadata of a table.
            file: Its name, for the message.
        """
        if not isinstance(document, dict) or document.get(_MARK) != _FORMAT:
            raise ValueError(
                f"{file}: not a journal of trajectories; remove it, or start anew with --overwrite"
            )
        differences = [
            f"{name} {document.get(name)!r}, here {mine!r}"
            for name, mine in dataclasses.asdict(self).items()
            if name not in ("release", "code") and document.get(name) != mine
        ]
        if document.get("code") != self.code:
            differences.append("another version of affectsim-data")
        if differences:
            raise ValueError(f"{file}: is of another run: {'; '.join(differences)}; {_WAY_OUT}")


class RunJournal:
    """The journal of a run, open and locked; made by `open_run_journal`."""

    def __init__(self, file: JournalFile, header: RunHeader, *, anew: bool) -> None:
        """Reads what is there, or begins a new one.

        Args:
            file: The file.
            header: Of this run.
            anew: Whether to forget what is there.

        Raises:
            ValueError: It is of another run, or a line of it cannot be read.
        """
        self.records: dict[str, EpisodeRecord] = {}
        """By episode."""
        self._file = file
        lines = iter(()) if anew else file.lines()
        first = next(lines, None)
        if first is None:
            file.clear()
            file.append(header.to_json())
            return
        header.check(first, file=file.path)
        for number, line in enumerate(lines, start=2):
            try:
                record = EpisodeRecord.from_json(line, policy=header.policy)
            except ValueError as error:
                raise file.damaged(number, error) from error
            self.records[record.episode_id] = record

    @property
    def path(self) -> Path:
        """Of the file."""
        return self._file.path

    def add(self, record: EpisodeRecord) -> None:
        """Keeps a record, on disk when this returns."""
        self._file.append(record.to_json())
        self.records[record.episode_id] = record

    def remove(self) -> None:
        """Once the table holds everything."""
        self._file.remove()


@contextlib.contextmanager
def open_run_journal(out: Path, header: RunHeader, *, anew: bool) -> Iterator[RunJournal]:
    """The journal of a table, for this process alone; without a record in it, it is removed.

    Args:
        out: The table.
        header: Of this run.
        anew: Whether to forget what is there.

    Raises:
        BlockingIOError: Another process acquires into this table.
        ValueError: The journal is of another run, or damaged.
    """
    busy = f"{out}: another process acquires into it now; wait for it, or choose another --out"
    with open_journal_file(journal_path(out), kind="trajectories", busy=busy) as file:
        journal = RunJournal(file, header, anew=anew)
        try:
            yield journal
        finally:
            if not journal.records:
                journal.remove()
