"""`MANIFEST.json`: what a release is made of, and the check that it is all there."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import itertools
import json
import os
from collections.abc import Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Robot
from affectsim_data.errors import IntegrityError
from affectsim_data.releases.partial import Partial
from affectsim_data.schemas import ASSET_TABLES, SCHEMA_VERSION, AssetTable

__all__ = ["MANIFEST_NAME", "FileEntry", "Manifest", "Source", "read_verified", "sha256_of"]

MANIFEST_NAME = "MANIFEST.json"
FORMAT = "affectsim-release"
MAX_MANIFEST_BYTES = 64 << 20


@dataclasses.dataclass(frozen=True)
class FileEntry:
    """What the manifest promises of one file."""

    bytes: int
    """Its size."""
    sha256: str
    """Hash of its contents, hexadecimal."""
    rows: int
    """Rows of its table."""
    keys: tuple[str, ...] = ()
    """Identifiers of the rows, in order, where rows are motions, scenes or avatars."""

    def to_json(self) -> dict[str, Any]:
        """The entry as it stands in the manifest."""
        document = dataclasses.asdict(self)
        return document if self.keys else {k: v for k, v in document.items() if k != "keys"}


@dataclasses.dataclass(frozen=True)
class Source:
    """Where motions, scenes or bodies of a release come from, and on what terms."""

    name: str
    """Of the corpus or dataset."""
    kind: AssetTable
    """What comes from it."""
    licence: str
    """Identifier, SPDX where there is one."""
    redistribution: bool = True
    """Whether what is made from it may be passed on."""
    citation: str = ""
    """How to cite it."""
    obtain: str = ""
    """Where one gets it."""

    def __post_init__(self) -> None:
        if self.kind not in ASSET_TABLES:
            raise ValueError(
                f"source {self.name!r}: kind must be one of {', '.join(ASSET_TABLES)}, "
                f"got {self.kind!r}"
            )

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Source:
        """Reads an entry of the manifest.

        Raises:
            KeyError: A key lacks.
            ValueError: `kind` is none of the assets' tables, or `redistribution` no boolean.
        """
        return cls(
            name=str(document["name"]),
            kind=document["kind"],
            licence=str(document["licence"]),
            redistribution=_boolean(document.get("redistribution", True), "redistribution"),
            citation=str(document.get("citation", "")),
            obtain=str(document.get("obtain", "")),
        )


@dataclasses.dataclass(frozen=True)
class Manifest:
    """The table of contents of a release, and the parameters all its episodes share."""

    name: str
    """Of the release."""
    recipe: str
    """Recipe that built it."""
    seed: int
    """Seed of the recipe."""
    code_version: str
    """Version of the package that built it."""
    camera: Camera
    """The one camera model of every condition."""
    robot: Robot
    """The observer's body."""
    files: Mapping[str, FileEntry]
    """By path inside the release, POSIX, sorted."""
    licences: tuple[str, ...] = ()
    """Of the motions, scenes and avatars inside."""
    schema_version: str = SCHEMA_VERSION
    """Version of the data contract."""
    redistribution: bool = True
    """Whether the release may be passed on to others."""
    sources: tuple[Source, ...] = ()
    """Where what is inside comes from."""
    recipe_toml: str = ""
    """Text of the recipe: thresholds, counts, seeds."""
    partial_of: Partial | None = None
    """What a copy that lacks files of its release was taken from, and which part it is."""

    @functools.cached_property
    def sha256(self) -> str:
        """Hash of the text of the manifest: names the release's content."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()

    def scene_ids(self, split: str) -> frozenset[str] | None:
        """Scenes whose episodes of a split are here; `None` where all that there are, are."""
        for held, scenes in self.partial_of.scene_ids.items() if self.partial_of else ():
            if held == split and scenes is not None:
                return frozenset(scenes)
        return None

    def first_rows(self, split: str) -> dict[str, int]:
        """Episodes shards of a split, with the place of their first row in the split's table.

        In a partial copy shards are missing between others; the places stay those of the whole.
        """
        names = self.table_files("episodes", split)
        if self.partial_of is not None:
            return {name: self.partial_of.first_rows[name] for name in names}
        starts = itertools.accumulate((self.files[name].rows for name in names), initial=0)
        return dict(zip(names, starts, strict=False))

    def table_files(self, table: str, split: str = "") -> list[str]:
        """Paths of a table's shards in order; of the episodes table, of one split."""
        prefix = f"{table}/{split}-" if split else f"{table}/"
        return [path for path in self.files if path.startswith(prefix)]

    def asset_places(self, table: AssetTable) -> dict[str, tuple[str, int]]:
        """File and row inside it of every motion, scene or avatar, by identifier, in order.

        Raises:
            ValueError: An identifier stands in the manifest twice, or a file does not name its
                rows.
        """
        places: dict[str, tuple[str, int]] = {}
        for path in self.table_files(table):
            entry = self.files[path]
            if len(entry.keys) != entry.rows:
                raise ValueError(
                    f"{path}: the manifest names {len(entry.keys)} of its {entry.rows} rows; "
                    "build the release again"
                )
            for row, key in enumerate(entry.keys):
                if key in places:
                    raise ValueError(f"{table} {key!r} is in {places[key][0]} and in {path}")
                places[key] = (path, row)
        return places

    def num_rows(self, table: str, split: str = "") -> int:
        """Rows of a table, or of one split of the episodes."""
        return sum(self.files[path].rows for path in self.table_files(table, split))

    def to_json(self) -> str:
        """The text of `MANIFEST.json`: the same manifest gives the same bytes."""
        document: dict[str, Any] = {
            "format": FORMAT,
            "schema_version": self.schema_version,
            "name": self.name,
            "recipe": self.recipe,
            "seed": self.seed,
            "code_version": self.code_version,
            "camera": self.camera.to_json(),
            "robot": dataclasses.asdict(self.robot),
            "licences": list(self.licences),
        }
        # Written only where they say something: other releases keep their bytes.
        if not self.redistribution:
            document["redistribution"] = False
        if self.sources:
            document["sources"] = [dataclasses.asdict(source) for source in self.sources]
        if self.recipe_toml:
            document["recipe_toml"] = self.recipe_toml
        if self.partial_of is not None:
            document["partial_of"] = self.partial_of.to_json()
        head = json.dumps(document, indent=2).removesuffix("\n}")
        # A line per file: it is the bulk, and the first thing that every reader fetches.
        compact = json.JSONEncoder(separators=(",", ":")).encode
        lines = [f"    {compact(p)}:{compact(self.files[p].to_json())}" for p in sorted(self.files)]
        return f'{head},\n  "files": {{\n' + ",\n".join(lines) + "\n  }\n}\n"

    @classmethod
    def from_path(cls, path: Path, *, name: str) -> Manifest:
        """Reads and checks a manifest file; `name` is what errors call it.

        Raises:
            ValueError: It is no manifest, or of a schema this version cannot read.
        """
        if path.stat().st_size > MAX_MANIFEST_BYTES:
            raise ValueError(f"{name}: larger than {MAX_MANIFEST_BYTES} bytes; not a manifest")
        return cls._parsed(path.read_bytes(), name)

    @classmethod
    @functools.lru_cache(maxsize=8)  # every split and condition of a release opens it anew
    def _parsed(cls, payload: bytes, name: str) -> Manifest:
        try:
            document = json.loads(payload.decode())
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{name}: not JSON ({error}); fetch or build it again") from error
        if not isinstance(document, dict) or document.get("format") != FORMAT:
            raise ValueError(f'{name}: "format" must be {FORMAT!r}; this is not a release manifest')
        major = str(document.get("schema_version", "")).split(".")[0]
        if major != SCHEMA_VERSION.split(".")[0]:
            raise ValueError(
                f"{name}: schema_version {document.get('schema_version')!r} cannot be read by this "
                f"version of affectsim-data, which reads {SCHEMA_VERSION}; install a matching one"
            )
        try:
            return cls._from_document(document)
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"{name}: field {error} is missing or malformed") from error
        except (ValueError, OverflowError) as error:
            raise ValueError(f"{name}: {error}") from error

    @classmethod
    def _from_document(cls, document: dict[str, Any]) -> Manifest:
        files = {}
        for path, entry in sorted(document["files"].items()):
            parts = PurePosixPath(path).parts
            if not parts or path.startswith("/") or ".." in parts or "\\" in path:
                raise ValueError(f"path {path!r} leads out of the release")
            keys = tuple(str(key) for key in entry.get("keys", ()))
            files[path] = FileEntry(
                int(entry["bytes"]), str(entry["sha256"]), int(entry["rows"]), keys
            )
        partial = None
        if document.get("partial_of") is not None:
            partial = Partial.from_json(document["partial_of"])
            for path in files:
                if path.startswith("episodes/") and path not in partial.first_rows:
                    raise ValueError(f"partial_of does not say the first row of {path}")
        return cls(
            name=str(document["name"]),
            recipe=str(document["recipe"]),
            seed=int(document["seed"]),
            code_version=str(document["code_version"]),
            camera=Camera.from_json(document["camera"]),
            robot=Robot(**document["robot"]),
            files=files,
            licences=tuple(document["licences"]),
            schema_version=str(document["schema_version"]),
            redistribution=_boolean(document.get("redistribution", True), "redistribution"),
            sources=tuple(Source.from_json(entry) for entry in document.get("sources", ())),
            recipe_toml=str(document.get("recipe_toml", "")),
            partial_of=partial,
        )


def _boolean(value: object, name: str) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"{name} must be true or false, got {value!r}")
    return value


def sha256_of(path: Path) -> str:
    """Hash of a file's contents, hexadecimal."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def read_verified(path: Path, name: str, entry: FileEntry, *, remedy: str) -> bytes:
    """The contents of a file, which are what the manifest promises.

    Args:
        path: The file on disk.
        name: What errors call it.
        entry: The promise.
        remedy: What the user can do, for the message.

    Raises:
        IntegrityError: Other size or other hash.
    """
    with path.open("rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        if size != entry.bytes:
            kind = "truncated: " if size < entry.bytes else ""
            raise IntegrityError(
                name, expected=f"{entry.bytes} bytes", got=f"{kind}{size} bytes", remedy=remedy
            )
        payload = stream.read(entry.bytes)
    digest = hashlib.sha256(payload).hexdigest()
    if digest != entry.sha256:
        raise IntegrityError(
            name, expected=f"SHA-256 {entry.sha256}", got=f"SHA-256 {digest}", remedy=remedy
        )
    return payload
