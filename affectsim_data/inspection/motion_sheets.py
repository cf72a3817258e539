"""Pictures of motions alone: strips of instants on an empty floor, one motion a row."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Person
from affectsim_data.poses import FloatArray, look_at
from affectsim_data.render import ClipSpec, PosedAvatar, Renderer
from affectsim_data.scenes import Room, Scene, Surface

__all__ = ["MotionRow", "empty_stage", "motion_sheet"]

_SIZE, _CAPTION, _GAP = 176, 20, 4
_INK, _PAPER = (60, 60, 66), (250, 250, 248)
_HALF_M, _TILE_M = 6.0, 0.5
_SHADES = ((176, 172, 164), (152, 149, 143))


@dataclasses.dataclass(frozen=True)
class MotionRow:
    """One row of a sheet: people who perform together, under a caption."""

    caption: str
    """Shown as it is."""
    people: tuple[Person, ...]
    """All on one floor; the first one's motion gives the length of the cycle."""


def empty_stage() -> Scene:
    """A chequered floor, tiles of half a metre, and nothing else: slides and gaps can be seen."""
    count = round(2.0 * _HALF_M / _TILE_M)
    corners = np.arange(count) * _TILE_M - _HALF_M
    x, z = (grid.ravel() for grid in np.meshgrid(corners, corners, indexing="ij"))
    shade = (np.arange(count)[:, None] + np.arange(count)).ravel() % 2
    square = np.array([[0, 0], [0, 1], [1, 1], [1, 0]]) * _TILE_M
    positions = np.zeros((len(x), 4, 3), np.float32)
    positions[..., 0] = x[:, None] + square[:, 0]
    positions[..., 2] = z[:, None] + square[:, 1]
    colors = np.full((len(x), 4, 4), 255, np.uint8)
    colors[..., :3] = np.array(_SHADES, np.uint8)[shade][:, None]
    first = 4 * np.arange(len(x), dtype=np.uint32)[:, None, None]
    faces = first + np.array([[0, 1, 2], [0, 2, 3]], np.uint32)
    floor = Surface(
        name="floor",
        positions=positions.reshape(-1, 3),
        normals=np.tile(np.array([0.0, 1.0, 0.0], np.float32), (4 * len(x), 1)),
        colors=colors.reshape(-1, 4),
        faces=faces.reshape(-1, 3),
    )
    room = Room(
        "stage",
        "stage",
        ((-_HALF_M, -_HALF_M), (_HALF_M, -_HALF_M), (_HALF_M, _HALF_M), (-_HALF_M, _HALF_M)),
    )
    return Scene("stage", (floor,), (room,))


def motion_sheet(
    rows: Sequence[MotionRow],
    renderer: Renderer,
    *,
    num_frames: int = 10,
    size: int = _SIZE,
    azimuth_deg: float = 35.0,
) -> Image.Image:
    """One motion a row, `num_frames` instants evenly over its cycle, left to right.

    The camera stands still, far enough to hold all of the cycle, `azimuth_deg` to the left of
    where the first person looks at the start.
    """
    stage = empty_stage()
    width = num_frames * (size + _GAP) - _GAP
    sheet = Image.new("RGB", (width, len(rows) * (size + _CAPTION)), _PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=13)
    for place, row in enumerate(rows):
        top = place * (size + _CAPTION)
        draw.text((2, top + 2), row.caption, fill=_INK, font=font)
        frames = renderer.render(_spec(row, stage, num_frames, size, azimuth_deg)).rgb
        for column, frame in enumerate(frames):
            sheet.paste(Image.fromarray(frame), (column * (size + _GAP), top + _CAPTION))
    return sheet


def _spec(row: MotionRow, stage: Scene, num_frames: int, size: int, azimuth_deg: float) -> ClipSpec:
    motion = row.people[0].motion
    time_s = np.arange(num_frames) * motion.duration_s / num_frames
    camera = Camera(width=size, height=size, hfov=np.deg2rad(40.0))
    pose = _viewpoint(row.people, camera, azimuth_deg)
    trajectory = CameraTrajectory(np.tile(pose, (num_frames, 1, 1)))
    people = tuple(
        PosedAvatar(person.avatar, person.joint_matrices(time_s)) for person in row.people
    )
    return ClipSpec(stage, people, camera, trajectory)


def _viewpoint(people: Sequence[Person], camera: Camera, azimuth_deg: float) -> FloatArray:
    """A still camera that sees every joint at every instant, `(4, 4)`."""
    joints = np.concatenate(
        [
            person.joint_frames(np.arange(person.motion.num_frames) / person.motion.fps)[
                ..., :3, 3
            ].reshape(-1, 3)
            for person in people
        ]
    )
    low, high = joints.min(axis=0), joints.max(axis=0)
    center = 0.5 * (low + high)
    center[1] = 0.5 * max(high[1] + 0.15, 1.7)
    radius = float(np.linalg.norm((joints - center)[:, [0, 2]], axis=1).max()) + 0.25
    reach = max(radius, center[1]) / np.tan(camera.hfov / 2.0) + 0.6 * radius
    facing = people[0].T_world_performance[:3, :3] @ np.array([0.0, 0.0, 1.0])
    azimuth = np.arctan2(facing[0], facing[2]) + np.deg2rad(azimuth_deg)
    way = np.array([np.sin(azimuth), 0.22, np.cos(azimuth)])
    return look_at(center + reach * way, center)
