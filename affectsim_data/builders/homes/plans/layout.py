"""Outlines cut into rooms: random slicing trees of the kinds that homes have, as rectangles.

A tree cuts a rectangle into strips, and those again. Its leaves are rooms, or parts of the outline
that stay empty: an empty corner makes the home L-shaped, an empty middle of a side U-shaped.
Rectangles here meet at the middle of walls.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.homes.plans.model import WALL_THICKNESS, Rect
from affectsim_data.builders.homes.purposes import Purpose

__all__ = ["Layout", "random_layout"]

_HALF_WALL = WALL_THICKNESS / 2.0
_CORRIDOR_M = (1.4, 1.75)
"""Width of halls that run along the rooms beside them."""
_VOID_SHARE = (0.07, 0.15)
_FITTING_STEPS = 4


@dataclasses.dataclass(frozen=True)
class _Cut:
    """Strips side by side along x (0) or z (1)."""

    axis: int
    parts: tuple[_Tree, ...]


_Tree = _Cut | int
"""A cut, a room by its number, or a void by a number below 0."""


@dataclasses.dataclass(frozen=True)
class Layout:
    """Rooms as rectangles that meet at the middle of walls, by number."""

    cells: dict[int, Rect]
    """Rooms only."""
    width: float
    """Of the outline's bounds along x, metres; their low corner is the origin."""
    depth: float

    def inner(self, number: int) -> Rect:
        """A room between its walls, metres."""
        x0, z0, x1, z1 = self.cells[number]
        return (x0 + _HALF_WALL, z0 + _HALF_WALL, x1 - _HALF_WALL, z1 - _HALF_WALL)

    def area_m2(self) -> float:
        """Floor of all rooms."""
        rects = map(self.inner, self.cells)
        return sum((x1 - x0) * (z1 - z0) for x0, z0, x1, z1 in rects)


def random_layout(
    purposes: Sequence[Purpose], areas: dict[int, float], *, rng: np.random.Generator
) -> Layout | None:
    """One random layout whose rooms have about these areas, m2; none if a void is not outside."""
    sizes = dict(areas)
    corridor = None
    tree = _random_tree(purposes, rng)
    if "hall" in purposes and _is_corridor(tree, purposes.index("hall")):
        corridor = purposes.index("hall")
    tree = _with_voids(tree, sizes, rng)
    breadth = float(rng.uniform(*_CORRIDOR_M)) + WALL_THICKNESS
    aspect = math.exp(float(rng.uniform(-0.55, 0.55)))
    wanted = sum(areas.values())
    gross = 1.12 * wanted
    for _ in range(_FITTING_STEPS):
        width, depth = math.sqrt(gross * aspect), math.sqrt(gross / aspect)
        cells: dict[int, Rect] = {}
        _lay(tree, (0.0, 0.0, width, depth), sizes, corridor, breadth, cells)
        layout = _rounded(cells, width, depth)
        gross *= wanted / max(layout.area_m2(), 1.0)
    if not _voids_are_outside(cells, layout):
        return None
    rooms = {number: rect for number, rect in layout.cells.items() if number >= 0}
    layout = dataclasses.replace(layout, cells=rooms)
    if abs(layout.area_m2() / wanted - 1.0) > 0.02:
        return None
    return layout


def _lay(
    tree: _Tree, rect: Rect, sizes: dict[int, float], corridor: int | None, breadth: float,
    cells: dict[int, Rect],
) -> None:  # fmt: skip
    """Fills `cells` with the rectangles of a tree in `rect`."""
    if isinstance(tree, int):
        cells[tree] = rect
        return
    low, high = rect[tree.axis], rect[tree.axis + 2]
    fixed = [part == corridor for part in tree.parts]
    shares = [
        0.0 if still else _size(part, sizes) for part, still in zip(tree.parts, fixed, strict=True)
    ]
    free = (high - low) - breadth * sum(fixed)
    place = low
    for part, share, still in zip(tree.parts, shares, fixed, strict=True):
        end = place + (breadth if still else free * share / max(sum(shares), 1e-9))
        inner = list(rect)
        inner[tree.axis], inner[tree.axis + 2] = place, end
        _lay(part, (inner[0], inner[1], inner[2], inner[3]), sizes, corridor, breadth, cells)
        place = end


def _size(tree: _Tree, sizes: dict[int, float]) -> float:
    if isinstance(tree, int):
        return sizes[tree]
    return sum(_size(part, sizes) for part in tree.parts)


def _rounded(cells: dict[int, Rect], width: float, depth: float) -> Layout:
    """To centimetres, voids left out."""
    rooms = {
        number: (round(x0, 2), round(z0, 2), round(x1, 2), round(z1, 2))
        for number, (x0, z0, x1, z1) in cells.items()
        if number >= 0
    }
    return Layout(rooms, round(width, 2), round(depth, 2))


def _voids_are_outside(cells: dict[int, Rect], layout: Layout) -> bool:
    for number, (x0, z0, x1, z1) in cells.items():
        inside = x0 > 0.01 and z0 > 0.01
        inside = inside and x1 < layout.width - 0.01 and z1 < layout.depth - 0.01
        if number < 0 and (inside or min(x1 - x0, z1 - z0) < 1.0):
            return False
    return True


def _is_corridor(tree: _Tree, hall: int) -> bool:
    """Whether the hall runs between or along strips of rooms."""
    if isinstance(tree, int):
        return False
    if hall in tree.parts:
        return any(isinstance(part, _Cut) for part in tree.parts)
    return any(_is_corridor(part, hall) for part in tree.parts)


def _with_voids(tree: _Tree, sizes: dict[int, float], rng: np.random.Generator) -> _Tree:
    """The tree with no, one or two empty places, whose sizes are added to `sizes`."""
    count = int(rng.choice([0, 1, 2], p=[0.5, 0.38, 0.12]))
    total = sum(sizes.values())
    for number in range(-1, -1 - count, -1):
        sizes[number] = float(rng.uniform(*_VOID_SHARE)) * total
        tree = _inserted(tree, number, rng)
    return tree


def _inserted(tree: _Tree, number: int, rng: np.random.Generator) -> _Tree:
    """The tree with one more leaf at a random place of one of its cuts."""
    if isinstance(tree, int):
        parts: list[_Tree] = [tree, number]
        return _Cut(int(rng.integers(2)), tuple(parts[:: int(rng.choice([-1, 1]))]))
    if rng.random() < 0.3:
        at = int(rng.integers(len(tree.parts) + 1))
        return _Cut(tree.axis, (*tree.parts[:at], number, *tree.parts[at:]))
    at = int(rng.integers(len(tree.parts)))
    inner = _inserted(tree.parts[at], number, rng)
    return _Cut(tree.axis, (*tree.parts[:at], inner, *tree.parts[at + 1 :]))


def _random_tree(purposes: Sequence[Purpose], rng: np.random.Generator) -> _Tree:
    """A tree of one of the kinds that homes have."""
    rooms = list(range(len(purposes)))
    axis = int(rng.integers(2))
    if "hall" in purposes:
        hall = purposes.index("hall")
        rest = [room for room in rooms if room != hall]
        kind = float(rng.random())
        if kind < 0.4:
            return _spine(hall, rest, purposes, axis, rng)
        if kind < 0.8:
            return _wing(hall, rest, purposes, axis, rng)
    elif rng.random() < 0.6:
        return _around_living(rooms, purposes, axis, rng)
    return _sliced([rooms[i] for i in rng.permutation(len(rooms))], axis, rng)


def _spine(
    hall: int, rest: list[int], purposes: Sequence[Purpose], axis: int, rng: np.random.Generator
) -> _Tree:
    """Rooms on both sides of a hall; those for the day are kept together."""
    day = [room for room in rest if purposes[room] in ("living", "kitchen", "dining")]
    night = [room for room in rest if room not in day]
    moved = int(rng.integers(0, max(len(night) - 1, 0) + 1)) if len(day) < 3 else 0
    night = [night[i] for i in rng.permutation(len(night))]
    one, other = [*_shuffled(day, rng), *night[:moved]], night[moved:]
    if not other:
        one, other = one[:-1], one[-1:]
    if rng.random() < 0.5:
        one, other = other, one
    return _strips(axis, one, hall, other)


def _wing(
    hall: int, rest: list[int], purposes: Sequence[Purpose], axis: int, rng: np.random.Generator
) -> _Tree:
    """Rooms for the day at one end, a hall from there between or along the others."""
    day = [room for room in rest if purposes[room] in ("living", "kitchen", "dining")]
    others = [room for room in rest if room not in day]
    if len(day) > 1 and rng.random() < 0.35:
        others.append(day.pop())
    others = _shuffled(others, rng)
    split = int(rng.integers(0, len(others) + 1))
    across = _strips(1 - axis, others[:split], hall, others[split:])
    front = _row(_shuffled(day, rng), 1 - axis if rng.random() < 0.7 else axis)
    ends: list[_Tree] = [front, across]
    return _Cut(axis, tuple(ends[:: int(rng.choice([-1, 1]))]))


def _around_living(
    rooms: list[int], purposes: Sequence[Purpose], axis: int, rng: np.random.Generator
) -> _Tree:
    """The living room with a strip of rooms at one or two of its sides."""
    rest = _shuffled([room for room in rooms if purposes[room] != "living"], rng)
    living = purposes.index("living")
    split = int(rng.integers(0, len(rest) + 1))
    if rng.random() < 0.5:
        return _strips(axis, rest[:split], living, rest[split:])
    block: _Tree = _Cut(axis, (living, *rest[:split])) if split else living
    return block if split == len(rest) else _Cut(1 - axis, (block, _row(rest[split:], axis)))


def _row(rooms: list[int], axis: int) -> _Tree:
    """Rooms side by side, at least one."""
    return rooms[0] if len(rooms) == 1 else _Cut(axis, tuple(rooms))


def _strips(axis: int, before: list[int], middle: int, after: list[int]) -> _Tree:
    """A room between two rows of rooms, either of which may be empty."""
    parts: list[_Tree] = [middle]
    if before:
        parts.insert(0, _row(before, 1 - axis))
    if after:
        parts.append(_row(after, 1 - axis))
    return middle if len(parts) == 1 else _Cut(axis, tuple(parts))


def _sliced(rooms: list[int], axis: int, rng: np.random.Generator) -> _Tree:
    """Any slicing tree of the rooms."""
    if len(rooms) == 1:
        return rooms[0]
    split = int(rng.integers(1, len(rooms)))
    turned = axis if rng.random() < 0.2 else 1 - axis
    return _Cut(axis, (_sliced(rooms[:split], turned, rng), _sliced(rooms[split:], turned, rng)))


def _shuffled(rooms: list[int], rng: np.random.Generator) -> list[int]:
    return [rooms[i] for i in rng.permutation(len(rooms))]
