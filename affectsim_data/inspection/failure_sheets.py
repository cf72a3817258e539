"""The worst runs of every cause on a page, and all runs with their causes as a table."""

from __future__ import annotations

import csv
import dataclasses
import textwrap
from collections.abc import Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont
from tqdm import tqdm

from affectsim_data.inspection.trajectory_failures import (
    CAUSE_MEANINGS,
    CAUSES,
    Cause,
    Verdict,
)
from affectsim_data.inspection.trajectory_frames import condition_frame, frames_at
from affectsim_data.inspection.trajectory_maps import draw_run_map
from affectsim_data.inspection.trajectory_moments import key_moments
from affectsim_data.inspection.trajectory_pictures import draw_key, run_caption
from affectsim_data.inspection.trajectory_runs import RecordedRun, RunTable
from affectsim_data.inspection.trajectory_sights import run_sights
from affectsim_data.releases import Release
from affectsim_data.render import Renderer

__all__ = ["failure_sheet", "write_failures"]

_MAP, _FRAME, _GAP, _TITLE, _LINE = 394, 193, 6, 40, 17
_CELL_WIDTH = _MAP + 2 * (_FRAME + _GAP) + _GAP
_CELL_HEIGHT = 3 * _LINE + _MAP + _GAP
_COLUMNS = 2
_INK, _PAPER, _QUIET = (30, 30, 34), (250, 250, 248), (96, 96, 104)
MOST = 6


def write_failures(
    release: Release,
    runs: RunTable,
    verdicts: Sequence[Verdict],
    renderer: Renderer,
    folder: Path,
    *,
    most: int = MOST,
) -> list[Path]:
    """Writes `runs.csv`, a row per run, and `CAUSE.png` with the worst runs of each cause.

    Args:
        release: Where the episodes are.
        runs: What was judged.
        verdicts: On them.
        renderer: Draws what the robots saw.
        folder: Where to write; made if need be.
        most: Runs on a page at most.

    Raises:
        ValueError: No room for a single run.
    """
    if most < 1:
        raise ValueError(f"a sheet needs at least one run, got most={most}")
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / "runs.csv"]
    with paths[0].open("w", newline="", encoding="utf-8") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(field.name for field in dataclasses.fields(Verdict))
        table.writerows(map(_row, verdicts))
    causes = [cause for cause in CAUSES if any(one.cause == cause for one in verdicts)]
    for cause in tqdm(causes, desc="sheets", unit="sheet", leave=False):
        members = [one for one in verdicts if one.cause == cause]
        worst = sorted(members, key=lambda one: (-one.badness, one.episode_id))[:most]
        path = folder / f"{cause}.png"
        failure_sheet(release, runs, cause, worst, renderer, count=len(members)).save(path)
        paths.append(path)
    return paths


def _row(verdict: Verdict) -> list[str]:
    """Numbers to three places; nothing where there is no cause or no number."""
    values = dataclasses.astuple(verdict)
    return [
        ""
        if value is None or value != value
        else f"{value:.3f}".rstrip("0").rstrip(".")
        if isinstance(value, float)
        else str(value)
        for value in values
    ]


def failure_sheet(
    release: Release,
    runs: RunTable,
    cause: Cause,
    verdicts: Sequence[Verdict],
    renderer: Renderer,
    *,
    count: int,
) -> Image.Image:
    """A page of runs of one cause: a map each, three looks on the way, and p_ref.

    Args:
        release: Where the episodes are.
        runs: All of them.
        cause: What the page is about.
        verdicts: On the runs to draw.
        renderer: Draws what the robots saw.
        count: How many runs there are of the cause.
    """
    rows = -(-len(verdicts) // _COLUMNS)
    height = _TITLE + rows * (_CELL_HEIGHT + _GAP) + _TITLE // 2 + _GAP
    page = Image.new("RGB", (_COLUMNS * (_CELL_WIDTH + _GAP) + _GAP, height), _PAPER)
    draw = ImageDraw.Draw(page)
    title = f"{cause.replace('_', ' ')}: {CAUSE_MEANINGS[cause]}   {len(verdicts)} of {count}"
    draw.text((_GAP, 8), title, fill=_INK, font=ImageFont.load_default(size=19))
    for place, verdict in enumerate(verdicts):
        row, column = divmod(place, _COLUMNS)
        x, y = _GAP + column * (_CELL_WIDTH + _GAP), _TITLE + row * (_CELL_HEIGHT + _GAP)
        episode = release.find_episode(verdict.episode_id)
        page.paste(_cell(release, runs.run(episode), renderer), (x, y))
    draw_key(draw, _GAP, height - _TITLE // 2 - 4, width=page.width)
    return page


def _cell(release: Release, run: RecordedRun, renderer: Renderer) -> Image.Image:
    one = run.episode
    world, navmesh = release.world(one), release.navmesh(one.scene_id)
    sights = run_sights(run, world)
    moments = key_moments(run, sights, count=3)
    cell = Image.new("RGB", (_CELL_WIDTH, _CELL_HEIGHT), _PAPER)
    draw, font = ImageDraw.Draw(cell), ImageFont.load_default(size=13)
    kind = (one.challenge or one.family).replace("_", " ")
    lines = [f"{one.episode_id}   {kind}   {one.emotion}   {one.scene_id}"]
    lines += textwrap.wrap(run_caption(run, sights).replace("   ", " "), 124)
    for number, line in enumerate(lines[:3]):
        color = _QUIET if number else _INK
        draw.text((0, number * _LINE), line, fill=color, font=font)
    top = 3 * _LINE
    map_ = draw_run_map(run, world, navmesh=navmesh, moments=moments, width=_MAP, height=_MAP)
    cell.paste(map_, (0, top))
    states = [moment.state for moment in moments]
    frames = frames_at(run, world, renderer, states, size=_FRAME)
    titles = [f"{moment.number} {moment.title}" for moment in moments]
    reference = condition_frame(run, world, renderer, "p_ref", states[-1], size=_FRAME)
    for place, (title, frame) in enumerate(
        zip([*titles, "p_ref"], [*frames, reference], strict=True)
    ):
        row, column = divmod(place, 2)
        x = _MAP + _GAP + column * (_FRAME + _GAP)
        y = top + row * (_FRAME + _GAP)
        cell.paste(Image.fromarray(frame), (x, y))
        draw.text(*((x + 5, y + 3), title, _PAPER, font), stroke_width=2, stroke_fill=_INK)
    return cell
