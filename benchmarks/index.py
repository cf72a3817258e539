"""What an index of 27,647 episodes costs: to open, to hold, to read from, to make into specs.

Every part runs in a process of its own, on one core; rates are per second of that core's time.
Nothing is drawn.

python -m benchmarks.index
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from benchmarks.parts import Rows, resident_mb, run_part, serve_part
from benchmarks.wide import wide_release_path

_SPECS, _SCENES = 200, 4
_ROUNDS = 5


def opening() -> Rows:
    """Milliseconds to open datasets of the wide release, everything imported before."""
    from affectsim_data import AffectSimDataset
    from affectsim_data.schemas import SPLITS

    folder = wide_release_path()
    AffectSimDataset(split="test", filter=[("visible_share_init", ">=", 0.0)])
    near: list[tuple[str, str, Any]] = [("initial_distance_m", "<", 4.0)]
    sad: list[tuple[str, str, Any]] = [("emotion", "in", ["sad", "angry"])]
    cases: dict[str, Callable[[], Any]] = {
        "train": lambda: AffectSimDataset(folder, split="train"),
        "all three splits": lambda: [AffectSimDataset(folder, split=split) for split in SPLITS],
        "train, fingerprint": lambda: AffectSimDataset(folder, split="train").fingerprint,
        "train, scene codes": lambda: AffectSimDataset(folder, split="train").scene_codes,
        "train, by emotion": lambda: AffectSimDataset(folder, split="train", filter=sad),
        "train, by distance": lambda: AffectSimDataset(folder, split="train", filter=near),
    }
    rows = []
    for name, make in cases.items():
        times = [_timed(make, clock=time.perf_counter) for _ in range(_ROUNDS)]
        rows.append({"opened": name, "first_ms": 1e3 * times[0], "best_ms": 1e3 * min(times)})
    return rows


def episodes() -> Rows:
    """Episodes per second in random order, and what holding all of them takes."""
    from affectsim_data import AffectSimDataset
    from affectsim_data.schemas import SPLITS

    AffectSimDataset(split="test", images=False).episode(0)  # a worker that has read nothing wide
    before = resident_mb()
    datasets = [AffectSimDataset(wide_release_path(), split=split) for split in SPLITS]
    opened = resident_mb()
    asked = [(dataset, row) for dataset in datasets for row in range(len(dataset))]
    order = np.random.default_rng(0).permutation(len(asked))

    def touch() -> None:
        for place in order:
            dataset, row = asked[place]
            dataset.episode(row)

    seconds = [_timed(touch) for _ in range(3)]
    return [
        {
            "episodes": len(asked),
            "first_pass_per_s": len(asked) / seconds[0],
            "later_per_s": len(asked) / min(seconds[1:]),
            "opened_mb": opened - before,
            "touched_mb": resident_mb() - before,
        }
    ]


def specs() -> Rows:
    """Specifications per second of 8-frame clips, people posed, nothing drawn; assets at hand."""
    from affectsim_data import AffectSimDataset, Orbit
    from affectsim_data.loaders import clip_spec

    rows = []
    for condition in ("p_init", "p_ref", "p_mon", Orbit(distance_m=2.0)):
        dataset = AffectSimDataset(wide_release_path(), split="test", condition=condition)
        near = np.flatnonzero(dataset.scene_codes < _SCENES)[:_SPECS].tolist()
        pairs = [(dataset.episode(row), dataset.world(row)) for row in near]

        def make(
            pairs: Sequence[tuple[Any, Any]] = pairs, dataset: AffectSimDataset = dataset
        ) -> None:
            for episode, world in pairs:
                clip_spec(episode, world, dataset.condition, dataset.clip)

        best = min(_timed(make) for _ in range(_ROUNDS))
        rows.append(
            {
                "condition": dataset.condition.name,
                "specs_per_s": len(pairs) / best,
                "spec_us": 1e6 * best / len(pairs),
            }
        )
    return rows


def _timed(work: Callable[[], Any], *, clock: Callable[[], float] = time.process_time) -> float:
    """Seconds; of this process's own time on the core unless another clock is given."""
    start = clock()
    work()
    return clock() - start


PARTS = {"opening": opening, "episodes": episodes, "specs": specs}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        wide_release_path()
        results = {name: run_part("benchmarks.index", name, cores=1) for name in PARTS}
        print(json.dumps(results, indent=2))
