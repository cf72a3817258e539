"""Samples per second against decoding the same clips, start-up times, and memory over a long run.

Every part runs in a process of its own, so that none warms another; the parts that are compared
share one process and one core.
"""

from __future__ import annotations

import functools
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.parts import Rows, resident_mb, serve_part

_ROUNDS = 3
_EPISODES = 20
_SAMPLES = 2_000


def throughput() -> Rows:
    """`AffectSimDataset` against PyAV on one core: 8 x 224 x 224, the same clips, interleaved."""
    from affectsim_data import AffectSimDataset, Orbit

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        # Uploads every scene, and draws no background that is measured below.
        uploads = AffectSimDataset(split="test", condition=Orbit(distance_m=2.5))
        for index in range(len(uploads)):
            uploads[index]
        for condition in ("p_init", "p_ref"):
            dataset = AffectSimDataset(split="test", condition=condition)
            count = min(_EPISODES, len(dataset))
            start = time.perf_counter()
            wanted = [dataset[index]["frame_indices"].tolist() for index in range(count)]
            first_pass = count / (time.perf_counter() - start)
            full = AffectSimDataset(split="test", condition=condition, clip="full")
            paths = [Path(folder) / f"{condition}_{i}.mp4" for i in range(count)]
            seconds = []
            for index, path in enumerate(paths):
                clip = full[index]["video"].permute(0, 2, 3, 1).numpy()
                seconds.append(len(clip) / 30.0)
                _encode(clip, path)
            work: dict[str, Callable[[int], Any]] = {
                "render": dataset.__getitem__,
                "decode": functools.partial(_decode_numbered, _decode, paths, wanted),
                "seek": functools.partial(_decode_numbered, _seek, paths, wanted),
            }
            times: dict[str, list[float]] = {name: [] for name in work}
            for _ in range(_ROUNDS):
                for name, one in work.items():
                    times[name].append(_timed(one, count))
            best = {name: count / min(values) for name, values in times.items()}
            peer = max(best["decode"], best["seek"])
            rows.append(
                {
                    "condition": condition,
                    "samples_per_s": best["render"],
                    "first_pass_per_s": first_pass,
                    "pyav_sequential_per_s": best["decode"],
                    "pyav_seeking_per_s": best["seek"],
                    "ratio": best["render"] / peer,
                    "first_pass_ratio": first_pass / peer,
                    "clips": count,
                    "mean_clip_s": float(np.mean(seconds)),
                }
            )
    return rows


def _timed(work: Callable[[int], Any], count: int) -> float:
    start = time.perf_counter()
    for index in range(count):
        work(index)
    return time.perf_counter() - start


def _decode_numbered(
    decode: Callable[[Path, list[int]], np.ndarray],
    paths: list[Path],
    wanted: list[list[int]],
    index: int,
) -> np.ndarray:
    return decode(paths[index], wanted[index])


def _encode(clip: np.ndarray, path: Path) -> None:
    import av

    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30, options={"crf": "20"})
        stream.width, stream.height, stream.pix_fmt = clip.shape[2], clip.shape[1], "yuv420p"
        for image in clip:
            container.mux(stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")))
        container.mux(stream.encode(None))


def _decode(path: Path, wanted: list[int]) -> np.ndarray:
    """Decodes from the start and keeps the wanted frames: all there is for one long GOP."""
    import av

    images, places = [], set(wanted)
    with av.open(str(path)) as container:
        for index, frame in enumerate(container.decode(video=0)):
            if index in places:
                images.append(frame.to_ndarray(format="rgb24"))
    return np.stack(images)


def _seek(path: Path, wanted: list[int]) -> np.ndarray:
    """Seeks to the key frame before each wanted frame."""
    import av

    images = []
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        for index in wanted:
            container.seek(round(index / 30.0 / float(stream.time_base or 1)), stream=stream)
            for frame in container.decode(stream):
                if frame.time is not None and frame.time >= (index - 0.5) / 30.0:
                    images.append(frame.to_ndarray(format="rgb24"))
                    break
    return np.stack(images)


def memory() -> Rows:
    """Resident set size after 200 and after 2,000 samples of mixed conditions."""
    from affectsim_data import AffectSimDataset

    datasets = [AffectSimDataset(split="test", condition=c) for c in ("p_init", "p_ref", "p_mon")]
    rng = np.random.default_rng(0)
    sizes = {}
    for number in range(1, _SAMPLES + 1):
        dataset = datasets[number % len(datasets)]
        dataset[int(rng.integers(len(dataset)))]
        if number in (200, _SAMPLES):
            sizes[number] = resident_mb()
    return [
        {
            "rss_mb_at_200": sizes[200],
            "rss_mb_at_2000": sizes[_SAMPLES],
            "growth_mb": sizes[_SAMPLES] - sizes[200],
        }
    ]


_FIRST_SAMPLE = (
    "from affectsim_data import AffectSimDataset;"
    "AffectSimDataset(split='test', condition='p_ref')[0]"
)


def startup() -> Rows:
    """Seconds to import the package, and to the first sample of a fresh process."""
    imports = [_run("import affectsim_data") - _run("pass") for _ in range(5)]
    with tempfile.TemporaryDirectory() as folder:
        cold = _run(_FIRST_SAMPLE, AFFECTSIM_CACHE=folder)
        warm = [_run(_FIRST_SAMPLE, AFFECTSIM_CACHE=folder) for _ in range(3)]
    return [
        {
            "import_s": sorted(imports)[len(imports) // 2],
            "first_sample_cold_s": cold,
            "first_sample_warm_s": sorted(warm)[1],
        }
    ]


def _run(code: str, **environment: str) -> float:
    start = time.perf_counter()
    subprocess.run(
        [sys.executable, "-c", code], check=True, env={**os.environ, **environment}, stderr=None
    )
    return time.perf_counter() - start


PARTS = {"throughput": throughput, "memory": memory, "startup": startup}

if __name__ == "__main__":
    serve_part(PARTS)
