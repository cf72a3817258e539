"""A dataset repository on the Hub, and what this machine remembers of it."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import re
import tempfile
import uuid
import warnings
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import quote

from affectsim_data.releases.fetching import hub_headers, is_offline, stream, with_retries
from affectsim_data.releases.hub_errors import explained, is_unreachable, not_here
from affectsim_data.releases.manifest import MANIFEST_NAME, MAX_MANIFEST_BYTES, Manifest

__all__ = ["HubRepository"]

_COMMIT = re.compile("[0-9a-f]{40}")
_RETRIES = 5


@dataclasses.dataclass(frozen=True)
class HubRepository:
    """A dataset repository; what its revisions are is kept in a folder.

    - `refs/ORG--NAME/REVISION`: the commit a revision last stood for
    - `manifests/ORG--NAME/COMMIT.SHA256.json`: the manifest of a commit, under its own hash
    """

    repo_id: str
    cache: Path
    """The folder."""

    def place(self, revision: str) -> str:
        """The address of a revision."""
        return f"hf://datasets/{self.repo_id}@{revision}"

    def commit_of(self, revision: str) -> str:
        """The commit a revision stands for: asked of the Hub, or remembered if that is impossible.

        Raises:
            FileNotFoundError: There is no such dataset or revision, it is no release, or the Hub
                cannot be reached and nothing is remembered.
            ConnectionError: The Hub answers, but does not help.
            ValueError: The Hub allows no such name.
        """
        self._check_name(revision)
        if _COMMIT.fullmatch(revision) and self._kept_manifest(revision):
            return revision
        ref = self._folder("refs") / quote(revision, safe="")
        remembered = ref.read_text().strip() if ref.is_file() else ""
        known = bool(_COMMIT.fullmatch(remembered)) and self._kept_manifest(remembered) is not None
        if is_offline():
            if known:
                return remembered
            raise not_here(self.place(revision), MANIFEST_NAME)
        try:
            commit = self._ask_commit(revision, retries=0 if known else _RETRIES)
        except Exception as error:  # what the client's transport raises differs by its version
            if known and is_unreachable(error):
                what = f"the Hub cannot be reached ({error}); going on with commit {remembered}"
                warnings.warn(f"{self.place(revision)}: {what}", stacklevel=2)
                return remembered
            raise explained(error, self.place(revision), MANIFEST_NAME) from error
        if not _COMMIT.fullmatch(commit):
            where = self._url(revision, MANIFEST_NAME)
            raise ConnectionError(f"{where}: X-Repo-Commit is {commit!r}; is HF_ENDPOINT a Hub?")
        if commit != remembered:
            _put(ref, commit.encode())
        return commit

    def _check_name(self, revision: str) -> None:
        from huggingface_hub.errors import HFValidationError

        try:
            self._url(revision, MANIFEST_NAME)
        except HFValidationError as error:
            raise ValueError(f"{self.place(revision)}: {error}") from error

    def _ask_commit(self, revision: str, *, retries: int) -> str:
        from huggingface_hub import constants, get_hf_file_metadata

        url, seconds = self._url(revision, MANIFEST_NAME), constants.HF_HUB_ETAG_TIMEOUT
        found = with_retries(
            lambda: get_hf_file_metadata(url, timeout=seconds, headers=hub_headers()),
            retries=retries,
        )
        return found.commit_hash or ""

    def _url(self, revision: str, name: str) -> str:
        from huggingface_hub import hf_hub_url

        return str(hf_hub_url(self.repo_id, name, repo_type="dataset", revision=revision))

    def _folder(self, kind: str) -> Path:
        return self.cache / kind / self.repo_id.replace("/", "--")

    def content(
        self, commit: str, name: str, start: int, most: int, *, retries: int = _RETRIES
    ) -> Iterator[bytes]:
        """The bytes of a file from `start` on, at most one piece more than makes `most`.

        Raises:
            FileNotFoundError: It is not on the Hub, or the Hub cannot be reached.
            ConnectionError: It cannot be had whole.
        """
        place, begun = self.place(commit), False
        if is_offline():
            raise not_here(place, name)
        try:
            for chunk in stream(self._url(commit, name), start, most, retries=retries):
                begun = True
                yield chunk
        except Exception as error:  # what the client's transport raises differs by its version
            raise explained(error, place, name, begun=begun) from error

    def manifest(self, commit: str) -> Manifest:
        """The manifest of a commit: kept here, else fetched.

        Raises:
            FileNotFoundError: It cannot be had.
            ValueError: It is no manifest, or of a schema this version cannot read.
        """
        name = f"{self.place(commit)}/{MANIFEST_NAME}"
        kept = self._kept_manifest(commit)
        if kept is not None:
            return Manifest.from_path(kept, name=name)
        payload = b"".join(self.content(commit, MANIFEST_NAME, 0, MAX_MANIFEST_BYTES))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / MANIFEST_NAME
            path.write_bytes(payload)
            manifest = Manifest.from_path(path, name=name)
        digest = hashlib.sha256(payload).hexdigest()
        _put(self._folder("manifests") / f"{commit}.{digest}.json", payload)
        return manifest

    def _kept_manifest(self, commit: str) -> Path | None:
        for path in self._folder("manifests").glob(f"{commit}.*.json"):
            with contextlib.suppress(OSError):
                if hashlib.sha256(path.read_bytes()).hexdigest() == path.name.split(".")[1]:
                    return path
        return None


def _put(path: Path, payload: bytes) -> None:
    """Keeps a small file, whole or not at all; a cache that is read-only or full does without."""
    partial = path.with_name(f".{uuid.uuid4().hex}")
    with contextlib.suppress(OSError):
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            partial.write_bytes(payload)
            partial.replace(path)
        finally:
            partial.unlink(missing_ok=True)
