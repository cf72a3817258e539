"""Recorded runs of a policy, read strictly: where the robot was once it had handed off."""

from __future__ import annotations

import bisect
import dataclasses
import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from affectsim_data.observations.recorded_rows import NUMBERS, RecordedRows
from affectsim_data.poses import FloatArray
from affectsim_data.schemas import ROBOT_ACTIONS, check_table

__all__ = ["RecordedRuns"]

_READ = ("episode_id", "policy", "step", "action", *NUMBERS)
_LISTED = 10


@dataclasses.dataclass(frozen=True, eq=False)
class RecordedRuns:
    """What one policy did in many episodes, as far as clips are seen from there."""

    policy: str
    """What moved the robot."""
    file: str
    """Where it was read from, for messages."""
    episode_ids: tuple[str, ...]
    """Sorted."""
    bounds: NDArray[np.int64]
    """Rows of episode `i` in `knots` are `bounds[i]:bounds[i + 1]`; none without a handoff."""
    knots: FloatArray
    """From the handoff on, at the end of every action: seconds since the start of the episode,
    position on the floor in metres, yaw in radians, `(n, 5)`."""
    first_positions: FloatArray
    """After the first action, metres, `(num_episodes, 3)`."""

    @classmethod
    def from_parquet(cls, path: str | Path, *, policy: str | None = None) -> RecordedRuns:
        """Reads a trajectory table.

        Args:
            path: A Parquet file of the contract's table `trajectories`.
            policy: Whose runs; may be left out where the table holds those of one.

        Raises:
            FileNotFoundError: There is no such file.
            ValueError: It is no such table, it has no run of the policy, or a row is wrong.
        """
        place = Path(path).expanduser()
        if not place.is_file():
            raise FileNotFoundError(
                f"{place}: no such trajectory table; `affectsim acquire` makes one"
            )
        try:
            check_table(pq.read_schema(place), "trajectories", file=str(place))
            table = pq.read_table(place, columns=list(_READ))
        except (pa.ArrowException, OSError) as error:
            raise ValueError(f"{place}: cannot be read as Parquet: {error}") from None
        return cls.from_table(table, file=str(place), policy=policy)

    @classmethod
    def from_table(cls, table: pa.Table, *, file: str, policy: str | None = None) -> RecordedRuns:
        """Takes rows of the contract's table `trajectories`; they may be in any order.

        Args:
            table: The rows.
            file: What messages call it.
            policy: Whose runs; may be left out where there are those of one.

        Raises:
            ValueError: There is no run of the policy, or a row is wrong.
        """
        rows = np.arange(1, table.num_rows + 1)
        table = table.select(_READ)
        for name in _READ:
            _refuse(table.column(name).is_null().to_numpy(), rows, file, f"{name} is null")
        policy = _one_policy(table, file, policy)
        mine = pc.equal(table.column("policy"), policy)
        return cls._of_rows(
            RecordedRows.of(table.filter(mine), rows[mine.to_numpy()]), file, policy
        )

    @classmethod
    def _of_rows(cls, rows: RecordedRows, file: str, policy: str) -> RecordedRuns:
        _check_rows(rows, file)
        numbers = np.stack([rows.column(name) for name in NUMBERS], axis=1).astype(np.float64)
        kept = rows.after_first(rows.does("hand_off"))
        knots = numbers[kept]
        knots[:, 4] = np.radians(knots[:, 4])
        num_kept = np.add.reduceat(kept, rows.starts, dtype=np.int64)
        return cls(
            policy=policy,
            file=file,
            episode_ids=rows.episode_ids,
            bounds=np.concatenate([[0], np.cumsum(num_kept)]).astype(np.int64),
            knots=knots,
            first_positions=numbers[rows.starts, 1:4],
        )

    def __len__(self) -> int:
        """Episodes there are."""
        return len(self.episode_ids)

    @functools.cached_property
    def sha256(self) -> str:
        """Names the content: all that decides how clips are seen, hexadecimal."""
        digest = hashlib.sha256("\n".join((self.policy, *self.episode_ids)).encode())
        for array in (self.bounds, self.knots, self.first_positions):
            digest.update(array.astype(array.dtype.newbyteorder("<")).tobytes())
        return digest.hexdigest()

    def missing(self, episode_ids: Iterable[str]) -> list[str]:
        """Those of some episodes that are not here."""
        there = set(self.episode_ids)
        return [one for one in episode_ids if one not in there]

    def place(self, episode_id: str) -> int:
        """Of an episode in `episode_ids`.

        Raises:
            ValueError: It is not there.
        """
        found = bisect.bisect_left(self.episode_ids, episode_id)
        if found == len(self) or self.episode_ids[found] != episode_id:
            raise ValueError(
                f"{self.file}: no trajectory of {self.policy!r} in episode {episode_id!r}; run "
                "`affectsim acquire` over the split it is of"
            )
        return found

    def after_handoff(self, episode_id: str) -> FloatArray:
        """The knots of an episode, `(k, 5)`; `k` is 0 if it was not handed off.

        Raises:
            ValueError: The episode is not there.
        """
        place = self.place(episode_id)
        return self.knots[self.bounds[place] : self.bounds[place + 1]]


def _one_policy(table: pa.Table, file: str, policy: str | None) -> str:
    there = sorted(pc.unique(table.column("policy")).to_pylist())
    if not there:
        raise ValueError(f"{file}: holds no trajectory")
    listed = ", ".join(map(repr, there[:_LISTED])) + (", ..." if len(there) > _LISTED else "")
    if policy is None and len(there) > 1:
        raise ValueError(
            f"{file}: holds trajectories of {len(there)} policies, {listed}; say which is meant "
            "with policy=..."
        )
    if policy is not None and policy not in there:
        raise ValueError(f"{file}: no trajectory of policy {policy!r}; there are those of {listed}")
    return str(there[0]) if policy is None else policy


def _check_rows(rows: RecordedRows, file: str) -> None:
    """Raises ValueError at the first row that is wrong."""
    for name in NUMBERS:
        _refuse(rows.not_finite(name), rows.numbers, file, f"{name} must be finite")
    words = ", ".join(ROBOT_ACTIONS)
    _refuse(
        rows.unknown("action", ROBOT_ACTIONS), rows.numbers, file, f"action must be one of {words}"
    )
    if rows.wrong_step.any():
        at = int(np.flatnonzero(rows.wrong_step)[0])
        episode = rows.table.column("episode_id")[at].as_py()
        raise ValueError(
            f"{file}, row {rows.numbers[at]}: episode {episode!r}: expected step "
            f"{rows.expected_steps[at]}, got step {rows.column('step')[at]}; steps are 0, 1, ... "
            "without a gap"
        )
    times = rows.column("time_s")
    grows = "time_s must grow with every step, from more than 0"
    _refuse(times <= rows.previous(times, 0.0), rows.numbers, file, grows)


def _refuse(wrong: NDArray[np.bool_], rows: NDArray[np.int64], file: str, what: str) -> None:
    if wrong.any():
        count = int(wrong.sum())
        others = f" (and {count - 1} more rows)" if count > 1 else ""
        raise ValueError(f"{file}, row {rows[wrong].min()}: {what}{others}")
