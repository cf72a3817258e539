"""Splits that a release does not store: by scene, and by scene and group at once.

They are made of the stored splits: the episodes whose `scene_split` is the one asked for, of all
stored splits or of the one of that name, in stored order.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.episodes import Episode
from affectsim_data.releases.splits import (
    SPLIT_BYS,
    SplitBy,
    SplitTable,
    dictionary_codes,
    files_used,
)
from affectsim_data.releases.stores import Store
from affectsim_data.schemas import SPLITS, Split

if TYPE_CHECKING:
    from affectsim_data.releases.release import Release

__all__ = ["JoinedSplit", "as_split_by", "check_split", "join_split", "split_title", "splits_there"]


class JoinedSplit:
    """Some episodes of stored splits, one split after the other; an `EpisodeTable`."""

    def __init__(self, store: Store, parts: Sequence[tuple[SplitTable, NDArray[np.int64]]]) -> None:
        """Reads nothing yet.

        Args:
            store: Whose splits they are.
            parts: Stored splits, and the places in each of the episodes that are meant, rising.
        """
        self._store = store
        self._tables = [table for table, _ in parts]
        self._rows = [rows for _, rows in parts]
        self._ends = np.cumsum([len(rows) for rows in self._rows])

    @property
    def num_episodes(self) -> int:
        """Episodes of the split, of which a partial copy may hold fewer."""
        return sum(len(rows) for rows in self._rows)

    @functools.cached_property
    def index(self) -> pa.Table:
        """What the episodes are and which assets they need, one row each."""
        pairs = zip(self._tables, self._rows, strict=True)
        chosen = [table.index.take(pa.array(rows)) for table, rows in pairs]
        return pa.concat_tables(chosen).unify_dictionaries().combine_chunks()

    @functools.cached_property
    def held_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows are here, `(num_held,)`."""
        return self._places_of([table.held_rows for table in self._tables])

    @functools.cached_property
    def drawable_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows and assets are here, `(num_drawable,)`."""
        return self._places_of([table.drawable_rows for table in self._tables])

    def _places_of(self, stored: Sequence[NDArray[np.int64]]) -> NDArray[np.int64]:
        """Places in this split of places in the stored ones; what is not in it is left out."""
        pairs = zip(self._rows, stored, strict=True)
        return np.flatnonzero(np.concatenate([np.isin(rows, places) for rows, places in pairs]))

    def table(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Columns, all if not said, of the episodes that are here: the rows are `held_rows`."""
        chosen = []
        for table, rows in zip(self._tables, self._rows, strict=True):
            if len(rows):
                inside = np.flatnonzero(np.isin(table.held_rows, rows))
                chosen.append(table.table(columns).take(pa.array(inside)))
        return pa.concat_tables(chosen)

    def episode(self, place: int) -> Episode:
        """The episode at a place of the split.

        Raises:
            FileNotFoundError: This copy of the release is partial, and without that episode.
        """
        number = int(np.searchsorted(self._ends, place, side="right"))
        row = self._rows[number][place - int(self._ends[number])]
        return self._tables[number].episode(int(row))

    def files(self, places: Iterable[int]) -> list[str]:
        """Files that drawing the episodes at some places needs, in order of use.

        Raises:
            KeyError: An episode names an asset the release does not have.
        """
        rows = np.fromiter(places, np.int64)
        return files_used(self._store, self.index, self._needed_files, rows)

    @functools.cached_property
    def _needed_files(self) -> NDArray[np.int32]:
        pairs = zip(self._tables, self._rows, strict=True)
        return np.concatenate([table.needed_files[rows] for table, rows in pairs])


def check_split(split: str, split_by: str = "group") -> None:
    """Raises ValueError unless these are words for a split and for what it is by."""
    if split not in SPLITS:
        raise ValueError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
    as_split_by(split_by)


def as_split_by(word: str) -> SplitBy:
    """The word for what a split is by, checked.

    Raises:
        ValueError: There is no such word.
    """
    for one in SPLIT_BYS:
        if one == word:
            return one
    raise ValueError(f"split_by must be one of {', '.join(SPLIT_BYS)}, got {word!r}")


def split_title(split: str, split_by: str) -> str:
    """What messages call a split.

    Examples:
        >>> split_title("test", "group"), split_title("test", "scene")
        ("split 'test'", "split 'test' by scene")
    """
    ending = {"group": "", "scene": " by scene", "both": " by group and scene"}[split_by]
    return f"split {split!r}{ending}"


def join_split(release: Release, store: Store, split: str, split_by: SplitBy) -> JoinedSplit:
    """The split of that name by scene, or by group and scene; reads the index.

    Raises:
        ValueError: The release has no episode in it, or this partial copy lacks it.
    """
    stored = _stored_splits(release, split, split_by)
    joined = JoinedSplit(store, _parts(release, split, stored))
    if not joined.num_episodes:
        raise ValueError(_nothing_there(release, split, split_by, stored))
    partial = release.manifest.partial_of
    if partial is not None and not len(joined.drawable_rows):
        raise ValueError(partial.lacks(split, split_by=split_by, folder=release.uri))
    return joined


def splits_there(release: Release, split_by: SplitBy = "group") -> tuple[Split, ...]:
    """The splits, by group or otherwise, with an episode; of a partial copy, with one to draw.

    Raises:
        ValueError: Not a word for what a split is by, or this partial copy lacks the index of a
            stored split.
    """
    as_split_by(split_by)
    there = tuple(split for split in SPLITS if release.manifest.num_rows("index", split))
    if split_by == "group" or not there:
        return there
    return tuple(
        split
        for split in (SPLITS if split_by == "scene" else there)
        if any(
            np.isin(table.drawable_rows, rows).any()
            for table, rows in _parts(release, split, _stored_splits(release, split, split_by))
        )
    )


def _parts(
    release: Release, split: str, stored: Sequence[Split]
) -> list[tuple[SplitTable, NDArray[np.int64]]]:
    """Of some stored splits, the places of the episodes whose scenes are in a split."""
    parts = []
    for table in map(release.stored_split, stored):
        codes, words = dictionary_codes(table.index.column("scene_split"))
        code = words.index(split) if split in words else len(words)
        parts.append((table, np.flatnonzero(codes == code)))
    return parts


def _stored_splits(release: Release, split: str, split_by: SplitBy) -> Sequence[Split]:
    """Stored splits that may hold episodes of a split; a partial copy must have their index."""
    there = [one for one in SPLITS if release.manifest.num_rows("index", one)]
    partial = release.manifest.partial_of
    needed = [one for one in SPLITS if one == split] if split_by == "both" else list(SPLITS)
    if partial is not None and (set(needed) & set(partial.splits)) - set(there):
        raise ValueError(partial.lacks(split, split_by=split_by, folder=release.uri))
    return [one for one in needed if one in there]


def _nothing_there(release: Release, split: str, split_by: SplitBy, stored: Sequence[Split]) -> str:
    """Why a joined split is empty, and what there is."""
    counts = dict.fromkeys(SPLITS, 0)
    for name in stored:
        for word in release.stored_split(name).index.column("scene_split").to_pylist():
            counts[word] += 1
    num_scenes = release.manifest.num_rows("scenes")
    few = "" if num_scenes >= 3 else f"; {num_scenes} scenes are too few, it takes 3"
    of = "" if split_by == "scene" else f" of split {split!r} by group"
    return (
        f"{release.uri}: {split_title(split, split_by)} is empty; episodes{of} by scene: "
        f"{counts}{few}"
    )
