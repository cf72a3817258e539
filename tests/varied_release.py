"""A release of 320 episodes that differ in every column one selects by, and a store that tells.

Made of the rooms, bodies and motions of the small release; our own and free to use (CC0).
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from small_release import small_rows, write_release

from affectsim_data.releases.stores import FolderStore
from affectsim_data.schemas import CHALLENGES, SPLITS

__all__ = ["COUNTS", "RemoteStore", "varied_rows", "write_varied_release"]

COUNTS = {"train": 300, "validation": 12, "test": 8}
"""Episodes by split: the first has two shards."""


@functools.cache
def varied_rows(split: str) -> list[dict[str, Any]]:
    """Rows of the episodes of a split."""
    tables = small_rows()
    motions = tables["motions"]
    rng = np.random.default_rng([3, SPLITS.index(split)])
    rows = []
    for number in range(COUNTS[split]):
        motion = motions[int(rng.integers(len(motions)))]
        nearest = float(rng.uniform(0.5, 3.0)) if rng.random() < 0.7 else None
        rows.append(
            {
                **tables["episodes"][0],
                "episode_id": f"varied/{split}-{number:04d}",
                "split": split,
                "group_id": f"group-{split}",
                "scene_id": ("empty_room", "crate_room")[int(rng.integers(2))],
                "challenge": [*CHALLENGES, None][int(rng.integers(5))],
                **{name: motion[name] for name in ("motion_id", "performer_id", "duration_s")},
                **{name: motion[name] for name in ("emotion", "action")},
                "phase_s": float(rng.uniform(0.0, 1.9)),
                "initial_distance_m": float(rng.integers(2, 7)),
                "d_star_3m": nearest,
                "d_star_3m_null": None if nearest is not None else "empty",
                "seed": int(rng.integers(3)),
            }
        )
    return rows


def write_varied_release(out: Path, *, seed: int = 7) -> None:
    """Writes the release into a folder."""
    episodes = [row for split in SPLITS for row in varied_rows(split)]
    write_release(out, rows={**small_rows(), "episodes": episodes}, seed=seed)


class RemoteStore:
    """Passes for a release on a network; notes what it is asked for."""

    def __init__(self, folder: Path) -> None:
        self._folder = FolderStore(folder)
        self.manifest = self._folder.manifest
        self.uri = "hf://datasets/org/varied@0123456"
        self.read_names: list[str] = []
        self.prefetched: list[list[str]] = []

    def read(self, name: str) -> bytes:
        """Contents of a file."""
        self.read_names.append(name)
        return self._folder.read(name)

    def prefetch(self, names: Iterable[str]) -> None:
        """Notes the names."""
        self.prefetched.append(list(names))

    def is_local(self, name: str) -> bool:
        """Never."""
        return False
