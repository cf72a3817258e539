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

_FROM_WALLS_M = 0.3
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
    polygon = shapely.Polygon(room.polygon)
    corners = _corners(polygon, room)
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


def _corners(polygon: shapely.Polygon, room: Room) -> FloatArray:
    inner = polygon.buffer(-_FROM_WALLS_M, join_style="mitre")
    ring = np.array(inner.exterior.coords)[:-1] if not inner.is_empty else np.array(room.polygon)
    height = np.full(len(ring), room.ceiling_y - _FROM_CEILING_M)
    return np.stack([ring[:, 0], height, ring[:, 1]], axis=1)


def _floor_points(polygon: shapely.Polygon, floor_y: float) -> FloatArray:
    x0, z0, x1, z1 = polygon.bounds
    x, z = np.meshgrid(np.arange(x0, x1, _FLOOR_GRID_M), np.arange(z0, z1, _FLOOR_GRID_M))
    inside = shapely.contains_xy(polygon, x.ravel(), z.ravel())
    x, z = x.ravel()[inside], z.ravel()[inside]
    return np.stack([x, np.full(len(x), floor_y + 0.05), z], axis=1)
