"""What one home has everywhere: its doors and trim, its floors, its bathroom tiles."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.doors import DoorStyle
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.plans import RoomPlan
from affectsim_data.builders.homes.trim import TRIM, Finish
from affectsim_data.poses import FloatArray

__all__ = ["WHITE", "Look", "accent_side", "draw_look", "floor_finish"]

WHITE = np.array([0.90, 0.885, 0.86])
"""Of painted doors."""
_STYLES: tuple[DoorStyle, ...] = ("four_panels", "two_panels", "planks", "plain")
_FINE_BELOW_M2 = 75.0
_FLOOR_TILES = np.array([0.86, 0.84, 0.80])
_CARPET = np.array([0.82, 0.80, 0.76])


@dataclasses.dataclass(frozen=True)
class Look:
    """Choices made once for a home."""

    style: DoorStyle
    doors: Finish
    entrance: Finish
    trim: Finish
    """Boards along walls, casings."""
    tile_top: float
    """Of the tiled part of bathroom walls, metres."""
    bath_color: FloatArray
    accent: str
    """Material of accent walls."""
    carpet: bool
    """Whether bedrooms are carpeted."""
    tiled_hall: bool
    cell: float
    """Of the light cells of walls and floors, as a share of the usual ones."""


def draw_look(palette: Palette, area_m2: float, rng: np.random.Generator) -> Look:
    """A look that goes with a palette; small homes can afford finer light."""
    light = 0.75 + 0.25 * palette.wall
    style = _STYLES[int(rng.choice(len(_STYLES), p=[0.35, 0.25, 0.2, 0.2]))]
    wooden, dark = Finish(palette.wood, "wood"), Finish(palette.dark_wood, "wood")
    choices = [Finish(WHITE), wooden, dark, Finish(palette.cabinet)]
    doors = choices[int(rng.choice(4, p=[0.35, 0.35, 0.1, 0.2]))]
    wooden_trim = doors.material == "wood" and rng.random() < 0.6
    return Look(
        style=style,
        doors=doors,
        entrance=dark if rng.random() < 0.7 else doors,
        trim=doors if wooden_trim else Finish(TRIM),
        tile_top=1.2 if rng.random() < 0.6 else 1.8,
        bath_color=light * np.array([0.93, 0.96, 0.97]) if rng.random() < 0.5 else 0.97 * light,
        accent="wallpaper" if rng.random() < 0.4 else "paint",
        carpet=bool(rng.random() < 0.3),
        tiled_hall=bool(rng.random() < 0.5),
        cell=float(np.clip(area_m2 / _FINE_BELOW_M2, 0.65, 1.0)),
    )


def floor_finish(room: RoomPlan, palette: Palette, look: Look) -> Finish:
    """Colour and material of a room's floor."""
    if room.purpose == "bath":
        return Finish(0.93 * look.bath_color, "tiles")
    if room.purpose == "kitchen" or (room.purpose == "hall" and look.tiled_hall):
        return Finish(_FLOOR_TILES, "tiles")
    if room.purpose == "bedroom" and look.carpet:
        return Finish(0.35 * palette.textile + 0.65 * _CARPET, "carpet")
    return Finish(palette.floor, "planks")


def accent_side(room: RoomPlan) -> str:
    """The wall with an accent: the emptiest one of rooms people stay in; empty for none."""
    if room.purpose not in ("living", "bedroom", "study", "dining"):
        return ""
    free = {
        wall.side: wall.length - 2.0 * sum(o.width for o in room.openings_in(wall.side))
        for wall in room.walls()
    }
    return max(free, key=lambda side: free[side])
