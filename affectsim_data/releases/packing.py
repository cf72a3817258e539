"""Rows of a table packed small and quick to read one by one."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

__all__ = ["PackedRows"]


class PackedRows:
    """A table whose rows are read as dictionaries, a hundred times faster than Arrow gives them.

    Float columns are one array, words are places in lists of distinct words; what is neither stays
    as it is.
    """

    def __init__(self, table: pa.Table) -> None:
        """Packs all columns of a table."""
        floats = [name for name in table.column_names if pa.types.is_float64(_type(table, name))]
        words = [name for name in table.column_names if pa.types.is_string(_type(table, name))]
        others = [name for name in table.column_names if name not in {*floats, *words}]
        self._names = (*floats, *words, *others)
        self._order = table.column_names
        self._floats = _stacked([table.column(name).to_numpy() for name in floats], len(table))
        self._null_floats = [
            (place, table.column(name).is_null().to_numpy())
            for place, name in enumerate(floats)
            if table.column(name).null_count
        ]
        encoded = [pc.dictionary_encode(_whole(table, name)) for name in words]
        codes = [one.indices.fill_null(-1).to_numpy(zero_copy_only=False) for one in encoded]
        self._codes = _stacked(codes, len(table)).astype(np.int16 if len(table) < 1 << 15 else int)
        # The last word is that of the code -1.
        self._words: list[list[str | None]] = [
            [*one.dictionary.to_pylist(), None] for one in encoded
        ]
        self._others = [_whole(table, name) for name in others]

    def __len__(self) -> int:
        return len(self._floats)

    def row(self, place: int) -> dict[str, Any]:
        """The row at a place, by column name; null is `None`."""
        numbers: list[float | None] = self._floats[place].tolist()
        for column, is_null in self._null_floats:
            if is_null[place]:
                numbers[column] = None
        codes = self._codes[place].tolist()
        words = [words[code] for words, code in zip(self._words, codes, strict=True)]
        others = [column[place].as_py() for column in self._others]
        return dict(zip(self._names, [*numbers, *words, *others], strict=True))


def _type(table: pa.Table, name: str) -> pa.DataType:
    return table.schema.field(name).type


def _whole(table: pa.Table, name: str) -> pa.Array:
    """A column in one piece, which holds no more than the column."""
    return (
        pa.concat_arrays(table.column(name).chunks)
        if len(table)
        else pa.array([], _type(table, name))
    )


def _stacked(columns: list[NDArray[Any]], num_rows: int) -> NDArray[Any]:
    """Columns as an array `(num_rows, num_columns)`, rows contiguous."""
    return np.stack(columns, axis=1) if columns else np.zeros((num_rows, 0))
