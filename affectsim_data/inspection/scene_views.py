"""Pictures of a scene without people: from above without its ceiling, and from standing height."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.render import ClipSpec, Renderer
from affectsim_data.scenes import Scene

__all__ = ["standing_views", "view_from_above", "without_ceiling"]

_LID_M = 0.25
"""Below the lowest ceiling everything stays."""
_TOP_HFOV = np.deg2rad(22.0)
_TILT = 0.12
"""Camera to the south of the middle, as a share of its height: walls show their faces a little."""
_EYE_M, _LOOK_DOWN = 1.6, 0.12
_STANDING_HFOV = np.deg2rad(75.0)


def without_ceiling(scene: Scene) -> Scene:
    """The scene without triangles that lie near its ceiling or above: one can look in."""
    lid = min(room.ceiling_y for room in scene.rooms) - _LID_M
    surfaces = []
    for surface in scene.surfaces:
        low = (surface.positions[surface.faces, 1] < lid).any(axis=1)
        if low.any():
            surfaces.append(dataclasses.replace(surface, faces=surface.faces[low]))
    return dataclasses.replace(scene, surfaces=tuple(surfaces), chunks=None, doorways=())


def view_from_above(
    scene: Scene, renderer: Renderer, *, width: int, height: int
) -> NDArray[np.uint8]:
    """The scene without its ceiling from high above, sRGB, `(height, width, 3)`."""
    camera = Camera(width, height, hfov=_TOP_HFOV)
    corners = np.concatenate([np.array(room.polygon) for room in scene.rooms])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, spans = (low + high) / 2.0, high - low + 0.8
    half = np.tan([camera.hfov / 2.0, camera.vfov / 2.0])
    floor = min(room.floor_y for room in scene.rooms)
    top = max(room.ceiling_y for room in scene.rooms)
    distance = float(np.max(spans / 2.0 / half)) + top - floor
    target = np.array([middle[0], floor, middle[1]])
    eye = target + np.array([0.0, distance, _TILT * distance])
    trajectory = CameraTrajectory(look_at(eye, target)[None])
    clip = renderer.render(ClipSpec(without_ceiling(scene), (), camera, trajectory))
    image: NDArray[np.uint8] = clip.rgb[0].copy()
    image[~np.isfinite(clip.depth[0])] = 250
    return image


def standing_views(
    scene: Scene, renderer: Renderer, *, width: int, height: int
) -> dict[str, NDArray[np.uint8]]:
    """What somebody sees who stands in a corner of each room, by room, `(height, width, 3)`."""
    camera = Camera(width, height, hfov=_STANDING_HFOV)
    views = {}
    for room in scene.rooms:
        eye, target = _corner_view(np.array(room.polygon), room.floor_y)
        trajectory = CameraTrajectory(look_at(eye, target)[None])
        views[room.room_id] = renderer.render(ClipSpec(scene, (), camera, trajectory)).rgb[0]
    return views


def _corner_view(polygon: FloatArray, floor_y: float) -> tuple[FloatArray, FloatArray]:
    """Eye near one corner of a room, and what it looks at near the opposite one."""
    low, high = polygon.min(axis=0), polygon.max(axis=0)
    inset = np.minimum(0.45, 0.2 * (high - low))
    near, far = low + inset, high - inset
    eye = np.array([near[0], floor_y + _EYE_M, near[1]])
    reach = float(np.linalg.norm(far - near))
    return eye, np.array([far[0], floor_y + _EYE_M - _LOOK_DOWN * reach - 0.25, far[1]])
