"""Furnishing: every room of a home by its purpose."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.pieces import FurnitureSource, Workshop
from affectsim_data.builders.homes.placed import Placed
from affectsim_data.builders.homes.placing import RoomFloor
from affectsim_data.builders.homes.plans import HomePlan, RoomPlan
from affectsim_data.builders.homes.rooms import ESSENTIALS, FURNISHERS, Job
from affectsim_data.builders.homes.shell import lamp_places

__all__ = ["Furnishing", "furnish_home"]

_ATTEMPTS = 3
"""How often a room is furnished anew when something essential had no place."""
_SEATS = 3
"""That can be used in every home, if there is any room for them."""


@dataclasses.dataclass(frozen=True)
class Furnishing:
    """What stands, lies and hangs in a home."""

    placed: tuple[Placed, ...]


def furnish_home(
    plan: HomePlan, palette: Palette, *, rng: np.random.Generator,
    catalogue: FurnitureSource | None = None,
) -> Furnishing:  # fmt: skip
    """Furniture for every room; a room in which nothing fits stays empty.

    Args:
        plan: The empty home.
        palette: Its colours.
        rng: Draws designs, sizes and places; the same `rng`, the same furniture.
        catalogue: Models that replace the built-in designs where they fit.
    """
    shop = Workshop(palette, rng=rng, catalogue=catalogue)
    purposes = tuple(room.purpose for room in plan.rooms)
    jobs = [_furnished(room, shop, purposes, rng) for room in plan.rooms]
    for job in sorted(jobs, key=lambda job: -job.area) * 2:
        if sum(len(placed.piece.seats) for placed in _everything(jobs)) >= _SEATS:
            break
        job.spare_seat()
    return Furnishing(tuple(_everything(jobs)))


def _everything(jobs: list[Job]) -> list[Placed]:
    return [placed for job in jobs for placed in job.floor.finish()]


def _furnished(
    room: RoomPlan, shop: Workshop, purposes: tuple[str, ...], rng: np.random.Generator
) -> Job:
    """The best of a few attempts; the first that has all essentials."""
    essentials = ESSENTIALS.get(room.purpose, ())
    done: list[tuple[int, Job]] = []
    for attempt in range(_ATTEMPTS):
        floor = RoomFloor(room, rng=rng)
        job = Job(floor, shop, purposes, tuple(lamp_places(room)), compact=attempt > 0)
        FURNISHERS[room.purpose](job)
        there = {placed.piece.category for placed in floor.placed}
        missing = sum(category not in there for category in essentials)
        done.append((missing, job))
        if missing == 0:
            break
    return min(done, key=lambda one: one[0])[1]
