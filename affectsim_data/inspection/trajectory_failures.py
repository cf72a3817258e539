"""Why runs failed: causes, found by casting rays along them, counted by what made them hard."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Sequence
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from affectsim_data.episodes import World
from affectsim_data.inspection.statistics import KINDS
from affectsim_data.inspection.trajectory_runs import RecordedRun, RunTable
from affectsim_data.inspection.trajectory_sights import SEEN_SHARE, Sights, run_sights
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release

__all__ = [
    "BEHIND",
    "CAUSES",
    "CAUSE_MEANINGS",
    "FAR_M",
    "LOST_SHARE",
    "Cause",
    "Verdict",
    "cause_lines",
    "judge_run",
    "judge_runs",
]

Cause = Literal[
    "actions_exhausted",
    "planner_calls_exhausted",
    "stopped",
    "cut_short",
    "out_of_view",
    "hidden",
    "lost",
    "too_far",
    "from_behind",
]
CAUSES: tuple[Cause, ...] = get_args(Cause)
"""A run has the first that holds: four without a whole clip, five of what the clip shows."""
FAR_M = 4.0
"""Mean distance of a clip from which on it is too far: a body then fills a third of the image."""
BEHIND = math.radians(120.0)
"""Mean angle off the target's front from which on a clip is from behind."""
LOST_SHARE = 0.25
"""Part of a clip without the target, after it began with it, from which on it was lost."""
_CLIP_STATES, _SECONDS = 12, 12
"""Rays are cast at so many instants of a clip, and seconds of a search, at a time."""
CAUSE_MEANINGS: dict[Cause, str] = {
    "actions_exhausted": "never handed off: no actions left",
    "planner_calls_exhausted": "never handed off: no planner calls left",
    "stopped": "never handed off: gave up",
    "cut_short": "ends before its clip and its budget: the policy failed",
    "out_of_view": f"the clip does not hold the target: mean share below {SEEN_SHARE:.0%}",
    "hidden": "the target is in the image, and something before it",
    "lost": f"the clip begins with the target and lacks it for {LOST_SHARE:.0%} or more",
    "too_far": f"the target is {FAR_M:g} m away or more, on average",
    "from_behind": f"{math.degrees(BEHIND):.0f} degrees off its front or more, on average",
}


@dataclasses.dataclass(frozen=True)
class Verdict:
    """What became of a run, and why it is no good view of the target if it is none."""

    episode_id: str
    kind: str
    """One of `KINDS`."""
    cause: Cause | None
    """`None`: a clip that shows the target."""
    path_length_m: float
    num_actions: int
    planner_calls: int
    moves: int
    """Attempts to move forward."""
    clipped: int
    """Those cut short."""
    first_seen_s: float
    """When the target was first in view, to the second; `nan` if never."""
    visible: float
    """Share of the target's body in view, mean of the clip; `nan` without one, like the rest."""
    in_image: float
    """The same, hidden or not."""
    distance_m: float
    """To the target, mean of the clip."""
    azimuth_deg: float
    """Off the target's front, 0 to 180, mean of the clip."""

    @property
    def badness(self) -> float:
        """How bad it is among those of the same cause; more is worse."""
        if self.cause == "too_far":
            return self.distance_m
        if self.cause == "from_behind":
            return self.azimuth_deg
        return self.path_length_m if math.isnan(self.visible) else 1.0 - self.visible


def judge_run(run: RecordedRun, world: World) -> Verdict:
    """The verdict on one run, by casting rays at up to 12 states of the clip."""
    clip = run_sights(run, world, _clip_states(run))
    return Verdict(
        episode_id=run.episode.episode_id,
        kind=run.episode.challenge or run.episode.family,
        cause=_cause(run, clip),
        path_length_m=float(run.lengths_m.sum()),
        num_actions=run.num_actions,
        planner_calls=int(run.planner_calls[-1]),
        moves=run.actions.count("move_forward"),
        clipped=int(run.clipped.sum()),
        first_seen_s=_first_seen_s(run, world),
        visible=_mean(clip.visible),
        in_image=_mean(clip.in_image),
        distance_m=_mean(clip.distance_m),
        azimuth_deg=math.degrees(_mean(np.abs(clip.azimuth))),
    )


def _clip_states(run: RecordedRun) -> NDArray[np.int64]:
    """States evenly over the clip, its first and last among them; none if it is not whole."""
    states = run.clip_states
    if run.end != "collected":
        return states[:0]
    chosen = np.linspace(0, len(states) - 1, min(len(states), _CLIP_STATES)).round()
    return states[chosen.astype(np.int64)]


def _first_seen_s(run: RecordedRun, world: World) -> float:
    """When the target was first in view; looked for in every fourth state."""
    for first in range(0, run.num_actions + 1, _SECONDS * 4):
        last = min(first + _SECONDS * 4, run.num_actions + 1)
        sights = run_sights(run, world, np.arange(first, last, 4))
        if sights.is_seen.any():
            return float(run.times_s[sights.states[sights.is_seen.argmax()]])
    return math.nan


def _mean(values: FloatArray) -> float:
    return float(values.mean()) if len(values) else math.nan


def _cause(run: RecordedRun, clip: Sights) -> Cause | None:
    if run.end != "collected":
        return run.end
    visible, gone = clip.visible.mean(), 1.0 - clip.is_seen.mean()
    if clip.is_seen[0] and gone >= LOST_SHARE:
        return "lost"
    if visible < SEEN_SHARE:
        return "hidden" if clip.in_image.mean() >= SEEN_SHARE else "out_of_view"
    if clip.distance_m.mean() >= FAR_M:
        return "too_far"
    return "from_behind" if np.abs(clip.azimuth).mean() >= BEHIND else None


def judge_runs(release: Release, runs: RunTable) -> list[Verdict]:
    """Verdicts on all runs of a table, scene by scene, in the order of the episodes' names.

    Raises:
        KeyError: The release has no such episode.
    """
    episodes = [release.find_episode(one) for one in runs.episode_ids]
    episodes.sort(key=lambda one: (one.scene_id, one.episode_id))
    verdicts = [
        judge_run(runs.run(one), release.world(one))
        for one in tqdm(episodes, desc="runs", unit="run", leave=False)
    ]
    return sorted(verdicts, key=lambda one: one.episode_id)


def cause_lines(verdicts: Sequence[Verdict]) -> list[str]:
    """A table for a terminal: causes by kind of episode, and how many runs there are of each."""
    kinds = [kind for kind in KINDS if any(one.kind == kind for one in verdicts)]
    rows = [["cause", *(kind.replace("_", " ") for kind in kinds), "all"]]
    for cause in (*CAUSES, None):
        members = [one for one in verdicts if one.cause == cause]
        if members or cause is None:
            name = "the clip shows the target" if cause is None else cause.replace("_", " ")
            rows.append([name, *_counts(members, kinds)])
    rows.append(["runs", *_counts(verdicts, kinds)])
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    return [
        "  ".join([row[0].ljust(widths[0]), *map(str.rjust, row[1:], widths[1:])]) for row in rows
    ]


def _counts(verdicts: Iterable[Verdict], kinds: Sequence[str]) -> list[str]:
    found = [one.kind for one in verdicts]
    return [str(found.count(kind)) for kind in kinds] + [str(len(found))]
