"""Bedrooms: a double bed, a single one or two, and what belongs to them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from affectsim_data.builders.homes import beds, chairs, decor, seating, storage, tables
from affectsim_data.builders.homes.pieces import Design, Furniture
from affectsim_data.builders.homes.placed import Placed, placed_before
from affectsim_data.builders.homes.rooms.groups import along
from affectsim_data.builders.homes.rooms.job import Job

__all__ = ["furnish_bedroom"]


def furnish_bedroom(job: Job) -> None:
    """The bed with its head to a wall, then wardrobe and chest, then the rest."""
    job.curtains()
    twin = job.area > 11.0 and job.chance(0.2)
    bed = _bed(job, widths=(0.9,) if twin else (1.8, 1.6, 1.4, 0.9))
    if twin:
        _bed(job, widths=(0.9,))
    _wardrobe(job)
    _chest(job)
    if job.area > 11.0:
        chair = job.make(seating.armchair_tub, seating.armchair_wooden, style="armchair")
        job.floor.at_wall(chair, prefer="corner", windows=True)
    if job.area > 15.0 and "study" not in job.purposes and job.chance(0.5):
        job.floor.at_wall(job.make(tables.desk), front=0.7)
    if job.area > 13.0:
        job.shelf(widths=(0.6,))
    job.floor.at_wall(job.make(storage.laundry_basket), prefer="corner")
    if job.area > 9.0 and job.chance(0.5):
        bench = job.make(partial(chairs.bench, width=0.9), chairs.stool)
        job.floor.at_wall(bench, prefer="any", windows=True)
    job.plants(1 + (job.area > 14.0))
    _rugs(job, bed)
    if bed is not None:
        job.picture_over(bed)
    job.pictures(0.6, most=3)


def _designs(width: float) -> tuple[Design, ...]:
    boards = partial(beds.bed_boards, width=width, foot=True)
    plain = partial(beds.bed_boards, width=width, foot=False)
    if width < 1.0:
        return (boards, plain, partial(beds.bed_steel, width=width))
    return (boards, plain, partial(beds.bed_padded, width=width))


def _bed(job: Job, *, widths: tuple[float, ...]) -> Placed | None:
    """The widest bed that fits, with stands at both sides, one, or none."""
    small = job.size[0] < 2.9
    for width in widths:
        if width > 1.6 and small:
            continue
        bed = job.make(*_designs(width), style=f"bed {width}")
        stand = job.make(storage.nightstand, storage.nightstand_open, style="nightstand")
        for stands in (2, 1, 0) if width > 1.0 else (1, 0):
            before = len(job.floor.placed)
            if job.floor.put_first(_heads(job, bed, stand, stands), tries=8):
                placed = job.floor.placed[before:]
                for side in placed[1:]:
                    job.lamp_on(side)
                return placed[0]
    return None


def _heads(job: Job, bed: Furniture, stand: Furniture, stands: int) -> Iterator[list[Placed]]:
    """Places with the head to a wall; single beds also along one, in a corner."""
    for wall in job.walls_by_length():
        for u in along(job, wall, bed):
            if job.floor.hides_window(bed, wall, u) and job.chance(0.7):
                continue
            head = placed_before(wall, bed, u)
            x = (bed.width + stand.width) / 2.0 + 0.03
            z = -bed.depth / 2.0 + stand.depth / 2.0
            sides = (1.0, -1.0) if job.chance(0.5) else (-1.0, 1.0)
            yield [head, *(head.beside(stand, s * x, z) for s in sides[:stands])]


def _wardrobe(job: Job) -> None:
    for width in (2.2, 1.8, 1.5, 1.0, 0.8):
        if width > 0.6 * job.size[1]:
            continue
        designs: list[Design] = [partial(storage.wardrobe, width=width)]
        if width >= 1.5:
            designs.append(partial(storage.wardrobe_sliding, width=width))
        placed = job.floor.at_wall(job.make(*designs), prefer="corner", front=0.65)
        if placed is not None:
            return


def _chest(job: Job) -> None:
    """A chest of drawers with a looking-glass over it."""
    for width in (1.1, 0.9, 0.6):
        chest = job.make(partial(storage.dresser, width=width))
        placed = job.floor.at_wall(chest, prefer="center", front=0.6)
        if placed is None:
            continue
        wall, u = job.wall_behind(placed), job.along_wall(placed)
        glass = job.make(decor.mirror_round, partial(decor.mirror, width=0.6, height=0.75))
        job.floor.hang(wall, glass, u, max(placed.top_y + 0.08, 1.15))
        return


def _rugs(job: Job, bed: Placed | None) -> None:
    """A runner beside the bed or a rug before its foot."""
    if bed is None:
        return
    half, long = bed.piece.width / 2.0, bed.piece.depth / 2.0
    spots = [
        (0.0, long + 0.6, 1.8, 1.0),
        (half + 0.45, 0.25, 0.7, 1.4),
        (-half - 0.45, 0.25, 0.7, 1.4),
    ]
    laid = 0
    for x, z, width, depth in spots:
        at = bed.world(x, z)
        laid += job.rug_under(*at, width, depth, yaw=bed.yaw)
        if laid == 2:
            return
