"""Filters over the columns of the episodes table, as lists in Python and as text on a command line.

The lists are those of `pyarrow.parquet.read_table`: `[("emotion", "in", ["sad", "angry"]),
("initial_distance_m", ">=", 3.0)]` holds where all its comparisons do, a list of such lists where
one of them does. As in SQL, null is neither equal nor unequal to anything; to ask for it, compare
with `None`.
"""

from __future__ import annotations

import functools
import operator
import re
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from affectsim_data.releases.splits import EpisodeTable
from affectsim_data.schemas import SCHEMAS

__all__ = ["Comparison", "Filter", "filter_columns", "matching", "parse_where", "values_there_are"]

Comparison: TypeAlias = tuple[str, str, Any]
"""Column, operator, value."""
Filter: TypeAlias = Sequence[Comparison] | Sequence[Sequence[Comparison]]
"""Comparisons that all hold, or lists of them of which one holds."""

_EQUAL, _LISTS = ("=", "==", "!="), ("in", "not in")
_OPERATORS = (*_EQUAL, "<", "<=", ">", ">=", *_LISTS)
_SHOWN = 10
_ROW = "__row__"
_WHERE = re.compile(r"\s*(\w+)\s*(==|!=|<=|>=|=|<|>)\s*(.*?)\s*", re.DOTALL)
_KINDS: dict[pa.DataType, tuple[tuple[type, ...], str]] = {
    pa.string(): ((str,), "text"),
    pa.float64(): ((int, float), "a number"),
    pa.int64(): ((int, float), "a number"),
    pa.int32(): ((int, float), "a number"),
}


def matching(table: EpisodeTable, filter: Filter) -> NDArray[np.bool_]:
    """Which episodes of a split match, `(num_episodes,)`.

    Columns of the index cost nothing more; others have the episodes table read.

    Raises:
        ValueError: The filter is malformed, or names a column there is none of.
    """
    groups = _groups(filter)
    columns = _columns(table, filter_columns(filter))
    any_of = functools.reduce(
        operator.or_,
        (functools.reduce(operator.and_, (_expression(*one) for one in group)) for group in groups),
    )
    rows = columns.filter(any_of).column(_ROW).to_numpy()
    chosen = np.zeros(table.num_episodes, bool)
    chosen[rows] = True
    return chosen


def filter_columns(filter: Filter) -> list[str]:
    """The columns a filter names, each once.

    Raises:
        ValueError: The filter is malformed, or names a column there is none of.
    """
    return list(dict.fromkeys(column for group in _groups(filter) for column, _, _ in group))


def values_there_are(tables: Sequence[EpisodeTable], filter: Filter) -> str:
    """For a message: what the columns of a filter hold in some splits."""
    found = [_columns(table, filter_columns(filter)) for table in tables]
    listed = []
    for name in filter_columns(filter):
        values = pa.chunked_array([c for columns in found for c in columns.column(name).chunks])
        listed.append(f"{name}: {_values(values)}")
    return "; ".join(listed)


def _values(column: pa.ChunkedArray) -> str:
    found = pc.unique(column.drop_null()).sort().to_pylist()
    null = ["null"] if column.null_count else []
    if found and not isinstance(found[0], str):
        return ", ".join([f"{found[0]:g} to {found[-1]:g}", *null])
    more = [f"... ({len(found)} in all)"] if len(found) > _SHOWN else []
    return ", ".join([*found[:_SHOWN], *more, *null])


def _columns(table: EpisodeTable, names: list[str]) -> pa.Table:
    """Columns of the episodes that are here, and their places in the split."""
    if set(names) <= set(SCHEMAS["index"].names):
        found = table.index.select(names)
        rows = np.arange(found.num_rows)
    else:
        found = table.table(names)
        rows = table.held_rows
    plain = pa.schema([SCHEMAS["episodes"].field(name) for name in names])
    return found.cast(plain).append_column(_ROW, pa.array(rows))


def _expression(column: str, relation: str, value: Any) -> pc.Expression:
    if value is None:
        null = pc.field(column).is_null()
        return ~null if relation == "!=" else null
    listed = sorted(value, key=repr) if isinstance(value, set | frozenset) else value
    return pq.filters_to_expression([(column, relation, listed)])


def _groups(filter: Filter) -> list[list[Comparison]]:
    """The filter as a list of lists, every comparison checked."""
    outer = list(filter) if isinstance(filter, list | tuple) else None
    if not outer:
        raise ValueError(
            f"filter must be a list of (column, operator, value) with at least one, got {filter!r}"
        )
    if isinstance(outer[0], tuple):
        outer = [outer]
    for group in outer:
        if not isinstance(group, list | tuple) or not group:
            raise ValueError(f"filter {filter!r}: expected lists of comparisons, got {group!r}")
        for comparison in group:
            if not isinstance(comparison, tuple) or len(comparison) != 3:
                raise ValueError(
                    f"filter {filter!r}: expected (column, operator, value), got {comparison!r}"
                )
            _check(*comparison)
    return [list(group) for group in outer]


def _check(column: str, relation: str, value: Any) -> None:
    """Raises ValueError unless this comparison can hold for some episode."""
    field = _field(column)
    types, kind = _KINDS[field.type]
    where = f"filter ({column!r}, {relation!r}, {value!r})"
    if relation not in _OPERATORS:
        raise ValueError(f"{where}: operator must be one of {', '.join(_OPERATORS)}")
    values = [value]
    if relation in _LISTS:
        if not isinstance(value, list | tuple | set | frozenset) or not value:
            raise ValueError(f"{where}: {relation!r} takes a list of values")
        values = list(value)
    for one in values:
        if one is None and field.nullable and relation in (*_EQUAL, *_LISTS):
            continue
        if isinstance(one, bool) or not isinstance(one, types):
            raise ValueError(f"{where}: {column} is {kind}, got {one!r}")


def _field(column: str) -> pa.Field:
    schema = SCHEMAS["episodes"]
    usable = [field.name for field in schema if field.type in _KINDS]
    if column not in usable:
        raise ValueError(f"filter: no column {column!r}; there are {', '.join(usable)}")
    return schema.field(column)


def parse_where(texts: Sequence[str]) -> list[Comparison]:
    """The filter that texts such as `emotion=sad,angry` and `initial_distance_m>=3` mean together.

    A column, one of `= != < <= > >=`, and a value; with `=` and `!=` also several, with commas
    between. `none` is null where a column may be null.

    Raises:
        ValueError: A text is malformed, names no column, or has a word where a number belongs.

    Examples:
        >>> parse_where(["emotion=sad,angry", "initial_distance_m>=3"])
        [('emotion', 'in', ['sad', 'angry']), ('initial_distance_m', '>=', 3.0)]
    """
    return [_parse_one(text) for text in texts]


def _parse_one(text: str) -> Comparison:
    found = _WHERE.fullmatch(text)
    if found is None or not found[3]:
        raise ValueError(
            f"{text!r}: expected COLUMN, one of = != < <= > >=, and a value, for example "
            "'emotion=sad,angry' or 'initial_distance_m>=3'"
        )
    column, relation, written = found[1], found[2], found[3]
    field = _field(column)
    words = [word.strip() for word in written.split(",")]
    if not all(words):
        raise ValueError(f"{text!r}: a value is missing between commas")
    values = [_parse_value(word, field, text) for word in words]
    if len(values) > 1:
        if relation not in _EQUAL:
            raise ValueError(f"{text!r}: {relation} takes one value, got {len(values)}")
        return (column, "not in" if relation == "!=" else "in", values)
    relation = "==" if relation == "=" else relation
    _check(column, relation, values[0])
    return (column, relation, values[0])


def _parse_value(written: str, field: pa.Field, text: str) -> Any:
    if written == "none" and field.nullable:
        return None
    if field.type == pa.string():
        return written
    try:
        return float(written) if field.type == pa.float64() else int(written)
    except ValueError:
        kind = "a number" if field.type == pa.float64() else "a whole number"
        raise ValueError(f"{text!r}: {field.name} is {kind}, got {written!r}") from None
