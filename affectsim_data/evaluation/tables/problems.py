"""Problems of tables that people bring: gathered over all files, listed with file and row."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

__all__ = ["Places", "Problems", "TableProblems", "quoted", "row_name"]

_LISTED = 20
"""Problems of a kind that are spelled out; the others are counted."""
_QUOTED_CHARACTERS = 60


def quoted(value: object) -> str:
    """A value for a message: short, and nothing in it can steer a terminal.

    Examples:
        >>> quoted("happy" * 20)
        "'happyhappyhappyhappyhappyhappyhappyhappyhappyhappyhappyhappy...'"
    """
    if isinstance(value, bytes):
        value = value[: 2 * _QUOTED_CHARACTERS].decode("utf-8", "backslashreplace")
    if isinstance(value, str) and len(value) > _QUOTED_CHARACTERS:
        return repr(value[:_QUOTED_CHARACTERS] + "...")
    shown = repr(value)
    return shown if len(shown) <= 2 * _QUOTED_CHARACTERS else f"{shown[:_QUOTED_CHARACTERS]} ..."


class TableProblems(ValueError):
    """Tables that cannot be scored as they are; the text lists what is wrong, file and row each.

    Attributes:
        counts: How many problems there are, by kind.
    """

    def __init__(self, message: str, counts: dict[str, int]) -> None:
        super().__init__(message, counts)
        self.counts = counts

    def __str__(self) -> str:
        return str(self.args[0])


@dataclasses.dataclass(frozen=True)
class Places:
    """Where the entries of a table stand in the files they were read from."""

    files: tuple[Path, ...]
    """The files, in order."""
    starts: NDArray[np.int64]
    """First entry of each file, then the number of all, `(len(files) + 1,)`."""
    rows: NDArray[np.int64]
    """Row of each entry in its file, from 1, `(num_entries,)`; rows that cannot be read count."""
    find_lines: tuple[Callable[[], NDArray[np.int64]] | None, ...] = ()
    """Per file: gives the lines its rows begin at, from 1; `None` for a file without lines."""

    def name(self, entry: int) -> str:
        """What messages call an entry: `answers.csv, row 3 (line 4)`."""
        number = int(np.searchsorted(self.starts, entry, side="right")) - 1
        return row_name(self.files[number], int(self.rows[entry]), self._find_lines(number))

    def _find_lines(self, number: int) -> Callable[[], NDArray[np.int64]] | None:
        return self.find_lines[number] if self.find_lines else None


def row_name(
    path: Path, row: int, find_lines: Callable[[], NDArray[np.int64]] | None = None
) -> str:
    """What messages call a row: with its line where it has one and they differ."""
    lines = find_lines() if find_lines else np.zeros(0, np.int64)
    line = int(lines[row - 1]) if row <= len(lines) else row
    return f"{path}, row {row}" + (f" (line {line})" if line != row else "")


class Problems:
    """Collects problems by kind; nothing is raised before all of them are known."""

    def __init__(self, table: str) -> None:
        """Has none yet; `table` is what the message calls the whole: `predictions`."""
        self._table = table
        self._listed: dict[str, list[str]] = {}
        self._counts: dict[str, int] = {}

    def add(self, kind: str, text: str) -> None:
        """Adds one problem."""
        self._counts[kind] = self._counts.get(kind, 0) + 1
        listed = self._listed.setdefault(kind, [])
        if len(listed) < _LISTED:
            listed.append(text)

    def add_entries(
        self,
        kind: str,
        entries: NDArray[np.int64] | Sequence[int],
        places: Places,
        describe: Callable[[int], str],
    ) -> None:
        """Adds a problem per entry of a table; `describe` says what came, of those listed."""
        already = len(self._listed.get(kind, ()))
        for entry in entries[: max(0, _LISTED - already)]:
            self.add(kind, f"{places.name(int(entry))}: {describe(int(entry))}")
        unlisted = len(entries) - max(0, min(len(entries), _LISTED - already))
        if unlisted:
            self._counts[kind] = self._counts.get(kind, 0) + unlisted

    def raise_if_any(self) -> None:
        """Raises TableProblems if there is a problem."""
        if not self._counts:
            return
        total = sum(self._counts.values())
        problems = "1 problem" if total == 1 else f"{total} problems"
        lines = [f"{problems} in the {self._table}; nothing is scored before they are resolved"]
        for kind, count in self._counts.items():
            lines.append(f"{kind}: {count}")
            lines += [f"  {text}" for text in self._listed[kind]]
            more = count - len(self._listed[kind])
            lines += [f"  ... and {more} more"] if more else []
        raise TableProblems("\n".join(lines), dict(self._counts))
