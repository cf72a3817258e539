"""Commands that show: `doctor`, `demo`, `inspect`."""

from __future__ import annotations

from pathlib import Path

import tyro

__all__ = ["demo", "doctor", "inspect"]


def doctor(*, device: int | None = None) -> int:
    """What renders here, what is missing, how to mend it.

    Args:
        device: EGL device to examine; the default one if not given.
    """
    from affectsim_data.inspection.doctor import examine

    lines, works = examine(device=device)
    print("\n".join(lines))
    return 0 if works else 1


def demo(*, out: Path = Path("demo")) -> int:
    """The main job in one go: contact sheet, recording, numbers.

    Args:
        out: Folder for the results.
    """
    from affectsim_data.inspection.demo import run_demo

    run_demo(out)
    return 0


def inspect(
    release: tyro.conf.Positional[str],
    episode: tyro.conf.Positional[str | None] = None,
    *,
    sheet: int | None = None,
    split: str | None = None,
    split_by: str = "group",
    where: tuple[str, ...] = (),
    seed: int = 0,
    trajectories: tuple[Path, ...] = (),
    policy: str | None = None,
    failures: bool = False,
    out: Path | None = None,
) -> int:
    """Record every condition of an episode for the Rerun viewer, or draw sheets of many.

    With --trajectories: what a policy did in the episode, or with --failures why it failed where.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        episode: Its episode_id, for example mini/test-00000.
        sheet: Instead of one episode, this many random ones as contact sheets, a page (PNG) per
            family or challenge: p_init, p_ref, p_mon and the plan of each.
        split: With --sheet, only of this split.
        split_by: With --sheet, what no two splits share: group, scene, or both.
        where: With --sheet, only episodes of which all this holds: emotion=sad,angry
        seed: With --sheet, of the choice.
        trajectories: Tables of runs, as `affectsim acquire` writes them.
        policy: With --trajectories, whose runs; may be left out if they are of one policy.
        failures: With --trajectories and no episode, a table of causes, and pages of the worst.
        out: The .rrd to write, named after the episode if not given; with --sheet a folder, sheets
            if not given. With --trajectories a .png, an .rrd, or a folder for both, runs if not
            given; with --failures a folder, failures if not given.
    """
    if trajectories or failures or policy is not None:
        others = (sheet, split, *where, *(() if split_by == "group" else (split_by,)))
        if any(one is not None for one in others):
            raise ValueError("--sheet, --split, --split-by and --where do not go with runs")
        return _show_runs(release, episode, trajectories, policy, failures=failures, out=out)
    if (episode is None) == (sheet is None):
        raise ValueError("inspect takes an episode_id, or --sheet N for sheets of N random ones")
    if sheet is not None:
        folder = out or Path("sheets")
        return _write_sheets(release, sheet, split, split_by, where, seed=seed, out=folder)
    if split is not None or where or split_by != "group":
        raise ValueError("--split, --split-by and --where go with --sheet; an episode is named")
    from affectsim_data.inspection.recording import record_episode
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    assert episode is not None
    opened = open_release(release)
    found = opened.find_episode(episode)
    path = out or Path(episode.replace("/", "_") + ".rrd")
    path.parent.mkdir(parents=True, exist_ok=True)
    record_episode(found, opened.world(found), open_renderer(), path)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB; open it with: rerun {path}")
    return 0


def _show_runs(
    release: str,
    episode: str | None,
    trajectories: tuple[Path, ...],
    policy: str | None,
    *,
    failures: bool,
    out: Path | None,
) -> int:
    from affectsim_data.cli.showing_runs import show_failures, show_run

    if not trajectories:
        raise ValueError("--policy and --failures are about runs; --trajectories names their table")
    if (episode is None) != failures:
        raise ValueError("--trajectories takes an episode_id, or --failures for all of its runs")
    if episode is None:
        return show_failures(release, trajectories, policy=policy, out=out)
    return show_run(release, episode, trajectories, policy=policy, out=out)


def _write_sheets(
    release: str,
    count: int,
    split: str | None,
    split_by: str,
    where: tuple[str, ...],
    *,
    seed: int,
    out: Path,
) -> int:
    import numpy as np

    from affectsim_data.inspection.episode_sheets import sampled_episodes, write_episode_sheets
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where
    from affectsim_data.releases.joined_splits import as_split_by
    from affectsim_data.render import open_renderer

    opened = open_release(release)
    episodes = sampled_episodes(
        opened,
        count,
        rng=np.random.default_rng(seed),
        split=split,
        split_by=as_split_by(split_by),
        filter=parse_where(where) if where else None,
    )
    for path in write_episode_sheets(opened, episodes, open_renderer(), out):
        print(path)
    return 0
