"""Where doorways lie in the walls that rooms share, and which have a leaf that stands open."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.builders.homes.plans.draft import NoPlaceError, PlanDraft
from affectsim_data.builders.homes.plans.links import Link
from affectsim_data.builders.homes.plans.model import Leaf, Opening, Rect, RoomPlan, Side

__all__ = ["LEAF_GAP_M", "LEAF_OUT_M", "LEAF_THICKNESS_M", "leaf_width", "place_doorways"]

LEAF_THICKNESS_M = 0.04
LEAF_OUT_M = 0.03
"""From the face of a wall to the hinge of an open leaf: it turns about the edge of the casing."""
LEAF_GAP_M = 0.02
"""By which a leaf is narrower than its opening."""
_HANDLE_M = 0.065
_FROM_CORNER_M = (0.2, 0.28)
"""From the corner of a room to a doorway whose leaf stands open along the other wall."""
_EDGE_M = 0.12
_MOST_BEYOND_DEG = 9.0
_WITH_LEAF = ("bedroom", "bath", "study")
_LEAF_CHANCE = 0.35
"""Of doorways between other rooms."""
_OPPOSITE: dict[Side, Side] = {
    "left": "right", "right": "left", "back": "front", "front": "back",
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class _Option:
    """A place of a doorway, and the room and end its leaf has, if it has one."""

    middle: float
    room: int | None = None
    leaf: Leaf | None = None
    blocked: Rect | None = None


def leaf_width(opening: Opening) -> float:
    """Of the leaf of an opening, metres."""
    return opening.width - LEAF_GAP_M


def place_doorways(draft: PlanDraft, links: list[Link], *, rng: np.random.Generator) -> None:
    """Adds all doorways to a draft.

    Raises:
        NoPlaceError: One fits nowhere.
    """
    for link in links:
        options = _options(draft, link, rng)
        fitting = [option for option in options if _fits(draft, link, option)]
        if not fitting:
            raise NoPlaceError("a doorway")
        wanted = _wants_leaf(draft, link, rng)
        leaves = [option for option in fitting if (option.leaf is not None) == wanted]
        _add(draft, link, (leaves or fitting)[0])


def _wants_leaf(draft: PlanDraft, link: Link, rng: np.random.Generator) -> bool:
    purposes = {draft.rooms[number].purpose for number in link.wall.rooms}
    chance = float(rng.random())
    if link.width > 1.5:
        return False
    return bool(purposes & set(_WITH_LEAF)) or chance < _LEAF_CHANCE


def _options(draft: PlanDraft, link: Link, rng: np.random.Generator) -> list[_Option]:
    """Places to try, those with a leaf first, in random order."""
    wall, half = link.wall, link.width / 2.0
    if link.width > 1.5:
        slack = (wall.length - link.width) / 2.0 - 0.15
        shifts = [0.0, *rng.uniform(-slack, slack, 3)] if slack > 0.0 else [0.0]
        return [_Option(round((wall.low + wall.high) / 2.0 + s, 3)) for s in shifts[::-1]]
    options = []
    ends = [("low", wall.low, 1.0), ("high", wall.high, -1.0)]
    for k in rng.permutation(2):
        _, corner, sign = ends[k]
        margin = float(rng.uniform(*_FROM_CORNER_M))
        middle = round(corner + sign * (margin + half), 3)
        if not wall.low + half + _EDGE_M <= middle <= wall.high - half - _EDGE_M:
            continue
        options += [
            _leaf_option(draft, link, number, middle, corner, rng)
            for number in _leaf_rooms(draft, link, corner)
        ]
        options.append(_Option(middle))
    options.append(_Option(round((wall.low + wall.high) / 2.0, 3)))
    return sorted(options, key=lambda option: option.leaf is None)


def _leaf_rooms(draft: PlanDraft, link: Link, corner: float) -> list[int]:
    """Rooms of a link that end at `corner`, rooms one retires to first; never halls."""
    found = []
    for number in (link.wall.first, link.wall.second):
        room = draft.rooms[number]
        ends = room.span(_side_of(link, number))
        if room.purpose != "hall" and min(abs(end - corner) for end in ends) < 0.01:
            found.append(number)
    return sorted(found, key=lambda number: draft.rooms[number].purpose not in _WITH_LEAF)


def _leaf_option(
    draft: PlanDraft, link: Link, number: int, middle: float, corner: float,
    rng: np.random.Generator,
) -> _Option:  # fmt: skip
    """A doorway whose leaf turns into a room and stands along the wall at `corner`."""
    low = corner < middle
    hinge = middle - link.width / 2.0 if low else middle + link.width / 2.0
    length = link.width - LEAF_GAP_M
    free = abs(hinge - corner) - LEAF_THICKNESS_M - _HANDLE_M - 0.02
    most = min(math.degrees(math.asin(max(free, 0.0) / length)), _MOST_BEYOND_DEG)
    angle = 90.0 + round(float(rng.uniform(0.3, 1.0)) * most, 1)
    inner = hinge + (0.03 if low else -0.03)
    wall = draft.rooms[number].wall(_side_of(link, number))
    rect = wall.rect((min(corner, inner), max(corner, inner)), length + LEAF_OUT_M + 0.03)
    return _Option(middle, number, Leaf("low" if low else "high", angle), rect)


def _side_of(link: Link, number: int) -> Side:
    return link.wall.side if number == link.wall.first else _OPPOSITE[link.wall.side]


def _openings(draft: PlanDraft, link: Link, option: _Option) -> dict[int, Opening]:
    """The two faces of a doorway, by room."""
    top = draft.door_top
    if link.width > 1.5:
        top = min(draft.rooms[link.wall.first].ceiling_y - 0.25, 2.3)
    found = {}
    for number, other in (
        (link.wall.first, link.wall.second),
        (link.wall.second, link.wall.first),
    ):
        leaf = option.leaf if option.room == number else None
        found[number] = Opening(
            "doorway", _side_of(link, number), option.middle, link.width, 0.0, top,
            leaf=leaf, to_room=draft.rooms[other].room_id,
        )  # fmt: skip
    return found


def _fits(draft: PlanDraft, link: Link, option: _Option) -> bool:
    """Whether no leaf stands before a doorway, neither this one's nor another's."""
    for number, opening in _openings(draft, link, option).items():
        if draft.meets(number, draft.zone(number, opening)):
            return False
    if option.room is None or option.blocked is None:
        return True
    room = draft.rooms[option.room]
    return _inside(room, option.blocked) and not draft.meets(
        option.room, option.blocked, leaves=True, zones=True
    )


def _inside(room: RoomPlan, rect: Rect) -> bool:
    x0, z0, x1, z1 = rect
    inside = x0 >= room.x0 - 1e-6 and z0 >= room.z0 - 1e-6
    return inside and x1 <= room.x1 + 1e-6 and z1 <= room.z1 + 1e-6


def _add(draft: PlanDraft, link: Link, option: _Option) -> None:
    for number, opening in _openings(draft, link, option).items():
        blocked = () if option.blocked is None or number != option.room else (option.blocked,)
        draft.add(number, opening, blocked=blocked)
