"""The order of an epoch: a pure function of seed, epoch and episodes, the same on every machine."""

from __future__ import annotations

import hashlib
import operator
from collections.abc import Sequence
from typing import Any, Literal, Protocol, TypeAlias, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.loaders.places import Place

__all__ = ["EpisodeOrder", "Episodes", "Shuffle", "epoch_order", "scene_aware"]

Shuffle: TypeAlias = bool | Literal["scenes"]
"""`False`: the table's order; `True`: shuffled; `"scenes"`: shuffled, then grouped by scene."""


@runtime_checkable
class Episodes(Protocol):
    """What can be ordered, shared among ranks and resumed: `AffectSimDataset` and its parts."""

    @property
    def fingerprint(self) -> str:
        """Identifies the ordered list of episodes and their content."""

    @property
    def scene_codes(self) -> NDArray[np.int64]:
        """A number for the scene of each episode, `(len,)`."""

    @property
    def source(self) -> str:
        """Where the episodes come from; on the Hub, with the commit."""

    def __len__(self) -> int: ...

    def __getitem__(self, place: int | Place) -> Any: ...

    def __getitems__(self, places: Sequence[int | Place]) -> list[Any]: ...


def epoch_order(num_episodes: int, *, seed: int, epoch: int, fingerprint: str) -> NDArray[np.int64]:
    """Every episode once, shuffled, `(num_episodes,)`.

    The sort of raw 64-bit words of a Philox generator whose key is a SHA-256 of the arguments: both
    are fixed for ever, whereas NumPy may change what `Generator.permutation` returns.

    Args:
        num_episodes: How many there are.
        seed: Any whole number from 0 up.
        epoch: From 0 up.
        fingerprint: Of the episodes; other episodes have another order.

    Raises:
        ValueError: A negative or fractional number.

    Examples:
        >>> epoch_order(5, seed=0, epoch=0, fingerprint="")
        array([1, 4, 2, 3, 0])
    """
    num_episodes = _natural("num_episodes", num_episodes)
    key = f"{_natural('seed', seed)} {_natural('epoch', epoch)} {fingerprint}"
    digest = hashlib.sha256(key.encode()).digest()
    words = [int.from_bytes(digest[start : start + 8], "little") for start in (0, 8)]
    generator = np.random.Philox(key=np.array(words, np.uint64))
    return np.argsort(generator.random_raw(num_episodes), kind="stable").astype(np.int64)


def scene_aware(order: ArrayLike, scene_codes: ArrayLike, *, window: int) -> NDArray[np.int64]:
    """An order with its episodes grouped by scene inside consecutive windows, `(num_episodes,)`.

    Scenes stand in the order of their first appearance in the window, episodes of a scene in the
    order they had. So every episode moves by less than `window` places, each window holds the
    episodes it held, and a scene is drawn in one go per window instead of here and there.

    Args:
        order: Rows, `(num_episodes,)`.
        scene_codes: A number for the scene of each row, `(num_episodes,)`, indexed by row.
        window: Places, from 1 up; 1 changes nothing.

    Raises:
        ValueError: A window below 1, or not one scene per row.

    Examples:
        >>> scene_aware([3, 0, 2, 1], [7, 7, 8, 8], window=4)
        array([3, 2, 0, 1])
    """
    rows, codes = np.asarray(order, np.int64), np.asarray(scene_codes)
    if rows.shape != codes.shape or rows.ndim != 1:
        raise ValueError(
            f"scene_codes must have one scene per episode, {rows.shape}, got {codes.shape}"
        )
    window = _window(window)
    scenes, scene = np.unique(codes[rows], return_inverse=True)
    group = np.arange(len(rows)) // window * len(scenes) + scene
    _, first, member = np.unique(group, return_index=True, return_inverse=True)
    return rows[np.argsort(first[member], kind="stable")]


class EpisodeOrder:
    """The order of every epoch of a set of episodes."""

    def __init__(self, dataset: Episodes, *, shuffle: Shuffle, window: int, seed: int) -> None:
        """Takes from the dataset what the order depends on.

        Args:
            dataset: The episodes.
            shuffle: See `Shuffle`.
            window: Places of the shuffled order within which scenes are grouped.
            seed: Of the shuffle.

        Raises:
            ValueError: Not a dataset of episodes, an empty one, or an argument out of range.
        """
        if not isinstance(dataset, Episodes):
            raise ValueError(
                "the order needs a dataset that says its fingerprint, scene_codes and source: "
                f"AffectSimDataset, its subsets and concatenations; got {type(dataset).__name__}"
            )
        if shuffle is not True and shuffle is not False and shuffle != "scenes":
            raise ValueError(f"shuffle must be False, True or 'scenes', got {shuffle!r}")
        self.num_episodes = len(dataset)
        if not self.num_episodes:
            raise ValueError(f"{dataset.source}: there is no episode to load")
        self.fingerprint, self.source = dataset.fingerprint, dataset.source
        self.shuffle: Shuffle = shuffle
        self.window, self.seed = _window(window), _natural("seed", seed)
        self._scene_codes = dataset.scene_codes if shuffle == "scenes" else None
        self._latest: tuple[int, NDArray[np.int64]] | None = None

    def rows(self, epoch: int) -> NDArray[np.int64]:
        """Rows of the dataset in the order of an epoch, `(num_episodes,)`.

        Raises:
            ValueError: A negative epoch.
        """
        if self._latest is None or self._latest[0] != epoch:
            self._latest = (epoch, self._rows(epoch))
        return self._latest[1]

    def _rows(self, epoch: int) -> NDArray[np.int64]:
        if not self.shuffle:
            return np.arange(self.num_episodes)
        rows = epoch_order(
            self.num_episodes, seed=self.seed, epoch=epoch, fingerprint=self.fingerprint
        )
        if self._scene_codes is None:
            return rows
        return scene_aware(rows, self._scene_codes, window=self.window)


def _natural(name: str, value: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < 0:
        raise ValueError(f"{name} must be a whole number from 0 up, got {value!r}")
    return number


def _window(window: int) -> int:
    if not isinstance(window, int | np.integer) or window < 1:
        raise ValueError(f"window must be a number of places from 1 up, got {window!r}")
    return int(window)
