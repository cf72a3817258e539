"""A picture of every failed episode: where everybody is, what the cameras see, what is wrong."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Iterable, Sequence
from pathlib import Path

from PIL import Image, ImageDraw, ImageFont

from affectsim_data.builders.validation import Failure
from affectsim_data.episodes import Episode, World
from affectsim_data.inspection.episode_plans import PLAN_KEY, draw_episode_plan
from affectsim_data.inspection.views import condition_title, draw_views
from affectsim_data.loaders import Clip, resolve_condition
from affectsim_data.releases import Release
from affectsim_data.render import Renderer

__all__ = ["failure_picture", "failure_pictures"]

MOST = 50
_PLAN, _VIEW, _GAP, _LINE = 620, 200, 6, 17
_FRAMES, _VIEWS = 3, ("p_init", "p_ref", "p_mon")
_INK, _PAPER, _MARK = (30, 30, 34), (250, 250, 248), (214, 40, 40)
_MOST_MESSAGES = 5


def failure_pictures(
    release: Release,
    failures: Iterable[Failure],
    renderer: Renderer,
    folder: Path,
    *,
    most: int = MOST,
) -> list[Path]:
    """One PNG per failed episode, `CHECK__EPISODE.png`, named by the first check that fails.

    Episodes that cannot be drawn, because what they name cannot be read, are left out.

    Args:
        release: What was validated.
        failures: Of any level; only episodes are drawn.
        renderer: Draws the views.
        folder: Where the pictures go; made if need be.
        most: Pictures at most; checks take turns, so that each shows some of its failures.
    """
    by_episode: dict[str, list[Failure]] = {}
    for failure in failures:
        if failure.level == "episode":
            by_episode.setdefault(failure.item, []).append(failure)
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for episode_id in itertools.islice(_in_turn(by_episode), most):
        found = by_episode[episode_id]
        try:
            episode = release.find_episode(episode_id)
            picture = failure_picture(episode, release.world(episode), found, renderer)
        except (KeyError, ValueError, OSError):
            continue
        path = folder / f"{found[0].check}__{episode_id.replace('/', '__')}.png"
        picture.save(path)
        paths.append(path)
    return paths


def _in_turn(by_episode: dict[str, list[Failure]]) -> Iterable[str]:
    """Episodes by their first check, one of each in turn."""
    groups: dict[str, list[str]] = {}
    for episode_id, found in by_episode.items():
        groups.setdefault(found[0].check, []).append(episode_id)
    rounds = itertools.zip_longest(*groups.values())
    return (one for turn in rounds for one in turn if one is not None)


def failure_picture(
    episode: Episode, world: World, failures: Sequence[Failure], renderer: Renderer
) -> Image.Image:
    """The plan with robot, people, ways and cameras, beside it what the cameras see."""
    plan = draw_episode_plan(episode, world, size=_PLAN)
    conditions = [resolve_condition(name) for name in _VIEWS]
    clip = Clip(num_frames=2 * _FRAMES, width=_VIEW, height=_VIEW)
    views = draw_views(episode, world, renderer, conditions=conditions, clip=clip)
    width = _PLAN + _FRAMES * (_VIEW + _GAP) + 2 * _GAP
    messages = [f"{one.check}: {one.message}" for one in failures[:_MOST_MESSAGES]]
    lines = [
        _title(episode),
        *(line for one in messages for line in textwrap.wrap(one, width // 7)),
    ]
    top = _LINE * len(lines) + 2 * _GAP
    sheet = Image.new("RGB", (width, top + _PLAN + 2 * _GAP + _LINE), _PAPER)
    draw, font = ImageDraw.Draw(sheet), ImageFont.load_default(size=13)
    for number, line in enumerate(lines):
        fill = _MARK if number else _INK
        draw.text((_GAP, _GAP + number * _LINE), line, fill=fill, font=font)
    sheet.paste(plan, (0, top))
    for row, condition in enumerate(conditions):
        y = top + row * (_VIEW + _GAP)
        for column in range(_FRAMES):
            frame = Image.fromarray(views[condition.name][column])
            sheet.paste(frame, (_PLAN + _GAP + column * (_VIEW + _GAP), y))
        draw.text((_PLAN + 2 * _GAP, y + 3), condition_title(condition), fill=_MARK, font=font)
    _legend(draw, top + _PLAN + _GAP)
    return sheet


def _title(episode: Episode) -> str:
    kind = episode.challenge or episode.family
    support = f"   at {episode.support}" if episode.support else ""
    return (
        f"{episode.episode_id}   {episode.emotion}   {episode.action}   {kind}   "
        f"{episode.scene_id}{support}   start {episode.initial_distance_m:.2f} m away"
    )


def _legend(draw: ImageDraw.ImageDraw, y: int) -> None:
    font, x = ImageFont.load_default(size=12), float(_GAP)
    for color, text in PLAN_KEY:
        draw.rectangle([x, y + 2, x + 10, y + 12], fill=color)
        draw.text((x + 15, y), text, fill=_INK, font=font)
        x += draw.textlength(text, font=font) + 34
