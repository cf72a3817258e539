"""Plans of homes: many random layouts, of which the most homelike that takes doors and windows."""

from __future__ import annotations

import itertools

import numpy as np

from affectsim_data.builders.homes.plans.doorways import place_doorways
from affectsim_data.builders.homes.plans.draft import NoPlaceError, PlanDraft
from affectsim_data.builders.homes.plans.layout import Layout, random_layout
from affectsim_data.builders.homes.plans.links import Link
from affectsim_data.builders.homes.plans.model import HomePlan, Rect, RoomPlan, overlaps
from affectsim_data.builders.homes.plans.outer import place_closed_doors, place_windows
from affectsim_data.builders.homes.plans.scoring import judge
from affectsim_data.builders.homes.purposes import Purpose, draw_program, room_areas
from affectsim_data.builders.homes.recipes import HomeRecipe

__all__ = ["plan_home"]

_BATCHES, _BATCH, _TRIED = 10, 120, 5
_CEILINGS_M = (2.5, 2.7)
_DOOR_TOPS_M = (2.0, 2.1)
_FREE_FLOORS = ((34.0, 4.2, 2.6), (26.0, 3.5, 2.4), (20.0, 3.2, 2.2), (0.0, 2.4, 1.8))
"""From this floor of a living room, m2, on: length and breadth of what stays free, metres."""
_GRID_M = 0.1


def plan_home(recipe: HomeRecipe, *, rng: np.random.Generator) -> HomePlan:
    """Rooms, doorways, windows and closed doors of a recipe; the same `rng`, the same plan.

    Raises:
        ValueError: No layout of such rooms was found.
    """
    purposes: tuple[Purpose, ...]
    for _ in range(_BATCHES):
        if isinstance(recipe.rooms, int):
            purposes = draw_program(recipe.rooms, recipe.area_m2, rng)
        else:
            purposes = recipe.rooms
        ceiling_y = round(float(rng.uniform(*_CEILINGS_M)), 2)
        door_top = round(float(rng.uniform(*_DOOR_TOPS_M)), 2)
        for layout, links in itertools.islice(_best(purposes, recipe.area_m2, rng), _TRIED):
            draft = PlanDraft(purposes, layout, ceiling_y=ceiling_y, door_top=door_top)
            try:
                place_doorways(draft, links, rng=rng)
                place_closed_doors(draft, rng=rng)
                place_windows(draft, rng=rng)
                living = purposes.index("living")
                draft.keep_clear(living, _free_floor(draft, living))
            except NoPlaceError:
                continue
            return draft.finished(living)
    raise ValueError(
        f"home {recipe.scene_id!r}: found no plan of {recipe.rooms} in {recipe.area_m2:g} m2 "
        f"in {_BATCHES * _BATCH} tries; change rooms, area_m2 or seed"
    )


def _best(
    purposes: tuple[Purpose, ...], area_m2: float, rng: np.random.Generator
) -> list[tuple[Layout, list[Link]]]:
    """A batch of random layouts that can be homes, the most homelike first."""
    found: list[tuple[float, int, Layout, list[Link]]] = []
    areas = room_areas(purposes, area_m2, rng)
    for number in range(_BATCH):
        layout = random_layout(purposes, areas, rng=rng)
        judged = None if layout is None else judge(purposes, areas, layout, rng=rng)
        if layout is not None and judged is not None:
            found.append((judged[0], number, layout, judged[1]))
    return [(layout, links) for _, _, layout, links in sorted(found, key=lambda one: one[:2])]


def _free_floor(draft: PlanDraft, living: int) -> Rect:
    """Floor of the living room where people stand, gesture and walk: before doors, not before
    windows, and beside a large rest for furniture.

    Raises:
        NoPlaceError: There is none.
    """
    room = draft.rooms[living]
    length, breadth = next(size[1:] for size in _FREE_FLOORS if room.area_m2 >= size[0])
    zones = draft.zones(living)
    best: tuple[float, Rect] | None = None
    for wide, deep in ((length, breadth), (breadth, length)):
        for x in np.arange(room.x0 + 0.1, room.x1 - wide - 0.1 + 1e-6, _GRID_M):
            for z in np.arange(room.z0 + 0.1, room.z1 - deep - 0.1 + 1e-6, _GRID_M):
                rect = (float(x), float(z), float(x) + wide, float(z) + deep)
                if any(overlaps(rect, leaf, gap=0.05) for leaf in room.blocked):
                    continue
                score = _rest_m2(room, rect) + 2.0 * sum(_common_m2(rect, zone) for zone in zones)
                if best is None or score > best[0] + 1e-9:
                    best = (score, rect)
    if best is None:
        raise NoPlaceError("free floor in the living room")
    x0, z0, x1, z1 = (round(value, 3) for value in best[1])
    return (x0, z0, x1, z1)


def _rest_m2(room: RoomPlan, rect: Rect) -> float:
    """Largest rectangle of a room beside another one."""
    width, depth = room.x1 - room.x0, room.z1 - room.z0
    return max(
        (rect[0] - room.x0) * depth,
        (room.x1 - rect[2]) * depth,
        (rect[1] - room.z0) * width,
        (room.z1 - rect[3]) * width,
    )


def _common_m2(a: Rect, b: Rect) -> float:
    x, z = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
    return max(x, 0.0) * max(z, 0.0)
