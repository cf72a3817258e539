"""The building itself: walls with their openings, floors, ceilings, windows and doors."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from affectsim_data.builders.homes.palettes import Palette
from affectsim_data.builders.homes.parts import Part, box, lathe, sheet
from affectsim_data.builders.homes.plans import (
    CEILING_Y,
    DOOR_HEIGHT,
    WALL_THICKNESS,
    HomePlan,
    Opening,
    RoomPlan,
    Wall,
)
from affectsim_data.poses import FloatArray

__all__ = ["WINDOW_RECESS", "build_shell", "lamp_places", "on_wall"]

WINDOW_RECESS = 0.1
"""From the inner face of a wall to its window panes, metres."""
_CELL_M = 0.22
_TRIM = np.array([0.93, 0.92, 0.90])
_BOARD_HEIGHT, _BOARD_DEPTH = 0.08, 0.012
_CASING_WIDTH, _CASING_DEPTH = 0.07, 0.022
_METAL = np.array([0.62, 0.61, 0.59])


def build_shell(plan: HomePlan, palette: Palette) -> list[Part]:
    """Everything of a home that does not move."""
    parts: list[Part] = []
    for room in plan.rooms:
        parts += _room(room, palette)
        for wall in room.walls():
            accent = _has_accent(room, wall)
            color = palette.accent_wall if accent else palette.wall
            parts.append(_wall_face(room, wall, color))
            parts += _baseboards(room, wall)
            for opening in room.openings_in(wall.side):
                u = wall.u_of(opening.middle)
                if opening.kind == "window":
                    parts += _window(wall, opening, u)
                elif opening.kind == "door":
                    parts += _closed_door(wall, opening, u)
                else:
                    parts += _casing(wall, opening.width, u)
                    # Two rooms share a doorway; the one it leads out of builds its lining.
                    if room is not plan.living:
                        parts += _doorway_lining(wall, opening, u, palette)
    return parts


def _has_accent(room: RoomPlan, wall: Wall) -> bool:
    return room.purpose in ("living", "bedroom", "study") and wall.side == "left"


def _lines(*stops: float) -> FloatArray:
    """Grid lines through all stops, at most a light cell apart, `(num_lines,)`."""
    unique = sorted({round(stop, 6) for stop in stops})
    pieces = [
        np.linspace(a, b, max(int(np.ceil((b - a) / _CELL_M)), 1) + 1)[:-1]
        for a, b in itertools.pairwise(unique)
    ]
    return np.concatenate([*pieces, [unique[-1]]])


def _room(room: RoomPlan, palette: Palette) -> list[Part]:
    x, z = _lines(0.0, room.x1 - room.x0), _lines(0.0, room.z1 - room.z0)
    tiled = room.purpose in ("kitchen", "hall")
    floor_color = np.array([0.86, 0.84, 0.80]) if tiled else palette.floor
    east, south = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    floor = sheet(
        (room.x0, 0.0, room.z1), east, -south, x, z,
        color=floor_color, material="tiles" if tiled else "planks",
    )  # fmt: skip
    ceiling = sheet(
        (room.x0, CEILING_Y, room.z0), east, south, x, z, color=(0.96, 0.955, 0.945),
        material="paint",
    )  # fmt: skip
    return [floor, ceiling, *_ceiling_lamp(room)]


def _ceiling_lamp(room: RoomPlan) -> list[Part]:
    """A flush glass dome in the middle; two where the room is long."""
    parts = []
    for x, z in lamp_places(room):
        at = (x, CEILING_Y, z)
        rim = [(0.0, -0.03), (0.215, -0.03), (0.215, 0.0)]
        angle = np.linspace(-np.pi / 2.0, 0.0, 7)
        dome = [(0.2 * float(np.cos(a)), -0.03 + 0.1 * float(np.sin(a))) for a in angle]
        parts.append(lathe(rim, color=_METAL, material="lamp", center=at))
        parts.append(
            lathe(dome, color=(1.0, 0.97, 0.9), material="lamp", center=at, smooth=True)
        )  # fmt: skip
    return parts


def lamp_places(room: RoomPlan) -> list[tuple[float, float]]:
    """Where ceiling lamps hang, `(x, z)` metres."""
    x, z = (room.x0 + room.x1) / 2.0, (room.z0 + room.z1) / 2.0
    if room.x1 - room.x0 < 5.5:
        return [(x, z)]
    quarter = (room.x1 - room.x0) / 4.0
    return [(x - quarter, z), (x + quarter, z)]


def _wall_face(room: RoomPlan, wall: Wall, color: FloatArray) -> Part:
    holes = [opening for opening in room.openings_in(wall.side) if opening.kind != "door"]
    spans = [sorted((wall.u_of(o.span[0]), wall.u_of(o.span[1]))) for o in holes]
    u = _lines(0.0, wall.length, *(end for span in spans for end in span))
    # The same heights in every wall, so that neighbours meet vertex to vertex.
    v = _lines(0.0, CEILING_Y, DOOR_HEIGHT, 0.75, 0.85, 1.1, 2.2)
    u_middle, v_middle = (u[1:] + u[:-1]) / 2.0, (v[1:] + v[:-1]) / 2.0
    keep = np.ones((len(v_middle), len(u_middle)), bool)
    for hole, (start, end) in zip(holes, spans, strict=True):
        inside_u = (u_middle > start) & (u_middle < end)
        inside_v = (v_middle > hole.bottom) & (v_middle < hole.top)
        keep &= ~(inside_v[:, None] & inside_u[None, :])
    up = np.array([0.0, 1.0, 0.0])
    return sheet(wall.origin, wall.along, up, u, v, color=color, material="paint", keep=keep)


def _baseboards(room: RoomPlan, wall: Wall) -> list[Part]:
    """Boards along the foot of a wall, broken by doors."""
    cuts = sorted(
        (wall.u_of(o.middle) - o.width / 2.0 - _CASING_WIDTH, wall.u_of(o.middle) + o.width / 2.0)
        for o in room.openings_in(wall.side)
        if o.kind != "window"
    )
    start, parts = 0.0, []
    for cut_start, cut_end in [*cuts, (wall.length, wall.length)]:
        if cut_start - start > 0.02:
            parts.append(
                on_wall(wall, (start + cut_start) / 2.0, _BOARD_HEIGHT / 2.0,
                        (cut_start - start, _BOARD_HEIGHT, _BOARD_DEPTH), color=_TRIM)
            )  # fmt: skip
        start = cut_end + _CASING_WIDTH
    return parts


def on_wall(
    wall: Wall, u: float, y: float, size: tuple[float, float, float], *, color: FloatArray,
    out: float = 0.0, material: str = "plain", radius: float = 0.003,
) -> Part:  # fmt: skip
    """A box (width, height, depth) whose back is `out` metres before a wall, middle at `(u, y)`."""
    part = box(
        size, (0.0, 0.0, size[2] / 2.0), color=color, material=material,
        radius=radius, step=0.3, sides="xXyYZ" if out == 0.0 else "xXyYzZ",
    )  # fmt: skip
    x, height, z = wall.point(u, y, out)
    return part.moved(float(x), float(height), float(z), yaw=wall.yaw)


def _casing(wall: Wall, width: float, u: float) -> list[Part]:
    """The frame around a door."""
    side = (_CASING_WIDTH, DOOR_HEIGHT + _CASING_WIDTH, _CASING_DEPTH)
    shift = (width + _CASING_WIDTH) / 2.0
    top = (width, _CASING_WIDTH, _CASING_DEPTH)
    return [
        on_wall(wall, u - shift, side[1] / 2.0, side, color=_TRIM),
        on_wall(wall, u + shift, side[1] / 2.0, side, color=_TRIM),
        on_wall(wall, u, DOOR_HEIGHT + _CASING_WIDTH / 2.0, top, color=_TRIM),
    ]


def _recess(
    wall: Wall, opening: Opening, u: float, depth: float, *, bottom: bool
) -> list[Part]:  # fmt: skip
    """The sides of a hole in a wall: left, right, top and, for windows, bottom."""
    low, high = opening.bottom, opening.top
    start, end = u - opening.width / 2.0, u + opening.width / 2.0
    up, out = np.array([0.0, 1.0, 0.0]), wall.normal
    deep, tall, wide = _lines(0.0, depth), _lines(low, high) - low, _lines(start, end) - start
    corner = wall.point(start, low, -depth)
    sheets = [
        sheet(wall.point(start, low), -out, up, deep, tall, color=_TRIM, material="plain"),
        sheet(wall.point(end, low, -depth), out, up, deep, tall, color=_TRIM, material="plain"),
        sheet(wall.point(start, high), wall.along, -out, wide, deep, color=_TRIM, material="plain"),
    ]
    if bottom:
        sheets.append(sheet(corner, wall.along, out, wide, deep, color=_TRIM, material="plain"))
    return [_facing(part, wall.point(u, (low + high) / 2.0, -depth / 2.0)) for part in sheets]


def _facing(part: Part, point: FloatArray) -> Part:
    """The same sheet, turned over if its front does not look at `point`."""
    if float(part.normals[0] @ (point - part.positions[0])) > 0.0:
        return part
    return dataclasses.replace(part, normals=-part.normals, faces=part.faces[:, ::-1])


def _doorway_lining(wall: Wall, opening: Opening, u: float, palette: Palette) -> list[Part]:
    threshold = sheet(
        wall.point(u - opening.width / 2.0), wall.along, -wall.normal,
        _lines(0.0, opening.width), np.array([0.0, WALL_THICKNESS]),
        color=palette.floor, material="planks",
    )  # fmt: skip
    up = wall.point(u, 1.0)
    return [*_recess(wall, opening, u, WALL_THICKNESS, bottom=False), _facing(threshold, up)]


def _window(wall: Wall, opening: Opening, u: float) -> list[Part]:
    """A pane of bright sky at the end of a recess, a frame with a middle bar, and a sill."""
    width, height = opening.width, opening.top - opening.bottom
    middle, bar, depth = (opening.bottom + opening.top) / 2.0, 0.055, 0.05
    pane = sheet(
        wall.point(u - width / 2.0, opening.bottom, -WINDOW_RECESS), wall.along,
        np.array([0.0, 1.0, 0.0]), np.array([0.0, width]), np.array([0.0, height]),
        color=(1.0, 1.0, 1.0), material="sky",
    )  # fmt: skip
    # One copy of the sky picture per window, the right way up.
    pane = dataclasses.replace(pane, uvs=pane.uvs / (width, height) + (0.0, 1.0))
    upright, level = (bar, height, depth), (width - 2.0 * bar, bar, depth)
    frame = [
        (u - (width - bar) / 2.0, middle, upright),
        (u + (width - bar) / 2.0, middle, upright),
        (u, middle, (bar, height - 2.0 * bar, depth)),
        (u, opening.bottom + bar / 2.0, level),
        (u, opening.top - bar / 2.0, level),
    ]
    bars = [
        on_wall(wall, at, y, size, color=_TRIM, out=0.004 - WINDOW_RECESS) for at, y, size in frame
    ]
    sill = on_wall(wall, u, opening.bottom - 0.015, (width + 0.12, 0.03, 0.06), color=_TRIM)
    return [pane, *bars, sill, *_recess(wall, opening, u, WINDOW_RECESS, bottom=True)]


def _closed_door(wall: Wall, opening: Opening, u: float) -> list[Part]:
    """A leaf with four raised panels and a handle, in its casing."""
    leaf_out = 0.01
    leaf_size = (opening.width - 0.006, DOOR_HEIGHT - 0.01, leaf_out)
    color = np.array([0.90, 0.885, 0.86])
    parts = [*_casing(wall, opening.width, u)]
    parts.append(on_wall(wall, u, leaf_size[1] / 2.0 + 0.005, leaf_size, color=color))
    panel_width = opening.width / 2.0 - 0.17
    for shift in (-1.0, 1.0):
        for y, height in ((0.55, 0.7), (1.5, 0.78)):
            at = u + shift * (panel_width / 2.0 + 0.05)
            size = (panel_width, height, 0.009)
            parts.append(
                on_wall(wall, at, y, size, color=color, out=leaf_out - 0.001, radius=0.006)
            )
    handle = u + opening.width / 2.0 - 0.07
    plate, grip = (0.035, 0.2, 0.012), (0.13, 0.022, 0.022)
    parts.append(on_wall(wall, handle, 1.02, plate, color=_METAL, out=leaf_out))
    parts.append(on_wall(wall, handle, 1.06, (0.022, 0.022, 0.055), color=_METAL, out=0.02))
    parts.append(
        on_wall(wall, handle - 0.05, 1.06, grip, color=_METAL, out=0.06, radius=0.01)
    )  # fmt: skip
    return parts
