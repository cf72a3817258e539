"""Runs a policy over the episodes of a split: a trajectory table, whatever happens on the way."""

from __future__ import annotations

import dataclasses
import functools
import math
import os
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from affectsim_data.engines import EngineName, open_engine
from affectsim_data.engines.code import code_fingerprint
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.joined_splits import split_title
from affectsim_data.releases.journals import journal_path
from affectsim_data.releases.recorded import sha256_without_trajectories
from affectsim_data.releases.selection import select_rows
from affectsim_data.releases.splits import SplitBy
from affectsim_data.simulation.acting import Job
from affectsim_data.simulation.finished import finished_run, run_metadata
from affectsim_data.simulation.intake import Intake, episode_ids
from affectsim_data.simulation.journal import RunHeader, open_run_journal
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
    ids, header, num_jobs = episode_ids(job, rows), _header(job), _num_jobs(jobs)
    if out.exists() and not overwrite and not journal_path(out).exists():
        done = finished_run(out, header, ids)
        elapsed_s = time.perf_counter() - started
        return AcquireRun(
            out, len(ids), 0, done.endings, done.failures, done.failures_path, elapsed_s
        )
    with open_run_journal(out, header, anew=overwrite) as journal:
        run = Intake(out, job, rows, journal, progress=progress)
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
