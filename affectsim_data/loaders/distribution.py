"""Which process this is among how many, and which places of the global order are its own."""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Mapping
from typing import Literal, NamedTuple, get_args

from torch import distributed

__all__ = ["Ends", "Rank", "Share", "find_rank"]

Ends = Literal["pad", "drop", "full"]
"""What becomes of an end that does not come out even; see `Share`."""


class Rank(NamedTuple):
    """One process among those that share an epoch."""

    rank: int
    """From 0 up."""
    world_size: int
    """How many there are."""
    given: bool
    """Whether the caller said so, rather than `torch.distributed`."""

    def check(self) -> None:
        """Makes sure that `torch.distributed` does not say otherwise by now.

        Raises:
            ValueError: It was initialised after the rank was looked up.
        """
        if self.given or not _initialized():
            return
        now = (distributed.get_rank(), distributed.get_world_size())
        if now != self[:2]:
            raise ValueError(
                f"this loader was made for rank {self.rank} of {self.world_size}, but "
                f"torch.distributed says rank {now[0]} of {now[1]}; make it after "
                "init_process_group, or give it rank= and world_size="
            )


def find_rank(
    rank: int | None = None,
    world_size: int | None = None,
    *,
    environment: Mapping[str, str] = os.environ,
) -> Rank:
    """The rank as given, else that of `torch.distributed`, else the only one.

    Args:
        rank: From 0 up; `None` to look it up.
        world_size: How many ranks there are; goes with `rank`.
        environment: Where a launcher leaves `WORLD_SIZE`.

    Raises:
        ValueError: A rank outside the world, only one of the two, or a process started as one of
            several (`WORLD_SIZE`) which has not initialised `torch.distributed`: all of them
            would get the same data.
    """
    if rank is not None or world_size is not None:
        if rank is None or world_size is None or not 0 <= rank < world_size:
            raise ValueError(
                f"rank must be in [0, world_size), and both be given or neither, "
                f"got rank={rank!r}, world_size={world_size!r}"
            )
        return Rank(rank, world_size, given=True)
    if _initialized():
        return Rank(distributed.get_rank(), distributed.get_world_size(), given=False)
    launched = environment.get("WORLD_SIZE", "1")
    if launched not in ("", "1"):
        raise ValueError(
            f"WORLD_SIZE is {launched}, but torch.distributed is not initialised, so all "
            "processes would get the same data; call init_process_group before, or give "
            "rank= and world_size= (rank=0, world_size=1 for everything in every process)"
        )
    return Rank(0, 1, given=False)


def _initialized() -> bool:
    return distributed.is_available() and distributed.is_initialized()


@dataclasses.dataclass(frozen=True)
class Share:
    """The part of every epoch that is one rank's.

    A step takes the next `batch_size * world_size` places of the global order, each rank a
    contiguous `batch_size` of them. Where fewer are left, the last step shares them evenly:

    - `pad` fills them up to a multiple of `world_size` with repeats from the start of the order,
      never more than `world_size - 1`;
    - `drop` leaves out the up to `world_size - 1` that are over;
    - `full` leaves out all that do not make a whole batch for every rank.

    So all ranks always get equally many batches, of equal size.
    """

    num_episodes: int
    """Length of the global order."""
    batch_size: int
    """Samples of one rank in one step."""
    rank: int
    """From 0 up."""
    world_size: int
    """How many ranks there are."""
    ends: Ends
    """See above."""

    def __post_init__(self) -> None:
        if not isinstance(self.batch_size, int) or self.batch_size < 1:
            raise ValueError(
                f"batch_size must be a number of samples from 1 up, got {self.batch_size!r}"
            )
        if self.ends not in get_args(Ends):
            raise ValueError(f"ends must be one of {', '.join(get_args(Ends))}, got {self.ends!r}")
        if not self.num_batches(0):
            raise ValueError(
                f"ends={self.ends!r} leaves nothing of {self.num_episodes} episodes for "
                f"{self.world_size} ranks with batches of {self.batch_size}; take ends='pad', "
                "smaller batches or fewer ranks"
            )

    @property
    def step(self) -> int:
        """Places of the global order that one step takes, over all ranks."""
        return self.batch_size * self.world_size

    def num_batches(self, consumed: int) -> int:
        """Batches of every rank from a place of the global order to the end of the epoch."""
        steps, left = divmod(self.num_episodes - consumed, self.step)
        least = {"pad": 1, "drop": self.world_size, "full": self.step}[self.ends]
        return steps + (left >= least)

    def positions(self, consumed: int, number: int) -> range:
        """Places of a batch; those from `num_episodes` up are padding and start over at 0.

        Args:
            consumed: Place of the global order where the pass begins.
            number: Of the batch in the pass, below `num_batches(consumed)`.
        """
        first = consumed + number * self.step
        places = min(self.step, self.num_episodes - first)
        each = -(-places // self.world_size) if self.ends == "pad" else places // self.world_size
        return range(first + self.rank * each, first + (self.rank + 1) * each)
