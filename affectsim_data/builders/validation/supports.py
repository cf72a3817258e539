"""Whether sitters are on their seats, and knocking hands at their doors."""

from __future__ import annotations

import functools
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.measuring import PELVIS_OVER_SEAT_M
from affectsim_data.builders.placement.supports import (
    BEFORE_SEAT_M,
    FEET_OFF_FLOOR_M,
    HAND_SHORT_M,
    HAND_THROUGH_M,
    PELVIS_OFF_SEAT_M,
    PELVIS_OFF_SEAT_PLAN_M,
)
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.navigation import off_island
from affectsim_data.builders.validation.part import Part
from affectsim_data.poses import FloatArray, transform_points
from affectsim_data.scenes import Door, Seat

__all__ = ["check_supports"]

UPRIGHT_SHARE = 0.85
"""Of the standing height of a pelvis, from which on a person stands."""
FACING_DEG = 20.0
"""Between the facing and the way a seat or door asks for."""
SKIN_BELOW_M, SKIN_ABOVE_M = -0.10, 0.15
"""Lowest skin of a sitter to the floor: soles sink into rugs, and feet are lifted."""
_SLACK_M = 0.01
"""Beyond what the composer grants: it looks at some instants, this at every frame."""
_LOWEST_M = 0.03
"""A pelvis within this of its lowest height is down."""


def check_supports(part: Part) -> list[Measure]:
    """Seats of sitters, doors of who knocks."""
    sitting = np.isin(part.kinds.astype(str), ["seat", "before_seat"])
    knocking = part.kinds == "door"
    supports: dict[int, Seat | Door] = {}
    notes = [""] * len(part)
    for place in np.flatnonzero(sitting | knocking):
        found = _support(part, int(place), "seat" if sitting[place] else "door")
        if isinstance(found, str):
            notes[place] = found
        else:
            supports[int(place)] = found
    lacking = np.array([float(bool(note)) for note in notes])
    named = part.measure(
        "support_named", lacking, where=sitting | knocking, high=0, notes=tuple(notes)
    )
    return [named, *_seats(part, supports), *_doors(part, supports)]


def _support(part: Part, place: int, kind: str) -> Seat | Door | str:
    """The seat or door an episode names, or why there is none."""
    text = part.episodes.text("support")[place]
    word, _, number = str(text).partition(" ")
    things: tuple[Seat | Door, ...] = part.scene.seats if kind == "seat" else part.scene.doors
    if text is None or word != kind or not number.isdigit():
        return f"expected a support like '{kind} 0', got {text!r}"
    if int(number) >= len(things):
        return f"the scene has {len(things)} {kind}s, got {text!r}"
    return things[int(number)]


def _seats(part: Part, supports: dict[int, Seat | Door]) -> list[Measure]:
    plan, height, facing, floor, skin, standing, free = (
        np.full(len(part), np.nan) for _ in range(7)
    )
    for place, seat in supports.items():
        if not isinstance(seat, Seat):
            continue
        track, pose, position = part.tracks[place], part.pose[place], np.array(seat.position)
        low = transform_points(pose, track.pelvis[_is_down(track.pelvis)]).mean(axis=0)
        plan[place] = math.hypot(*(low - position)[[0, 2]])
        height[place] = low[1] - position[1] - PELVIS_OVER_SEAT_M * track.motion_scale
        facing[place] = _turn_deg(part.episodes.number("facing_deg")[place], seat.yaw_deg)
        ground = position[1] - seat.height
        floor[place] = pose[1, 3] - ground
        skin[place] = part.surface[place, ..., 1].min() - ground
        standing[place] = track.pelvis[0, 1] / track.hip_height_m
        free[place] = off_island(part, part.anchor[place])
    there = np.isfinite(plan)
    rises = there & (part.kinds == "before_seat")
    measure = functools.partial(part.measure, where=there)
    high_m, floor_m = PELVIS_OFF_SEAT_M + _SLACK_M, FEET_OFF_FLOOR_M + _SLACK_M
    return [
        measure("seat_place", plan, high=PELVIS_OFF_SEAT_PLAN_M + _SLACK_M),
        measure("seat_height", height, low=-high_m, high=high_m),
        measure("seat_facing", facing, high=FACING_DEG),
        measure("seat_floor", floor, low=-floor_m, high=floor_m),
        measure("seat_feet", skin, low=SKIN_BELOW_M, high=SKIN_ABOVE_M),
        part.measure("sit_standing", standing, where=rises, low=UPRIGHT_SHARE),
        part.measure("sit_floor", free, where=rises, high=BEFORE_SEAT_M + _SLACK_M),
    ]


def _is_down(pelvis: FloatArray) -> NDArray[np.bool_]:
    """Frames in which a pelvis `(num_frames, 3)` is lowest, `(num_frames,)`."""
    return np.asarray(pelvis[:, 1] <= pelvis[:, 1].min() + _LOWEST_M)


def _doors(part: Part, supports: dict[int, Seat | Door]) -> list[Measure]:
    count = len(part)
    opening, facing, gap, beside = (np.full(count, np.nan) for _ in range(4))
    for place, door in supports.items():
        if not isinstance(door, Door):
            continue
        opening[place] = abs(door.opening_deg)
        facing[place] = _turn_deg(part.episodes.number("facing_deg")[place], door.yaw_deg + 180.0)
        names = (part.episodes.text(f"{one}_id")[place] for one in ("motion", "avatar"))
        hands = transform_points(part.pose[place], part.bodies.hands(*names).reshape(-1, 3))
        ahead, across, up = _at_leaf(door, hands)
        nearest = int(np.argmin(ahead))
        gap[place] = ahead[nearest]
        out = np.array([abs(across[nearest]) - door.width / 2.0, up[nearest] - door.height])
        beside[place] = np.maximum(out, [0.0, -up[nearest]]).max()
    there = np.isfinite(gap)
    through_m, short_m = HAND_THROUGH_M + _SLACK_M, HAND_SHORT_M + _SLACK_M
    return [
        part.measure("door_closed", opening, where=there, high=0.0),
        part.measure("door_facing", facing, where=there, high=FACING_DEG),
        part.measure("door_hand", gap, where=there, low=-through_m, high=short_m),
        part.measure("door_contact", beside, where=there, high=0.0),
    ]


def _at_leaf(door: Door, points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Points `(n, 3)` before the leaf, beside its middle, and above its foot, metres, `(n,)`."""
    yaw = math.radians(door.yaw_deg)
    out = np.array([math.sin(yaw), 0.0, math.cos(yaw)])
    along = np.array([math.cos(yaw), 0.0, -math.sin(yaw)])
    knock, hinge = np.array(door.knock_point), np.array(door.hinge)
    side = 1.0 if float((knock - hinge) @ along) >= 0.0 else -1.0
    middle = hinge + side * door.width / 2.0 * along
    return (points - knock) @ out, (points - middle) @ along, points[:, 1] - hinge[1]


def _turn_deg(one: float, two: float) -> float:
    """Angle between two yaws, degrees, 0 to 180."""
    return abs(math.remainder(one - two, 360.0))
