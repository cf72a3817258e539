"""`EpisodeBatches`: the sampler that orders, shares and resumes, for any map-style loader."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from torch.utils.data import Sampler

from affectsim_data.loaders.distribution import Ends
from affectsim_data.loaders.order import Episodes, Shuffle
from affectsim_data.loaders.places import Place
from affectsim_data.loaders.plans import EpisodePlan, Point, ResumeToken

__all__ = ["DEFAULT_WINDOW", "EpisodeBatches", "EpisodePass", "ResumeToken"]

DEFAULT_WINDOW = 1024


class EpisodeBatches(Sampler[list[Place]]):
    """The batches of one rank, as a `batch_sampler`.

    A pass that gave its last batch is followed by the next epoch, whether or not anyone calls
    `set_epoch`; one that was broken off begins again where it began. A stock DataLoader with
    workers takes the last batch a few batches before its user does, so only `data_loader`, which
    counts what the user took, is exact about a pass broken off near its end.

    Examples:
        >>> batches = EpisodeBatches(dataset, batch_size=8, shuffle=True)  # doctest: +SKIP
        >>> loader = DataLoader(dataset, batch_sampler=batches)  # doctest: +SKIP
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
        num_workers: int = 0,
    ) -> None:
        """Plans the batches; the first pass is epoch 0.

        Args:
            dataset: `AffectSimDataset`, a subset or a concatenation.
            batch_size: Samples of one rank in one step.
            shuffle: `False` for the table's order, `True`, or `"scenes"`: shuffled, then grouped by
                scene inside windows, so that scenes are opened rarely.
            window: Places of the shuffled order in a window.
            seed: Of the shuffle, from 0 up.
            rank: Of this process; `None` for that of `torch.distributed`, else 0.
            world_size: How many ranks there are; goes with `rank`.
            ends: What becomes of an end that does not come out even: `pad`, `drop` or `full`; see
                `Share`.
            look_ahead: How many batches before its turn a worker is told of one.
            num_workers: Of the loader; only says which batches go to the same worker.

        Raises:
            ValueError: An argument out of range, or nothing is left to load.
        """
        self._stride = max(1, num_workers)
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
        self._latest: EpisodePass | None = None

    def __len__(self) -> int:
        """Batches of a whole epoch on every rank; after a resume, `batches_left` are fewer.

        Constant, as trainers that read it once and keep it, and schedules built on it, expect.
        """
        return self._plan.num_batches(Point(0, 0))

    @property
    def batches_left(self) -> int:
        """Batches of the next pass on every rank."""
        return self._plan.num_batches(self._start)

    @property
    def epoch(self) -> int:
        """The epoch of the next pass."""
        return self._start.epoch

    @property
    def drop_last(self) -> bool:
        """Not to be asked for: who does is about to share these batches among the ranks again.

        Accelerate's `prepare` would, and every rank would silently lose most of its data.

        Raises:
            ValueError: Always.
        """
        raise ValueError(
            "EpisodeBatches already holds the batches of one rank and cannot be sharded again; do "
            "not pass this loader to Accelerator.prepare, only the model and the optimizer"
        )

    @property
    def latest_pass(self) -> EpisodePass | None:
        """The pass begun last; `None` once `set_epoch` or `load_state_dict` said otherwise."""
        return self._latest

    def __iter__(self) -> EpisodePass:
        self._plan.rank.check()
        self._latest = EpisodePass(self, self._plan, self._start, stride=self._stride)
        return self._latest

    def set_epoch(self, epoch: int) -> None:
        """Has the next pass be one of this epoch: from where it was to begin, if it was to be this.

        Raises:
            ValueError: A negative epoch.
        """
        if not isinstance(epoch, int) or epoch < 0:
            raise ValueError(f"epoch must be a whole number from 0 up, got {epoch!r}")
        if epoch != self._start.epoch:
            self._start, self._latest = Point(epoch, 0), None
        elif self._latest is not None and self._latest.epoch != epoch:
            self._latest = None

    def finish_pass(self) -> None:
        """Has the next pass be one of the epoch after the pass begun last."""
        if self._latest is not None:
            self._start, self._latest = Point(self._latest.epoch + 1, 0), None

    def ran_out(self, one: EpisodePass) -> None:
        """Told by a pass that it has given its last batch."""
        if one is self._latest:
            self._start = Point(one.epoch + 1, 0)

    def state_dict(self, batches_taken: int | None = None) -> ResumeToken:
        """Where the pass begun last stands; before any, where the next one begins.

        Args:
            batches_taken: Batches the training loop took in this pass, this one included; `None`
                for those this sampler gave, which is more where workers fetch ahead.

        Raises:
            ValueError: More than the pass has.
        """
        if self._latest is None:
            return self._plan.token(self._plan.after(self._start, batches_taken or 0))
        taken = self._latest.given if batches_taken is None else batches_taken
        return self._plan.token(self._plan.after(self._latest.start, taken))

    def load_state_dict(self, token: Mapping[str, Any]) -> None:
        """Has the next pass begin where a token says; nothing is read or replayed.

        Raises:
            ValueError: Not a token, or one of other episodes or another order.
        """
        self._start, self._latest = self._plan.point(token), None


class EpisodePass(Iterator[list[Place]]):
    """One run over the batches of an epoch, or of what is left of it.

    Its own `state_dict` and `load_state_dict` are those that torchdata's `StatefulDataLoader` looks
    for; use those of the sampler.
    """

    def __init__(
        self, batches: EpisodeBatches, plan: EpisodePlan, start: Point, *, stride: int
    ) -> None:
        self._batches, self._plan, self._stride = batches, plan, stride
        self.start = start
        """Where it began."""
        self.given = 0
        """Batches given so far."""

    @property
    def epoch(self) -> int:
        """The epoch it runs over."""
        return self.start.epoch

    @property
    def num_batches(self) -> int:
        """How many it has."""
        return self._plan.num_batches(self.start)

    def __next__(self) -> list[Place]:
        if self.given >= self.num_batches:
            raise StopIteration
        self.given += 1
        # With the last batch, as some trainers count and never ask for one more.
        if self.given == self.num_batches:
            self._batches.ran_out(self)
        return self._plan.places(self.start, self.given - 1, stride=self._stride)

    def state_dict(self) -> dict[str, int]:
        """Epoch and samples consumed, at the end of the epoch all of them."""
        consumed = self.start.consumed + self.given * self._plan.share.step
        left = self.given < self.num_batches
        consumed = consumed if left else self._plan.share.num_episodes
        return {"epoch": self.epoch, "consumed": consumed}

    def load_state_dict(self, state: Mapping[str, int]) -> None:
        """Goes on from there; at the end of an epoch there is nothing left, as there was then."""
        self.start, self.given = Point(state["epoch"], state["consumed"]), 0
