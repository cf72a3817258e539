"""One split of a release: its light index, its episodes, and the files each of them needs.

A release stores its episodes by the paper's split, which is by group. Other splits are made of
the stored ones, see `affectsim_data.releases.joined_splits`; all are read as an `EpisodeTable`.
"""

from __future__ import annotations

import bisect
import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, Protocol, get_args

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.episodes import Episode
from affectsim_data.releases.packing import PackedRows
from affectsim_data.releases.stores import Store
from affectsim_data.releases.tables import read_table
from affectsim_data.schemas import SCHEMAS, AssetTable

__all__ = ["SPLIT_BYS", "EpisodeTable", "SplitBy", "SplitTable", "dictionary_codes", "files_used"]

SplitBy = Literal["group", "scene", "both"]
"""What no two splits share: performer, performance or sequence (the paper's split); the scene; or
either of them: of episodes that are in the same split by group and by scene."""
SPLIT_BYS: tuple[SplitBy, ...] = get_args(SplitBy)

_SHARDS_KEPT = 128
_INDEX_CATEGORIES = [
    name for name in SCHEMAS["index"].names if name not in ("episode_id", "target")
]
_ASSET_COLUMNS: tuple[tuple[AssetTable, str], ...] = (
    ("scenes", "scene_id"),
    ("motions", "motion_id"),
    ("motions", "partner_motion_id"),
    ("avatars", "avatar_id"),
    ("avatars", "partner_avatar_id"),
)
"""Columns of the index that name assets, in order of use."""
_NONE, _UNKNOWN = -1, -2
"""In place of a file number: an episode needs none, or names an asset that is nowhere."""


class EpisodeTable(Protocol):
    """The episodes of a split, by their places in it."""

    @property
    def num_episodes(self) -> int:
        """Episodes of the split, of which a partial copy may hold fewer."""

    @property
    def index(self) -> pa.Table:
        """What the episodes are and which assets they need, one row each."""

    @property
    def held_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows are here, `(num_held,)`."""

    @property
    def drawable_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows and assets are here, `(num_drawable,)`."""

    def table(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Columns, all if not said, of the episodes that are here: the rows are `held_rows`."""

    def episode(self, place: int) -> Episode:
        """The episode at a place of the split."""

    def files(self, places: Iterable[int]) -> list[str]:
        """Files that drawing the episodes at some places needs, in order of use."""


class SplitTable:
    """The episodes of a stored split; files are read when first needed, the latest shards kept."""

    def __init__(
        self,
        store: Store,
        split: str,
        asset_places: Callable[[AssetTable], Mapping[str, tuple[str, int]]],
    ) -> None:
        """Reads nothing yet.

        Args:
            store: Gives the files.
            split: Of which there is at least one episode.
            asset_places: Says where assets are, as the manifest does.
        """
        self._store = store
        self._split = split
        self._asset_places = asset_places
        self._shard = functools.lru_cache(maxsize=_SHARDS_KEPT)(self._read_shard)

    @functools.cached_property
    def num_episodes(self) -> int:
        """Episodes of the split, of which a partial copy may hold fewer."""
        return self._store.manifest.num_rows("index", self._split)

    @functools.cached_property
    def index(self) -> pa.Table:
        """What the episodes are and which assets they need, strings but the identifier as
        dictionaries."""
        names = self._store.manifest.table_files("index", self._split)
        shards = [
            read_table(self._store, "index", name, read_dictionary=_INDEX_CATEGORIES)
            for name in names
        ]
        return pa.concat_tables(shards).unify_dictionaries().combine_chunks()

    @functools.cached_property
    def held_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows are here: all, but in a partial copy, `(num_held,)`."""
        ends = zip(self._starts, self._counts, strict=True)
        parts = [np.arange(start, start + count) for start, count in ends]
        return np.concatenate(parts) if parts else np.zeros(0, np.int64)

    @functools.cached_property
    def drawable_rows(self) -> NDArray[np.int64]:
        """Places of the episodes whose rows and assets are here, `(num_drawable,)`."""
        scenes = self._store.manifest.scene_ids(self._split)
        if scenes is None:
            return np.arange(self.num_episodes)
        codes, words = dictionary_codes(self.index.column("scene_id"))
        held = [code for code, word in enumerate(words) if word in scenes]
        return np.intersect1d(np.flatnonzero(np.isin(codes, held)), self.held_rows)

    def table(self, columns: Sequence[str] | None = None) -> pa.Table:
        """Columns, all if not said, of the episodes that are here: the rows are `held_rows`."""
        self._store.prefetch(self._names)
        wanted = SCHEMAS["episodes"].names if columns is None else list(columns)
        shards = [read_table(self._store, "episodes", name, columns=wanted) for name in self._names]
        schema = pa.schema([SCHEMAS["episodes"].field(name) for name in wanted])
        return pa.concat_tables(shards) if shards else schema.empty_table()

    def episode(self, place: int) -> Episode:
        """The episode at a place of the split.

        Raises:
            FileNotFoundError: This copy of the release is partial, and without that episode.
        """
        number = bisect.bisect_right(self._starts, place) - 1
        row = place - self._starts[number] if number >= 0 else -1
        if not 0 <= row < self._counts[number]:
            raise FileNotFoundError(
                f"{self._store.uri}: episode {place} of split {self._split!r} is not in this "
                "partial copy; `affectsim download` can add it"
            )
        return Episode.from_row(self._shard(self._names[number]).row(row))

    def files(self, places: Iterable[int]) -> list[str]:
        """Files that drawing the episodes at some places needs, in order of use.

        Raises:
            KeyError: An episode names an asset the release does not have.
        """
        rows = np.fromiter(places, np.int64)
        return files_used(self._store, self.index, self.needed_files, rows)

    @functools.cached_property
    def needed_files(self) -> NDArray[np.int32]:
        """Places in the manifest of the files that each episode needs, `(num_episodes, 6)`."""
        index = self.index
        numbers = {name: number for number, name in enumerate(self._store.manifest.files)}
        needed = np.full((index.num_rows, 1 + len(_ASSET_COLUMNS)), _NONE, np.int32)
        for name, start, count in zip(self._names, self._starts, self._counts, strict=True):
            needed[start : start + count, 0] = numbers[name]
        for column, (table, key) in enumerate(_ASSET_COLUMNS, start=1):
            places = self._asset_places(table)
            codes, words = dictionary_codes(index.column(key))
            known = [numbers[places[word][0]] if word in places else _UNKNOWN for word in words]
            needed[:, column] = np.array([*known, _NONE])[codes]
        return needed

    @functools.cached_property
    def _first_rows(self) -> dict[str, int]:
        return self._store.manifest.first_rows(self._split)

    @functools.cached_property
    def _names(self) -> list[str]:
        return list(self._first_rows)

    @functools.cached_property
    def _starts(self) -> list[int]:
        return list(self._first_rows.values())

    @functools.cached_property
    def _counts(self) -> list[int]:
        return [self._store.manifest.files[name].rows for name in self._names]

    def _read_shard(self, name: str) -> PackedRows:
        return PackedRows(read_table(self._store, "episodes", name))


def files_used(
    store: Store, index: pa.Table, needed: NDArray[np.int32], rows: NDArray[np.int64]
) -> list[str]:
    """Names of the files that the episodes at some places need, in order of use.

    Args:
        store: Whose files they are.
        index: Of the split.
        needed: `SplitTable.needed_files` of its rows, `(num_episodes, 6)`.
        rows: The places, `(n,)`.

    Raises:
        KeyError: An episode names an asset the release does not have.
    """
    chosen = needed[rows].ravel()
    if (chosen == _UNKNOWN).any():
        place, column = divmod(int(np.argmax(chosen == _UNKNOWN)), needed.shape[1])
        table, key = _ASSET_COLUMNS[column - 1]
        asset_id = index.column(key)[int(rows[place])].as_py()
        raise KeyError(f"{store.uri}: {table} has no {asset_id!r}")
    found, first = np.unique(chosen, return_index=True)
    names = list(store.manifest.files)
    return [names[number] for number in found[np.argsort(first)] if number != _NONE]


def dictionary_codes(column: pa.ChunkedArray) -> tuple[NDArray[np.int64], list[Any]]:
    """Places of a dictionary column's values in its words, -1 for null, `(n,)`; and the words."""
    array = column.combine_chunks()
    codes = array.indices.fill_null(-1).to_numpy(zero_copy_only=False).astype(np.int64)
    return codes, array.dictionary.to_pylist()
