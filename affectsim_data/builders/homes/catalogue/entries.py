"""The entries of furniture libraries: Sweet Home 3D's, and folders of models with their sizes."""

from __future__ import annotations

import csv
import dataclasses
import io
import math
import re
import tomllib
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from affectsim_data.builders.homes.catalogue.kinds import kinds_of
from affectsim_data.builders.meshes import MESH_SUFFIXES, FolderFiles, MeshFiles, ZipFiles
from affectsim_data.builders.meshes.files import safe_name

__all__ = ["CatalogueEntry", "Matrix", "library_entries", "read_bounded"]

Size = tuple[float, float, float]
Matrix = tuple[float, ...]
PROPERTIES = "PluginFurnitureCatalog.properties"
TABLES = ("catalogue.toml", "catalogue.csv")
"""Names of the table in a folder of models."""
_MAX_TABLE_BYTES = 16 * 2**20
_MAX_MODELS = 20_000
_MAX_SIZE_M, _MIN_SIZE_M = 6.0, 0.01
_SIZED = re.compile(r"^(.+?)[_ -](\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)(cm|mm|m)?$")
_UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, None: 0.01}


@dataclasses.dataclass(frozen=True)
class CatalogueEntry:
    """A model of a library and what the library says of it."""

    entry_id: str
    """Unique in its catalogue."""
    name: str
    kinds: tuple[str, ...]
    """Categories it may stand in for."""
    size: Size | None
    """Width, depth and height, metres; none takes the model's own, in metres."""
    files: MeshFiles
    """Where its model is."""
    model: str
    """Name of the model in there."""
    elevation_m: float = 0.0
    """Of its underside above the floor."""
    rotation: Matrix | None = None
    """Turns the model upright and to the front, nine numbers, row by row."""
    top_m: float | None = None
    """Height at which things are put on it."""
    light_y: float | None = None
    """Height of its lamp."""
    licence: str = ""
    creator: str = ""


def read_bounded(path: Path) -> bytes:
    """The bytes of a table.

    Raises:
        ValueError: It is larger than any table.
    """
    if path.stat().st_size > _MAX_TABLE_BYTES:
        raise ValueError(f"{path}: a table may have {_MAX_TABLE_BYTES} bytes at most")
    return path.read_bytes()


def library_entries(path: Path, *, left_out: dict[str, str]) -> list[CatalogueEntry]:
    """The entries of one library: an `.sh3f` file, or a folder of models.

    Args:
        path: The library.
        left_out: Takes what cannot be used, with the reason, by the entry's id.

    Raises:
        ValueError: Not a library; the message starts with `path`.
    """
    if path.is_dir():
        if (path / PROPERTIES).is_file():
            text = read_bounded(path / PROPERTIES).decode("latin-1")
            rows = _property_rows(text)
            return _sweet_home(rows, path, path.name, left_out)
        return _folder(path, left_out)
    try:
        with zipfile.ZipFile(path) as archive:
            text = _property_text(archive, path)
    except (zipfile.BadZipFile, OSError, RuntimeError, NotImplementedError) as error:
        raise ValueError(f"{path}: not a furniture library (.sh3f): {error}") from error
    return _sweet_home(_property_rows(text), path, path.stem, left_out)


def _property_text(archive: zipfile.ZipFile, path: Path) -> str:
    try:
        entry = archive.getinfo(PROPERTIES)
    except KeyError as error:
        raise ValueError(f"{path}: a furniture library must have {PROPERTIES}") from error
    if entry.file_size > _MAX_TABLE_BYTES:
        raise ValueError(f"{path}: {PROPERTIES} may have {_MAX_TABLE_BYTES} bytes at most")
    with archive.open(entry) as file:
        return file.read(_MAX_TABLE_BYTES).decode("latin-1")


def _property_rows(text: str) -> dict[str, dict[str, str]]:
    """`key#number=value` lines by number; those of the library itself under an empty one."""
    rows: dict[str, dict[str, str]] = {"": {}}
    lines = text.replace("\r\n", "\n").replace("\\\n", "").split("\n")
    for line in lines:
        bare = line.strip()
        if not bare or bare[0] in "#!":
            continue
        key, _, value = bare.partition("=")
        field, _, number = key.strip().partition("#")
        rows.setdefault(number, {})[field] = _unescaped(value.strip())
    return rows


def _unescaped(value: str) -> str:
    """Java's escapes of characters outside Latin-1."""
    plain = re.sub(r"\\u([0-9a-fA-F]{4})", lambda found: chr(int(found[1], 16)), value)
    return re.sub(r"\\(.)", r"\1", plain)


def _sweet_home(
    rows: dict[str, dict[str, str]], path: Path, library: str, left_out: dict[str, str]
) -> list[CatalogueEntry]:
    licence = rows[""].get("license", "")
    entries = []
    for number, row in rows.items():
        if not number:
            continue
        entry_id = f"{library}/{row.get('id', number)}"
        # Names are short, `Chair`; the name of the model often says more, `office-chair`.
        words = f"{row.get('name', '')} {PurePosixPath(row.get('model', '')).stem}"
        kinds = kinds_of(row.get("name", ""), group=row.get("category", ""))
        if kinds[:1] == ("chair",):
            kinds = kinds_of(words) or kinds
        if not kinds or row.get("doorOrWindow") == "true":
            continue
        try:
            entries.append(_sweet_home_entry(row, path, entry_id, kinds, licence))
        except ValueError as error:
            left_out[entry_id] = str(error)
    return entries


def _sweet_home_entry(
    row: Mapping[str, str], path: Path, entry_id: str, kinds: tuple[str, ...], licence: str
) -> CatalogueEntry:
    model = PurePosixPath(safe_name(row.get("model", "").lstrip("/")))
    if model.suffix.lower() not in MESH_SUFFIXES:
        raise ValueError(f"model must end in {', '.join(MESH_SUFFIXES)}, got {model.name!r}")
    folder = str(model.parent)
    files: MeshFiles = FolderFiles(path / folder) if path.is_dir() else ZipFiles(path, folder)
    if path.is_dir() and not (path / model).is_file():
        raise ValueError(f"{model} is not there")
    size = _size([_cm(row, key) for key in ("width", "depth", "height")])
    elevation = _cm(row, "elevation", 0.0)
    top = _cm(row, "dropOnTopElevation", 0.0)
    light = row.get("lightSourceZ", "").split()
    return CatalogueEntry(
        entry_id, row.get("name", ""), kinds, size, files, model.name,
        elevation_m=max(elevation, 0.0),
        rotation=_rotation(row.get("modelRotation", "")),
        top_m=top if top > 0.0 else None,
        light_y=float(light[0]) / 100.0 if light else None,
        licence=row.get("license", licence),
        creator=row.get("creator", ""),
    )  # fmt: skip


def _cm(row: Mapping[str, str], key: str, default: float | None = None) -> float:
    """A length of a library, which has centimetres, as metres."""
    try:
        value = float(row[key])
    except KeyError as error:
        if default is None:
            raise ValueError(f"{key} is missing") from error
        return default
    except ValueError as error:
        raise ValueError(f"{key} must be a number, got {row[key]!r}") from error
    return value / 100.0


def _size(values: Iterable[float]) -> Size:
    width, depth, height = values
    for name, value in (("width", width), ("depth", depth), ("height", height)):
        if not (math.isfinite(value) and _MIN_SIZE_M <= value <= _MAX_SIZE_M):
            raise ValueError(f"{name} must be {_MIN_SIZE_M} to {_MAX_SIZE_M} m, got {value:g}")
    return width, depth, height


def _rotation(text: str) -> Matrix | None:
    if not text:
        return None
    try:
        numbers = tuple(float(word) for word in text.split())
    except ValueError as error:
        raise ValueError(f"modelRotation must be nine numbers, got {text!r}") from error
    if len(numbers) != 9 or not all(math.isfinite(number) for number in numbers):
        raise ValueError(f"modelRotation must be nine numbers, got {text!r}")
    return numbers


def _folder(path: Path, left_out: dict[str, str]) -> list[CatalogueEntry]:
    """A folder of OBJ and GLB: sizes from its table, else from file names, else the model's own."""
    table = next((path / name for name in TABLES if (path / name).is_file()), None)
    if table is not None:
        return _table_entries(table, left_out)
    models = sorted(one for one in path.rglob("*") if one.suffix.lower() in MESH_SUFFIXES)
    if not models:
        raise ValueError(
            f"{path}: no furniture here; expected *.sh3f, {PROPERTIES}, {' or '.join(TABLES)}, or "
            f"models ({', '.join(MESH_SUFFIXES)})"
        )
    entries = []
    for model in models[:_MAX_MODELS]:
        entry_id = model.relative_to(path).as_posix()
        sized = _SIZED.match(model.stem)
        name = sized[1] if sized else model.stem
        kinds = kinds_of(name)
        if not kinds:
            left_out[entry_id] = f"its name {name!r} says no category"
            continue
        if sized is None and model.suffix.lower() == ".obj":
            left_out[entry_id] = "an OBJ has no unit: name it NAME_WxDxHcm.obj or add a table"
            continue
        try:
            scale = _UNITS_M[sized[5]] if sized else 1.0
            size = _size([float(sized[k]) * scale for k in (2, 3, 4)]) if sized else None
        except ValueError as error:
            left_out[entry_id] = str(error)
            continue
        files = FolderFiles(model.parent)
        entries.append(CatalogueEntry(entry_id, name, kinds, size, files, model.name))
    return entries


def _table_entries(table: Path, left_out: dict[str, str]) -> list[CatalogueEntry]:
    rows = _table_rows(table)
    entries = []
    for number, row in enumerate(rows[:_MAX_MODELS], start=1):
        try:
            entries.append(_table_entry(row, table))
        except ValueError as error:
            left_out[f"{table.name} row {number} {row.get('name', '')}".strip()] = str(error)
    return entries


def _table_rows(table: Path) -> list[dict[str, Any]]:
    payload = read_bounded(table)
    try:
        text = payload.decode("utf-8-sig")
        if table.suffix == ".csv":
            return [dict(row) for row in csv.DictReader(io.StringIO(text))]
        rows = tomllib.loads(text).get("model", [])
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, csv.Error) as error:
        raise ValueError(f"{table}: does not parse: {error}") from error
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        raise ValueError(f"{table}: must have [[model]] tables, got {rows!r}")
    return rows


def _table_entry(row: Mapping[str, Any], table: Path) -> CatalogueEntry:
    """A row of name, width, depth, height (metres), category and perhaps licence and creator."""
    name = safe_name(str(row.get("name") or ""))
    category = str(row.get("category") or "").strip()
    if not category:
        raise ValueError("category is missing")
    model = table.parent / name
    if model.suffix.lower() not in MESH_SUFFIXES or not model.is_file():
        raise ValueError(f"{name} is no model in {table.parent}")
    values = []
    for key in ("width", "depth", "height"):
        try:
            values.append(float(row[key]))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{key} must be metres, got {row.get(key)!r}") from error
    return CatalogueEntry(
        name, model.stem, (category,), _size(values), FolderFiles(model.parent), model.name,
        licence=str(row.get("licence") or ""), creator=str(row.get("creator") or ""),
    )  # fmt: skip
