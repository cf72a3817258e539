"""The command that describes releases: `info`."""

from __future__ import annotations

import sys
from json import dumps
from pathlib import Path

import tyro

__all__ = ["info"]


def info(
    release: tyro.conf.Positional[str] = "mini",
    *,
    split: str | None = None,
    where: tuple[str, ...] = (),
    motions: bool = False,
    scenes: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Counts per split, family, challenge, action, emotion and scene; distances; sizes.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split.
        where: Only episodes of which all this holds: emotion=sad,angry visible_share_init<0.3
        motions: Describe the motions instead: how they move, by emotion.
        scenes: Describe the scenes instead: their rooms, and where a robot can go.
        out: A folder; with --motions for a plot and a sheet of pictures per emotion and action,
            with --scenes for a plan (PNG) and a recording (Rerun) of each.
        json: Print JSON.
    """
    if motions or scenes:
        option = "--motions" if motions else "--scenes"
        if motions and scenes:
            raise ValueError("--motions and --scenes describe different things; give one of them")
        if split is not None or where:
            raise ValueError(f"{option} describes all of them; leave out --split and --where")
        describe = _describe_motions if motions else _describe_scenes
        return describe(release, out=out, json=json)
    if out is not None:
        raise ValueError("--out is where pictures go; add --motions or --scenes")
    from affectsim_data.inspection.summary import release_summary, summary_lines
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where

    filter = parse_where(where) if where else None
    summary = release_summary(open_release(release), split=split, filter=filter)
    print(dumps(summary, indent=2) if json else "\n".join(summary_lines(summary)))
    return 0


def _describe_motions(release: str, *, out: Path | None, json: bool) -> int:
    from affectsim_data.inspection.motion_summary import (
        motion_descriptors,
        motion_summary,
        motion_summary_lines,
    )
    from affectsim_data.releases import open_release

    opened = open_release(release)
    table = motion_descriptors(opened)
    summary = motion_summary(table)
    print(dumps(summary, indent=2) if json else "\n".join(motion_summary_lines(summary)))
    if out is not None:
        from affectsim_data.inspection.emotion_sheets import emotion_sheets
        from affectsim_data.inspection.motion_plots import motion_plot

        out.mkdir(parents=True, exist_ok=True)
        motion_plot(table, out / "motions.png")
        sheets = emotion_sheets(opened, out / "sheets")
        print(f"{out}: motions.png and {len(sheets)} sheets", file=sys.stderr)
    return 0


def _describe_scenes(release: str, *, out: Path | None, json: bool) -> int:
    from affectsim_data.inspection.scene_summary import draw_scenes, scene_lines, scene_summary
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    opened = open_release(release)
    rows = scene_summary(opened)
    print(dumps(rows, indent=2) if json else "\n".join(scene_lines(rows)))
    if out is not None:
        written = draw_scenes(opened, open_renderer(), out)
        print(f"{out}: {len(written)} files", file=sys.stderr)
    return 0
