"""Datasets that draw nothing and recognizers that know nothing, for tests of running them."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import torch

from affectsim_data.loaders import (
    AffectSimDataset,
    Clip,
    ConcatenatedDataset,
    Sample,
    concatenate,
)
from affectsim_data.loaders.places import Place
from affectsim_data.motions import EMOTIONS
from affectsim_data.observations import Condition, Orbit
from affectsim_data.recognizers import Reply
from affectsim_data.releases import Release

CONDITIONS = ("p_init", "p_ref", "p_mon")


class Undrawn(AffectSimDataset):
    """Clips of noise that hangs on episode and condition; keeps what was asked for."""

    drawn: list[tuple[str, str]]
    """Episodes and conditions, in the order in which they were drawn."""

    def _draw(self, place: Place) -> Any:
        key = (self.episode(place.row).episode_id, self.condition.name)
        self.drawn.append(key)
        seed = int.from_bytes(hashlib.sha256(repr(key).encode()).digest()[:4], "little")
        noise = torch.Generator().manual_seed(seed)
        shape = (int(self.clip.num_frames), 3, self.clip.height, self.clip.width)
        return {
            "episode_id": key[0],
            "condition": key[1],
            "label": 2,
            "emotion": "happy",
            "video": torch.randint(0, 256, shape, dtype=torch.uint8, generator=noise),
            "depth": torch.ones(shape[0], 1, *shape[2:]),
            "intrinsics": torch.eye(3, dtype=torch.float64),
            "time_s": torch.zeros(shape[0], dtype=torch.float64),
        }


def undrawn(
    release: Release | Path,
    *,
    orbits: int = 0,
    split: str = "test",
    conditions: Sequence[str] = CONDITIONS,
    num_frames: int = 2,
) -> tuple[ConcatenatedDataset, list[tuple[str, str]]]:
    """Two episodes under some conditions and from some sides, and the list of what is drawn."""
    drawn: list[tuple[str, str]] = []
    sides: list[str | Condition] = [
        Orbit(distance_m=2.0, azimuth_deg=float(side)) for side in range(orbits)
    ]
    parts = []
    small = Clip(num_frames=num_frames, width=8, height=6)
    for condition in [*conditions, *sides]:
        part = Undrawn(release, split=split, condition=condition, clip=small)
        part.drawn = drawn
        parts.append(part)
    return concatenate(parts), drawn


class Teller:
    """Answers by the sum of the pixels, and remembers how often it was asked."""

    def __init__(self, name: str = "teller", *, batch_size: int = 2) -> None:
        self.name, self.batch_size = name, batch_size
        self.num_asked = 0

    def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
        """Text for even sums, a label and scores for odd ones."""
        self.num_asked += len(samples)
        return [self.reply(sample) for sample in samples]

    def reply(self, sample: Sample) -> Reply:
        """To one clip."""
        total = int(sample["video"].sum())
        emotion = EMOTIONS[total // 2 % len(EMOTIONS)]
        if total % 2:
            return Reply(label=emotion, scores=(0.5, 0.25, 0.125, 0.0625, 0.0625))
        return Reply(raw_text=f'I see "{emotion}",\nnothing else: \u2014 {total}', latency_ms=5.0)


def main(release: str, out: str, kill_after: int) -> None:
    """Predicts, and is killed when it has been asked about so many clips."""
    from affectsim_data.recognizers import predict

    class Mortal(Teller):
        def recognize(self, samples: Sequence[Sample]) -> list[Reply]:
            if self.num_asked >= kill_after:
                os.kill(os.getpid(), 9)
            return super().recognize(samples)

    predict(Mortal(), undrawn(Path(release), orbits=3)[0], out, progress=False)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
