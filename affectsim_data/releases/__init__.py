"""Releases on disk and on the Hub: manifest, shards, and reading them back."""

from affectsim_data.releases.builtin import builtin_release_path
from affectsim_data.releases.manifest import MANIFEST_NAME, FileEntry, Manifest
from affectsim_data.releases.opening import open_release
from affectsim_data.releases.release import Release
from affectsim_data.releases.writing import ReleaseWriter

__all__ = [
    "MANIFEST_NAME",
    "FileEntry",
    "Manifest",
    "Release",
    "ReleaseWriter",
    "builtin_release_path",
    "open_release",
]
