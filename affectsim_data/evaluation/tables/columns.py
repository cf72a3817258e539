"""Columns as files have them, turned into those of the contract; what cannot be is told by row."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from affectsim_data.evaluation.tables.problems import quoted

__all__ = ["BadValues", "as_column", "values_column"]

BadValues = list[tuple[int, str]]
"""Entries whose values cannot be taken, and why; null stands in the column instead."""

_MAX_NUMBER_BYTES, _MAX_SCORES_BYTES = 100, 10_000
_NUMBER = r"^[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?$|^[+-]?(?i:nan|inf|infinity)$"
_WHOLE = r"^[+-]?[0-9]{1,18}$"
_FLAGS = {"true": True, "false": False, "1": True, "0": False}
_MAX_WHOLE = 2**31


def as_column(column: pa.ChunkedArray, type_: pa.DataType) -> tuple[pa.ChunkedArray, BadValues]:
    """A column of a file as a type of the contract.

    Text may be of any kind Arrow has, also dictionaries and valid UTF-8 as bytes; numbers of any
    kind or written as text; lists of numbers also as text of JSON.

    Raises:
        TypeError: Nothing of the kind; says what was expected and what came.
    """
    found = column.type.value_type if pa.types.is_dictionary(column.type) else column.type
    if pa.types.is_null(found):
        return pa.chunked_array([pa.nulls(len(column), type_)], type_), []
    if not _may_become(found, type_):
        raise TypeError(f"must be {_KINDS[type_]}, got {found}")
    try:
        plain = column.cast(found) if pa.types.is_dictionary(column.type) else column
        return _cast(plain, type_), []
    except (pa.ArrowInvalid, pa.ArrowNotImplementedError):
        # Some value is wrong; which one, Arrow does not say.
        return values_column(_python_values(column), type_)


def values_column(values: Sequence[Any], type_: pa.DataType) -> tuple[pa.ChunkedArray, BadValues]:
    """Python values, `None` for null, as a column of a type of the contract."""
    convert, bad = _CONVERTERS[type_], []
    good: list[Any] = []
    for entry, value in enumerate(values):
        try:
            good.append(None if value is None else convert(value))
        except ValueError as error:
            good.append(None)
            bad.append((entry, f"{error}, got {quoted(value)}"))
    return pa.chunked_array([pa.array(good, type_)], type_), bad


def _python_values(column: pa.ChunkedArray) -> list[Any]:
    return list(column.to_pylist())


def _may_become(found: pa.DataType, wanted: pa.DataType) -> bool:
    if _is_text(found):
        return True
    if wanted == pa.string():
        return False
    if wanted == pa.bool_():
        return bool(pa.types.is_boolean(found) or pa.types.is_integer(found))
    if pa.types.is_list(wanted):
        return bool(_is_list(found) and (_is_number(found.value_type) or _is_null(found)))
    return _is_number(found)


def _is_text(found: pa.DataType) -> bool:
    of = pa.types
    kinds = (of.is_string, of.is_large_string, of.is_string_view, of.is_binary, of.is_large_binary)
    return any(is_kind(found) for is_kind in kinds)


def _is_number(found: pa.DataType) -> bool:
    of = pa.types
    return any(is_kind(found) for is_kind in (of.is_integer, of.is_floating, of.is_decimal))


def _is_list(found: pa.DataType) -> bool:
    of = pa.types
    return any(is_kind(found) for is_kind in (of.is_list, of.is_large_list, of.is_fixed_size_list))


def _is_null(found: pa.DataType) -> bool:
    return bool(pa.types.is_null(found.value_type))


def _cast(column: pa.ChunkedArray, wanted: pa.DataType) -> pa.ChunkedArray:
    """By Arrow, all at once; raises ArrowInvalid if a single value is wrong."""
    if _is_text(column.type):
        text = column.cast(pa.string())  # bytes are checked to be UTF-8
        if wanted == pa.string():
            return text
        if wanted not in _PATTERNS or not _all_match(text, _PATTERNS[wanted]):
            raise pa.ArrowInvalid("not numbers throughout")
        return text.cast(wanted)
    if wanted == pa.bool_() and not pa.types.is_boolean(column.type):
        raise pa.ArrowInvalid("Arrow would take any number but 0 for true")
    # Whole numbers must stay what they are; float32 and float64 may round.
    return column.cast(wanted, safe=wanted == pa.int32())


def _all_match(text: pa.ChunkedArray, pattern: str) -> bool:
    matched = pc.all(pc.match_substring_regex(text, pattern)).as_py()
    return matched is None or bool(matched)


def _to_text(value: object) -> str:
    if isinstance(value, bytes):
        try:
            return value.decode("utf-8")
        except UnicodeDecodeError:
            raise ValueError("must be text in UTF-8") from None
    if not isinstance(value, str):
        raise ValueError("must be text")
    try:
        value.encode("utf-8")
    except UnicodeEncodeError:
        raise ValueError("must be text of whole characters, not half a surrogate pair") from None
    return value


def _to_number(value: object) -> float:
    if isinstance(value, bytes | str):
        text = _to_text(value).strip()
        if len(text) > _MAX_NUMBER_BYTES or not re.match(_NUMBER, text):
            raise ValueError("must be a number")
        return float(text)
    # A flag is an int to Python, and no number to anyone else.
    if isinstance(value, bool) or not hasattr(value, "__float__"):
        raise ValueError("must be a number")
    try:
        return float(value)
    except OverflowError:
        raise ValueError("must be a number of 64 bits") from None


def _to_whole(value: object) -> int:
    number = _to_number(value)
    if not abs(number) < _MAX_WHOLE or number != int(number):
        raise ValueError("must be a whole number of 32 bits")
    return int(number)


def _to_flag(value: object) -> bool:
    flag = _FLAGS.get(str(value).strip().lower()) if isinstance(value, str | int) else None
    if isinstance(value, bytes):
        flag = _FLAGS.get(_to_text(value).strip().lower())
    if flag is None:
        raise ValueError("must be true or false")
    return flag


def _to_numbers(value: object) -> list[float | None]:
    if isinstance(value, bytes | str):
        text = _to_text(value)
        if len(text) > _MAX_SCORES_BYTES:
            raise ValueError("must be a list of five numbers")
        try:
            value = json.loads(text)
        except (ValueError, RecursionError):
            raise ValueError("must be a list of numbers, as JSON: [0.1, 0.2, ...]") from None
    if not isinstance(value, list | tuple):
        raise ValueError("must be a list of numbers")
    # Nulls inside are a matter of what scores must be, and told there.
    return [None if number is None else _to_number(number) for number in value]


_CONVERTERS: dict[pa.DataType, Callable[[Any], Any]] = {
    pa.string(): _to_text,
    pa.float64(): _to_number,
    pa.int32(): _to_whole,
    pa.bool_(): _to_flag,
    pa.list_(pa.float32()): _to_numbers,
}
_PATTERNS = {pa.float64(): _NUMBER, pa.int32(): _WHOLE}
_KINDS = {
    pa.string(): "text",
    pa.float64(): "numbers",
    pa.int32(): "whole numbers",
    pa.bool_(): "true or false",
    pa.list_(pa.float32()): "lists of numbers",
}
