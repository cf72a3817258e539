"""Episodes that are only numbers, and what the tests of order, ranks and resume ask of loaders."""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from torch.utils.data import Dataset

from affectsim_data.loaders.places import Place

Seen = list[tuple[int, int, int, bool]]
"""Row, epoch, position and padding of every sample, in the order a loop got them."""


class TinyEpisodes(Dataset[Any]):
    """`num_episodes` episodes in `num_scenes` scenes; a sample says what was asked for."""

    def __init__(
        self, num_episodes: int, *, num_scenes: int = 3, fingerprint: str = "tiny"
    ) -> None:
        self.fingerprint = fingerprint
        self.source = "tests/tiny"
        self.scene_codes: NDArray[np.int64] = np.arange(num_episodes) * 7919 % max(1, num_scenes)
        self.asked: list[Place] = []

    def __len__(self) -> int:
        return len(self.scene_codes)

    def __getitem__(self, place: int | Place) -> dict[str, Any]:
        assert isinstance(place, Place)
        self.asked.append(place)
        return {
            "row": place.row,
            "epoch": place.epoch,
            "position": place.position,
            "padding": place.padding,
        }

    def __getitems__(self, places: Sequence[int | Place]) -> list[dict[str, Any]]:
        return [self[place] for place in places]


def seen_in(batch: dict[str, Any]) -> Seen:
    """The samples of one collated batch."""
    columns = [batch[name].tolist() for name in ("row", "epoch", "position", "padding")]
    return list(zip(*columns, strict=True))


def seen(batches: Iterable[dict[str, Any]]) -> Seen:
    """The samples of all batches."""
    return list(itertools.chain.from_iterable(seen_in(batch) for batch in batches))


def interleaved(per_rank: Sequence[Sequence[Any]]) -> list[Any]:
    """What all ranks got, step by step: `per_rank[rank][step]` is a list of samples."""
    return [one for step in zip(*per_rank, strict=True) for part in step for one in part]
