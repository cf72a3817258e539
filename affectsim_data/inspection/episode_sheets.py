"""Contact sheets to judge a release by eye: random episodes, a page per family or challenge."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from tqdm import tqdm

from affectsim_data.episodes import Episode
from affectsim_data.inspection.contact_sheet import contact_sheet
from affectsim_data.inspection.statistics import KINDS, chosen_episodes, episode_kinds
from affectsim_data.inspection.summary import chosen_rows
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.splits import SplitBy
from affectsim_data.render import Renderer

__all__ = ["sampled_episodes", "write_episode_sheets"]

_CONDITIONS = ("p_init", "p_ref", "p_mon")
_PAGE_ROWS = 10


def sampled_episodes(
    release: Release,
    count: int,
    *,
    rng: np.random.Generator,
    split: str | None = None,
    split_by: SplitBy = "group",
    filter: Filter | None = None,
) -> dict[str, list[Episode]]:
    """Random episodes by kind: family or challenge; kinds as even as there are episodes.

    Args:
        release: Where they are.
        count: How many; all there are if fewer.
        rng: Decides which.
        split: Only of this split; of all if not given.
        split_by: What no two splits share.
        filter: Only episodes that match.

    Raises:
        ValueError: A count below 1; no such split, a malformed filter, or no episode.
    """
    if count < 1:
        raise ValueError(f"a sheet needs at least one episode, got {count}")
    chosen = chosen_rows(release, split=split, split_by=split_by, filter=filter)
    if not chosen:
        raise ValueError(f"{release.uri}: has no episodes; `affectsim info --scenes` describes it")
    places = [(one, int(row)) for one, rows in chosen.items() for row in rows]
    kinds = episode_kinds(chosen_episodes(release, chosen, split_by=split_by))
    shuffled = {kind: rng.permutation(np.flatnonzero(kinds == kind)) for kind in KINDS}
    shares = _even_shares(count, [len(shuffled[kind]) for kind in KINDS])
    return {
        kind: [
            release.split_table(places[n][0], split_by).episode(places[n][1])
            for n in sorted(shuffled[kind][:share].tolist())
        ]
        for kind, share in zip(KINDS, shares, strict=True)
        if share
    }


def _even_shares(count: int, sizes: list[int]) -> list[int]:
    """How many to take of groups of some sizes: one of each in turn, until `count` are taken."""
    turns = [(turn, group) for group, size in enumerate(sizes) for turn in range(size)]
    taken = [group for _, group in sorted(turns)[:count]]
    return [taken.count(group) for group in range(len(sizes))]


def write_episode_sheets(
    release: Release, episodes: dict[str, list[Episode]], renderer: Renderer, folder: Path
) -> list[Path]:
    """Writes `KIND.png`, or `KIND-1.png` and on, of at most ten rows each, and says which.

    A row has p_init, p_ref and p_mon side by side, and the episode seen from above.

    Args:
        release: Where the episodes are.
        episodes: By kind, as `sampled_episodes` gives them.
        renderer: Draws them.
        folder: Where to write; made if need be.
    """
    folder.mkdir(parents=True, exist_ok=True)
    pages = [
        (kind, start // _PAGE_ROWS, members[start : start + _PAGE_ROWS], len(members) > _PAGE_ROWS)
        for kind, members in episodes.items()
        for start in range(0, len(members), _PAGE_ROWS)
    ]
    written = []
    for kind, number, members, has_more in tqdm(pages, desc="sheets", unit="sheet", leave=False):
        path = folder / (f"{kind}-{number + 1}.png" if has_more else f"{kind}.png")
        sheet = contact_sheet(release, members, renderer, conditions=_CONDITIONS, plans=True)
        sheet.save(path)
        written.append(path)
    return written
