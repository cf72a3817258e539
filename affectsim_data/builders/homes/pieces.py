"""What a piece of furniture is: parts about its own origin, on the floor, its front towards +Z."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.parts import Part

__all__ = ["DARK", "METAL", "Furniture", "LocalSeat"]

METAL = np.array([0.66, 0.66, 0.65])
DARK = np.array([0.25, 0.25, 0.27])
"""Plastic, screens and hobs."""


@dataclasses.dataclass(frozen=True)
class LocalSeat:
    """A place to sit on a piece of furniture; the sitter looks along its +Z."""

    position: tuple[float, float, float]
    """Middle of the seat surface's front half, metres."""
    depth: float
    """Free depth of the seat surface, metres."""


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
