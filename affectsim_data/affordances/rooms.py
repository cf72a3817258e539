"""Which room points are in, and which points see each other."""

from __future__ import annotations

import functools

import numpy as np
import shapely
from numpy.typing import ArrayLike, NDArray

from affectsim_data.scenes import Scene
from affectsim_data.visibility import scene_caster

__all__ = ["line_of_sight", "rooms_of", "same_room"]

# A seated or planted body's root may lie a little below the floor of its room.
_BELOW_FLOOR_M = 0.5


def rooms_of(scene: Scene, points: ArrayLike) -> NDArray[np.int64]:
    """Index into `scene.rooms` of the room each point `(..., 3)` is in, `(...)`; -1 for none.

    A point on the line between two rooms is in neither; where rooms overlap the first one counts.
    """
    where = np.asarray(points, np.float64)
    x, y, z = np.moveaxis(where, -1, 0)
    number = np.full(x.shape, -1, np.int64)
    for index, polygon in reversed(list(enumerate(_room_polygons(scene)))):
        room = scene.rooms[index]
        inside = shapely.contains_xy(polygon, x, z)
        inside &= (y >= room.floor_y - _BELOW_FLOOR_M) & (y <= room.ceiling_y)
        number = np.where(inside, index, number)
    return number


def same_room(scene: Scene, points: ArrayLike, others: ArrayLike) -> NDArray[np.bool_]:
    """Whether points and others, `(..., 3)` each, are in one room, `(...)`; false outside rooms."""
    room = rooms_of(scene, points)
    same: NDArray[np.bool_] = (room == rooms_of(scene, others)) & (room >= 0)
    return same


def line_of_sight(scene: Scene, points: ArrayLike, others: ArrayLike) -> NDArray[np.bool_]:
    """Whether nothing of the scene stands between points and others, `(..., 3)` each, `(...)`."""
    seen: NDArray[np.bool_] = ~scene_caster(scene).hidden(points, others)
    return seen


@functools.lru_cache(maxsize=8)
def _room_polygons(scene: Scene) -> tuple[shapely.Polygon, ...]:
    polygons = tuple(shapely.Polygon(room.polygon) for room in scene.rooms)
    shapely.prepare(polygons)
    return polygons
