"""What a build depends on, as hashes: only what was made of the same things can be gone on with."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.sources import SourceGiven
from affectsim_data.engines.code import code_fingerprint

__all__ = ["build_fingerprint"]

_NAMED = (".toml", ".csv", ".tsv")
"""Ends of the names of files that a recipe may refer to."""


def build_fingerprint(recipe: Recipe, source: SourceGiven) -> str:
    """Of all that decides what a build makes; not of how many processes make it.

    Args:
        recipe: With the options that change it.
        source: The user's own copies. Of these, paths, sizes and times of change count.
    """
    document = {
        "code": code_fingerprint(),
        "recipe": hashlib.sha256(recipe.path.read_bytes()).hexdigest(),
        "options": repr(recipe.scenes),
        "files": {str(path): _sha256(path) for path in _named_files(recipe.document, recipe.path)},
        "sources": {name: _listing(folder) for name, folder in _folders(source)},
    }
    return hashlib.sha256(json.dumps(document, sort_keys=True).encode()).hexdigest()


def _folders(source: SourceGiven) -> list[tuple[str, Path]]:
    if source is None:
        return []
    return sorted(source.items()) if isinstance(source, Mapping) else [("", source)]


def _listing(folder: Path) -> list[str]:
    """The folder and a line per file of it."""
    folder = folder.expanduser().resolve()
    lines = []
    for path in folder.rglob("*"):
        if path.is_file():
            state = path.stat()
            name = path.relative_to(folder).as_posix()
            lines.append(f"{name} {state.st_size} {state.st_mtime_ns}")
    return [str(folder), *sorted(lines)]


def _named_files(document: Any, path: Path) -> list[Path]:
    """Files that a recipe names anywhere, and files that those recipes name, sorted."""
    found: set[Path] = set()
    waiting = [(document, path.parent)]
    while waiting:
        tables, folder = waiting.pop()
        for name in _texts(tables):
            for place in (folder / name, Path(name)):
                if name.endswith(_NAMED) and place.is_file() and place not in found:
                    found.add(place)
                    if place.suffix == ".toml":
                        text = place.read_text(encoding="utf-8")
                        waiting.append((tomllib.loads(text), place.parent))
    return sorted(found)


def _texts(document: Any) -> Iterator[str]:
    if isinstance(document, str):
        yield document
    elif isinstance(document, Mapping):
        for value in document.values():
            yield from _texts(value)
    elif isinstance(document, list | tuple):
        for value in document:
            yield from _texts(value)


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
