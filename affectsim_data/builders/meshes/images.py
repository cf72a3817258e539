"""Textures of mesh files: decoded within bounds, each once."""

from __future__ import annotations

import io
import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.ktx2 import KTX2_MAGIC, decode_ktx2
from affectsim_data.builders.meshes.limits import MeshLimits
from affectsim_data.errors import MissingExtraError

__all__ = ["Pixels", "Textures", "decode_image"]

Pixels = NDArray[np.uint8]
"""`(height, width, 3)` or, with alpha, `(height, width, 4)`."""
_FORMATS = ("PNG", "JPEG", "WEBP", "BMP", "TGA", "GIF", "TIFF")


def decode_image(payload: bytes, *, limits: MeshLimits) -> Pixels:
    """The pixels of an encoded image, at most `limits.texture_side` a side.

    Raises:
        ValueError: Not an image this can read, or larger than the limits.
        MissingExtraError: It is a Basis Universal texture and the extra `ktx2` is not installed.
    """
    if payload.startswith(KTX2_MAGIC):
        return _scaled(decode_ktx2(payload, max_side=limits.max_texture_side), limits)
    try:
        with (
            # Pillow warns of sizes that are refused here anyway.
            warnings.catch_warnings(action="ignore", category=Image.DecompressionBombWarning),
            Image.open(io.BytesIO(payload), formats=_FORMATS) as image,
        ):
            _check_size(image.size, limits)
            image.draft("RGB", (limits.texture_side, limits.texture_side))
            clear = "A" in image.getbands() or "transparency" in image.info
            pixels = np.asarray(image.convert("RGBA" if clear else "RGB"))
    except (OSError, SyntaxError, Image.DecompressionBombError, EOFError, IndexError) as error:
        # Pillow reports a broken image as any of these.
        raise ValueError(f"not an image that can be read: {error}") from error
    return _scaled(pixels, limits)


def _check_size(size: tuple[int, int], limits: MeshLimits) -> None:
    if max(size) > limits.max_texture_side:
        raise ValueError(
            f"{size[0]} x {size[1]} pixels, more than {limits.max_texture_side} a side"
        )


def _scaled(pixels: Pixels, limits: MeshLimits) -> Pixels:
    height, width = pixels.shape[:2]
    side = max(height, width)
    if side <= limits.texture_side:
        return pixels
    import cv2

    share = limits.texture_side / side
    size = (max(round(width * share), 1), max(round(height * share), 1))
    return np.asarray(cv2.resize(pixels, size, interpolation=cv2.INTER_AREA), np.uint8)


class Textures:
    """The textures of one file, decoded when first asked for; failures are noted, once each."""

    def __init__(self, *, limits: MeshLimits, notes: Notes) -> None:
        self._limits, self._notes = limits, notes
        self._left = limits.max_texture_bytes
        self._found: dict[str, Pixels | None] = {}

    def get(self, key: str, read: Callable[[], bytes]) -> Pixels | None:
        """The texture called `key`, or none, with a note that says why.

        Args:
            key: Its name in the notes; equal keys are one texture.
            read: Gives its encoded bytes.
        """
        if key not in self._found:
            self._found[key] = self._decode(key, read)
        return self._found[key]

    def _decode(self, key: str, read: Callable[[], bytes]) -> Pixels | None:
        try:
            pixels = decode_image(read(), limits=self._limits)
        except FileNotFoundError as error:
            self._notes[f"texture {key} missing, base colour instead: {error}"] += 1
            return None
        except (ValueError, MissingExtraError) as error:
            self._notes[f"texture {key} not decoded, base colour instead: {error}"] += 1
            return None
        if pixels.nbytes > self._left:
            limit = self._limits.max_texture_bytes
            self._notes[
                f"texture {key} over the {limit} bytes a file may decode to, base colour instead"
            ] += 1
            return None
        self._left -= pixels.nbytes
        return pixels
