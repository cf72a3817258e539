"""Dining rooms."""

from __future__ import annotations

from functools import partial

from affectsim_data.builders.homes import storage
from affectsim_data.builders.homes.rooms.groups import place_dining
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_dining"]


def furnish_dining(job: Job) -> None:
    """A table with chairs in the middle, cabinets at the walls."""
    job.curtains()
    most = 8 if job.area > 15.0 else 6 if job.area > 10.0 else 4
    place_dining(job, most=most)
    for width in (1.6, 1.2, 0.8):
        designs = (
            partial(storage.sideboard, width=width), partial(storage.sideboard_open, width=width),
        )  # fmt: skip
        placed = job.floor.at_wall(job.make(*designs), prefer="center", front=0.5)
        if placed is not None:
            job.picture_over(placed)
            break
    job.floor.at_wall(job.make(storage.glass_cabinet), prefer="corner", front=0.5)
    job.shelf(widths=(0.6,))
    job.plants(2)
    _rug(job)
    job.pictures(0.7, most=4)


def _rug(job: Job) -> None:
    """A rug large enough for the table and all of its chairs, if there is room for one."""
    group = [p.rect() for p in job.floor.placed if p.piece.category in ("table", "chair")]
    if not group or not job.chance(0.6):
        return
    x0, z0 = min(r[0] for r in group), min(r[1] for r in group)
    x1, z1 = max(r[2] for r in group), max(r[3] for r in group)
    job.rug_under((x0 + x1) / 2.0, (z0 + z1) / 2.0, x1 - x0 + 0.3, z1 - z0 + 0.3)
