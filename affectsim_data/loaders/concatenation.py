"""Several datasets as one: other splits, conditions or releases, in order."""

from __future__ import annotations

import bisect
import functools
import hashlib
import itertools
from collections.abc import Iterable, Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import NDArray
from torch.utils.data import Dataset

from affectsim_data.episodes import Episode, World
from affectsim_data.loaders.dataset import AffectSimDataset
from affectsim_data.loaders.places import Place
from affectsim_data.loaders.requests import as_place

__all__ = ["ConcatenatedDataset", "concatenate"]


def concatenate(datasets: Iterable[Any]) -> ConcatenatedDataset:
    """Datasets one after another; what is a concatenation already is taken apart.

    Raises:
        ValueError: There is none, or one is no dataset of this package.
    """
    parts: list[AffectSimDataset] = []
    for dataset in datasets:
        if isinstance(dataset, ConcatenatedDataset):
            parts += dataset.parts
        elif isinstance(dataset, AffectSimDataset):
            parts.append(dataset)
        else:
            raise ValueError(
                f"only AffectSimDatasets can be concatenated, got {type(dataset).__name__}"
            )
    return ConcatenatedDataset(parts)


class ConcatenatedDataset(Dataset[Any]):
    """Datasets one after another; made by `concatenate` or `+`."""

    def __init__(self, parts: Sequence[AffectSimDataset]) -> None:
        """Joins them.

        Raises:
            ValueError: There is none.
        """
        if not parts:
            raise ValueError("concatenate needs at least one dataset, got none")
        self.parts = tuple(parts)
        """In order; each has its condition, clip and transform."""
        self._ends = list(itertools.accumulate(len(part) for part in parts))

    def __getstate__(self) -> dict[str, Any]:
        """A worker process gets the parts and where they end."""
        return {"parts": self.parts, "_ends": self._ends}

    def __len__(self) -> int:
        return self._ends[-1]

    def __add__(self, other: Dataset[Any]) -> ConcatenatedDataset:  # type: ignore[override]  # torch promises its own class
        return concatenate([self, other])

    @property
    def source(self) -> str:
        """Where the episodes come from, each place once, joined by ` + `."""
        return " + ".join(dict.fromkeys(part.source for part in self.parts))

    @functools.cached_property
    def fingerprint(self) -> str:
        """Of the parts' fingerprints in order, hexadecimal."""
        return hashlib.sha256("\n".join(p.fingerprint for p in self.parts).encode()).hexdigest()

    @functools.cached_property
    def scene_codes(self) -> NDArray[np.int64]:
        """Places of the episodes' scenes in `scene_ids`, `(len,)`: a scene of a release has one
        place, whichever parts it is in."""
        first = self._first_scenes
        return np.concatenate(
            [part.scene_codes + first[part.release.content_sha256][0] for part in self.parts]
        )

    @property
    def scene_ids(self) -> list[str]:
        """All scenes of all the releases, release by release; `scene_codes` are places in it."""
        return list(itertools.chain.from_iterable(ids for _, ids in self._first_scenes.values()))

    @functools.cached_property
    def _first_scenes(self) -> dict[str, tuple[int, list[str]]]:
        """By content of a release: the place of its first scene in `scene_ids`, and its scenes."""
        found: dict[str, tuple[int, list[str]]] = {}
        total = 0
        for part in self.parts:
            if part.release.content_sha256 not in found:
                found[part.release.content_sha256] = (total, part.scene_ids)
                total += len(part.scene_ids)
        return found

    def _part(self, row: int) -> tuple[int, int]:
        """The part a row is in, and its row there."""
        number = bisect.bisect_right(self._ends, row)
        return number, row - (self._ends[number - 1] if number else 0)

    def _place(self, index: SupportsIndex | Place) -> Place:
        return as_place(index, len(self), "this concatenation")

    def episode(self, index: SupportsIndex) -> Episode:
        """The configuration behind a sample.

        Raises:
            IndexError: Outside the dataset.
        """
        number, row = self._part(self._place(index).row)
        return self.parts[number].episode(row)

    def world(self, index: SupportsIndex) -> World:
        """The scene and the people behind a sample."""
        number, row = self._part(self._place(index).row)
        return self.parts[number].world(row)

    def prefetch(self, rows: Iterable[int]) -> None:
        """Has what samples need fetched in the background, where a release is far."""
        by_part: dict[int, list[int]] = {}
        for row in rows:
            number, inside = self._part(row)
            by_part.setdefault(number, []).append(inside)
        for number, inside_part in by_part.items():
            self.parts[number].prefetch(inside_part)

    def __getitem__(self, index: SupportsIndex | Place) -> Any:
        return self.__getitems__([index])[0]

    def __getitems__(self, indices: Sequence[SupportsIndex | Place]) -> list[Any]:
        places = [self._place(index) for index in indices]
        ahead = itertools.chain.from_iterable(place.ahead for place in places)
        self.prefetch(itertools.chain((place.row for place in places), ahead))
        samples = []
        for place in places:
            number, row = self._part(place.row)
            samples.append(self.parts[number][place._replace(row=row, ahead=())])
        return samples
