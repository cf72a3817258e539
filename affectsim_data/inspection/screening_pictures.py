"""A picture of every rejected motion: what it looks like where it fails, and why it does."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.avatars import Avatar
from affectsim_data.builders.screening import Finding
from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Person
from affectsim_data.inspection.motion_sheets import empty_stage
from affectsim_data.motions import Motion
from affectsim_data.poses import FloatArray, invert_pose, look_at, transform_points
from affectsim_data.render import ClipSpec, PosedAvatar, Renderer
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["rejected_picture", "rejected_pictures"]

_OFFSETS_S = (-0.5, -0.2, -1.0 / 15.0, 0.0, 1.0 / 15.0, 0.2, 0.5)
_SIZE, _GAP, _LINE = 208, 4, 18
_MAX_FINDINGS = 4
_INK, _PAPER, _MARK = (60, 60, 66), (250, 250, 248), (214, 40, 40)
_DISTANCE_M, _RING_PIXELS = 3.6, 13
_AZIMUTH = np.deg2rad(50.0)


def rejected_pictures(
    rejected: Iterable[tuple[Motion, Sequence[Finding]]],
    avatar: Avatar,
    renderer: Renderer,
    folder: Path | str,
) -> list[Path]:
    """One PNG per rejected motion, in a folder that is made if need be.

    Args:
        rejected: Motions with their findings; those that pass are left out.
        avatar: Body to show them on.
        renderer: What draws.
        folder: Where the pictures go, named after the motion ids.

    Returns:
        Paths of the pictures.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for motion, findings in rejected:
        failed = [finding for finding in findings if not finding.passed]
        if not failed:
            continue
        path = folder / f"{motion.motion_id.replace('/', '__')}.png"
        rejected_picture(motion, failed, avatar, renderer).save(path)
        paths.append(path)
    return paths


def rejected_picture(
    motion: Motion, failed: Sequence[Finding], avatar: Avatar, renderer: Renderer
) -> Image.Image:
    """A strip of the moments around each failure, the joint ringed, the reason above it.

    At most four failures are shown; the others are named. The camera follows the pelvis.
    """
    shown, rest = failed[:_MAX_FINDINGS], failed[_MAX_FINDINGS:]
    width = len(_OFFSETS_S) * (_SIZE + _GAP) - _GAP
    font = ImageFont.load_default(size=13)
    strips = [_captioned(motion, finding, avatar, renderer, font, width) for finding in shown]
    head = f"{motion.motion_id}  ({motion.performer_id}, {motion.action}, {motion.emotion})"
    if rest:
        head += f"; also rejected by {', '.join(finding.check for finding in rest)}"
    lines = textwrap.wrap(head, width // 7)
    top = _LINE * len(lines) + _GAP
    picture = Image.new("RGB", (width, top + sum(strip.height for strip in strips)), _PAPER)
    _write(picture, lines, font)
    for strip in strips:
        picture.paste(strip, (0, top))
        top += strip.height
    return picture


def _captioned(
    motion: Motion,
    finding: Finding,
    avatar: Avatar,
    renderer: Renderer,
    font: ImageFont.FreeTypeFont | ImageFont.ImageFont,
    width: int,
) -> Image.Image:
    """One failure: its reason over its strip."""
    lines = textwrap.wrap(f"{finding.check}: {finding.reason}", width // 7)
    strip = _strip(motion, finding, avatar, renderer)
    picture = Image.new("RGB", (width, _LINE * len(lines) + _SIZE + 2 * _GAP), _PAPER)
    _write(picture, lines, font)
    picture.paste(strip, (0, _LINE * len(lines) + _GAP))
    return picture


def _strip(motion: Motion, finding: Finding, avatar: Avatar, renderer: Renderer) -> Image.Image:
    person = Person(motion, avatar, np.eye(4))
    middle = finding.time_s if np.isfinite(finding.time_s) else finding.frame / motion.fps
    # A source may be longer than the cycle that was made of it.
    time_s = np.clip(middle, 0.0, motion.duration_s) + np.array(_OFFSETS_S)
    joints = person.joint_frames(time_s)[..., :3, 3]
    camera = Camera(width=_SIZE, height=_SIZE, hfov=np.deg2rad(36.0))
    views = np.stack([_view(pelvis) for pelvis in joints[:, 0]])
    people = (PosedAvatar(avatar, person.joint_matrices(time_s)),)
    frames = renderer.render(ClipSpec(empty_stage(), people, camera, CameraTrajectory(views))).rgb
    sheet = Image.new("RGB", (len(frames) * (_SIZE + _GAP) - _GAP, _SIZE), _PAPER)
    draw = ImageDraw.Draw(sheet)
    for column, frame in enumerate(frames):
        left = column * (_SIZE + _GAP)
        sheet.paste(Image.fromarray(frame), (left, 0))
        if finding.joint:
            joint = joints[column, [JOINT_NAMES.index(finding.joint)]]
            pixels, _ = camera.project(transform_points(invert_pose(views[column]), joint))
            u, v = pixels[0].tolist()
            _ring(draw, (left + u, v), strong=_OFFSETS_S[column] == 0.0)
    return sheet


def _view(pelvis: FloatArray) -> FloatArray:
    """A camera a few metres away, at the side the performance faces, `(4, 4)`."""
    target = np.array([pelvis[0], 0.9, pelvis[2]])
    away = np.array([np.sin(_AZIMUTH), 0.25, np.cos(_AZIMUTH)])
    return look_at(target + _DISTANCE_M * away, target)


def _ring(draw: ImageDraw.ImageDraw, center: tuple[float, float], *, strong: bool) -> None:
    u, v = center
    box = (u - _RING_PIXELS, v - _RING_PIXELS, u + _RING_PIXELS, v + _RING_PIXELS)
    draw.ellipse(box, outline=_MARK, width=3 if strong else 1)


def _write(
    picture: Image.Image,
    lines: Sequence[str],
    font: ImageFont.FreeTypeFont | ImageFont.ImageFont,
) -> None:
    draw = ImageDraw.Draw(picture)
    for number, line in enumerate(lines):
        draw.text((2, 2 + _LINE * number), line, fill=_INK, font=font)
