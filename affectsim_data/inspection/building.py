"""What a build has to tell: what is missing and why, and pictures of what screening rejected."""

from __future__ import annotations

from pathlib import Path

from affectsim_data.avatars import Avatar
from affectsim_data.builders.building import BuildReport
from affectsim_data.builders.casting import Cast
from affectsim_data.content import content_path

__all__ = ["build_lines", "picture_rejected"]

_BODY = "ben"
"""Whom rejected motions are shown on."""


def build_lines(report: BuildReport) -> list[str]:
    """What is not in the release, indented lines; none if all the recipe asked for is there."""
    lines = [
        f"  not placed: {shortfall.key} ({shortfall.num_episodes} episodes)"
        for shortfall in report.shortfalls
    ]
    cast = report.cast
    if cast.left_out:
        lines.append(f"  {cast.left_out}")
    lines += [f"  not read: {failure.reason}" for failure in cast.failures]
    lines += [
        f"  rejected: {motion.motion_id}: {finding.check}: {finding.reason}"
        for motion in cast.rejected
        for finding in cast.screening.failed(motion.motion_id)
    ]
    return lines


def picture_rejected(cast: Cast, folder: Path) -> list[Path]:
    """A picture per rejected motion in a folder; no folder if there is none."""
    if not cast.rejected:
        return []
    from affectsim_data.inspection.screening_pictures import rejected_pictures
    from affectsim_data.render import open_renderer

    path = content_path("builders", f"avatars/{_BODY}.glb")
    avatar = Avatar.from_glb(path.read_bytes(), name=str(path))
    rejected = [(motion, cast.screening.failed(motion.motion_id)) for motion in cast.rejected]
    return rejected_pictures(rejected, avatar, open_renderer(), folder)
