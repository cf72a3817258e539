"""What rooms are for, how large they are, and which of them make a home."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

__all__ = [
    "MAX_ROOMS", "MIN_ROOMS", "NEEDS_DAYLIGHT", "PURPOSES", "SIZES", "Purpose", "RoomSize",
    "area_limits", "check_program", "draw_program", "room_areas", "usual_limits",
]  # fmt: skip

Purpose = Literal["living", "kitchen", "dining", "bedroom", "bath", "study", "hall"]
"""What a room is for."""
PURPOSES: tuple[Purpose, ...] = get_args(Purpose)
NEEDS_DAYLIGHT: tuple[Purpose, ...] = ("living", "kitchen", "dining", "bedroom", "study")
"""Rooms that people stay in: they have windows."""
MIN_ROOMS, MAX_ROOMS = 2, 7


@dataclasses.dataclass(frozen=True)
class RoomSize:
    """What size a room of a purpose has."""

    least_m2: float
    usual_m2: float
    most_m2: float
    side_m: float
    """Least length of its shorter side."""
    aspect: float
    """Most of its longer over its shorter side."""


SIZES: dict[Purpose, RoomSize] = {
    "living": RoomSize(18.0, 27.0, 52.0, 3.4, 2.2),
    "kitchen": RoomSize(7.0, 10.5, 20.0, 2.2, 2.3),
    "dining": RoomSize(9.0, 13.0, 26.0, 2.7, 1.9),
    "bedroom": RoomSize(9.0, 14.0, 28.0, 2.7, 1.8),
    "bath": RoomSize(4.0, 5.6, 9.5, 1.75, 2.2),
    "study": RoomSize(7.5, 11.0, 20.0, 2.4, 1.9),
    "hall": RoomSize(3.6, 8.0, 20.0, 1.35, 7.0),
}
"""Floor between the walls, that is."""

_PROGRAMS: tuple[tuple[Purpose, ...], ...] = (
    ("living", "bedroom"),
    ("living", "kitchen"),
    ("living", "bedroom", "bath"),
    ("living", "kitchen", "bedroom"),
    ("living", "bedroom", "study"),
    ("living", "kitchen", "bedroom", "bath"),
    ("living", "hall", "bedroom", "bath"),
    ("living", "kitchen", "study", "bath"),
    ("living", "hall", "kitchen", "bedroom"),
    ("living", "kitchen", "hall", "bedroom", "bath"),
    ("living", "dining", "kitchen", "bedroom", "bath"),
    ("living", "hall", "bedroom", "study", "bath"),
    ("living", "kitchen", "hall", "bedroom", "bedroom", "bath"),
    ("living", "kitchen", "hall", "bedroom", "study", "bath"),
    ("living", "dining", "kitchen", "hall", "bedroom", "bath"),
    ("living", "kitchen", "hall", "bedroom", "bedroom", "study", "bath"),
    ("living", "dining", "kitchen", "hall", "bedroom", "study", "bath"),
    ("living", "dining", "kitchen", "hall", "bedroom", "bedroom", "bath"),
    ("living", "kitchen", "hall", "bedroom", "bedroom", "bedroom", "bath"),
)
"""Rooms of homes people know, by which a number of rooms becomes purposes."""


def area_limits(purposes: Sequence[Purpose]) -> tuple[float, float]:
    """Least and most floor of these rooms together, m2."""
    sizes = [SIZES[purpose] for purpose in purposes]
    return sum(size.least_m2 for size in sizes), sum(size.most_m2 for size in sizes)


def usual_limits(count: int) -> tuple[float, float]:
    """Least and most floor of homes of `count` rooms, neither cramped nor half empty, m2."""
    limits = [area_limits(program) for program in _PROGRAMS if len(program) == count]
    most = max(high for _, high in limits)
    return (1.0 + 0.1 * count) * min(low for low, _ in limits), 0.95 * most


def check_program(rooms: Sequence[Purpose] | int, area_m2: float, *, where: str) -> None:
    """Raises unless rooms, or some rooms of a number, make a home of an area.

    Raises:
        ValueError: They do not; the message starts with `where`.
    """
    count = rooms if isinstance(rooms, int) else len(rooms)
    if not MIN_ROOMS <= count <= MAX_ROOMS:
        raise ValueError(f"{where}: rooms must be {MIN_ROOMS} to {MAX_ROOMS}, got {count}")
    if isinstance(rooms, int):
        limits = [area_limits(program) for program in _PROGRAMS if len(program) == count]
    else:
        _check_purposes(rooms, where=where)
        limits = [area_limits(rooms)]
    low, high = min(least for least, _ in limits), max(most for _, most in limits)
    if not low <= area_m2 <= high:
        raise ValueError(
            f"{where}: area_m2 of {count} such rooms must be {low:g} to {high:g}, got {area_m2:g}"
        )


def _check_purposes(rooms: Sequence[Purpose], *, where: str) -> None:
    for purpose in rooms:
        if purpose not in PURPOSES:
            raise ValueError(f"{where}: rooms must be of {', '.join(PURPOSES)}, got {purpose!r}")
    for purpose, low, high in (("living", 1, 1), ("hall", 0, 1), ("kitchen", 0, 1)):
        if not low <= rooms.count(purpose) <= high:
            raise ValueError(
                f"{where}: rooms must have {'one' if low else 'at most one'} {purpose}, "
                f"got {rooms.count(purpose)}"
            )


def draw_program(count: int, area_m2: float, rng: np.random.Generator) -> tuple[Purpose, ...]:
    """Purposes of `count` rooms that an area suits, the living room first."""
    fitting = [
        program
        for program in _PROGRAMS
        if len(program) == count and area_limits(program)[0] <= area_m2 <= area_limits(program)[1]
    ]
    return fitting[int(rng.integers(len(fitting)))]


def room_areas(
    purposes: Sequence[Purpose], area_m2: float, rng: np.random.Generator
) -> dict[int, float]:
    """Floor of each room by its number, m2, which add up to `area_m2`; usual shares, give or take.

    Rooms that reach their least or most size leave the rest to the others.
    """
    sizes = [SIZES[purpose] for purpose in purposes]
    usual = np.array([size.usual_m2 for size in sizes]) * rng.uniform(0.87, 1.15, len(sizes))
    low, high = (
        np.array([getattr(size, field) for size in sizes]) for field in ("least_m2", "most_m2")
    )
    scale_low, scale_high = 0.0, 10.0
    for _ in range(50):
        scale = (scale_low + scale_high) / 2.0
        if np.clip(scale * usual, low, high).sum() < area_m2:
            scale_low = scale
        else:
            scale_high = scale
    areas = np.clip(scale_high * usual, low, high)
    return {number: float(area) for number, area in enumerate(areas)}
