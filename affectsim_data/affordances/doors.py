"""Doors: whether one can stand before a closed leaf and knock on it."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.affordances.rooms import rooms_of
from affectsim_data.affordances.standing import clearance
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.visibility import scene_caster

__all__ = ["DoorAccess", "knockable_doors"]

# How far before the leaf people stand to knock, the most comfortable first; metres.
DISTANCES_M = (0.65, 0.6, 0.7, 0.55, 0.75, 0.5, 0.8)


@dataclasses.dataclass(frozen=True, eq=False)
class DoorAccess:
    """Where one can knock, arrays over the `n` doors of a scene."""

    stand: FloatArray
    """Place on the floor of the free side, `(n, 3)`; nan if there is none."""
    is_closed: NDArray[np.bool_]
    """Whether the leaf is closed, `(n,)`."""

    @property
    def is_knockable(self) -> NDArray[np.bool_]:
        """Whether the leaf is closed and one can stand before it, `(n,)`."""
        knockable: NDArray[np.bool_] = self.is_closed & np.all(np.isfinite(self.stand), axis=1)
        return knockable


def knockable_doors(
    scene: Scene, navmesh: NavMesh, *, start: ArrayLike | None = None, radius_m: float = 0.3
) -> DoorAccess:
    """Which doors can be knocked on from their free side, and from where.

    A place counts if it is 0.5 to 0.8 m straight before the knock point, on the navmesh where the
    robot can come, in the door's own room if it names one, with a free disc around it, and nothing
    between it and the knock point.

    Args:
        scene: With its doors.
        navmesh: Of the scene.
        start: Where the robot is, `(3,)`; anywhere on the largest island if not given.
        radius_m: Of the free disc, metres; below the leaf's distance.
    """
    doors = scene.doors
    knock = np.array([door.knock_point for door in doors], np.float64).reshape(-1, 3)
    yaw = np.radians([door.yaw_deg for door in doors])
    out = np.stack([np.sin(yaw), 0.0 * yaw, np.cos(yaw)], axis=-1)
    foot = np.array([door.hinge[1] for door in doors], np.float64)
    stand = knock[:, None] + np.array(DISTANCES_M)[:, None] * out[:, None]
    stand[..., 1] = foot[:, None]
    good = _stands(navmesh, stand.reshape(-1, 3), start, radius_m).reshape(stand.shape[:2])
    hand = stand.copy()
    hand[..., 1] = knock[:, None, 1]
    good &= ~scene_caster(scene).hidden(hand, knock[:, None])
    names = [room.room_id for room in scene.rooms]
    room = np.array([names.index(d.room_id) if d.room_id in names else -1 for d in doors], np.int64)
    good &= (room < 0)[:, None] | (rooms_of(scene, stand) == room[:, None])
    best = np.argmax(good, axis=1) if len(doors) else np.zeros(0, np.int64)
    chosen = stand[np.arange(len(doors)), best]
    if len(doors):
        chosen[~np.any(good, axis=1)] = np.nan
    return DoorAccess(chosen, np.array([door.is_closed for door in doors], bool))


def _stands(
    navmesh: NavMesh, points: FloatArray, start: ArrayLike | None, radius_m: float
) -> NDArray[np.bool_]:
    """Whether points `(n, 3)` are on the robot's island with a free disc around them, `(n,)`."""
    island = 0 if start is None else navmesh.island(start)
    stands: NDArray[np.bool_] = clearance(navmesh, points) >= radius_m
    stands &= navmesh.island_numbers(points) == island
    return stands
