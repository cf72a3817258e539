"""Where the files of a release are: a folder, or a pinned revision of a Hub dataset."""

from __future__ import annotations

import dataclasses
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

from affectsim_data.releases.hub import HubStore
from affectsim_data.releases.manifest import MANIFEST_NAME, Manifest, read_verified

__all__ = ["FolderStore", "HubStore", "Store", "open_store"]

DOWNLOAD_NOTE_NAME = ".download.json"
"""In a folder that a download has not finished: what it will be."""
_HUB_URI = re.compile(r"hf://datasets/([\w.-]+/[\w.-]+)(?:@([\w./-]+))?/?")


class Store(Protocol):
    """Gives the contents of a release's files, checked against its manifest."""

    @property
    def manifest(self) -> Manifest:
        """Its table of contents."""
        ...

    @property
    def uri(self) -> str:
        """What the release is called in samples, errors and checkpoints."""
        ...

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest.

        Raises:
            IntegrityError: They are not what the manifest promises.
        """
        ...

    def prefetch(self, names: Iterable[str]) -> None:
        """Has files fetched in the background where they are not at hand; returns at once."""
        ...

    def is_local(self, name: str) -> bool:
        """Whether reading a file of the manifest needs no network."""
        ...


@dataclasses.dataclass
class FolderStore:
    """A release in a folder."""

    root: Path

    def __post_init__(self) -> None:
        self.uri = str(self.root)
        path = self.root / MANIFEST_NAME
        if not path.is_file():
            remedy = f"build one with `affectsim build RECIPE --out {self.root}`"
            if (self.root / DOWNLOAD_NOTE_NAME).is_file():
                remedy = "its download did not end: run the same `affectsim download` again"
            raise FileNotFoundError(
                f"{self.root}: no {MANIFEST_NAME}, so this is no release or an unfinished one; "
                f"{remedy}"
            )
        self.manifest = Manifest.from_path(path, name=str(path))
        self._check_inventory()

    def _check_inventory(self) -> None:
        folders = {name.rpartition("/")[0] for name in self.manifest.files}
        there = {folder: self._files(folder) for folder in folders}
        parts = {name: name.rpartition("/") for name in self.manifest.files}
        missing = [name for name, (folder, _, file) in parts.items() if file not in there[folder]]
        if missing:
            listed = ", ".join(missing[:20]) + (" ..." if len(missing) > 20 else "")
            raise FileNotFoundError(
                f"{self.root}: {len(missing)} of {len(self.manifest.files)} files of its manifest "
                f"are missing: {listed}; {self._remedy}"
            )

    def _files(self, folder: str) -> set[str]:
        """Names of the files in a folder; far quicker than asking for each."""
        try:
            with os.scandir(self.root / folder) as entries:
                return {entry.name for entry in entries if entry.is_file()}
        except (FileNotFoundError, NotADirectoryError):
            return set()

    @property
    def _remedy(self) -> str:
        return f"delete {self.root} and build or fetch the release again"

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest, checked against it."""
        label, entry = f"{self.root}/{name}", self.manifest.files[name]
        return read_verified(self.root / name, label, entry, remedy=self._remedy)

    def prefetch(self, names: Iterable[str]) -> None:
        """Does nothing: everything is at hand."""

    def is_local(self, name: str) -> bool:
        """Whether reading a file of the manifest needs no network: always."""
        return name in self.manifest.files


def open_store(source: str | Path) -> Store:
    """The store of a folder or of `hf://datasets/ORG/NAME@REVISION`.

    Raises:
        FileNotFoundError: Nothing there, or not all of it.
        ValueError: A malformed address or manifest.
    """
    text = str(source)
    if not text.startswith("hf:"):
        return FolderStore(Path(source).expanduser())
    match = _HUB_URI.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r}: expected hf://datasets/ORG/NAME@REVISION")
    return HubStore(match[1], match[2] or "main")
