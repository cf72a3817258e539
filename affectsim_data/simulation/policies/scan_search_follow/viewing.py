"""Where to look at a person from: views on rings around them, by what the own map says."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.courses import PersonCourse
from affectsim_data.simulation.policies.scan_search_follow.mapping import OccupancyMap

__all__ = ["View", "best_view", "rate_views"]

BoolArray = NDArray[np.bool_]

_RADII_M = (1.4, 1.6, 1.8, 2.0, 2.2, 2.4, 2.7, 3.0)
_AZIMUTHS = 36
_IDEAL_M, _WALKER_IDEAL_M, _SEATED_MORE_M = 2.2, 2.1, 0.3
"""From 1.2 m high and at a field of view of 60 degrees, a standing adult just fits in from here.
Who walks about comes nearer and goes farther off; the feet of who sits are nearer by so much."""
_SITS_M, _STANDS_M = 1.25, 1.45
"""Mean heights of the highest point seen of people who sit and who stand."""
_CIRCLES_M = 0.6
"""Where the facing of somebody who goes so far from the middle no longer counts."""
_BODY_M = 0.45
"""Sight is asked for up to here before the person, who sits or leans on something."""
_HALF_BODY_M = 0.2
_BODY = np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]) * _HALF_BODY_M
_HALF_PERSON_M = 0.3
_CLOSE_M, _CLOSE = 1.1, 1.0
"""So near to the way of somebody who walks they will not fit in; it strains that much, by the
metre."""
_FARTHEST_M, _LEAST_SIGHT = 3.3, 0.5
_CRAMPED_M2 = 1.0
"""With so little floor in reach nothing can be chosen."""
_BEFORE_M = np.arange(0.5, 1.3, 0.05)
"""Low things so far before a person hide their legs."""
_FACING, _SIGHT, _LOW, _DISTANCE, _WAY = 2.2, 3.0, 0.8, 0.75, 0.025
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
    """Whether it is far off, much of the person is hidden, or hardly any other could be reached."""


def best_view(
    plan: OccupancyMap,
    here: FloatArray,
    course: PersonCourse,
    avoid: list[FloatArray],
    partner: FloatArray | None = None,
) -> View:
    """The view that is worth its way most; to stay where the robot is may be one.

    Args:
        plan: What is known of the home.
        here: Where the robot is, `(2,)`.
        course: What is known of the person, at least one look.
        avoid: Places that could not be reached, `(2,)` each.
        partner: Where somebody else is who belongs to them, `(2,)`: they face each other.
    """
    angle = 2.0 * np.pi * np.arange(_AZIMUTHS) / _AZIMUTHS
    ring = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    center = course.center_xz
    places = center + (np.array(_RADII_M)[:, None, None] * ring).reshape(-1, 2)
    rows, columns = plan.cells(places).T
    ways = plan.distances_from(here)
    is_cramped = np.isfinite(ways).sum() * plan.cell_m**2 < _CRAMPED_M2
    way = ways[rows, columns]
    possible = np.isfinite(way)
    for one in avoid:
        possible &= np.hypot(*(places - one).T) > 0.4
    places = np.concatenate([here[None], places[possible]])
    way = np.concatenate([[0.0], way[possible]])
    quality = rate_views(plan, places, course, partner)
    worth = quality - _WAY * way
    best = int(np.argmax(np.round(worth, 9)))
    far = math.dist(places[best], center) > _FARTHEST_M + course.reach_m
    hidden = float(_sight(plan, places[best][None], course, partner)[0]) < _LEAST_SIGHT
    is_poor = bool(far or hidden or is_cramped)
    return View(places[best], float(quality[best]), float(worth[best]), is_poor=is_poor)


def rate_views(
    plan: OccupancyMap, places: FloatArray, course: PersonCourse, partner: FloatArray | None = None
) -> FloatArray:
    """How good places `(n, 2)` are to look at a person from, `(n,)`: facing, sight, framing."""
    center = course.center_xz
    away = places - center
    distance = np.maximum(np.hypot(*away.T), 1e-6)
    # A yaw looks along (-sin, -cos) on the plan; a face is seen from where it looks to.
    facing = course.facing if partner is None else _facing_partner(course, partner)
    # Who walks to and fro is seen from all sides, wherever from.
    facing *= float(np.clip((_CIRCLES_M - course.reach_m) / (0.5 * _CIRCLES_M), 0.0, 1.0))
    front = -(away[:, 0] * facing.imag + away[:, 1] * facing.real) / distance
    sight = _sight(plan, places, course, partner)
    low = plan.occupied(center + _BEFORE_M[:, None] * (away / distance[:, None])[:, None]).any(
        axis=1
    )
    # Too near cuts the body off, too far makes it smaller.
    strain = np.minimum(np.abs(distance - _ideal_m(course)), 2.5)
    trodden = course.trodden_xz
    if len(trodden):
        nearest = np.hypot(*(places[:, None] - trodden).transpose(2, 0, 1)).min(axis=1)
        strain = strain + _CLOSE * np.maximum(_CLOSE_M - nearest, 0.0)
    # A face that something hides is worth no more than a back that it hides.
    return np.asarray(sight * (_SIGHT + _FACING * front) - _LOW * low - _DISTANCE * strain)


def _ideal_m(course: PersonCourse) -> float:
    """How far off a person is seen best, as far as their size in the image goes."""
    if course.walks:
        return _WALKER_IDEAL_M
    height_m = _STANDS_M if course.height_m is None else course.height_m
    sits = float(np.clip((_STANDS_M - height_m) / (_STANDS_M - _SITS_M), 0.0, 1.0))
    return _IDEAL_M + _SEATED_MORE_M * sits


def _facing_partner(course: PersonCourse, partner: FloatArray) -> complex:
    """As `PersonCourse.facing`, of one of two: half of it is where the other is."""
    away = partner - course.center_xz
    length = max(float(np.hypot(*away)), 1e-6)
    return 0.5 * (course.facing + complex(-away[1], -away[0]) / length)


def _sight(
    plan: OccupancyMap, places: FloatArray, course: PersonCourse, partner: FloatArray | None
) -> FloatArray:
    """Share of the upper body that nothing known hides from places `(n, 2)`, `(n,)`."""
    body = course.center_xz + _BODY
    seen = plan.line_of_sight(places, body, end_gap_m=_BODY_M)
    if partner is not None:
        seen = seen & ~_hides(partner, places, body)
    return np.asarray(seen.mean(axis=1))


def _hides(person: FloatArray, places: FloatArray, body: FloatArray) -> BoolArray:
    """Whether a person `(2,)` stands between places `(n, 2)` and points `(m, 2)`, `(n, m)`."""
    line = body - places[:, None]
    away = person - places[:, None]
    length2 = np.maximum((line**2).sum(axis=-1), 1e-9)
    share = np.clip((away * line).sum(axis=-1) / length2, 0.0, 1.0)
    off = np.linalg.norm(away - share[..., None] * line, axis=-1)
    return np.asarray((off < _HALF_PERSON_M) & (share < 1.0))
