"""Commands that move releases: `plan`, `download`, `upload`."""

from __future__ import annotations

import sys
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

if TYPE_CHECKING:
    from affectsim_data.releases import Release
    from affectsim_data.releases.planning import Selection
    from affectsim_data.releases.stores import Store

__all__ = ["download", "plan", "upload"]

_CONDITION_TABLES: dict[str, tuple[str, ...]] = {"a_obs": ("trajectories",)}
"""Tables that a condition reads beside episodes and assets."""

_Repeated = tyro.conf.UseAppendAction[tuple[str, ...]]


def plan(
    source: tyro.conf.Positional[str] = "mini",
    *,
    split: _Repeated = (),
    split_by: str = "group",
    condition: _Repeated = (),
    scenes: tuple[str, ...] = (),
    json: bool = False,
) -> int:
    """What downloading would fetch, in files and bytes, and how much of it is here already.

    Args:
        source: mini, a folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split; may be given several times.
        split_by: What no two splits share: group (performers, performances), scene, or both.
        condition: Only what this condition needs; may be given several times.
        scenes: Only episodes in these scenes.
        json: Print JSON.
    """
    from affectsim_data.inspection.plans import plan_lines
    from affectsim_data.releases.cache_limits import cache_limit
    from affectsim_data.releases.planning import make_plan

    release, store, selection = _selected(source, split, split_by, condition, scenes)
    made, limit = make_plan(release, store, selection), cache_limit()
    document = {**made.to_json(), "cache_limit_bytes": limit}
    print(dumps(document, indent=2) if json else "\n".join(plan_lines(made, limit=limit)))
    return 0


def download(
    source: tyro.conf.Positional[str],
    *,
    split: _Repeated = (),
    split_by: str = "group",
    condition: _Repeated = (),
    scenes: tuple[str, ...] = (),
    out: Path | None = None,
    jobs: int = 8,
) -> int:
    """Fetch a release or a part of it, verified; run it again to go on after an interruption.

    Args:
        source: A folder, or hf://datasets/ORG/NAME@REVISION.
        split: Only this split; may be given several times.
        split_by: What no two splits share: group (performers, performances), scene, or both.
        condition: Only what this condition needs; may be given several times.
        scenes: Only episodes in these scenes.
        out: Folder that becomes a release, or more of one; the local cache if not given.
        jobs: Files fetched at a time.
    """
    from affectsim_data.releases.cache_limits import cache_limit
    from affectsim_data.releases.downloading import download_to_cache, download_to_folder
    from affectsim_data.releases.planning import format_bytes

    try:
        release, store, selection = _selected(source, split, split_by, condition, scenes)
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
    """Publish a release on the Hugging Face Hub, with card and Croissant, as one commit.

    Args:
        folder: The release; every file is verified first.
        repository: ORG/NAME of the dataset; made if there is none.
        private: Only you may see it.
        tag: Name of this version, such as v1.
        message: Of the commit.
        jobs: Files read or sent at a time.
    """
    from affectsim_data.cards import has_own_card, published_pages
    from affectsim_data.releases import open_release
    from affectsim_data.releases.publishing import check_publishable, publish, repository_id
    from affectsim_data.releases.stores import FolderStore

    repo_id, store = repository_id(repository), FolderStore(folder.expanduser())
    check_publishable(store, private=private)
    place = f"hf://datasets/{repo_id}" + (f"@{tag}" if tag else "")

    def pages() -> dict[str, bytes]:
        return published_pages(open_release(store.root), store.root, place=place)

    done = publish(
        store, repo_id, pages=pages, private=private, tag=tag, message=message, jobs=jobs
    )
    kept = "README.md as you wrote it" if has_own_card(store.root) else "a card"
    gone = f"; {done.num_deleted} files of an older version deleted" if done.num_deleted else ""
    print(f"{done.uri}: {done.num_files} files, the manifest and {kept}{gone}")
    if tag is not None:
        print(f"  also {place}")
    return 0


def _selected(
    source: str,
    split: tuple[str, ...],
    split_by: str,
    condition: tuple[str, ...],
    scenes: tuple[str, ...],
) -> tuple[Release, Store, Selection]:
    """The part of a release that the options of a command name."""
    from affectsim_data.releases import open_release
    from affectsim_data.releases.joined_splits import as_split_by
    from affectsim_data.releases.planning import select
    from affectsim_data.releases.stores import open_store

    tables = _tables_of(condition)
    release = open_release(source)
    selection = select(
        release, splits=split, split_by=as_split_by(split_by), scene_ids=scenes, tables=tables
    )
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
