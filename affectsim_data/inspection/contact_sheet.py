"""A picture that shows what observation does: one performance per row, one condition per column."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.episodes import Episode
from affectsim_data.inspection.episode_plans import PLAN_KEY, draw_episode_plan
from affectsim_data.inspection.views import SHOWN_CONDITIONS, condition_title, draw_views
from affectsim_data.loaders import Clip, resolve_condition
from affectsim_data.observations import Condition
from affectsim_data.releases import Release
from affectsim_data.render import Renderer
from affectsim_data.schemas import SPLITS, Split

__all__ = ["contact_sheet", "representative_episodes"]

_SIZE, _GAP, _HEADER, _CAPTION = 224, 6, 30, 24
_FRAMES = 2
_BLOCK = _FRAMES * _SIZE + _GAP // 2
_INK, _PAPER, _QUIET = (30, 30, 34), (250, 250, 248), (96, 96, 104)


def representative_episodes(release: Release) -> list[Episode]:
    """One episode of every family, challenge and action; splits and emotions taken in turn."""
    splits = [split for split in SPLITS if release.manifest.num_rows("episodes", split)]
    groups: dict[tuple[str, str], dict[tuple[Split, str], int]] = {}
    for split in splits:
        columns = ["family", "challenge", "action", "emotion"]
        for index, row in enumerate(release.episode_index(split).select(columns).to_pylist()):
            key = (row["family"], row["challenge"] or row["action"])
            groups.setdefault(key, {}).setdefault((split, row["emotion"]), index)
    chosen = []
    for number, key in enumerate(sorted(groups)):
        members = sorted(groups[key])
        # 7 shares no factor with five emotions or three splits, so all come round.
        place = members[7 * number % len(members)]
        chosen.append(release.episode(place[0], groups[key][place]))
    return chosen


def contact_sheet(
    release: Release,
    episodes: Sequence[Episode],
    renderer: Renderer,
    *,
    conditions: Sequence[str | Condition] = SHOWN_CONDITIONS,
    plans: bool = False,
) -> Image.Image:
    """Draws the sheet: a row per episode with its caption, two instants per condition.

    Args:
        release: Where the episodes are.
        episodes: A row each.
        renderer: Draws them.
        conditions: A column each.
        plans: Whether each row ends with the episode seen from above.
    """
    resolved = [resolve_condition(condition) for condition in conditions]
    clip = Clip(num_frames=2 * _FRAMES + 1, width=_SIZE, height=_SIZE)
    width = len(resolved) * (_BLOCK + _GAP) + _GAP + plans * (_SIZE + _GAP)
    row_height = _CAPTION + _SIZE + _GAP
    sheet = Image.new("RGB", (width, _HEADER + len(episodes) * row_height), _PAPER)
    draw = ImageDraw.Draw(sheet)
    small = ImageFont.load_default(size=14)
    for column, condition in enumerate(resolved):
        x = _GAP + column * (_BLOCK + _GAP)
        draw.text((x, 6), condition_title(condition), fill=_INK, font=_heading())
    if plans:
        _draw_key(draw, width - _SIZE - _GAP)
    for row, episode in enumerate(episodes):
        y = _HEADER + row * row_height
        draw.text((_GAP, y + 4), _caption(episode), fill=_QUIET, font=small)
        world = release.world(episode)
        views = draw_views(episode, world, renderer, conditions=resolved, clip=clip)
        for column, condition in enumerate(resolved):
            x = _GAP + column * (_BLOCK + _GAP)
            _paste(sheet, views[condition.name], x, y + _CAPTION)
        if plans:
            plan = draw_episode_plan(episode, world, size=_SIZE)
            sheet.paste(plan, (width - _SIZE - _GAP, y + _CAPTION))
    return sheet


def _heading() -> ImageFont.ImageFont | ImageFont.FreeTypeFont:
    return ImageFont.load_default(size=17)


def _draw_key(draw: ImageDraw.ImageDraw, x: float) -> None:
    """What the colours of plans stand for, in two lines."""
    font, left, line = ImageFont.load_default(size=11), x, 2
    for color, text in PLAN_KEY:
        length = 14 + draw.textlength(text, font=font) + 8
        if left + length > x + _SIZE:
            left, line = x, line + 14
        draw.rectangle([left, line + 3, left + 9, line + 11], fill=color)
        draw.text((left + 13, line), text, fill=_QUIET, font=font)
        left += length


def _paste(sheet: Image.Image, frames: NDArray[np.uint8], x: int, y: int) -> None:
    # Instants 1 and 2 of 5: a quarter and half of the clip; the clip is two cycles, so 0 and 2
    # of five would show the same pose.
    for place in range(_FRAMES):
        sheet.paste(Image.fromarray(frames[1 + place]), (x + place * (_SIZE + _GAP // 2), y))


def _caption(episode: Episode) -> str:
    kind = episode.challenge or episode.family
    support = f" ({episode.support})" if episode.support else ""
    return (
        f"{episode.episode_id}   {episode.emotion}   {episode.action.replace('_', ' ')}{support}   "
        f"{kind.replace('_', ' ')}   {episode.initial_distance_m:.1f} m away   visible share: "
        f"init {episode.visible_share_init:.2f}, ref {episode.visible_share_ref:.2f}, "
        f"mon {episode.visible_share_mon:.2f}"
    )
