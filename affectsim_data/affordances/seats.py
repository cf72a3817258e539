"""Seats: whether a robot gets near them, and whether a sitter has room on them."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene
from affectsim_data.visibility import RayCaster, scene_caster

__all__ = ["SeatAccess", "reachable_seats"]

# A sitter of middle size: pelvis to knee, half the width, and height above the seat, metres.
THIGH_M, HALF_WIDTH_M, TRUNK_M = 0.45, 0.18, 0.85
# Rays start this far above the cushion and end this far above the floor.
CUSHION_M, FLOOR_GAP_M = 0.1, 0.06
# Of the trunk before and behind the pelvis; the back rest begins behind it.
TRUNK_FRONT_M, TRUNK_BACK_M = 0.12, 0.02
# Heights at which robot and seat must see each other: over tables, not over walls.
EYE_M, OVER_SEAT_M = 1.2, 0.4
UP = np.array([0.0, 1.0, 0.0])


@dataclasses.dataclass(frozen=True, eq=False)
class SeatAccess:
    """What is free around each seat of a scene, arrays over its `n` seats."""

    approach: FloatArray
    """The place on the robot's island nearest to the floor before the sitter's knees, `(n, 3)`."""
    distance_m: FloatArray
    """From there to that floor, on the plan, `(n,)`."""
    is_near: NDArray[np.bool_]
    """Whether that is near enough, and no wall is between the two, `(n,)`."""
    legs_free: NDArray[np.bool_]
    """Whether thighs, knees and shins meet nothing, `(n,)`."""
    body_free: NDArray[np.bool_]
    """Whether trunk and head meet nothing, `(n,)`."""

    @property
    def is_usable(self) -> NDArray[np.bool_]:
        """Whether one can sit there and a robot can come near, `(n,)`."""
        usable: NDArray[np.bool_] = self.is_near & self.legs_free & self.body_free
        return usable


def reachable_seats(
    scene: Scene, navmesh: NavMesh, *, start: ArrayLike | None = None, within_m: float = 1.2
) -> SeatAccess:
    """Which seats a sitter fits on and a robot comes near, by the navmesh and by rays.

    Args:
        scene: With its seats.
        navmesh: Of the scene.
        start: Where the robot is, `(3,)`; anywhere on the largest island if not given.
        within_m: How near the floor before the knees it must come.
    """
    island = navmesh.islands[0 if start is None else navmesh.island(start)]
    position = np.array([seat.position for seat in scene.seats], np.float64).reshape(-1, 3)
    yaw = np.radians([seat.yaw_deg for seat in scene.seats])
    height = np.array([seat.height for seat in scene.seats], np.float64)
    forward = np.stack([np.sin(yaw), 0.0 * yaw, np.cos(yaw)], axis=-1)
    front = position + THIGH_M * forward - height[:, None] * UP
    approach = island.on_floor(island.nearest(front[:, [0, 2]]))
    distance = np.hypot(*(approach - front)[:, [0, 2]].T)
    caster = scene_caster(scene)
    is_near = distance <= within_m
    is_near &= ~caster.hidden(approach + EYE_M * UP, position + OVER_SEAT_M * UP)
    frame = np.stack([np.cross(UP, forward), forward], axis=1)
    return SeatAccess(
        approach=approach,
        distance_m=distance,
        is_near=is_near,
        legs_free=_legs_free(caster, position, frame, height),
        body_free=_body_free(caster, position, frame),
    )


def _placed(position: FloatArray, frame: FloatArray, offsets: ArrayLike) -> FloatArray:
    """Points `(side, up, forward)`, `(k, 3)`, off every seat, `(n, k, 3)`."""
    side, up, ahead = np.moveaxis(np.asarray(offsets, np.float64), -1, 0)
    plan = side[:, None] * frame[:, None, 0] + ahead[:, None] * frame[:, None, 1]
    placed: FloatArray = position[:, None] + plan + up[:, None] * UP
    return placed


def _legs_free(
    caster: RayCaster, position: FloatArray, frame: FloatArray, height: FloatArray
) -> NDArray[np.bool_]:
    sides = (-HALF_WIDTH_M, 0.0, HALF_WIDTH_M)
    hips = _placed(position, frame, [(side, CUSHION_M, 0.0) for side in sides])
    knees = _placed(position, frame, [(side, CUSHION_M, THIGH_M) for side in sides])
    ankles = knees - (height[:, None, None] + CUSHION_M - FLOOR_GAP_M) * UP
    across = caster.hidden(knees[:, 0], knees[:, 2]) | caster.hidden(ankles[:, 0], ankles[:, 2])
    hidden = caster.hidden(hips, knees) | caster.hidden(knees, ankles)
    return np.asarray(~np.any(hidden, axis=1) & ~across)


def _body_free(caster: RayCaster, position: FloatArray, frame: FloatArray) -> NDArray[np.bool_]:
    """Rays up through the trunk, and across it from either side at four heights."""
    corners = [
        (side, ahead)
        for side in (-HALF_WIDTH_M, 0.0, HALF_WIDTH_M)
        for ahead in (-TRUNK_BACK_M, TRUNK_FRONT_M)
    ]
    low = _placed(position, frame, [(side, CUSHION_M, ahead) for side, ahead in corners])
    high = _placed(position, frame, [(side, TRUNK_M, ahead) for side, ahead in corners])
    levels = np.linspace(CUSHION_M, TRUNK_M, 4)
    left = _placed(position, frame, [(-HALF_WIDTH_M, up, 0.0) for up in levels])
    right = _placed(position, frame, [(HALF_WIDTH_M, up, 0.0) for up in levels])
    hidden = np.concatenate([caster.hidden(low, high), caster.hidden(left, right)], axis=1)
    return np.asarray(~np.any(hidden, axis=1))
