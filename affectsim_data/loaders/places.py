"""What a sampler asks a dataset for: an episode, and its place in the order of an epoch."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["Place"]


class Place(NamedTuple):
    """A request for one sample; datasets take it wherever they take an index."""

    row: int
    """Index of the episode in the dataset."""
    epoch: int
    """Epoch the order belongs to."""
    position: int
    """Place in the global order of that epoch, over all ranks."""
    padding: bool = False
    """Whether this repeats an episode only to give every rank as many samples."""
    ahead: tuple[int, ...] = ()
    """Rows the same process will be asked for soon: a release on the Hub fetches them now."""
