"""What a finished table says of the run that made it, so that the same run is not made again."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from affectsim_data.schemas import check_table
from affectsim_data.simulation.journal import RunHeader
from affectsim_data.simulation.recording import Ending, EpisodeRecord, failures_path

__all__ = ["FinishedRun", "finished_run", "run_metadata"]

_KEY = b"affectsim_trajectories"
_WAY_OUT = "choose another --out, or start anew with --overwrite"


@dataclasses.dataclass(frozen=True)
class FinishedRun:
    """A run whose table is there already."""

    endings: dict[Ending, int]
    """How many episodes ended how."""
    failures: tuple[EpisodeRecord, ...]
    """Those in which the policy failed, as the file beside the table has them."""
    failures_path: Path | None
    """That file, if there is one."""


def run_metadata(header: RunHeader, records: Iterable[EpisodeRecord]) -> dict[bytes, bytes]:
    """The metadata of a table's schema: what was run on what, and how many episodes ended how.

    Where the release is, is left out: the same content elsewhere gives the same bytes.
    """
    document = header.to_json()
    del document["release"]
    document["endings"] = Counter(record.ending for record in records)
    return {_KEY: json.dumps(document, sort_keys=True).encode()}


def finished_run(out: Path, header: RunHeader, episode_ids: Sequence[str]) -> FinishedRun:
    """The run that made a table, which must be this one.

    Args:
        out: The table, which is there.
        header: Of this run.
        episode_ids: Of this run, in order.

    Raises:
        FileExistsError: It does not say what run it is of.
        ValueError: It is of another run, or of other episodes.
    """
    document = _told(out)
    if document is None:
        raise FileExistsError(
            f"{out}: is there already, and does not say what run it is of; --overwrite replaces it"
        )
    header.check(document, file=out)
    table = pq.read_table(out)
    check_table(table.schema, "trajectories", file=str(out))
    there = pc.unique(table.column("episode_id")).to_pylist()
    if there != list(episode_ids):
        raise ValueError(
            f"{out}: is of other episodes: {_difference(there, episode_ids)}; choose them as they "
            f"were, {_WAY_OUT}"
        )
    path = failures_path(out)
    failures = _failures(path, table, header.policy) if path.exists() else ()
    return FinishedRun(document["endings"], failures, path if failures else None)


def _told(out: Path) -> dict[str, Any] | None:
    """What a table says of its run; `None` for a file that says nothing."""
    try:
        metadata = pq.read_schema(out).metadata or {}
        document = json.loads(metadata[_KEY])
    except (KeyError, ValueError, OSError):  # an ArrowInvalid is a ValueError
        return None
    is_whole = isinstance(document, dict) and isinstance(document.get("endings"), dict)
    return document if is_whole else None


def _difference(there: Sequence[str], wanted: Sequence[str]) -> str:
    known, asked = set(there), set(wanted)
    lacking = [one for one in wanted if one not in known]
    beyond = [one for one in there if one not in asked]
    told = [f"{len(lacking):,} are not in it, such as {lacking[0]!r}"] if lacking else []
    told += [f"{len(beyond):,} more are, such as {beyond[0]!r}"] if beyond else []
    return " and ".join(told) or "their order is another"


def _failures(path: Path, table: pa.Table, policy: str) -> tuple[EpisodeRecord, ...]:
    """The records that a file of failures tells of.

    Raises:
        ValueError: It cannot be read.
    """
    found = []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), start=1):
        try:
            told = json.loads(line)
            episode_id, reason, step = (told[name] for name in ("episode_id", "reason", "step"))
        except (ValueError, KeyError, TypeError) as error:
            raise ValueError(f"{path}, line {number}: not a failure: {error!r}") from error
        rows = table.filter(pc.equal(table.column("episode_id"), episode_id))
        found.append(EpisodeRecord(episode_id, policy, "failed", rows, reason, step))
    return tuple(found)
