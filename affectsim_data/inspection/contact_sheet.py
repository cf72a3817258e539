"""A picture that shows what observation does: one performance per row, one condition per column."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from affectsim_data.episodes import Episode
from affectsim_data.inspection.views import SHOWN_CONDITIONS, condition_title, draw_views
from affectsim_data.loaders import Clip, resolve_condition
from affectsim_data.observations import Condition
from affectsim_data.releases import Release
from affectsim_data.render import Renderer
from affectsim_data.schemas import SPLITS, Split

__all__ = ["contact_sheet", "representative_episodes"]

_SIZE, _GAP, _HEADER, _CAPTION = 224, 6, 30, 24
_FRAMES = 2
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
) -> Image.Image:
    """Draws the sheet: a row per episode with its caption, two instants per condition."""
    resolved = [resolve_condition(condition) for condition in conditions]
    clip = Clip(num_frames=2 * _FRAMES + 1, width=_SIZE, height=_SIZE)
    block = _FRAMES * _SIZE + _GAP // 2
    width = len(resolved) * (block + _GAP) + _GAP
    row_height = _CAPTION + _SIZE + _GAP
    sheet = Image.new("RGB", (width, _HEADER + len(episodes) * row_height), _PAPER)
    draw = ImageDraw.Draw(sheet)
    font, small = ImageFont.load_default(size=17), ImageFont.load_default(size=14)
    for column, condition in enumerate(resolved):
        x = _GAP + column * (block + _GAP)
        draw.text((x, 6), condition_title(condition), fill=_INK, font=font)
    for row, episode in enumerate(episodes):
        y = _HEADER + row * row_height
        draw.text((_GAP, y + 4), _caption(episode), fill=_QUIET, font=small)
        views = draw_views(
            episode, release.world(episode), renderer, conditions=resolved, clip=clip
        )
        for column, condition in enumerate(resolved):
            x = _GAP + column * (block + _GAP)
            _paste(sheet, views[condition.name], x, y + _CAPTION)
    return sheet


def _paste(sheet: Image.Image, frames: NDArray[np.uint8], x: int, y: int) -> None:
    # Instants 1 and 2 of 5: a quarter and half of the clip; the clip is two cycles, so 0 and 2
    # of five would show the same pose.
    for place in range(_FRAMES):
        sheet.paste(Image.fromarray(frames[1 + place]), (x + place * (_SIZE + _GAP // 2), y))


def _caption(episode: Episode) -> str:
    kind = episode.challenge or episode.family
    return (
        f"{episode.episode_id}   {episode.emotion}   {episode.action.replace('_', ' ')}   "
        f"{kind.replace('_', ' ')}   {episode.initial_distance_m:.1f} m away   visible share: "
        f"init {episode.visible_share_init:.2f}, ref {episode.visible_share_ref:.2f}, "
        f"mon {episode.visible_share_mon:.2f}"
    )
