"""Pictures of motions alone: strips of instants on an empty floor, one motion a row."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person
from affectsim_data.inspection.framing import View, needed_aspect, sheet_camera
from affectsim_data.render import ClipSpec, PosedAvatar, Renderer
from affectsim_data.scenes import Room, Scene, Surface

__all__ = ["MotionRow", "empty_stage", "motion_sheet"]

_SIZE, _CAPTION, _GAP = 200, 22, 3
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


def empty_stage(half_m: float = _HALF_M) -> Scene:
    """A chequered floor, tiles of half a metre, and nothing else: slides and gaps can be seen.

    Args:
        half_m: Half its side; a multiple of half a metre.
    """
    count = round(2.0 * half_m / _TILE_M)
    corners = np.arange(count) * _TILE_M - half_m
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
        ((-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m)),
    )
    return Scene("stage", (floor,), (room,))


def motion_sheet(
    rows: Sequence[MotionRow],
    renderer: Renderer,
    *,
    num_frames: int = 12,
    size: int = _SIZE,
    azimuth_deg: float = 35.0,
    labels: bool = True,
) -> Image.Image:
    """One motion a row, `num_frames` instants evenly over its cycle, left to right.

    The camera looks from `azimuth_deg` to the left of where the first person looks at the start, as
    near as holds all of the cycle. It stands still, or glides along with people who walk off; the
    tiles of the floor, half a metre, show what slides.

    Args:
        rows: The motions.
        renderer: Draws.
        num_frames: Instants of each motion.
        size: Height of an instant, pixels; its width follows from what the widest row needs.
        azimuth_deg: Side the camera looks from.
        labels: Whether to write the captions; False to judge by eye alone.

    Raises:
        ValueError: There are no rows.
    """
    if not rows:
        raise ValueError("motion_sheet needs at least one row, got none")
    views = [View(row.people, azimuth_deg) for row in rows]
    column = round(size * needed_aspect(views))
    caption = _CAPTION if labels else _GAP
    width = num_frames * (column + _GAP) - _GAP
    sheet = Image.new("RGB", (width, len(rows) * (size + caption)), _PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=15)
    stage = empty_stage(_stage_half_m(views))
    for place, (row, view) in enumerate(zip(rows, views, strict=True)):
        top = place * (size + caption)
        if labels:
            draw.text((3, top + 2), row.caption, fill=_INK, font=font)
        spec = _spec(row, view, stage, num_frames, sheet_camera(column, size))
        for number, frame in enumerate(renderer.render(spec).rgb):
            sheet.paste(Image.fromarray(frame), (number * (column + _GAP), top + caption))
    return sheet


def _spec(row: MotionRow, view: View, stage: Scene, num_frames: int, camera: Camera) -> ClipSpec:
    time_s = np.arange(num_frames) * row.people[0].motion.duration_s / num_frames
    people = tuple(
        PosedAvatar(person.avatar, person.joint_matrices(time_s)) for person in row.people
    )
    return ClipSpec(stage, people, camera, view.trajectory(camera, time_s))


def _stage_half_m(views: Sequence[View]) -> float:
    """Half the side of a floor that goes on behind everybody, whole tiles."""
    reach = max(float(np.abs(view.reach()).max()) for view in views)
    return float(np.ceil(max(_HALF_M, reach + 4.0)))
