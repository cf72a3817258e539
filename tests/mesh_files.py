"""Small mesh files for tests: GLB and glTF from parts, images, KTX2 textures, OBJ models."""

from __future__ import annotations

import base64
import io
import json
import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from affectsim_data.glb import GlbBuilder

Document = dict[str, Any]

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
"""Corners of a unit square that faces +Z."""
SQUARE_FACES = np.array([0, 1, 2, 0, 2, 3], np.uint16)
SQUARE_UVS = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)

# 8 x 8 pixels, upper half (200, 40, 60), lower half (30, 160, 90). Made with alktx2 0.1.7 (PyPI):
# encode_raw_rgba_to_ktx2(pixels, 8, 8, has_alpha=False, codec=..., quality=100), UASTC with
# zstd_supercompression_level=9. Our own pixels, no licence needed.
KTX2_ETC1S = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAAAAAA"
    "igAAAAAAAABCAQAAAAAAAAIAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAAAAAAAAAA"
    "/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAAAIAAgAtAAAACQAAACwAAAAAAAAAAAAAAAAAAAACAAAA"
    "AAAAAAAAAAAXwEQAAAAAAABy4QOIEgAAAAAACSZoggBgAgAAAAAAAIEATAEQAAAAACBZkHIEAAAAUFVVVQU0wEQAAAAAAAAS"
    "RQCYABAAAAAAQBwBJgQIAAAAgCBySgHABAAAAAAAAAIIAKAB"
)
KTX2_UASTC = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAIAAAACAAAAAAAAAAAAAAAAQAAAAEAAAACAAAAaAAAACwAAACUAAAAJAAAAAAAAAAAAAAA"
    "AAAAAAAAAAC4AAAAAAAAACMAAAAAAAAAQAAAAAAAAAAsAAAAAAAAAAIAKACmAQIAAwMAABAAAAAAAAAAAAB/AAAAAAAAAAAA"
    "/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAACi1L/0gQNUAAIAXGYXnP7WjANcDVOs/WVsCAwAA5JkoEIAL"
)


def png(pixels: np.ndarray) -> bytes:
    """An array `(height, width, 3 or 4)` as PNG."""
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG")
    return buffer.getvalue()


def halves(*, alpha: bool = False) -> np.ndarray:
    """4 x 4 pixels: red left, blue right; with alpha the right half is clear."""
    pixels = np.zeros((4, 4, 4 if alpha else 3), np.uint8)
    pixels[:, :2, 0] = pixels[:, 2:, 2] = 255
    if alpha:
        pixels[:, :2, 3] = 255
    return pixels


def png_header(width: int, height: int) -> bytes:
    """A PNG that promises many pixels and has none."""
    body = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunk = struct.pack(">I", 13) + body + struct.pack(">I", zlib.crc32(body))
    data = b"IDAT" + zlib.compress(b"")
    chunk += struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    return b"\x89PNG\r\n\x1a\n" + chunk


def plain_ktx2(pixels: np.ndarray, *, packed: bool = False) -> bytes:
    """An array `(height, width, 4)` as an uncompressed KTX2, or one packed with zstd."""
    import pyarrow

    raw = pixels.tobytes()
    data = pyarrow.compress(raw, codec="zstd", asbytes=True) if packed else raw
    height, width = pixels.shape[:2]
    header = struct.pack("<9I", 43, 1, width, height, 0, 0, 1, 1, 2 if packed else 0)
    header += struct.pack("<4I2Q", 0, 0, 0, 0, 0, 0)
    start = 12 + len(header) + 24
    return (
        b"\xabKTX 20\xbb\r\n\x1a\n" + header + struct.pack("<3Q", start, len(data), len(raw)) + data
    )


def square_glb(
    *, node: Document | None = None, material: Document | None = None,
    images: list[bytes] | None = None, primitive: Document | None = None,
    attributes: dict[str, np.ndarray] | None = None, faces: np.ndarray | None = None,
    extra: Document | None = None, normals: bool = True,
) -> bytes:  # fmt: skip
    """A GLB of one mesh, the unit square unless told otherwise.

    Args:
        node: Members of its node.
        material: Its material.
        images: Encoded images; texture k shows image k.
        primitive: More members of its primitive.
        attributes: Vertex attributes that are added or replaced.
        faces: Indices.
        extra: Top-level members that are added or replaced.
        normals: Whether it has normals.
    """
    builder = GlbBuilder()
    arrays: dict[str, np.ndarray] = {"POSITION": SQUARE, "TEXCOORD_0": SQUARE_UVS}
    if normals:
        arrays["NORMAL"] = np.tile(np.array([[0, 0, 1]], np.float32), (4, 1))
    arrays.update(attributes or {})
    named = {
        name: builder.accessor(array, normalized=array.dtype.kind == "u" and "COLOR" in name)
        for name, array in arrays.items()
    }
    indices = builder.accessor(SQUARE_FACES if faces is None else faces)
    part = {"attributes": named, "indices": indices, "material": 0, **(primitive or {})}
    for image in images or []:
        builder.png(image)
    document: Document = {
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "name": "square", **(node or {})}],
        "meshes": [{"primitives": [part]}],
        "materials": [{"name": "paint", **(material or {})}],
        "textures": [{"source": k} for k in range(len(images or []))],
        **(extra or {}),
    }
    return builder.to_bytes(document)


def textured(factor: list[float] | None = None, **info: Any) -> Document:
    """A material that shows texture 0."""
    pbr: Document = {"baseColorTexture": {"index": 0, **info}}
    if factor is not None:
        pbr["baseColorFactor"] = factor
    return {"pbrMetallicRoughness": pbr}


def document_of(payload: bytes) -> tuple[Document, bytes]:
    """JSON and binary chunk of a GLB."""
    length = struct.unpack_from("<I", payload, 12)[0]
    return json.loads(payload[20 : 20 + length]), payload[28 + length :]


def pack(document: Any, blob: bytes) -> bytes:
    """A GLB of any JSON, well formed or not."""
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(blob), 0x004E4942) + blob
    return struct.pack("<III", 0x46546C67, 2, 12 + len(body)) + body


def boxes_obj(
    boxes: dict[str, tuple[tuple[float, float, float], tuple[float, float, float]]],
    *, library: str = "", textured: bool = False,
) -> str:  # fmt: skip
    """An OBJ of boxes, each an object of its own with a material of its name.

    Args:
        boxes: Lowest and highest corner by name.
        library: Name of the MTL.
        textured: Whether corners have texture coordinates.
    """
    lines = [f"mtllib {library}"] if library else []
    lines += ["vt 0 0", "vt 1 0", "vt 1 1", "vt 0 1"] if textured else []
    for number, (name, (low, high)) in enumerate(boxes.items()):
        lines += [f"o {name}", f"usemtl {name}"]
        for x in (low[0], high[0]):
            for y in (low[1], high[1]):
                lines += [f"v {x} {y} {z}" for z in (low[2], high[2])]
        quads = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
        for quad in quads:
            corners = [str(int(k) + 8 * number) for k in quad.split()]
            if textured:
                corners = [f"{corner}/{k}" for k, corner in enumerate(corners, start=1)]
            lines.append("f " + " ".join(corners))
    return "\n".join(lines) + "\n"


def write(path: Path, content: bytes | str) -> Path:
    """Writes a file and the folders it needs."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    return path
