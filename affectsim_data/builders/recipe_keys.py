"""Checks of the tables of a recipe: unknown keys with a suggestion, values of the wrong type."""

from __future__ import annotations

import dataclasses
import difflib
import re
from collections.abc import Collection, Mapping
from typing import Any

__all__ = ["check_keys", "check_texts", "typed_fields"]


def check_keys(table: object, known: Collection[str], *, where: str) -> None:
    """Raises unless a value is a table that has only known keys.

    Raises:
        ValueError: It is not; the message starts with `where`, lists the known keys and suggests
            the closest.

    Examples:
        >>> check_keys({"licnce": "MIT"}, ["licence", "name"], where="a.toml: [corpus]")
        Traceback (most recent call last):
        ValueError: a.toml: [corpus] knows no 'licnce'; is it 'licence'? Known: licence, name
    """
    if not isinstance(table, Mapping):
        raise ValueError(f"{where} must be a table, got {table!r}".strip())
    for key in table:
        if key not in known:
            close = difflib.get_close_matches(str(key), known, n=1)
            hint = f"; is it {close[0]!r}?" if close else "."
            listed = ", ".join(sorted(known))
            raise ValueError(f"{where} knows no {key!r}{hint} Known: {listed}".strip())


def check_texts(table: object, *, where: str) -> None:
    """Raises unless a value is a table of texts that are not empty.

    Raises:
        ValueError: It is not; the message starts with `where`.
    """
    if not isinstance(table, Mapping):
        raise ValueError(f"{where} must be a table, got {table!r}")
    for key, value in table.items():
        if not isinstance(value, str) or not value:
            raise ValueError(f"{where} {key!r} must be a text, got {value!r}")


def typed_fields(record: type, table: object, *, before: str) -> dict[str, Any]:
    """The values of a table as the fields of a data class, up to the field `before`.

    Raises:
        ValueError: A key is unknown or lacks, or a value is not of the field's type.
    """
    fields = {}
    for field in dataclasses.fields(record):
        if field.name == before:
            break
        fields[field.name] = field
    check_keys(table, fields, where="")
    assert isinstance(table, Mapping)
    for name, field in fields.items():
        if field.default is dataclasses.MISSING and name not in table:
            raise ValueError(f"needs the key {name!r}")
    return {key: _typed(key, str(fields[key].type), value) for key, value in table.items()}


def _typed(key: str, kind: str, value: object) -> object:
    """The value as a field of a type, given as it is written, needs it."""
    if kind == "bool":
        # A text such as "false" would count as true, and the motions would be passed on.
        if not isinstance(value, bool):
            raise ValueError(f"{key} must be true or false, got {value!r}")
        return value
    if kind.startswith("int"):
        if isinstance(value, bool) or not isinstance(value, int) or value < 0:
            raise ValueError(f"{key} must be a whole number from 0, got {value!r}")
        return value
    if kind == "tuple[str, ...]":
        if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
            raise ValueError(f"{key} must be a list of texts, got {value!r}")
        return tuple(value)
    if kind.startswith("float"):
        return _number(key, value)
    if kind in ("Sequence[float]", "tuple[float, ...]"):
        if not isinstance(value, list | tuple):
            raise ValueError(f"{key} must be a list of numbers, got {value!r}")
        return tuple(_number(key, one) for one in value)
    if not isinstance(value, str):
        raise ValueError(f"{key} must be a text, got {value!r}")
    if kind != "re.Pattern[str]":
        return value
    try:
        return re.compile(value)
    except re.error as error:
        raise ValueError(f"{key} is no regular expression: {error}") from error


def _number(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{key} must be a number, got {value!r}")
    return float(value)
