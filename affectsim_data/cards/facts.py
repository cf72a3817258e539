"""What a release's own tables say of it: counted once, used by its card, plots and Croissant."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Sequence

import pyarrow as pa

from affectsim_data.releases import Release
from affectsim_data.releases.manifest import Manifest
from affectsim_data.releases.stores import open_store
from affectsim_data.releases.tables import read_table
from affectsim_data.schemas import ASSET_TABLES, SCHEMAS, SPLITS, AssetTable, Split, TableName

__all__ = ["Facts", "Origin", "read_facts"]

EPISODE_COLUMNS = (
    *("split", "family", "challenge", "action", "emotion", "scene_id", "group_id"),
    *("motion_id", "partner_motion_id", "performer_id", "initial_distance_m"),
    *("visible_share_init", "visible_share_ref", "visible_share_mon"),
    *("d_star_1m", "d_star_3m", "d_star_5m"),
)
"""Columns of the episodes that are counted or measured."""
_SCENE_COLUMNS = ("scene_id", "rooms", "num_seats", "num_doors", "area_m2", "num_triangles")
_PROCEDURAL = "procedural"
"""How the source of motions begins that nobody performed."""


@dataclasses.dataclass(frozen=True)
class Origin:
    """Motions, scenes or bodies that were made from the same thing under the same licence."""

    table: AssetTable
    source: str
    """Corpus, dataset or generator."""
    licence: str
    count: int


@dataclasses.dataclass(frozen=True)
class Facts:
    """What there is to say of a release."""

    manifest: Manifest
    splits: tuple[Split, ...]
    """Those that hold episodes."""
    episodes: pa.Table
    """`EPISODE_COLUMNS` of all episodes."""
    scenes: pa.Table
    """What the scenes table says beside geometry."""
    cells: pa.Table
    """What was planned and composed."""
    origins: tuple[Origin, ...]
    """What the assets were made from."""

    @property
    def num_procedural(self) -> int:
        """Motions that nobody performed."""
        return self._num_motions(procedural=True)

    @property
    def num_recorded(self) -> int:
        """Motions of people."""
        return self._num_motions(procedural=False)

    def _num_motions(self, *, procedural: bool) -> int:
        motions = (one for one in self.origins if one.table == "motions")
        return sum(one.count for one in motions if one.source.startswith(_PROCEDURAL) == procedural)


def read_facts(release: Release) -> Facts:
    """Counts what a card tells.

    Raises:
        ValueError: The release is a partial copy, whose counts would pass for those of the whole.
    """
    manifest = release.manifest
    if manifest.partial_of is not None:
        raise ValueError(
            f"{release.uri}: this copy holds only {manifest.partial_of.describe()} of "
            f"{manifest.partial_of.uri}; a card describes the whole release"
        )
    splits = tuple(split for split in SPLITS if manifest.num_rows("episodes", split))
    episodes = [release.episode_table(split, EPISODE_COLUMNS) for split in splits]
    return Facts(
        manifest=manifest,
        splits=splits,
        episodes=_concatenated(episodes, "episodes", EPISODE_COLUMNS),
        scenes=_read(release, "scenes", _SCENE_COLUMNS),
        cells=_read(release, "cells", SCHEMAS["cells"].names),
        origins=tuple(origin for table in ASSET_TABLES for origin in _origins(release, table)),
    )


def _read(release: Release, table: TableName, columns: Sequence[str]) -> pa.Table:
    """Columns of a whole table."""
    store = open_store(release.uri)
    names = release.manifest.table_files(table)
    return _concatenated(
        [read_table(store, table, name, columns=columns) for name in names], table, columns
    )


def _concatenated(parts: Sequence[pa.Table], table: TableName, columns: Sequence[str]) -> pa.Table:
    schema = pa.schema([SCHEMAS[table].field(name) for name in columns])
    return pa.concat_tables([schema.empty_table(), *parts])


def _origins(release: Release, table: AssetTable) -> list[Origin]:
    """What the rows of a table of assets were made from, the most frequent first."""
    rows = _read(release, table, ["source", "licence"]).to_pylist()
    # A corpus or dataset names itself before the file: `kdae: F01_angry_03.bvh`.
    found = Counter((row["source"].partition(": ")[0], row["licence"]) for row in rows)
    ordered = sorted(found.items(), key=lambda item: (-item[1], item[0]))
    return [Origin(table, source, licence, count) for (source, licence), count in ordered]
