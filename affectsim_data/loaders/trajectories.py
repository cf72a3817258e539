"""Which recorded trajectories `condition="a_obs"` shows: a table's, or those of the release."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.observations import RecordedRuns
from affectsim_data.releases import Release
from affectsim_data.releases.joined_splits import split_title, splits_there
from affectsim_data.releases.recorded import recorded_runs
from affectsim_data.releases.splits import SplitBy

__all__ = ["check_recorded", "open_trajectories"]

_LISTED = 5


def open_trajectories(
    release: Release,
    split: str,
    split_by: SplitBy,
    *,
    trajectories: str | Path | None = None,
    policy: str | None = None,
) -> RecordedRuns:
    """The recorded runs of one policy.

    Args:
        release: Of the episodes; its own trajectories serve where no table is given.
        split: The split meant.
        split_by: What it is split by.
        trajectories: A Parquet table.
        policy: Whose runs, where there are those of several.

    Raises:
        FileNotFoundError: There is no such table.
        ValueError: There are no runs of the policy, several policies and none named, or a row of
            the table is wrong.
    """
    if trajectories is not None:
        return RecordedRuns.from_parquet(trajectories, policy=policy)
    # The episodes of a split by scene are stored in any split.
    stored = splits_there(release) if split_by == "scene" else (split,)
    table, file = recorded_runs(release, stored, policy)
    return RecordedRuns.from_table(table, file=file)


def check_recorded(
    runs: RecordedRuns, release: Release, split: str, split_by: SplitBy, rows: NDArray[Any]
) -> None:
    """Raises ValueError if some episodes of a split have no trajectory.

    Args:
        runs: What there is.
        release: Of the episodes.
        split: The split meant.
        split_by: What it is split by.
        rows: Places of the episodes in its table.
    """
    ids = release.split_table(split, split_by).index.column("episode_id")
    wanted = ids.take(pa.array(rows)).to_pylist()
    missing = runs.missing(wanted)
    if missing:
        shown = ", ".join(map(repr, missing[:_LISTED])) + ", ..." * (len(missing) > _LISTED)
        raise ValueError(
            f"{runs.file}: {len(missing):,} of {len(wanted):,} episodes of "
            f"{split_title(split, split_by)} have no trajectory of {runs.policy!r}: {shown}; run "
            "`affectsim acquire` over all of them, or choose those that have one: "
            "episodes=[...]"
        )
