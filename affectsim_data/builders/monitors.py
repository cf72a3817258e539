"""P-Mon cameras: one per room, near the ceiling, chosen for the room, never for the performer."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import shapely

from affectsim_data.cameras import Camera
from affectsim_data.observations import monitor_pose
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Room
from affectsim_data.visibility import RayCaster

__all__ = ["Monitor", "plan_monitor"]

_FROM_WALLS_M = (0.3, 0.2, 0.12)
"""Of a camera; nearer only in rooms too narrow or too full."""
_CLEARANCE_M = 0.1
"""Free space around it, so that it is in no cupboard, curtain or lamp."""
_FROM_CEILING_M = 0.25
_FLOOR_GRID_M = 0.4
_PITCHES_DEG = (-20.0, -27.0, -34.0)
_YAWS_DEG = tuple(range(0, 360, 15))


@dataclasses.dataclass(frozen=True)
class Monitor:
    """A fixed camera of a room."""

    position: tuple[float, float, float]
    """Metres."""
    yaw: float
    """Radians, 0 looks along -Z."""
    pitch: float
    """Radians, negative looks down."""
    floor_share: float
    """Share of the room's floor in view."""


def plan_monitor(room: Room, camera: Camera, caster: RayCaster) -> Monitor:
    """The corner, yaw and pitch that see most of the room's floor; ties go to the first."""
    polygon = shapely.make_valid(shapely.Polygon(room.polygon))
    corners = _corners(polygon, room, caster)
    floor = _floor_points(polygon, room.floor_y)
    seen = ~caster.hidden(corners[:, None], floor[None])
    yaws, pitches = (
        grid.reshape(-1)
        for grid in np.meshgrid(np.radians(_YAWS_DEG), np.radians(_PITCHES_DEG), indexing="ij")
    )
    poses = monitor_pose(corners[:, None], yaws, pitches)
    inside = camera.sees(floor, poses)
    share = (inside & seen[:, None]).mean(axis=-1)
    corner, turn = np.unravel_index(int(np.argmax(share)), share.shape)
    x, y, z = (float(value) for value in corners[corner])
    return Monitor(
        (x, y, z),
        yaw=math.remainder(float(yaws[turn]), math.tau),
        pitch=float(pitches[turn]),
        floor_share=float(share[corner, turn]),
    )


def _corners(polygon: shapely.Polygon, room: Room, caster: RayCaster) -> FloatArray:
    """Places under the ceiling in the corners of a room, free of what stands there, `(n, 3)`."""
    height = room.ceiling_y - _FROM_CEILING_M
    for margin in _FROM_WALLS_M:
        inner = polygon.buffer(-margin, join_style="mitre")
        rings = [part.exterior for part in shapely.get_parts(inner) if not part.is_empty]
        if not rings:
            continue
        plan = np.concatenate([np.array(ring.coords)[:-1] for ring in rings])
        corners = np.stack([plan[:, 0], np.full(len(plan), height), plan[:, 1]], axis=1)
        around = caster.distance(corners[:, None], _DIRECTIONS, limit=1.0).min(axis=1)
        if np.any(around >= _CLEARANCE_M):
            free: FloatArray = corners[around >= _CLEARANCE_M]
            return free
    x, z = polygon.representative_point().coords[0]
    return np.array([[x, height, z]])


def _directions() -> FloatArray:
    """To the corners, edges and sides of a cube, unit vectors, `(26, 3)`."""
    steps = np.stack(np.meshgrid(*([[-1.0, 0.0, 1.0]] * 3)), axis=-1).reshape(-1, 3)
    steps = steps[np.any(steps != 0.0, axis=1)]
    directions: FloatArray = steps / np.linalg.norm(steps, axis=1, keepdims=True)
    return directions


_DIRECTIONS = _directions()


def _floor_points(polygon: shapely.Polygon, floor_y: float) -> FloatArray:
    x0, z0, x1, z1 = polygon.bounds
    x, z = np.meshgrid(np.arange(x0, x1, _FLOOR_GRID_M), np.arange(z0, z1, _FLOOR_GRID_M))
    inside = shapely.contains_xy(polygon, x.ravel(), z.ravel())
    x, z = x.ravel()[inside], z.ravel()[inside]
    if not len(x):
        x, z = (np.array([value]) for value in polygon.representative_point().coords[0])
    return np.stack([x, np.full(len(x), floor_y + 0.05), z], axis=1)
