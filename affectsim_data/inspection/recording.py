"""An episode as a Rerun recording: the scene, the moving body, every camera and what it sees."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.episodes import Episode, World, clip_time_s
from affectsim_data.inspection.scene_recording import log_scene
from affectsim_data.inspection.views import SHOWN_CONDITIONS, condition_title, draw_views
from affectsim_data.loaders import Clip, resolve_condition
from affectsim_data.observations import Condition
from affectsim_data.poses import UP, matrix_quaternion
from affectsim_data.render import Renderer
from affectsim_data.skeletons import JOINT_PARENTS

__all__ = ["record_episode"]

_BODY_FPS, _IMAGE_FPS = 6.0, 3.0
_BODY_BYTES, _MAX_IMAGES = 1_000_000, 24
"""Long clips and second people lower the rates, so that a recording stays below 3 MB."""
_BODY_TRIANGLES = 2_500
_JPEG_QUALITY = 80
_CAMERA_COLORS = ((66, 133, 244), (52, 168, 83), (251, 188, 5), (171, 71, 188), (234, 67, 53))


def record_episode(
    episode: Episode,
    world: World,
    renderer: Renderer,
    path: Path,
    *,
    conditions: Sequence[str | Condition] = SHOWN_CONDITIONS,
) -> None:
    """Writes an `.rrd` that `rerun FILE` opens: all conditions on one timeline, a few megabytes.

    The scene is simplified to about 5 cm and logged once; bodies are logged as moving vertices at a
    modest rate; frames are JPEG.
    """
    import rerun as rr

    resolved = [resolve_condition(condition) for condition in conditions]
    stream = rr.RecordingStream("affectsim", recording_id=episode.episode_id)
    stream.save(path, default_blueprint=_blueprint(episode, resolved))
    stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Y_UP, static=True)
    stream.log("about", rr.TextDocument(_about(episode), media_type="text/markdown"), static=True)
    log_scene(stream, world.scene)
    _log_people(stream, episode, world)
    for condition, color in zip(resolved, _CAMERA_COLORS * 4, strict=False):
        _log_camera(stream, episode, world, renderer, condition, color)
    stream.disconnect()


def _blueprint(episode: Episode, conditions: Sequence[Condition]) -> Any:
    import rerun.blueprint as rrb

    anchor = np.array(episode.target.anchor)
    # From high behind the robot, so that both it and the person are in view.
    away = np.array(episode.start_position) - anchor
    eye = anchor + 5.2 * away / max(float(np.linalg.norm(away)), 1e-6) + 6.5 * UP
    look = rrb.EyeControls3D(position=eye, look_target=anchor + 0.8 * UP, eye_up=UP)

    pictures = [
        rrb.Spatial2DView(origin=f"world/cameras/{one.name}/image", name=condition_title(one))
        for one in conditions
    ]
    return rrb.Blueprint(
        rrb.Horizontal(
            rrb.Vertical(
                rrb.Spatial3DView(origin="world", name="World", eye_controls=look),
                rrb.TextDocumentView(origin="about", name="Episode"),
                row_shares=[4, 1],
            ),
            rrb.Grid(*pictures, grid_columns=2),
            column_shares=[1, 1],
        ),
        collapse_panels=True,
    )


def _about(episode: Episode) -> str:
    rows = {
        "episode": episode.episode_id,
        "emotion": episode.emotion,
        "action": episode.action,
        "family": episode.family,
        "challenge": episode.challenge or "none",
        "scene": episode.scene_id,
        "motion": episode.target.motion_id,
        "initial distance": f"{episode.initial_distance_m:.2f} m",
        "visible share": f"p_init {episode.visible_share_init:.2f}, "
        f"p_ref {episode.visible_share_ref:.2f}, p_mon {episode.visible_share_mon:.2f}",
    }
    return "| | |\n|---|---|\n" + "\n".join(f"| {key} | {rows[key]} |" for key in rows)


def _log_people(stream: Any, episode: Episode, world: World) -> None:
    import rerun as rr

    grid = clip_time_s(episode)
    meshes = [person.avatar.mesh(max_triangles=_BODY_TRIANGLES) for person in world.people]
    bytes_per_frame = sum(mesh.positions.nbytes for mesh in meshes)
    num_frames = min((grid[-1] - grid[0]) * _BODY_FPS, _BODY_BYTES / bytes_per_frame)
    step = max(1, math.ceil(len(grid) / num_frames))
    bones = [(parent, joint) for joint, parent in enumerate(JOINT_PARENTS) if parent >= 0]
    names = ("target", "partner")
    for person, mesh, name in zip(world.people, meshes, names, strict=False):
        vertices = mesh.skin(person.joint_matrices(grid[::step])).astype(np.float32)
        joints = person.joint_frames(grid[::step])[..., :3, 3]
        entity = f"world/people/{name}"
        look = rr.Mesh3D.from_fields(
            vertex_colors=mesh.colors, triangle_indices=mesh.faces, clear_unset=False
        )
        stream.log(f"{entity}/body", look, static=True)
        for time_s, shape, skeleton in zip(grid[::step], vertices, joints, strict=True):
            stream.set_time("clip", duration=float(time_s - episode.phase_s))
            stream.log(f"{entity}/body", rr.Mesh3D.from_fields(vertex_positions=shape))
            lines = rr.LineStrips3D(skeleton[np.array(bones)].astype(np.float32), radii=0.008)
            stream.log(f"{entity}/skeleton", lines)


def _log_camera(
    stream: Any,
    episode: Episode,
    world: World,
    renderer: Renderer,
    condition: Condition,
    color: tuple[int, int, int],
) -> None:
    import rerun as rr

    grid = clip_time_s(episode)
    count = min(_MAX_IMAGES, max(2, round((grid[-1] - grid[0]) * _IMAGE_FPS)))
    clip = Clip(num_frames=count, width=world.camera.width, height=world.camera.height)
    indices = clip.frame_indices(len(grid))
    frames = draw_views(episode, world, renderer, conditions=[condition], clip=clip)
    trajectory = condition.trajectory(episode, world, grid[indices])
    poses = trajectory.T_world_camera
    entity = f"world/cameras/{condition.name}"
    pinhole = rr.Pinhole(
        image_from_camera=world.camera.intrinsics,
        width=world.camera.width,
        height=world.camera.height,
        camera_xyz=rr.ViewCoordinates.RUB,
        image_plane_distance=0.4,
        color=color,
    )
    stream.log(f"{entity}/image", pinhole, static=True)
    if not trajectory.is_still:
        way = rr.LineStrips3D([poses[:, :3, 3].astype(np.float32)], colors=color, radii=0.01)
        stream.log(f"world/ways/{condition.name}", way, static=True)
    for index, pose, image in zip(indices, poses, frames[condition.name], strict=True):
        stream.set_time("clip", duration=float(grid[index] - episode.phase_s))
        w, x, y, z = matrix_quaternion(pose[:3, :3])
        turn = rr.Quaternion(xyzw=[x, y, z, w])
        stream.log(entity, rr.Transform3D(translation=pose[:3, 3], rotation=turn))
        stream.log(f"{entity}/image", rr.Image(image).compress(jpeg_quality=_JPEG_QUALITY))
