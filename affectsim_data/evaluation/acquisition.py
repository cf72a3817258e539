"""What a policy did in each episode, from its trajectory: way, handoff, budget, clipped moves."""

from __future__ import annotations

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import ArrayLike, NDArray

from affectsim_data.evaluation.scored import Acquisitions
from affectsim_data.poses import FloatArray

__all__ = ["MAX_ACTIONS", "MAX_PLANNER_CALLS", "acquisitions"]

MAX_ACTIONS = 480
"""Primitive actions an episode may take; the paper, Execution settings."""
MAX_PLANNER_CALLS = 80
"""Calls of the global planner it may take; the same."""


def acquisitions(
    trajectories: pa.Table,
    episode_ids: NDArray[np.str_],
    starts_m: ArrayLike,
    *,
    policy: str,
) -> Acquisitions:
    """What `policy` did in every episode, by its rows of the trajectories table.

    - The way is measured over the floor, in X and Z, from the start through the position after
      every action. Turns cost nothing, and a clipped move counts as far as it went.
    - The handoff is the first action `hand_off`. The way before it is what was gone until then.
    - A new clip was acquired if rows of phase `collect` follow the handoff.
    - The budget was exhausted if there was no handoff, and 480 actions or 80 planner calls.
    - A move is an attempt whether or not it was clipped; only `move_forward` is one.

    Args:
        trajectories: Rows of the contract, of one policy. Episodes without a row stood still,
            handed nothing off, and exhausted nothing.
        episode_ids: Episodes of the result, `(num_episodes,)`.
        starts_m: Where the robot starts, `(num_episodes, 3)`.
        policy: Name of the policy.

    Raises:
        ValueError: A row is of another policy, or of an episode not in `episode_ids`.
    """
    places = _places(trajectories, episode_ids, policy)
    steps = _numbers(trajectories, "step")
    order = np.lexsort((steps, places))
    places, count = places[order], len(episode_ids)
    rows = np.arange(len(places))
    handoffs = rows[_holds(trajectories, "action", "hand_off")[order]]
    handoff = np.full(count, len(places))
    # Written from the last to the first, so that the first of an episode stays.
    handoff[places[handoffs][::-1]] = handoffs[::-1]
    handed_off = handoff < len(places)
    moves = _holds(trajectories, "action", "move_forward")[order]
    clipped = moves & _booleans(trajectories.column("clipped"))[order]
    collecting = _holds(trajectories, "phase", "collect")[order] & (rows > handoff[places])
    lengths = _step_lengths(trajectories, order, places, np.asarray(starts_m, np.float64))
    calls = np.zeros(count, np.int64)
    np.maximum.at(calls, places, _numbers(trajectories, "planner_calls")[order].astype(np.int64))
    num_steps = _sums(places, np.ones(len(places)), count).astype(np.int64)
    return Acquisitions(
        policy=policy,
        path_length_m=_sums(places, lengths, count),
        path_before_handoff_m=_sums(places, lengths * (rows <= handoff[places]), count),
        num_steps=num_steps,
        planner_calls=calls,
        num_translations=_sums(places, moves, count).astype(np.int64),
        num_clipped=_sums(places, clipped, count).astype(np.int64),
        handed_off=handed_off,
        acquired=_sums(places, collecting, count) > 0,
        budget_exhausted=~handed_off & ((num_steps >= MAX_ACTIONS) | (calls >= MAX_PLANNER_CALLS)),
    )


def _places(table: pa.Table, episode_ids: NDArray[np.str_], policy: str) -> NDArray[np.int64]:
    """Place of every row's episode in `episode_ids`."""
    others = pc.unique(table.column("policy")).to_pylist()
    if set(others) - {policy}:
        listed = ", ".join(sorted(map(repr, others)))
        raise ValueError(f"trajectories must be of policy {policy!r} alone, got {listed}")
    known = pa.array(episode_ids.tolist(), pa.string())
    found = pc.index_in(table.column("episode_id").cast(pa.string()), value_set=known)
    if found.null_count:
        strange = table.column("episode_id").filter(pc.is_null(found))[0].as_py()
        raise ValueError(f"trajectories: episode {strange!r} is not among those evaluated")
    places: NDArray[np.int64] = found.to_numpy().astype(np.int64)
    return places


def _step_lengths(
    table: pa.Table, order: NDArray[np.int64], places: NDArray[np.int64], starts_m: FloatArray
) -> FloatArray:
    """Way over the floor to the position of each row from the one before, or the start."""
    x, z = (_numbers(table, f"position_{axis}_m")[order] for axis in "xz")
    first = np.diff(places, prepend=-1) > 0
    before_x = np.where(first, starts_m[places, 0], np.roll(x, 1))
    before_z = np.where(first, starts_m[places, 2], np.roll(z, 1))
    return np.hypot(x - before_x, z - before_z)


def _numbers(table: pa.Table, column: str) -> FloatArray:
    numbers: FloatArray = table.column(column).to_numpy().astype(np.float64)
    return numbers


def _holds(table: pa.Table, column: str, value: str) -> NDArray[np.bool_]:
    return _booleans(pc.equal(table.column(column).cast(pa.string()), value))


def _booleans(column: pa.ChunkedArray) -> NDArray[np.bool_]:
    values: NDArray[np.bool_] = column.to_numpy().astype(bool)
    return values


def _sums(places: NDArray[np.int64], values: NDArray[np.generic], count: int) -> FloatArray:
    """Sum of a row's values by episode, in the order of the rows."""
    # Without a row, bincount would forget that the weights are float.
    return np.bincount(places, values.astype(np.float64), minlength=count).astype(np.float64)
