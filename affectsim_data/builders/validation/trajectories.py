"""Whether the trajectories that a release carries can be what a robot did in its episodes."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.recorded import Recorded, read_recorded
from affectsim_data.builders.validation.tables import Tables
from affectsim_data.builders.validation.trajectory_ways import check_ways
from affectsim_data.episodes import ACTION_RATE_HZ
from affectsim_data.observations.active import clip_start_s
from affectsim_data.observations.recorded_rows import NUMBERS
from affectsim_data.releases import Release
from affectsim_data.schemas import PHASES, ROBOT_ACTIONS

__all__ = ["check_trajectories"]

TIME_S = 1e-6


def check_trajectories(release: Release, tables: Tables) -> list[Measure]:
    """Every check of the trajectories that a release carries; nothing if it carries none."""
    everything, measures = read_recorded(release, tables)
    for recorded in everything:
        values, steps = _values(recorded), _steps(recorded)
        measures += [values, steps]
        # What is no number cannot be measured, nor what does not follow.
        wrong = np.union1d(values.failed, steps.failed)
        if len(wrong) < len(recorded):
            measures += _measured(recorded.without(wrong), release)
    return measures


def _measured(recorded: Recorded, release: Release) -> list[Measure]:
    return [
        _times(recorded),
        _phases(recorded),
        _clip(recorded),
        *check_ways(recorded, release),
    ]


def _values(recorded: Recorded) -> Measure:
    """Rows with a word that is not known, or a number that can be none."""
    rows = recorded.rows
    calls = rows.column("planner_calls").astype(np.int64)
    reasons = {
        "action is {action!r}": rows.unknown("action", ROBOT_ACTIONS),
        "phase is {phase!r}": rows.unknown("phase", PHASES),
        "planner_calls becomes fewer: {planner_calls}": calls < rows.previous(calls, 0),
        **{f"{name} is {{{name}}}": rows.not_finite(name) for name in NUMBERS},
    }

    def describe(row: int) -> str:
        told = next(text for text, wrong in reasons.items() if wrong[row])
        return told.format_map(recorded.rows.table.slice(row, 1).to_pylist()[0])

    wrong = np.logical_or.reduce(list(reasons.values()))
    return recorded.counted("trajectory_values", wrong, describe)


def _steps(recorded: Recorded) -> Measure:
    def describe(row: int) -> str:
        return f"expected step {recorded.rows.expected_steps[row]}"

    return recorded.counted("trajectory_steps", recorded.rows.wrong_step, describe)


def _times(recorded: Recorded) -> Measure:
    times = recorded.rows.column("time_s")
    expected = (recorded.rows.column("step") + 1) / ACTION_RATE_HZ

    def describe(row: int) -> str:
        return f"time_s is {times[row]:.9g}, the action ends at {expected[row]:g} s"

    return recorded.worst("trajectory_times", np.abs(times - expected), TIME_S, describe)


def _phases(recorded: Recorded) -> Measure:
    """Rows that collect before the handoff, or do not after it, or come after the robot stopped."""
    rows = recorded.rows
    collecting = rows.after_first(rows.does("hand_off"))
    unlike = rows.says("phase", "collect") != collecting
    stopped = rows.after_first(rows.does("stop") & ~collecting)
    is_late = stopped & rows.previous(stopped, False)

    def describe(row: int) -> str:
        if not unlike[row]:
            return "the robot had stopped"
        when = "after" if collecting[row] else "before"
        return f"phase is {rows.table.column('phase')[row].as_py()} {when} the handoff"

    return recorded.counted("trajectory_phases", unlike | is_late, describe)


def _clip(recorded: Recorded) -> Measure:
    """What the rows of those that handed off lack of a whole clip, seconds."""
    rows, notes, times = recorded.rows, [], []
    handoffs = np.flatnonzero(rows.does("hand_off"))
    owners, firsts = np.unique(rows.owners(handoffs), return_index=True)
    handed_off_s = rows.column("time_s")[handoffs[firsts]]
    last_s = rows.column("time_s")[rows.starts + rows.lengths - 1]
    duration_s = recorded.duration_s
    for owner, time_s in zip(owners.tolist(), handed_off_s.tolist(), strict=True):
        end_s = clip_start_s(time_s, float(duration_s[owner])) + 2.0 * float(duration_s[owner])
        times.append(end_s - last_s[owner])
        notes.append(
            f"{recorded.policy!r}, step {rows.lengths[owner] - 1}: the last one ends at "
            f"{last_s[owner]:g} s, the clip at {end_s:.6g} s"
        )
    ids = [rows.episode_ids[owner] for owner in owners]
    return Measure.of("trajectory_clip", ids, np.maximum(times, 0.0), high=TIME_S, notes=notes)
