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
    split_by: str = "group",
    where: tuple[str, ...] = (),
    motions: bool = False,
    scenes: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Counts per split, family, challenge, action, emotion and scene; distances, angles, shares.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split.
        split_by: What no two splits share: group (performers, performances), scene, or both.
        where: Only episodes of which all this holds: emotion=sad,angry visible_share_init<0.3
        motions: Describe the motions instead: how they move, by emotion.
        scenes: Describe the scenes instead: their rooms, and where a robot can go.
        out: A folder for a figure (PNG) and tables (CSV) of these numbers; with --motions for a
            plot and a sheet of pictures per emotion and action, with --scenes for a plan (PNG) and
            a recording (Rerun) of each.
        json: Print JSON.
    """
    if motions or scenes:
        option = "--motions" if motions else "--scenes"
        if motions and scenes:
            raise ValueError("--motions and --scenes describe different things; give one of them")
        if split is not None or where or split_by != "group":
            raise ValueError(
                f"{option} describes all of them; leave out --split, --split-by and --where"
            )
        describe = _describe_motions if motions else _describe_scenes
        return describe(release, out=out, json=json)
    return _describe_episodes(release, split, split_by, where, out=out, json=json)


def _describe_episodes(
    release: str,
    split: str | None,
    split_by: str,
    where: tuple[str, ...],
    *,
    out: Path | None,
    json: bool,
) -> int:
    from affectsim_data.inspection.summary import chosen_rows, release_summary, summary_lines
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where
    from affectsim_data.releases.joined_splits import as_split_by

    opened, by = open_release(release), as_split_by(split_by)
    filter = parse_where(where) if where else None
    summary = release_summary(opened, split=split, split_by=by, filter=filter)
    print(dumps(summary, indent=2) if json else "\n".join(summary_lines(summary)))
    if out is not None:
        from affectsim_data.inspection.statistics import chosen_episodes
        from affectsim_data.inspection.statistics_figure import statistics_figure
        from affectsim_data.inspection.statistics_tables import write_tables

        rows = chosen_rows(opened, split=split, split_by=by, filter=filter)
        if not rows:
            raise ValueError(
                f"{opened.uri}: has no episodes to draw; --scenes describes its scenes"
            )
        out.mkdir(parents=True, exist_ok=True)
        statistics_figure(chosen_episodes(opened, rows, split_by=by), out / "statistics.png")
        tables = write_tables(summary, out)
        print(f"{out}: statistics.png and {len(tables)} tables", file=sys.stderr)
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
