"""Trajectory tables: what a policy did, action by action, read and checked by themselves."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.tables.files import Columns
from affectsim_data.evaluation.tables.predictions import combined_codes
from affectsim_data.evaluation.tables.problems import Places, Problems, quoted
from affectsim_data.evaluation.tables.reading import entries_where, read_table_files
from affectsim_data.schemas import PHASES, ROBOT_ACTIONS, SCHEMAS

__all__ = ["Trajectories", "read_trajectories"]

_COLUMNS = Columns("trajectories", required=tuple(SCHEMAS["trajectories"].names))
_NUMBERS = ("time_s", "position_x_m", "position_y_m", "position_z_m", "yaw_deg")


@dataclasses.dataclass(frozen=True)
class Trajectories:
    """Rows of trajectory tables that hold together, in the order of the files."""

    table: pa.Table
    """Columns of the contract, `SCHEMAS["trajectories"]`."""
    places: Places
    """File and row of each."""
    notes: tuple[str, ...] = ()
    """What was passed over."""

    @property
    def policies(self) -> tuple[str, ...]:
        """What moved the robot, in the order of first appearance."""
        return tuple(pc.unique(self.table.column("policy")).to_pylist())


def read_trajectories(paths: Sequence[Path]) -> Trajectories:
    """Reads trajectory tables, Parquet, CSV or JSONL by suffix, and checks every row.

    The rows may come in any order. The steps of an episode and policy are 0, 1, ... without a
    gap; time grows with every step, calls of the planner never become fewer.

    Raises:
        TableProblems: Something is wrong; lists all of it, over all files, with file and row.
        ValueError: No file is given.
    """
    read = read_table_files(paths, _COLUMNS)
    table, places, problems = read.table, read.places, read.problems
    _check_words(table, places, problems)
    _check_finite(table, places, problems)
    # Steps are told apart only where they are known; a row without one was told already.
    names = ("episode_id", "policy", "step", "time_s", "planner_calls")
    whole = np.logical_and.reduce([table.column(name).is_valid().to_numpy() for name in names])
    order, is_first = _in_order(table, np.flatnonzero(whole))
    _check_steps(table, order, is_first, places, problems)
    problems.raise_if_any()
    return Trajectories(table.cast(_COLUMNS.schema), places, read.notes)


def _check_words(table: pa.Table, places: Places, problems: Problems) -> None:
    for name, words in (("action", ROBOT_ACTIONS), ("phase", PHASES)):
        column = table.column(name)
        known = pc.or_kleene(pc.is_null(column), pc.is_in(column, value_set=pa.array(words)))
        unknown = pc.and_(pc.invert(known), pc.not_equal(column, ""))
        problems.add_entries(
            f"{name} is unknown",
            entries_where(unknown),
            places,
            functools.partial(_unknown_word, column, words),
        )


def _unknown_word(column: pa.ChunkedArray, words: Sequence[str], entry: int) -> str:
    return f"expected {', '.join(words)}, got {quoted(column[entry].as_py())}"


def _check_finite(table: pa.Table, places: Places, problems: Problems) -> None:
    for name in (*_NUMBERS, "step", "planner_calls"):
        values: NDArray[Any] = table.column(name).fill_null(0).to_numpy()
        lowest = 0.0 if name in ("step", "planner_calls", "time_s") else -np.inf
        wrong = np.flatnonzero(~np.isfinite(values) | (values < lowest))
        describe = functools.partial(_out_of_range, values, lowest)
        problems.add_entries(f"{name} is out of range", wrong, places, describe)


def _out_of_range(values: NDArray[Any], lowest: float, entry: int) -> str:
    kind = "a finite number" if lowest < 0 else "a finite number from 0"
    return f"expected {kind}, got {values[entry]:g}"


def _in_order(
    table: pa.Table, entries: NDArray[np.int64]
) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Entries by policy, episode and step; and whether each is the first of its episode."""
    chosen = table.select(["episode_id", "policy", "step"]).take(pa.array(entries))
    runs = combined_codes(chosen, ["policy", "episode_id"])
    steps: NDArray[Any] = chosen.column("step").to_numpy()
    order = np.lexsort((entries, steps, runs))
    is_first = np.diff(runs[order], prepend=-1) != 0
    return entries[order], is_first


def _check_steps(
    table: pa.Table,
    order: NDArray[np.int64],
    is_first: NDArray[np.bool_],
    places: Places,
    problems: Problems,
) -> None:
    """Steps 0, 1, ...; time and calls of the planner with them. `order` and `is_first` belong."""
    steps, times, calls = (
        table.column(name).to_numpy()[order].astype(np.float64)
        for name in ("step", "time_s", "planner_calls")
    )
    ahead = np.where(is_first, -1.0, np.roll(steps, 1))

    def tell(kind: str, wrong: NDArray[np.bool_], expected: str, values: NDArray[Any]) -> None:
        chosen = np.flatnonzero(wrong)
        chosen = chosen[np.argsort(order[chosen])]
        found = dict(zip(order[chosen].tolist(), chosen.tolist(), strict=True))

        def describe(entry: int) -> str:
            place = found[entry]
            episode = quoted(table.column("episode_id")[entry].as_py())
            before = "the start" if is_first[place] else f"step {ahead[place]:.0f}"
            was = "" if is_first[place] else f" after {values[place - 1]:g}"
            got = f"step {steps[place]:.0f}"
            if values is not steps:
                got = f"{values[place]:g}{was}"
            return f"episode {episode}: {expected} after {before}, got {got}"

        problems.add_entries(kind, order[chosen], places, describe)

    tell("steps there twice", steps == ahead, "expected the next step", steps)
    tell("steps with a gap", steps > ahead + 1, "expected the next step", steps)
    later = ~is_first
    tell(
        "time_s does not grow", later & (times <= np.roll(times, 1)), "expected a later time", times
    )
    fewer = later & (calls < np.roll(calls, 1))
    tell("planner_calls becomes fewer", fewer, "expected at least as many calls", calls)
