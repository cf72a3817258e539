"""The command that has a policy act in episodes: `acquire`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import tyro

if TYPE_CHECKING:
    from affectsim_data.simulation.acquiring import AcquireRun

__all__ = ["acquire"]

_FAILURES_TOLD = 5


def acquire(
    release: tyro.conf.Positional[str] = "mini",
    *,
    policy: str,
    out: Path,
    split: str = "test",
    split_by: str = "group",
    where: tuple[str, ...] = (),
    limit: int | None = None,
    seed: int = 0,
    jobs: int | None = None,
    engine: Literal["local", "ray"] = "local",
    ray_address: str | None = None,
    policy_time: float = 60.0,
    into_release: bool = False,
    overwrite: bool = False,
) -> int:
    """Have a policy act in every episode of a split, into a trajectory table.

    Safe to interrupt: the same command goes on where it was, and has nothing to do once the table
    is there. The same release, policy and seed give the same bytes, with any number of processes.
    Where the policy fails, its episode ends without a handoff, and OUT.failures.jsonl says why.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        policy: stay, random, random:STEPS, limited_search, scan_search_follow,
            privileged:straight_to_target, privileged:reference, or module:PACKAGE.MODULE:NAME for
            one of yours.
        out: The table, .parquet; what condition a_obs shows.
        split: train, validation or test.
        split_by: What no two splits share: group (performers, performances), scene, or both.
        where: Only episodes of which all this holds: family=dyadic initial_distance_m>5
        limit: Only so many episodes, the first ones.
        seed: Of whatever the policy does at random; every episode has its own, made of it.
        jobs: Episodes in work at once, each in a process; one per core if not given.
        engine: Where the work is done: processes of this machine, or a Ray cluster, which needs
            the extra scale.
        ray_address: Of the Ray cluster; without it one is started on this machine.
        policy_time: Seconds the policy may take in an episode; drawing is not counted.
        into_release: Also put the trajectories into the release, a folder: a_obs finds them there.
        overwrite: Begin anew, and replace a table of another run.
    """
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where
    from affectsim_data.releases.joined_splits import as_split_by
    from affectsim_data.simulation.acquiring import acquire as run_acquire

    opened = open_release(release)
    if into_release and not Path(opened.uri).is_dir():
        raise ValueError(f"--into-release needs a release in a folder, got {opened.uri}")
    run = run_acquire(
        opened,
        policy,
        out,
        split=split,
        split_by=as_split_by(split_by),
        filter=parse_where(where) if where else None,
        limit=limit,
        seed=seed,
        jobs=jobs,
        engine=engine,
        ray_address=ray_address,
        max_policy_time_s=policy_time,
        overwrite=overwrite,
    )
    print("\n".join(_summary(run)))
    for failure in run.failures[:_FAILURES_TOLD]:
        print(
            f"affectsim: failed: {failure.episode_id}, step {failure.failed_at}: {failure.reason}",
            file=sys.stderr,
        )
    if into_release:
        from affectsim_data.releases.recorded import add_trajectories

        for name in add_trajectories(Path(opened.uri), run.path):
            print(f"{opened.uri}/{name}")
        print(f"`affectsim card {opened.uri}` brings its card up to date")
    return 0


def _summary(run: AcquireRun) -> list[str]:
    before = run.num_episodes - run.num_new
    told = [f"{run.num_new:,} episodes in {run.elapsed_s:,.0f} s"]
    told += [f"{before:,} before"] if before else []
    if not run.num_new:
        told = [f"all {before:,} episodes were done before; nothing to do"]
    endings = sorted(run.endings.items(), key=lambda pair: (-pair[1], pair[0]))
    lines = [
        f"{run.path}: {'; '.join(told)}",
        *(f"  {count:>7,} {ending.replace('_', ' ')}" for ending, count in endings),
    ]
    if run.failures_path is not None:
        lines.append(f"{run.failures_path}: why the policy failed in {len(run.failures):,}")
    return lines
