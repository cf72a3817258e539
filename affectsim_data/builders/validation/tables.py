"""The tables of a release as validation reads them, and their columns as arrays."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.builders.recipes import Recipe
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Manifest, Release
from affectsim_data.releases.stores import Store
from affectsim_data.releases.tables import read_table
from affectsim_data.schemas import ASSET_TABLES, SCHEMAS, SPLITS, AssetTable

__all__ = ["Columns", "Tables", "read_tables"]


class Columns:
    """A table whose columns are asked for as NumPy arrays; each is converted once."""

    def __init__(self, table: pa.Table) -> None:
        self.table = table
        self._converted: dict[str, NDArray[np.object_] | FloatArray] = {}

    def __len__(self) -> int:
        return int(self.table.num_rows)

    def text(self, name: str) -> NDArray[np.object_]:
        """Strings, or `None`, `(n,)`."""
        if name not in self._converted:
            values = np.empty(len(self), object)
            values[:] = self.table.column(name).to_pylist()
            self._converted[name] = values
        return np.asarray(self._converted[name], object)

    def number(self, name: str) -> FloatArray:
        """Numbers, `nan` for null, `(n,)`."""
        if name not in self._converted:
            column = self.table.column(name).cast(pa.float64())
            self._converted[name] = column.to_numpy().astype(np.float64)
        return np.asarray(self._converted[name], np.float64)

    def point(self, name: str) -> FloatArray:
        """A point from its three columns, metres, `(n, 3)`."""
        return np.stack([self.number(f"{name}_{axis}_m") for axis in "xyz"], axis=-1)

    def where(self, mask: NDArray[np.bool_]) -> Columns:
        """The rows of which a mask `(n,)` says so."""
        return Columns(self.table.filter(pa.array(mask)))


@dataclasses.dataclass(frozen=True, eq=False)
class Tables:
    """Everything of a release but its motions, scenes and avatars themselves."""

    manifest: Manifest
    recipe: Recipe | None
    """What the manifest's `recipe_toml` says; none if it says nothing that can be read."""
    recipe_problem: str
    """Why not."""
    episodes: Columns
    """Of all splits."""
    index: Columns
    """Of the same episodes, in the same order."""
    cells: Columns
    """Of all splits."""
    assets: dict[AssetTable, Columns]
    """Rows of motions, scenes and avatars, without their payloads."""

    @functools.cached_property
    def episode_ids(self) -> NDArray[np.object_]:
        """`(n,)`."""
        return self.episodes.text("episode_id")

    def rows_of(self, table: AssetTable, ids: NDArray[np.object_]) -> NDArray[np.intp]:
        """Place of each asset in its table, `(n,)`; -1 for one that is not there, or null."""
        keys = self.assets[table].text(SCHEMAS[table].names[0])
        places = {key: place for place, key in enumerate(keys)}
        return np.array([places.get(one, -1) for one in ids], np.intp)


def read_tables(
    release: Release, store: Store, recipe: Recipe | None, recipe_problem: str
) -> Tables:
    """The tables of an opened release; `store` gives its files.

    Raises:
        ValueError: A file is not what it must be; the message names it.
        IntegrityError: Its bytes are not what the manifest promises.
    """
    manifest = store.manifest
    episodes, indices = [SCHEMAS["episodes"].empty_table()], [SCHEMAS["index"].empty_table()]
    for split in SPLITS:
        if not manifest.num_rows("index", split):
            continue
        table = release.split_table(split)
        episodes.append(table.table())
        names = manifest.table_files("index", split)
        rows = pa.concat_tables([read_table(store, "index", name) for name in names])
        indices.append(rows.take(pa.array(table.held_rows)))
    cells = [SCHEMAS["cells"].empty_table()]
    cells += [read_table(store, "cells", name) for name in manifest.table_files("cells")]
    return Tables(
        manifest,
        recipe,
        recipe_problem,
        episodes=Columns(pa.concat_tables(episodes).combine_chunks()),
        index=Columns(pa.concat_tables(indices).combine_chunks()),
        cells=Columns(pa.concat_tables(cells).combine_chunks()),
        assets={table: Columns(_asset_rows(store, table)) for table in ASSET_TABLES},
    )


def _asset_rows(store: Store, table: AssetTable) -> pa.Table:
    schema = SCHEMAS[table]
    wanted = [field.name for field in schema if field.type != pa.binary()]
    names = store.manifest.table_files(table)
    store.prefetch(names)
    parts = [pa.schema([schema.field(name) for name in wanted]).empty_table()]
    parts += [read_table(store, table, name, columns=wanted) for name in names]
    return pa.concat_tables(parts).combine_chunks()
