"""Fetches a part of a release: into the local cache, or as a release folder of its own.

A folder becomes a release in one step, when its manifest is put there after everything else. Until
then it holds a note of what it will be, by which the next run knows what to go on with.
"""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import shutil
from collections.abc import Iterator, Sequence
from pathlib import Path

from affectsim_data.errors import IntegrityError
from affectsim_data.releases.builtin import cache_folder
from affectsim_data.releases.file_locks import opened, try_lock
from affectsim_data.releases.hub import HubStore
from affectsim_data.releases.hub_repository import HubRepository
from affectsim_data.releases.manifest import MANIFEST_NAME, Manifest, sha256_of
from affectsim_data.releases.part_files import PART_SUFFIX
from affectsim_data.releases.partial import Partial, join_scenes
from affectsim_data.releases.planning import Selection, files_of, format_bytes
from affectsim_data.releases.release import Release
from affectsim_data.releases.stores import DOWNLOAD_NOTE_NAME, FolderStore, Store
from affectsim_data.releases.transfers import Progress, failure_list, transfer
from affectsim_data.schemas import SPLITS

__all__ = ["Download", "download_to_cache", "download_to_folder"]

_LOCK_NAME = ".download.lock"
_CARD_NAME = "README.md"
_FIRST_NAMES = {_LOCK_NAME, f"{DOWNLOAD_NOTE_NAME}{PART_SUFFIX}"}
_MAX_CARD_BYTES = 4 << 20


@dataclasses.dataclass(frozen=True)
class Download:
    """What a download left in place."""

    manifest: Manifest
    """Of the release, or of the part of it that is in the folder."""
    names: tuple[str, ...]
    """Files that are there, each verified."""
    bytes: int
    """Their size."""
    has_card: bool = False
    """Whether the page of the release is there too."""


def download_to_cache(
    release: Release, store: Store, selection: Selection, *, limit: int, jobs: int = 8
) -> Download:
    """Fetches a selection from the Hub into the local cache.

    Args:
        release: The release.
        store: Where its files are.
        selection: What to fetch.
        limit: Bytes the cache holds at most.
        jobs: Files at a time.

    Raises:
        ValueError: The release is in a folder, or the selection does not fit into the cache.
        ConnectionError: Files could not be fetched, or are broken at the source; lists them.
    """
    if not isinstance(store, HubStore):
        raise ValueError(
            f"{store.uri}: is a folder, there is nothing to fetch; --out FOLDER copies it"
        )
    sizes = {name: store.manifest.files[name].bytes for name in files_of(release, selection)}
    total = sum(sizes.values())
    if total > limit:
        raise ValueError(
            f"{store.uri}: the selection is {format_bytes(total)}, the local cache holds at most "
            f"{format_bytes(limit)}; set AFFECTSIM_CACHE_LIMIT, choose less by --split or "
            "--scenes, or fetch it into a folder of its own by --out FOLDER"
        )
    hub = store

    def work(name: str, progress: Progress) -> None:
        if hub.is_local(name):
            hub.read(name)  # verifies it
        else:
            hub.fetch(name, progress=progress)

    failures = transfer(sizes, work, jobs=jobs, label=f"{store.manifest.name}: fetching")
    for name in sizes:
        if name not in failures and not hub.is_local(name):
            failures[name] = ConnectionError(f"{name}: another process pushed it out of the cache")
    _raise_failures(failures, len(sizes))
    return Download(store.manifest, tuple(sizes), total)


def download_to_folder(
    release: Release, store: Store, selection: Selection, out: Path, *, jobs: int = 8
) -> Download:
    """Fetches or copies a selection into a folder, which then is a release like any other.

    What the folder holds of the same release stays and is verified too. Killed at any moment, the
    next run goes on where this one was and ends with the same bytes.

    Args:
        release: The release.
        store: Where its files are.
        selection: What to fetch.
        out: The folder; empty, new, or made by an earlier download of the same release.
        jobs: Files at a time.

    Raises:
        FileExistsError: `out` holds something else, or another version of the release.
        ValueError: There is not enough space on the disk, or a selection is malformed.
        ConnectionError: Files could not be fetched, or are broken at the source; lists them.
    """
    origin = _origin(store)
    _read_held(out, origin)  # before anything is made
    out.mkdir(parents=True, exist_ok=True)
    with _alone_in(out):
        held = _read_held(out, origin)
        before = set() if held is None else set(held.files)
        chosen = before.union(files_of(release, selection))
        names = [name for name in store.manifest.files if name in chosen]
        if lost := before - set(names):
            raise FileExistsError(
                f"{out}: holds {len(lost)} files that {store.uri} lacks; download from {origin.uri}"
            )
        _check_space(out, store.manifest, names)
        if held is None:
            note = {"uri": origin.uri, "manifest_sha256": origin.manifest_sha256}
            _put(out / DOWNLOAD_NOTE_NAME, json.dumps(note).encode())
        _fetch_files(store, names, out, jobs=jobs)
        manifest = _manifest_of(release, names, held, selection, origin)
        if (card := _read_card(store)) is not None:
            _put(out / _CARD_NAME, card)
        _put(out / MANIFEST_NAME, manifest.to_json().encode())
        _clean(out)
    total = sum(entry.bytes for entry in manifest.files.values())
    return Download(manifest, tuple(names), total, (out / _CARD_NAME).is_file())


@dataclasses.dataclass(frozen=True)
class _Origin:
    """The whole release that a folder is, or is a part of."""

    uri: str
    manifest_sha256: str


def _origin(store: Store) -> _Origin:
    partial = store.manifest.partial_of
    if partial is not None:
        return _Origin(partial.uri, partial.manifest_sha256)
    uri = str(store.root.resolve()) if isinstance(store, FolderStore) else store.uri
    return _Origin(uri, store.manifest.sha256)


def _read_held(out: Path, origin: _Origin) -> Manifest | None:
    """The manifest in `out`, if it holds a release; `None` if it is empty or half-way.

    Raises:
        FileExistsError: It holds something else, or another version of the release.
    """
    if not out.exists():
        return None
    if not out.is_dir():
        raise FileExistsError(f"{out}: is a file; choose another --out")
    manifest = None
    if (out / MANIFEST_NAME).is_file():
        manifest = Manifest.from_path(out / MANIFEST_NAME, name=str(out / MANIFEST_NAME))
        there = _Origin(f"the release {manifest.name!r}", manifest.sha256)
        if manifest.partial_of is not None:
            there = _Origin(manifest.partial_of.uri, manifest.partial_of.manifest_sha256)
    elif (out / DOWNLOAD_NOTE_NAME).is_file():
        note = json.loads((out / DOWNLOAD_NOTE_NAME).read_bytes())
        there = _Origin(note["uri"], note["manifest_sha256"])
    elif {path.name for path in out.iterdir()} <= _FIRST_NAMES:
        return None  # empty, or killed before its first step was done
    else:
        raise FileExistsError(f"{out}: exists and is no release; choose another --out")
    if there.manifest_sha256 != origin.manifest_sha256:
        raise FileExistsError(
            f"{out}: holds {there.uri}, which is not the same as {origin.uri}; ask for what is "
            "there, or choose another --out"
        )
    return manifest


@contextlib.contextmanager
def _alone_in(out: Path) -> Iterator[None]:
    path = out / _LOCK_NAME
    with opened(path, os.O_RDWR | os.O_CREAT) as fd:
        if try_lock(fd) is False:
            raise FileExistsError(f"{out}: another download into it is running; wait for its end")
        try:
            yield
        finally:
            path.unlink(missing_ok=True)


def _check_space(out: Path, manifest: Manifest, names: Sequence[str]) -> None:
    missing = [name for name in names if not (out / name).is_file()]
    needed = sum(manifest.files[name].bytes for name in missing)
    free = shutil.disk_usage(out).free
    if needed > free:
        raise ValueError(
            f"{out}: {format_bytes(needed)} to fetch, only {format_bytes(free)} are free there; "
            "choose less by --split or --scenes, or another --out"
        )


def _fetch_files(store: Store, names: Sequence[str], out: Path, *, jobs: int) -> None:
    """Has every file at its place in `out`, verified."""

    def work(name: str, progress: Progress) -> None:
        path, entry = out / name, store.manifest.files[name]
        if (
            path.is_file()
            and path.stat().st_size == entry.bytes
            and sha256_of(path) == entry.sha256
        ):
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        if isinstance(store, HubStore) and not store.is_local(name):
            store.fetch_to(name, path, progress=progress)
        else:
            _put(path, store.read(name))

    sizes = {name: store.manifest.files[name].bytes for name in names}
    failures = transfer(sizes, work, jobs=jobs, label=f"{store.manifest.name}: fetching")
    _raise_failures(failures, len(names))


def _raise_failures(failures: dict[str, OSError | ValueError], total: int) -> None:
    if not failures:
        return
    broken = all(isinstance(error, IntegrityError) for error in failures.values())
    advice = "" if broken else "; run the same command again to go on, what is here is kept"
    raise ConnectionError(
        f"{len(failures)} of {total} files could not be had{advice}:{failure_list(failures)}"
    )


def _manifest_of(
    release: Release,
    names: Sequence[str],
    held: Manifest | None,
    selection: Selection,
    origin: _Origin,
) -> Manifest:
    """What the folder says of itself: the release's own manifest where it is all there."""
    source = release.manifest
    if len(names) == len(source.files):
        return source
    choice = selection.scene_choice
    if source.partial_of is not None and selection.scene_ids is None:
        choice = {s: source.partial_of.scene_ids[s] for s in selection.splits}
    if held is not None and held.partial_of is not None:
        choice = join_scenes(held.partial_of.scene_ids, choice)
    there = tuple(split for split in SPLITS if source.num_rows("index", split))
    starts = {k: row for split in SPLITS for k, row in source.first_rows(split).items()}
    partial = Partial(
        uri=origin.uri,
        manifest_sha256=origin.manifest_sha256,
        scene_ids=choice,
        splits=there if source.partial_of is None else source.partial_of.splits,
        first_rows={name: starts[name] for name in names if name in starts},
    )
    files = {name: source.files[name] for name in names}
    return dataclasses.replace(source, files=files, partial_of=partial)


def _read_card(store: Store) -> bytes | None:
    """The page of the release, if it has one; the manifest makes no promise of it."""
    if isinstance(store, FolderStore):
        path = store.root / _CARD_NAME
        return path.read_bytes() if path.is_file() else None
    assert isinstance(store, HubStore)
    repository = HubRepository(store.repo_id, cache_folder() / "hub")
    try:
        return b"".join(repository.content(store.commit, _CARD_NAME, 0, _MAX_CARD_BYTES))
    except FileNotFoundError:
        return None


def _put(path: Path, payload: bytes) -> None:
    """Puts a file in place, whole or not at all."""
    partial = path.with_name(path.name + PART_SUFFIX)
    with partial.open("wb") as stream:
        stream.write(payload)
        stream.flush()
        os.fsync(stream.fileno())
    os.replace(partial, path)


def _clean(out: Path) -> None:
    """Removes what only a download under way needs."""
    (out / DOWNLOAD_NOTE_NAME).unlink(missing_ok=True)
    for path in out.glob(f"*/*{PART_SUFFIX}"):
        path.unlink(missing_ok=True)
