"""`AffectSimDataset`: episodes of a release, seen under one condition, drawn when asked for."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable
from pathlib import Path
from typing import Any

from torch.utils.data import DataLoader, Dataset

from affectsim_data.episodes import Episode, World
from affectsim_data.loaders.presets import Clip, resolve_clip, resolve_condition
from affectsim_data.loaders.samples import Sample, draw_sample
from affectsim_data.observations import Condition
from affectsim_data.releases import Release, open_release
from affectsim_data.render import RendererName, process_renderer

__all__ = ["AffectSimDataset", "data_loader"]


class AffectSimDataset(Dataset[Any]):
    """A map-style dataset of clips; the same episode and condition give the same pixels, always.

    Examples:
        >>> dataset = AffectSimDataset(split="test", condition="p_ref")  # doctest: +SKIP
        >>> dataset[0]["video"].shape  # doctest: +SKIP
        torch.Size([8, 3, 224, 224])
    """

    def __init__(
        self,
        release: str | Path | Release = "mini",
        *,
        split: str = "test",
        condition: str | Condition = "p_ref",
        clip: str | Clip = "8x224",
        transform: Callable[[Sample], Any] | None = None,
        instances: bool = False,
        renderer: RendererName = "egl",
    ) -> None:
        """Opens the release; nothing is drawn and no GL context is made before the first sample.

        Args:
            release: `mini` (built on first use), a folder, `hf://datasets/ORG/NAME@REVISION`, or
                a release already open.
            split: `train`, `validation` or `test`.
            condition: `p_init`, `p_ref`, `p_mon`, or an object such as `Orbit(distance_m=2.0)`.
            clip: `8x224`, `16x224`, `1x448`, `full`, or a `Clip`.
            transform: Takes a `Sample` and returns what the dataset shall yield.
            instances: Whether samples carry instance ids.
            renderer: `egl`, or `pyrender`, the slow reference.

        Raises:
            FileNotFoundError: No such release, or not all of it.
            ValueError: Unknown split, condition or clip; an empty split.
        """
        self.condition = resolve_condition(condition)
        self.clip = resolve_clip(clip)
        self.release = release if isinstance(release, Release) else open_release(release)
        self.split = split
        self._num_episodes = int(self.release.episode_index(split).num_rows)
        self._transform = transform
        self._instances = instances
        self._renderer = renderer

    def __len__(self) -> int:
        return self._num_episodes

    def episode(self, index: int) -> Episode:
        """The configuration behind a sample.

        Raises:
            IndexError: Outside the split.
        """
        if not -len(self) <= index < len(self):
            raise IndexError(f"split {self.split!r} has {len(self)} episodes, got index {index}")
        return self.release.episode(self.split, index % len(self))

    def world(self, index: int) -> World:
        """The scene and the people behind a sample."""
        return self.release.world(self.episode(index))

    def __getitem__(self, index: int) -> Any:
        episode = self.episode(index)
        sample = draw_sample(
            episode,
            self.release.world(episode),
            self.condition,
            self.clip,
            process_renderer(self._renderer),
            release=self.release.uri,
            instances=self._instances,
        )
        return sample if self._transform is None else self._transform(sample)


def data_loader(dataset: AffectSimDataset, **options: Any) -> DataLoader[Any]:
    """A stock DataLoader whose workers start clean, so that no GL context is ever inherited.

    Args:
        dataset: What to load.
        options: Passed on to `torch.utils.data.DataLoader`.
    """
    if options.get("num_workers", 0) and "multiprocessing_context" not in options:
        options["multiprocessing_context"] = multiprocessing.get_context("forkserver")
    return DataLoader(dataset, **options)
