"""The page a release carries: a dataset card the Hugging Face Hub understands."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from string import Template

from affectsim_data.content import content_path
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Release
from affectsim_data.schemas import SPLITS, Split

__all__ = ["dataset_card", "published_card", "write_card"]


_NOT_PASSED_ON = """
This release may not be passed on. Share its recipe: whoever has the corpus builds it from that.
"""


def dataset_card(release: Release, *, place: str = "path/to/this/folder") -> str:
    """The text of a release's README.md.

    Args:
        release: What to describe.
        place: What a reader writes to open it: a folder or `hf://datasets/ORG/NAME@REVISION`.
    """
    splits = [split for split in SPLITS if release.manifest.num_rows("episodes", split)]
    if not splits:
        scene_ids = release.asset_ids("scenes")
        return _filled(
            "scenes_card.md",
            release,
            place=place,
            scene_id=scene_ids[0],
            counts=f"{len(scene_ids)} scenes.",
        )
    data_files = "\n".join(
        f"  - split: {split}\n    path: episodes/{split}-*.parquet" for split in splits
    )
    return _filled(
        "dataset_card.md",
        release,
        place=place,
        data_files=data_files,
        split=splits[-1],
        counts=_counts(release, splits),
    )


def _filled(template: str, release: Release, **values: str) -> str:
    """A template with the values all pages have, and others of its own."""
    manifest = release.manifest
    text = Template(content_path("cards", template).read_text(encoding="utf-8"))
    return text.substitute(
        name=manifest.name,
        licences="\n".join(f"- {licence}" for licence in manifest.licences) or "- none stated",
        terms="" if manifest.redistribution else _NOT_PASSED_ON,
        schema_version=manifest.schema_version,
        code_version=manifest.code_version,
        recipe=manifest.recipe,
        seed=manifest.seed,
        **values,
    )


def _counts(release: Release, splits: Sequence[Split]) -> str:
    lines = [
        "| split | episodes | " + " | ".join(EMOTIONS) + " |",
        "|---|---|" + "---|" * len(EMOTIONS),
    ]
    for split in splits:
        emotions = release.episode_index(split).column("emotion").to_pylist()
        cells = " | ".join(str(emotions.count(emotion)) for emotion in EMOTIONS)
        lines.append(f"| {split} | {len(emotions)} | {cells} |")
    return "\n".join(lines)


def published_card(release: Release, folder: Path, *, place: str) -> tuple[str, bool]:
    """The card to publish with the release in a folder.

    Args:
        release: The release.
        folder: Where it is.
        place: What a reader will write to open it.

    Returns:
        The README.md of the folder if somebody wrote their own, else a new one that names the
        place; and whether it is their own.
    """
    path = folder / "README.md"
    generated = dataset_card(release, place=place)
    if path.is_file():
        text = path.read_text(encoding="utf-8")
        if text not in (generated, dataset_card(release)):
            return text, True
    return generated, False


def write_card(release: Release, folder: Path) -> None:
    """Writes README.md into the folder of a release, whole or not at all."""
    staged = folder / ".README.md.partial"
    staged.write_text(dataset_card(release), encoding="utf-8")
    os.replace(staged, folder / "README.md")
