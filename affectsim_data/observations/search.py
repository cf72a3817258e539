"""What a search for the reference view tries, wants and allows; a recipe may change it."""

from __future__ import annotations

import dataclasses
import difflib
import math
from collections.abc import Mapping
from typing import Any

__all__ = ["PART_NAMES", "ReferenceSearch"]

PART_NAMES = ("visibility", "alignment", "distance_fit", "framing", "clearance")
"""Parts of a score, as episodes store them."""


@dataclasses.dataclass(frozen=True)
class ReferenceSearch:
    """Candidates, weights and limits of the search for the reference view."""

    azimuths_deg: tuple[float, ...] = (
        *(0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0),
        *(90.0, -90.0, 120.0, -120.0, 150.0, -150.0, 180.0),
    )
    """Sides of the body, 0 in front. Ties go to the earlier one."""
    distances_m: tuple[float, ...] = (1.7, 2.0, 2.3, 2.7)
    """Horizontal distances to the body centre."""
    heights_m: tuple[float, ...] = (1.2, 1.5)
    """Camera heights above the performer's floor."""
    preferred_distance_m: float = 2.1
    """A standing body fills about 70 % of a 60 degree image from here."""
    body_share: float = 0.72
    """Share of the image height a body should fill."""
    clearance_m: float = 0.5
    """Free space around the camera that counts as full clearance."""
    weight_visibility: float = 0.35
    weight_alignment: float = 0.25
    weight_distance_fit: float = 0.10
    weight_framing: float = 0.20
    weight_clearance: float = 0.10
    least_clearance_m: float = 0.10
    """A trajectory keeps this far from every surface."""
    least_share: float = 0.5
    """Of the body it sees at every instant of the cycle."""
    speed_m_s: float = 3.5
    """Fastest a trajectory may move."""
    acceleration_m_s2: float = 8.0
    """Most it may change its velocity by."""
    turn_deg_s: float = 100.0
    """Fastest it may turn."""

    def __post_init__(self) -> None:
        for name in ("azimuths_deg", "distances_m", "heights_m"):
            values = getattr(self, name)
            if not values or not all(math.isfinite(value) for value in values):
                raise ValueError(f"{name} must be finite numbers, at least one, got {values}")
        for name in ("distances_m", "heights_m"):
            if min(getattr(self, name)) <= 0.0:
                raise ValueError(f"{name} must be above 0, got {getattr(self, name)}")
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if isinstance(value, float | int) and not 0.0 <= value < math.inf:
                raise ValueError(f"{field.name} must be 0 or more, got {value}")
        for name in ("clearance_m", "preferred_distance_m", "body_share"):
            if not getattr(self, name):
                raise ValueError(f"{name} must be above 0, got 0")
        total = sum(self.weights.values())
        if not 0.0 < total <= 1.0 + 1e-9:
            raise ValueError(f"weights must add up to at most 1 and not to 0, got {total:g}")

    @property
    def weights(self) -> dict[str, float]:
        """Of each part of the score, by name."""
        return {name: getattr(self, f"weight_{name}") for name in PART_NAMES}

    @classmethod
    def from_table(cls, table: object, *, where: str) -> ReferenceSearch:
        """Reads the `[reference]` table of a recipe; what it leaves out keeps its default.

        Args:
            table: Its entries: numbers and lists of numbers, named as the fields here.
            where: What messages start with: file and table.

        Raises:
            ValueError: A key is unknown or a value not what the field needs.

        Examples:
            >>> ReferenceSearch.from_table({"heights_m": [1.4]}, where="my.toml").heights_m
            (1.4,)
        """
        if not isinstance(table, Mapping):
            raise ValueError(f"{where} must be a table, got {table!r}")
        fields = {field.name: str(field.type) for field in dataclasses.fields(cls)}
        for key in table:
            if key not in fields:
                close = difflib.get_close_matches(str(key), fields, n=1)
                hint = f"; is it {close[0]!r}?" if close else "."
                raise ValueError(f"{where} knows no {key!r}{hint} Known: {', '.join(fields)}")
        try:
            values = {key: _value(key, fields[key], value) for key, value in table.items()}
            return cls(**values)
        except ValueError as error:
            raise ValueError(f"{where} {error}") from error


def _value(key: str, kind: str, value: object) -> Any:
    if kind == "float":
        return _number(key, value)
    if not isinstance(value, list | tuple):
        raise ValueError(f"{key} must be a list of numbers, got {value!r}")
    return tuple(_number(key, one) for one in value)


def _number(key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{key} must be a number, got {value!r}")
    return float(value)
