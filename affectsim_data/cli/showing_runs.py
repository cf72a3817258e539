"""What `affectsim inspect --trajectories` does: one run as picture and recording, or failures."""

from __future__ import annotations

from pathlib import Path

__all__ = ["show_failures", "show_run"]

_PICTURE, _RECORDING = ".png", ".rrd"


def show_run(
    release: str,
    episode_id: str,
    trajectories: tuple[Path, ...],
    *,
    policy: str | None = None,
    out: Path | None = None,
) -> int:
    """Draws what a policy did in an episode.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        episode_id: Which episode.
        trajectories: Tables that hold its run.
        policy: Whose, if the tables hold several.
        out: A `.png` for the page with map and frames, an `.rrd` for Rerun, or a folder for both.

    Raises:
        ValueError: A file that is neither.
    """
    from affectsim_data.inspection.trajectory_pictures import run_picture
    from affectsim_data.inspection.trajectory_recording import record_run
    from affectsim_data.inspection.trajectory_runs import RunTable
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    paths = _paths(out or Path("runs"), episode_id)
    opened = open_release(release)
    episode = opened.find_episode(episode_id)
    run = RunTable(trajectories, policy=policy).run(episode)
    world, navmesh = opened.world(episode), opened.navmesh(episode.scene_id)
    renderer = open_renderer()
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix == _PICTURE:
            run_picture(run, world, renderer, navmesh=navmesh).save(path)
            print(path)
        else:
            record_run(run, world, renderer, path, navmesh=navmesh)
            print(f"{path}: {path.stat().st_size / 1e6:.1f} MB; open it with: rerun {path}")
    return 0


def _paths(out: Path, episode_id: str) -> list[Path]:
    if out.suffix in (_PICTURE, _RECORDING):
        return [out]
    if out.suffix and not out.is_dir():
        raise ValueError(f"--out must end with .png or .rrd, or be a folder for both, got {out}")
    name = episode_id.replace("/", "_")
    return [out / f"{name}{suffix}" for suffix in (_PICTURE, _RECORDING)]


def show_failures(
    release: str,
    trajectories: tuple[Path, ...],
    *,
    policy: str | None = None,
    out: Path | None = None,
) -> int:
    """Prints how many runs failed of which cause, and draws the worst of each.

    Args:
        release: Where the episodes are.
        trajectories: Tables of runs; all runs in them are judged.
        policy: Whose, if the tables hold several.
        out: Folder for `runs.csv` and a page per cause; `failures` if not given.
    """
    from affectsim_data.inspection.failure_sheets import write_failures
    from affectsim_data.inspection.trajectory_failures import cause_lines, judge_runs
    from affectsim_data.inspection.trajectory_runs import RunTable
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    opened, runs = open_release(release), RunTable(trajectories, policy=policy)
    verdicts = judge_runs(opened, runs)
    print("\n".join(cause_lines(verdicts)))
    for path in write_failures(opened, runs, verdicts, open_renderer(), out or Path("failures")):
        print(path)
    return 0
