"""Folders of the user's own that a recipe reads: what it needs, and what was given."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

from affectsim_data.builders.recipes import Recipe
from affectsim_data.releases.manifest import Source

__all__ = ["SourceGiven", "find_sources", "needed_sources", "read_sources"]

SourceGiven = Path | Mapping[str, Path] | None
"""One folder for a recipe that reads one source, or folders by name."""
_KINDS: dict[str, tuple[str, str, str]] = {
    "motions": ("a corpus", "it", "the corpus"),
    "scenes": ("scenes", "them", "the scenes"),
}
_NAMED = re.compile(r"([\w.+-]+)=(.+)", re.DOTALL)


def needed_sources(recipe: Recipe) -> dict[str, Source]:
    """What a recipe reads from folders of the user's own, by name: its corpora, then its scenes."""
    return {one.name: one for one in recipe.needs}


def read_sources(values: Sequence[str], recipe: Recipe) -> dict[str, Path]:
    """Folders by name, of arguments `NAME=FOLDER`, or `FOLDER` alone for the one there is.

    Args:
        values: As they were given.
        recipe: Says which names there are.

    Raises:
        ValueError: A name is unknown, lacks or comes twice, or a folder serves two: all that is
            wrong, and what the recipe needs.
        FileNotFoundError: Nothing else is wrong than that folders are not there.
    """
    needed = needed_sources(recipe)
    given: list[tuple[str, Path]] = []
    for value in values:
        match = _NAMED.fullmatch(value)
        # A folder may have "=" in its name.
        if match is not None and (match[1] in needed or not Path(value).exists()):
            given.append((match[1], Path(match[2])))
        else:
            given.append((next(iter(needed)) if len(needed) == 1 else "", Path(value)))
    return _checked(given, recipe)


def find_sources(recipe: Recipe, given: SourceGiven) -> dict[str, Path]:
    """Folders by name, of what a caller gave.

    Raises:
        ValueError: As `read_sources`.
        FileNotFoundError: As `read_sources`.
    """
    if isinstance(given, Mapping):
        return _checked([(name, Path(folder)) for name, folder in given.items()], recipe)
    if given is None:
        return _checked([], recipe)
    needed = needed_sources(recipe)
    return _checked([(next(iter(needed)) if len(needed) == 1 else "", Path(given))], recipe)


def _checked(given: Sequence[tuple[str, Path]], recipe: Recipe) -> dict[str, Path]:
    """The folders by name, if they are what the recipe needs; a name is empty if none was given."""
    needed = needed_sources(recipe)
    if not needed:
        if given:
            raise ValueError(
                f"recipe {recipe.name!r} reads no folder of your own, got {given[0][1]}; "
                "leave out --source"
            )
        return {}
    if len(needed) == 1 and not given:
        raise ValueError(_none_given(recipe, next(iter(needed.values()))))
    absent = [name for name, folder in given if name in needed and not _is_folder(folder)]
    wrong = _wrong_counts(given, needed) + _unknown(given, needed) + _shared(given)
    if not wrong and not absent:
        return {name: folder.expanduser() for name, folder in given}
    wrong += [
        f"{name}: expected a folder with {_KINDS[needed[name].kind][2]} at {folder}, "
        "got no such folder"
        for name, folder in given
        if name in absent
    ]
    good = [f"{name}: {folder}" for name, folder in given if name in needed and name not in absent]
    lines = [f"recipe {recipe.name!r} reads {len(needed)} of your folders", *good, *wrong]
    text = "\n  ".join(lines) + "\ngive each as --source NAME=FOLDER"
    raise (FileNotFoundError if len(wrong) == len(absent) else ValueError)(text)


def _is_folder(folder: Path) -> bool:
    return folder.expanduser().is_dir()


def _none_given(recipe: Recipe, one: Source) -> str:
    what, it, _ = _KINDS[one.kind]
    return (
        f"recipe {recipe.name!r} reads {what}: add --source FOLDER, where your copy of "
        f"{it} is; {one.name}{_obtain(one)}"
    )


def _obtain(one: Source) -> str:
    return f" ({one.obtain})" if one.obtain else ""


def _wrong_counts(given: Sequence[tuple[str, Path]], needed: Mapping[str, Source]) -> list[str]:
    """Sources that were not given, or more than once."""
    lines = []
    for name, one in needed.items():
        folders = [str(folder) for other, folder in given if other == name]
        if not folders:
            lines.append(f"{name}: not given, a folder with {_KINDS[one.kind][2]}{_obtain(one)}")
        elif len(folders) > 1:
            lines.append(f"{name}: given {len(folders)} times: {', '.join(folders)}")
    return lines


def _unknown(given: Sequence[tuple[str, Path]], needed: Mapping[str, Source]) -> list[str]:
    """Folders without a name, or with one that the recipe does not read."""
    lines = []
    for name, folder in given:
        if not name:
            lines.append(f"{folder}: given without a name")
        elif name not in needed:
            close = difflib.get_close_matches(name, needed, n=1)
            hint = f"; is it {close[0]!r}?" if close else ""
            lines.append(f"{name}: given, but the recipe does not read it{hint}")
    return lines


def _shared(given: Sequence[tuple[str, Path]]) -> list[str]:
    """Folders that two names share: each would read the files of the other."""
    users: dict[Path, list[str]] = {}
    for name, folder in given:
        names = users.setdefault(folder.expanduser().resolve(), [])
        if name and name not in names:
            names.append(name)
    return [
        f"{' and '.join(names)}: one folder for both: {folder}"
        for folder, names in users.items()
        if len(names) > 1
    ]
