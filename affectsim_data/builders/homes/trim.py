"""Joinery along walls: boards at their foot, casings around doors; what else is fixed to a wall."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from affectsim_data.builders.homes.parts import Part, box
from affectsim_data.builders.homes.plans import Opening, RoomPlan, Wall
from affectsim_data.poses import FloatArray

__all__ = ["BOARD_DEPTH", "TRIM", "Finish", "baseboards", "casing", "graded", "on_wall", "span_u"]

TRIM = np.array([0.93, 0.92, 0.90])
BOARD_DEPTH = 0.012
_BOARD_HEIGHT = 0.08
_CASING_WIDTH, _CASING_DEPTH = 0.07, 0.022
_BEAD = 0.014


@dataclasses.dataclass(frozen=True)
class Finish:
    """How the joinery of a home is finished."""

    color: FloatArray
    """sRGB in [0, 1], `(3,)`."""
    material: str = "plain"
    """Key of `textures.MATERIALS`."""


def graded(*stops: float, fine: float = 0.16, most: float = 0.5) -> FloatArray:
    """Grid lines through all stops, close together beside them, at most `most` metres apart.

    Light is stored per vertex, and it changes most in corners and at the edges of windows.
    """
    unique = sorted({round(stop, 4) for stop in stops})
    pieces = [_spaced(a, b, fine, most) for a, b in itertools.pairwise(unique)]
    return np.concatenate([*pieces, [unique[-1]]])


def _spaced(start: float, end: float, fine: float, most: float) -> FloatArray:
    """Lines from `start` to before `end`, whose gaps grow towards the middle."""
    half, gap = (end - start) / 2.0, fine
    gaps: list[float] = []
    while sum(gaps) < half:
        gaps.append(gap)
        gap = min(1.6 * gap, most)
    steps = np.array([*gaps, *gaps[::-1]])
    places = start + np.concatenate([[0.0], np.cumsum(steps)]) * (end - start) / steps.sum()
    return np.asarray(places[:-1])


def on_wall(
    wall: Wall, u: float, y: float, size: tuple[float, float, float], *, color: FloatArray,
    out: float = 0.0, material: str = "plain", radius: float = 0.003,
) -> Part:  # fmt: skip
    """A box (width, height, depth) whose back is `out` metres before a wall, middle at `(u, y)`."""
    part = box(
        size, (0.0, 0.0, size[2] / 2.0), color=color, material=material,
        radius=radius, step=0.5,
    )  # fmt: skip
    x, height, z = wall.point(u, y, out)
    return part.moved(float(x), float(height), float(z), yaw=wall.yaw)


def span_u(wall: Wall, opening: Opening) -> tuple[float, float]:
    """Both ends of an opening, metres along its wall, ascending."""
    start, end = sorted(wall.u_of(place) for place in opening.span)
    return start, end


def baseboards(room: RoomPlan, wall: Wall, finish: Finish) -> list[Part]:
    """Boards along the foot of a wall, broken by doors."""
    # Only boards of two walls reach into the corners: two tops at one place would flicker.
    inset = BOARD_DEPTH if wall.side in ("left", "right") else 0.0
    cuts = sorted(
        (start - _CASING_WIDTH, end + _CASING_WIDTH)
        for start, end in (
            span_u(wall, opening)
            for opening in room.openings_in(wall.side)
            if opening.kind != "window"
        )
    )
    place, parts = inset, []
    for start, end in [*cuts, (wall.length - inset, wall.length)]:
        if start - place > 0.02:
            size = (start - place, _BOARD_HEIGHT, BOARD_DEPTH)
            parts.append(
                on_wall(
                    wall,
                    (place + start) / 2.0,
                    _BOARD_HEIGHT / 2.0,
                    size,
                    color=finish.color,
                    material=finish.material,
                )
            )
        place = end
    return parts


def casing(wall: Wall, opening: Opening, finish: Finish) -> list[Part]:
    """The frame around a door, with a bead along its outer edge."""
    u, width, top = wall.u_of(opening.middle), opening.width, opening.top
    tall = top + _CASING_WIDTH
    shift, edge = (width + _CASING_WIDTH) / 2.0, (width + 2.0 * _CASING_WIDTH - _BEAD) / 2.0
    upright, bead = (_CASING_WIDTH, tall, _CASING_DEPTH), (_BEAD, tall, 0.012)
    pieces = [
        (u - shift, tall / 2.0, upright, 0.0),
        (u + shift, tall / 2.0, upright, 0.0),
        (u, top + _CASING_WIDTH / 2.0, (width, _CASING_WIDTH, _CASING_DEPTH), 0.0),
        (u - edge, tall / 2.0, bead, _CASING_DEPTH),
        (u + edge, tall / 2.0, bead, _CASING_DEPTH),
        (u, tall - _BEAD / 2.0, (2.0 * edge - _BEAD, _BEAD, 0.012), _CASING_DEPTH),
    ]
    return [
        on_wall(wall, at, y, size, color=finish.color, material=finish.material, out=out)
        for at, y, size, out in pieces
    ]
