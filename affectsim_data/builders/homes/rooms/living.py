"""Living rooms: where one sits together, and what fills the rest of a large room."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from affectsim_data.builders.homes import decor, dividers, seating, storage, tables
from affectsim_data.builders.homes.pieces import Design, Furniture
from affectsim_data.builders.homes.placed import Placed, placed_before
from affectsim_data.builders.homes.rooms.groups import (
    ARMCHAIRS,
    COFFEE_TABLES,
    along,
    place_dining,
    seated_group,
    sofas,
)
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_living"]

_LARGE_M2, _HUGE_M2 = 22.0, 32.0
_DIVIDER_FROM_M = 5.6
_VIEW_M = 2.3
"""Before a sofa nothing else is put."""


def furnish_living(job: Job) -> None:
    """Sofa and table first, then what they look at, then whatever still has room."""
    job.curtains()
    sofa = _sit_together(job)
    if sofa is not None and not any(p.piece.category == "tv" for p in job.floor.placed):
        _view(job, sofa)
    if sofa is not None:
        front = sofa.piece.depth / 2.0
        job.floor.keep_free(sofa.before(front, front + _VIEW_M, width=1.4))
    large, huge = job.area >= _LARGE_M2, job.area >= _HUGE_M2
    if large and "dining" not in job.purposes:
        place_dining(job, most=6 if huge else 4)
    if job.size[1] >= _DIVIDER_FROM_M:
        _divide(job)
    if huge and job.chance(0.6):
        piano = job.make(dividers.piano)
        job.floor.at_wall(piano, front=0.7)
    _cabinet(job)
    for _ in range(1 + large + huge):
        job.shelf()
    if large:
        _reading_corner(job)
    if huge and "study" not in job.purposes and job.chance(0.6):
        job.floor.at_wall(job.make(tables.desk), front=0.6)
    if not any(p.piece.category == "lamp" for p in job.floor.placed if p.support == "floor"):
        job.floor_lamp(None if sofa is None else (sofa.x, sofa.z))
    job.floor.at_wall(job.make(seating.pouf), prefer="any", windows=True)
    job.plants(3 + large + huge)
    if sofa is not None:
        _rug(job, sofa)
        job.picture_over(sofa)
    job.pictures(0.75, most=4 + 2 * large)


def _sofa_designs(job: Job) -> list[tuple[Design, ...]]:
    """Sofas from the largest the room should have to the smallest."""
    corner = tuple(partial(seating.sofa_corner, places=2, right=right) for right in (True, False))
    wide = [corner] if job.area > 20.0 and job.chance(0.35) else []
    return [*wide, sofas(3), sofas(2)] if job.area > 16.0 else [sofas(2)]


def _sit_together(job: Job) -> Placed | None:
    """The lounge; the sofa as it was placed, or none if even two armchairs had no room."""
    table, chair = job.make(*COFFEE_TABLES), job.make(*ARMCHAIRS, style="armchair")
    facing = job.chance(0.45)
    for designs in _sofa_designs(job):
        sofa = job.make(*designs)
        for makers in (_facing, _against) if facing else (_against, _facing):
            before = len(job.floor.placed)
            for chairs in (2, 1, 0):
                if job.floor.put_first(makers(job, sofa, table, chair, chairs), tries=8):
                    placed = job.floor.placed[before:]
                    for base in [p for p in placed if p.piece.category == "cabinet"]:
                        job.floor.on_top(base, _television(job, base.piece))
                    return next(p for p in placed if p.piece.category == "sofa")
    small = job.make(*sofas(2))
    found = job.floor.at_wall(small, prefer="center", windows=True)
    if found is None:
        for _ in range(2):
            job.floor.at_wall(chair, prefer="corner", windows=True)
    return found


def _against(
    job: Job, sofa: Furniture, table: Furniture, chair: Furniture, chairs: int
) -> Iterator[list[Placed]]:
    """The sofa with its back to a wall."""
    walls = job.walls_by_length()
    first = job.rng.permutation(2)
    for wall in [walls[first[0]], walls[first[1]], *walls[2:]]:
        for u in along(job, wall, sofa):
            jitter = float(job.rng.uniform(0.0, 0.25))
            yield seated_group(
                placed_before(wall, sofa, u), table, chair, chairs=chairs, jitter=jitter
            )


def _facing(
    job: Job, sofa: Furniture, table: Furniture, chair: Furniture, chairs: int
) -> Iterator[list[Placed]]:
    """A television at a wall and the sofa before it, its back to the room."""
    board = _board(job)
    for wall in job.room.walls():
        for u in along(job, wall, board, step=0.3):
            base = placed_before(wall, board, u)
            gap = float(job.rng.uniform(1.95, 2.3))
            z = board.depth / 2.0 + gap + sofa.depth / 2.0
            seat = base.beside(sofa, 0.0, z, turn=np.pi)
            yield [base, *seated_group(seat, table, chair, chairs=chairs, jitter=0.1)]


def _board(job: Job) -> Furniture:
    width = 1.7 if job.area > 18.0 else 1.4
    designs = (partial(storage.tv_board, width=width), partial(storage.tv_frame, width=width))
    return job.make(*designs, style="tv board")


def _television(job: Job, board: Furniture) -> Furniture:
    width = min(float(job.rng.uniform(1.05, 1.3)), board.width - 0.1)
    return job.make(partial(decor.tv, width=width))


def _view(job: Job, sofa: Placed) -> None:
    """What one looks at from the sofa: a television, or a fireplace."""
    ahead = sofa.world(0.0, 4.0)
    room = job.room
    near = (float(np.clip(ahead[0], room.x0, room.x1)), float(np.clip(ahead[1], room.z0, room.z1)))
    if job.chance(0.25):
        hearth = job.make(dividers.fireplace)
        if job.floor.at_wall(hearth, near=near, front=0.6) is not None:
            return
    board = _board(job)
    base = job.floor.at_wall(board, near=near, front=0.5)
    if base is not None:
        job.floor.on_top(base, _television(job, board))


def _divide(job: Job) -> None:
    """A shelf, half wall or screen that stands out into the room, so that ways go around it."""
    short, _ = job.size
    lengths = [length for length in (2.4, 1.8, 1.2) if length <= short - 1.9]
    for length in lengths:
        designs: tuple[Design, ...] = (
            partial(dividers.room_divider, width=length),
            partial(dividers.partition, width=length),
        )
        if job.floor.put_first(_across(job, job.make(*designs)), tries=12):
            return
    screen = job.make(dividers.folding_screen)
    job.floor.put_first(_across(job, screen), tries=8)


def _across(job: Job, piece: Furniture) -> Iterator[list[Placed]]:
    """Places at right angles to the long walls, one end against them, inner ones first."""
    for wall in job.walls_by_length()[:2]:
        places = np.arange(1.6, wall.length - 1.5, 0.2)
        order = np.argsort(
            np.abs(places - wall.length / 2.0) + job.rng.uniform(0.0, 1.5, len(places))
        )
        for u in places[order]:
            x, _, z = wall.point(float(u), 0.0, piece.width / 2.0 + 0.021)
            turn = np.pi / 2.0 if job.chance(0.5) else -np.pi / 2.0
            yield [Placed(piece, float(x), float(z), wall.yaw + turn)]


def _cabinet(job: Job) -> None:
    for width in (1.6, 1.2, 0.8):
        designs = (
            partial(storage.sideboard, width=width), partial(storage.sideboard_open, width=width),
        )  # fmt: skip
        placed = job.floor.at_wall(job.make(*designs), prefer="center", front=0.5)
        if placed is not None:
            job.picture_over(placed)
            return


def _reading_corner(job: Job) -> None:
    """An armchair with a small table and a lamp beside it."""
    chair, table = job.make(*ARMCHAIRS, style="armchair"), job.make(tables.side_table)
    for wall in job.room.walls():
        for u in along(job, wall, chair, step=0.35):
            seat = placed_before(wall, chair, u, out=0.12)
            x = (chair.width + table.width) / 2.0 + 0.03
            side = seat.beside(table, x, -chair.depth / 2.0 + table.depth / 2.0)
            if job.floor.put_first([[seat, side]], tries=3):
                job.lamp_on(side)
                return


def _rug(job: Job, sofa: Placed) -> None:
    """A rug before the sofa, under the table, or under all of them."""
    front = sofa.piece.depth / 2.0
    yaw = sofa.yaw
    for width, depth, z in ((3.4, 3.6, 0.7), (2.4, 1.9, front + 1.0), (1.9, 1.5, front + 0.8)):
        x, at = sofa.world(0.0, z)
        if job.rug_under(x, at, width, depth, yaw=yaw):
            return
