"""`EpisodeStream`: the same batches in the same order, for loaders that want an iterable."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import torch
from torch.utils.data import IterableDataset, default_collate, get_worker_info

from affectsim_data.loaders.batches import DEFAULT_WINDOW
from affectsim_data.loaders.distribution import Ends
from affectsim_data.loaders.order import Episodes, Shuffle
from affectsim_data.loaders.plans import EpisodePlan, Point, ResumeToken

__all__ = ["EpisodeStream"]


class EpisodeStream(IterableDataset[Any]):
    """Whole batches of one rank; worker `w` of `W` makes the batches `w, w + W, ...` of a pass.

    So a stock DataLoader yields the batches of `EpisodeBatches` in their order, with any number of
    workers. Nobody tells an iterable that its user had the last batch: each pass is of the same
    epoch, from the same point, until `set_epoch` names another (`data_loader` needs no such call).

    torchdata's `StatefulDataLoader` resumes it within a pass with as many workers as before;
    `state_dict(batches_taken)` does with any.

    Examples:
        >>> stream = EpisodeStream(dataset, batch_size=8, shuffle=True)  # doctest: +SKIP
        >>> loader = DataLoader(stream, batch_size=None, num_workers=2)  # doctest: +SKIP
        >>> for epoch in range(10):  # doctest: +SKIP
        ...     stream.set_epoch(epoch)
        ...     for batch in loader:
        ...         train(batch)
    """

    def __init__(
        self,
        dataset: Episodes,
        *,
        batch_size: int = 1,
        shuffle: Shuffle = False,
        window: int = DEFAULT_WINDOW,
        seed: int = 0,
        rank: int | None = None,
        world_size: int | None = None,
        ends: Ends = "pad",
        look_ahead: int = 2,
        collate_fn: Callable[[list[Any]], Any] = default_collate,
    ) -> None:
        """Plans the batches; the first pass is epoch 0.

        Args:
            dataset: `AffectSimDataset`, a subset or a concatenation.
            batch_size: Samples of one rank in one step.
            shuffle: See `EpisodeBatches`, as for what follows.
            window: Places of the shuffled order in a window.
            seed: Of the shuffle, from 0 up.
            rank: Of this process; `None` for that of `torch.distributed`, else 0.
            world_size: How many ranks there are; goes with `rank`.
            ends: What becomes of an uneven end.
            look_ahead: How many batches before its turn a worker is told of one.
            collate_fn: Makes a batch of samples.

        Raises:
            ValueError: An argument out of range, or nothing is left to load.
        """
        self._dataset, self._collate = dataset, collate_fn
        self._plan = EpisodePlan(
            dataset,
            batch_size=batch_size,
            shuffle=shuffle,
            window=window,
            seed=seed,
            rank=rank,
            world_size=world_size,
            ends=ends,
            look_ahead=look_ahead,
        )
        self._start = Point(0, 0)
        # A persistent worker lives on with a copy of this object; what it must hear of goes here.
        self._shared_start = torch.tensor(self._start)
        self._shared_start.share_memory_()  # type: ignore[no-untyped-call]  # torch's own
        self._passes_as_worker = 0

    def __len__(self) -> int:
        """Batches of a whole epoch on every rank."""
        return self._plan.num_batches(Point(0, 0))

    def __getstate__(self) -> dict[str, Any]:
        self._plan.rank.check()
        return self.__dict__.copy()

    def __iter__(self) -> _StreamPass:
        worker = get_worker_info()
        if worker is None:
            self._plan.rank.check()
            return self._begin(first=0, stride=1)
        if self._passes_as_worker:
            self._start = Point(*self._shared_start.tolist())
        self._passes_as_worker += 1
        return self._begin(first=worker.id, stride=worker.num_workers)

    def _begin(self, *, first: int, stride: int) -> _StreamPass:
        return _StreamPass(
            self._dataset, self._collate, self._plan, self._start, first=first, stride=stride
        )

    def set_epoch(self, epoch: int) -> None:
        """Has the next pass be one of this epoch, also in workers that are already running.

        From where a resume left it if that is in this epoch, else from its start.

        Raises:
            ValueError: A negative epoch.
        """
        if not isinstance(epoch, int) or epoch < 0:
            raise ValueError(f"epoch must be a whole number from 0 up, got {epoch!r}")
        if epoch != self._start.epoch:
            self._move(Point(epoch, 0))

    def _move(self, start: Point) -> None:
        self._start = start
        if get_worker_info() is None:
            self._shared_start.copy_(torch.tensor(start))

    def state_dict(self, batches_taken: int = 0) -> ResumeToken:
        """Where the pass stands.

        Args:
            batches_taken: Batches the training loop took since the pass began.

        Raises:
            ValueError: More than the pass has.
        """
        return self._plan.token(self._plan.after(self._start, batches_taken))

    def load_state_dict(self, token: Mapping[str, Any]) -> None:
        """Has the next pass begin where a token says; nothing is read or replayed.

        Raises:
            ValueError: Not a token, or one of other episodes or another order.
        """
        self._move(self._plan.point(token))


class _StreamPass(Iterator[Any]):
    """The batches of one process in one pass; its state is what `StatefulDataLoader` keeps."""

    def __init__(
        self,
        dataset: Episodes,
        collate: Callable[[list[Any]], Any],
        plan: EpisodePlan,
        start: Point,
        *,
        first: int,
        stride: int,
    ) -> None:
        self._dataset, self._collate, self._plan = dataset, collate, plan
        self._start, self._next, self._stride = start, first, stride

    def __next__(self) -> Any:
        if self._next >= self._plan.num_batches(self._start):
            raise StopIteration
        places = self._plan.places(self._start, self._next, stride=self._stride)
        self._next += self._stride
        return self._collate(self._dataset.__getitems__(places))

    def state_dict(self) -> dict[str, int]:
        """Where the pass began and which batch of it comes next."""
        epoch, consumed = self._start
        return {"epoch": epoch, "consumed": consumed, "next": self._next}

    def load_state_dict(self, state: Mapping[str, int]) -> None:
        """Goes on from there."""
        self._start, self._next = Point(state["epoch"], state["consumed"]), state["next"]
