"""KTX2 textures: Basis Universal by a library, plain 8-bit pixels by hand.

HSSD and other Habitat data sets hold their textures in this container (glTF extension
`KHR_texture_basisu`).
"""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import NDArray

from affectsim_data.errors import require_extra

__all__ = ["KTX2_MAGIC", "decode_ktx2"]

KTX2_MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
_HEADER = struct.Struct("<9I")
_LEVEL = struct.Struct("<3Q")
_FIRST_LEVEL = 80
"""Bytes before the index of levels."""
_PLAIN = {9: 1, 15: 1, 16: 2, 22: 2, 23: 3, 29: 3, 37: 4, 43: 4}
"""Channels of the VkFormats R8, RG8, RGB8 and RGBA8, linear (UNORM) and sRGB."""
_BASIS = 0
"""VkFormat of Basis Universal: undefined."""
_NO_SCHEME, _BASIS_LZ, _ZSTD = 0, 1, 2


def decode_ktx2(payload: bytes, *, max_side: int) -> NDArray[np.uint8]:
    """The largest level of a two-dimensional KTX2 texture: `(height, width, 3 or 4)`.

    Args:
        payload: The file.
        max_side: Most pixels a side; checked before anything is decoded.

    Raises:
        ValueError: Broken, too large, or of a kind that cannot be decoded.
        MissingExtraError: Basis Universal, and the extra `ktx2` is not installed.
    """
    if len(payload) < _FIRST_LEVEL + _LEVEL.size or not payload.startswith(KTX2_MAGIC):
        raise ValueError(f"not a complete KTX2 file: {len(payload)} bytes")
    kind, _, width, height, depth, layers, faces, _, scheme = _HEADER.unpack_from(payload, 12)
    if depth > 1 or layers > 1 or faces != 1 or height == 0:
        raise ValueError(
            f"a KTX2 of {faces} faces, {layers} layers and depth {depth} is no picture"
        )
    if max(width, height) > max_side:
        raise ValueError(f"{width} x {height} pixels, more than {max_side} a side")
    if kind == _BASIS:
        return _decode_basis(payload)
    if kind not in _PLAIN or scheme not in (_NO_SCHEME, _ZSTD):
        raise ValueError(f"KTX2 of VkFormat {kind} with supercompression {scheme} is not supported")
    return _decode_plain(payload, (height, width, _PLAIN[kind]), packed=scheme == _ZSTD)


def _decode_basis(payload: bytes) -> NDArray[np.uint8]:
    basisu = require_extra("opengl_basisu", extra="ktx2")
    try:
        texture = basisu.open(payload)
        pixels = np.asarray(texture.transcode(basisu.Target.RGBA8).data, np.uint8)
        pixels = pixels.reshape(texture.height, texture.width, 4)
    except (ValueError, IndexError, RuntimeError, OSError) as error:
        raise ValueError(f"KTX2: {error}") from error
    return pixels if texture.has_alpha else np.ascontiguousarray(pixels[..., :3])


def _decode_plain(
    payload: bytes, shape: tuple[int, int, int], *, packed: bool
) -> NDArray[np.uint8]:
    start, size, unpacked = _LEVEL.unpack_from(payload, _FIRST_LEVEL)
    expected = shape[0] * shape[1] * shape[2]
    if start + size > len(payload) or (unpacked if packed else size) != expected:
        raise ValueError(f"KTX2 level 0 must hold {expected} bytes of pixels, got {size}")
    data = payload[start : start + size]
    if packed:
        data = _unpack_zstd(data, expected)
    pixels = np.frombuffer(data, np.uint8).reshape(shape)
    if shape[2] == 2:
        # Red and green alone: blue is 0, as a texture unit reads it.
        pixels = np.concatenate([pixels, np.zeros_like(pixels[..., :1])], axis=-1)
    return np.repeat(pixels, 3, axis=-1) if shape[2] == 1 else pixels


def _unpack_zstd(data: bytes, size: int) -> bytes:
    import pyarrow

    try:
        return pyarrow.decompress(data, size, codec="zstd", asbytes=True)  # type: ignore[no-any-return]
    except (OSError, ValueError) as error:
        raise ValueError(f"KTX2: {error}") from error
