"""Limits of the checks, as `builders/screening.toml` states them and a recipe may change them."""

from __future__ import annotations

import dataclasses
import math
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from affectsim_data.builders.screening.limits import ANGLES, LIMITS, Limit, Thresholds
from affectsim_data.content import content_path

__all__ = ["Thresholds", "load_thresholds"]

_CHECKS = tuple(LIMITS)


def load_thresholds(
    overrides: Mapping[str, Any] | None = None, *, path: Path | str | None = None
) -> Thresholds:
    """The limits of `builders/screening.toml`, changed by a recipe's `[screening]` table.

    Args:
        overrides: Tables by check with the keys to change; `off` names checks to switch off, each
            with a reason. None changes nothing.
        path: Another file of limits.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: A check or key is unknown or missing, or a value does not fit; names all three.
    """
    path = Path(path) if path else content_path("builders", "screening.toml")
    tables = tomllib.loads(path.read_text(encoding="utf-8"))
    _check_names(tables, where=path.name)
    lacking = [check for check in _CHECKS if check not in tables]
    if lacking:
        raise ValueError(f"{path.name}: expected a table for each check, got none for {lacking}")
    changed = {check: _entries(tables[check], path.name, check) for check in _CHECKS}
    changes = dict(overrides or {})
    _check_names(changes, where="[screening]")
    for check, table in changes.items():
        if check == "off":
            continue
        for key, value in _entries(table, "[screening]", check).items():
            if key not in changed[check]:
                raise ValueError(
                    f"[screening] {check}: expected one of {sorted(changed[check])}, got {key!r}"
                )
            both = isinstance(value, Mapping) and isinstance(changed[check][key], Mapping)
            changed[check][key] = {**changed[check][key], **value} if both else value
    off = {**_entries(tables.get("off", {}), path.name, "off"), **changes.get("off", {})}
    _check_off(off)
    where = f"[screening] over {path.name}" if changes else path.name
    limits: dict[str, Any] = {
        check: _limits(LIMITS[check], changed[check], f"{where}: {check}") for check in _CHECKS
    }
    return Thresholds(**limits, off=off)


def _check_names(tables: Mapping[str, Any], *, where: str) -> None:
    unknown = sorted(set(tables) - {*_CHECKS, "off"})
    if unknown:
        raise ValueError(f"{where}: expected tables named {[*_CHECKS, 'off']}, got {unknown}")


def _entries(table: Any, where: str, check: str) -> dict[str, Any]:
    if not isinstance(table, Mapping):
        raise ValueError(f"{where}: {check} must be a table, got {table!r}")
    return dict(table)


def _check_off(off: Mapping[str, Any]) -> None:
    for check, reason in off.items():
        if check not in _CHECKS:
            raise ValueError(f"[screening.off]: expected checks of {list(_CHECKS)}, got {check!r}")
        if not isinstance(reason, str) or not reason.strip():
            raise ValueError(f"[screening.off] {check}: expected a reason, got {reason!r}")


def _limits(kind: type[Limit], table: Mapping[str, Any], where: str) -> Limit:
    """One table as the limits of its check."""
    names = [field.name for field in dataclasses.fields(kind)]
    if sorted(names) != sorted(table):
        raise ValueError(f"{where}: expected the keys {names}, got {sorted(table)}")
    values: dict[str, Any] = {}
    for name in names:
        value = table[name]
        if name == "ranges_deg":
            values[name] = _ranges(value, f"{where} {name}")
        else:
            values[name] = _number(value, f"{where} {name}")
    return kind(**values)


def _ranges(table: Any, where: str) -> dict[str, tuple[float, float]]:
    given = sorted(table) if isinstance(table, Mapping) else table
    if given != sorted(ANGLES):
        raise ValueError(f"{where}: expected a range for each of {sorted(ANGLES)}, got {given}")
    return {angle: _range(pair, f"{where} {angle}") for angle, pair in table.items()}


def _number(value: Any, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{where}: expected a number, got {value!r}")
    if value < 0:
        raise ValueError(f"{where}: expected a number of 0 or more, got {value}")
    return value


def _range(pair: Any, where: str) -> tuple[float, float]:
    numbers = isinstance(pair, list | tuple) and len(pair) == 2
    numbers = numbers and all(isinstance(x, int | float) for x in pair)
    if not numbers or pair[0] >= pair[1]:
        raise ValueError(f"{where}: expected [lowest, highest] in degrees, got {pair!r}")
    return float(pair[0]), float(pair[1])
