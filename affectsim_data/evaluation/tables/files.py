"""What every kind of file of a table is read into, and which of its columns are meant."""

from __future__ import annotations

import dataclasses
import difflib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.evaluation.tables.columns import BadValues, as_column
from affectsim_data.evaluation.tables.problems import quoted
from affectsim_data.schemas import SCHEMAS, TableName

__all__ = ["MAX_FILE_BYTES", "MAX_ROWS", "MAX_TEXT_BYTES", "Columns", "TableFile", "converted"]

MAX_FILE_BYTES = 2 << 30
"""Of a file; larger ones are refused."""
MAX_ROWS = 20_000_000
"""Of a file."""
MAX_TEXT_BYTES = 1_000_000
"""Of a cell, in UTF-8."""
_NAMES_LISTED = 20


@dataclasses.dataclass(frozen=True)
class Columns:
    """The columns a table may have: those of the contract, and other names for some of them."""

    table: TableName
    """Whose contract."""
    required: tuple[str, ...]
    """Those that must be there."""
    any_of: tuple[str, ...] = ()
    """Of these, one must be there."""
    aliases: Mapping[str, str] = dataclasses.field(default_factory=dict)
    """Other names, and the contract's."""

    @property
    def schema(self) -> pa.Schema:
        """The contract."""
        return SCHEMAS[self.table]

    @property
    def known(self) -> tuple[str, ...]:
        """All names that mean something."""
        return (*self.schema.names, *self.aliases)

    def contract_name(self, name: str) -> str:
        """The contract's name of a column."""
        return self.aliases.get(name, name)

    def choose(self, names: Sequence[str]) -> dict[str, str]:
        """The name in the file of every column of the contract that it has.

        Raises:
            ValueError: A column that must be there is not, or one is there twice.
        """
        known = [name for name in names if name in self.known]
        twice = [
            name for name, count in Counter(map(self.contract_name, known)).items() if count > 1
        ]
        if twice:
            raise ValueError(f"columns are there twice: {', '.join(twice)}")
        chosen = {self.contract_name(name): name for name in known}
        missing = [name for name in self.required if name not in chosen]
        if self.any_of and not set(self.any_of) & set(chosen):
            missing.append(" or ".join(self.any_of))
        if missing:
            raise ValueError(f"columns are missing: {', '.join(missing)}; {self._there(names)}")
        return chosen

    def _there(self, names: Sequence[str]) -> str:
        if len(names) == 1 and any(mark in names[0] for mark in ";\t"):
            return f"its first line is {quoted(names[0])}: cells are parted by commas"
        listed = ", ".join(quoted(name) for name in names[:_NAMES_LISTED])
        more = ", ..." if len(names) > _NAMES_LISTED else ""
        near = [
            f"{quoted(name)} may be {match[0]}"
            for name in names[:_NAMES_LISTED]
            if name not in self.known and (match := difflib.get_close_matches(name, self.required))
        ]
        return "; ".join([f"there are {listed}{more}" if names else "there are none", *near])


@dataclasses.dataclass(frozen=True)
class TableFile:
    """A file of a table, its values of the contract's types."""

    path: Path
    """Where it was read from."""
    columns: Mapping[str, pa.ChunkedArray]
    """By the contract's names; those the file has."""
    bad_values: Mapping[str, BadValues]
    """Entries by column whose values could not be taken, and are null in `columns`."""
    unknown: tuple[str, ...]
    """Columns that mean nothing here."""
    rows: NDArray[np.int64]
    """Row of every entry, from 1, `(num_entries,)`."""
    broken: tuple[tuple[int, str], ...] = ()
    """Rows that could not be read at all, and why."""
    find_lines: Callable[[], NDArray[np.int64]] | None = None
    """Gives the line each row begins at, broken ones included; `None` if there are no lines."""


def converted(
    found: Mapping[str, pa.ChunkedArray], columns: Columns
) -> tuple[dict[str, pa.ChunkedArray], dict[str, BadValues]]:
    """Columns by the contract's names, turned into its types; and what could not be.

    Raises:
        ValueError: A column is of a wrong kind throughout.
    """
    good: dict[str, pa.ChunkedArray] = {}
    bad: dict[str, BadValues] = {}
    wrong = []
    for name, column in found.items():
        try:
            good[name], bad[name] = as_column(column, columns.schema.field(name).type)
        except TypeError as error:
            wrong.append(f"{name} {error}")
    if wrong:
        raise ValueError(f"columns have the wrong type: {'; '.join(wrong)}")
    return good, bad
