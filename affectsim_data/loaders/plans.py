"""What every batch of a rank holds, from any point of any epoch, and the token of that point."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, TypedDict

from affectsim_data.loaders.distribution import Ends, Share, find_rank
from affectsim_data.loaders.order import EpisodeOrder, Episodes, Shuffle
from affectsim_data.loaders.places import Place

__all__ = ["EpisodePlan", "Point", "ResumeToken"]


class ResumeToken(TypedDict):
    """Where a run stands in its data: what an exact resume needs; plain JSON.

    It holds for any number of ranks and workers and for any batch size.
    """

    seed: int
    """Of the shuffle."""
    epoch: int
    """The epoch in progress, or the next one if that had just ended."""
    consumed: int
    """Samples of the epoch's global order consumed, over all ranks."""
    fingerprint: str
    """Of the episodes."""
    shuffle: Shuffle
    """How they are ordered."""
    window: int
    """Of the scene-aware order."""
    release: str
    """Where they came from; for the reader, the fingerprint decides."""


class Point(NamedTuple):
    """A place where a pass over the data can begin."""

    epoch: int
    """From 0 up."""
    consumed: int
    """Places of its global order already done with."""


class EpisodePlan:
    """The batches of one rank: a pure function of the point where a pass begins."""

    def __init__(
        self,
        dataset: Episodes,
        *,
        batch_size: int,
        shuffle: Shuffle,
        window: int,
        seed: int,
        rank: int | None,
        world_size: int | None,
        ends: Ends,
        look_ahead: int,
    ) -> None:
        """Checks the arguments; those of `EpisodeBatches`.

        Raises:
            ValueError: One of them is out of range, or nothing is left to load.
        """
        if look_ahead < 0:
            raise ValueError(f"look_ahead must be a number of batches from 0 up, got {look_ahead}")
        self.order = EpisodeOrder(dataset, shuffle=shuffle, window=window, seed=seed)
        self.rank = find_rank(rank, world_size)
        self.share = Share(
            self.order.num_episodes, batch_size, self.rank.rank, self.rank.world_size, ends
        )
        self._look_ahead = look_ahead

    def num_batches(self, point: Point) -> int:
        """Batches of a pass that begins there."""
        return self.share.num_batches(point.consumed)

    def places(self, point: Point, number: int, *, stride: int) -> list[Place]:
        """What batch `number` of a pass holds; its first place says what comes soon.

        Args:
            point: Where the pass begins.
            number: Of the batch in the pass.
            stride: The same process is asked for every `stride`-th batch.
        """
        positions = self.share.positions(point.consumed, number)
        end = self.order.num_episodes
        rows = self._rows(point, number)
        places = [
            Place(row, point.epoch, position % end, position >= end)
            for row, position in zip(rows, positions, strict=True)
        ]
        last = min(number + self._look_ahead * stride + 1, self.num_batches(point))
        ahead = [self._rows(point, later) for later in range(number + stride, last, stride)]
        places[0] = places[0]._replace(ahead=tuple(row for rows in ahead for row in rows))
        return places

    def _rows(self, point: Point, number: int) -> list[int]:
        positions = self.share.positions(point.consumed, number)
        rows: list[int] = self.order.rows(point.epoch).take(positions, mode="wrap").tolist()
        return rows

    def after(self, point: Point, batches_taken: int) -> Point:
        """The point reached once that many batches of a pass were taken on every rank.

        Raises:
            ValueError: The pass has fewer batches.
        """
        count = self.num_batches(point)
        if not 0 <= batches_taken <= count:
            raise ValueError(
                f"batches_taken must be in [0, {count}], the batches of this pass, "
                f"got {batches_taken}"
            )
        return self._settled(Point(point.epoch, point.consumed + batches_taken * self.share.step))

    def _settled(self, point: Point) -> Point:
        """The start of the next epoch if this one has no batch left."""
        left = point.consumed < self.order.num_episodes and self.num_batches(point)
        return point if left else Point(point.epoch + 1, 0)

    def token(self, point: Point) -> ResumeToken:
        """The same point for any number of ranks, and any batch size."""
        return ResumeToken(
            seed=self.order.seed,
            epoch=point.epoch,
            consumed=point.consumed,
            fingerprint=self.order.fingerprint,
            shuffle=self.order.shuffle,
            window=self.order.window,
            release=self.order.source,
        )

    def point(self, token: Mapping[str, Any]) -> Point:
        """Where a token says that the run stood.

        A seed is not compared where nothing is shuffled, nor a window where no scenes are grouped.

        Raises:
            ValueError: Not a token, or one of other episodes or another order.
        """
        own: Mapping[str, Any] = dict(self.token(Point(0, 0)))
        if missing := [name for name in own if name not in token]:
            raise ValueError(f"not a resume token, it lacks {', '.join(missing)}: {dict(token)}")
        if token["fingerprint"] != own["fingerprint"]:
            raise ValueError(
                f"the token is for the episodes {token['fingerprint']!r} of {token['release']}, "
                f"these are {own['fingerprint']!r} of {own['release']}; resume with the same "
                "release, split and selection"
            )
        matters = {"shuffle": True, "seed": own["shuffle"], "window": own["shuffle"] == "scenes"}
        for name in (name for name, it_does in matters.items() if it_does):
            if token[name] != own[name] or type(token[name]) is not type(own[name]):
                raise ValueError(
                    f"the token is for {name}={token[name]!r}, this loader has "
                    f"{name}={own[name]!r}; the order would not be the same"
                )
        point = Point(token["epoch"], token["consumed"])
        self._check(point)
        return self._settled(point)

    def _check(self, point: Point) -> None:
        for name, value in point._asdict().items():
            if type(value) is not int or value < 0:
                raise ValueError(f"token: {name} must be a whole number from 0 up, got {value!r}")
        if point.consumed > self.order.num_episodes:
            raise ValueError(
                f"token: consumed must be in [0, {self.order.num_episodes}], the episodes there "
                f"are, got {point.consumed}"
            )
