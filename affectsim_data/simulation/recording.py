"""What became of an episode that a policy acted in, and files of many such records."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import IO, Any, Literal, TypeAlias

import pyarrow as pa
import pyarrow.parquet as pq

from affectsim_data.episodes import Episode
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation.actions import ACTION_RATE_HZ
from affectsim_data.simulation.running import Outcome

__all__ = ["Ending", "EpisodeRecord", "failures_path", "write_failures", "write_records"]

Ending: TypeAlias = Outcome | Literal["failed"]
"""How an episode ended; `failed` where the policy raised, stalled or returned nonsense."""

_SCHEMA = SCHEMAS["trajectories"]
_COLUMNS = tuple(name for name in _SCHEMA.names if name not in ("episode_id", "policy"))
"""Those that are not alike in all rows of an episode."""
_ROWS_IN_GROUP = 1 << 16


@dataclasses.dataclass(frozen=True, eq=False)
class EpisodeRecord:
    """A trajectory, and how it came to its end."""

    episode_id: str
    policy: str
    """Name of what moved the robot."""
    ending: Ending
    rows: pa.Table
    """Of the contract's table `trajectories`, at least one."""
    reason: str | None = None
    """Why the policy failed, if it did."""
    failed_at: int | None = None
    """Actions done when it did."""

    @classmethod
    def of_failure(
        cls, rows: list[dict[str, Any]], reason: str, episode: Episode, *, policy: str
    ) -> EpisodeRecord:
        """The record of an episode in which the policy failed.

        What it did before the handoff stays; then the robot stops. So nothing was acquired, and
        who reads the table needs no other to know it.

        Args:
            rows: Of the contract, until it failed.
            reason: Why.
            episode: Which one.
            policy: Its name.
        """
        before = [row for row in rows if row["phase"] != "collect"]
        table = pa.Table.from_pylist([*before, _stop(before, episode, policy)], schema=_SCHEMA)
        return cls(episode.episode_id, policy, "failed", table, reason, len(rows))

    def failure(self) -> dict[str, Any]:
        """What the file of failures says of it."""
        return {
            "episode_id": self.episode_id,
            "policy": self.policy,
            "step": self.failed_at,
            "reason": self.reason,
        }

    def to_json(self) -> dict[str, Any]:
        """What `from_json` reads; numbers come back to the last bit."""
        return {
            "episode_id": self.episode_id,
            "ending": self.ending,
            "reason": self.reason,
            "failed_at": self.failed_at,
            "rows": {name: self.rows.column(name).to_pylist() for name in _COLUMNS},
        }

    @classmethod
    def from_json(cls, document: Any, *, policy: str) -> EpisodeRecord:
        """The record in a document that `to_json` made.

        Raises:
            ValueError: It is none.
        """
        try:
            columns: Mapping[str, Any] = document["rows"]
            shared = {"episode_id": document["episode_id"], "policy": policy}
            alike = {name: [value] * len(columns["step"]) for name, value in shared.items()}
            rows = pa.Table.from_pydict({**alike, **columns}, schema=_SCHEMA)
            rest = {name: document[name] for name in ("ending", "reason", "failed_at")}
        except (KeyError, TypeError, pa.ArrowException) as error:
            raise ValueError(f"not the record of an episode: {error!r}") from error
        return cls(document["episode_id"], policy, rows=rows, **rest)


def _stop(rows: list[dict[str, Any]], episode: Episode, policy: str) -> dict[str, Any]:
    """A row in which the robot stops where it is."""
    x, y, z = episode.start_position
    last = {
        "position_x_m": x,
        "position_y_m": y,
        "position_z_m": z,
        "yaw_deg": math.degrees(episode.start_yaw),
        "phase": "search",
        "planner_calls": 0,
    }
    return {
        **(rows[-1] if rows else last),
        "episode_id": episode.episode_id,
        "policy": policy,
        "step": len(rows),
        "time_s": (len(rows) + 1) / ACTION_RATE_HZ,
        "action": "stop",
        "clipped": False,
    }


def failures_path(out: Path) -> Path:
    """Where the failures of a run stand beside its table."""
    return out.with_name(f"{out.stem}.failures.jsonl")


def write_records(
    out: Path, records: Iterable[EpisodeRecord], metadata: Mapping[bytes, bytes]
) -> None:
    """Writes the trajectories, whole or not at all; the same records give the same bytes.

    Args:
        out: The table.
        records: Its episodes, in order.
        metadata: Of its schema.
    """
    table = pa.concat_tables([_SCHEMA.empty_table(), *(one.rows for one in records)])
    table = table.replace_schema_metadata(dict(metadata))
    with _whole(out) as stream:
        # In one piece: where pages of the file end must not depend on who made which rows.
        pq.write_table(
            table.combine_chunks(), stream, compression="zstd", row_group_size=_ROWS_IN_GROUP
        )


def write_failures(out: Path, records: Iterable[EpisodeRecord]) -> Path | None:
    """Writes why episodes failed beside a table, a line of JSON each; no file if none did."""
    path = failures_path(out)
    failures = [one.failure() for one in records if one.ending == "failed"]
    if not failures:
        path.unlink(missing_ok=True)
        return None
    with _whole(path) as stream:
        for failure in failures:
            stream.write(json.dumps(failure).encode() + b"\n")
    return path


@contextlib.contextmanager
def _whole(path: Path) -> Iterator[IO[bytes]]:
    """A file that takes its place when it is whole and on disk."""
    staging = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        with staging.open("wb") as stream:
            yield stream
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(staging, path)
    finally:
        staging.unlink(missing_ok=True)
