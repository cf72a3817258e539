"""One way to open a release, wherever it is."""

from __future__ import annotations

import weakref
from pathlib import Path

from affectsim_data.releases.builtin import BUILTIN_RELEASES, builtin_release_path
from affectsim_data.releases.release import Release
from affectsim_data.releases.stores import Store, open_store

__all__ = ["open_release"]

_open: weakref.WeakValueDictionary[str, Release] = weakref.WeakValueDictionary()


def open_release(source: str | Path = "mini") -> Release:
    """Opens a built-in release, a folder or a revision of a Hub dataset.

    Args:
        source: `mini`, a folder, or `hf://datasets/ORG/NAME@REVISION`.

    Raises:
        FileNotFoundError: Nothing there, or not all of it; missing files are listed.
        ValueError: A malformed address or manifest.
    """
    if source in BUILTIN_RELEASES and not Path(source).is_dir():
        return _shared(open_store(builtin_release_path(str(source))))
    if not str(source).startswith("hf:") and not Path(source).expanduser().exists():
        raise FileNotFoundError(
            f"no release {str(source)!r}: expected a folder with a MANIFEST.json, "
            f"hf://datasets/ORG/NAME@REVISION, or one of: {', '.join(BUILTIN_RELEASES)}"
        )
    return _shared(open_store(source))


def _shared(store: Store) -> Release:
    """The release of this place and content that is already open, else a new one.

    Datasets of several splits and conditions then read, hold and upload every scene once.
    """
    release = _open.get(store.uri)
    if release is None or release.manifest != store.manifest:
        release = _open[store.uri] = Release(store)
    return release
