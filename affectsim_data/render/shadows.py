"""Contact shadows: soft discs on the floor under pelvis and feet, so that nobody floats."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.render.protocol import PosedAvatar
from affectsim_data.scenes import Room, Scene
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["VERTICES_PER_PERSON", "floor_height", "shadow_discs"]

VERTICES_PER_PERSON = 18
"""Three discs of two triangles."""

PELVIS_RADIUS_M = 0.42
FOOT_LENGTH_M, FOOT_WIDTH_M = 0.24, 0.13
ANKLE_HEIGHT_M = 0.10
"""Of a standing person; a foot's shadow fades as its ankle rises above it."""
PELVIS_STRENGTH, FOOT_STRENGTH = 0.34, 0.46
FADE_M = 0.15
_CORNERS = np.array([(-1, -1), (1, -1), (1, 1), (-1, -1), (1, 1), (-1, 1)], np.float64)


def floor_height(scene: Scene, x: float, z: float) -> float:
    """Floor of the room at a place; where rooms are stacked or there is none, the lowest."""
    inside = [room.floor_y for room in scene.rooms if _contains(room, x, z)]
    return min(inside or [room.floor_y for room in scene.rooms])


def _contains(room: Room, x: float, z: float) -> bool:
    """Even-odd rule on the room's polygon."""
    inside = False
    corners = room.polygon
    for (xa, za), (xb, zb) in zip(corners, (*corners[1:], corners[0]), strict=True):
        if (za > z) != (zb > z) and x < xa + (z - za) * (xb - xa) / (zb - za):
            inside = not inside
    return inside


def shadow_discs(scene: Scene, person: PosedAvatar) -> NDArray[np.float32]:
    """Discs of one person, `(num_frames, 18, 6)`: position, place in the unit disc, strength."""
    joints = _joint_positions(person)
    pelvis = joints[:, JOINT_NAMES.index("pelvis")]
    floor = np.array([floor_height(scene, float(p[0]), float(p[2])) for p in pelvis])
    unit = np.array([0.0, 1.0])
    forward = np.broadcast_to(unit, (len(pelvis), 2))
    body = _disc(pelvis, floor, forward, (PELVIS_RADIUS_M, PELVIS_RADIUS_M), PELVIS_STRENGTH)
    discs = [body]
    for side in ("left", "right"):
        ankle = joints[:, JOINT_NAMES.index(f"{side}_ankle")]
        toe = joints[:, JOINT_NAMES.index(f"{side}_foot")]
        along = (toe - ankle)[:, [0, 2]]
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = np.where(length > 1e-3, along / np.maximum(length, 1e-3), unit)
        lift = np.maximum(ankle[:, 1] - floor - ANKLE_HEIGHT_M, 0.0)
        strength = FOOT_STRENGTH * np.exp(-lift / FADE_M)
        middle = (ankle + toe) / 2.0
        discs.append(_disc(middle, floor, along, (FOOT_WIDTH_M, FOOT_LENGTH_M), strength))
    return np.concatenate(discs, axis=1).astype(np.float32)


def _joint_positions(person: PosedAvatar) -> FloatArray:
    rest = person.avatar.skeleton.rest_positions
    matrices = person.joint_matrices
    positions: FloatArray = np.einsum("fjab,jb->fja", matrices[..., :3, :3], rest)
    return positions + matrices[..., :3, 3]


def _disc(
    centre: FloatArray,
    floor: FloatArray,
    forward: FloatArray,
    radii: tuple[float, float],
    strength: FloatArray | float,
) -> FloatArray:
    """One ellipse per frame: half axes across and along `forward`, the latter `(num_frames, 2)`."""
    across = np.stack([forward[:, 1], -forward[:, 0]], axis=1)
    offset = (
        _CORNERS[None, :, :1] * radii[0] * across[:, None]
        + _CORNERS[None, :, 1:] * radii[1] * forward[:, None]
    )
    disc = np.empty((len(centre), len(_CORNERS), 6))
    disc[:, :, 0] = centre[:, None, 0] + offset[..., 0]
    disc[:, :, 1] = floor[:, None]
    disc[:, :, 2] = centre[:, None, 2] + offset[..., 1]
    disc[:, :, 3:5] = _CORNERS
    disc[:, :, 5] = np.broadcast_to(strength, len(centre))[:, None]
    return disc
