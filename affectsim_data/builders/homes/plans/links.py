"""Which rooms open into which: the walls they share, and the doorways a home would have there."""

from __future__ import annotations

import dataclasses
import heapq
import itertools
from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.homes.plans.layout import Layout
from affectsim_data.builders.homes.plans.model import WALL_THICKNESS, Side
from affectsim_data.builders.homes.purposes import Purpose

__all__ = ["Link", "SharedWall", "choose_links", "link_cost", "outside_spans", "shared_walls"]

DOOR_ROOM_M = 1.32
"""Least length of wall that a door, its casing and its open leaf need."""
_WIDE_M = (1.6, 3.0)
_MAX_LOOPS = 2
_LOOP_CHANCE = 0.65

_COSTS: dict[frozenset[Purpose], float] = {
    frozenset({"living", "kitchen"}): 1.0,
    frozenset({"living", "dining"}): 0.8,
    frozenset({"living", "hall"}): 1.0,
    frozenset({"living", "study"}): 4.0,
    frozenset({"living", "bedroom"}): 4.5,
    frozenset({"living", "bath"}): 6.0,
    frozenset({"dining", "kitchen"}): 1.2,
    frozenset({"dining", "study"}): 6.0,
    frozenset({"dining", "hall"}): 2.5,
    frozenset({"kitchen", "hall"}): 2.5,
    frozenset({"hall", "bedroom"}): 1.0,
    frozenset({"hall", "study"}): 1.0,
    frozenset({"hall", "bath"}): 0.9,
    frozenset({"bedroom", "bath"}): 5.0,
    frozenset({"bedroom", "study"}): 9.0,
    frozenset({"kitchen", "study"}): 11.0,
}
"""How unusual a doorway between two rooms is."""
_UNUSUAL = 16.0
_LOOPS: tuple[frozenset[Purpose], ...] = (
    frozenset({"kitchen", "hall"}), frozenset({"living", "hall"}), frozenset({"dining", "hall"}),
    frozenset({"kitchen", "dining"}), frozenset({"living", "dining"}),
    frozenset({"living", "kitchen"}), frozenset({"living", "study"}),
    frozenset({"study", "bedroom"}), frozenset({"bedroom", "living"}),
)  # fmt: skip
"""Rooms that may be joined though there is another way between them."""
_OPEN: dict[frozenset[Purpose], float] = {
    frozenset({"living", "kitchen"}): 0.6,
    frozenset({"living", "dining"}): 0.8,
    frozenset({"kitchen", "dining"}): 0.4,
}
"""How often a wide opening without a leaf joins two rooms."""


@dataclasses.dataclass(frozen=True)
class SharedWall:
    """Where two rooms lie side by side."""

    first: int
    """Number of a room."""
    second: int
    side: Side
    """Of the first room; of the second it is the opposite one."""
    low: float
    """Least x or z that belongs to both rooms' walls, metres."""
    high: float

    @property
    def length(self) -> float:
        """Metres."""
        return self.high - self.low

    @property
    def rooms(self) -> frozenset[int]:
        """Both numbers."""
        return frozenset({self.first, self.second})


@dataclasses.dataclass(frozen=True)
class Link:
    """A doorway to be made."""

    wall: SharedWall
    width: float
    """Metres; more than 1.5 is an open passage."""


def shared_walls(layout: Layout) -> list[SharedWall]:
    """Every pair of rooms with a wall between them, in the order of their numbers."""
    walls = []
    for i, j in itertools.combinations(sorted(layout.cells), 2):
        a, b = layout.cells[i], layout.cells[j]
        for axis, low_side, high_side in ((0, "left", "right"), (1, "back", "front")):
            low = max(a[1 - axis], b[1 - axis]) + WALL_THICKNESS / 2.0
            high = min(a[3 - axis], b[3 - axis]) - WALL_THICKNESS / 2.0
            if high - low <= 0.0:
                continue
            if abs(a[axis + 2] - b[axis]) < 1e-6:
                walls.append(SharedWall(i, j, _side(high_side), low, high))
            elif abs(b[axis + 2] - a[axis]) < 1e-6:
                walls.append(SharedWall(i, j, _side(low_side), low, high))
    return walls


def outside_spans(layout: Layout, number: int, side: Side) -> list[tuple[float, float]]:
    """Parts of a room's wall behind which there is no room, world x or z, metres."""
    axis = 0 if side in ("left", "right") else 1
    near = axis if side in ("left", "back") else axis + 2
    rect, place = layout.inner(number), layout.cells[number][near]
    spans = [(rect[1 - axis], rect[3 - axis])]
    for other, cell in layout.cells.items():
        if other == number or abs(cell[(near + 2) % 4] - place) > 1e-6:
            continue
        low, high = cell[1 - axis] - 0.05, cell[3 - axis] + 0.05
        spans = [
            part
            for start, end in spans
            for part in ((start, min(end, low)), (max(start, high), end))
            if part[1] - part[0] > 0.3
        ]
    return spans


def _side(name: str) -> Side:
    sides: dict[str, Side] = {"left": "left", "right": "right", "back": "back", "front": "front"}
    return sides[name]


def link_cost(first: Purpose, second: Purpose) -> float:
    """How unusual a doorway between two rooms is, 1 for one that most homes have."""
    return _COSTS.get(frozenset({first, second}), _UNUSUAL)


def choose_links(
    purposes: Sequence[Purpose], walls: Sequence[SharedWall], *, rng: np.random.Generator
) -> tuple[list[Link], float] | None:
    """Doorways that join all rooms, and how unusual they are together; none if rooms are cut off.

    Nobody walks through a bath, and through a bedroom only where there is no other way. Some homes
    have a second way between two rooms.
    """
    usable = [wall for wall in walls if wall.length >= DOOR_ROOM_M]
    chosen, cost = _spanning(purposes, usable)
    if len(chosen) < len(purposes) - 1 or ("hall" in purposes and cost >= _UNUSUAL):
        return None
    extra = [
        wall
        for wall in usable
        if wall not in chosen and frozenset(purposes[number] for number in wall.rooms) in _LOOPS
    ]
    for wall in [extra[i] for i in rng.permutation(len(extra))][:_MAX_LOOPS]:
        if rng.random() < _LOOP_CHANCE:
            chosen.append(wall)
    return [Link(wall, _width(purposes, wall, rng)) for wall in chosen], cost


def _spanning(
    purposes: Sequence[Purpose], walls: Sequence[SharedWall]
) -> tuple[list[SharedWall], float]:
    """The cheapest tree from the living room that does not lead through baths (Prim)."""
    start = purposes.index("living")
    reached, chosen, total = {start}, [], 0.0
    queue = [
        (_cost(purposes, wall, start), k) for k, wall in enumerate(walls) if start in wall.rooms
    ]
    heapq.heapify(queue)
    while queue:
        cost, index = heapq.heappop(queue)
        wall = walls[index]
        if wall.rooms <= reached:
            continue
        (new,) = wall.rooms - reached
        reached.add(new)
        chosen.append(wall)
        total += cost
        if purposes[new] != "bath":
            for k, other in enumerate(walls):
                if new in other.rooms and not other.rooms <= reached:
                    heapq.heappush(queue, (_cost(purposes, other, new), k))
    return chosen, total


def _cost(purposes: Sequence[Purpose], wall: SharedWall, passed: int) -> float:
    """Of a doorway by which one comes out of the room `passed`."""
    cost = link_cost(purposes[wall.first], purposes[wall.second])
    (new,) = wall.rooms - {passed}
    if purposes[passed] == "bedroom" and purposes[new] != "bath":
        cost += _UNUSUAL
    return cost


def _width(purposes: Sequence[Purpose], wall: SharedWall, rng: np.random.Generator) -> float:
    chance = _OPEN.get(frozenset({purposes[wall.first], purposes[wall.second]}), 0.0)
    most = min(_WIDE_M[1], wall.length - 0.4)
    if most >= _WIDE_M[0] and rng.random() < chance:
        return round(float(rng.uniform(_WIDE_M[0], most)), 2)
    return round(float(rng.uniform(0.92, 0.98)), 2)
