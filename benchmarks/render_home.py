"""A furnished home and a camera's way through it, for `benchmarks.render`.

The home is one of the built-in set, baked as builds bake it; the camera goes through all its rooms
along the navmesh, 1.2 m high, and looks ahead.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from affectsim_data.builders.homes import build_home, home_recipes
from affectsim_data.cameras import CameraTrajectory
from affectsim_data.content import content_path
from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray, invert_pose, look_at
from affectsim_data.render import ClipSpec
from affectsim_data.render.framing import FAR_M, NEAR_M, choose_mesh, visible_boxes
from affectsim_data.render.portals import Portals
from affectsim_data.scenes import Room, Scene
from affectsim_data.scenes.baking import bake_scene

__all__ = ["HABITAT_FPS", "beside", "drawn_per_frame", "furnished_home", "home_walk"]

HABITAT_FPS = {"224x224": 108.0, "640x480": 52.0}
"""habitat-sim 0.2.2, RGB and depth without antialiasing, a new pose each frame, 142 k textured
triangles, llvmpipe on two cores of the same kind: measured apart, not in the same run."""

HEIGHT_M, AHEAD_M = 1.2, 0.8
"""Of the camera; how far along its way it looks."""


def furnished_home(place: int) -> Scene:
    """A baked home of `builders/homes-full.toml`, by its place in the file."""
    recipe = home_recipes(content_path("builders", "homes-full.toml"))[place]
    scene = build_home(recipe, rng=np.random.default_rng(recipe.seed))
    return bake_scene(scene)[0]


def home_walk(scene: Scene, *, num_frames: int) -> CameraTrajectory:
    """A round through all rooms, at one speed."""
    navmesh = NavMesh.from_mesh(*scene.mesh())
    stops = [_stop(navmesh, room) for room in scene.rooms]
    legs = [_way(navmesh, a, b) for a, b in zip(stops, [*stops[1:], stops[0]], strict=True)]
    path = np.concatenate(legs)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(path, axis=0), axis=1))])
    along = np.linspace(0.0, length[-1], num_frames, endpoint=False)
    eyes, ahead = (_at(path, length, along + shift) for shift in (0.0, AHEAD_M))
    # Where the way turns back on itself, on in the direction of before.
    ahead += np.where(np.linalg.norm(ahead - eyes, axis=1) < 0.05, 1.0, 0.0)[:, None] * [0.3, 0, 0]
    lift = np.array([0.0, HEIGHT_M, 0.0])
    return CameraTrajectory(look_at(eyes + lift, ahead + lift - [0.0, 0.05, 0.0]))


def beside(scene: Scene, eyes: FloatArray) -> tuple[float, float]:
    """A place `(x, z)` in the first room where a person stands as far from the way as it goes."""
    navmesh = NavMesh.from_mesh(*scene.mesh())
    rng, room = np.random.default_rng(0), scene.rooms[0].polygon
    points = navmesh.random_points(256, rng, island=0, within=room)
    away = np.linalg.norm(points[:, None, [0, 2]] - eyes[None][..., [0, 2]], axis=-1).min(axis=1)
    x, _, z = points[np.argmax(away)]
    return float(x), float(z)


def _stop(navmesh: NavMesh, room: Room) -> FloatArray:
    """The free floor nearest to the middle of a room."""
    corners = np.array(room.polygon)
    low, high = corners.min(axis=0), corners.max(axis=0)
    plan = low + (np.indices((21, 21)).reshape(2, -1).T + 0.5) / 21 * (high - low)
    points = np.insert(plan, 1, room.floor_y, axis=1)
    free = points[navmesh.navigable(points, 0.1) & (navmesh.island_numbers(points) == 0)]
    if not len(free):
        raise ValueError(f"room {room.room_id!r}: a robot finds no place in it")
    away = np.linalg.norm(free[:, [0, 2]] - corners.mean(axis=0), axis=1)
    stop: FloatArray = free[np.argmin(away)]
    return stop


def _way(navmesh: NavMesh, start: FloatArray, end: FloatArray) -> FloatArray:
    way = navmesh.shortest_path(start, end)
    if way is None:
        raise ValueError(f"no way from {start} to {end}: the home is not one island")
    return way


def _at(path: FloatArray, length: FloatArray, along: FloatArray) -> FloatArray:
    places = np.mod(along, length[-1])
    return np.stack([np.interp(places, length, path[:, axis]) for axis in range(3)], axis=1)


def drawn_per_frame(spec: ClipSpec) -> dict[str, Any]:
    """Mean numbers of triangles and draw calls of the scene, and of triangles of the body."""
    chunks, camera = spec.scene.chunks, spec.camera
    assert chunks is not None, "baked scenes have chunks"
    poses = spec.trajectory.T_world_camera
    matrices = camera.projection_matrix(near=NEAR_M, far=FAR_M) @ invert_pose(poses)
    windows = Portals(spec.scene).windows(matrices, poses[:, :3, 3])
    triangles, calls = 0, 0
    for matrix, pose, window in zip(matrices, poses, windows, strict=True):
        boxes = None if window is None else window[chunks.room]
        drawn = visible_boxes(chunks.low, chunks.high, matrix, pose[:3, 3], boxes)
        triangles, calls = triangles + int(chunks.count[drawn].sum()), calls + len(drawn)
    return {
        "triangles": spec.scene.num_triangles,
        "body_triangles": len(choose_mesh(spec.people[0], spec).faces),
        "triangles_drawn": round(triangles / len(poses)),
        "draw_calls": round(calls / len(poses)),
    }
