"""A glTF's JSON and buffers, and the arrays of its accessors, checked before they are allocated."""

from __future__ import annotations

import base64
import binascii
import json
import struct
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.meshes.files import MeshFiles
from affectsim_data.builders.meshes.limits import MeshLimits

__all__ = ["GltfDocument"]

_MAGIC, _JSON_CHUNK, _BIN_CHUNK = b"glTF", 0x4E4F534A, 0x004E4942
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class GltfDocument:
    """A parsed glTF or GLB; buffers are read when first asked for."""

    def __init__(self, payload: bytes, files: MeshFiles, *, limits: MeshLimits) -> None:
        """Splits and parses the file itself.

        Raises:
            ValueError: Not a complete glTF 2.0.
        """
        self._files, self._limits = files, limits
        self._budget = limits.max_file_bytes
        self._buffers: dict[int, bytes] = {}
        text = payload
        if payload.startswith(_MAGIC):
            text, blob = _split_glb(payload)
            if blob is not None:
                self._buffers[0] = blob
        if len(text) > limits.max_json_bytes:
            raise ValueError(
                f"its JSON has {len(text)} bytes, more than the {limits.max_json_bytes} allowed"
            )
        try:
            document = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise ValueError(f"its JSON does not parse: {error}") from error
        if not isinstance(document, dict):
            raise ValueError(f"its JSON must be an object, got {type(document).__name__}")
        version = document.get("asset", {}).get("version")
        if not str(version).startswith("2."):
            raise ValueError(f"asset.version must be 2.x, got {version!r}")
        self.json: dict[str, Any] = document

    def entries(self, member: str) -> list[Any]:
        """A top-level array, empty where there is none."""
        found = self.json.get(member, [])
        if not isinstance(found, list):
            raise ValueError(f"{member} must be an array, got {type(found).__name__}")
        return found

    def entry(self, member: str, index: Any) -> dict[str, Any]:
        """One object of a top-level array.

        Raises:
            ValueError: There is no such object.
        """
        entries = self.entries(member)
        if type(index) is int and 0 <= index < len(entries) and isinstance(entries[index], dict):
            found: dict[str, Any] = entries[index]
            return found
        raise ValueError(f"there is no {member}[{index!r}], it has {len(entries)}")

    def count(self, index: Any) -> int:
        """Elements of an accessor, not yet checked against its buffer."""
        return _natural(self.entry("accessors", index), "count", f"accessors[{index}]")

    def view(self, index: Any) -> bytes:
        """The bytes of a buffer view."""
        entry = self.entry("bufferViews", index)
        where = f"bufferViews[{index}]"
        if "EXT_meshopt_compression" in entry.get("extensions", {}):
            raise ValueError(f"{where} is compressed with EXT_meshopt_compression; decompress it")
        buffer = self._buffer(entry.get("buffer"))
        start = _natural(entry, "byteOffset", where, 0)
        size = _natural(entry, "byteLength", where)
        if start + size > len(buffer):
            raise ValueError(f"{where} needs bytes {start} to {start + size} of {len(buffer)}")
        return buffer[start : start + size]

    def array(self, index: Any) -> NDArray[Any]:
        """The elements of an accessor, `(count, width)`; normalised integers become floats.

        Raises:
            ValueError: It does not fit its buffer, or is of no known type.
        """
        entry, where = self.entry("accessors", index), f"accessors[{index}]"
        dtype, width = _component(entry, where), _WIDTHS.get(str(entry.get("type")))
        if width is None:
            raise ValueError(f"{where}: type {entry.get('type')!r} is not supported")
        count = _natural(entry, "count", where)
        if count > self._limits.max_vertices * 3:
            raise ValueError(f"{where}: count {count} is more than any mesh allowed here has")
        if "bufferView" in entry:
            start = _natural(entry, "byteOffset", where, 0)
            values = self._strided(entry["bufferView"], start, (count, width), dtype, where)
        else:
            values = np.zeros((count, width), dtype)
        if "sparse" in entry:
            values = self._with_sparse(values, entry["sparse"], where)
        return _normalised(values) if entry.get("normalized") is True else values

    def _strided(
        self, view: Any, start: int, shape: tuple[int, int], dtype: np.dtype[Any], where: str
    ) -> NDArray[Any]:
        data = self.view(view)
        size = shape[1] * dtype.itemsize
        stride = _natural(self.entry("bufferViews", view), "byteStride", where, size) or size
        needed = start + (shape[0] - 1) * stride + size if shape[0] else 0
        if needed > len(data) or stride < size:
            raise ValueError(f"{where}: {shape[0]} elements need {needed} bytes, got {len(data)}")
        if not shape[0]:
            return np.zeros(shape, dtype)
        return np.ndarray(shape, dtype, data, start, (stride, dtype.itemsize))

    def _with_sparse(self, values: NDArray[Any], sparse: Any, where: str) -> NDArray[Any]:
        count = _natural(sparse, "count", f"{where}.sparse")
        places, fill = sparse["indices"], sparse["values"]
        kind = _component(places, f"{where}.sparse.indices")
        at = self._strided(
            places["bufferView"], _natural(places, "byteOffset", where, 0), (count, 1), kind, where
        )[:, 0]
        new = self._strided(
            fill["bufferView"], _natural(fill, "byteOffset", where, 0),
            (count, values.shape[1]), values.dtype, where,
        )  # fmt: skip
        if count and int(at.max()) >= len(values):
            raise ValueError(f"{where}: a sparse index leaves its {len(values)} elements")
        changed = values.copy()
        changed[at] = new
        return changed

    def _buffer(self, index: Any) -> bytes:
        entry = self.entry("buffers", index)
        if index not in self._buffers:
            if "uri" not in entry:
                raise ValueError(f"buffers[{index}] has neither a uri nor the GLB's binary chunk")
            self._buffers[index] = self.resource(entry["uri"])
        return self._buffers[index]

    def resource(self, uri: Any) -> bytes:
        """The bytes of a data URI or of a file beside this one.

        Raises:
            FileNotFoundError: There is no such file.
            ValueError: It lies elsewhere, or is too large.
        """
        if not isinstance(uri, str):
            raise ValueError(f"a uri must be a string, got {type(uri).__name__}")
        if uri.startswith("data:"):
            payload = _data_uri(uri)
        else:
            payload = self._files.read(unquote(uri), limit=self._budget)
        self._budget -= len(payload)
        return payload


def _split_glb(payload: bytes) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk; chunks of other kinds are skipped, as the format asks."""
    if len(payload) < 20:
        raise ValueError(f"a GLB has at least 20 bytes, got {len(payload)}")
    version, total = struct.unpack_from("<II", payload, 4)
    if version != 2 or total > len(payload):
        raise ValueError(
            f"GLB header says version {version} and {total} bytes, got {len(payload)} bytes"
        )
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= total:
        size, kind = struct.unpack_from("<II", payload, start)
        if start + 8 + size > total:
            raise ValueError(f"a GLB chunk needs {size} bytes, {total - start - 8} are left")
        chunks.setdefault(kind, payload[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON_CHUNK not in chunks:
        raise ValueError("the GLB has no JSON chunk")
    return chunks[_JSON_CHUNK], chunks.get(_BIN_CHUNK)


def _natural(entry: Any, key: str, where: str, default: int | None = None) -> int:
    value = entry.get(key, default) if isinstance(entry, dict) else None
    if type(value) is not int or value < 0:
        raise ValueError(f"{where}: {key} must be an integer >= 0, got {value!r}")
    return value


def _component(entry: Any, where: str) -> np.dtype[Any]:
    code = entry.get("componentType") if isinstance(entry, dict) else None
    if type(code) is not int or code not in _COMPONENTS:
        raise ValueError(f"{where}: componentType {code!r} is not supported")
    return np.dtype(_COMPONENTS[code])


def _normalised(values: NDArray[Any]) -> NDArray[Any]:
    if values.dtype.kind == "f":
        return values
    top = np.iinfo(values.dtype).max
    shares: NDArray[Any] = np.maximum(values.astype(np.float32) / top, -1.0)
    return shares


def _data_uri(uri: str) -> bytes:
    head, comma, body = uri.partition(",")
    if not comma or not head.endswith(";base64"):
        raise ValueError(f"a data uri must be base64, got {head[:60]!r}")
    try:
        return base64.b64decode(body, validate=True)
    except binascii.Error as error:
        raise ValueError(f"a data uri does not decode: {error}") from error
