"""`AffectSimDataset`: episodes of a release, seen under one condition, drawn when asked for."""

from __future__ import annotations

import copy
import functools
import hashlib
import itertools
import operator
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray
from torch.utils.data import Dataset

from affectsim_data.episodes import Episode, World
from affectsim_data.loaders.places import Place
from affectsim_data.loaders.presets import Clip, is_recorded, resolve_clip, resolve_condition
from affectsim_data.loaders.requests import as_place, chosen_rows
from affectsim_data.loaders.samples import Sample, draw_sample
from affectsim_data.loaders.trajectories import check_recorded, open_trajectories
from affectsim_data.observations import AObs, Condition
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.joined_splits import split_title
from affectsim_data.releases.selection import select_rows, selection_fingerprint
from affectsim_data.releases.splits import EpisodeTable, SplitBy, dictionary_codes
from affectsim_data.render import RendererName, process_renderer

if TYPE_CHECKING:
    from affectsim_data.loaders.concatenation import ConcatenatedDataset

__all__ = ["AffectSimDataset"]

_DERIVED = ("fingerprint", "scene_codes")
"""Computed when asked for; workers do without."""


class AffectSimDataset(Dataset[Any]):
    """A map-style dataset of clips; the same episode and condition give the same pixels, always.

    Examples:
        >>> dataset = AffectSimDataset(split="test", condition="p_ref")  # doctest: +SKIP
        >>> dataset[0]["video"].shape  # doctest: +SKIP
        torch.Size([8, 3, 224, 224])
        >>> sad = AffectSimDataset(filter=[("emotion", "in", ["sad"])])  # doctest: +SKIP
    """

    def __init__(
        self,
        release: str | Path | Release = "mini",
        *,
        split: str = "test",
        split_by: SplitBy = "group",
        condition: str | Condition = "p_ref",
        trajectories: str | Path | None = None,
        policy: str | None = None,
        clip: str | Clip = "8x224",
        filter: Filter | None = None,
        episodes: Iterable[str] | None = None,
        exclude: Iterable[str] | None = None,
        transform: Callable[[Sample], Any] | None = None,
        images: bool = True,
        instances: bool = False,
        renderer: RendererName = "egl",
        device: int | None = None,
    ) -> None:
        """Opens the release; nothing is drawn and no GL context is made before the first sample.

        Args:
            release: `mini` (built on first use), a folder, `hf://datasets/ORG/NAME@REVISION`, or
                a release already open.
            split: `train`, `validation` or `test`.
            split_by: What no two splits share: `group`, the paper's split, for people never seen;
                `scene`, for homes never seen; `both`, for either at once, of fewer episodes.
            condition: `p_init`, `p_ref`, `p_mon`, `a_obs`, or an object such as
                `Orbit(distance_m=2.0)`.
            trajectories: What `a_obs` shows: a Parquet table that `affectsim acquire` made; that
                of the release if not given.
            policy: Whose trajectories, where there are those of several.
            clip: `8x224`, `16x224`, `1x448`, `full`, or a `Clip`.
            filter: Only episodes whose columns match: `[(column, operator, value), ...]` where
                all hold, or a list of such lists where one does, as pyarrow takes them.
            episodes: Only the episodes with these identifiers, in this order.
            exclude: No episode with one of these identifiers.
            transform: Takes a `Sample` and returns what the dataset shall yield.
            images: Whether to draw; without, samples lack `video` and `depth`, and need no GL.
            instances: Whether samples carry instance ids.
            renderer: `egl`, or `pyrender`, the slow reference.
            device: EGL device; the one `open_renderer` would take if not given.

        Raises:
            FileNotFoundError: No such release, or not all of it.
            ValueError: Unknown split, split_by, condition or clip; an empty split; `instances`
                without `images`; a malformed filter, an unknown identifier, or no episode left;
                trajectories that are not those of one policy, lack episodes, or that nothing shows.
        """
        self.clip = resolve_clip(clip)
        self.release = release if isinstance(release, Release) else open_release(release)
        self.split, self.split_by = split, split_by
        self.condition = self._resolved(condition, trajectories, policy)
        if instances and not images:
            raise ValueError("instances=True needs images=True: instance ids are drawn")
        self._rows = self._packed(
            select_rows(
                self.release,
                split,
                split_by=split_by,
                filter=filter,
                episodes=episodes,
                exclude=exclude,
            )
        )
        if isinstance(self.condition, AObs):
            runs = self.condition.trajectories
            check_recorded(runs, self.release, split, split_by, self.rows)
        self._transform = transform
        self._images = images
        self._instances = instances
        self._renderer: RendererName = renderer
        self._device = device

    def _resolved(
        self, condition: str | Condition, trajectories: str | Path | None, policy: str | None
    ) -> Condition:
        """The condition, with what was recorded if it shows that."""
        if is_recorded(condition):
            runs = open_trajectories(
                self.release, self.split, self.split_by, trajectories=trajectories, policy=policy
            )
            return resolve_condition(condition, trajectories=runs)
        if trajectories is not None or policy is not None:
            raise ValueError(
                f"trajectories and policy go with condition 'a_obs', got {condition!r}"
            )
        return resolve_condition(condition)

    @property
    def _table(self) -> EpisodeTable:
        return self.release.split_table(self.split, self.split_by)

    def _packed(self, rows: NDArray[np.int64]) -> NDArray[np.int32] | None:
        """Rows as they are kept and sent to workers; `None` for the whole split in its order."""
        count = self._table.num_episodes
        whole = len(rows) == count and bool((rows == np.arange(count)).all())
        return None if whole else rows.astype(np.int32)

    def __getstate__(self) -> dict[str, Any]:
        """A worker process gets what it needs to draw, and reads the rest."""
        return {name: value for name, value in self.__dict__.items() if name not in _DERIVED}

    def __len__(self) -> int:
        if self._rows is None:
            return self._table.num_episodes
        return len(self._rows)

    @property
    def rows(self) -> NDArray[np.int64]:
        """Places in the split's table of the episodes, in order, `(len,)`."""
        if self._rows is None:
            return np.arange(len(self))
        return self._rows.astype(np.int64)

    @property
    def source(self) -> str:
        """Where the episodes come from; on the Hub, with the commit."""
        return self.release.uri

    @functools.cached_property
    def fingerprint(self) -> str:
        """Identifies the ordered list of episodes and the release's content, hexadecimal.

        Two datasets of the same episodes in the same order have the same one, however the episodes
        were chosen; condition, clip, place and commit do not matter. Under `a_obs` what was
        recorded does.
        """
        own = selection_fingerprint(self.release, self.split, self.rows, split_by=self.split_by)
        if not isinstance(self.condition, AObs):
            return own
        return hashlib.sha256(f"{own}\n{self.condition.trajectories.sha256}".encode()).hexdigest()

    @functools.cached_property
    def scene_codes(self) -> NDArray[np.int64]:
        """Places of the episodes' scenes in `scene_ids`, `(len,)`."""
        numbers = {scene_id: number for number, scene_id in enumerate(self.scene_ids)}
        codes, words = dictionary_codes(self._table.index.column("scene_id"))
        # A scene the release does not have is an error when it is drawn, not before.
        known = np.array([numbers.get(word, len(numbers)) for word in words], np.int64)
        return known[codes][self.rows]

    @property
    def scene_ids(self) -> list[str]:
        """All scenes of the release; `scene_codes` are places in it."""
        return self.release.asset_ids("scenes")

    def subset(self, rows: ArrayLike | slice) -> AffectSimDataset:
        """Some of the episodes, in the order asked for, of the same release and condition.

        Args:
            rows: Places in this dataset, a slice of them, or a mask `(len,)`.

        Raises:
            IndexError: A place outside the dataset.
            ValueError: No episode left, or neither of these.
        """
        part = copy.copy(self)
        part._rows = self._packed(self.rows[chosen_rows(rows, len(self))])
        return part

    def __add__(self, other: Dataset[Any]) -> ConcatenatedDataset:  # type: ignore[override]  # torch promises its own class
        # Not at the top: concatenations are made of these.
        from affectsim_data.loaders.concatenation import concatenate

        return concatenate([self, other])

    def episode(self, index: SupportsIndex) -> Episode:
        """The configuration behind a sample.

        Raises:
            IndexError: Outside the dataset.
        """
        row = as_place(index, len(self), self._name).row
        return self._table.episode(row if self._rows is None else int(self._rows[row]))

    @property
    def _name(self) -> str:
        title = split_title(self.split, self.split_by)
        return title if self._rows is None else f"this part of {title}"

    def world(self, index: SupportsIndex) -> World:
        """The scene and the people behind a sample."""
        return self.release.world(self.episode(index))

    def prefetch(self, rows: Iterable[int]) -> None:
        """Has what samples need fetched in the background, if the release is far; returns at once.

        Args:
            rows: Places in this dataset, in order of use.
        """
        if self.release.is_remote:
            wanted = np.fromiter(rows, np.int64)
            places = wanted if self._rows is None else self._rows[wanted]
            self.release.prefetch(self._table.files(places))

    def __getitem__(self, index: SupportsIndex | Place) -> Any:
        place = as_place(index, len(self), self._name)
        if place.ahead:
            self.prefetch((place.row, *place.ahead))
        return self._draw(place)

    def __getitems__(self, indices: Sequence[SupportsIndex | Place]) -> list[Any]:
        places = [as_place(index, len(self), self._name) for index in indices]
        ahead = itertools.chain.from_iterable(place.ahead for place in places)
        self.prefetch(itertools.chain(map(operator.attrgetter("row"), places), ahead))
        return [self._draw(place) for place in places]

    def _draw(self, place: Place) -> Any:
        episode = self.episode(place.row)
        sample = draw_sample(
            episode,
            self.release.world(episode),
            self.condition,
            self.clip,
            process_renderer(self._renderer, self._device) if self._images else None,
            release=self.release.uri,
            instances=self._instances,
            place=place,
        )
        return sample if self._transform is None else self._transform(sample)
