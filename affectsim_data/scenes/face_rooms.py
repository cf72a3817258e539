"""Which room a triangle lies in, all of it: what rooms out of sight hide can be left out whole."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.scenes.semantics import Room

__all__ = ["SLACK_M", "face_rooms"]

SLACK_M = 0.02
"""How far a triangle may reach out of its room: baseboards end in the wall, rugs lie on floors."""


def face_rooms(corners: FloatArray, rooms: Sequence[Room]) -> NDArray[np.int32]:
    """Index of the one room that all of a triangle lies in, -1 if there is none or more than one.

    Args:
        corners: Of the triangles, metres, `(n, 3, 3)`.
        rooms: May overlap; one whose polygon crosses itself holds nothing.

    Returns:
        `(n,)`. What lies in a wall, in a doorway or outside is in no room.
    """
    found = np.full(len(corners), -1, np.int32)
    held = np.zeros(len(corners), np.int32)
    low, high = corners.min(axis=1), corners.max(axis=1)
    for index, room in enumerate(rooms):
        inside = (low[:, 1] >= room.floor_y - SLACK_M) & (high[:, 1] <= room.ceiling_y + SLACK_M)
        inside &= _in_plan(corners[:, :, [0, 2]], low[:, [0, 2]], high[:, [0, 2]], room)
        found[inside] = index
        held += inside
    found[held != 1] = -1
    return found


def _in_plan(
    corners: FloatArray, low: FloatArray, high: FloatArray, room: Room
) -> NDArray[np.bool_]:
    """Whether triangles on the plan lie in a room's polygon."""
    import shapely

    polygon: Any = shapely.Polygon(room.polygon)
    if not polygon.is_valid:
        return np.zeros(len(corners), bool)
    wide = polygon.buffer(SLACK_M, join_style="mitre")
    bounds = np.array(wide.bounds)
    inside = np.asarray(((low >= bounds[:2]) & (high <= bounds[2:])).all(axis=1))
    if wide.area < shapely.box(*wide.bounds).area - 1e-9:
        # Rooms have no holes, so a triangle whose outline is inside is inside.
        near = np.flatnonzero(inside)
        shapely.prepare(wide)
        outlines = shapely.linestrings(corners[near][:, [0, 1, 2, 0]])
        inside[near] = shapely.covers(wide, outlines)
    return inside
