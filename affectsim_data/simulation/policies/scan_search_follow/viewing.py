"""Where to look at a person from: views on rings around them, by what the own map says."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.courses import PersonCourse
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap
from affectsim_data.simulation.policies.scan_search_follow.ways import way_lengths

__all__ = ["View", "best_view", "rate_views"]

_RADII_M = (1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0)
_AZIMUTHS = 36
_IDEAL_M = 2.2
"""From 1.2 m high and at a field of view of 60 degrees, a standing adult just fits in from here."""
_ROOM_FOR_COURSE = 0.35
"""Share of how far the person goes from the middle that the robot keeps more."""
_BODY_M = 0.45
"""Sight is asked for up to here before the person, who sits or leans on something."""
_HALF_BODY_M = 0.2
_BODY = np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]) * _HALF_BODY_M
_FARTHEST_M, _LEAST_SIGHT = 3.3, 0.5
_BEFORE_M = np.arange(0.5, 1.3, 0.05)
"""Low things so far before a person hide their legs."""
_FACING, _SIGHT, _LOW, _DISTANCE, _WAY = 1.4, 2.0, 0.3, 0.6, 0.025
"""What a view gains by each; distance and way count against it, by the metre."""


@dataclasses.dataclass(frozen=True, eq=False)
class View:
    """A place to look at a person from."""

    place_xz: FloatArray
    """Where the robot stands, `(2,)`."""
    quality: float
    """How good the view is, whatever the way there."""
    worth: float
    """The same less what the way costs."""
    is_poor: bool = False
    """Whether it is far off, or much of the person is hidden."""


def best_view(
    plan: OccupancyMap, here: FloatArray, course: PersonCourse, avoid: list[FloatArray]
) -> View:
    """The view that is worth its way most; to stay where the robot is may be one.

    Args:
        plan: What is known of the home.
        here: Where the robot is, `(2,)`.
        course: What is known of the person, at least one look.
        avoid: Places that could not be reached, `(2,)` each.
    """
    angle = 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
    ring = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    radii = np.array(_RADII_M) + _ROOM_FOR_COURSE * course.reach_m
    places = course.center_xz + (radii[:, None, None] * ring).reshape(-1, 2)
    rows, columns = plan.cells(places).T
    way = way_lengths(plan, here)[rows, columns]
    possible = np.isfinite(way)
    for one in avoid:
        possible &= np.hypot(*(places - one).T) > 0.4
    places = np.concatenate([here[None], places[possible]])
    way = np.concatenate([[0.0], way[possible]])
    quality = rate_views(plan, places, course)
    worth = quality - _WAY * way
    best = int(np.argmax(np.round(worth, 9)))
    far = math.dist(places[best], course.center_xz) > _FARTHEST_M + course.reach_m
    hidden = float(_sight(plan, places[best][None], course)[0]) < _LEAST_SIGHT
    return View(places[best], float(quality[best]), float(worth[best]), far or hidden)


def rate_views(plan: OccupancyMap, places: FloatArray, course: PersonCourse) -> FloatArray:
    """How good places `(n, 2)` are to look at a person from, `(n,)`: facing, sight, framing."""
    away = places - course.center_xz
    distance = np.maximum(np.hypot(*away.T), 1e-6)
    # A yaw looks along (-sin, -cos) on the plan; a face is seen from where it looks to.
    facing = course.facing
    front = -(away[:, 0] * facing.imag + away[:, 1] * facing.real) / distance
    sight = _sight(plan, places, course)
    low = plan.occupied(
        course.center_xz + _BEFORE_M[:, None] * (away / distance[:, None])[:, None]
    ).any(axis=1)
    off = distance - (_IDEAL_M + _ROOM_FOR_COURSE * course.reach_m)
    # Too near cuts the body off, and soon; too far only makes it smaller.
    strain = np.minimum(np.where(off < 0.0, -0.9 * off, off), 2.5)
    # A face that something hides is worth no more than a back that it hides.
    return np.asarray(sight * (_SIGHT + _FACING * front) - _LOW * low - _DISTANCE * strain)


def _sight(plan: OccupancyMap, places: FloatArray, course: PersonCourse) -> FloatArray:
    """Share of the upper body that nothing known hides from places `(n, 2)`, `(n,)`."""
    body = course.center_xz + _BODY
    return np.asarray(plan.line_of_sight(places, body, end_gap_m=_BODY_M).mean(axis=1))
