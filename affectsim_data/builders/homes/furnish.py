"""Furnishing: a living area around its sofa, table and divider, and the rooms beside it."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes import kitchen, seating, storage, tables
from affectsim_data.builders.homes.decor import curtains, floor_lamp, picture, plant, rug
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part
from affectsim_data.builders.homes.placing import Placed, RoomFloor
from affectsim_data.builders.homes.plans import HomePlan, RoomPlan, divider_x
from affectsim_data.builders.homes.recipes import HomeRecipe

__all__ = ["Furnishing", "furnish_home"]

_QUARTER = np.pi / 2.0


@dataclasses.dataclass(frozen=True)
class Furnishing:
    """What stands and hangs in a home."""

    placed: tuple[Placed, ...]
    fixed: tuple[Part, ...]
    """Curtains and pictures, in the world."""


def furnish_home(plan: HomePlan, recipe: HomeRecipe, *, rng: np.random.Generator) -> Furnishing:
    """Furniture for every room."""
    placed: list[Placed] = []
    fixed: list[Part] = []
    for room in plan.rooms:
        floor = RoomFloor(room)
        if room.purpose == "living":
            _living(floor, recipe, rng)
        else:
            _ROOMS[room.purpose](floor, recipe.palette, rng)
        placed += floor.placed
        fixed += _hangings(floor, recipe.palette, rng)
    return Furnishing(tuple(placed), tuple(fixed))


def _living(floor: RoomFloor, recipe: HomeRecipe, rng: np.random.Generator) -> None:
    palette, (width, depth) = recipe.palette, recipe.living
    # Free floor for people who stand, gesture or walk a loop; nothing is ever put there.
    floor.keep_free((3.8, 0.15, min(8.1, width - 0.15), 2.75))
    _lounge(floor, palette, depth, rng)
    x, length = divider_x(recipe), min(2.8, depth - 2.8)
    middle = depth - length / 2.0
    if recipe.divider == "island":
        floor.put(Placed(kitchen.island(palette, width=length - 0.05), x, middle - 0.03, _QUARTER))
        _kitchen_bay(floor, palette, x, depth, length)
    else:
        piece = (
            storage.room_divider(palette, width=length - 0.05, rng=rng)
            if recipe.divider == "shelf"
            else storage.partition(palette, width=length - 0.06)
        )
        floor.put(Placed(piece, x, middle - 0.01, _QUARTER))
        turn = float(rng.choice([-1.0, 1.0]))
        _dining(floor, palette, (x + 0.2 + width) / 2.0, depth - 1.42, 1.6, turn)
    floor.put_at_wall(
        storage.bookshelf(palette, width=1.0, rng=rng), rng=rng, prefer="corner", front=0.5
    )
    floor.put_at_wall(storage.sideboard(palette), rng=rng, prefer="center", front=0.5)
    for tall in (1.5, 1.2):
        floor.put_at_wall(plant(tall=tall, rng=rng), rng=rng, prefer="corner")


def _lounge(floor: RoomFloor, palette: Palette, depth: float, rng: np.random.Generator) -> None:
    """Television at the left wall; the sofa faces it with its back to the open floor."""
    z = 0.38 * depth + 0.25
    x = 2.85 + float(rng.uniform(0.0, 0.12))
    stand = storage.tv_stand(palette)
    floor.put(Placed(stand, stand.depth / 2.0 + 0.02, z, _QUARTER))
    floor.put(Placed(seating.sofa(palette, places=3, rng=rng), x, z, -_QUARTER))
    floor.put(Placed(tables.coffee_table(palette), x - 0.46 - 0.57 - 0.29, z, _QUARTER))
    chair = seating.armchair(palette)
    turn = np.pi + float(rng.uniform(-0.3, 0.1))
    floor.put(Placed(chair, x - 1.2, z + 1.65, turn))
    floor.lay(rug(2.3, 2.7, color=palette.rug, border=palette.textile), x - 1.2, z + 0.1)
    lamp = floor_lamp()
    spot = Placed(lamp, x + 0.1, z + 1.42, 0.0)
    if floor.fits(spot):
        floor.put(spot)


def _dining(
    floor: RoomFloor, palette: Palette, x: float, z: float, width: float, turn: float
) -> None:
    """A table whose chairs stand at its long sides: one tucked in, one turned away, on each."""
    table = floor.put(Placed(tables.dining_table(palette, width=width), x, z, 0.0))
    half = table.piece.depth / 2.0
    for side in (-1.0, 1.0):
        # The turned chair looks along the table, so that knees and robots find room before it.
        away = side * turn
        turned = Placed(
            seating.dining_chair(palette), x - 0.34 * away * width, z + side * (half + 0.28),
            away * _QUARTER,
        )  # fmt: skip
        floor.put_under(turned)
        tucked = dataclasses.replace(seating.dining_chair(palette), seats=())
        facing = np.pi if side > 0.0 else 0.0
        floor.put_under(Placed(tucked, x + 0.36 * away * width, z + side * (half + 0.08), facing))


def _kitchen_bay(floor: RoomFloor, palette: Palette, x: float, depth: float, length: float) -> None:
    """A counter and a fridge along the right wall behind the island, stools before it."""
    room = floor.room
    fridge = kitchen.fridge()
    counter = kitchen.counter(palette, width=length - fridge.width - 0.05, upper=True)
    fridge_z = depth - fridge.width / 2.0 - 0.02
    floor.put(Placed(fridge, room.x1 - fridge.depth / 2.0 - 0.02, fridge_z, -_QUARTER))
    counter_z = fridge_z - (fridge.width + counter.width) / 2.0 - 0.01
    floor.put(Placed(counter, room.x1 - counter.depth / 2.0 - 0.013, counter_z, -_QUARTER))
    for index in range(3):
        at = depth - length + 0.5 + 0.62 * index
        floor.put(Placed(seating.stool(palette), x - 0.62, at, 0.0))


def _bedroom(floor: RoomFloor, palette: Palette, rng: np.random.Generator) -> None:
    width = 1.6 if min(_size(floor.room)) > 3.0 else 1.4
    bed = floor.put_at_wall(seating.bed(palette, width=width), rng=rng, prefer="center")
    if bed is not None:
        stand = storage.nightstand(palette)
        for sign in (-1.0, 1.0):
            shift = sign * (bed.piece.width + stand.width + 0.06) / 2.0
            x, z = bed.world(shift, -bed.piece.depth / 2.0 + stand.depth / 2.0)
            beside = Placed(stand, x, z, bed.yaw)
            if floor.fits(beside):
                floor.put(beside)
        x, z = bed.world(0.0, 0.45)
        floor.lay(rug(width + 1.0, 1.5, color=palette.rug, border=palette.textile), x, z, bed.yaw)
    for length in (1.5, 1.0):
        wardrobe = storage.wardrobe(palette, width=length)
        if floor.put_at_wall(wardrobe, rng=rng, prefer="corner", front=0.6) is not None:
            break
    floor.put_at_wall(seating.armchair(palette), rng=rng, prefer="corner")
    floor.put_at_wall(plant(tall=1.1, rng=rng), rng=rng, prefer="corner")


def _kitchen(floor: RoomFloor, palette: Palette, rng: np.random.Generator) -> None:
    longest = max(_size(floor.room))
    for length in (2.6, 2.2, 1.8):
        counter = kitchen.counter(palette, width=min(length, longest - 0.1), upper=True)
        if floor.put_at_wall(counter, rng=rng, prefer="corner", front=0.8) is not None:
            break
    floor.put_at_wall(kitchen.fridge(), rng=rng, prefer="corner", front=0.6)
    low = kitchen.counter(palette, width=1.2, upper=False)
    floor.put_at_wall(low, rng=rng, prefer="corner", front=0.7)
    floor.put_at_wall(dataclasses.replace(seating.dining_chair(palette)), rng=rng, prefer="any")
    floor.put_at_wall(plant(tall=1.0, rng=rng), rng=rng, prefer="corner")


def _study(floor: RoomFloor, palette: Palette, rng: np.random.Generator) -> None:
    desk = floor.put_at_wall(tables.desk(palette), rng=rng, prefer="center", front=1.35)
    if desk is not None:
        # Pushed back from the desk and turned to the side.
        x, z = desk.world(-0.2, desk.piece.depth / 2.0 + 0.42)
        floor.put_under(Placed(seating.desk_chair(palette), x, z, desk.yaw + 0.5 * np.pi))
    for width in (1.2, 0.8):
        shelf = storage.bookshelf(palette, width=width, rng=rng)
        floor.put_at_wall(shelf, rng=rng, prefer="corner", front=0.5)
    floor.put_at_wall(seating.armchair(palette), rng=rng, prefer="corner")
    floor.lay(rug(1.9, 1.4, color=palette.rug, border=palette.accent), *_middle(floor.room))
    floor.put_at_wall(plant(tall=1.3, rng=rng), rng=rng, prefer="corner")


def _hall(floor: RoomFloor, palette: Palette, rng: np.random.Generator) -> None:
    floor.put_at_wall(storage.wardrobe(palette, width=1.0), rng=rng, prefer="corner", front=0.6)
    floor.put_at_wall(storage.sideboard(palette, width=1.0), rng=rng, prefer="center")
    chair = seating.dining_chair(palette)
    floor.put_at_wall(chair, rng=rng, prefer="corner")
    floor.lay(rug(1.6, 0.9, color=palette.rug, border=palette.accent), *_middle(floor.room))


_ROOMS = {"bedroom": _bedroom, "kitchen": _kitchen, "study": _study, "hall": _hall}


def _size(room: RoomPlan) -> tuple[float, float]:
    return (room.x1 - room.x0, room.z1 - room.z0)


def _middle(room: RoomPlan) -> tuple[float, float]:
    return ((room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0)


def _hangings(floor: RoomFloor, palette: Palette, rng: np.random.Generator) -> list[Part]:
    """Curtains at the windows that have them, and a picture on walls that have room for one."""
    parts: list[Part] = []
    for wall in floor.room.walls():
        for opening in floor.room.openings_in(wall.side):
            if opening.curtains:
                parts += curtains(wall, opening, palette)
        size = (0.62, 0.82) if rng.random() < 0.5 else (0.95, 0.68)
        painting = int(rng.integers(4))
        places = wall.length * np.array([0.5, 0.4, 0.6, 0.3, 0.7])
        free = [float(u) for u in places if floor.free_wall(wall, float(u), size[0])]
        if free:
            parts += picture(wall, free[0], 1.58, size, painting=painting)
    return parts
