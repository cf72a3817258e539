"""What comes in from a run over episodes, and in which order they are given out."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from tqdm import tqdm

from affectsim_data.releases.splits import dictionary_codes
from affectsim_data.simulation.acting import Job
from affectsim_data.simulation.journal import RunJournal
from affectsim_data.simulation.recording import EpisodeRecord

__all__ = ["Intake", "episode_ids", "work_units"]

_LARGEST_UNIT = 4
"""Episodes that a process is given at once: a kill loses that many per process at most."""


class Intake:
    """The records of a run as they come in."""

    def __init__(
        self,
        out: Path,
        job: Job,
        rows: NDArray[np.int64],
        journal: RunJournal,
        *,
        progress: bool,
    ) -> None:
        """Nothing has come in yet but what the journal has.

        Args:
            out: The table that is written in the end.
            job: What is run.
            rows: Of the episodes in the split, `(n,)`.
            journal: Keeps what comes in.
            progress: Show a bar.
        """
        self._out, self._job, self._rows, self._journal = out, job, rows, journal
        self._progress = progress
        self._ids = episode_ids(job, rows)
        self._scenes, self._placements = (
            dictionary_codes(job.episodes.index.column(name))[0][rows]
            for name in ("scene_id", "placement_id")
        )
        self.num_new = 0
        """Records that came in, beyond those of the journal."""

    def units(self, jobs: int) -> list[tuple[int, ...]]:
        """Places of the episodes that are left, as `work_units`."""
        left = np.array([one not in self._journal.records for one in self._ids], bool)
        return work_units(self._rows[left], self._scenes[left], self._placements[left], jobs=jobs)

    def take(self, results: Iterator[list[EpisodeRecord]]) -> None:
        """Takes in unit after unit; says what is kept if that does not come to its end."""
        total, before = len(self._ids), self._num_done()
        if before:
            self._say(f"going on; {before:,} of {total:,} episodes are done")
        bar = tqdm(
            total=total,
            initial=before,
            desc=self._job.name,
            unit="episode",
            disable=not self._progress,
        )
        failed = 0
        try:
            with bar:
                for records in results:
                    for record in records:
                        self._journal.add(record)
                        failed += record.ending == "failed"
                    self.num_new += len(records)
                    bar.set_postfix(failed=failed, refresh=False)
                    bar.update(len(records))
        except BaseException:
            if self._num_done():
                self._say(
                    f"{self._num_done():,} of {total:,} episodes are done, kept in "
                    f"{self._journal.path.name}; without overwrite the same run goes on from there"
                )
            raise

    def _num_done(self) -> int:
        return sum(one in self._journal.records for one in self._ids)

    def _say(self, text: str) -> None:
        if self._progress:
            print(f"affectsim: {self._out}: {text}", file=sys.stderr)

    def in_order(self) -> list[EpisodeRecord]:
        """All of them, in the order of the split."""
        return [self._journal.records[one] for one in self._ids]


def work_units(
    rows: NDArray[np.int64],
    scenes: NDArray[np.int64],
    placements: NDArray[np.int64],
    *,
    jobs: int,
) -> list[tuple[int, ...]]:
    """Episodes scene by scene, some at a time.

    In a scene those that begin at the same place follow each other: what is seen of the scene from
    there need not be drawn again.

    Args:
        rows: Of the episodes in their split, `(n,)`.
        scenes: A number for the scene of each, `(n,)`.
        placements: A number for where each begins, `(n,)`.
        jobs: Processes that share them.
    """
    ordered = rows[np.lexsort((placements, scenes))].tolist()
    # Small where few are left: every process shall have some of them.
    size = min(_LARGEST_UNIT, max(1, math.ceil(len(ordered) / (2 * jobs))))
    return [tuple(ordered[at : at + size]) for at in range(0, len(ordered), size)]


def episode_ids(job: Job, rows: NDArray[np.int64]) -> list[str]:
    """Of the episodes at some rows of the split."""
    ids: list[str] = job.episodes.index.column("episode_id").take(pa.array(rows)).to_pylist()
    return ids
