"""A release opened for reading: episodes by split, assets by identifier."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, Literal, TypeVar

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.avatars import Avatar
from affectsim_data.episodes import Episode, Participant, Person, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases.manifest import Manifest
from affectsim_data.releases.rows import read_motion
from affectsim_data.releases.stores import Store
from affectsim_data.scenes import Scene
from affectsim_data.schemas import SCHEMAS, SPLITS, TableName, check_table

__all__ = ["Release"]

_AssetTable = Literal["motions", "scenes", "avatars"]
_Item = TypeVar("_Item")
_MOTIONS_KEPT, _SCENES_KEPT, _AVATARS_KEPT, _GROUPS_KEPT = 256, 8, 32, 8


class Release:
    """A set of episodes with the motions, scenes and avatars they name.

    Files are checked against the manifest when first read; assets are read one row group at a time
    and the most recent ones are kept.
    """

    def __init__(self, store: Store) -> None:
        self._store = store
        self._tables: dict[str, pa.Table] = {}
        self._indices: dict[_AssetTable, dict[str, tuple[str, int, int]]] = {}
        self._keep()

    def _keep(self) -> None:
        everything = SCHEMAS["motions"].names
        self.motion = self._kept(_MOTIONS_KEPT, "motions", everything, read_motion)
        self.scene = self._kept(_SCENES_KEPT, "scenes", ["glb"], _read_scene)
        self.navmesh = self._kept(_SCENES_KEPT, "scenes", ["navmesh"], _read_navmesh)
        self.avatar = self._kept(_AVATARS_KEPT, "avatars", ["glb"], _read_avatar)
        # Neighbours in a group of motions are asked for soon; groups of the rest hold one row.
        self._motion_group = functools.lru_cache(maxsize=_GROUPS_KEPT)(self._read_group)

    def _kept(
        self,
        size: int,
        table: _AssetTable,
        columns: Sequence[str],
        read: Callable[[dict[str, Any], str], _Item],
    ) -> Callable[[str], _Item]:
        @functools.lru_cache(maxsize=size)
        def get(asset_id: str) -> _Item:
            row = self._asset_row(table, asset_id, tuple(columns))
            return read(row, f"{self.uri}: {table} {asset_id!r}")

        return get

    def __getstate__(self) -> dict[str, Any]:
        """A worker process gets the place, not what was read from it."""
        return {"_store": self._store}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__init__(state["_store"])  # type: ignore[misc]  # caches start empty

    @property
    def manifest(self) -> Manifest:
        """Its table of contents."""
        return self._store.manifest

    @property
    def uri(self) -> str:
        """Where it is; on the Hub, with the commit."""
        return self._store.uri

    def episode_table(self, split: str) -> pa.Table:
        """All episodes of a split.

        Raises:
            ValueError: Not a split, or the release has no episode in it.
        """
        if split not in SPLITS:
            raise ValueError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
        if split not in self._tables:
            names = self.manifest.table_files("episodes", split)
            shards = [_read_table(self._store.path(name), "episodes", name) for name in names]
            if not sum(shard.num_rows for shard in shards):
                counts = {one: self.manifest.num_rows("episodes", one) for one in SPLITS}
                raise ValueError(f"{self.uri}: split {split!r} is empty; episodes: {counts}")
            self._tables[split] = pa.concat_tables(shards)
        return self._tables[split]

    def episode(self, split: str, index: int) -> Episode:
        """The episode at a place of a split's table."""
        return Episode.from_row(self.episode_table(split).slice(index, 1).to_pylist()[0])

    def find_episode(self, episode_id: str) -> Episode:
        """The episode of that identifier, in any split.

        Raises:
            KeyError: There is none.
        """
        for split in SPLITS:
            if not self.manifest.num_rows("episodes", split):
                continue
            found = self.episode_table(split).column("episode_id").index(episode_id).as_py()
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

    def asset_ids(self, table: _AssetTable) -> list[str]:
        """Identifiers of all motions, scenes or avatars, in stored order."""
        return list(self._index(table))

    def _index(self, table: _AssetTable) -> dict[str, tuple[str, int, int]]:
        """File, row group and row inside it, by identifier."""
        if table not in self._indices:
            key = SCHEMAS[table].names[0]
            index: dict[str, tuple[str, int, int]] = {}
            for name in self.manifest.table_files(table):
                with _open_parquet(self._store.path(name), table, name) as file:
                    for group in range(file.num_row_groups):
                        ids = file.read_row_group(group, columns=[key]).column(key).to_pylist()
                        index |= {asset_id: (name, group, row) for row, asset_id in enumerate(ids)}
            self._indices[table] = index
        return self._indices[table]

    def _asset_row(
        self, table: _AssetTable, asset_id: str, columns: tuple[str, ...]
    ) -> dict[str, Any]:
        try:
            name, group, row = self._index(table)[asset_id]
        except KeyError:
            raise KeyError(f"{self.uri}: {table} has no {asset_id!r}") from None
        read = self._motion_group if table == "motions" else self._read_group
        rows: list[dict[str, Any]] = read(table, name, group, columns).slice(row, 1).to_pylist()
        return rows[0]

    def _read_group(
        self, table: _AssetTable, name: str, group: int, columns: tuple[str, ...]
    ) -> pa.Table:
        with _open_parquet(self._store.path(name), table, name) as file:
            return file.read_row_group(group, columns=list(columns))


def _open_parquet(path: Path, table: TableName, name: str) -> pq.ParquetFile:
    try:
        file = pq.ParquetFile(path)
    except (pa.ArrowInvalid, OSError) as error:
        raise ValueError(f"{name}: not a Parquet file: {error}") from error
    check_table(file.schema_arrow, table, file=name)
    return file


def _read_table(path: Path, table: TableName, name: str) -> pa.Table:
    with _open_parquet(path, table, name) as file:
        return file.read(columns=SCHEMAS[table].names)


def _read_scene(row: dict[str, Any], where: str) -> Scene:
    return Scene.from_glb(row["glb"], name=where)


def _read_navmesh(row: dict[str, Any], where: str) -> NavMesh:
    return NavMesh.from_bytes(row["navmesh"], name=where)


def _read_avatar(row: dict[str, Any], where: str) -> Avatar:
    return Avatar.from_glb(row["glb"], name=where)
