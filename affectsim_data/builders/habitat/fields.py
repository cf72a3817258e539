"""Values of a JSON table, checked one by one: a wrong one is an error that names file and field."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["Table"]

_SHOWN = 60


@dataclasses.dataclass(frozen=True)
class Table:
    """A JSON object, and where it stands."""

    values: Mapping[str, Any]
    where: str
    """File and field, for messages."""

    @classmethod
    def of(cls, value: object, *, where: str) -> Table:
        """The value as a table.

        Raises:
            ValueError: It is none.
        """
        if not isinstance(value, Mapping):
            raise ValueError(f"{where} must be a JSON object, got {_shown(value)}")
        return cls(value, where)

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def wrong(self, key: str, expected: str) -> ValueError:
        """The error for a field that is not what it should be."""
        return ValueError(
            f"{self.where}: {key} must be {expected}, got {_shown(self.values.get(key))}"
        )

    def text(self, key: str, default: str = "") -> str:
        """A text, or the default where there is none."""
        value = self.values.get(key, default)
        if not isinstance(value, str):
            raise self.wrong(key, "a text")
        return value

    def flag(self, key: str, *, default: bool) -> bool:
        """True or false."""
        value = self.values.get(key, default)
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def whole(self, key: str) -> int | None:
        """A whole number, or `None` where there is none."""
        value = self.values.get(key)
        if value is not None and (isinstance(value, bool) or not isinstance(value, int)):
            raise self.wrong(key, "a whole number")
        return value

    def number(self, key: str, default: float) -> float:
        """A finite number."""
        value = _finite(self.values.get(key, default))
        if value is None:
            raise self.wrong(key, "a finite number")
        return value

    def vector(self, key: str, default: tuple[float, ...]) -> FloatArray:
        """As many finite numbers as the default has."""
        found = self.values.get(key, default)
        numbers = [_finite(one) for one in found] if isinstance(found, list | tuple) else []
        if len(numbers) != len(default) or None in numbers:
            raise self.wrong(key, f"a list of {len(default)} finite numbers")
        return np.array(numbers, np.float64)

    def table(self, key: str) -> Table:
        """A table; an empty one where there is none."""
        return Table.of(self.values.get(key, {}), where=f"{self.where}: {key}")

    def rows(self, key: str) -> list[Any]:
        """A list; an empty one where there is none."""
        value = self.values.get(key, [])
        if not isinstance(value, list):
            raise self.wrong(key, "a list")
        return value


def _finite(value: object) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= _SHOWN else text[:_SHOWN] + "..."
