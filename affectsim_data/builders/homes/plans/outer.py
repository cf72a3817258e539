"""Openings of outer walls: the entrance and other closed doors, and windows."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.plans.draft import NoPlaceError, PlanDraft
from affectsim_data.builders.homes.plans.links import outside_spans
from affectsim_data.builders.homes.plans.model import SIDES, Leaf, Opening, Rect, Side, overlaps
from affectsim_data.builders.homes.purposes import NEEDS_DAYLIGHT, Purpose

__all__ = ["place_closed_doors", "place_windows"]

_LEAF_M = 0.9
_FREE_M = (1.24, 1.12)
"""Floor before a closed door, along its wall and away from it: somebody stands there and knocks."""
_MOST_CLOSED = 3
_ENTRANCES: tuple[Purpose, ...] = ("hall", "living", "kitchen", "dining", "study", "bedroom")
"""Rooms with the entrance, the first that has a place for it."""
_CLOSETS: tuple[Purpose, ...] = ("living", "bedroom", "hall", "kitchen", "study", "dining")


@dataclasses.dataclass(frozen=True)
class _WindowKind:
    """Windows of rooms of a purpose."""

    most: int
    width: tuple[float, float]
    bottom: float
    top: float
    curtains: float
    """How many of them have curtains."""


_WINDOWS: dict[Purpose, _WindowKind] = {
    "living": _WindowKind(3, (1.3, 2.4), 0.75, 2.2, 1.0),
    "dining": _WindowKind(2, (1.2, 2.0), 0.75, 2.2, 0.8),
    "bedroom": _WindowKind(2, (1.1, 1.7), 0.85, 2.2, 1.0),
    "study": _WindowKind(2, (1.0, 1.5), 0.85, 2.2, 0.6),
    "kitchen": _WindowKind(2, (0.9, 1.4), 1.1, 2.15, 0.0),
    "bath": _WindowKind(1, (0.55, 0.8), 1.45, 2.1, 0.0),
    "hall": _WindowKind(1, (0.6, 0.9), 1.1, 2.1, 0.0),
}
_CURTAIN_ROOM_M = 0.52
"""Wall beside a window that drawn-back curtains take."""
_BARE_ROOM_M = 0.3
_TWO_FROM_M = 5.2
"""A wall this long has two windows."""


def place_closed_doors(draft: PlanDraft, *, rng: np.random.Generator) -> None:
    """Adds an entrance and one to three other closed doors.

    Raises:
        NoPlaceError: There is no place for two doors.
    """
    for purpose in _ENTRANCES:
        if _place_door(draft, _rooms(draft, purpose), rng):
            break
    else:
        raise NoPlaceError("an entrance")
    wanted = int(rng.integers(1, _MOST_CLOSED + 1))
    if len(draft.rooms) <= 3:
        wanted = min(wanted, 2)
    rooms = [n for n, room in draft.rooms.items() if room.purpose in _CLOSETS]
    placed = 0
    for number in [rooms[i] for i in rng.permutation(len(rooms))]:
        placed += placed < wanted and _place_door(draft, [number], rng)
    if not placed and not any(_place_door(draft, [number], rng) for number in rooms):
        raise NoPlaceError("a second closed door")


def _rooms(draft: PlanDraft, purpose: Purpose) -> list[int]:
    return [number for number, room in draft.rooms.items() if room.purpose == purpose]


def _place_door(draft: PlanDraft, numbers: list[int], rng: np.random.Generator) -> bool:
    """Adds a closed door to one of some rooms, if it fits."""
    half = _FREE_M[0] / 2.0
    options: list[tuple[float, int, Side, float]] = []
    for number in numbers:
        for side in SIDES:
            for low, high in outside_spans(draft.layout, number, side):
                if high - low < _FREE_M[0]:
                    continue
                # At the ends of walls, so that the rest stays free; in the middle of short ones.
                places = {low + half + 0.02, high - half - 0.02, (low + high) / 2.0}
                short = high - low < 2.0
                for place in sorted(places):
                    middle = abs(place - (low + high) / 2.0) < 0.01
                    rank = (0.0 if middle == short else 1.0) + float(rng.random())
                    options.append((rank, number, side, round(place, 3)))
    for _, number, side, place in sorted(options):
        door = Opening(
            "door", side, place, _LEAF_M, 0.0, draft.door_top,
            leaf=Leaf("low" if rng.random() < 0.5 else "high"),
        )  # fmt: skip
        free = draft.rooms[number].wall(side).rect((place - half, place + half), _FREE_M[1])
        if _door_fits(draft, number, door, free):
            draft.add(number, door, clear=[free])
            return True
    return False


def _door_fits(draft: PlanDraft, number: int, door: Opening, free: Rect) -> bool:
    room = draft.rooms[number]
    x0, z0, x1, z1 = free
    if x0 < room.x0 - 1e-6 or z0 < room.z0 - 1e-6 or x1 > room.x1 + 1e-6 or z1 > room.z1 + 1e-6:
        return False
    for other in room.openings_in(door.side):
        if abs(other.middle - door.middle) < (other.width + door.width) / 2.0 + 0.25:
            return False
    return not draft.meets(number, free)


def place_windows(draft: PlanDraft, *, rng: np.random.Generator) -> None:
    """Adds windows to all rooms, the longest outer walls first.

    Raises:
        NoPlaceError: A room that people stay in has no place for one.
    """
    for number, room in draft.rooms.items():
        kind = _WINDOWS[room.purpose]
        beside = _CURTAIN_ROOM_M if kind.curtains > 0.5 else _BARE_ROOM_M
        spans = _window_spans(draft, number, kind, beside)
        count = 0
        for side, low, high in spans:
            two = high - low > _TWO_FROM_M and kind.most > 1
            for a, b in ((low, (low + high) / 2.0), ((low + high) / 2.0, high)) if two else (
                (low, high),
            ):  # fmt: skip
                if count < kind.most and (count == 0 or rng.random() < 0.7):
                    draft.add(number, _window(kind, side, a, b, beside, rng))
                    count += 1
        if not count and room.purpose in NEEDS_DAYLIGHT:
            raise NoPlaceError("a window")


def _window_spans(
    draft: PlanDraft, number: int, kind: _WindowKind, beside: float
) -> list[tuple[Side, float, float]]:
    """Free stretches of outer wall long enough for a window, longest first."""
    room = draft.rooms[number]
    found = []
    for side in SIDES:
        wall = room.wall(side)
        taken = [(o.span[0] - 0.12, o.span[1] + 0.12) for o in room.openings_in(side)]
        for rect in room.blocked:
            near = wall.rect(room.span(side), 0.35)
            if overlaps(near, rect):
                axis = 1 if side in ("left", "right") else 0
                taken.append((rect[axis], rect[axis + 2]))
        for low, high in _without(outside_spans(draft.layout, number, side), taken):
            if high - low >= kind.width[0] + 2.0 * beside:
                found.append((side, low, high))
    return sorted(found, key=lambda span: (round(span[1] - span[2], 3), span[0]))


def _without(
    spans: list[tuple[float, float]], taken: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """Spans less others."""
    for start, end in taken:
        spans = [
            part
            for low, high in spans
            for part in ((low, min(high, start)), (max(low, end), high))
            if part[1] > part[0]
        ]
    return spans


def _window(
    kind: _WindowKind, side: Side, low: float, high: float, beside: float,
    rng: np.random.Generator,
) -> Opening:  # fmt: skip
    room = high - low - 2.0 * beside
    width = round(min(room, float(rng.uniform(*kind.width))), 2)
    slack = min(max(room - width, 0.0) / 2.0, 0.4)
    middle = round((low + high) / 2.0 + float(rng.uniform(-slack, slack)), 3)
    curtains = bool(rng.random() < kind.curtains)
    return Opening("window", side, middle, width, kind.bottom, kind.top, curtains)
