"""Writes a release: Parquet shards and the manifest, all or nothing, the same bytes every time."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import TracebackType
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Robot
from affectsim_data.releases.manifest import (
    MANIFEST_NAME,
    FileEntry,
    Manifest,
    Source,
    sha256_of,
)
from affectsim_data.schemas import ASSET_TABLES, SCHEMAS, TableName

__all__ = ["ReleaseWriter"]

MAX_SHARD_BYTES = 64 << 20
_EPISODES_PER_SHARD = 256
_COMPRESSION, _COMPRESSION_OF_AVATARS = 6, 19
"""Levels of zstd. All are as quick to read; 6 makes files a tenth smaller than its default of 1,
more costs far more time. Avatars are few, and every first batch waits for them."""
_MAX_ASSET_SHARDS = 2048
"""Assets get a file each, so that one item is one fetch; beyond this many they share files."""


_SYNCED_AT_ONCE = 16


class ReleaseWriter:
    """Collects tables in a hidden folder beside `out` and puts it in place when all is written.

    Used as a context manager: leaving it by an exception leaves nothing behind.
    """

    def __init__(self, out: Path, *, overwrite: bool = False, staging: Path | None = None) -> None:
        """Checks the place.

        Args:
            out: Folder of the release.
            overwrite: Whether it may hold a release already.
            staging: Folder to write in, on the same file system; one beside `out` if not given.

        Raises:
            FileExistsError: `out` exists, is not empty and `overwrite` is not set, or it is
                something other than a release.
        """
        out = out.resolve()
        self._out = out
        self._staging = staging or out.parent / f".{out.name}.partial"
        if out.exists() and any(out.iterdir() if out.is_dir() else [out]):
            if not (out / MANIFEST_NAME).is_file():
                raise FileExistsError(f"{out}: exists and is no release; choose another --out")
            if not overwrite:
                raise FileExistsError(f"{out}: holds a release already; add --overwrite")
        self._files: dict[str, FileEntry] = {}

    def __enter__(self) -> ReleaseWriter:
        self._out.parent.mkdir(parents=True, exist_ok=True)
        shutil.rmtree(self._staging, ignore_errors=True)
        self._staging.mkdir(parents=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        shutil.rmtree(self._staging, ignore_errors=True)

    def add_table(
        self, table: TableName, rows: Sequence[Mapping[str, Any]] | pa.Table, *, stem: str = ""
    ) -> None:
        """Writes rows as shards `TABLE/STEM-00000-of-00001.parquet`, each at most 64 MB of data.

        A file is what a reader fetches: an episodes shard holds a few hundred rows, an asset has a
        file of its own. Episodes also get their index.
        """
        count = len(rows)
        if isinstance(rows, pa.Table):
            _check_columns(table, rows)
            self._add_shards(table, _slices(rows, _shard_rows(table, count)), stem=stem)
        else:
            self._add_shards(table, _shards(table, rows, _shard_rows(table, count)), stem=stem)
        if table == "episodes":
            names = SCHEMAS["index"].names
            short: Sequence[Mapping[str, Any]] | pa.Table
            if isinstance(rows, pa.Table):
                short = rows.select(names).cast(SCHEMAS["index"])
            else:
                short = [{name: row[name] for name in names} for row in rows]
            self.add_table("index", short, stem=stem)

    def add_assets(
        self, table: TableName, items: Iterable[pa.Table], *, count: int, stem: str = ""
    ) -> None:
        """Writes a table whose rows come one by one, so that never many are in memory.

        Args:
            table: Which.
            items: An Arrow table of one row each.
            count: How many there are.
            stem: First part of the files' names, the table's own if empty.
        """
        self._add_shards(table, _joined(table, items, _shard_rows(table, count)), stem=stem)

    def _add_shards(self, table: TableName, shards: Iterable[pa.Table], *, stem: str) -> None:
        """Writes shards as they come; their names tell how many there are, so they come last."""
        folder = self._staging / table
        folder.mkdir(exist_ok=True)
        written: list[FileEntry] = []
        for number, shard in enumerate(shards):
            path = folder / f".{number}"
            is_asset = table in ASSET_TABLES
            # Minima and maxima of binary columns are their whole values, and help nobody.
            level = _COMPRESSION_OF_AVATARS if table == "avatars" else _COMPRESSION
            options = {"row_group_size": 1, "write_statistics": False} if is_asset else {}
            pq.write_table(shard, path, compression="zstd", compression_level=level, **options)
            keys = tuple(shard.column(0).to_pylist()) if is_asset else ()
            entry = FileEntry(path.stat().st_size, sha256_of(path), shard.num_rows, keys)
            written.append(entry)
        for number, entry in enumerate(written):
            name = f"{table}/{stem or table}-{number:05d}-of-{len(written):05d}.parquet"
            os.replace(folder / f".{number}", self._staging / name)
            self._files[name] = entry

    def finish(
        self,
        *,
        name: str,
        recipe: str,
        seed: int,
        code_version: str,
        camera: Camera,
        robot: Robot,
        licences: Sequence[str],
        redistribution: bool = True,
        sources: Sequence[Source] = (),
        recipe_toml: str = "",
        dress: Callable[[Path], None] = lambda _: None,
    ) -> Manifest:
        """Writes the manifest and moves the release into place.

        `redistribution` says whether what is inside may be passed on; `dress` is called with the
        folder of the whole release before it is moved, to put a card into it; the rest is in
        `Manifest`.
        """
        manifest = Manifest(
            name=name,
            recipe=recipe,
            seed=seed,
            code_version=code_version,
            camera=camera,
            robot=robot,
            files=dict(sorted(self._files.items())),
            licences=tuple(licences),
            redistribution=redistribution,
            sources=tuple(sources),
            recipe_toml=recipe_toml,
        )
        path = self._staging / MANIFEST_NAME
        path.write_text(manifest.to_json(), encoding="utf-8")
        dress(self._staging)
        # Many at once: a disk makes hardly more of many than of one.
        with ThreadPoolExecutor(_SYNCED_AT_ONCE) as pool:
            list(pool.map(_sync, self._staging.rglob("*")))
        old = self._out.parent / f".{self._out.name}.old"
        shutil.rmtree(old, ignore_errors=True)
        with contextlib.suppress(FileNotFoundError):
            os.replace(self._out, old)
        try:
            os.replace(self._staging, self._out)
        except OSError:
            if old.exists():
                os.replace(old, self._out)
            raise
        shutil.rmtree(old, ignore_errors=True)
        return manifest


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _shard_rows(table: TableName, num_rows: int) -> int:
    """Rows of a shard at most."""
    if table == "episodes":
        return _EPISODES_PER_SHARD
    return max(1, -(-num_rows // _MAX_ASSET_SHARDS) if table in ASSET_TABLES else num_rows)


def _shards(
    table: TableName, rows: Sequence[Mapping[str, Any]], max_rows: int
) -> Iterator[pa.Table]:
    """Arrow tables of at most `MAX_SHARD_BYTES` and `max_rows` each, at least one row each."""
    start, total = 0, 0
    for index, row in enumerate(rows):
        size = sum(len(value) for value in row.values() if isinstance(value, bytes | str))
        full = index - start >= max_rows or total + size > MAX_SHARD_BYTES
        if index > start and full:
            yield _arrow(table, rows[start:index])
            start, total = index, 0
        total += size
    yield _arrow(table, rows[start:])


def _slices(rows: pa.Table, max_rows: int) -> Iterator[pa.Table]:
    """The same of an Arrow table; shards too large are halved."""
    for start in range(0, max(1, rows.num_rows), max_rows):
        part = rows.slice(start, max_rows)
        if part.nbytes > MAX_SHARD_BYTES and part.num_rows > 1:
            yield from _slices(part, -(-part.num_rows // 2))
        else:
            yield part.combine_chunks()


def _joined(table: TableName, items: Iterable[pa.Table], max_rows: int) -> Iterator[pa.Table]:
    """The same of Arrow tables of a row each."""
    parts: list[pa.Table] = []
    total = 0
    for item in items:
        _check_columns(table, item)
        if parts and (len(parts) >= max_rows or total + item.nbytes > MAX_SHARD_BYTES):
            yield pa.concat_tables(parts).combine_chunks()
            parts, total = [], 0
        parts.append(item)
        total += item.nbytes
    yield pa.concat_tables(parts or [SCHEMAS[table].empty_table()]).combine_chunks()


def _check_columns(table: TableName, rows: pa.Table) -> None:
    if not rows.schema.equals(SCHEMAS[table], check_metadata=True):
        raise ValueError(f"{table}: expected columns {SCHEMAS[table]}, got {rows.schema}")


def _arrow(table: TableName, rows: Sequence[Mapping[str, Any]]) -> pa.Table:
    schema = SCHEMAS[table]
    for row in rows:
        # Arrow would drop columns it does not know and fill the others with nulls.
        unknown = sorted(row.keys() - set(schema.names))
        missing = [f.name for f in schema if not f.nullable and row.get(f.name) is None]
        if unknown or missing:
            raise ValueError(
                f"{table} {row.get(schema.names[0])!r}: unknown columns {unknown}, "
                f"columns missing or null {missing}"
            )
    return pa.Table.from_pylist([dict(row) for row in rows], schema=schema)
