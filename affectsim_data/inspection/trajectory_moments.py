"""Which states of a run are worth a look."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.inspection.trajectory_sights import Sights

__all__ = ["Moment", "chosen_moments", "key_moments"]


@dataclasses.dataclass(frozen=True)
class Moment:
    """A state of a run, as pictures number it."""

    number: int
    """From 1, in the order of time."""
    state: int
    """Actions done before."""
    title: str


def key_moments(run: RecordedRun, sights: Sights, *, count: int) -> tuple[Moment, ...]:
    """Start, first sight of the target, handoff, the clip, the end; filled up evenly with others.

    Args:
        run: Which one.
        sights: Of all its states.
        count: How many at most, from 2; a run of fewer states has fewer moments.

    Raises:
        ValueError: Too few.
    """
    if count < 2:
        raise ValueError(f"a run is shown by its start and its end at least, got count={count}")
    titles = {0: "start", run.num_actions: "end"}
    for state, title in _worthy(run, sights):
        if len(titles) < count:
            titles.setdefault(state, title)
    while len(titles) < min(count, run.num_actions + 1):
        states = sorted(titles)
        gaps = np.diff(states)
        widest = int(gaps.argmax())
        titles[states[widest] + int(gaps[widest]) // 2] = ""
    return _numbered(run, titles)


def chosen_moments(run: RecordedRun, states: Sequence[int]) -> tuple[Moment, ...]:
    """Moments of states one names.

    Raises:
        ValueError: The run has no such state.
    """
    wrong = [state for state in states if not 0 <= state <= run.num_actions]
    if wrong:
        raise ValueError(
            f"{run.episode.episode_id}: steps must be 0 to {run.num_actions}, got {wrong[0]}"
        )
    return _numbered(run, dict.fromkeys(states, ""))


def _worthy(run: RecordedRun, sights: Sights) -> list[tuple[int, str]]:
    """States and what they are, the ones that matter most first."""
    clip = run.clip_states.tolist()
    found: list[tuple[int, str]] = []
    if run.handoff is not None:
        found.append((run.handoff, "handoff"))
    if clip:
        found += [(clip[len(clip) // 2], "middle of the clip"), (clip[0], "clip begins")]
    else:
        found.append((int(sights.distance_m.argmin()), "nearest to the target"))
    seen = np.flatnonzero(sights.is_seen)
    if len(seen):
        found.append((int(seen[0]), "target in view"))
    if "approach" in run.phases:
        found.append((run.phases.index("approach") + 1, "approach begins"))
    return found


def _numbered(run: RecordedRun, titles: dict[int, str]) -> tuple[Moment, ...]:
    clip = run.clip_states
    if len(clip) and run.end == "collected":
        titles = {s: "clip ends" if t == "end" else t for s, t in titles.items()}
    return tuple(
        Moment(number, state, titles[state]) for number, state in enumerate(sorted(titles), start=1)
    )
