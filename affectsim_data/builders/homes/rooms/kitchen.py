"""Kitchens: counters along walls, a fridge, an island or a small table."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from affectsim_data.builders.homes import chairs, kitchen
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.placed import Placed, placed_before
from affectsim_data.builders.homes.rooms.groups import place_dining
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_kitchen"]

_FRONT_M = 0.75
"""Floor to keep free before counters."""
_LENGTHS = (3.6, 3.0, 2.4, 1.8, 1.2)


def furnish_kitchen(job: Job) -> None:
    """A counter with sink and hob, the fridge at its end, more counters, a place to eat."""
    job.curtains()
    main = _main_counter(job)
    if main is not None:
        _second_counter(job, main)
    _eat(job, main)
    if job.area > 9.0:
        job.shelf(widths=(0.9, 0.6))
    job.plants(1 + (job.area > 12.0))
    job.pictures(0.6, most=2)


def _blank(width: float) -> Furniture:
    """The room that a counter takes; it is made when its place is known."""
    return Furniture((), width, kitchen.COUNTER_ROOM, kitchen.COUNTER_Y, category="counter")


def _main_counter(job: Job) -> Placed | None:
    """The longest counter that fits with the fridge beside it, with wall cabinets over it."""
    fridge = job.make(
        *((kitchen.fridge, kitchen.fridge_steel) if job.area > 10.0 else (kitchen.fridge,))
    )
    for length in _LENGTHS:
        if job.floor.put_first(_runs(job, _blank(length), fridge), tries=6):
            run = next(p for p in reversed(job.floor.placed) if p.piece.category == "counter")
            return _with_uppers(job, run)
    for length in _LENGTHS[2:]:
        placed = job.floor.at_wall(_blank(length), prefer="corner", front=_FRONT_M)
        if placed is not None:
            job.floor.at_wall(fridge, prefer="corner", front=0.6)
            return _with_uppers(job, placed)
    job.floor.at_wall(fridge, prefer="corner", front=0.6)
    return None


def _runs(job: Job, counter: Furniture, fridge: Furniture) -> Iterator[list[Placed]]:
    """A counter with the fridge at one of its ends, along every wall."""
    width = counter.width + fridge.width + 0.01
    walls = job.walls_by_length()
    for wall in walls:
        slack = wall.length - width - 0.05
        if slack < 0.0:
            continue
        for start in sorted({0.025, slack + 0.025, *np.arange(0.1, slack, 0.3)}):
            for first in (True, False) if job.chance(0.5) else (False, True):
                left = fridge if first else counter
                right = counter if first else fridge
                a = placed_before(wall, left, start + left.width / 2.0)
                u = start + left.width + 0.01 + right.width / 2.0
                b = placed_before(wall, right, u)
                if any(
                    job.floor.hides_window(p.piece, wall, at)
                    for p, at in ((a, start + left.width / 2.0), (b, u))
                ):
                    continue
                yield [a, b] if left is fridge else [b, a]


def _with_uppers(job: Job, run: Placed, *, hob: bool = True, sink: bool = True) -> Placed:
    """The counter, made with wall cabinets wherever nothing is above it."""
    wall = job.wall_behind(run)
    u, half = job.along_wall(run), run.piece.width / 2.0
    spans = [(u - half, u + half)]
    for opening in job.room.openings_in(wall.side):
        reach, middle = opening.width / 2.0 + 0.14, wall.u_of(opening.middle)
        spans = [
            part
            for low, high in spans
            for part in ((low, min(high, middle - reach)), (max(low, middle + reach), high))
            if part[1] - part[0] >= 0.35
        ]
    # Somebody who looks at a wall sees a piece's +x on the right, as `along` runs.
    uppers = tuple((low - u, high - u) for low, high in spans)
    width = run.piece.width
    made = partial(kitchen.counter, width=width, hob=hob, sink=sink, uppers=uppers)
    return job.floor.replace(run, job.make(made))


def _second_counter(job: Job, main: Placed) -> None:
    """A shorter counter at another wall, in an L or opposite."""
    if job.area < 7.0:
        return
    for length in (2.4, 1.8, 1.2, 0.6):
        placed = job.floor.at_wall(_blank(length), prefer="corner", front=_FRONT_M)
        if placed is not None:
            _with_uppers(job, placed, hob=False, sink=False)
            return


def _eat(job: Job, main: Placed | None) -> None:
    """An island with stools before the main counter, else a table with chairs."""
    if main is not None and job.area > 13.0 and job.chance(0.6) and _island(job, main):
        return
    if job.area > 8.0:
        place_dining(job, most=4 if job.area > 13.0 else 2)


def _island(job: Job, main: Placed) -> bool:
    stool = job.make(chairs.bar_stool)
    for width in (2.1, 1.6):
        island = job.make(partial(kitchen.island, width=width))
        groups = []
        for gap in (1.05, 1.25, 1.5):
            for shift in (0.0, -0.4, 0.4, -0.8, 0.8):
                z = main.piece.depth / 2.0 + gap + island.depth / 2.0
                block = main.beside(island, shift, z, turn=np.pi)
                count = 3 if width > 2.0 else 2
                xs = (np.arange(count) - (count - 1) / 2.0) * 0.58
                back = -island.depth / 2.0 - 0.02
                stools = [block.beside(stool, float(x), back) for x in xs]
                groups.append([block, *stools])
        if job.floor.put_first(groups, tries=8):
            return True
    return False
