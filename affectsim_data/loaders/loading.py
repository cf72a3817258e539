"""`data_loader`: a DataLoader that knows its epoch, its rank and what its user has had."""

from __future__ import annotations

import multiprocessing
import weakref
from collections.abc import Iterator, Mapping
from typing import Any

from torch.utils.data import DataLoader

from affectsim_data.loaders.batches import DEFAULT_WINDOW, EpisodeBatches, EpisodePass
from affectsim_data.loaders.distribution import Ends
from affectsim_data.loaders.order import Episodes, Shuffle
from affectsim_data.loaders.plans import ResumeToken
from affectsim_data.loaders.workers import WorkerStart

__all__ = ["EpisodeLoader", "data_loader"]

_REFUSED = {
    "sampler": "EpisodeBatches decides which samples; choose them with dataset.subset(...)",
    "batch_sampler": "EpisodeBatches makes the batches; for one of your own, use the stock "
    "torch.utils.data.DataLoader",
    "drop_last": "say what becomes of an uneven end with ends='full' (or 'drop')",
}


class EpisodeLoader(DataLoader[Any]):
    """A DataLoader that goes from epoch to epoch by itself and resumes at the very next sample.

    It counts the batches it hands out, not those its workers fetched ahead. A pass whose last batch
    was had is followed by the next epoch; one that was broken off begins again where it began. Made
    by `data_loader`.
    """

    def __init__(self, dataset: Episodes, batches: CountedBatches, **options: Any) -> None:
        """Loads what the batches say.

        Args:
            dataset: The episodes.
            batches: Of these episodes, for this loader only.
            options: Passed on to `torch.utils.data.DataLoader`.
        """
        self.batches = batches
        """Which samples, in which order."""
        # Weak, as an iterator that was given up must be free to end its workers.
        self._newest: weakref.ref[_Counted] | None = None
        super().__init__(dataset, batch_sampler=batches, **options)  # type: ignore[arg-type]  # not a Dataset by name

    @property
    def epoch(self) -> int:
        """The epoch of the next batch: once the last of one was had, that is the one after."""
        return self.batches.epoch

    @property
    def batches_left(self) -> int:
        """Batches a pass would have now: after a resume fewer than `len`, which is an epoch's."""
        return self.batches.batches_left

    def __iter__(self) -> Iterator[Any]:  # type: ignore[override]  # torch promises its own class
        counted = _Counted(self, super().__iter__(), self.batches.latest_pass)
        self._newest = weakref.ref(counted)
        return counted

    def is_newest(self, one: _Counted) -> bool:
        """Whether no other iterator was made since."""
        return self._newest is not None and self._newest() is one

    def set_epoch(self, epoch: int) -> None:
        """Has the next pass be one of this epoch; needed only to leave the order of epochs.

        Without effect if it is to be this epoch anyway, so that a resume is not lost.

        Raises:
            ValueError: A negative epoch.
        """
        self.batches.set_epoch(epoch)

    def state_dict(self) -> ResumeToken:
        """Where the training loop stands: after the last batch it was given."""
        return self.batches.state_dict()

    def load_state_dict(self, token: Mapping[str, Any]) -> None:
        """Has the next pass begin where a token says; nothing is read or replayed.

        The token may come from other numbers of ranks and workers, and another batch size.

        Raises:
            ValueError: Not a token, or one of other episodes or another order.
        """
        self.batches.load_state_dict(token)


class CountedBatches(EpisodeBatches):
    """Stands where the user does, not where the workers are that fetch ahead."""

    _taken = 0

    def __iter__(self) -> EpisodePass:
        self._taken = 0
        return super().__iter__()

    def ran_out(self, one: EpisodePass) -> None:
        """Nothing: that a worker was told of the last batch does not end the pass."""

    def took(self, one: EpisodePass | None) -> None:
        """Told of every batch that the user is given of a pass."""
        if one is None or one is not self.latest_pass:
            return
        self._taken += 1
        # With the last batch, as some trainers count and never ask for one more.
        if self._taken == one.num_batches:
            self.finish_pass()

    def state_dict(self, batches_taken: int | None = None) -> ResumeToken:
        """Where the user stands, unless told that it is elsewhere in the pass."""
        if batches_taken is None:
            batches_taken = self._taken if self.latest_pass is not None else 0
        return super().state_dict(batches_taken)


class _Counted(Iterator[Any]):
    """The batches of one pass, counted as the user takes them."""

    def __init__(
        self, loader: EpisodeLoader, batches: Iterator[Any], source: EpisodePass | None
    ) -> None:
        self._loader, self._batches, self._source = loader, batches, source

    def __next__(self) -> Any:
        if self._loader.persistent_workers and not self._loader.is_newest(self):
            raise RuntimeError(
                "a newer iterator of this loader has taken its persistent workers over; use one "
                "iterator at a time, or persistent_workers=False"
            )
        batch = next(self._batches)
        self._loader.batches.took(self._source)
        return batch


def data_loader(
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
    resume: Mapping[str, Any] | None = None,
    **options: Any,
) -> EpisodeLoader:
    """A DataLoader with an order that is the same everywhere, shared among ranks, resumable.

    Its workers start clean, so that no GL context is ever inherited.

    Args:
        dataset: `AffectSimDataset`, a subset or a concatenation.
        batch_size: Samples of one rank in one step.
        shuffle: `False` for the table's order, `True`, or `"scenes"`: shuffled, then grouped by
            scene inside windows, so that scenes are opened rarely.
        window: Places of the shuffled order in a window.
        seed: Of the shuffle, from 0 up.
        rank: Of this process; `None` for that of `torch.distributed`, else 0.
        world_size: How many ranks there are; goes with `rank`.
        ends: `pad` fills an uneven end with marked repeats, `drop` leaves out the up to
            `world_size - 1` samples over, `full` all that make no whole batch for every rank.
        look_ahead: How many batches before its turn a worker is told of one, to fetch its files.
        resume: A token of `state_dict()` to begin at.
        options: Passed on to `torch.utils.data.DataLoader`.

    Raises:
        ValueError: Arguments out of range or against one another, nothing left to load, or a token
            of other episodes or another order.
    """
    for name, remedy in _REFUSED.items():
        if options.pop(name, None):
            raise ValueError(f"data_loader takes no {name}: {remedy}")
    if not options.get("in_order", True):
        raise ValueError("data_loader takes no in_order=False: a resume needs batches in order")
    num_workers = options.get("num_workers", 0)
    if num_workers and options.get("multiprocessing_context") is None:
        options["multiprocessing_context"] = multiprocessing.get_context("forkserver")
    if num_workers:
        options["worker_init_fn"] = WorkerStart(options.get("worker_init_fn"))
    batches = CountedBatches(
        dataset,
        batch_size=batch_size,
        shuffle=shuffle,
        window=window,
        seed=seed,
        rank=rank,
        world_size=world_size,
        ends=ends,
        look_ahead=look_ahead,
        num_workers=num_workers,
    )
    if resume is not None:
        batches.load_state_dict(resume)
    return EpisodeLoader(dataset, batches, **options)
