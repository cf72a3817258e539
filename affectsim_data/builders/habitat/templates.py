"""Templates of stages, objects and articulated objects: found by name as Habitat finds them."""

from __future__ import annotations

import bisect
import dataclasses
import functools
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal

from affectsim_data.builders.habitat.fields import Table
from affectsim_data.builders.habitat.files import DatasetFolder, read_json

__all__ = ["CONFIG_SUFFIXES", "Match", "Template", "TemplateKind", "TemplateLibrary"]

TemplateKind = Literal["stage", "object", "articulated object"]
CONFIG_SUFFIXES: Mapping[TemplateKind, str] = {
    "stage": ".stage_config.json",
    "object": ".object_config.json",
    "articulated object": ".ao_config.json",
}
_OWN_NAME = "%%CONFIG_NAME_AS_ASSET_FILENAME%%"
_ASSETS = ("render_asset", "collision_asset", "urdf_filepath")


@dataclasses.dataclass(frozen=True)
class Template:
    """What a handle stands for: its attributes, defaults filled in."""

    handle: str
    kind: TemplateKind
    table: Table
    bases: Mapping[str, Path]
    """Folder that each of its asset names is relative to."""

    @property
    def stem(self) -> str:
        """Its handle without folders and endings."""
        return self.handle.rsplit("/", 1)[-1].split(".", 1)[0]


@dataclasses.dataclass(frozen=True)
class Match:
    """The template a name stands for."""

    handle: str
    others: int = 0
    """Templates that contain the name as well, and come later in the alphabet."""


@dataclasses.dataclass(frozen=True)
class _Source:
    """Where the attributes of a handle come from."""

    path: Path | None = None
    """Its config, URDF or mesh file, or that of the template it is a copy of."""
    changes: Mapping[str, Any] = dataclasses.field(default_factory=dict)
    """Attributes set in the dataset's config."""


class TemplateLibrary:
    """All templates of one kind. Files are listed at once and read when they are asked for."""

    def __init__(
        self, kind: TemplateKind, folder: DatasetFolder, defaults: Mapping[str, Any] | None = None
    ) -> None:
        self.kind: TemplateKind = kind
        self._folder = folder
        self._defaults = dict(defaults or {})
        self._sources: dict[str, _Source] = {}
        self._read = functools.lru_cache(maxsize=None)(self._build)

    def __len__(self) -> int:
        return len(self._sources)

    @property
    def handles(self) -> tuple[str, ...]:
        """In alphabetical order, as they are searched."""
        return tuple(sorted(self._sources))

    def add_file(self, path: Path) -> None:
        """Registers a config file, a URDF or a mesh; a mesh or URDF brings the config beside it."""
        suffix = CONFIG_SUFFIXES[self.kind]
        beside = path.with_name(path.name.split(".", 1)[0] + suffix)
        if not path.name.endswith(suffix) and beside.is_file():
            path = beside
        self._sources[self._folder.relative(path)] = _Source(path)
        self._forget()

    def add_config(self, row: Table) -> None:
        """Registers an entry of `configs`: a changed copy, or a template of its own.

        Raises:
            ValueError: It names neither an original nor a handle, or no such original is known.
        """
        original, handle = row.text("original_file"), row.text("template_handle")
        if not original and not handle:
            raise ValueError(f"{row.where}: needs original_file or template_handle")
        changes = dict(row.table("attributes").values)
        known = _Source()
        if original:
            match = self.find(original)
            if match is None:
                raise ValueError(f"{row.where}: original_file {original!r} is no known template")
            known = self._sources[match.handle]
            # Without a name of its own it changes the original for everybody.
            handle = handle or match.handle
        self._sources[handle] = _Source(known.path, {**known.changes, **changes})
        self._forget()

    def _forget(self) -> None:
        self._read.cache_clear()
        self.__dict__.pop("_index", None)

    @functools.cached_property
    def _index(self) -> tuple[str, list[int], tuple[str, ...]]:
        """All handles as one text to search, and where each begins in it."""
        handles = self.handles
        starts, total = [], 0
        for handle in handles:
            starts.append(total)
            total += len(handle) + 1
        return "\n".join(handles).lower(), starts, handles

    def find(self, name: str) -> Match | None:
        """The template with this handle, else the first in the alphabet that contains the name.

        As in habitat-sim, case does not count in the second case.
        """
        if name in self._sources:
            return Match(name)
        text, starts, handles = self._index
        wanted = name.lower()
        place = text.find(wanted) if wanted and "\n" not in wanted else -1
        if place < 0:
            return None
        first = bisect.bisect_right(starts, place) - 1
        end = starts[first] + len(handles[first]) + 1
        others = sum(wanted in line for line in text[end:].split("\n")) if wanted else 0
        return Match(handles[first], others)

    def get(self, handle: str) -> Template:
        """The template of a handle that `find` gave.

        Raises:
            ValueError: Its file is broken.
        """
        return self._read(handle)

    def _build(self, handle: str) -> Template:
        source = self._sources[handle]
        root = self._folder.root
        if source.path is None:
            values, where = self._defaults_for(handle), f"template {handle!r}"
            bases = dict.fromkeys(_ASSETS, root)
        else:
            values = {**self._defaults_for(source.path.name), **self._file_values(source.path)}
            where = self._folder.relative(source.path)
            bases = dict.fromkeys(_ASSETS, source.path.parent)
        for key in set(_ASSETS) & set(source.changes):
            bases[key] = root
        table = Table({**values, **source.changes}, where)
        return Template(handle, self.kind, table, bases)

    def _file_values(self, path: Path) -> dict[str, Any]:
        where = self._folder.relative(path)
        suffix = CONFIG_SUFFIXES[self.kind]
        if not path.name.endswith(".json"):
            key = "urdf_filepath" if path.suffix.lower() == ".urdf" else "render_asset"
            return {key: path.name}
        values = dict(read_json(path, where=where).values)
        if self.kind == "articulated object":
            values.setdefault("urdf_filepath", path.name.removesuffix(suffix) + ".urdf")
        return values

    def _defaults_for(self, name: str) -> dict[str, Any]:
        """The defaults of the dataset, the tag for a template's own name filled in."""
        own = name.rsplit("/", 1)[-1].split(".", 1)[0]
        return {
            key: value.replace(_OWN_NAME, own) if isinstance(value, str) else value
            for key, value in self._defaults.items()
        }
