"""What a piece of furniture is, and the one place where pieces are made.

A piece is parts about its own origin, the middle of its underside; its front looks towards +Z.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Protocol

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, merged

__all__ = [
    "BLACK", "DARK", "METAL", "WHITE", "FurnitureSource", "Furniture", "LocalSeat", "Top",
    "Workshop", "piece",
]  # fmt: skip

METAL = np.array([0.66, 0.66, 0.65])
DARK = np.array([0.25, 0.25, 0.27])
"""Plastic, screens and hobs."""
BLACK = np.array([0.2, 0.19, 0.19])
"""Painted steel."""
WHITE = np.array([0.94, 0.935, 0.92])
"""China and enamel."""

_LEVEL_M = 0.015
"""Pieces whose lowest point is that close to the floor are let down or lifted onto it."""

Size = tuple[float, float, float]
"""Width, depth and height, metres."""


@dataclasses.dataclass(frozen=True)
class LocalSeat:
    """A place to sit on a piece of furniture; the sitter looks along its +Z."""

    position: tuple[float, float, float]
    """Middle of the seat surface's front half, metres."""
    depth: float
    """Free depth of the seat surface, metres."""
    yaw: float = 0.0
    """Which way the sitter looks in the piece, radians; 0 is +Z."""
    edge: float = 0.2
    """From `position` to the edge that the knees bend over, metres."""


@dataclasses.dataclass(frozen=True)
class Top:
    """A level surface on which things may be put."""

    y: float
    """Its height, metres."""
    width: float
    depth: float
    x: float = 0.0
    """Its middle in the piece, metres."""
    z: float = 0.0


@dataclasses.dataclass(frozen=True)
class Furniture:
    """A piece of furniture about its own origin."""

    parts: tuple[Part, ...]
    width: float
    """Along x, metres."""
    depth: float
    """Along z, metres."""
    height: float
    seats: tuple[LocalSeat, ...] = ()
    lamp_y: float | None = None
    """Height of its lamp above its middle, if it has one."""
    category: str = ""
    """What it is: `sofa`, `chair`, `table`, ..."""
    tops: tuple[Top, ...] = ()
    """Where things may be put on it."""
    footprint: tuple[tuple[float, float, float, float], ...] = ()
    """Least x and z, greatest x and z of what it takes of the floor, metres; its box if empty."""
    licence: str = ""
    """Of a model from a catalogue, as that states it; empty for a design of our own."""
    credit: str = ""
    """Its name and who made it."""


def piece(
    category: str, parts: Iterable[Part], size: Size, *, seats: Iterable[LocalSeat] = (),
    lamp_y: float | None = None, tops: Iterable[Top] = (),
) -> Furniture:  # fmt: skip
    """A piece whose parts of one material are one; no part of it lies outside of its box.

    Args:
        category: What it is.
        parts: About the middle of its underside.
        size: Width, depth and height, metres; parts that need more width or depth have it.
        seats: Where one can sit.
        lamp_y: Height of its lamp, metres.
        tops: Where things may be put.
    """
    groups: dict[str, list[Part]] = {}
    for part in parts:
        groups.setdefault(part.material, []).append(part)
    whole = tuple(merged(group) for group in groups.values())
    low = float(min(part.positions[:, 1].min() for part in whole))
    if 0.0 < abs(low) < _LEVEL_M:
        whole = tuple(part.moved(y=-low) for part in whole)
    lowest = np.min([part.positions.min(axis=0) for part in whole], axis=0)
    highest = np.max([part.positions.max(axis=0) for part in whole], axis=0)
    width, depth = (float(2.0 * max(-lowest[k], highest[k])) for k in (0, 2))
    if width <= size[0] and depth <= size[1]:
        return Furniture(whole, *size, tuple(seats), lamp_y, category, tuple(tops))
    # Too large for its box: the box is what its parts need, its middle their middle.
    x, z = (float(lowest[k] + highest[k]) / 2.0 for k in (0, 2))
    return Furniture(
        tuple(part.moved(-x, 0.0, -z) for part in whole),
        float(highest[0] - lowest[0]), float(highest[2] - lowest[2]), size[2],
        tuple(_shifted(seat, x, z) for seat in seats), lamp_y, category,
        tuple(dataclasses.replace(top, x=top.x - x, z=top.z - z) for top in tops),
    )  # fmt: skip


def _shifted(seat: LocalSeat, x: float, z: float) -> LocalSeat:
    at = seat.position
    return dataclasses.replace(seat, position=(at[0] - x, at[1], at[2] - z))


class FurnitureSource(Protocol):
    """Where pieces come from that replace the parametric ones: a catalogue of models."""

    def piece(self, category: str, *, rng: np.random.Generator, max_size: Size) -> Furniture | None:
        """A piece no larger than `max_size`, or none."""


class Design(Protocol):
    """Makes a piece in the colours of a home."""

    def __call__(self, palette: Palette, *, rng: np.random.Generator) -> Furniture:
        """The piece."""


_BUILT_IN = frozenset(
    {
        *("counter", "rug", "curtain", "curtain rod", "picture", "divider", "fireplace"),
        *("mirror", "pendant lamp"),
    }
)
"""Categories that are always made to measure."""
_SLACK, _LEAST = 1.04, 0.55
"""A catalogue's piece may be that much larger than the parametric one, and must have that share of
each of its extents, so that a table lamp does not stand in for a floor lamp."""


class Workshop:
    """Makes the pieces of a home: from its catalogue where that has one, else from a design."""

    def __init__(
        self, palette: Palette, *, rng: np.random.Generator, catalogue: FurnitureSource | None
    ) -> None:
        self.palette = palette
        self.rng = rng
        self._catalogue = catalogue
        self._styles: dict[str, int] = {}

    def make(self, *designs: Design, style: str | None = None) -> Furniture:
        """A piece of one of the designs; under the same `style` always the same of them."""
        choice = int(self.rng.integers(len(designs)))
        if style is not None:
            choice = self._styles.setdefault(style, choice)
        made = designs[choice % len(designs)](self.palette, rng=self.rng)
        if self._catalogue is None or made.category in _BUILT_IN:
            return made
        size = (made.width * _SLACK, made.depth * _SLACK, made.height * _SLACK)
        found = self._catalogue.piece(made.category, rng=self.rng, max_size=size)
        if found is None or not _comparable(found, made):
            return made
        return dataclasses.replace(found, category=made.category)


def _comparable(found: Furniture, made: Furniture) -> bool:
    return (
        found.width >= _LEAST * made.width
        and found.depth >= _LEAST * made.depth
        and found.height >= _LEAST * made.height
    )
