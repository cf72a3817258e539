"""Runs a policy over the episodes of a split: a trajectory table, whatever happens on the way."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray
from tqdm import tqdm

from affectsim_data.engines import EngineName, open_engine
from affectsim_data.engines.code import code_fingerprint
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.joined_splits import split_title
from affectsim_data.releases.journals import journal_path
from affectsim_data.releases.recorded import sha256_without_trajectories
from affectsim_data.releases.selection import select_rows
from affectsim_data.releases.splits import SplitBy, dictionary_codes
from affectsim_data.simulation.acting import Job
from affectsim_data.simulation.finished import finished_run, run_metadata
from affectsim_data.simulation.journal import RunHeader, RunJournal, open_run_journal
from affectsim_data.simulation.policies.opening import open_policy
from affectsim_data.simulation.recording import (
    Ending,
    EpisodeRecord,
    write_failures,
    write_records,
)
from affectsim_data.simulation.supervising import EpisodeProcess

__all__ = ["DEFAULT_POLICY_TIME_S", "AcquireRun", "acquire"]

DEFAULT_POLICY_TIME_S = 60.0
"""What a policy may take in an episode: some 0.1 s an action."""
_LARGEST_UNIT = 4
"""Episodes that a process is given at once: a kill loses that many per process at most."""
_PRELOADED = "affectsim_data.simulation.acquiring"

_process: EpisodeProcess | None = None
"""That of the latest job in this process; kept, so that it keeps its scenes."""


@dataclasses.dataclass(frozen=True)
class AcquireRun:
    """What became of a run."""

    path: Path
    """The table."""
    num_episodes: int
    num_new: int
    """Acted in by this run; the rest had been before."""
    endings: dict[Ending, int]
    """How many episodes ended how."""
    failures: tuple[EpisodeRecord, ...]
    """Those in which the policy failed."""
    failures_path: Path | None
    """The file that says why, if there is one."""
    elapsed_s: float
    """Time it took."""


def acquire(
    release: Release,
    policy: str,
    out: str | Path,
    *,
    split: str = "test",
    split_by: SplitBy = "group",
    filter: Filter | None = None,
    limit: int | None = None,
    seed: int = 0,
    jobs: int | None = None,
    engine: EngineName = "local",
    ray_address: str | None = None,
    max_policy_time_s: float = DEFAULT_POLICY_TIME_S,
    overwrite: bool = False,
    progress: bool = True,
) -> AcquireRun:
    """Has a policy act in every episode of a split, and writes its trajectory table.

    The same release, policy and seed give the same bytes, with any number of processes. Finished
    episodes are on disk at once, in `OUT.partial.jsonl`; the same call goes on from there, and has
    nothing to do where the table is finished. Where the policy raises, takes too long or returns
    nonsense, its episode ends without a handoff, and `OUT.failures.jsonl` says why.

    Args:
        release: Whose episodes.
        policy: As `open_policy` takes it.
        out: The table, `.parquet`.
        split: `train`, `validation` or `test`.
        split_by: What it is split by.
        filter: Only episodes whose columns match.
        limit: Only so many episodes, the first ones.
        seed: Of whatever a policy does at random.
        jobs: Processes; one per core if not given.
        engine: `local`, or `ray`.
        ray_address: Of a Ray cluster.
        max_policy_time_s: What the policy may take in an episode; drawing is not counted.
        overwrite: Whether to begin anew, and to replace a table that is there.
        progress: Whether to show a bar and say what was found, on stderr.

    Raises:
        FileExistsError: `out` is there already, and no run has made it.
        BlockingIOError: Another process acquires into it.
        ValueError: No such policy, split or engine, no episode; the journal or the table is of
            another run.
    """
    started = time.perf_counter()
    out = Path(out)
    _check(out, limit=limit, seed=seed, max_policy_time_s=max_policy_time_s)
    name = open_policy(policy).name
    job = Job(release, split, split_by, policy, name, seed, max_policy_time_s)
    rows = select_rows(release, split, split_by=split_by, filter=filter)[:limit]
    ids, header, num_jobs = _ids(job, rows), _header(job), _num_jobs(jobs)
    if out.exists() and not overwrite and not journal_path(out).exists():
        done = finished_run(out, header, ids)
        elapsed_s = time.perf_counter() - started
        return AcquireRun(
            out, len(ids), 0, done.endings, done.failures, done.failures_path, elapsed_s
        )
    with open_run_journal(out, header, anew=overwrite) as journal:
        run = _Run(out, job, rows, journal, progress=progress)
        # Opened even with nothing left to do: arguments are checked all the same.
        with open_engine(engine, jobs=jobs, address=ray_address, preload=_PRELOADED) as workers:
            try:
                task = functools.partial(_act_in_episodes, job)
                run.take(records for _, records in workers.run(task, run.units(num_jobs)))
            finally:
                _end_process()
        records = run.in_order()
        failures = write_failures(out, records)
        write_records(out, records, run_metadata(header, records))
        journal.remove()
    return AcquireRun(
        out,
        num_episodes=len(records),
        num_new=run.num_new,
        endings=dict(Counter(record.ending for record in records)),
        failures=tuple(record for record in records if record.ending == "failed"),
        failures_path=failures,
        elapsed_s=time.perf_counter() - started,
    )


def _act_in_episodes(job: Job, places: Sequence[int]) -> list[EpisodeRecord]:
    """What became of some episodes of a split; called in any process."""
    global _process
    if _process is None or _process.job is not job:
        _end_process()
        _process = EpisodeProcess(job)
    return [_process.record(place) for place in places]


def _end_process() -> None:
    global _process
    if _process is not None:
        _process.close()
    _process = None


class _Run:
    """Records as they come in."""

    def __init__(
        self,
        out: Path,
        job: Job,
        rows: NDArray[np.int64],
        journal: RunJournal,
        *,
        progress: bool,
    ) -> None:
        self._out, self._job, self._rows, self._journal = out, job, rows, journal
        self._progress = progress
        self._ids = _ids(job, rows)
        self._scenes, self._placements = (
            dictionary_codes(job.episodes.index.column(name))[0][rows]
            for name in ("scene_id", "placement_id")
        )
        self.num_new = 0

    def units(self, jobs: int) -> list[tuple[int, ...]]:
        """Places of the episodes that are left, scene by scene, some at a time.

        In a scene those that begin at the same place follow each other: what is seen of the scene
        from there need not be drawn again.
        """
        done = np.array([one in self._journal.records for one in self._ids], bool)
        order = np.lexsort((self._placements, self._scenes))
        left = self._rows[order[~done[order]]].tolist()
        # Small where few are left: every process shall have some of them.
        size = min(_LARGEST_UNIT, max(1, math.ceil(len(left) / (2 * jobs))))
        return [tuple(left[at : at + size]) for at in range(0, len(left), size)]

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


def _ids(job: Job, rows: NDArray[np.int64]) -> list[str]:
    """Of the episodes at some rows of the split."""
    ids: list[str] = job.episodes.index.column("episode_id").take(pa.array(rows)).to_pylist()
    return ids


def _header(job: Job) -> RunHeader:
    return RunHeader(
        policy=job.name,
        release=job.release.uri,
        release_sha256=sha256_without_trajectories(job.release),
        split=split_title(job.split, job.split_by),
        seed=job.seed,
        max_policy_time_s=job.max_policy_time_s,
        code=code_fingerprint(),
    )


def _num_jobs(jobs: int | None) -> int:
    number = (os.cpu_count() or 1) if jobs is None else jobs
    if number < 1:
        raise ValueError(f"jobs must be at least 1, got {number}")
    return number


def _check(out: Path, *, limit: int | None, seed: int, max_policy_time_s: float) -> None:
    if out.suffix.lower() != ".parquet":
        raise ValueError(f"{out}: must end with .parquet")
    if limit is not None and limit < 1:
        raise ValueError(f"limit must be from 1 up, got {limit}")
    if seed < 0:
        raise ValueError(f"seed must be from 0 up, got {seed}")
    if not 0.0 < max_policy_time_s < math.inf:
        raise ValueError(f"max_policy_time_s must be more than 0 s, got {max_policy_time_s:g}")
