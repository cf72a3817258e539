"""The command that makes releases: `build`."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Literal

import tyro

__all__ = ["build"]


def build(
    recipe: tyro.conf.Positional[str],
    *,
    out: Path,
    source: tyro.conf.UseAppendAction[tuple[str, ...]] = (),
    jobs: int | None = None,
    overwrite: bool = False,
    screen_report: Path | None = None,
    skip_broken: bool = False,
    shell: bool = False,
    scene_report: Path | None = None,
    engine: Literal["local", "ray"] = "local",
    ray_address: str | None = None,
) -> int:
    """Build a release from a recipe; the same recipe gives the same bytes.

    A build that was interrupted or killed goes on where it was when the same command is given
    again. `build avatars` bakes the bodies instead; it needs the extra `build`.

    Args:
        recipe: Name of a file in builders/, or a path ending in .toml.
        out: Folder of the release; appears when it is whole.
        source: Your copy of the corpus, scenes or furniture, for recipes that read some: FOLDER,
            or NAME=FOLDER for recipes that read several; repeat it.
        jobs: Units in work at once; one per core if not given.
        overwrite: Replace a release that is already there.
        screen_report: Write what screening said, a row per motion and check, as Parquet; pictures
            of rejected motions go beside it, into NAME_rejected.
        skip_broken: Leave out motions and scenes that cannot be read, instead of stopping.
        shell: Build floor and walls for scenes of a Habitat dataset whose stage is missing.
        scene_report: Write what was found, missing, skipped and ignored, a row per thing, as
            Parquet.
        engine: Where the work is done: processes of this machine, or a Ray cluster, which needs
            the extra `scale`.
        ray_address: Of the Ray cluster; without it one is started on this machine.
    """
    if recipe == "avatars":
        from affectsim_data.builders.bodies.baking import bake_avatars

        for path in bake_avatars(out, progress=lambda message: print(message, file=sys.stderr)):
            print(path)
        return 0
    from affectsim_data.builders.building import build_release
    from affectsim_data.builders.recipes import read_recipe
    from affectsim_data.builders.sources import read_sources
    from affectsim_data.cards import write_card
    from affectsim_data.inspection.building import (
        build_lines,
        cost_lines,
        picture_rejected,
        write_scene_report,
    )
    from affectsim_data.releases import open_release

    start = time.perf_counter()
    try:
        report = build_release(
            recipe,
            out,
            source=read_sources(source, read_recipe(recipe)),
            jobs=jobs,
            overwrite=overwrite,
            screen_report=screen_report,
            skip_broken=skip_broken,
            shell=shell,
            engine=engine,
            ray_address=ray_address,
            dress=lambda folder: write_card(open_release(folder), folder),
        )
    except KeyboardInterrupt:
        print("affectsim: interrupted", file=sys.stderr)  # what is left, the build has said
        return 130
    count, scenes = (report.manifest.num_rows(table) for table in ("episodes", "scenes"))
    seconds = time.perf_counter() - start
    print(f"{out}: {count} episodes in {scenes} scenes, {seconds:.1f} s")
    print("\n".join([*cost_lines(report), *build_lines(report)]))
    if scene_report is not None:
        print(f"{scene_report}: {write_scene_report(report, scene_report)} rows")
    if screen_report is not None:
        print(f"{screen_report}: {report.cast.screening.num_motions} motions screened")
        for path in picture_rejected(report.cast, _rejected_folder(screen_report)):
            print(f"  {path}")
    return 0


def _rejected_folder(report: Path) -> Path:
    return report.with_name(f"{report.stem}_rejected")
