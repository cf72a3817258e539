"""Bathrooms."""

from __future__ import annotations

from functools import partial

import numpy as np

from affectsim_data.builders.homes import bathroom, decor, storage, textiles
from affectsim_data.builders.homes.pieces import Design
from affectsim_data.builders.homes.placed import Placed
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_bath"]


def furnish_bath(job: Job) -> None:
    """Bath or shower, basin under a looking-glass, toilet, and what still fits."""
    job.curtains()
    first = job.area > 3.6 and not job.compact
    if first:
        _wash_body(job)
    else:
        _toilet(job)
    basin = _basin(job)
    if first:
        _toilet(job)
    else:
        _wash_body(job)
    if job.area > 4.5:
        job.floor.at_wall(job.make(bathroom.washing_machine), prefer="corner", front=0.5)
    if job.area > 5.0:
        chest = job.make(partial(storage.dresser, width=0.6))
        job.floor.at_wall(chest, prefer="corner", front=0.4)
        job.floor.at_wall(job.make(storage.laundry_basket), prefer="corner")
    job.floor.at_wall(job.make(bathroom.bin_pedal), prefer="corner")
    _rail(job)
    _mat(job, basin)
    if job.area > 6.0:
        job.plants(1)
    job.pictures(0.3, most=1)


def _toilet(job: Job) -> None:
    front = 0.35 if job.compact else 0.5
    job.floor.at_wall(job.make(bathroom.toilet), front=front, prefer="corner")


def _wash_body(job: Job) -> None:
    if job.area > 4.4 and not job.compact:
        for width in (1.8, 1.7, 1.6):
            tub = job.make(partial(bathroom.bathtub, width=width))
            if job.floor.at_wall(tub, prefer="corner", front=0.45, windows=True) is not None:
                break
        else:
            job.floor.at_wall(job.make(bathroom.shower), prefer="corner", front=0.45)
            return
        if job.area < 8.0:
            return
    for width in (0.9, 0.8):
        shower = job.make(partial(bathroom.shower, width=width))
        if job.floor.at_wall(shower, prefer="corner", front=0.45) is not None:
            return


def _basin(job: Job) -> Placed | None:
    wide = 0.9 if job.area > 7.0 else 0.7
    small: tuple[Design, ...] = (
        bathroom.basin_pillar, partial(bathroom.basin_cabinet, width=0.6),
    )  # fmt: skip
    designs = (small,) if job.compact else ((partial(bathroom.basin_cabinet, width=wide),), small)
    for choice in designs:
        basin = job.make(*choice)
        placed = job.floor.at_wall(basin, prefer="center", front=0.35 if job.compact else 0.5)
        if placed is None:
            continue
        wall, u = job.wall_behind(placed), job.along_wall(placed)
        width = min(basin.width, 0.6)
        glass = job.make(
            partial(decor.mirror, width=width, height=0.8),
            partial(decor.mirror_round, width=width),
        )
        job.floor.hang(wall, glass, u, 1.2)
        return placed
    return None


def _rail(job: Job) -> None:
    rail = job.make(bathroom.towel_rail)
    for wall in job.room.walls():
        for share in job.rng.permutation(np.linspace(0.1, 0.9, 9)):
            if job.floor.hang(wall, rail, float(share) * wall.length, 0.5, solid=True):
                return


def _mat(job: Job, basin: Placed | None) -> None:
    """A mat before the bath or shower, else before the basin."""
    wet = [p for p in job.floor.placed if p.piece.category in ("bathtub", "shower")]
    for base in [*wet, *([basin] if basin is not None else [])]:
        mat = job.make(textiles.bath_mat)
        x, z = base.world(0.0, base.piece.depth / 2.0 + mat.depth / 2.0 + 0.06)
        if job.floor.lay(mat, x, z, base.yaw):
            return
