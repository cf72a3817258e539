"""Where the files of a release are: a folder, or a pinned revision of a Hub dataset."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Protocol

from affectsim_data.errors import IntegrityError
from affectsim_data.releases.manifest import MANIFEST_NAME, Manifest, read_verified

__all__ = ["FolderStore", "HubStore", "Store", "open_store"]

_HUB_URI = re.compile(r"hf://datasets/([\w.-]+/[\w.-]+)(?:@([\w./-]+))?/?")


class Store(Protocol):
    """Gives the contents of a release's files, checked against its manifest."""

    manifest: Manifest
    uri: str
    """What the release is called in samples, errors and checkpoints."""

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest.

        Raises:
            IntegrityError: They are not what the manifest promises.
        """
        ...

    def prefetch(self, names: Iterable[str]) -> None:
        """Has files fetched in the background where they are not at hand; returns at once."""
        ...


@dataclasses.dataclass
class FolderStore:
    """A release in a folder."""

    root: Path

    def __post_init__(self) -> None:
        self.uri = str(self.root)
        path = self.root / MANIFEST_NAME
        if not path.is_file():
            raise FileNotFoundError(
                f"{self.root}: no {MANIFEST_NAME}, so this is no release or an unfinished one; "
                f"build one with `affectsim build RECIPE --out {self.root}`"
            )
        self.manifest = Manifest.from_path(path, name=str(path))
        self._check_inventory()

    def _check_inventory(self) -> None:
        missing = [name for name in self.manifest.files if not (self.root / name).is_file()]
        if missing:
            listed = ", ".join(missing[:20]) + (" ..." if len(missing) > 20 else "")
            raise FileNotFoundError(
                f"{self.root}: {len(missing)} of {len(self.manifest.files)} files of its manifest "
                f"are missing: {listed}; {self._remedy}"
            )

    @property
    def _remedy(self) -> str:
        return f"delete {self.root} and build or fetch the release again"

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest, checked against it."""
        label, entry = f"{self.root}/{name}", self.manifest.files[name]
        return read_verified(self.root / name, label, entry, remedy=self._remedy)

    def prefetch(self, names: Iterable[str]) -> None:
        """Does nothing: everything is at hand."""


@dataclasses.dataclass
class HubStore:
    """A release on the Hugging Face Hub; files are fetched when first asked for."""

    repo_id: str
    revision: str

    def __post_init__(self) -> None:
        manifest_path = self._download(MANIFEST_NAME)
        # The cache lays files out as snapshots/COMMIT/NAME: pin every later fetch to that commit.
        self.commit = manifest_path.parent.name
        self.uri = f"hf://datasets/{self.repo_id}@{self.commit}"
        self.manifest = Manifest.from_path(manifest_path, name=f"{self.uri}/{MANIFEST_NAME}")

    def _download(self, name: str, *, force: bool = False) -> Path:
        from huggingface_hub import hf_hub_download
        from huggingface_hub.errors import (
            EntryNotFoundError,
            HFValidationError,
            LocalEntryNotFoundError,
            RepositoryNotFoundError,
            RevisionNotFoundError,
        )

        place = f"hf://datasets/{self.repo_id}@{self.revision}"
        try:
            return Path(
                hf_hub_download(
                    self.repo_id,
                    name,
                    repo_type="dataset",
                    revision=getattr(self, "commit", self.revision),
                    force_download=force,
                )
            )
        except RevisionNotFoundError as error:
            raise FileNotFoundError(f"{place}: there is no such revision") from error
        except RepositoryNotFoundError as error:
            raise FileNotFoundError(
                f"{place}: no such dataset, or it is private; `hf auth login` if it is yours"
            ) from error
        except LocalEntryNotFoundError as error:
            raise FileNotFoundError(
                f"{place}: {name} is not in the local cache and the Hub cannot be reached; "
                "check the network, and HF_HUB_OFFLINE"
            ) from error
        except EntryNotFoundError as error:
            raise FileNotFoundError(f"{place}: has no {name}; the release is incomplete") from error
        except HFValidationError as error:
            raise ValueError(f"{place}: {error}") from error
        except Exception as error:  # what the client's transport raises differs by its version
            raise ConnectionError(f"{place}: fetching {name} failed: {error}") from error

    def prefetch(self, names: Iterable[str]) -> None:
        """Does nothing yet."""

    def read(self, name: str) -> bytes:
        """Contents of a file of the manifest: fetched, checked, fetched once more if broken."""
        path = self._download(name)
        label, entry = f"{self.uri}/{name}", self.manifest.files[name]
        try:
            remedy = "the local copy is damaged and the Hub cannot be reached; check the network"
            return read_verified(path, label, entry, remedy=remedy)
        except IntegrityError as damage:
            try:
                path = self._download(name, force=True)
            except ConnectionError as error:
                raise damage from error
            remedy = "what the Hub serves is not what the manifest says; tell the publisher"
            return read_verified(path, label, entry, remedy=remedy)


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
