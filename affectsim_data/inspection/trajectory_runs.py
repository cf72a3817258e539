"""Recorded runs: what a policy did in one episode, read back from a table of trajectories."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.episodes import Episode, Robot
from affectsim_data.evaluation.tables import read_trajectories
from affectsim_data.observations.active import clip_start_s
from affectsim_data.observations.still import head_camera_pose
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import STEP_M, Action, Budget
from affectsim_data.simulation.running import Outcome, Phase

__all__ = ["RecordedRun", "RunEnd", "RunTable"]

_SLACK_M = 0.05
RunEnd = Literal[Outcome, "cut_short"]
"""How a run ended; `cut_short`: neither its clip nor its budget is complete, a policy failed."""


@dataclasses.dataclass(frozen=True, eq=False)
class RecordedRun:
    """What a policy did in an episode. State 0 is the start, state k what k actions led to."""

    episode: Episode
    policy: str
    times_s: FloatArray
    """Since the start of the episode, `(num_actions + 1,)`."""
    positions: FloatArray
    """Robot on the floor, metres, `(num_actions + 1, 3)`."""
    yaws: FloatArray
    """Radians, 0 looks along -Z, `(num_actions + 1,)`."""
    actions: tuple[Action, ...]
    phases: tuple[Phase, ...]
    """Of each action."""
    clipped: NDArray[np.bool_]
    """Whether each action was a move cut short, `(num_actions,)`."""
    planner_calls: NDArray[np.int64]
    """So far, after each action, `(num_actions,)`."""

    @classmethod
    def from_table(cls, episode: Episode, rows: pa.Table) -> RecordedRun:
        """Reads the rows of one episode and policy, in the order of their steps.

        Args:
            episode: Which one.
            rows: Of the contract's table, `SCHEMAS["trajectories"]`; at least one.

        Raises:
            ValueError: The first action leads farther from the start than an action can.
        """
        ends = np.stack([rows.column(f"position_{axis}_m").to_numpy() for axis in "xyz"], axis=1)
        apart = math.dist(ends[0, [0, 2]], episode.start_position[::2])
        if apart > STEP_M + _SLACK_M:
            raise ValueError(
                f"episode {episode.episode_id!r}: the run begins {apart:.2f} m from where the "
                "robot starts; it was recorded in another release"
            )
        yaws = np.radians(rows.column("yaw_deg").to_numpy())
        return cls(
            episode=episode,
            policy=rows.column("policy")[0].as_py(),
            times_s=np.concatenate([[0.0], rows.column("time_s").to_numpy()]),
            positions=np.concatenate([[episode.start_position], ends]),
            yaws=np.concatenate([[episode.start_yaw], yaws]),
            actions=tuple(rows.column("action").to_pylist()),
            phases=tuple(rows.column("phase").to_pylist()),
            clipped=rows.column("clipped").to_numpy().astype(bool),
            planner_calls=rows.column("planner_calls").to_numpy().astype(np.int64),
        )

    @property
    def num_actions(self) -> int:
        """Actions done."""
        return len(self.actions)

    @property
    def handoff(self) -> int | None:
        """The state that the first `hand_off` led to, `None` if there is none."""
        return self.actions.index("hand_off") + 1 if "hand_off" in self.actions else None

    @property
    def clip_s(self) -> tuple[float, float] | None:
        """When the clip begins and ends, as `EpisodeRun` has it; `None` without a handoff."""
        if self.handoff is None:
            return None
        cycle = self.episode.duration_s
        start = clip_start_s(float(self.times_s[self.handoff]), cycle)
        return start, start + 2.0 * cycle

    @property
    def clip_states(self) -> NDArray[np.int64]:
        """States within the clip; none without a handoff."""
        start, end = self.clip_s or (math.inf, math.inf)
        return np.flatnonzero((self.times_s >= start - 1e-9) & (self.times_s <= end + 1e-9))

    @property
    def end(self) -> RunEnd:
        """How it ended, by the paper's budget."""
        if self.clip_s is not None:
            return "collected" if self.times_s[-1] >= self.clip_s[1] - 1e-9 else "cut_short"
        budget = Budget()
        if self.planner_calls[-1] >= budget.max_planner_calls:
            return "planner_calls_exhausted"
        if self.actions[-1] == "stop":
            return "stopped"
        return "actions_exhausted" if self.num_actions >= budget.max_actions else "cut_short"

    @property
    def lengths_m(self) -> FloatArray:
        """Way over the floor of each action, `(num_actions,)`."""
        steps = np.diff(self.positions[:, [0, 2]], axis=0)
        return np.hypot(steps[:, 0], steps[:, 1])

    def T_world_camera(self, robot: Robot) -> FloatArray:
        """Pose of the head camera in every state, `(num_actions + 1, 4, 4)`."""
        return head_camera_pose(self.positions, self.yaws, robot)


class RunTable:
    """The runs of one policy, by episode."""

    def __init__(self, paths: Sequence[Path], *, policy: str | None = None) -> None:
        """Reads and checks tables of trajectories.

        Args:
            paths: Parquet, CSV or JSONL.
            policy: Whose; may be left out if there is one alone.

        Raises:
            ValueError: The rows do not hold together, or it is not clear whose are meant.
        """
        trajectories = read_trajectories(paths)
        self._files = ", ".join(map(str, paths))
        self.policy = _policy(trajectories.policies, policy, self._files)
        table = trajectories.table
        table = table.filter(pc.equal(table.column("policy"), self.policy))
        self._table = table.sort_by([("episode_id", "ascending"), ("step", "ascending")])
        ids = self._table.column("episode_id").to_numpy()
        first = np.flatnonzero(np.append(True, ids[1:] != ids[:-1]))
        ends = np.append(first[1:], len(ids))
        names = ids[first].tolist()
        self._places = dict(
            zip(names, zip(first.tolist(), ends.tolist(), strict=True), strict=True)
        )

    @property
    def episode_ids(self) -> tuple[str, ...]:
        """Episodes that were run, in the order of their names."""
        return tuple(self._places)

    def run(self, episode: Episode) -> RecordedRun:
        """What the policy did in an episode.

        Raises:
            KeyError: It was not run.
        """
        place = self._places.get(episode.episode_id)
        if place is None:
            some = ", ".join(self.episode_ids[:3])
            raise KeyError(
                f"{self._files}: {self.policy!r} has no run of episode {episode.episode_id!r}; "
                f"it has {len(self._places):,}, such as {some}"
            )
        return RecordedRun.from_table(episode, self._table.slice(place[0], place[1] - place[0]))


def _policy(there: Sequence[str], wanted: str | None, files: str) -> str:
    names = ", ".join(map(repr, there))
    if wanted is None and len(there) > 1:
        raise ValueError(f"{files}: holds runs of {names}; say whose with --policy")
    if wanted is not None and wanted not in there:
        raise ValueError(f"{files}: holds runs of {names}, none of {wanted!r}")
    return wanted or there[0]
