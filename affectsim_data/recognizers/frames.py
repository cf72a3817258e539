"""What a recognizer is shown: the frames of a sample without its answer, and their hash."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from typing import Any, cast

import torch
from PIL import Image

from affectsim_data.loaders import Sample

__all__ = ["SEEN", "blinded", "frame_pictures", "frame_strip", "frames_sha256"]

SEEN = ("video", "depth", "intrinsics", "time_s")
"""What of a sample a recognizer gets."""
_STRIP_COLUMNS, _STRIP_GAP = 8, 4
_STRIP_GROUND = (255, 255, 255)


class _Blinded(dict[str, Any]):
    """A sample without what would tell the answer; says so to whoever asks."""

    def __missing__(self, name: str) -> Any:
        raise KeyError(
            f"a recognizer is given {', '.join(SEEN)}, not {name!r}: the rest of a sample says "
            "what the answer is"
        )


def blinded(sample: Sample) -> Sample:
    """The part of a sample that a recognizer may look at.

    Raises:
        ValueError: It has no video.
    """
    if not isinstance(sample, dict) or not isinstance(sample.get("video"), torch.Tensor):
        raise ValueError(
            "a recognizer needs samples with `video`: a dataset with images=True and no transform"
        )
    everything = cast(dict[str, Any], sample)
    seen = {name: everything[name] for name in SEEN if name in everything}
    return cast(Sample, _Blinded(seen))


def frames_sha256(video: torch.Tensor) -> str:
    """Names the frames of a clip, hexadecimal: equal only for equal frames.

    The hash is of the ASCII text `uint8 8x3x224x224` and a newline, with the clip's shape, and then
    of its bytes in row-major order.

    Args:
        video: uint8 `(num_frames, 3, height, width)`.

    Raises:
        ValueError: Not such a clip.
    """
    if video.dtype != torch.uint8 or video.ndim != 4:
        raise ValueError(
            "a clip is uint8 (num_frames, 3, height, width), got "
            f"{video.dtype} {tuple(video.shape)}"
        )
    shape = "x".join(map(str, video.shape))
    digest = hashlib.sha256(f"uint8 {shape}\n".encode())
    digest.update(video.contiguous().numpy().data)
    return digest.hexdigest()


def frame_pictures(video: torch.Tensor) -> list[Image.Image]:
    """The frames of a clip as RGB pictures, in order.

    Args:
        video: uint8 `(num_frames, 3, height, width)`.
    """
    return [Image.fromarray(frame) for frame in video.permute(0, 2, 3, 1).contiguous().numpy()]


def frame_strip(videos: Sequence[torch.Tensor]) -> Image.Image:
    """The frames of clips in one picture, pixel by pixel as they are; each clip begins a row.

    Args:
        videos: uint8 `(num_frames, 3, height, width)` each, all of one size.
    """
    clips = [frame_pictures(video) for video in videos]
    columns = min(max(map(len, clips)), _STRIP_COLUMNS)
    rows = [clip[at : at + columns] for clip in clips for at in range(0, len(clip), columns)]
    width, height = (side + _STRIP_GAP for side in rows[0][0].size)
    size = (columns * width - _STRIP_GAP, len(rows) * height - _STRIP_GAP)
    strip = Image.new("RGB", size, _STRIP_GROUND)
    for row, pictures in enumerate(rows):
        for column, picture in enumerate(pictures):
            strip.paste(picture, (column * width, row * height))
    return strip
