"""The `affectsim` command."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

if TYPE_CHECKING:
    from affectsim_data.releases import Release
    from affectsim_data.releases.planning import Selection
    from affectsim_data.releases.stores import Store

__all__ = ["main"]

_CONDITION_TABLES: dict[str, tuple[str, ...]] = {"a_obs": ("trajectories",)}
"""Tables that a condition reads beside episodes and assets."""

_Repeated = tyro.conf.UseAppendAction[tuple[str, ...]]


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


def build(
    recipe: tyro.conf.Positional[str],
    *,
    out: Path,
    source: Path | None = None,
    jobs: int | None = None,
    overwrite: bool = False,
    screen_report: Path | None = None,
    skip_broken: bool = False,
) -> int:
    """Build a release from a recipe; the same recipe gives the same bytes.

    `build avatars` bakes the bodies instead; it needs the extra `build`.

    Args:
        recipe: Name of a file in builders/, or a path ending in .toml.
        out: Folder of the release; appears when it is whole.
        source: Your copy of the corpus, for recipes that read one.
        jobs: Processes; one per core if not given.
        overwrite: Replace a release that is already there.
        screen_report: Write what screening said, a row per motion and check, as Parquet; pictures
            of rejected motions go beside it, into NAME_rejected.
        skip_broken: Leave out files of the corpus that cannot be read, instead of stopping.
    """
    if recipe == "avatars":
        from affectsim_data.builders.bodies.baking import bake_avatars

        for path in bake_avatars(out, progress=lambda message: print(message, file=sys.stderr)):
            print(path)
        return 0
    from affectsim_data.builders.building import build_release
    from affectsim_data.cards import write_card
    from affectsim_data.inspection.building import build_lines, picture_rejected
    from affectsim_data.releases import open_release

    start = time.perf_counter()
    report = build_release(
        recipe,
        out,
        source=source,
        jobs=jobs,
        overwrite=overwrite,
        screen_report=screen_report,
        skip_broken=skip_broken,
    )
    write_card(open_release(out), out)
    count = report.manifest.num_rows("episodes")
    print(f"{out}: {count} episodes in {time.perf_counter() - start:.1f} s")
    print("\n".join(build_lines(report)))
    if screen_report is not None:
        print(f"{screen_report}: {report.cast.screening.num_motions} motions screened")
        for path in picture_rejected(report.cast, _rejected_folder(screen_report)):
            print(f"  {path}")
    return 0


def _rejected_folder(report: Path) -> Path:
    return report.with_name(f"{report.stem}_rejected")


def info(
    release: tyro.conf.Positional[str] = "mini",
    *,
    split: str | None = None,
    where: tuple[str, ...] = (),
    motions: bool = False,
    out: Path | None = None,
    json: bool = False,
) -> int:
    """Counts per split, family, challenge, action, emotion and scene; distances; sizes.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split.
        where: Only episodes of which all this holds: emotion=sad,angry visible_share_init<0.3
        motions: Describe the motions instead: how they move, by emotion.
        out: With --motions, a folder for a plot and a sheet of pictures per emotion and action.
        json: Print JSON.
    """
    if motions:
        if split is not None or where:
            raise ValueError("--motions describes all motions; leave out --split and --where")
        return _describe_motions(release, out=out, json=json)
    if out is not None:
        raise ValueError("--out is where --motions puts its pictures; add --motions")
    from affectsim_data.inspection.summary import release_summary, summary_lines
    from affectsim_data.releases import open_release
    from affectsim_data.releases.filters import parse_where

    filter = parse_where(where) if where else None
    summary = release_summary(open_release(release), split=split, filter=filter)
    print(dumps(summary, indent=2) if json else "\n".join(summary_lines(summary)))
    return 0


def _describe_motions(release: str, *, out: Path | None, json: bool) -> int:
    from affectsim_data.inspection.motion_summary import (
        motion_descriptors,
        motion_summary,
        motion_summary_lines,
    )
    from affectsim_data.releases import open_release

    opened = open_release(release)
    table = motion_descriptors(opened)
    summary = motion_summary(table)
    print(dumps(summary, indent=2) if json else "\n".join(motion_summary_lines(summary)))
    if out is not None:
        from affectsim_data.inspection.emotion_sheets import emotion_sheets
        from affectsim_data.inspection.motion_plots import motion_plot

        out.mkdir(parents=True, exist_ok=True)
        motion_plot(table, out / "motions.png")
        sheets = emotion_sheets(opened, out / "sheets")
        print(f"{out}: motions.png and {len(sheets)} sheets", file=sys.stderr)
    return 0


def plan(
    source: tyro.conf.Positional[str] = "mini",
    *,
    split: _Repeated = (),
    condition: _Repeated = (),
    scenes: tuple[str, ...] = (),
    json: bool = False,
) -> int:
    """What downloading would fetch, in files and bytes, and how much of it is here already.

    Args:
        source: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split; may be given several times.
        condition: Only what this condition needs; may be given several times.
        scenes: Only episodes in these scenes.
        json: Print JSON.
    """
    from affectsim_data.inspection.plans import plan_lines
    from affectsim_data.releases.cache_limits import cache_limit
    from affectsim_data.releases.planning import make_plan

    release, store, selection = _selected(source, split, condition, scenes)
    made, limit = make_plan(release, store, selection), cache_limit()
    document = {**made.to_json(), "cache_limit_bytes": limit}
    print(dumps(document, indent=2) if json else "\n".join(plan_lines(made, limit=limit)))
    return 0


def download(
    source: tyro.conf.Positional[str],
    *,
    split: _Repeated = (),
    condition: _Repeated = (),
    scenes: tuple[str, ...] = (),
    out: Path | None = None,
    jobs: int = 8,
) -> int:
    """Fetch a release or a part of it, verified; run it again to go on after an interruption.

    Args:
        source: A folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split; may be given several times.
        condition: Only what this condition needs; may be given several times.
        scenes: Only episodes in these scenes.
        out: Folder that becomes a release, or more of one; the local cache if not given.
        jobs: Files fetched at a time.
    """
    from affectsim_data.releases.cache_limits import cache_limit
    from affectsim_data.releases.downloading import download_to_cache, download_to_folder
    from affectsim_data.releases.planning import format_bytes

    try:
        release, store, selection = _selected(source, split, condition, scenes)
        if out is None:
            done = download_to_cache(release, store, selection, limit=cache_limit(), jobs=jobs)
        else:
            done = download_to_folder(release, store, selection, out.expanduser(), jobs=jobs)
    except KeyboardInterrupt:
        print(
            "affectsim: interrupted; what is verified is kept, run the same command to go on",
            file=sys.stderr,
        )
        return 130
    part = done.manifest.partial_of if out is not None else None
    held = f"{part.describe()} of {part.uri}" if part else store.uri
    print(f"{out or 'cache'}: {len(done.names)} files, {format_bytes(done.bytes)}, all verified")
    print(f"  {held}")
    if out is not None and not done.has_card:
        print("  without a README.md: there is none, or it could not be fetched")
    return 0


def upload(
    folder: tyro.conf.Positional[Path],
    repository: tyro.conf.Positional[str],
    *,
    private: bool = False,
    tag: str | None = None,
    message: str | None = None,
    jobs: int = 8,
) -> int:
    """Publish a release on the Hugging Face Hub, with its card, as one commit.

    Args:
        folder: The release; every file is verified first.
        repository: ORG/NAME of the dataset; made if there is none.
        private: Only you may see it.
        tag: Name of this version, such as v1.
        message: Of the commit.
        jobs: Files read or sent at a time.
    """
    from affectsim_data.cards import published_card
    from affectsim_data.releases import open_release
    from affectsim_data.releases.publishing import check_publishable, publish, repository_id
    from affectsim_data.releases.stores import FolderStore

    repo_id, store = repository_id(repository), FolderStore(folder.expanduser())
    check_publishable(store, private=private)
    place = f"hf://datasets/{repo_id}" + (f"@{tag}" if tag else "")
    card, is_own = published_card(open_release(store.root), store.root, place=place)
    done = publish(store, repo_id, card=card, private=private, tag=tag, message=message, jobs=jobs)
    kept = "README.md as you wrote it" if is_own else "a card"
    gone = f"; {done.num_deleted} files of an older version deleted" if done.num_deleted else ""
    print(f"{done.uri}: {done.num_files} files, the manifest and {kept}{gone}")
    if tag is not None:
        print(f"  also {place}")
    return 0


def _selected(
    source: str, split: tuple[str, ...], condition: tuple[str, ...], scenes: tuple[str, ...]
) -> tuple[Release, Store, Selection]:
    """The part of a release that the options of a command name."""
    from affectsim_data.releases import open_release
    from affectsim_data.releases.planning import select
    from affectsim_data.releases.stores import open_store

    tables = _tables_of(condition)
    release = open_release(source)
    selection = select(release, splits=split, scene_ids=scenes, tables=tables)
    return release, open_store(release.uri), selection


def _tables_of(conditions: tuple[str, ...]) -> tuple[str, ...] | None:
    """Tables that conditions read beside episodes and assets; `None` for no condition: all."""
    if not conditions:
        return None
    from affectsim_data.loaders.presets import condition_names

    known = sorted({*condition_names(), *_CONDITION_TABLES})
    for name in conditions:
        if name not in known:
            raise ValueError(f"condition must be one of {', '.join(known)}, got {name!r}")
    return tuple(table for name in conditions for table in _CONDITION_TABLES.get(name, ()))


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


_COMMANDS: dict[str, Callable[..., int]] = {
    "doctor": doctor,
    "demo": demo,
    "build": build,
    "info": info,
    "plan": plan,
    "download": download,
    "upload": upload,
    "inspect": inspect,
}


def main(arguments: list[str] | None = None) -> int:
    """Runs a command; errors a user can mend are one line, not a traceback.

    Args:
        arguments: Command line without the program name; that of the process if not given.
    """
    from affectsim_data.errors import ForkedContextError, RendererUnavailableError

    expected = (
        *(ValueError, KeyError, OSError, ImportError),
        *(RendererUnavailableError, ForkedContextError),
    )
    try:
        status: int = tyro.extras.subcommand_cli_from_dict(
            _COMMANDS,
            prog="affectsim",
            description="Replayable affective episodes, seen as you ask.",
            args=arguments,
        )
        return status
    except BrokenPipeError:  # whoever read our output has had enough: `affectsim info | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except expected as error:
        if os.environ.get("AFFECTSIM_TRACEBACK"):
            raise
        message = error.args[0] if isinstance(error, KeyError) and error.args else error
        print(f"affectsim: {message}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("affectsim: interrupted; nothing half-written is left", file=sys.stderr)
        return 130
