"""Loading from a Hub at the end of a 100 Mbit/s line, and in the order that spares scenes.

python -m benchmarks.streaming cold_start | scene_order | epoch_memory
"""

from __future__ import annotations

import functools
import gc
import itertools
import os
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from affectsim_data import AffectSimDataset
from affectsim_data.loaders import EpisodeLoader, Sample, data_loader
from affectsim_data.releases import MANIFEST_NAME, Release
from affectsim_data.releases.stores import FolderStore, HubStore
from benchmarks.parts import Rows, in_fresh_process, resident_mb, serve_part
from benchmarks.shuffling import WINDOWS, Episodes, order_name
from benchmarks.slow_hub import REPO_ID, hub_environment, slow_hub
from benchmarks.wide import wide_release_path

_BATCH = 16
_STEADY_BATCHES = 20
_SCENES_KEPT = 4
_PLAIN_BLOCK, _AWARE_BLOCK, _ROUNDS = 40, 150, 2
_MEMORY_SAMPLES = 2_000
_MEMORY_MARKS = (500, 1_000, 1_500, _MEMORY_SAMPLES)
_MEMORY_SPAN = 300
"""Samples before a mark of which the median counts: homes come and go, and some are large."""


class WatchedStore(HubStore):
    """Counts the seconds its process spends on files that are not here yet."""

    waited_s = 0.0

    def read(self, name: str) -> bytes:
        """As ever; reads of threads that fetch ahead keep nobody waiting."""
        start = time.perf_counter()
        ahead = threading.current_thread() is not threading.main_thread()
        here = ahead or self.is_local(name)
        payload = super().read(name)
        if not here:
            WatchedStore.waited_s += time.perf_counter() - start
        return payload


def stamp(sample: Sample) -> dict[str, Any]:
    """What is told of a sample by the process that drew it: a `transform`."""
    return {
        "video": sample["video"],
        "process": os.getpid(),
        "time_s": time.perf_counter(),
        "waited_s": WatchedStore.waited_s,
        "rss_mb": resident_mb(),
    }


def cold_start() -> Rows:
    """From an empty cache to the first batch, and what the workers do afterwards."""
    return [in_fresh_process(_cold_start, workers) for workers in (1, 2)]


def _cold_start(workers: int) -> dict[str, Any]:
    folder = wide_release_path()
    total = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
    with slow_hub(folder) as hub, hub_environment(hub):
        start = time.perf_counter()
        batches = _batches(_loader(Release(WatchedStore(REPO_ID, "main")), workers))
        first = next(batches)
        first_s, then = time.perf_counter() - start, hub.counts()
        steady = [first, *itertools.islice(batches, _STEADY_BATCHES)]
        num_bytes = hub.counts().bytes - then.bytes
        batches.close()
    local = _loader(Release(FolderStore(folder)), workers)
    needed = _first_batch_bytes(local)
    local_batches = _batches(local)
    local_rate = _rate(list(itertools.islice(local_batches, _STEADY_BATCHES + 1)))
    local_batches.close()
    return {
        "workers": workers,
        "first_batch_s": first_s,
        "of_that_waiting_s": float(first["waited_s"][-1]),
        "its_files_mb": needed / 1e6,
        "its_files_percent_of_release": 100.0 * needed / total,
        "fetched_by_then_mb": then.bytes / 1e6,
        "fetched_percent": 100.0 * then.bytes / total,
        "requests": then.requests,
        "waiting_percent_after_it": 100.0 * _waiting_share(steady),
        "samples_per_s": _rate(steady),
        "from_a_folder_per_s": local_rate,
        "mbit_per_s": 8e-6 * num_bytes / (_BATCH * _STEADY_BATCHES / _rate(steady)),
    }


def _loader(release: Release, workers: int) -> EpisodeLoader:
    dataset = AffectSimDataset(release, split="train", condition="p_init", transform=stamp)
    return data_loader(dataset, batch_size=_BATCH, shuffle="scenes", num_workers=workers)


def _first_batch_bytes(loader: EpisodeLoader) -> int:
    """Of all files without which the first batch cannot be had."""
    dataset = cast(AffectSimDataset, loader.dataset)
    rows = [place.row for place in next(iter(loader.batches))]
    manifest = dataset.release.manifest
    names = {*manifest.table_files("index", "train"), *dataset.release.episode_files("train", rows)}
    own = Path(dataset.source) / MANIFEST_NAME
    return own.stat().st_size + sum(manifest.files[name].bytes for name in names)


def _batches(loader: EpisodeLoader) -> Generator[dict[str, Any]]:
    """What batches are told of, and when they arrived; closing it ends the workers."""
    try:
        for batch in loader:
            del batch["video"]
            yield {**batch, "taken_s": time.perf_counter()}
    finally:
        # Workers end with the loader, and loader and iterator hold each other.
        del loader
        gc.collect()


def _rate(batches: Sequence[dict[str, Any]]) -> float:
    """Samples per second after the first batch."""
    seconds: float = batches[-1]["taken_s"] - batches[0]["taken_s"]
    return _BATCH * (len(batches) - 1) / seconds


def _waiting_share(batches: Sequence[dict[str, Any]]) -> float:
    """Share of the workers' time, after the first batch of each, in which they waited for files."""
    waited, total = 0.0, 0.0
    for process in {int(batch["process"][0]) for batch in batches}:
        own = [batch for batch in batches if int(batch["process"][0]) == process]
        waited += float(own[-1]["waited_s"][-1] - own[0]["waited_s"][-1])
        total += float(own[-1]["time_s"][-1] - own[0]["time_s"][-1])
    return waited / total


def scene_order() -> Rows:
    """Samples per second of the plain order and of scene-aware ones, with room for four scenes.

    One process draws blocks of every order in turn, so that a busy machine slows all; each order
    has a release of its own, so that none finds what another has read.
    """
    folder = wide_release_path()
    releases = [Release(FolderStore(folder), scenes_kept=_SCENES_KEPT) for _ in WINDOWS]
    datasets = [AffectSimDataset(one, split="train", condition="p_init") for one in releases]
    episodes = Episodes.of(releases[0], "train")
    orders = [episodes.order(window, epoch=0)[1] for window in WINDOWS]
    blocks = [_PLAIN_BLOCK, *[_AWARE_BLOCK] * len(WINDOWS[1:])]
    seconds = np.zeros((_ROUNDS + 1, len(orders)))
    for turn in range(_ROUNDS + 1):
        for number, (dataset, order, size) in enumerate(zip(datasets, orders, blocks, strict=True)):
            # The first turn opens the context and fills the caches.
            count = size if turn else _BATCH
            first = _BATCH + (turn - 1) * size if turn else 0
            rows = order[first : first + count]
            seconds[turn, number] = _timed(functools.partial(_draw, dataset, rows))
    rates = np.array(blocks) * _ROUNDS / seconds[1:].sum(axis=0)
    return [
        {
            "order": order_name(window),
            "samples_per_s": float(rate),
            "over_plain": float(rate / rates[0]),
            "scenes": len(np.unique(episodes.scenes)),
            "scenes_kept": _SCENES_KEPT,
        }
        for window, rate in zip(WINDOWS, rates, strict=True)
    ]


def _timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def _draw(dataset: AffectSimDataset, rows: NDArray[np.int64]) -> None:
    for row in rows:
        dataset[int(row)]


def epoch_memory() -> Rows:
    """Resident set size of a worker that streams, its cache of files smaller than the release."""
    limit = 40_000_000
    with (
        slow_hub(wide_release_path(), latency_s=0.0, bytes_per_s=0.0) as hub,
        hub_environment(hub, AFFECTSIM_CACHE_LIMIT=str(limit)),
    ):
        batches = _batches(_loader(Release(WatchedStore(REPO_ID, "main")), 1))
        sizes = []
        for batch in itertools.islice(batches, _MEMORY_SAMPLES // _BATCH):
            sizes += batch["rss_mb"].tolist()
        batches.close()
        cached = sum(p.stat().st_size for p in _cache_files())
    marks = {f"rss_mb_at_{mark}": sizes[mark - 1] for mark in _MEMORY_MARKS}
    growth = sizes[_MEMORY_MARKS[-1] - 1] - sizes[_MEMORY_MARKS[0] - 1]
    return [{"cache_limit_mb": limit / 1e6, "cache_mb": cached / 1e6, **marks, "growth_mb": growth}]


def _cache_files() -> Iterator[Path]:
    return (path for path in Path(os.environ["AFFECTSIM_CACHE"]).rglob("*") if path.is_file())


PARTS = {
    "cold_start": cold_start,
    "scene_order": scene_order,
    "epoch_memory": epoch_memory,
}

if __name__ == "__main__":
    serve_part(PARTS)
