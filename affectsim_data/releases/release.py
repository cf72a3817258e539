"""A release opened for reading: episodes by split, assets by identifier."""

from __future__ import annotations

import bisect
import functools
import itertools
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any, TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.avatars import Avatar
from affectsim_data.episodes import Episode, Participant, Person, World
from affectsim_data.releases.heap import trim_heap
from affectsim_data.releases.joined_splits import check_split, join_split
from affectsim_data.releases.manifest import Manifest
from affectsim_data.releases.rows import read_motion
from affectsim_data.releases.splits import EpisodeTable, SplitBy, SplitTable
from affectsim_data.releases.stores import FolderStore, Store
from affectsim_data.releases.tables import open_parquet, read_table
from affectsim_data.scenes import Scene
from affectsim_data.schemas import SCHEMAS, SPLITS, AssetTable

if TYPE_CHECKING:
    from affectsim_data.navmesh import NavMesh

__all__ = ["Release"]

_Item = TypeVar("_Item")
_MOTIONS_KEPT, _SCENES_KEPT, _AVATARS_KEPT = 256, 8, 32


class Release:
    """A set of episodes with the motions, scenes and avatars they name.

    Files are read when first needed and checked against the manifest; the most recent assets and
    shards of episodes are kept.
    """

    def __init__(self, store: Store, *, scenes_kept: int = _SCENES_KEPT) -> None:
        """Opens what a store holds.

        Args:
            store: Gives the files.
            scenes_kept: Scenes held in memory, and on the renderer's device, at a time.
        """
        self._store = store
        self._scenes_kept = scenes_kept
        self._splits: dict[str, SplitTable] = {}
        self._joined: dict[tuple[str, SplitBy], EpisodeTable] = {}
        self._places: dict[AssetTable, dict[str, tuple[str, int]]] = {}
        everything = SCHEMAS["motions"].names[1:]
        self.motion = self._kept(_MOTIONS_KEPT, "motions", everything, read_motion)
        self.scene = self._kept(scenes_kept, "scenes", ["glb"], _read_scene)
        self.navmesh = self._kept(scenes_kept, "scenes", ["navmesh"], _read_navmesh)
        self.avatar = self._kept(_AVATARS_KEPT, "avatars", ["glb"], _read_avatar)

    def _kept(
        self,
        size: int,
        table: AssetTable,
        columns: Sequence[str],
        read: Callable[[dict[str, Any], str], _Item],
    ) -> Callable[[str], _Item]:
        @functools.lru_cache(maxsize=size)
        def get(asset_id: str) -> _Item:
            row = self._asset_row(table, asset_id, columns)
            return read(row, f"{self.uri}: {table} {asset_id!r}")

        return get

    def __getstate__(self) -> dict[str, Any]:
        """A worker process gets the place, not what was read from it."""
        return {"store": self._store, "scenes_kept": self._scenes_kept}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(**state)  # type: ignore[misc]  # caches start empty

    @property
    def manifest(self) -> Manifest:
        """Its table of contents."""
        return self._store.manifest

    @property
    def uri(self) -> str:
        """Where it is; on the Hub, with the commit."""
        return self._store.uri

    @functools.cached_property
    def content_sha256(self) -> str:
        """Names what is in it, wherever it is; a partial copy is called as the whole."""
        partial = self.manifest.partial_of
        return self.manifest.sha256 if partial is None else partial.manifest_sha256

    @property
    def is_remote(self) -> bool:
        """Whether files come over a network, so that it is of use to `prefetch` them."""
        return not isinstance(self._store, FolderStore)

    def split_table(self, split: str, split_by: SplitBy = "group") -> EpisodeTable:
        """The episodes of a split.

        Args:
            split: `train`, `validation` or `test`.
            split_by: What no two splits share: `group`, the paper's, which is how episodes are
                stored; `scene`; or `both`, of the episodes in the same split by either.

        Raises:
            ValueError: Not a split, the release has no episode in it, or a partial copy lacks it.
        """
        check_split(split, split_by)
        if split_by == "group":
            return self.stored_split(split)
        key = (split, split_by)
        if key not in self._joined:
            self._joined[key] = join_split(self, self._store, split, split_by)
        return self._joined[key]

    def stored_split(self, split: str) -> SplitTable:
        """The episodes of a split by group; reads nothing yet.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        if split not in self._splits:
            check_split(split)
            if not self.manifest.num_rows("index", split):
                partial = self.manifest.partial_of
                if partial is not None:
                    raise ValueError(partial.lacks(split, folder=self.uri))
                counts = {one: self.manifest.num_rows("index", one) for one in SPLITS}
                raise ValueError(f"{self.uri}: split {split!r} is empty; episodes: {counts}")
            self._splits[split] = SplitTable(self._store, split, self._asset_places)
        return self._splits[split]

    def num_episodes(self, split: str) -> int:
        """Episodes of a split, of which a partial copy may hold fewer.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        return self.stored_split(split).num_episodes

    def episode_index(self, split: str) -> pa.Table:
        """What the episodes of a split are and which assets they need, one row each.

        Its columns are those of the `index` schema, strings other than the identifier as
        dictionaries; much smaller than `episode_table`.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        return self.stored_split(split).index

    def episode_table(self, split: str, columns: Sequence[str] | None = None) -> pa.Table:
        """Columns, all if not said, of the episodes of a split that are here.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        return self.stored_split(split).table(columns)

    def episode(self, split: str, index: int) -> Episode:
        """The episode at a place of a split's table.

        Raises:
            FileNotFoundError: This copy of the release is partial, and without that episode.
        """
        return self.stored_split(split).episode(index)

    def cells(self, split: str) -> pa.Table:
        """Episodes planned and composed per cell of the recipe, one row each; none if not told.

        Raises:
            ValueError: Not a split.
        """
        check_split(split)
        names = self.manifest.table_files("cells", split)
        tables = [read_table(self._store, "cells", name) for name in names]
        return pa.concat_tables([SCHEMAS["cells"].empty_table(), *tables])

    def recorded_table(self, name: str) -> pa.Table:
        """Trajectories in a file of the release; see `affectsim_data.releases.recorded`.

        Raises:
            IntegrityError: Its bytes are not what the manifest promises.
            ValueError: Not a file of trajectories.
        """
        return read_table(self._store, "trajectories", name)

    def find_episode(self, episode_id: str) -> Episode:
        """The episode of that identifier, in any split.

        Raises:
            KeyError: There is none.
        """
        for split in SPLITS:
            if not self.manifest.num_rows("index", split):
                continue
            found = self.episode_index(split).column("episode_id").index(episode_id).as_py()
            if found >= 0:
                return self.episode(split, found)
        raise KeyError(f"{self.uri}: no episode {episode_id!r}; `affectsim info` lists some")

    def world(self, episode: Episode) -> World:
        """The scene, people and camera an episode names.

        Raises:
            KeyError: It names a motion, scene or avatar the release does not have.
        """
        try:
            scene = self.scene(episode.scene_id)
            people = tuple(self._person(participant) for participant in episode.participants)
        except KeyError as error:
            raise KeyError(f"episode {episode.episode_id!r}: {error.args[0]}") from error
        return World(scene, people, camera=self.manifest.camera, robot=self.manifest.robot)

    def _person(self, participant: Participant) -> Person:
        return Person(
            motion=self.motion(participant.motion_id),
            avatar=self.avatar(participant.avatar_id),
            T_world_performance=participant.T_world_performance,
        )

    def asset_ids(self, table: AssetTable) -> list[str]:
        """Identifiers of all motions, scenes or avatars, in stored order."""
        return list(self.manifest.asset_places(table))

    def episode_files(self, split: str, rows: Iterable[int]) -> list[str]:
        """Files that drawing the episodes at these places of a split needs, in order of use.

        Raises:
            KeyError: An episode names an asset the release does not have.
        """
        return self.stored_split(split).files(rows)

    def prefetch(self, files: Iterable[str]) -> None:
        """Has files fetched in the background where they are not here yet; returns at once."""
        self._store.prefetch(files)

    def _asset_places(self, table: AssetTable) -> dict[str, tuple[str, int]]:
        if table not in self._places:
            self._places[table] = self.manifest.asset_places(table)
        return self._places[table]

    def _asset_place(self, table: AssetTable, asset_id: str) -> tuple[str, int]:
        try:
            return self._asset_places(table)[asset_id]
        except KeyError:
            raise KeyError(f"{self.uri}: {table} has no {asset_id!r}") from None

    def _asset_row(
        self, table: AssetTable, asset_id: str, columns: Sequence[str]
    ) -> dict[str, Any]:
        name, place = self._asset_place(table, asset_id)
        key = SCHEMAS[table].names[0]
        with open_parquet(self._store, table, name) as file:
            group, place = _row_group(file, place)
            group_rows = file.read_row_group(group, [key, *columns], use_threads=False)
        row: dict[str, Any] = group_rows.slice(place, 1).to_pylist()[0]
        if row[key] != asset_id:
            raise ValueError(f"{name}: the manifest promises {asset_id!r}, it holds {row[key]!r}")
        return row


def _row_group(file: pq.ParquetFile, row: int) -> tuple[int, int]:
    """The row group that holds a row of a file, and the row's place inside."""
    sizes = [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)]
    starts = [0, *itertools.accumulate(sizes[:-1])]
    group = bisect.bisect_right(starts, row) - 1
    return group, row - starts[group]


def _read_scene(row: dict[str, Any], where: str) -> Scene:
    scene = Scene.from_glb(row["glb"], name=where)
    trim_heap()  # of the scene that makes room, too
    return scene


def _read_navmesh(row: dict[str, Any], where: str) -> NavMesh:
    from affectsim_data.navmesh import NavMesh  # half a second of SciPy that drawing does not need

    return NavMesh.from_bytes(row["navmesh"], name=where)


def _read_avatar(row: dict[str, Any], where: str) -> Avatar:
    return Avatar.from_glb(row["glb"], name=where)
