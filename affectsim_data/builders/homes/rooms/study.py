"""Studies."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from affectsim_data.builders.homes import chairs, storage, tables
from affectsim_data.builders.homes.pieces import Furniture
from affectsim_data.builders.homes.placed import Placed, placed_before
from affectsim_data.builders.homes.rooms.groups import ARMCHAIRS, along, free_places
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_study"]


def furnish_study(job: Job) -> None:
    """A desk at a wall or facing the room, shelves, an armchair."""
    job.curtains()
    desk = _desk(job)
    for _ in range(2 + (job.area > 10.0)):
        job.shelf()
    if job.area > 8.0:
        job.floor.at_wall(job.make(*ARMCHAIRS, style="armchair"), prefer="corner", windows=True)
    job.floor.at_wall(job.make(partial(storage.dresser, width=0.6)), prefer="corner", front=0.5)
    if job.area > 12.0:
        job.floor.at_wall(job.make(storage.sideboard), prefer="center", front=0.5)
    job.floor_lamp()
    job.plants(1 + (job.area > 10.0))
    room = job.room
    middle = ((room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0)
    job.rug_under(*middle, min(job.size[1] - 1.6, 2.0), 1.4)
    if desk is not None:
        job.picture_over(desk)
    job.pictures(0.7, most=3)


def _desk(job: Job) -> Placed | None:
    chair = job.make(chairs.desk_chair, chairs.office_chair)
    facing = job.area > 11.0 and job.chance(0.45)
    for width in (1.6, 1.4, 1.1):
        desk = job.make(
            partial(tables.desk, width=width), partial(tables.desk_trestle, width=width)
        )
        groups = (_in_room, _at_wall) if facing else (_at_wall,)
        for group in groups:
            before = len(job.floor.placed)
            if job.floor.put_first(group(job, desk, chair), tries=10):
                placed = job.floor.placed[before]
                job.floor.on_top(placed, job.make(tables.monitor))
                return placed
    return None


def _with_chair(job: Job, desk: Placed, chair: Furniture) -> list[Placed]:
    """The chair pushed back from the desk and turned to one side."""
    turn = float(job.rng.choice([-1.0, 1.0])) * np.pi / 2.0
    gap = desk.piece.depth / 2.0 + chair.width / 2.0 + 0.08
    return [desk, desk.beside(chair, -0.1 * np.sign(turn), gap, turn=turn)]


def _at_wall(job: Job, desk: Furniture, chair: Furniture) -> Iterator[list[Placed]]:
    for wall in job.room.walls():
        for u in along(job, wall, desk):
            # A screen before a window is common; only what is higher than its sill hides it.
            yield _with_chair(job, placed_before(wall, desk, u), chair)


def _in_room(job: Job, desk: Furniture, chair: Furniture) -> Iterator[list[Placed]]:
    """Facing the room: the chair between the desk and a wall."""
    for place in free_places(job, desk, None):
        yield _with_chair(job, place, chair)
