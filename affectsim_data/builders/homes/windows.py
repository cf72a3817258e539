"""Windows: a pane that shows the sky, its frame, the recess it sits in and a sill."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.homes.parts import Part, boxes, sheet
from affectsim_data.builders.homes.plans import Opening, Wall
from affectsim_data.builders.homes.trim import TRIM, Finish, graded, on_wall
from affectsim_data.poses import FloatArray

__all__ = ["WINDOW_RECESS", "facing", "recess", "window"]

WINDOW_RECESS = 0.1
"""From the inner face of a wall to its window panes, metres."""
_BAR, _BAR_DEPTH = 0.055, 0.05
_SASH = 0.035
_METAL = np.array([0.70, 0.70, 0.69])
_TWO_SASHES_FROM_M = 1.0


def window(wall: Wall, opening: Opening) -> list[Part]:
    """All of a window; large ones have two sashes, each with its own frame and a handle."""
    u, width, height = wall.u_of(opening.middle), opening.width, opening.top - opening.bottom
    pane = sheet(
        wall.point(u - width / 2.0, opening.bottom, -WINDOW_RECESS), wall.along,
        np.array([0.0, 1.0, 0.0]), np.array([0.0, width]), np.array([0.0, height]),
        color=(1.0, 1.0, 1.0), material="sky",
    )  # fmt: skip
    # One copy of the sky picture per window, the right way up.
    pane = dataclasses.replace(pane, uvs=pane.uvs / (width, height) + (0.0, 1.0))
    sashes, handles = _sashes(opening, u)
    sill = on_wall(wall, u, opening.bottom - 0.015, (width + 0.12, 0.03, 0.06), color=TRIM)
    return [
        pane, sill, _built(wall, _frame(opening, u), TRIM), _built(wall, sashes, 0.985 * TRIM),
        _built(wall, handles, _METAL),
        *recess(wall, opening, WINDOW_RECESS, finish=Finish(TRIM), bottom=True),
    ]  # fmt: skip


_Bar = tuple[float, float, float, tuple[float, float, float]]
"""Along the wall, height and distance before it of its middle; size. Metres."""


def _frame(opening: Opening, u: float) -> list[_Bar]:
    width, height = opening.width, opening.top - opening.bottom
    middle, out = (opening.bottom + opening.top) / 2.0, 0.004 + _BAR_DEPTH / 2.0 - WINDOW_RECESS
    upright, level = (_BAR, height, _BAR_DEPTH), (width - 2.0 * _BAR, _BAR, _BAR_DEPTH)
    bars = [
        (u - (width - _BAR) / 2.0, middle, out, upright),
        (u + (width - _BAR) / 2.0, middle, out, upright),
        (u, opening.bottom + _BAR / 2.0, out, level),
        (u, opening.top - _BAR / 2.0, out, level),
    ]
    if width >= _TWO_SASHES_FROM_M:
        bars.append((u, middle, out, (_BAR, height - 2.0 * _BAR, _BAR_DEPTH)))
    return bars


def _sashes(opening: Opening, u: float) -> tuple[list[_Bar], list[_Bar]]:
    """Movable frames within the frame, a little farther back, and a handle on each."""
    two = opening.width >= _TWO_SASHES_FROM_M
    inner = (opening.width - _BAR * (3.0 if two else 2.0)) / (2.0 if two else 1.0)
    height, middle = opening.top - opening.bottom - 2.0 * _BAR, (opening.bottom + opening.top) / 2.0
    out, shift, rise = 0.024 - WINDOW_RECESS, (inner - _SASH) / 2.0, (height - _SASH) / 2.0
    upright, level = (_SASH, height, 0.036), (inner - 2.0 * _SASH, _SASH, 0.036)
    bars: list[_Bar] = []
    handles: list[_Bar] = []
    for sign in (-1.0, 1.0) if two else (0.0,):
        at = u + sign * (inner + _BAR) / 2.0
        bars += [(at - shift, middle, out, upright), (at + shift, middle, out, upright)]
        bars += [(at, middle - rise, out, level), (at, middle + rise, out, level)]
        free = at - (sign or -1.0) * shift
        handles.append((free, middle, 0.057 - WINDOW_RECESS, (0.018, 0.11, 0.03)))
    return bars, handles


def _built(wall: Wall, bars: list[_Bar], color: FloatArray) -> Part:
    """Sharp boxes in the frame of a wall."""
    part = boxes(
        [size for _, _, _, size in bars], [(u, y, out) for u, y, out, _ in bars], colors=color
    )
    x, y, z = (float(value) for value in wall.origin)
    return part.moved(x, y, z, yaw=wall.yaw)


def recess(
    wall: Wall, opening: Opening, depth: float, *, finish: Finish, bottom: bool
) -> list[Part]:
    """The sides of a hole in a wall: left, right, top and, for windows, bottom."""
    low, high, u = opening.bottom, opening.top, wall.u_of(opening.middle)
    start, end = u - opening.width / 2.0, u + opening.width / 2.0
    up, out = np.array([0.0, 1.0, 0.0]), wall.normal
    deep, tall = graded(0.0, depth), graded(low, high, fine=0.2) - low
    wide = graded(start, end, fine=0.2) - start
    sides = [
        (wall.point(start, low), -out, up, deep, tall),
        (wall.point(end, low, -depth), out, up, deep, tall),
        (wall.point(start, high), wall.along, -out, wide, deep),
    ]
    if bottom:
        sides.append((wall.point(start, low, -depth), wall.along, out, wide, deep))
    sheets = [sheet(*side, color=finish.color, material=finish.material) for side in sides]
    return [facing(part, wall.point(u, (low + high) / 2.0, -depth / 2.0)) for part in sheets]


def facing(part: Part, point: FloatArray) -> Part:
    """The same sheet, turned over if its front does not look at `point`."""
    if float(part.normals[0] @ (point - part.positions[0])) > 0.0:
        return part
    return dataclasses.replace(part, normals=-part.normals, faces=part.faces[:, ::-1])
