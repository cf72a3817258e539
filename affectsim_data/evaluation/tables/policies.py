"""Trajectories of one policy beside the episodes of a split."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.acquisition import acquisitions
from affectsim_data.evaluation.scored import Acquisitions
from affectsim_data.evaluation.tables.episodes import UNKNOWN, ScoredEpisodes
from affectsim_data.evaluation.tables.problems import Problems, quoted
from affectsim_data.evaluation.tables.trajectories import Trajectories

__all__ = ["acquisitions_of"]

_EXAMPLES = 3


def acquisitions_of(
    trajectories: Trajectories,
    episodes: ScoredEpisodes,
    *,
    policy: str | None,
    allow_missing: bool,
    problems: Problems,
) -> tuple[Acquisitions, list[str]]:
    """What the policy did in every episode, and notes; what does not fit is added to `problems`.

    Raises:
        ValueError: No such policy, or several and none is named.
    """
    policy = _policy(trajectories, policy)
    table = trajectories.table
    entries = np.flatnonzero(pc.equal(table.column("policy"), policy).to_numpy())
    column = table.column("episode_id")
    places = episodes.places(column)[entries]
    _tell_unknown(trajectories, episodes, entries[places == UNKNOWN], problems)
    notes = _missing(policy, episodes, places, allow_missing=allow_missing, problems=problems)
    found = acquisitions(
        table.take(pa.array(entries[places >= 0])),
        np.array(episodes.episode_ids.to_pylist(), np.str_),
        episodes.starts_m,
        policy=policy,
    )
    return found, notes


def _policy(trajectories: Trajectories, policy: str | None) -> str:
    there = ", ".join(map(quoted, trajectories.policies))
    if policy is None:
        if len(trajectories.policies) != 1:
            raise ValueError(f"the trajectories are of several policies: {there}; name one")
        return trajectories.policies[0]
    if policy not in trajectories.policies:
        raise ValueError(f"policy: got {quoted(policy)}; the trajectories are of {there}")
    return policy


def _tell_unknown(
    trajectories: Trajectories,
    episodes: ScoredEpisodes,
    entries: NDArray[np.int64],
    problems: Problems,
) -> None:
    """One problem per episode, at its first row; its steps would drown the others."""
    if not len(entries):
        return
    unknown = trajectories.table.column("episode_id").take(pa.array(entries)).to_pylist()
    _, first = np.unique(np.array(unknown, np.str_), return_index=True)
    reasons = episodes.why_not(pa.array(sorted(set(unknown)), pa.string()))
    names = dict(zip(entries.tolist(), unknown, strict=True))
    problems.add_entries(
        "trajectories of another place",
        entries[np.sort(first)],
        trajectories.places,
        lambda entry: f"{quoted(names[entry])} {reasons[names[entry]]}",
    )


def _missing(
    policy: str,
    episodes: ScoredEpisodes,
    places: NDArray[np.int64],
    *,
    allow_missing: bool,
    problems: Problems,
) -> list[str]:
    count = len(episodes.episode_ids)
    absent = np.setdiff1d(np.arange(count), places)
    if not len(absent):
        return []
    text = f"policy {quoted(policy)}: {len(absent):,} of {count:,} episodes have no trajectory"
    if allow_missing:
        return [f"{text}; they count as no handoff and no way"]
    ids = ", ".join(repr(episodes.episode_ids[int(one)].as_py()) for one in absent[:_EXAMPLES])
    more = ", ..." if len(absent) > _EXAMPLES else ""
    kind = "missing trajectories (allow_missing counts them as no handoff and no way)"
    problems.add(kind, f"{text}: {ids}{more}")
    return []
