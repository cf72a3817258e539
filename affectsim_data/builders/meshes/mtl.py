"""MTL files: the materials of OBJ models."""

from __future__ import annotations

import dataclasses
import functools
from pathlib import PurePosixPath

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.files import MeshFiles
from affectsim_data.builders.meshes.images import Textures
from affectsim_data.builders.meshes.limits import MeshLimits
from affectsim_data.builders.meshes.looks import Look

__all__ = ["ObjMaterials"]

_OPTIONS = {
    "-blendu": 1, "-blendv": 1, "-boost": 1, "-mm": 2, "-o": 3, "-s": 3, "-t": 3, "-texres": 1,
    "-clamp": 1, "-bm": 1, "-imfchan": 1, "-type": 1,
}  # fmt: skip
"""Options of `map_Kd` with how many words follow them."""
_GREY = (0.8, 0.8, 0.8)
"""A material without a colour."""


@dataclasses.dataclass
class _Entry:
    """What an MTL says of one material."""

    color: tuple[float, float, float] | None = None
    opacity: float = 1.0
    picture: str = ""
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)


class ObjMaterials:
    """The materials an OBJ names, from all its libraries."""

    def __init__(self, files: MeshFiles, *, limits: MeshLimits, notes: Notes) -> None:
        self._files, self._limits, self._notes = files, limits, notes
        self._textures = Textures(limits=limits, notes=notes)
        self._entries: dict[str, _Entry] = {}
        self._looks: dict[str, Look] = {}

    def add_library(self, name: str) -> None:
        """Reads an MTL; one that is not there is noted."""
        try:
            payload = self._files.read(name, limit=self._limits.max_json_bytes)
        except (FileNotFoundError, ValueError) as error:
            self._notes[f"material library missing, grey instead: {error}"] += 1
            return
        entry = _Entry()
        for line in payload.decode("utf-8", "replace").splitlines():
            words = line.split()
            if len(words) < 2 or words[0].startswith("#"):
                continue
            if words[0].lower() == "newmtl":
                entry = _Entry()
                self._entries.setdefault(line.split(None, 1)[1].strip(), entry)
            else:
                self._set(entry, words[0].lower(), line.split(None, 1)[1].strip())
        if len(self._entries) > self._limits.max_nodes:
            raise ValueError(f"more than the {self._limits.max_nodes} materials allowed")

    def _set(self, entry: _Entry, key: str, text: str) -> None:
        try:
            if key == "kd":
                entry.color = _color(text)
            elif key in ("d", "tr"):
                value = float(text.split()[-1])
                entry.opacity = value if key == "d" else 1.0 - value
            elif key == "map_kd":
                _set_picture(entry, text)
            elif key in ("map_d", "map_opacity"):
                self._notes["opacity maps ignored"] += 1
        except (ValueError, IndexError):
            self._notes[f"material lines not understood, such as {key} {text[:40]!r}"] += 1

    def look(self, name: str) -> Look:
        """The material called `name`; grey and noted if no library has it."""
        if name not in self._looks:
            entry = self._entries.get(name)
            if entry is None:
                what = f"material {name!r} missing" if name else "faces without a material"
                self._notes[f"{what}, grey instead"] += 1
                entry = _Entry()
            self._looks[name] = self._read(name, entry)
        return self._looks[name]

    def _read(self, name: str, entry: _Entry) -> Look:
        texture = None
        if entry.picture:
            read = functools.partial(self._picture, entry.picture)
            texture = self._textures.get(entry.picture, read)
        color = entry.color or ((1.0, 1.0, 1.0) if texture is not None else _GREY)
        if texture is not None and max(color) <= 0.0:
            # Exporters that write black under a texture mean the texture alone.
            color = (1.0, 1.0, 1.0)
        opacity = min(max(entry.opacity, 0.0), 1.0)
        cut_out = texture is not None and texture.shape[-1] == 4
        return Look(
            name=name,
            color=(*color, opacity),
            texture=texture,
            uv_transform=_transform(entry),
            alpha_mode="BLEND" if opacity < 1.0 else "MASK" if cut_out else "OPAQUE",
        )

    def _picture(self, name: str) -> bytes:
        """The file of that name; where it is a path on its author's machine, its last part."""
        limit = self._limits.max_file_bytes
        try:
            return self._files.read(name, limit=limit)
        except ValueError:
            last = PurePosixPath(name.replace("\\", "/")).name
            if not last or last == name:
                raise
            return self._files.read(last, limit=limit)


def _color(text: str) -> tuple[float, float, float]:
    """One number is grey; values above 1 are cut off."""
    words = text.split()
    if words[0] in ("spectral", "xyz"):
        raise ValueError(f"{words[0]} colours are not read")
    values = [min(max(float(word), 0.0), 1.0) for word in words[:3]]
    return (values[0], values[0], values[0]) if len(values) < 3 else tuple(values)  # type: ignore[return-value]


def _set_picture(entry: _Entry, text: str) -> None:
    """The file name comes last, and may hold spaces; options come before it."""
    words = text.split()
    rest = text
    while words and words[0] in _OPTIONS:
        option, most = words[0], _OPTIONS[words[0]]
        values: list[str] = []
        rest = rest.split(None, 1)[1]
        while len(values) < most and len(rest.split(None, 1)) == 2:
            word = rest.split(None, 1)[0]
            if option in ("-o", "-s", "-t") and not _is_number(word):
                break
            values.append(word)
            rest = rest.split(None, 1)[1]
        if option in ("-o", "-s"):
            pair = [float(value) for value in values] + [0.0 if option == "-o" else 1.0] * 2
            if option == "-o":
                entry.offset = (pair[0], pair[1])
            else:
                entry.scale = (pair[0], pair[1])
        words = rest.split()
    entry.picture = rest.strip()


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _transform(
    entry: _Entry,
) -> tuple[tuple[float, float, float], tuple[float, float, float]] | None:
    """Scale and offset of MTL coordinates, v up, as a map of ours, v down."""
    if entry.scale == (1.0, 1.0) and entry.offset == (0.0, 0.0):
        return None
    (su, sv), (ou, ov) = entry.scale, entry.offset
    return ((su, 0.0, ou), (0.0, sv, 1.0 - sv - ov))
