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
    episode: tyro.conf.Positional[str],
    *,
    out: Path | None = None,
) -> int:
    """Record every condition of an episode for the Rerun viewer.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        episode: Its episode_id, for example mini/test-00000.
        out: The .rrd to write; named after the episode if not given.
    """
    from affectsim_data.inspection.recording import record_episode
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    opened = open_release(release)
    found = opened.find_episode(episode)
    path = out or Path(episode.replace("/", "_") + ".rrd")
    path.parent.mkdir(parents=True, exist_ok=True)
    record_episode(found, opened.world(found), open_renderer(), path)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB; open it with: rerun {path}")
    return 0
