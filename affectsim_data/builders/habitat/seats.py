"""Where one can sit on an imported piece of furniture, found from its shape."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.habitat.things import Thing
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Seat

__all__ = ["SEAT_CATEGORIES", "seats_on"]

SEAT_CATEGORIES = ("armchair", "bed", "bench", "chair", "sofa", "stool")
_HEIGHTS_M = (0.28, 0.68)
"""Of seats above the floor."""
_BED_HEIGHTS_M = (0.28, 0.8)
_LEVEL = 0.8
"""Least upward part of the normal of a seat surface."""
_THICKNESS_M = 0.05
"""Half of the heights that belong to one seat surface: cushions are not flat."""
_LEAST_AREA_M2 = 0.05
_LEAST_SHARE = 0.5
"""Of the area of the largest level part, for a higher one to be the seat."""
_BACK_M = 0.12
"""What is higher above the seat than this is a back or an arm."""
_PLACE_M = 0.6
"""Width of a place on a sofa."""
_EDGE_M = 0.2
"""From where the pelvis rests to the front edge."""
_MAX_DEPTH_M = 0.6


@dataclasses.dataclass(frozen=True)
class _Shape:
    """Triangles in a frame that looks along +Z."""

    corners: FloatArray
    """`(n, 3, 3)`"""
    areas: FloatArray
    """`(n,)`"""
    up: FloatArray
    """Upward part of their normals, `(n,)`."""

    @property
    def middles(self) -> FloatArray:
        """`(n, 3)`"""
        middles: FloatArray = self.corners.mean(axis=1)
        return middles

    def plan_box(self, chosen: NDArray[np.bool_], share: float) -> tuple[FloatArray, FloatArray]:
        """Low and high corner on the plan of some triangles, their outermost share left out."""
        points = self.corners[chosen].reshape(-1, 3)
        weights = np.repeat(self.areas[chosen], 3)
        low, high = (
            np.array([_weighted(points[:, k], weights, part) for k in (0, 2)])
            for part in (share, 1.0 - share)
        )
        return low, high


def seats_on(thing: Thing, *, floor_y: float) -> list[Seat]:
    """Seats of a thing that stands on the floor; empty if it is none to sit on.

    The seat surface is the highest of the large level parts at sitting height: cushions lie on
    boards. A sitter looks away from the back where there is one, else the way the template's front
    faces.

    Args:
        thing: Any thing; a stand-in has no seats.
        floor_y: Height of the floor it stands on, metres.
    """
    if thing.category not in SEAT_CATEGORIES or thing.stand_in or not thing.upright:
        return []
    points = thing.points
    if abs(float(points[:, 1].min()) - floor_y) > 0.2:
        return []
    is_bed = thing.category == "bed"
    shape = _shape(thing, thing.yaw_deg)
    low, high = _BED_HEIGHTS_M if is_bed else _HEIGHTS_M
    level = shape.up > _LEVEL
    level &= (shape.middles[:, 1] > floor_y + low) & (shape.middles[:, 1] < floor_y + high)
    if shape.areas[level].sum() < _LEAST_AREA_M2:
        return []
    seat_y = _seat_height(shape.middles[level, 1], shape.areas[level])
    if is_bed:
        return [
            seat
            for turn in (90.0, -90.0)
            for seat in _places(thing, thing.yaw_deg + turn, seat_y, floor_y, most=1)
        ]
    most = None if thing.category in ("sofa", "bench") else 1
    return _places(thing, _facing(thing, shape, seat_y), seat_y, floor_y, most=most)


def _shape(thing: Thing, yaw_deg: float) -> _Shape:
    corners = np.concatenate(
        [one.positions[one.faces].astype(np.float64) for one in thing.surfaces]
    ) @ _frame(yaw_deg)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    doubled = np.linalg.norm(cross, axis=1)
    up = np.divide(cross[:, 1], doubled, out=np.zeros_like(doubled), where=doubled > 0.0)
    return _Shape(corners, doubled / 2.0, up)


def _frame(yaw_deg: float) -> FloatArray:
    """Columns: left, up and forward of a frame that looks along the yaw, `(3, 3)`."""
    s, c = np.sin(np.radians(yaw_deg)), np.cos(np.radians(yaw_deg))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _seat_height(heights: FloatArray, areas: FloatArray) -> float:
    """The highest height that has much area within the thickness of a seat."""
    order = np.argsort(heights)
    heights, total = heights[order], np.concatenate([[0.0], np.cumsum(areas[order])])
    first = np.searchsorted(heights, heights - _THICKNESS_M, side="left")
    last = np.searchsorted(heights, heights + _THICKNESS_M, side="right")
    sums = total[last] - total[first]
    highest = heights[np.flatnonzero(sums >= _LEAST_SHARE * sums.max())[-1]]
    # From there down to where most of it is.
    near = np.abs(heights - highest) <= 2.0 * _THICKNESS_M
    best = int(np.argmax(np.where(near, sums, -1.0)))
    inside = slice(first[best], last[best])
    return float(np.average(heights[inside], weights=areas[order][inside]))


def _facing(thing: Thing, shape: _Shape, seat_y: float) -> float:
    """The yaw of a sitter: away from the back, along one of the axes of the template."""
    above = shape.middles[:, 1] > seat_y + _BACK_M
    if shape.areas[above].sum() < _LEAST_AREA_M2:
        return thing.yaw_deg
    low, high = shape.plan_box(np.ones(len(above), bool), 0.0)
    back = np.average(shape.middles[above][:, [0, 2]], axis=0, weights=shape.areas[above])
    share = (back - (low + high) / 2.0) / (high - low)
    axis = int(np.argmax(np.abs(share)))
    if abs(share[axis]) < 0.08:
        return thing.yaw_deg
    # Axis 0 is to the left of the front: a quarter turn counter-clockwise from above.
    return thing.yaw_deg + (90.0 if axis == 0 else 0.0) + (180.0 if share[axis] > 0.0 else 0.0)


def _places(
    thing: Thing, yaw_deg: float, seat_y: float, floor_y: float, *, most: int | None
) -> list[Seat]:
    """Places side by side along the front edge of the seat surface."""
    shape = _shape(thing, yaw_deg)
    seat = (shape.up > _LEVEL) & (np.abs(shape.middles[:, 1] - seat_y) <= _THICKNESS_M)
    low, high = shape.plan_box(seat, 0.02)
    width, depth = high - low
    count = max(1, int((width + 0.1) / _PLACE_M)) if most is None else most
    edge = min(_EDGE_M, depth / 2.0)
    offsets = (np.arange(count) - (count - 1) / 2.0) * width / count
    local = np.stack(
        [
            (low[0] + high[0]) / 2.0 + offsets,
            np.full(count, seat_y),
            np.full(count, high[1] - edge),
        ],
        axis=1,
    )
    yaw = float((yaw_deg + 180.0) % 360.0 - 180.0)
    return [
        Seat(
            position=(float(x), float(y), float(z)),
            yaw_deg=yaw,
            depth=float(min(depth, _MAX_DEPTH_M)),
            height=float(seat_y - floor_y),
        )
        for x, y, z in local @ _frame(yaw_deg).T
    ]


def _weighted(values: FloatArray, weights: FloatArray, share: float) -> float:
    """Value below which this share of the weight lies."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, share * total[-1])])
