"""Recipes of homes: the tables of `builders/homes-*.toml`.

A file names its homes one by one in `[[home]]` tables, or draws them in a `[set]`: so many of them,
of so many rooms and so much floor, from one seed.
"""

from __future__ import annotations

import dataclasses
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.purposes import (
    MAX_ROOMS,
    MIN_ROOMS,
    Purpose,
    check_program,
    usual_limits,
)
from affectsim_data.builders.recipe_keys import check_keys
from affectsim_data.poses import FloatArray

__all__ = ["HomeRecipe", "home_recipes"]

_SET_KEYS = ("prefix", "count", "seed", "rooms", "area_m2")
_MAX_COUNT = 10_000


@dataclasses.dataclass(frozen=True)
class HomeRecipe:
    """One home: which rooms, how large, and the seed of everything else."""

    scene_id: str
    """Unique in a release."""
    seed: int
    rooms: tuple[Purpose, ...] | int
    """Purposes, one of them living; or how many rooms, 2 to 7."""
    area_m2: float
    """Floor of all rooms together."""
    palette: Palette | None = None
    """Colours; drawn if not given."""

    def __post_init__(self) -> None:
        check_program(self.rooms, self.area_m2, where=f"home {self.scene_id!r}")


def home_recipes(path: str | Path) -> tuple[HomeRecipe, ...]:
    """All homes of a TOML file, in its order.

    Raises:
        FileNotFoundError: There is no such file.
        ValueError: The file does not say what it must; the message names file and field.
    """
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not TOML: {error}") from error
    check_keys(document, ("palettes", "home", "set"), where=f"{path}: the file")
    if ("home" in document) == ("set" in document):
        raise ValueError(f"{path}: needs either [[home]] tables or one [set]")
    if "set" in document:
        return _drawn(document["set"], f"{path}: [set]")
    palettes = {
        name: _palette(table, f"{path}: [palettes.{name}]")
        for name, table in _table(document.get("palettes", {}), f"{path}: [palettes]").items()
    }
    homes = document["home"]
    if not isinstance(homes, list) or not homes:
        raise ValueError(f"{path}: home must be one or more [[home]] tables, got {homes!r}")
    recipes = tuple(
        _recipe(table, palettes, f"{path}: [[home]] {number}")
        for number, table in enumerate(homes, start=1)
    )
    names = [recipe.scene_id for recipe in recipes]
    if repeated := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{path}: scene_id repeats: {', '.join(repeated)}")
    return recipes


def _table(value: object, where: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise ValueError(f"{where} must be a table, got {value!r}")
    return value


def _palette(table: object, where: str) -> Palette:
    names = [field.name for field in dataclasses.fields(Palette)]
    needed = [
        field.name
        for field in dataclasses.fields(Palette)
        if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
    ]
    check_keys(table, names, where=where)
    values = _table(table, where)
    if missing := [name for name in needed if name not in values]:
        raise ValueError(f"{where} needs {', '.join(missing)}")
    return Palette(**{name: _color(code, f"{where} {name}") for name, code in values.items()})


def _color(code: object, where: str) -> FloatArray:
    if not isinstance(code, str) or len(code) != 7 or code[0] != "#":
        raise ValueError(f"{where} must be a colour written #rrggbb, got {code!r}")
    try:
        return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
    except ValueError as error:
        raise ValueError(f"{where} must be a colour written #rrggbb, got {code!r}") from error


def _recipe(table: object, palettes: dict[str, Palette], where: str) -> HomeRecipe:
    fields = [field.name for field in dataclasses.fields(HomeRecipe)]
    check_keys(table, fields, where=where)
    values = _table(table, where)
    if missing := [name for name in fields if name not in values and name != "palette"]:
        raise ValueError(f"{where} needs {', '.join(missing)}")
    name = values.get("palette")
    if name is not None and name not in palettes:
        known = ", ".join(sorted(palettes)) or "none"
        raise ValueError(f"{where}: palette must be one of [palettes]: {known}; got {name!r}")
    if not isinstance(values["scene_id"], str) or not values["scene_id"]:
        raise ValueError(f"{where}: scene_id must be a text, got {values['scene_id']!r}")
    try:
        return HomeRecipe(
            scene_id=values["scene_id"],
            seed=_whole(values, "seed", where),
            rooms=_rooms(values["rooms"], where),
            area_m2=_number(values["area_m2"], f"{where}: area_m2"),
            palette=None if name is None else palettes[name],
        )
    except ValueError as error:
        text = str(error)
        raise ValueError(text if text.startswith(where) else f"{where}: {text}") from error


def _rooms(value: object, where: str) -> tuple[Purpose, ...] | int:
    if isinstance(value, int) and not isinstance(value, bool):
        return value
    if not isinstance(value, list) or not all(isinstance(one, str) for one in value):
        raise ValueError(f"{where}: rooms must be purposes or how many rooms, got {value!r}")
    return tuple(cast(Purpose, one) for one in value)


def _drawn(table: object, where: str) -> tuple[HomeRecipe, ...]:
    """The homes of a set: its numbers of rooms in turn, their floor drawn from its range."""
    check_keys(table, _SET_KEYS, where=where)
    values = _table(table, where)
    if missing := [key for key in _SET_KEYS if key not in values]:
        raise ValueError(f"{where} needs {', '.join(missing)}")
    if not isinstance(values["prefix"], str) or not values["prefix"]:
        raise ValueError(f"{where}: prefix must be a text, got {values['prefix']!r}")
    count, seed = _whole(values, "count", where), _whole(values, "seed", where)
    if not 1 <= count <= _MAX_COUNT:
        raise ValueError(f"{where}: count must be 1 to {_MAX_COUNT}, got {count}")
    fewest, most = (int(one) for one in _range(values["rooms"], f"{where}: rooms"))
    if not MIN_ROOMS <= fewest <= most <= MAX_ROOMS:
        raise ValueError(
            f"{where}: rooms must lie in {MIN_ROOMS} to {MAX_ROOMS}, got {values['rooms']!r}"
        )
    areas = _range(values["area_m2"], f"{where}: area_m2")
    return tuple(
        _member(f"{values['prefix']}{number:02d}", [seed, number], (fewest, most), areas, where)
        for number in range(count)
    )


def _member(
    scene_id: str, seed: list[int], rooms: tuple[int, int], areas: tuple[float, float], where: str
) -> HomeRecipe:
    """One home of a set."""
    rng = np.random.default_rng(seed)
    number = rooms[0] + seed[1] % (rooms[1] - rooms[0] + 1)
    low, high = usual_limits(number)
    low, high = max(low, areas[0] + 0.02 * areas[0]), min(high, 0.98 * areas[1])
    if low > high:
        raise ValueError(
            f"{where}: area_m2 [{areas[0]:g}, {areas[1]:g}] suits no home of {number} rooms, which "
            f"has {usual_limits(number)[0]:g} to {usual_limits(number)[1]:g} m2"
        )
    area = round(float(rng.triangular(low, (2.0 * low + high) / 3.0, high)), 1)
    return HomeRecipe(scene_id, int(rng.integers(2**31)), number, area)


def _range(value: object, where: str) -> tuple[float, float]:
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError(f"{where} must be [least, most], got {value!r}")
    low, high = (_number(one, where) for one in value)
    if low > high:
        raise ValueError(f"{where} must be [least, most], got {value!r}")
    return low, high


def _whole(values: Mapping[str, Any], key: str, where: str) -> int:
    value = values[key]
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"{where}: {key} must be a whole number from 0, got {value!r}")
    return value


def _number(value: object, where: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"{where} must be a number, got {value!r}")
    return float(value)
