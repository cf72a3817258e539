"""Files of a dataset: found by name inside its folder and nowhere else, read within bounds."""

from __future__ import annotations

import dataclasses
import json
import os
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from affectsim_data.builders.habitat.fields import Table

__all__ = ["DatasetFolder", "OutsideError", "read_json"]

MAX_JSON_BYTES = 64 * 2**20
MAX_FILES = 200_000
"""Listed in one dataset."""
_GLOB = re.compile(r"[*?\[]")
_DRIVE_OR_SCHEME = re.compile(r"^[A-Za-z][A-Za-z0-9+.-]*:")


class OutsideError(ValueError):
    """A name leads out of the folder of its dataset."""


@dataclasses.dataclass(frozen=True)
class DatasetFolder:
    """The folder of a dataset; all names are looked up in it and below."""

    root: Path
    """Its real path, links resolved."""

    def inside(self, base: Path, name: str) -> Path:
        """The path that a file in `base` calls `name`; it need not exist.

        Raises:
            OutsideError: It is absolute, or `..` or a link leads out of the dataset.
        """
        forward = name.replace("\\", "/")
        if not forward or "\0" in forward:
            raise OutsideError(f"{name!r} names no file")
        if forward.startswith("/") or _DRIVE_OR_SCHEME.match(forward):
            raise OutsideError(f"{name!r} is no path relative to the file that names it")
        path = Path(os.path.normpath(base / forward))
        if not path.is_relative_to(self.root):
            raise OutsideError(f"{name!r} leads out of the dataset's folder")
        if not path.resolve().is_relative_to(self.root):
            raise OutsideError(
                f"{name!r} is a link that leads out of the dataset's folder; put a copy there"
            )
        return path

    def relative(self, path: Path) -> str:
        """A path inside, as messages and handles give it."""
        return path.relative_to(self.root).as_posix()

    def expand(self, base: Path, pattern: str) -> list[Path]:
        """Paths that a pattern with `*`, `?` and `[0-9]` names, in order.

        Raises:
            OutsideError: The pattern leads out of the dataset.
        """
        plain = self.inside(base, pattern.rstrip("/") or pattern)
        if not _GLOB.search(pattern):
            return [plain] if plain.exists() else []
        found = sorted(self.root.glob(self.relative(plain)))
        return [path for path in found if path.resolve().is_relative_to(self.root)]

    def walk(self) -> Iterator[Path]:
        """All files, in order; links to folders are not followed.

        Raises:
            ValueError: There are too many.
        """
        count = 0
        for folder, folders, names in os.walk(self.root):
            folders.sort()
            for name in sorted(names):
                count += 1
                if count > MAX_FILES:
                    raise ValueError(
                        f"{self.root}: more than {MAX_FILES} files; name the dataset's "
                        "*.scene_dataset_config.json instead of its folder"
                    )
                yield Path(folder) / name


def read_json(path: Path, *, where: str) -> Table:
    """The JSON object in a file.

    Args:
        path: The file.
        where: What messages call it.

    Raises:
        ValueError: It is too large, no JSON, nested too deeply, or no object.
        FileNotFoundError: It is not there.
    """
    if not path.is_file():
        raise FileNotFoundError(f"{where}: no such file")
    size = path.stat().st_size
    if size > MAX_JSON_BYTES:
        raise ValueError(f"{where}: has {size} bytes, more than the {MAX_JSON_BYTES} allowed")
    try:
        value: Any = json.loads(path.read_bytes(), parse_constant=_refuse_constant)
    except RecursionError as error:
        raise ValueError(f"{where}: JSON is nested too deeply") from error
    except ValueError as error:
        # Also broken UTF-8, and whole numbers of thousands of digits.
        raise ValueError(f"{where}: no valid JSON: {error}") from error
    return Table.of(value, where=where)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON")
