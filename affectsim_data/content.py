"""Finds the data folders `builders/`, `cards/`, `loaders/` and `schemas/` of the package."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

__all__ = ["ContentFolder", "content_names", "content_path"]

ContentFolder = Literal["builders", "cards", "loaders", "schemas"]

_PACKAGE = Path(__file__).resolve().parent


def content_path(folder: ContentFolder, name: str = "") -> Path:
    """Path of a data file or folder that ships with the package.

    An installed wheel carries the folders as `affectsim_data/content/FOLDER`; in a checkout they
    stand beside the package.

    Args:
        folder: Which of the four data folders.
        name: File inside it; empty for the folder itself. May not lead out of the folder.

    Raises:
        FileNotFoundError: There is no such file; the message lists those there are.
        ValueError: `name` leads out of the folder.
    """
    root = _PACKAGE / "content" / folder
    if not root.is_dir():
        root = _PACKAGE.parent / folder
    path = (root / name).resolve()
    if path != root and not path.is_relative_to(root):
        raise ValueError(f"{folder}/{name} leads out of {folder}/")
    if not path.exists():
        there = ", ".join(sorted(entry.name for entry in root.glob("*"))) or "nothing"
        raise FileNotFoundError(f"no {name!r} in {folder}/ ({root}); there is: {there}")
    return path


def content_names(folder: ContentFolder, suffix: str) -> list[str]:
    """Names, without suffix and sorted, of the files of a data folder, e.g. its `.toml` recipes."""
    return sorted(path.stem for path in content_path(folder).glob(f"*{suffix}"))
