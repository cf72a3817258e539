"""Frames of a clip as a model is sent them: JPEG, as `data:` URIs."""

from __future__ import annotations

import base64

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.loaders import Sample

__all__ = ["data_uri", "encode_frame", "encode_frames", "frames_of"]


def frames_of(sample: Sample) -> NDArray[np.uint8]:
    """The frames of a sample, `(num_frames, height, width, 3)` RGB.

    Raises:
        ValueError: The sample has no `video`, or not one of uint8 `(num_frames, 3, height, width)`.
    """
    if "video" not in sample:
        raise ValueError("a sample has no video; make the dataset with images=True")
    video: NDArray[np.uint8] = np.asarray(sample["video"])
    if video.dtype != np.uint8 or video.ndim != 4 or video.shape[1] != 3 or not video.size:
        raise ValueError(
            f"video must be uint8 (num_frames, 3, height, width), got {video.dtype} {video.shape}"
        )
    return video.transpose(0, 2, 3, 1)


def encode_frames(
    frames: NDArray[np.uint8], *, quality: int = 90, max_side: int | None = None
) -> list[bytes]:
    """Each frame as a JPEG file, in order; the same frames give the same bytes.

    Args:
        frames: uint8 `(num_frames, height, width, 3)` RGB.
        quality: Of JPEG, 1 to 100.
        max_side: Pixels; a frame with a longer side is made smaller, its aspect kept.
    """
    return [encode_frame(frame, quality=quality, max_side=max_side) for frame in frames]


def encode_frame(
    frame: NDArray[np.uint8], *, quality: int = 90, max_side: int | None = None
) -> bytes:
    """One frame, uint8 `(height, width, 3)` RGB, as a JPEG file."""
    height, width = frame.shape[:2]
    pixels: NDArray[np.uint8] = frame[:, :, ::-1]
    if max_side is not None and max(height, width) > max_side:
        scale = max_side / max(height, width)
        size = (max(1, round(width * scale)), max(1, round(height * scale)))
        shrunk = cv2.resize(np.ascontiguousarray(pixels), size, interpolation=cv2.INTER_AREA)
        pixels = np.asarray(shrunk, np.uint8)
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality]
    done, encoded = cv2.imencode(".jpg", np.ascontiguousarray(pixels), settings)
    assert done
    return bytes(encoded)


def data_uri(jpeg: bytes) -> str:
    """A JPEG file as a URI that holds it."""
    return "data:image/jpeg;base64," + base64.b64encode(jpeg).decode("ascii")
