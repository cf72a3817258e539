"""Reads and writes binary glTF 2.0 (GLB): named accessors in, JSON and one buffer out.

Only what shards hold: meshes, one skin, PNG textures, `extras`. trimesh reads scenes from
elsewhere, but drops skins and re-orders vertices, so it cannot carry ours.
"""

from __future__ import annotations

import dataclasses
import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["GlbBuilder", "GlbFile"]

_MAGIC, _JSON_CHUNK, _BIN_CHUNK = 0x46546C67, 0x4E4F534A, 0x004E4942
_COMPONENTS: dict[int, np.dtype[Any]] = {
    5120: np.dtype("<i1"),
    5121: np.dtype("<u1"),
    5122: np.dtype("<i2"),
    5123: np.dtype("<u2"),
    5125: np.dtype("<u4"),
    5126: np.dtype("<f4"),
}
_COMPONENT_CODES = {dtype.str: code for code, dtype in _COMPONENTS.items()}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


def _refuse(constant: str) -> None:
    raise ValueError(f"{constant} is no JSON number")


class GlbBuilder:
    """Collects arrays and images into one buffer; `to_bytes` closes it with the glTF JSON."""

    def __init__(self) -> None:
        self._blob = bytearray()
        self._views: list[dict[str, Any]] = []
        self._accessors: list[dict[str, Any]] = []
        self._images: list[dict[str, Any]] = []

    def _view(self, payload: bytes) -> int:
        self._blob += b"\0" * (-len(self._blob) % 4)
        self._views.append({"buffer": 0, "byteOffset": len(self._blob), "byteLength": len(payload)})
        self._blob += payload
        return len(self._views) - 1

    def accessor(self, array: NDArray[Any], *, normalized: bool = False) -> int:
        """Adds an array `(n,)`, `(n, 2..4)` or `(n, 4, 4)`; returns its accessor index.

        Matrices are given row-major and stored column-major, as glTF wants them.
        """
        data = np.swapaxes(array, -1, -2).reshape(len(array), 16) if array.ndim == 3 else array
        data = np.ascontiguousarray(data, dtype=data.dtype.newbyteorder("<"))
        width = 1 if data.ndim == 1 else data.shape[1]
        code = _COMPONENT_CODES.get(data.dtype.str)
        if code is None:
            raise ValueError(f"glTF has no component type for {data.dtype}")
        kind = next((name for name, size in _WIDTHS.items() if size == width), None)
        if kind is None:
            raise ValueError(f"glTF has no accessor type for arrays {array.shape}")
        entry: dict[str, Any] = {
            "bufferView": self._view(data.tobytes()),
            "componentType": code,
            "count": len(data),
            "type": kind,
        }
        if normalized:
            entry["normalized"] = True
        if width == 3 and data.dtype.kind == "f" and len(data):
            entry["min"] = [float(x) for x in data.min(axis=0)]
            entry["max"] = [float(x) for x in data.max(axis=0)]
        self._accessors.append(entry)
        return len(self._accessors) - 1

    def png(self, payload: bytes) -> int:
        """Adds an encoded PNG; returns its image index."""
        self._images.append({"bufferView": self._view(payload), "mimeType": "image/png"})
        return len(self._images) - 1

    def to_bytes(self, document: dict[str, Any]) -> bytes:
        """The GLB; `document` holds the glTF members that are not buffers, accessors or images."""
        header = {"asset": {"version": "2.0", "generator": "affectsim-data"}, **document}
        header["accessors"] = self._accessors
        header["bufferViews"] = self._views
        header["buffers"] = [{"byteLength": len(self._blob) + (-len(self._blob) % 4)}]
        if self._images:
            header["images"] = self._images
        text = json.dumps(header, separators=(",", ":"), sort_keys=True).encode()
        text += b" " * (-len(text) % 4)
        blob = bytes(self._blob) + b"\0" * (-len(self._blob) % 4)
        body = struct.pack("<II", len(text), _JSON_CHUNK) + text
        body += struct.pack("<II", len(blob), _BIN_CHUNK) + blob
        return struct.pack("<III", _MAGIC, 2, 12 + len(body)) + body


@dataclasses.dataclass(frozen=True)
class GlbFile:
    """A parsed GLB; arrays are views of its buffer, checked against its bounds."""

    name: str
    """What error messages call it."""
    document: dict[str, Any]
    """The glTF JSON."""
    blob: bytes
    """The binary chunk."""

    @classmethod
    def from_bytes(cls, payload: bytes, *, name: str) -> GlbFile:
        """Splits a GLB into its JSON and its binary chunk.

        Raises:
            ValueError: Not a complete GLB 2.0 file.
        """
        if len(payload) < 20:
            raise ValueError(f"{name}: a GLB has at least 20 bytes, got {len(payload)}")
        magic, version, total = struct.unpack_from("<III", payload)
        if magic != _MAGIC or version != 2:
            raise ValueError(f"{name}: not a GLB 2.0 file")
        if total != len(payload):
            raise ValueError(f"{name}: GLB header says {total} bytes, got {len(payload)}")
        length, kind = struct.unpack_from("<II", payload, 12)
        if kind != _JSON_CHUNK or 20 + length > total:
            raise ValueError(f"{name}: broken GLB JSON chunk")
        try:
            # Shards come from elsewhere: `Infinity` and `NaN` are no JSON.
            document = json.loads(payload[20 : 20 + length], parse_constant=_refuse)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"{name}: GLB JSON does not parse: {error}") from error
        if not isinstance(document, dict):
            raise ValueError(f"{name}: GLB JSON must be an object, got {type(document).__name__}")
        blob = b""
        start = 20 + length
        if start + 8 <= total:
            size, kind = struct.unpack_from("<II", payload, start)
            if kind != _BIN_CHUNK or start + 8 + size > total:
                raise ValueError(f"{name}: broken GLB binary chunk")
            blob = payload[start + 8 : start + 8 + size]
        return cls(name=name, document=document, blob=blob)

    def _entry(self, member: str, index: Any) -> dict[str, Any]:
        entries = self.document.get(member)
        entry: Any = None
        if isinstance(entries, list) and isinstance(index, int) and 0 <= index < len(entries):
            entry = entries[index]  # a negative index would count from the end
        if not isinstance(entry, dict):
            raise ValueError(f"{self.name}: the GLB has no {member}[{index!r}]")
        return entry

    def _count(self, entry: dict[str, Any], key: str, default: int | None = None) -> int:
        value = entry.get(key, default)
        if not isinstance(value, int) or value < 0:
            raise ValueError(f"{self.name}: GLB {key} must be an integer >= 0, got {value!r}")
        return value

    def _bytes(self, view_index: Any) -> memoryview:
        view = self._entry("bufferViews", view_index)
        if "byteStride" in view:
            raise ValueError(f"{self.name}: GLB buffer view {view_index} is interleaved")
        start, size = self._count(view, "byteOffset", 0), self._count(view, "byteLength")
        if start + size > len(self.blob):
            raise ValueError(f"{self.name}: GLB buffer view {view_index} leaves the buffer")
        return memoryview(self.blob)[start : start + size]

    def array(self, index: int) -> NDArray[Any]:
        """The array of an accessor: `(n,)`, `(n, k)` or `(n, 4, 4)` row-major.

        Raises:
            ValueError: No such accessor, or it leaves the buffer, or it is sparse or interleaved.
        """
        entry = self._entry("accessors", index)
        code, kind = entry.get("componentType"), entry.get("type")
        if not isinstance(code, int) or code not in _COMPONENTS:
            raise ValueError(f"{self.name}: GLB accessor {index} has componentType {code!r}")
        if not isinstance(kind, str) or kind not in _WIDTHS or "sparse" in entry:
            raise ValueError(f"{self.name}: GLB accessor {index} is of type {kind!r} or sparse")
        dtype, width = _COMPONENTS[code], _WIDTHS[kind]
        count, start = self._count(entry, "count"), self._count(entry, "byteOffset", 0)
        payload = self._bytes(entry.get("bufferView"))
        if start + count * width * dtype.itemsize > len(payload):
            raise ValueError(f"{self.name}: GLB accessor {index} leaves its buffer view")
        flat = np.frombuffer(payload, dtype, count * width, start)
        if width == 16:
            return np.swapaxes(flat.reshape(count, 4, 4), 1, 2)
        return flat if width == 1 else flat.reshape(count, width)

    def image(self, index: int) -> bytes:
        """The encoded bytes of an image."""
        return bytes(self._bytes(self._entry("images", index).get("bufferView")))
