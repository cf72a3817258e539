"""Pieces that belong together: sofa with table and chairs, table with its chairs."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from functools import partial

import numpy as np

from affectsim_data.builders.homes import lamps, seating, tables
from affectsim_data.builders.homes.pieces import Design, Furniture
from affectsim_data.builders.homes.placed import Placed, wall_places
from affectsim_data.builders.homes.plans import Wall
from affectsim_data.builders.homes.rooms.job import CHAIRS, Job

__all__ = [
    "ARMCHAIRS", "COFFEE_TABLES", "along", "dining_group", "free_places", "place_dining",
    "seated_group", "sofas",
]  # fmt: skip

ARMCHAIRS: tuple[Design, ...] = (
    seating.armchair_wooden, seating.armchair_cushioned, seating.armchair_tub,
)  # fmt: skip
COFFEE_TABLES: tuple[Design, ...] = (
    tables.coffee_plain, tables.coffee_round, tables.coffee_oval, tables.coffee_block,
)  # fmt: skip
_BEFORE_SOFA_M, _BESIDE_TABLE_M = 0.72, 0.6
"""Between a sofa or an armchair and the table before it: a robot gets to whoever sits there."""
_BACK_M = 0.16
"""Armchairs beside the table stand that much further from the sofa than its middle."""
_PENDANT_Y = 1.55
"""Underside of a lamp over a table."""


def sofas(places: int) -> tuple[Design, ...]:
    """Straight sofas for so many."""
    return tuple(
        partial(design, places=places)
        for design in (seating.sofa_boxy, seating.sofa_rolled, seating.sofa_wooden)
    )


def seated_group(
    sofa: Placed, table: Furniture, chair: Furniture, *, chairs: int, jitter: float
) -> list[Placed]:
    """A sofa, the low table before it and up to three armchairs around that.

    Args:
        sofa: At its place.
        table: The low table.
        chair: The armchair, used for all of them.
        chairs: How many: beside the table left, right, and opposite the sofa.
        jitter: Radians the chairs are turned towards the sofa.
    """
    z = sofa.piece.depth / 2.0 + _BEFORE_SOFA_M + table.depth / 2.0
    group = [sofa, sofa.beside(table, 0.0, z)]
    aside = table.width / 2.0 + _BESIDE_TABLE_M + chair.depth / 2.0
    opposite = z + table.depth / 2.0 + _BESIDE_TABLE_M + chair.depth / 2.0
    places = (
        (aside, z + _BACK_M, -np.pi / 2.0 - jitter),
        (-aside, z + _BACK_M, np.pi / 2.0 + jitter),
        (0.0, opposite, np.pi + jitter),
    )
    group += [sofa.beside(chair, x, at, turn=turn) for x, at, turn in places[:chairs]]
    return group


def dining_group(
    table: Placed, chair: Furniture, *, count: int, round_top: bool, turned: tuple[bool, ...],
    tuck: float,
) -> list[Placed]:  # fmt: skip
    """A table and its chairs.

    Chairs at the long sides are tucked in, or turned outwards along the table so that one can sit
    down; the others lose their seats. A pair more stands at the ends of larger tables.

    Args:
        table: At its place.
        chair: Used for all.
        count: Chairs, an even number.
        round_top: Whether the chairs stand around a round table.
        turned: For every chair, whether it is turned outwards.
        tuck: Metres that tucked chairs reach under the table.
    """
    in_place = dataclasses.replace(chair, seats=())
    group = [table]
    half = table.piece.depth / 2.0
    if round_top:
        for k in range(count):
            angle = 2.0 * np.pi * k / count
            reach = half + chair.depth / 2.0 - tuck
            x, z = reach * np.sin(angle), reach * np.cos(angle)
            group.append(table.beside(in_place, float(x), float(z), turn=angle + np.pi))
        return group
    per_side = count // 2 if count <= 6 else 3
    room = table.piece.width - 0.24
    xs = (np.arange(per_side) + 0.5) * room / per_side - room / 2.0
    index = 0
    for side in (-1.0, 1.0):
        for x in xs:
            outward = turned[index] and abs(x) > 0.1
            index += 1
            if outward:
                z = side * (half + chair.width / 2.0 + 0.02)
                turn = np.copysign(np.pi / 2.0, x)
                group.append(table.beside(chair, float(x), float(z), turn=float(turn)))
            else:
                z = side * (half + chair.depth / 2.0 - tuck)
                turn = np.pi if side > 0.0 else 0.0
                group.append(table.beside(in_place, float(x), float(z), turn=turn))
    if count > 6:
        x = table.piece.width / 2.0 + chair.depth / 2.0 - 0.02
        group += [table.beside(in_place, s * x, 0.0, turn=-s * np.pi / 2.0) for s in (-1.0, 1.0)]
    return group


def place_dining(job: Job, *, most: int, middle: tuple[float, float] | None = None) -> bool:
    """A dining table with up to `most` chairs where there is room for it, and a lamp over it."""
    chair = job.make(*CHAIRS, style="dining chair")
    for count in (8, 6, 4, 2):
        if count > most:
            continue
        for free in (True, False):
            table, round_top, tuck = _dining_table(job, count)
            turned = tuple(bool(free and draw < 0.5) for draw in job.rng.random(count))
            if free and not any(turned):
                turned = (True, *turned[1:])
            if _put_somewhere(job, table, chair, count, round_top, turned, tuck, middle):
                _lamp_over(job)
                return True
    return False


def _dining_table(job: Job, count: int) -> tuple[Furniture, bool, float]:
    """A table for so many, whether it is round, and how far chairs reach under it."""
    if count <= 4 and job.chance(0.35):
        width = 1.1 if count == 4 else 0.85
        return job.make(partial(tables.dining_round, width=width)), True, 0.1
    width = {2: 0.8, 4: 1.4, 6: 1.9, 8: 2.1}[count] + float(job.rng.uniform(0.0, 0.15))
    designs: list[Design] = [partial(tables.dining_plain, width=width)]
    if count >= 4:
        designs.append(partial(tables.dining_trestle, width=width))
    if count == 6:
        designs.append(partial(tables.dining_oval, width=width))
    return job.make(*designs), False, 0.18


def _put_somewhere(
    job: Job, table: Furniture, chair: Furniture, count: int, round_top: bool,
    turned: tuple[bool, ...], tuck: float, middle: tuple[float, float] | None,
) -> bool:  # fmt: skip
    groups = (
        dining_group(place, chair, count=count, round_top=round_top, turned=turned, tuck=tuck)
        for place in free_places(job, table, middle)
    )
    return job.floor.put_first(groups)


def free_places(
    job: Job, piece: Furniture, middle: tuple[float, float] | None, *, step: float = 0.25
) -> Iterator[Placed]:
    """Places all over the floor in both directions, those near `middle` first."""
    room, rng = job.room, job.rng
    xs, zs = (
        np.arange(room.x0 + 0.5, room.x1 - 0.4, step),
        np.arange(room.z0 + 0.5, room.z1 - 0.4, step),
    )
    x, z, turned = (a.ravel() for a in np.meshgrid(xs, zs, [0.0, 1.0], indexing="ij"))
    goal = middle or ((room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0)
    weight = 1.0 if middle is None else 0.6
    cost = weight * np.hypot(x - goal[0], z - goal[1]) + rng.uniform(0.0, 0.6, len(x))
    free = job.floor.open_at(piece, x, z, turned)
    for k in np.argsort(cost):
        if free[k]:
            yield Placed(piece, float(x[k]), float(z[k]), float(turned[k]) * np.pi / 2.0)


def _lamp_over(job: Job) -> None:
    """A lamp over the table placed last, unless a ceiling lamp hangs there."""
    table = next(p for p in reversed(job.floor.placed) if p.piece.category == "table")
    if not job.bare_of_lamps(table.x, table.z):
        return
    drop = job.room.ceiling_y - _PENDANT_Y
    designs = [
        partial(design, drop=drop)
        for design in (lamps.pendant_cone, lamps.pendant_globe, lamps.pendant_drum)
    ]
    job.floor.drop_from_ceiling(job.make(*designs), table.x, table.z)


def along(job: Job, wall: Wall, piece: Furniture, *, step: float = 0.2) -> list[float]:
    """Places along a wall for a piece's middle, from its middle outwards, with some disorder."""
    _, us = wall_places(wall, piece, step=step)
    us = job.floor.open_along(wall, piece, us)
    away = np.abs(us - wall.length / 2.0) + job.rng.uniform(0.0, 0.8, len(us))
    return [float(u) for u in us[np.argsort(away)]]
