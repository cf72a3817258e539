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
    out: Path | None = None,
) -> int:
    """Record every condition of an episode for the Rerun viewer, or draw sheets of many.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        episode: Its episode_id, for example mini/test-00000.
        sheet: Instead of one episode, this many random ones as contact sheets, a page (PNG) per
            family or challenge: p_init, p_ref, p_mon and the plan of each.
        split: With --sheet, only of this split.
        split_by: With --sheet, what no two splits share: group, scene, or both.
        where: With --sheet, only episodes of which all this holds: emotion=sad,angry
        seed: With --sheet, of the choice.
        out: The .rrd to write, named after the episode if not given; with --sheet a folder, sheets
            if not given.
    """
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
