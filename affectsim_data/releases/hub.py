"""A release on the Hugging Face Hub, read through a cache on this machine.

Files are fetched when they are first asked for, or ahead of that, checked against the manifest, and
kept in `hub` inside the user's cache, up to AFFECTSIM_CACHE_LIMIT bytes. Processes share them. What
a cache cannot take, because it is read-only or all it holds is in use, is read past it.
"""

from __future__ import annotations

import functools
import hashlib
import warnings
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, TypeVar

from affectsim_data.errors import IntegrityError
from affectsim_data.releases.builtin import cache_folder
from affectsim_data.releases.cache_limits import cache_limit
from affectsim_data.releases.fetching import is_offline
from affectsim_data.releases.hub_repository import HubRepository
from affectsim_data.releases.manifest import Manifest, sha256_of
from affectsim_data.releases.object_cache import CacheBypass, ObjectCache
from affectsim_data.releases.part_files import (
    PART_SUFFIX,
    REMEDY,
    Delivery,
    Progress,
    check,
    locked_part,
)
from affectsim_data.releases.prefetching import Prefetcher

__all__ = ["HubStore"]

_Result = TypeVar("_Result")
_TRIES = 3


class HubStore:
    """A release on the Hugging Face Hub, pinned to a commit.

    A copy in another process, pickled or forked, has the same commit and cache, and asks nobody.
    """

    def __init__(self, repo_id: str, revision: str = "main") -> None:
        """Finds the commit of a revision.

        Args:
            repo_id: `ORG/NAME` of a dataset.
            revision: Branch, tag or commit.

        Raises:
            FileNotFoundError: No such dataset or revision, or it is no release, or the Hub cannot
                be reached and the cache does not know it.
            ValueError: The Hub allows no such name, what it has is no manifest, or
                AFFECTSIM_CACHE_LIMIT is no number of bytes.
        """
        cache = ObjectCache(cache_folder() / "hub", max_bytes=cache_limit())
        commit = HubRepository(repo_id, cache.root).commit_of(revision)
        self._set_up(repo_id, commit, cache)
        self.manifest  # noqa: B018  # an error about it belongs here

    def _set_up(self, repo_id: str, commit: str, cache: ObjectCache) -> None:
        self.repo_id = repo_id
        self.commit = commit
        self.uri = f"hf://datasets/{repo_id}@{commit}"
        self._cache = cache
        self._repository = HubRepository(repo_id, cache.root)
        self._prefetcher = Prefetcher(self._fetch_ahead)
        self._warned = False

    def __repr__(self) -> str:
        return f"HubStore({self.uri!r})"

    def __getstate__(self) -> dict[str, Any]:
        return {"repo_id": self.repo_id, "commit": self.commit, "cache": self._cache}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self._set_up(**state)

    @functools.cached_property
    def manifest(self) -> Manifest:
        """Its table of contents."""
        return self._repository.manifest(self.commit)

    def is_local(self, name: str) -> bool:
        """Whether reading a file of the manifest needs no network."""
        return self._cache.has(self.manifest.files[name])

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest: fetched if need be, checked.

        What is damaged, here or on its way, is fetched once more.

        Raises:
            IntegrityError: They are not what the manifest promises.
            FileNotFoundError: It is not here and the Hub has it not, or cannot be reached.
            ConnectionError: The Hub does not give all of it.
            CacheError: It is larger than AFFECTSIM_CACHE_LIMIT, or the disk is full.
        """
        damage = None
        try:
            payload = self._read_cached(name)
        except IntegrityError as error:
            payload, damage = None, error
        if payload is not None:
            return payload
        self._prefetcher.forget(name)
        try:
            return self._obtain(name)
        except (ConnectionError, FileNotFoundError) as error:
            if damage is None:
                raise
            raise damage from error

    def _read_cached(self, name: str) -> bytes | None:
        return self._cache.read(self.manifest.files[name], label=f"{self.uri}/{name}")

    def _obtain(self, name: str) -> bytes:
        """The contents of a file by way of the cache, or past it where it cannot take the file."""
        for _ in range(_TRIES):
            try:
                self.fetch(name)
            except CacheBypass as error:
                self._warn(error)
                break
            try:
                payload = self._read_cached(name)
            except IntegrityError:  # in a folder that cannot be mended
                break
            if payload is not None:
                return payload
            # Others needed the room at once: their turn, then ours again.
        return _twice(lambda: self._fetch_past_cache(name))

    def _warn(self, error: CacheBypass) -> None:
        if not self._warned:
            self._warned = True
            warnings.warn(f"{error}; reading past the cache, which is slow", stacklevel=4)

    def _fetch_past_cache(self, name: str) -> bytes:
        order = self._delivery(name)
        payload = b"".join(order.content(0))
        digest = hashlib.sha256(payload).hexdigest()
        check(order.entry, len(payload), digest, label=order.label, remedy=REMEDY)
        return payload

    def fetch(self, name: str, *, progress: Progress | None = None) -> None:
        """Has a file of the manifest in the cache, checked; fetched once more if it is broken.

        What another process is fetching is waited for.

        Args:
            name: Of the file.
            progress: Called with numbers of new bytes; a negative one if they were thrown away.

        Raises:
            IntegrityError: The Hub gave something else, twice.
            FileNotFoundError: It is not on the Hub, or the Hub cannot be reached.
            ConnectionError: The Hub does not give all of it.
            CacheError: The cache cannot take it; the message says why.
        """
        if not self.is_local(name):
            _twice(lambda: self._cache.store(self._delivery(name, progress=progress)))

    def _fetch_ahead(self, name: str) -> None:
        if not self.is_local(name):
            self._cache.store(self._delivery(name, retries=1))

    def _delivery(
        self, name: str, *, progress: Progress | None = None, retries: int = 5
    ) -> Delivery:
        entry = self.manifest.files[name]

        def content(start: int) -> Iterable[bytes]:
            return self._repository.content(self.commit, name, start, entry.bytes, retries=retries)

        return Delivery(entry, content, label=f"{self.uri}/{name}", progress=progress)

    def fetch_to(self, name: str, path: Path, *, progress: Progress | None = None) -> None:
        """Has a file of the manifest at a path, checked, without a copy in the cache.

        Begun at `path` + `.partial`, where a run that was killed is taken up again.

        Args:
            name: Of the file.
            path: Where to put it; its folder exists.
            progress: Called with numbers of new bytes; a negative one if they were thrown away.

        Raises:
            IntegrityError: The Hub gave something else, twice.
            FileNotFoundError: It is not on the Hub, or the Hub cannot be reached.
            ConnectionError: The Hub does not give all of it.
        """
        order = self._delivery(name, progress=progress)

        def done() -> bool:
            size = path.stat().st_size if path.is_file() else -1
            return size == order.entry.bytes and sha256_of(path) == order.entry.sha256

        def attempt() -> None:
            with locked_part(path.with_name(path.name + PART_SUFFIX), done=done) as part:
                if part is not None:
                    part.complete(order)
                    part.path.replace(path)

        if not done():
            _twice(attempt)

    def prefetch(self, names: Iterable[str]) -> None:
        """Has files fetched in the background where they are not at hand; returns at once.

        What fails there fails in `read`.
        """
        if not is_offline():
            self._prefetcher.add(name for name in names if not self.is_local(name))


def _twice(attempt: Callable[[], _Result]) -> _Result:
    """What an attempt gives, repeated once if it gave something broken."""
    try:
        return attempt()
    except IntegrityError:
        return attempt()
