"""Door leaves among imported things, found from their shape: what one can knock on."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.habitat.things import Thing
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Door

__all__ = ["DOOR_CATEGORIES", "doors_on"]

DOOR_CATEGORIES = ("door", "exterior_door", "interior_door")
_WIDTHS_M, _HEIGHTS_M = (0.55, 1.3), (1.7, 2.6)
"""Of a door with its frame."""
_MOST_DEPTH_M = 0.35
_KNOCK_HEIGHT_M = 1.4
_INNER = 0.6
"""Share of width and height, in the middle, that the leaf must fill: a frame alone is a way."""
_FILLED = 0.6
"""Share of that area which is there, for a leaf."""


def doors_on(thing: Thing, *, floor_y: float) -> list[Door]:
    """Both sides of a closed leaf; empty if the thing is no door, or an open one.

    A door is upright, as wide and high as doors are and thin; a leaf is where triangles that face
    its side fill most of the middle.

    Args:
        thing: Any thing; a stand-in has no leaf.
        floor_y: Height of the floor it stands on, metres.
    """
    if thing.category not in DOOR_CATEGORIES or thing.stand_in or not thing.upright:
        return []
    points = thing.points
    if abs(float(points[:, 1].min()) - floor_y) > 0.2:
        return []
    low, high = _box(points, thing.yaw_deg)
    # Templates call either axis the front: the thin one is across the leaf.
    turn = 90.0 if high[0] - low[0] < high[2] - low[2] else 0.0
    doors = []
    for yaw_deg in (thing.yaw_deg + turn, thing.yaw_deg + turn + 180.0):
        door = _side(thing, (yaw_deg + 180.0) % 360.0 - 180.0, floor_y)
        doors += [] if door is None else [door]
    return doors


def _side(thing: Thing, yaw_deg: float, floor_y: float) -> Door | None:
    """The leaf as seen from one side."""
    frame = _frame(yaw_deg)
    low, high = _box(thing.points, yaw_deg)
    width, height, depth = high - low
    if not (
        _WIDTHS_M[0] <= width <= _WIDTHS_M[1]
        and _HEIGHTS_M[0] <= height <= _HEIGHTS_M[1]
        and depth <= _MOST_DEPTH_M
    ):
        return None
    middle = 0.5 * (low + high)
    areas, depths = _facing_areas(thing, frame, middle, 0.5 * _INNER * (high - low))
    if areas.sum() < _FILLED * _INNER**2 * width * height:
        return None
    order = np.argsort(depths)
    shares = np.cumsum(areas[order]) / areas.sum()
    leaf_z = float(depths[order][np.searchsorted(shares, 0.5)])
    knock = frame @ (middle[0], floor_y + _KNOCK_HEIGHT_M, leaf_z)
    hinge = frame @ (low[0], floor_y, leaf_z)
    return Door(
        knock_point=_point(knock),
        yaw_deg=yaw_deg,
        width=float(width),
        height=float(height),
        hinge=_point(hinge),
    )


def _facing_areas(
    thing: Thing, frame: FloatArray, middle: FloatArray, half: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Areas in the middle of the leaf, seen from the front, and how far forward they are.

    Triangles are as large as the leaf, so each counts by the part of its box that lies in the
    middle.
    """
    corners = (
        np.concatenate([one.positions[one.faces].astype(np.float64) for one in thing.surfaces])
        @ frame
    )
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    ahead = np.divide(
        normals[:, 2],
        np.linalg.norm(normals, axis=1),
        out=np.zeros(len(normals)),
        where=normals.any(axis=1),
    )
    corners, seen = corners[ahead > 0.7], 0.5 * normals[ahead > 0.7, 2]
    low, high = corners.min(axis=1)[:, :2], corners.max(axis=1)[:, :2]
    inside = np.minimum(high, (middle + half)[:2]) - np.maximum(low, (middle - half)[:2])
    share = np.clip(inside / np.maximum(high - low, 1e-9), 0.0, 1.0).prod(axis=1)
    return seen * share, corners[:, :, 2].mean(axis=1)


def _box(points: FloatArray, yaw_deg: float) -> tuple[FloatArray, FloatArray]:
    turned = points @ _frame(yaw_deg)
    return turned.min(axis=0), turned.max(axis=0)


def _frame(yaw_deg: float) -> FloatArray:
    """Columns: left, up and forward of a frame that looks along the yaw, `(3, 3)`."""
    s, c = np.sin(np.radians(yaw_deg)), np.cos(np.radians(yaw_deg))
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _point(place: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(number) for number in place)
    return (x, y, z)
