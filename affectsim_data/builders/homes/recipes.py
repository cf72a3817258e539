"""Recipes of homes: the tables of `builders/homes-*.toml`."""

from __future__ import annotations

import dataclasses
import tomllib
from pathlib import Path
from typing import Any, Literal, cast, get_args

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.poses import FloatArray

__all__ = ["Divider", "HomeRecipe", "Strip", "home_recipes"]

Divider = Literal["shelf", "partition", "island"]
"""What stands across the living area: blocks the straight way and hides legs or more."""

_PURPOSES = ("bedroom", "kitchen", "study", "hall")


@dataclasses.dataclass(frozen=True)
class Strip:
    """Rooms side by side along one wall of the living area."""

    depth: float
    """Metres, away from the living area."""
    rooms: tuple[str, ...]
    """Purposes, in order of growing x or z."""


@dataclasses.dataclass(frozen=True)
class HomeRecipe:
    """One home: a living area and up to two strips of rooms that open into it."""

    scene_id: str
    seed: int
    living: tuple[float, float]
    """Inner size of the living area along x and z, metres; at least 8 x 5."""
    palette: Palette
    divider: Divider
    right: Strip | None = None
    """Rooms beyond its far-x wall."""
    back: Strip | None = None
    """Rooms beyond its near-z wall."""
    mirror: bool = False
    """Whether the home is built mirrored."""

    def __post_init__(self) -> None:
        if self.living[0] < 8.0 or self.living[1] < 5.0:
            raise ValueError(
                f"home {self.scene_id!r}: living must be at least 8 x 5 m, got {self.living}"
            )
        if self.divider not in get_args(Divider):
            raise ValueError(
                f"home {self.scene_id!r}: divider must be one of {get_args(Divider)}, "
                f"got {self.divider!r}"
            )
        for strip in (self.right, self.back):
            for purpose in strip.rooms if strip else ():
                if purpose not in _PURPOSES:
                    raise ValueError(
                        f"home {self.scene_id!r}: a room must be one of {_PURPOSES}, "
                        f"got {purpose!r}"
                    )


def home_recipes(path: str | Path) -> tuple[HomeRecipe, ...]:
    """All homes of a TOML file, in its order.

    Raises:
        ValueError: The file does not say what it must.
    """
    path = Path(path)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise ValueError(f"{path}: not TOML: {error}") from error
    try:
        palettes = {name: _palette(table) for name, table in document["palettes"].items()}
        return tuple(_recipe(table, palettes) for table in document["home"])
    except (KeyError, TypeError) as error:
        raise ValueError(f"{path}: {error} is missing or malformed") from error


def _palette(table: dict[str, str]) -> Palette:
    return Palette(**{name: _color(code) for name, code in table.items()})


def _color(code: str) -> FloatArray:
    if len(code) != 7 or code[0] != "#":
        raise ValueError(f"a colour must be written #rrggbb, got {code!r}")
    return np.array([int(code[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0


def _recipe(table: dict[str, Any], palettes: dict[str, Palette]) -> HomeRecipe:
    strips = {
        side: Strip(float(table[side]["depth"]), tuple(table[side]["rooms"]))
        for side in ("right", "back")
        if side in table
    }
    width, depth = table["living"]
    return HomeRecipe(
        scene_id=table["scene_id"],
        seed=int(table["seed"]),
        living=(float(width), float(depth)),
        palette=palettes[table["palette"]],
        divider=cast(Divider, table["divider"]),
        mirror=bool(table.get("mirror", False)),
        **strips,
    )
