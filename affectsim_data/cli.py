"""The `affectsim` command."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from json import dumps
from pathlib import Path

import tyro

__all__ = ["main"]


def doctor(*, device: int | None = None) -> int:
    """What renders here, what is missing, how to mend it.

    Args:
        device: EGL device to examine; the default one if not given.
    """
    from affectsim_data.inspection import examine

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


def build(
    recipe: tyro.conf.Positional[str],
    *,
    out: Path,
    source: Path | None = None,
    jobs: int | None = None,
    overwrite: bool = False,
) -> int:
    """Build a release from a recipe; the same recipe gives the same bytes.

    Args:
        recipe: Name of a file in builders/, or a path ending in .toml.
        out: Folder of the release; appears when it is whole.
        source: Your copy of the corpus, for recipes that read one.
        jobs: Processes; one per core if not given.
        overwrite: Replace a release that is already there.
    """
    from affectsim_data.builders.building import build_release
    from affectsim_data.cards import write_card
    from affectsim_data.releases import open_release

    start = time.perf_counter()
    report = build_release(recipe, out, source=source, jobs=jobs, overwrite=overwrite)
    write_card(open_release(out), out)
    count = report.manifest.num_rows("episodes")
    print(f"{out}: {count} episodes in {time.perf_counter() - start:.1f} s")
    for shortfall in report.shortfalls:
        print(f"  not placed: {shortfall.key} ({shortfall.num_episodes} episodes)")
    return 0


def info(release: tyro.conf.Positional[str] = "mini", *, json: bool = False) -> int:
    """Counts per split, family, challenge, action, emotion and scene; distances; sizes.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        json: Print JSON.
    """
    from affectsim_data.inspection.summary import release_summary, summary_lines
    from affectsim_data.releases import open_release

    summary = release_summary(open_release(release))
    print(dumps(summary, indent=2) if json else "\n".join(summary_lines(summary)))
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
    from affectsim_data.inspection import record_episode
    from affectsim_data.releases import open_release
    from affectsim_data.render import open_renderer

    opened = open_release(release)
    found = opened.find_episode(episode)
    path = out or Path(episode.replace("/", "_") + ".rrd")
    path.parent.mkdir(parents=True, exist_ok=True)
    record_episode(found, opened.world(found), open_renderer(), path)
    print(f"{path}: {path.stat().st_size / 1e6:.1f} MB; open it with: rerun {path}")
    return 0


_COMMANDS: dict[str, Callable[..., int]] = {
    "doctor": doctor,
    "demo": demo,
    "build": build,
    "info": info,
    "inspect": inspect,
}


def main(arguments: list[str] | None = None) -> int:
    """Runs a command; errors a user can mend are one line, not a traceback.

    Args:
        arguments: Command line without the program name; that of the process if not given.
    """
    from affectsim_data.errors import ForkedContextError, RendererUnavailableError

    expected = (
        *(ValueError, KeyError, FileNotFoundError, FileExistsError, PermissionError),
        *(ImportError, ConnectionError, RendererUnavailableError, ForkedContextError),
    )
    try:
        status: int = tyro.extras.subcommand_cli_from_dict(
            _COMMANDS,
            prog="affectsim",
            description="Replayable affective episodes, seen as you ask.",
            args=arguments,
        )
        return status
    except expected as error:
        if os.environ.get("AFFECTSIM_TRACEBACK"):
            raise
        message = error.args[0] if isinstance(error, KeyError) and error.args else error
        print(f"affectsim: {message}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("affectsim: interrupted; nothing half-written is left", file=sys.stderr)
        return 130
