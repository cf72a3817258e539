"""Pictures of a scene without people: from above without its ceiling, and from standing height."""

from __future__ import annotations

import dataclasses

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.render import ClipSpec, Renderer
from affectsim_data.render.framing import FAR_M
from affectsim_data.scenes import Room, Scene

__all__ = ["standing_views", "view_from_above", "without_ceiling"]

_LID_M = 0.25
"""Below the lowest ceiling everything stays."""
_TOP_HFOV, _MAX_ABOVE_M = np.deg2rad(22.0), 0.8 * FAR_M
_TILT = 0.12
"""Camera to the south of the middle, as a share of its height: walls show their faces a little."""
_EYE_M, _LOOK_DOWN = 1.6, 0.12
_STANDING_HFOV = np.deg2rad(75.0)
_PROBE, _FAR_M = (48, 32), 20.0


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
    corners = np.concatenate([np.array(room.polygon) for room in scene.rooms])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, spans = (low + high) / 2.0, high - low + 0.8
    floor = min(room.floor_y for room in scene.rooms)
    top = max(room.ceiling_y for room in scene.rooms)
    # Half the width of what has to be in view, and from how far it is; large places get a wider
    # view, for nothing is drawn beyond the far plane.
    reach = float(max(spans[0], spans[1] * width / height)) / 2.0
    above = min(reach / float(np.tan(_TOP_HFOV / 2.0)), _MAX_ABOVE_M)
    camera = Camera(width, height, hfov=2.0 * float(np.arctan(reach / above)))
    distance = above + top - floor
    target = np.array([middle[0], floor, middle[1]])
    eye = target + np.array([0.0, distance, _TILT * distance])
    trajectory = CameraTrajectory(look_at(eye, target)[None])
    clip = renderer.render(ClipSpec(without_ceiling(scene), (), camera, trajectory))
    image: NDArray[np.uint8] = clip.rgb[0].copy()
    image[~np.isfinite(clip.depth[0])] = 250
    return image


def standing_views(
    scene: Scene, navmesh: NavMesh, renderer: Renderer, *, width: int, height: int
) -> dict[str, NDArray[np.uint8]]:
    """What somebody sees who stands near a corner of each room, by room, `(height, width, 3)`.

    Of the places near the corners the one with the widest view is taken; rooms in which nobody can
    stand are left out.
    """
    views = {}
    for room in scene.rooms:
        poses = _corner_poses(room, navmesh)
        if len(poses):
            small = Camera(_PROBE[0], _PROBE[1], hfov=_STANDING_HFOV)
            depth = renderer.render(ClipSpec(scene, (), small, CameraTrajectory(poses))).depth
            best = int(np.argmax(np.median(np.minimum(depth, _FAR_M), axis=(1, 2))))
            camera = Camera(width, height, hfov=_STANDING_HFOV)
            spec = ClipSpec(scene, (), camera, CameraTrajectory(poses[best : best + 1]))
            views[room.room_id] = renderer.render(spec).rgb[0]
    return views


def _corner_poses(room: Room, navmesh: NavMesh) -> FloatArray:
    """Cameras at places near the corners of a room that look across it, `(n, 4, 4)`."""
    polygon = shapely.Polygon(room.polygon)
    free = shapely.intersection(navmesh.polygons[0], polygon)
    if free.is_empty:
        return np.empty((0, 4, 4))
    middle = np.array(polygon.centroid.coords[0])
    poses = []
    for corner in room.polygon:
        place = shapely.get_coordinates(shapely.shortest_line(free, shapely.Point(corner)))[0]
        across = 2.0 * middle - place
        reach = float(np.linalg.norm(across - place))
        if reach > 0.1:
            eye_y = room.floor_y + _EYE_M
            target = np.array([across[0], eye_y - _LOOK_DOWN * reach - 0.25, across[1]])
            poses.append(look_at(np.array([place[0], eye_y, place[1]]), target))
    return np.array(poses).reshape(-1, 4, 4)
