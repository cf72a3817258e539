"""A page about one run: the map, what the robot saw on its way, and how much of the target."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.episodes import World
from affectsim_data.inspection.trajectory_frames import condition_frame, frames_at
from affectsim_data.inspection.trajectory_maps import (
    CLIPPED_COLOR,
    MAP_KEY,
    PHASE_COLORS,
    draw_run_map,
)
from affectsim_data.inspection.trajectory_moments import Moment, chosen_moments, key_moments
from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.inspection.trajectory_sights import SEEN_SHARE, Sights, run_sights
from affectsim_data.navmesh import NavMesh
from affectsim_data.render import Renderer

__all__ = ["draw_key", "run_caption", "run_picture"]

_WIDTH, _MAP, _FRAME, _GAP = 1600, 830, 248, 6
_LINE, _CAPTION, _STRIP, _KEY = 20, 20, 126, 24
_COLUMNS, _ROWS = 3, 3
_MOMENTS = 6
_INK, _PAPER, _QUIET, _GRID = (30, 30, 34), (250, 250, 248), (96, 96, 104), (215, 215, 212)


def run_picture(
    run: RecordedRun,
    world: World,
    renderer: Renderer,
    *,
    navmesh: NavMesh | None = None,
    steps: Sequence[int] | None = None,
) -> Image.Image:
    """The page, 1600 pixels wide.

    Beside the map stand six states, numbered as on it, each with the share of the target's body in
    view; below them p_init, the clip that was
    collected and p_ref at one and the same instant of the motion. The strip at the foot is the
    share of the target's body that is in view, over time.

    Args:
        run: What the robot did.
        world: Where.
        renderer: Draws the frames.
        navmesh: Outlined on the map if given.
        steps: The states to show instead, six at most: how many actions were done before each.

    Raises:
        ValueError: No such step, or too many.
    """
    if steps is not None and len(set(steps)) > _MOMENTS:
        raise ValueError(f"a page has room for {_MOMENTS} steps, got {len(set(steps))}")
    sights = run_sights(run, world)
    moments = (
        key_moments(run, sights, count=_MOMENTS) if steps is None else chosen_moments(run, steps)
    )
    lines = textwrap.wrap(run_caption(run, sights), 200)
    top = 34 + _LINE * len(lines)
    page = Image.new("RGB", (_WIDTH, top + _MAP + _STRIP + _KEY + 3 * _GAP), _PAPER)
    draw = ImageDraw.Draw(page)
    _draw_title(draw, run, lines)
    map_ = draw_run_map(run, world, navmesh=navmesh, moments=moments, width=_MAP, height=_MAP)
    page.paste(map_, (0, top))
    _paste_frames(page, run, world, renderer, sights, moments, top)
    _draw_strip(draw, run, sights, moments, top + _MAP + _GAP)
    draw_key(draw, _GAP, page.height - _KEY, width=_WIDTH)
    return page


def run_caption(run: RecordedRun, sights: Sights) -> str:
    """How the run ended, what it cost, and what its clip shows.

    Args:
        run: Which one.
        sights: Of states that include those of the clip.
    """
    before = run.num_actions if run.handoff is None else run.handoff
    way, tries = run.lengths_m.sum(), run.actions.count("move_forward")
    words = [
        run.end.replace("_", " "),
        f"{way:.1f} m ({run.lengths_m[:before].sum():.1f} m before the handoff)"
        if run.handoff is not None
        else f"{way:.1f} m",
        f"{_counted(run.num_actions, 'step')} ({run.times_s[-1]:.1f} s)",
        _counted(int(run.planner_calls[-1]), "planner call"),
        f"{int(run.clipped.sum())} of {tries} moves cut short",
    ]
    inside = np.isin(sights.states, run.clip_states)
    if inside.any():
        azimuth = np.degrees(np.abs(sights.azimuth[inside]).mean())
        words.append(
            f"the clip shows {sights.visible[inside].mean():.0%} of the body from "
            f"{sights.distance_m[inside].mean():.1f} m, {azimuth:.0f}\N{DEGREE SIGN} off its front"
        )
    return "   \N{MIDDLE DOT}   ".join(words)


def _counted(count: int, thing: str) -> str:
    return f"{count} {thing}{'s' * (count != 1)}"


def _draw_title(draw: ImageDraw.ImageDraw, run: RecordedRun, lines: Sequence[str]) -> None:
    one = run.episode
    title = "   ".join(
        (
            one.episode_id,
            (one.challenge or one.family).replace("_", " "),
            one.emotion,
            one.action.replace("_", " "),
            one.scene_id,
            f"policy {run.policy}",
        )
    )
    draw.text((_GAP + 2, 6), title, fill=_INK, font=ImageFont.load_default(size=19))
    for number, line in enumerate(lines):
        font = ImageFont.load_default(size=15)
        draw.text((_GAP + 2, 32 + number * _LINE), line, fill=_QUIET, font=font)


def _paste_frames(
    page: Image.Image,
    run: RecordedRun,
    world: World,
    renderer: Renderer,
    sights: Sights,
    moments: Sequence[Moment],
    top: int,
) -> None:
    pictures = frames_at(run, world, renderer, [one.state for one in moments], size=_FRAME)
    for place, (moment, picture) in enumerate(zip(moments, pictures, strict=True)):
        title = f"{moment.number}   {run.times_s[moment.state]:.2f} s   {moment.title}"
        note = f"{sights.visible[moment.state]:.0%}"
        color = PHASE_COLORS[run.phases[max(moment.state - 1, 0)]]
        _paste(page, picture, place, (title, note), color, top)
    for place, (title, picture) in enumerate(_compared(run, world, renderer)):
        _paste(page, picture, 6 + place, (title, ""), _QUIET, top)


def _compared(
    run: RecordedRun, world: World, renderer: Renderer
) -> list[tuple[str, NDArray[np.uint8]]]:
    """P-Init, the collected clip and P-Ref at the middle of the clip, with their titles."""
    clip = run.clip_states
    whole = run.end == "collected" and len(clip) > 0
    state = int(clip[len(clip) // 2]) if whole else run.num_actions
    initial, reference = (
        condition_frame(run, world, renderer, name, state, size=_FRAME)
        for name in ("p_init", "p_ref")
    )
    own = frames_at(run, world, renderer, [state], size=_FRAME)[0]
    title = "a_obs: middle of the clip" if whole else "last look; a_obs is p_init"
    return [("p_init", initial), (title, own), ("p_ref, at the same instant", reference)]


def _paste(
    page: Image.Image,
    picture: NDArray[np.uint8],
    place: int,
    texts: tuple[str, str],
    color: tuple[int, int, int],
    top: int,
) -> None:
    row, column = divmod(place, _COLUMNS)
    height = _CAPTION + _FRAME + _GAP
    spare = _MAP - _ROWS * height
    x = _MAP + _GAP + column * (_FRAME + _GAP)
    y = top + row * (height + spare // (_ROWS - 1))
    page.paste(Image.fromarray(picture), (x, y + _CAPTION))
    draw, font = ImageDraw.Draw(page), ImageFont.load_default(size=13)
    draw.rectangle([x, y + _CAPTION - 3, x + _FRAME - 1, y + _CAPTION - 1], fill=color)
    draw.text((x, y), texts[0], fill=_INK, font=font)
    draw.text((x + _FRAME, y), texts[1], fill=_QUIET, font=font, anchor="ra")


def _draw_strip(
    draw: ImageDraw.ImageDraw,
    run: RecordedRun,
    sights: Sights,
    moments: Sequence[Moment],
    top: int,
) -> None:
    """The share of the body in view over time; the ground says the phase."""
    font = ImageFont.load_default(size=12)
    left, right, low, high = 150, _WIDTH - 16, top + _STRIP - 36, top + 18
    draw.text((_GAP + 2, (low + high) // 2), "body in view", fill=_QUIET, font=font, anchor="lm")
    across = (right - left) / max(float(run.times_s[-1]), 1e-9)

    def at(time_s: float, share: float) -> tuple[float, float]:
        return left + across * time_s, low - share * (low - high)

    for action, phase in enumerate(run.phases):
        box = (*at(run.times_s[action], 1.0), *at(run.times_s[action + 1], 0.0))
        color = np.array(PHASE_COLORS[phase]) // 5 + np.array(_PAPER) * 4 // 5
        draw.rectangle(box, fill=tuple(color.tolist()))
    for share, text in ((0.0, "0"), (SEEN_SHARE, f"{SEEN_SHARE:.0%}"), (1.0, "100%")):
        draw.line([at(0.0, share), at(run.times_s[-1], share)], fill=_GRID)
        draw.text((left - 6, at(0.0, share)[1]), text, fill=_QUIET, font=font, anchor="rm")
    for state in np.flatnonzero(run.clipped) + 1:
        x, y = at(run.times_s[state], 0.0)
        draw.line([(x, y - 6), (x, y)], fill=CLIPPED_COLOR, width=2)
    points = [at(t, share) for t, share in zip(run.times_s, sights.visible, strict=True)]
    draw.line(points, fill=_INK, width=2)
    if run.clip_s is not None:
        ends = [at(time_s, 1.0) for time_s in run.clip_s]
        draw.line([(x, high - 4) for x, _ in ends], fill=_INK, width=4)
        draw.text((ends[0][0], high - 7), "clip", fill=_INK, font=font, anchor="lb")
    for moment in moments:
        x, y = at(run.times_s[moment.state], 0.0)
        draw.text((x, y + 4), str(moment.number), fill=_INK, font=font, anchor="mt")
    _draw_seconds(draw, float(run.times_s[-1]), left, across, low)


def _draw_seconds(
    draw: ImageDraw.ImageDraw, duration_s: float, left: float, across: float, low: int
) -> None:
    """A scale below the strip and the numbers of the moments."""
    font = ImageFont.load_default(size=11)
    step = next((one for one in (1, 2, 5, 10, 20) if duration_s / one <= 14), 30)
    for second in range(0, math.floor(duration_s) + 1, step):
        x = left + across * second
        draw.line([(x, low), (x, low + 3)], fill=_QUIET)
        draw.text((x, low + 19), f"{second} s", fill=_QUIET, font=font, anchor="mt")


def draw_key(draw: ImageDraw.ImageDraw, x: float, y: float, *, width: int) -> None:
    """What the colours of maps stand for, in one line from `(x, y)`; what runs over is left out."""
    font = ImageFont.load_default(size=13)
    for color, text in MAP_KEY:
        length = draw.textlength(text, font=font) + 36
        if x + length > width:
            return
        draw.rectangle([x, y + 4, x + 11, y + 15], fill=color)
        draw.text((x + 16, y + 2), text, fill=_INK, font=font)
        x += length
