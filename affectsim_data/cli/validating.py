"""The command that checks releases: `validate`."""

from __future__ import annotations

import sys
from json import dumps
from pathlib import Path
from typing import Literal

import tyro

__all__ = ["validate"]


def validate(
    release: tyro.conf.Positional[str] = "mini",
    *,
    report: Path | None = None,
    images: Path | None = None,
    sample: int | Literal["all"] = 300,
    jobs: int | None = None,
    json: bool = False,
) -> int:
    """Check all that a release promises, from its own stored bytes; status 0 if every check holds.

    Args:
        release: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        report: Write every check and every failure as Parquet.
        images: Folder for a picture of each failed episode, at most 50.
        sample: Episodes of which d* is measured again, or all; everything else is over all.
        jobs: Processes; one per core if not given.
        json: Print JSON.
    """
    from affectsim_data.builders.validation import validate_release

    found = validate_release(release, sample=None if sample == "all" else sample, jobs=jobs)
    print(dumps(found.to_json(), indent=2) if json else "\n".join(found.lines()))
    if report is not None:
        print(f"{report}: {found.write(report)} rows", file=sys.stderr)
    if images is not None:
        from affectsim_data.inspection.validation_pictures import failure_pictures
        from affectsim_data.releases import open_release
        from affectsim_data.render import open_renderer

        paths = failure_pictures(open_release(release), found.failures, open_renderer(), images)
        print(f"{images}: {len(paths)} pictures", file=sys.stderr)
    return 0 if found.holds else 1
