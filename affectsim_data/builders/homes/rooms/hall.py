"""Halls and corridors."""

from __future__ import annotations

from functools import partial

import numpy as np

from affectsim_data.builders.homes import chairs, decor, storage
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_hall"]


def furnish_hall(job: Job) -> None:
    """Coats, shoes, a bench, a looking-glass, a runner."""
    job.curtains()
    if job.size[0] > 1.7:
        for width in (1.5, 1.0):
            wardrobe = job.make(partial(storage.wardrobe, width=width))
            if job.floor.at_wall(wardrobe, prefer="corner", front=0.6) is not None:
                break
    _coats(job)
    for width in (1.1, 0.8, 0.6):
        cabinet = job.make(partial(storage.shoe_cabinet, width=width))
        placed = job.floor.at_wall(cabinet, front=0.4)
        if placed is not None:
            wall, u = job.wall_behind(placed), job.along_wall(placed)
            job.floor.hang(wall, job.make(decor.mirror_round), u, max(placed.top_y + 0.06, 1.2))
            break
    for width in (1.1, 0.8):
        bench = job.make(partial(chairs.bench, width=width))
        if job.floor.at_wall(bench) is not None:
            break
    if job.area > 6.0:
        job.plants(1)
    _runner(job)
    job.pictures(0.7, most=4)


def _coats(job: Job) -> None:
    """A board with hooks, its coats over free floor."""
    for width in (1.0, 0.6):
        rack = job.make(partial(decor.coat_rack, width=width))
        for wall in job.walls_by_length():
            for share in job.rng.permutation(np.linspace(0.1, 0.9, 9)):
                if job.floor.hang(wall, rack, float(share) * wall.length, 0.62, solid=True):
                    return


def _runner(job: Job) -> None:
    """A long rug along the middle, shorter where doors or furniture need it."""
    room = job.room
    along_x = room.x1 - room.x0 >= room.z1 - room.z0
    x, z = (room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0
    for length in (2.6, 1.9, 1.3):
        for shift in (0.0, -0.6, 0.6, -1.2, 1.2):
            at = (x + shift, z) if along_x else (x, z + shift)
            size = (length, 0.7) if along_x else (0.7, length)
            if length < job.size[1] - 0.4 and job.rug_under(*at, *size):
                return
