"""Recorded runs of a policy, read strictly: where the robot was once it had handed off."""

from __future__ import annotations

import bisect
import dataclasses
import functools
import hashlib
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.schemas import check_table

__all__ = ["RecordedRuns"]

_POINT = ("position_x_m", "position_y_m", "position_z_m")
_NUMBERS = ("time_s", *_POINT, "yaw_deg")
_READ = ("episode_id", "policy", "step", "action", *_NUMBERS)
_ACTIONS = ("move_forward", "turn_left", "turn_right", "hand_off", "stop")
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
        table, rows = table.filter(mine), rows[mine.to_numpy()]
        return cls._of_rows(table, rows, file, policy)

    @classmethod
    def _of_rows(
        cls, table: pa.Table, rows: NDArray[np.int64], file: str, policy: str
    ) -> RecordedRuns:
        ids = pc.unique(table.column("episode_id")).sort()
        codes = pc.index_in(table.column("episode_id"), value_set=ids).to_numpy()
        order = np.lexsort((table.column("step").to_numpy(), codes))
        table, rows, codes = table.take(pa.array(order)), rows[order], codes[order]
        is_first = np.diff(codes, prepend=-1) > 0
        _check_rows(table, rows, is_first, file)
        numbers = np.stack([table.column(name).to_numpy() for name in _NUMBERS], axis=1)
        done = pc.equal(table.column("action"), "hand_off").to_numpy()
        starts = np.flatnonzero(is_first)
        # How many handoffs there were in the episode so far: from the first on, rows are kept.
        count = np.cumsum(done)
        kept = count > np.repeat((count - done)[starts], np.diff(starts, append=len(codes)))
        knots = numbers[kept].astype(np.float64)
        knots[:, 4] = np.radians(knots[:, 4])
        num_kept = np.bincount(codes[kept], minlength=len(ids))
        return cls(
            policy=policy,
            file=file,
            episode_ids=tuple(ids.to_pylist()),
            bounds=np.concatenate([[0], np.cumsum(num_kept)]).astype(np.int64),
            knots=knots,
            first_positions=numbers[starts, 1:4].astype(np.float64),
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


def _check_rows(
    table: pa.Table, rows: NDArray[np.int64], is_first: NDArray[np.bool_], file: str
) -> None:
    """Raises ValueError at the first row that is wrong; rows are by episode and step."""
    for name in _NUMBERS:
        values = table.column(name).to_numpy()
        _refuse(~np.isfinite(values), rows, file, f"{name} must be finite")
    known = pc.is_in(table.column("action"), value_set=pa.array(_ACTIONS)).to_numpy()
    _refuse(~known, rows, file, f"action must be one of {', '.join(_ACTIONS)}")
    steps: NDArray[Any] = table.column("step").to_numpy()
    expected = np.where(is_first, 0, np.roll(steps, 1) + 1)
    wrong = steps != expected
    if wrong.any():
        at = int(np.flatnonzero(wrong)[0])
        episode = table.column("episode_id")[at].as_py()
        raise ValueError(
            f"{file}, row {rows[at]}: episode {episode!r}: expected step {expected[at]}, got step "
            f"{steps[at]}; steps are 0, 1, ... without a gap"
        )
    times = table.column("time_s").to_numpy()
    before = np.where(is_first, 0.0, np.roll(times, 1))
    _refuse(times <= before, rows, file, "time_s must grow with every step, from more than 0")


def _refuse(wrong: NDArray[np.bool_], rows: NDArray[np.int64], file: str, what: str) -> None:
    if wrong.any():
        count = int(wrong.sum())
        others = f" (and {count - 1} more rows)" if count > 1 else ""
        raise ValueError(f"{file}, row {rows[wrong].min()}: {what}{others}")
