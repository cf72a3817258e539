"""Whether the ways of recorded trajectories are those of their actions, on the navmesh."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.recorded import Recorded
from affectsim_data.episodes import STEP_M, TURN
from affectsim_data.navmesh.locating import nearest_points
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release

__all__ = ["check_ways"]

MOVE_M = 1e-6
TURN_DEG = 1e-6
FULL_MOVE_M = 1e-4
"""What a move may lack of its length and not count as cut short: habitat-sim's rule, rounded."""
FLOOR_M = 0.01
"""The robot may be off the navmesh by: rounding, no more."""
_ROWS_ON_FLOOR = 1000
"""Of each scene and policy whose distance to the navmesh is measured."""
_FLOOR_SEED = 20261122


def check_ways(recorded: Recorded, release: Release) -> list[Measure]:
    """Where trajectories begin, how far each action leads, and whether all is on the navmesh."""
    return [
        _start(recorded),
        _moves(recorded),
        _turns(recorded),
        _clipped(recorded),
        _floor(recorded, release),
    ]


def _start(recorded: Recorded) -> Measure:
    """How much further from the start of its episode each begins than its first action leads."""
    rows = recorded.rows
    first = recorded.position[rows.starts]
    allowed = np.where(rows.does("move_forward")[rows.starts], STEP_M, 0.0)
    away = np.hypot(*(first - recorded.start)[:, [0, 2]].T)
    notes = [
        f"{recorded.policy!r}, step 0: {x:.2f} {y:.2f} {z:.2f}; the episode starts "
        f"{distance:.2f} m away"
        for (x, y, z), distance in zip(first.tolist(), away.tolist(), strict=True)
    ]
    beyond = np.maximum(away - allowed, 0.0)
    return Measure.of("trajectory_start", rows.episode_ids, beyond, high=MOVE_M, notes=notes)


def _ways(recorded: Recorded) -> FloatArray:
    """Length of each action's way on the plan, metres; 0 of the first of an episode."""
    position = recorded.position
    before = recorded.rows.previous(position, position[recorded.rows.starts])
    return np.asarray(np.hypot(*(position - before)[:, [0, 2]].T), np.float64)


def _moves(recorded: Recorded) -> Measure:
    ways, actions = _ways(recorded), recorded.rows.column("action")
    allowed = np.where(recorded.rows.does("move_forward"), STEP_M, 0.0)

    def describe(row: int) -> str:
        return f"{actions[row]} leads {ways[row]:.6g} m on, at most {allowed[row]:g} m"

    beyond = np.maximum(ways - allowed, 0.0)
    return recorded.worst("trajectory_moves", beyond, MOVE_M, describe)


def _turns(recorded: Recorded) -> Measure:
    rows = recorded.rows
    yaw = rows.column("yaw_deg")
    actions, turned = rows.column("action"), yaw - rows.previous(yaw, recorded.start_yaw_deg)
    angle = np.degrees(TURN)
    expected = angle * (rows.does("turn_left").astype(float) - rows.does("turn_right"))
    off = np.abs((turned - expected + 180.0) % 360.0 - 180.0)

    def describe(row: int) -> str:
        since = "the start of the episode" if rows.is_first[row] else "the step before"
        return f"{actions[row]} to {yaw[row]:.6g} deg, {off[row]:.6g} deg off {since}"

    return recorded.worst("trajectory_turns", off, TURN_DEG, describe)


def _clipped(recorded: Recorded) -> Measure:
    """Rows said to be cut short that are no move or a whole one, or the other way round."""
    rows = recorded.rows
    clipped, ways = rows.column("clipped").astype(bool), _ways(recorded)
    ways[rows.starts] = np.hypot(*(recorded.position[rows.starts] - recorded.start)[:, [0, 2]].T)
    moves, actions = rows.does("move_forward"), rows.column("action")
    whole, short = ways > STEP_M - MOVE_M, ways < STEP_M - FULL_MOVE_M
    wrong = np.asarray(np.where(clipped, ~moves | whole, moves & short), bool)

    def describe(row: int) -> str:
        said = "is" if clipped[row] else "is not"
        return f"{actions[row]} by {ways[row]:.6g} m {said} said to be cut short"

    return recorded.counted("trajectory_clipped", wrong, describe)


def _floor(recorded: Recorded, release: Release) -> Measure:
    """Distance to the navmesh, metres, of a sample of the rows of each scene."""
    rows = recorded.rows
    scene_ids, codes = np.unique(
        recorded.episodes.text("scene_id").astype(str), return_inverse=True
    )
    codes = np.repeat(codes, rows.lengths)
    rng = np.random.default_rng(_FLOOR_SEED)
    off = np.full(len(rows), -np.inf)
    for code, scene_id in enumerate(scene_ids):
        chosen = rng.permutation(np.flatnonzero(codes == code))[:_ROWS_ON_FLOOR]
        try:
            navmesh = release.navmesh(str(scene_id))
        except (KeyError, ValueError, OSError):
            continue  # `assets_readable` tells of it
        nearest, _ = nearest_points(navmesh.islands, recorded.position[chosen])
        off[chosen] = np.linalg.norm(nearest - recorded.position[chosen], axis=1)
    worst = np.maximum.reduceat(off, rows.starts)

    def describe(row: int) -> str:
        x, y, z = recorded.position[row]
        return f"{x:.2f} {y:.2f} {z:.2f} is {off[row]:.2f} m off"

    notes = recorded.notes(off > FLOOR_M, describe)
    looked_at = np.flatnonzero(worst >= 0.0)
    return Measure.of(
        "trajectory_floor",
        [rows.episode_ids[place] for place in looked_at],
        worst[looked_at],
        high=FLOOR_M,
        notes=[notes[place] for place in looked_at],
    )
