"""Rectangles side by side on pages whose sides are powers of two."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

__all__ = ["Packing", "pack_rectangles"]

MIN_SIDE = 64


@dataclasses.dataclass(frozen=True)
class Packing:
    """Where rectangles lie."""

    places: tuple[tuple[int, int, int], ...]
    """Page, x and y of every rectangle, in the order they were given."""
    pages: tuple[tuple[int, int], ...]
    """Width and height of every page."""

    @property
    def area(self) -> int:
        """Of all pages."""
        return sum(width * height for width, height in self.pages)


def pack_rectangles(sizes: Sequence[tuple[int, int]], *, max_side: int) -> Packing:
    """Packs rectangles `(width, height)` in shelves, the highest first.

    One page as small as can be where that holds them, else pages of `max_side`, each cut to the
    power of two that holds what is on it.

    Raises:
        ValueError: A rectangle is larger than a page.
    """
    widest = max((max(size) for size in sizes), default=1)
    if widest > max_side:
        raise ValueError(f"a rectangle of {widest} does not fit a page of {max_side}")
    side = MIN_SIDE
    while side < max_side and (side < widest or side * side < sum(w * h for w, h in sizes)):
        side *= 2
    packing = _shelves(sizes, side)
    while len(packing.pages) > 1 and side < max_side:
        side *= 2
        packing = _shelves(sizes, side)
    return packing


def _shelves(sizes: Sequence[tuple[int, int]], side: int) -> Packing:
    order = sorted(range(len(sizes)), key=lambda i: (-sizes[i][1], -sizes[i][0], i))
    places = [(0, 0, 0)] * len(sizes)
    shelves: list[list[int]] = []  # page, top, used width
    bottoms: list[int] = []
    widths: list[int] = []
    for index in order:
        width, height = sizes[index]
        # No later rectangle is higher, so any shelf with room to the right will do.
        shelf = next((one for one in shelves if one[2] + width <= side), None)
        if shelf is None:
            page = next((p for p, used in enumerate(bottoms) if used + height <= side), None)
            if page is None:
                page = len(bottoms)
                bottoms.append(0)
                widths.append(0)
            shelf = [page, bottoms[page], 0]
            shelves.append(shelf)
            bottoms[page] += height
        places[index] = (shelf[0], shelf[2], shelf[1])
        shelf[2] += width
        widths[shelf[0]] = max(widths[shelf[0]], shelf[2])
    pages = [(_power(w), _power(h)) for w, h in zip(widths, bottoms, strict=True)]
    return Packing(tuple(places), tuple(pages))


def _power(size: int) -> int:
    return max(1 << (size - 1).bit_length(), MIN_SIDE)
