"""A contact sheet per action and emotion: can the emotion be told with the labels covered?"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from tqdm import tqdm

from affectsim_data.avatars import Avatar
from affectsim_data.episodes import Person
from affectsim_data.inspection.motion_sheets import MotionRow, motion_sheet
from affectsim_data.motions import Emotion, Motion
from affectsim_data.releases import Release
from affectsim_data.render import Renderer, process_renderer

__all__ = ["KEY_NAME", "emotion_sheets"]

KEY_NAME = "key.json"
"""What is on which sheet, for sheets without labels."""


class _Entry(NamedTuple):
    """What has to be known of a motion to choose it."""

    motion_id: str
    performer_id: str
    performance: str
    action: str
    emotion: Emotion


def emotion_sheets(
    source: Release | Sequence[Motion],
    folder: Path | str,
    *,
    avatars: Sequence[Avatar] = (),
    renderer: Renderer | None = None,
    labels: bool = True,
    rng: np.random.Generator | None = None,
    max_rows: int = 6,
    num_frames: int = 12,
    progress: bool = True,
) -> list[Path]:
    """Writes `ACTION-EMOTION.png` for all there are: a row per motion, performers taken in turn.

    Without labels the sheets are numbered in random order and `key.json` says what they show.

    Args:
        source: A release, or motions.
        folder: Where to write; made if it is not there.
        avatars: Bodies, one performer the next; the release's own if none are given.
        renderer: Draws; this process' own if not given.
        labels: Whether sheets say what they show.
        rng: Orders sheets without labels.
        max_rows: Motions on a sheet at most.
        num_frames: Instants of each motion.
        progress: Whether to show a bar.

    Returns:
        The sheets, in the order of actions and emotions with labels, of numbers without.

    Raises:
        ValueError: There are no motions, no avatars, or no `rng` for sheets without labels.
    """
    entries, motion_of = _motions(source)
    if not avatars and isinstance(source, Release):
        avatars = [source.avatar(name) for name in source.asset_ids("avatars")]
    if not entries or not avatars:
        raise ValueError(
            f"emotion_sheets needs motions and avatars, got {len(entries)} and {len(avatars)}"
        )
    groups = sorted({(entry.action, entry.emotion) for entry in entries})
    names = [f"{action}-{emotion}" for action, emotion in groups]
    if not labels:
        if rng is None:
            raise ValueError("sheets without labels need rng, to come in random order")
        groups = [groups[place] for place in rng.permutation(len(groups))]
        names = [f"sheet-{number:02d}" for number in range(1, len(groups) + 1)]
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    performers = sorted({entry.performer_id for entry in entries})
    paths = []
    bar = tqdm(list(zip(names, groups, strict=True)), desc="sheets", disable=not progress)
    for name, (action, emotion) in bar:
        mine = [one for one in entries if (one.action, one.emotion) == (action, emotion)]
        rows = []
        for entry in _varied(mine, max_rows):
            avatar = avatars[performers.index(entry.performer_id) % len(avatars)]
            rows.append(_row(motion_of(entry.motion_id), avatar))
        sheet = motion_sheet(
            rows, renderer or process_renderer(), num_frames=num_frames, labels=labels
        )
        paths.append(folder / f"{name}.png")
        sheet.save(paths[-1])
    if not labels:
        key = {
            name: f"{action}-{emotion}"
            for name, (action, emotion) in zip(names, groups, strict=True)
        }
        (folder / KEY_NAME).write_text(json.dumps(key, indent=2) + "\n", encoding="utf-8")
    return paths


def _motions(source: Release | Sequence[Motion]) -> tuple[list[_Entry], Callable[[str], Motion]]:
    """What there is, and how to get it; a release's motions are not all kept."""
    if isinstance(source, Release):
        found = (source.motion(name) for name in source.asset_ids("motions"))
        return [_entry(motion) for motion in found], source.motion
    by_id = {motion.motion_id: motion for motion in source}
    return [_entry(motion) for motion in by_id.values()], by_id.__getitem__


def _entry(motion: Motion) -> _Entry:
    return _Entry(*(getattr(motion, field) for field in _Entry._fields))


def _varied(entries: Sequence[_Entry], count: int) -> list[_Entry]:
    """Entries of performers and performances not seen yet first, by name where that is equal."""
    left, chosen = sorted(entries), list[_Entry]()
    seen: Counter[str] = Counter()
    while left and len(chosen) < count:
        best = min(left, key=lambda one: seen[one.performer_id] + seen[f"/{one.performance}"])
        left.remove(best)
        chosen.append(best)
        seen.update((best.performer_id, f"/{best.performance}"))
    return chosen


def _row(motion: Motion, avatar: Avatar) -> MotionRow:
    words = [motion.emotion, motion.performance or motion.action, motion.performer_id]
    caption = f"{', '.join(words)}, {motion.duration_s:.1f} s"
    return MotionRow(caption, (Person(motion, avatar, np.eye(4)),))
