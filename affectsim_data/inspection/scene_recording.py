"""A scene as a Rerun recording: geometry, rooms, things, seats, doors and the robot's floor."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray
from PIL import Image

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import UP, FloatArray
from affectsim_data.scenes import Scene, Surface

__all__ = ["log_scene", "record_scene"]

_CELL_M = 0.05
_LID_M = 0.1
_ISLAND_LIFT_M = 0.02
_ARROW_M = 0.45
_MAIN, _OTHER = (0, 140, 130, 110), (213, 94, 0, 140)
_SEAT, _DOOR, _THING, _ROOM = (160, 60, 40), (150, 96, 40), (120, 110, 100), (60, 60, 70)


def record_scene(
    scene: Scene, navmesh: NavMesh, path: Path, *, plan: Image.Image | None = None
) -> None:
    """Writes an `.rrd` that `rerun FILE` opens.

    Args:
        scene: Logged without its ceiling, simplified to about 5 cm.
        navmesh: Its islands are logged as faces a little above the floor.
        path: The file; its folder is there.
        plan: A picture to show beside it.
    """
    import rerun as rr

    stream = rr.RecordingStream("affectsim", recording_id=f"scene {scene.scene_id}")
    stream.save(path, default_blueprint=_blueprint(scene, with_plan=plan is not None))
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
    log_scene(stream, scene)
    _log_islands(stream, navmesh)
    _log_rooms(stream, scene)
    _log_things(stream, scene)
    _log_arrows(stream, "seats", [(s.position, s.yaw_deg) for s in scene.seats], _SEAT)
    knocks = [(d.knock_point, d.yaw_deg) for d in scene.doors if d.is_closed]
    _log_arrows(stream, "doors", knocks, _DOOR)
    if plan is not None:
        stream.log("plan", rr.Image(np.asarray(plan)).compress(jpeg_quality=90), static=True)
    stream.disconnect()


def _blueprint(scene: Scene, *, with_plan: bool) -> Any:
    import rerun.blueprint as rrb

    corners = np.concatenate([np.array(room.polygon) for room in scene.rooms])
    middle, reach = corners.mean(axis=0), float(np.ptp(corners, axis=0).max())
    look = np.array([middle[0], scene.rooms[0].floor_y, middle[1]])
    eye = rrb.EyeControls3D(
        position=look + reach * np.array([0.0, 1.2, 0.9]), look_target=look, eye_up=UP
    )
    world = rrb.Spatial3DView(origin="world", name=scene.scene_id, eye_controls=eye)
    if not with_plan:
        return rrb.Blueprint(world, collapse_panels=True)
    plan = rrb.Spatial2DView(origin="plan", name="Plan")
    return rrb.Blueprint(rrb.Horizontal(world, plan), collapse_panels=True)


def _log_islands(stream: Any, navmesh: NavMesh) -> None:
    import rerun as rr

    for number, island in enumerate(navmesh.islands):
        pieces = shapely.get_parts(shapely.constrained_delaunay_triangles(island.polygon))
        plan = np.array([shapely.get_coordinates(piece)[:3] for piece in pieces])
        points = island.on_floor(plan.reshape(-1, 2)) + _ISLAND_LIFT_M * UP
        mesh = rr.Mesh3D(
            vertex_positions=points.astype(np.float32),
            triangle_indices=np.arange(len(points)).reshape(-1, 3),
            albedo_factor=_OTHER if number else _MAIN,
        )
        stream.log(f"world/navmesh/island_{number}", mesh, static=True)


def _log_rooms(stream: Any, scene: Scene) -> None:
    import rerun as rr

    strips = [_outline(room.polygon, room.floor_y + 0.03) for room in scene.rooms]
    labels = [room.purpose or room.room_id for room in scene.rooms]
    lines = rr.LineStrips3D(strips, colors=_ROOM, radii=0.015, labels=labels, show_labels=True)
    stream.log("world/rooms", lines, static=True)


def _outline(polygon: Sequence[tuple[float, float]], y: float) -> NDArray[np.float32]:
    closed = np.array([*polygon, polygon[0]])
    return np.insert(closed, 1, y, axis=1).astype(np.float32)


def _log_things(stream: Any, scene: Scene) -> None:
    import rerun as rr

    if not scene.objects:
        return
    sizes = np.array([thing.size for thing in scene.objects])
    middles = np.array([thing.position for thing in scene.objects]) + 0.5 * sizes * UP
    half_yaw = np.radians([thing.yaw_deg for thing in scene.objects]) / 2.0
    turns = np.zeros((len(sizes), 4))
    turns[:, 1], turns[:, 3] = np.sin(half_yaw), np.cos(half_yaw)
    boxes = rr.Boxes3D(
        sizes=sizes.astype(np.float32),
        centers=middles.astype(np.float32),
        quaternions=turns.astype(np.float32),
        colors=_THING,
        labels=[thing.category for thing in scene.objects],
        show_labels=False,
    )
    stream.log("world/things", boxes, static=True)


def _log_arrows(
    stream: Any,
    name: str,
    places: Sequence[tuple[tuple[float, float, float], float]],
    color: tuple[int, int, int],
) -> None:
    import rerun as rr

    if not places:
        return
    yaw = np.radians([yaw_deg for _, yaw_deg in places])
    ways: FloatArray = np.stack([np.sin(yaw), np.zeros_like(yaw), np.cos(yaw)], axis=1)
    arrows = rr.Arrows3D(
        origins=np.array([point for point, _ in places], np.float32),
        vectors=(_ARROW_M * ways).astype(np.float32),
        colors=color,
    )
    stream.log(f"world/{name}", arrows, static=True)


def log_scene(stream: Any, scene: Scene) -> None:
    """Logs a scene without its ceiling, simplified to about 5 cm, below `world/scene`."""
    import rerun as rr

    lid = min(room.ceiling_y for room in scene.rooms) - _LID_M
    for surface in scene.surfaces:
        positions, colors, faces = _simplified(surface)
        # Without ceilings one can look in from above.
        faces = faces[(positions[faces, 1] < lid).any(axis=1)]
        if len(faces):
            mesh = rr.Mesh3D(
                vertex_positions=positions, vertex_colors=colors, triangle_indices=faces
            )
            stream.log(f"world/scene/{surface.name}", mesh, static=True)


def _simplified(
    surface: Surface,
) -> tuple[NDArray[np.float32], NDArray[np.uint8], NDArray[np.uint32]]:
    """Vertices merged into 5 cm cells; triangles that collapse are dropped."""
    tint = np.ones(3) if surface.texture is None else surface.texture.mean(axis=(0, 1)) / 255.0
    cells = np.floor(surface.positions / _CELL_M).astype(np.int64)
    _, first, inverse = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    inverse = inverse.reshape(-1)
    faces = inverse[surface.faces]
    whole = (
        (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    )
    faces = np.unique(faces[whole], axis=0)
    colors = (surface.colors[first, :3] * tint).astype(np.uint8)
    return surface.positions[first], colors, faces.astype(np.uint32)
