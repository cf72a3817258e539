"""The building itself: walls with their openings, floors and ceilings, windows and doors."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.builders.homes.doors import (
    closed_door,
    doorway_lining,
    leaves_of,
    open_leaf,
)
from affectsim_data.builders.homes.looks import WHITE, Look, accent_side, draw_look, floor_finish
from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, lathe, sheet
from affectsim_data.builders.homes.plans import HomePlan, Opening, RoomPlan, Wall
from affectsim_data.builders.homes.trim import (
    Finish,
    baseboards,
    casing,
    graded,
    on_wall,
    span_u,
)
from affectsim_data.builders.homes.windows import WINDOW_RECESS, window
from affectsim_data.poses import FloatArray

__all__ = ["WINDOW_RECESS", "build_shell", "lamp_places", "on_wall"]

_FLOOR_CELL_M = 0.26
"""Light on floors changes at every foot of a piece of furniture."""
_OVERLAP_M = 0.002
"""How far faces reach behind each other where they meet: their corners lie at different heights
along the edge, and without it single pixels would show what is behind."""
_TWO_LAMPS_FROM_M = 5.5
_METAL = np.array([0.62, 0.61, 0.59])
_BORDER = (0.03, 0.012)
"""Height and depth of the strip above wall tiles, metres."""


def build_shell(plan: HomePlan, palette: Palette, *, rng: np.random.Generator) -> list[Part]:
    """Everything of a home that does not move."""
    look = draw_look(palette, plan.area_m2, rng)
    parts: list[Part] = []
    for room in plan.rooms:
        parts += _floor_and_ceiling(room, floor_finish(room, palette, look), look.cell)
        for wall in room.walls():
            parts += _wall(room, wall, palette, look)
            for opening in room.openings_in(wall.side):
                if opening.kind == "window":
                    parts += window(wall, opening)
                elif opening.kind == "doorway":
                    parts += _doorway(plan, room, opening, palette, look)
    return parts + _leaves(plan, look)


def _doorway(
    plan: HomePlan, room: RoomPlan, opening: Opening, palette: Palette, look: Look
) -> list[Part]:
    """The casing on one side of a doorway; the first of its rooms builds the lining as well."""
    wall, other = room.wall(opening.side), plan.room(opening.to_room)
    parts = casing(wall, opening, look.trim)
    if plan.rooms.index(other) < plan.rooms.index(room):
        return parts
    floors = [floor_finish(one, palette, look).material for one in (room, other)]
    through = floors[0] == floors[1] == "planks"
    return parts + doorway_lining(wall, opening, palette, look.trim, planks=through)


def _leaves(plan: HomePlan, look: Look) -> list[Part]:
    parts: list[Part] = []
    entrance = _entrance(plan)
    for _, wall, pose in leaves_of(plan):
        if pose.opening.kind == "door":
            finish = look.entrance if pose.opening is entrance else look.doors
            parts += closed_door(wall, pose, look.style, finish, look.trim)
        else:
            parts += open_leaf(pose, look.style, look.doors)
    return parts


def _entrance(plan: HomePlan) -> Opening | None:
    """The first closed door of the hall or, without one, of the home."""
    rooms = sorted(plan.rooms, key=lambda room: room.purpose != "hall")
    doors = [opening for room in rooms for opening in room.openings if opening.kind == "door"]
    return doors[0] if doors else None


def _floor_and_ceiling(room: RoomPlan, finish: Finish, cell: float) -> list[Part]:
    width, depth = room.x1 - room.x0, room.z1 - room.z0
    east, south = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    floor = sheet(
        (room.x0, 0.0, room.z1), east, -south,
        _widened(_lines(cell, 0.0, width, most=_FLOOR_CELL_M)),
        _widened(_lines(cell, 0.0, depth, most=_FLOOR_CELL_M)),
        color=finish.color, material=finish.material,
    )  # fmt: skip
    # Boards run on from room to room.
    floor = dataclasses.replace(floor, uvs=floor.positions[:, [0, 2]])
    ceiling = sheet(
        (room.x0, room.ceiling_y, room.z0), east, south,
        _widened(_lines(cell, 0.0, width)), _widened(_lines(cell, 0.0, depth)),
        color=(0.96, 0.955, 0.945), material="paint",
    )  # fmt: skip
    return [floor, ceiling, *_ceiling_lamps(room)]


def _ceiling_lamps(room: RoomPlan) -> list[Part]:
    """Flush glass domes."""
    parts = []
    for x, z in lamp_places(room):
        at = (x, room.ceiling_y, z)
        rim = [(0.0, -0.03), (0.215, -0.03), (0.215, 0.0)]
        angle = np.linspace(-np.pi / 2.0, 0.0, 7)
        dome = [(0.2 * float(np.cos(a)), -0.03 + 0.1 * float(np.sin(a))) for a in angle]
        parts.append(lathe(rim, color=_METAL, material="lamp", center=at))
        parts.append(
            lathe(dome, color=(1.0, 0.97, 0.9), material="lamp", center=at, smooth=True)
        )  # fmt: skip
    return parts


def lamp_places(room: RoomPlan) -> list[tuple[float, float]]:
    """Where ceiling lamps hang, `(x, z)` metres: in the middle, two where the room is long."""
    middle = np.array([(room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0])
    size = np.array([room.x1 - room.x0, room.z1 - room.z0])
    if size.max() < _TWO_LAMPS_FROM_M:
        return [(float(middle[0]), float(middle[1]))]
    shift = np.where(size == size.max(), size / 4.0, 0.0)
    return [(float(x), float(z)) for x, z in (middle - shift, middle + shift)]


def _wall(room: RoomPlan, wall: Wall, palette: Palette, look: Look) -> list[Part]:
    """The inner face of a wall with holes for its openings, and what runs along it."""
    boards = baseboards(room, wall, look.trim)
    whole, top = (0.0, room.ceiling_y), look.tile_top
    if wall.side == accent_side(room):
        accent = Finish(palette.accent_wall, look.accent)
        return [_wall_face(room, wall, whole, accent, look.cell), *boards]
    paint, tiles = Finish(palette.wall, "paint"), Finish(look.bath_color, "wall_tiles")
    if room.purpose != "bath":
        return [_wall_face(room, wall, whole, paint, look.cell), *boards]
    return [
        _wall_face(room, wall, (0.0, top), tiles, look.cell),
        _wall_face(room, wall, (top, room.ceiling_y), paint, look.cell),
        *_tile_border(room, wall, top),
    ]


def _tile_border(room: RoomPlan, wall: Wall, top: float) -> list[Part]:
    """A thin strip where tiles end, broken by openings."""
    cuts = [span_u(wall, o) for o in room.openings_in(wall.side) if o.bottom < top + 0.02]
    inset = _BORDER[1] if wall.side in ("left", "right") else 0.0
    place, parts = inset, []
    for start, end in [*sorted(cuts), (wall.length - inset, wall.length)]:
        if start - place > 0.1:
            size = (start - place - 0.16, *_BORDER)
            parts.append(on_wall(wall, (place + start) / 2.0, top, size, color=WHITE))
        place = end
    return parts


def _wall_face(
    room: RoomPlan, wall: Wall, heights: tuple[float, float], finish: Finish, cell: float
) -> Part:
    """A band of the face of a wall between two heights."""
    holes = room.openings_in(wall.side)
    spans = [span_u(wall, hole) for hole in holes]
    low, high = heights
    levels = [y for hole in holes for y in (hole.bottom, hole.top) if low < y < high]
    u = _lines(cell, 0.0, wall.length, *(end for span in spans for end in span))
    v = _lines(cell, low, high, *levels)
    u_middle, v_middle = (u[1:] + u[:-1]) / 2.0, (v[1:] + v[:-1]) / 2.0
    keep = np.ones((len(v_middle), len(u_middle)), bool)
    for hole, (start, end) in zip(holes, spans, strict=True):
        inside_u = (u_middle > start) & (u_middle < end)
        inside_v = (v_middle > hole.bottom) & (v_middle < hole.top)
        keep &= ~(inside_v[:, None] & inside_u[None, :])
    up = np.array([0.0, 1.0, 0.0])
    ends = np.array([low == 0.0, high == room.ceiling_y])
    return sheet(
        wall.origin + low * up, wall.along, up, _widened(u), _widened(v - low, ends),
        color=finish.color, material=finish.material, keep=keep,
    )  # fmt: skip


def _widened(lines: FloatArray, ends: ArrayLike = (True, True)) -> FloatArray:
    """Grid lines of which the first and the last reach a little further, where `ends` say so."""
    wide = lines.copy()
    wide[[0, -1]] += _OVERLAP_M * np.array([-1.0, 1.0]) * np.asarray(ends)
    return wide


def _lines(cell: float, *stops: float, most: float = 0.5) -> FloatArray:
    """`graded` lines for cells of a share of the usual size."""
    return graded(*stops, fine=0.16 * cell, most=most * cell)
