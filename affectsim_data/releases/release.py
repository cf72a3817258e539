"""A release opened for reading: episodes by split, assets by identifier."""

from __future__ import annotations

import bisect
import functools
import itertools
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.avatars import Avatar
from affectsim_data.episodes import Episode, Participant, Person, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases.manifest import Manifest
from affectsim_data.releases.rows import read_motion
from affectsim_data.releases.stores import Store
from affectsim_data.scenes import Scene
from affectsim_data.schemas import SCHEMAS, SPLITS, AssetTable, TableName, check_table

__all__ = ["Release"]

_Item = TypeVar("_Item")
_MOTIONS_KEPT, _SCENES_KEPT, _AVATARS_KEPT, _SHARDS_KEPT = 256, 8, 32, 128
_INDEX_CATEGORIES = [
    name for name in SCHEMAS["index"].names if name not in ("episode_id", "target")
]


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
        self._indices: dict[str, pa.Table] = {}
        self._places: dict[AssetTable, dict[str, tuple[str, int]]] = {}
        everything = SCHEMAS["motions"].names[1:]
        self.motion = self._kept(_MOTIONS_KEPT, "motions", everything, read_motion)
        self.scene = self._kept(scenes_kept, "scenes", ["glb"], _read_scene)
        self.navmesh = self._kept(scenes_kept, "scenes", ["navmesh"], _read_navmesh)
        self.avatar = self._kept(_AVATARS_KEPT, "avatars", ["glb"], _read_avatar)
        self._shard = functools.lru_cache(maxsize=_SHARDS_KEPT)(self._read_shard)

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

    def episode_index(self, split: str) -> pa.Table:
        """What the episodes of a split are and which assets they need, one row each.

        Its columns are those of the `index` schema, strings other than the identifier as
        dictionaries; much smaller than `episode_table`.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        if split not in SPLITS:
            raise ValueError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
        if split not in self._indices:
            counts = {one: self.manifest.num_rows("index", one) for one in SPLITS}
            if not counts[split]:
                raise ValueError(f"{self.uri}: split {split!r} is empty; episodes: {counts}")
            shards = [
                self._read_table("index", name, read_dictionary=_INDEX_CATEGORIES)
                for name in self.manifest.table_files("index", split)
            ]
            self._indices[split] = pa.concat_tables(shards).unify_dictionaries()
        return self._indices[split]

    def episode_table(self, split: str) -> pa.Table:
        """All columns of all episodes of a split.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        self.episode_index(split)
        names = self.manifest.table_files("episodes", split)
        return pa.concat_tables([self._shard(name) for name in names])

    def episode(self, split: str, index: int) -> Episode:
        """The episode at a place of a split's table."""
        names, starts = self._episode_shards(split)
        number = bisect.bisect_right(starts, index) - 1
        row = index - starts[number]
        columns = zip(SCHEMAS["episodes"].names, self._shard(names[number]).columns, strict=True)
        return Episode.from_row({name: column.chunk(0)[row].as_py() for name, column in columns})

    def _episode_shards(self, split: str) -> tuple[list[str], list[int]]:
        """Files of a split's table, and the place of the first row of each."""
        names = self.manifest.table_files("episodes", split)
        rows = [self.manifest.files[name].rows for name in names]
        return names, [0, *itertools.accumulate(rows[:-1])]

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
        names, starts = self._episode_shards(split)
        places = list(rows)
        needed = [names[bisect.bisect_right(starts, row) - 1] for row in places]
        index = self.episode_index(split).take(places)
        columns: tuple[tuple[AssetTable, str], ...] = (
            ("scenes", "scene_id"),
            *(("motions", name) for name in ("motion_id", "partner_motion_id")),
            *(("avatars", name) for name in ("avatar_id", "partner_avatar_id")),
        )
        per_row = [needed]
        for table, column in columns:
            asset_ids = index.column(column).to_pylist()
            per_row.append([self._asset_place(table, key)[0] for key in asset_ids if key])
        return list(dict.fromkeys(itertools.chain.from_iterable(per_row)))

    def prefetch(self, files: Iterable[str]) -> None:
        """Has files fetched in the background where they are not here yet; returns at once."""
        self._store.prefetch(files)

    def _asset_place(self, table: AssetTable, asset_id: str) -> tuple[str, int]:
        if table not in self._places:
            self._places[table] = self.manifest.asset_places(table)
        try:
            return self._places[table][asset_id]
        except KeyError:
            raise KeyError(f"{self.uri}: {table} has no {asset_id!r}") from None

    def _asset_row(
        self, table: AssetTable, asset_id: str, columns: Sequence[str]
    ) -> dict[str, Any]:
        name, place = self._asset_place(table, asset_id)
        key = SCHEMAS[table].names[0]
        with self._open_parquet(table, name) as file:
            group, place = _row_group(file, place)
            group_rows = file.read_row_group(group, [key, *columns])
        row: dict[str, Any] = group_rows.slice(place, 1).to_pylist()[0]
        if row[key] != asset_id:
            raise ValueError(f"{name}: the manifest promises {asset_id!r}, it holds {row[key]!r}")
        return row

    def _read_shard(self, name: str) -> pa.Table:
        return self._read_table("episodes", name).combine_chunks()

    def _read_table(self, table: TableName, name: str, **options: Any) -> pa.Table:
        with self._open_parquet(table, name, **options) as file:
            found = file.read(columns=SCHEMAS[table].names)
        if found.num_rows != self.manifest.files[name].rows:
            raise ValueError(
                f"{name}: the manifest says {self.manifest.files[name].rows} rows, "
                f"the file holds {found.num_rows}"
            )
        return found

    def _open_parquet(self, table: TableName, name: str, **options: Any) -> pq.ParquetFile:
        source = pa.BufferReader(self._store.read(name))
        try:
            check_table(pq.read_schema(source), table, file=name)
            source.seek(0)
            return pq.ParquetFile(source, **options)
        except (pa.ArrowInvalid, OSError) as error:
            raise ValueError(f"{name}: not a Parquet file: {error}") from error


def _row_group(file: pq.ParquetFile, row: int) -> tuple[int, int]:
    """The row group that holds a row of a file, and the row's place inside."""
    sizes = [file.metadata.row_group(group).num_rows for group in range(file.num_row_groups)]
    starts = [0, *itertools.accumulate(sizes[:-1])]
    group = bisect.bisect_right(starts, row) - 1
    return group, row - starts[group]


def _read_scene(row: dict[str, Any], where: str) -> Scene:
    return Scene.from_glb(row["glb"], name=where)


def _read_navmesh(row: dict[str, Any], where: str) -> NavMesh:
    return NavMesh.from_bytes(row["navmesh"], name=where)


def _read_avatar(row: dict[str, Any], where: str) -> Avatar:
    return Avatar.from_glb(row["glb"], name=where)
