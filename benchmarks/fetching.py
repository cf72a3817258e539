"""Assets from a Hub at the end of a slow line: a file each, or ranges of shards.

python -m benchmarks.fetching fetching
"""

from __future__ import annotations

import itertools
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.releases import Manifest
from affectsim_data.releases.stores import FolderStore, HubStore
from benchmarks.parts import Rows, in_fresh_process, serve_part
from benchmarks.slow_hub import REPO_ID, hub_environment, slow_hub
from benchmarks.wide import wide_release_path

__all__ = ["PARTS"]

_SCENES, _MOTIONS = 4, 64
_THREADS = 8


def fetching() -> Rows:
    """The same scenes and motions by several ways, each from an empty cache; seconds, MB, requests.

    Range reads get what they are made for: all scenes in one shard, all motions in another, one
    row per row group.
    """
    with tempfile.TemporaryDirectory() as folder:
        served, release = Path(folder), wide_release_path()
        for path in release.iterdir():
            (served / path.name).symlink_to(path)
        names, needed = _wanted_assets(FolderStore(release).manifest)
        _write_shards(served)
        rows = []
        for way, fetch in _WAYS.items():
            with slow_hub(served) as hub, hub_environment(hub):
                seconds = in_fresh_process(fetch, names)
                counts = hub.counts()
            row = {"way": way, "seconds": seconds, "mb": counts.bytes / 1e6}
            rows.append({**row, "mb_needed": needed / 1e6, "requests": counts.requests})
    return rows


def _wanted_assets(manifest: Manifest) -> tuple[list[str], int]:
    """Files of scenes and motions spread over the release, and their bytes."""
    names = []
    for table, count in (("scenes", _SCENES), ("motions", _MOTIONS)):
        files = manifest.table_files(table)
        names += [files[place * len(files) // count] for place in range(count)]
    return names, sum(manifest.files[name].bytes for name in names)


def _write_shards(root: Path) -> None:
    for table in ("scenes", "motions"):
        parts = [pq.read_table(path) for path in sorted((root / table).glob("*.parquet"))]
        out = root / "shards" / f"{table}.parquet"
        out.parent.mkdir(exist_ok=True)
        options = {"row_group_size": 1, "write_statistics": False, "compression": "zstd"}
        pq.write_table(pa.concat_tables(parts), out, **options)


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _by_store(names: list[str]) -> float:
    """As a release does: all announced, then read one after the other; the manifest included."""

    def read() -> None:
        store = HubStore(REPO_ID, "main")
        store.prefetch(names)
        for name in names:
            store.read(name)

    return _timed(read)


def _by_store_unannounced(names: list[str]) -> float:
    def read() -> None:
        store = HubStore(REPO_ID, "main")
        for name in names:
            store.read(name)

    return _timed(read)


def _by_download(names: list[str], *, threads: int = 1) -> float:
    from huggingface_hub import hf_hub_download

    def read(name: str) -> bytes:
        return Path(hf_hub_download(REPO_ID, name, repo_type="dataset")).read_bytes()

    with ThreadPoolExecutor(threads) as pool:
        return _timed(lambda: list(pool.map(read, names)))


def _by_download_threads(names: list[str]) -> float:
    return _by_download(names, threads=_THREADS)


def _by_ranges(names: list[str], *, threads: int = 1, **options: Any) -> float:
    from huggingface_hub import HfFileSystem

    system = HfFileSystem()

    def read(names: Sequence[str]) -> None:
        for table, group in itertools.groupby(names, lambda name: name.split("/")[0]):
            path = f"datasets/{REPO_ID}/shards/{table}.parquet"
            with system.open(path, "rb", **options) as source:
                file = pq.ParquetFile(source, pre_buffer=True)
                for name in group:
                    file.read_row_group(int(name.split("-")[1]))

    shares = [names[first::threads] for first in range(threads)]
    with ThreadPoolExecutor(threads) as pool:
        return _timed(lambda: list(pool.map(read, shares)))


def _by_ranges_exact(names: list[str]) -> float:
    return _by_ranges(names, cache_type="none")


def _by_ranges_threads(names: list[str]) -> float:
    return _by_ranges(names, threads=_THREADS, cache_type="none")


_WAYS: dict[str, Callable[[list[str]], float]] = {
    "our store, announced": _by_store,
    "our store, unannounced": _by_store_unannounced,
    "hf_hub_download": _by_download,
    f"hf_hub_download, {_THREADS} threads": _by_download_threads,
    "ranges, default read-ahead": _by_ranges,
    "ranges, no read-ahead": _by_ranges_exact,
    f"ranges, no read-ahead, {_THREADS} threads": _by_ranges_threads,
}

PARTS = {"fetching": fetching}

if __name__ == "__main__":
    serve_part(PARTS)
