"""Trajectories that a release carries, with the episodes they are of, as validation reads them."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Columns, Tables
from affectsim_data.errors import IntegrityError
from affectsim_data.observations.recorded_rows import POSITION, RecordedRows
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release
from affectsim_data.releases.recorded import file_stem, recorded_files
from affectsim_data.schemas import SCHEMAS

__all__ = ["Recorded", "read_recorded"]

_COLUMNS = tuple(SCHEMAS["trajectories"].names)


@dataclasses.dataclass(frozen=True, eq=False)
class Recorded:
    """The trajectories of one policy in one file; `n` rows of `k` episodes, all known."""

    policy: str
    rows: RecordedRows
    episodes: Columns
    """Of each trajectory, `k` rows."""

    def __len__(self) -> int:
        return len(self.rows.starts)

    def without(self, places: NDArray[np.intp]) -> Recorded:
        """The same without some trajectories."""
        if not len(places):
            return self
        keep = np.ones(len(self), bool)
        keep[places] = False
        mine = np.repeat(keep, self.rows.lengths)
        rows = RecordedRows.of(self.rows.table.filter(pa.array(mine)), self.rows.numbers[mine])
        return Recorded(self.policy, rows, self.episodes.where(keep))

    @functools.cached_property
    def position(self) -> FloatArray:
        """Of the robot after each action, `(n, 3)`."""
        return np.stack([self.rows.column(name) for name in POSITION], axis=1)

    @property
    def start(self) -> FloatArray:
        """Where the robot starts, `(k, 3)`."""
        return self.episodes.point("start")

    @property
    def start_yaw_deg(self) -> FloatArray:
        """Where it looks then, `(k,)`."""
        return self.episodes.number("start_yaw_deg")

    @property
    def duration_s(self) -> FloatArray:
        """Of a cycle of the motion, `(k,)`."""
        return self.episodes.number("duration_s")

    def worst(
        self, check: str, values: FloatArray, high: float, describe: Callable[[int], str]
    ) -> Measure:
        """The largest value of each trajectory, with the first step beyond the limit.

        Args:
            check: Its name.
            values: Of every row, `(n,)`.
            high: The limit.
            describe: What is wrong with a row.
        """
        worst = np.maximum.reduceat(values, self.rows.starts)
        notes = self.notes(~(values <= high), describe)
        return Measure.of(check, self.rows.episode_ids, worst, high=high, notes=notes)

    def counted(
        self, check: str, wrong: NDArray[np.bool_], describe: Callable[[int], str]
    ) -> Measure:
        """How many rows of each trajectory are wrong, `(n,)`, with the first of them."""
        counts = np.add.reduceat(wrong, self.rows.starts, dtype=np.int64)
        notes = self.notes(wrong, describe)
        return Measure.of(check, self.rows.episode_ids, counts, high=0, notes=notes)

    def notes(self, wrong: NDArray[np.bool_], describe: Callable[[int], str]) -> list[str]:
        """What is wrong with the first row of each trajectory that is; empty if none is."""
        notes = [""] * len(self)
        at = np.flatnonzero(wrong)
        owners, firsts = np.unique(self.rows.owners(at), return_index=True)
        for owner, first in zip(owners, firsts, strict=True):
            step = self.rows.column("step")[at[first]]
            notes[owner] = f"{self.policy!r}, step {step}: {describe(int(at[first]))}"
        return notes


def read_recorded(release: Release, tables: Tables) -> tuple[list[Recorded], list[Measure]]:
    """The trajectories that can be looked at, and what is wrong with the others.

    Of a partial copy, trajectories of episodes that are not there are left out.
    """
    recorded: list[Recorded] = []
    strangers: dict[str, str] = {}
    notes: dict[str, str] = {}
    named = recorded_files(release.manifest)
    for name in release.manifest.table_files("trajectories"):
        if name not in named:
            notes[name] = "its name is not trajectories/POLICY-SPLIT.parquet"
            continue
        try:
            table = release.recorded_table(name).select(_COLUMNS)
        except (ValueError, OSError, IntegrityError) as error:
            notes[name] = str(error)
            continue
        stem, split = named[name]
        notes[name] = _problem(table, stem)
        if not notes[name]:
            episodes = tables.episodes.where(tables.episodes.text("split") == split)
            found, unknown = _known(table, episodes)
            recorded += found
            if release.manifest.partial_of is None:
                strangers |= dict.fromkeys(unknown, f"in {name}, in no row of split {split!r}")
    known = [one for part in recorded for one in part.rows.episode_ids]
    told = {**dict.fromkeys(known, ""), **strangers}
    return recorded, [_flagged("trajectory_files", notes), _flagged("trajectory_episodes", told)]


def _flagged(check: str, notes: dict[str, str]) -> Measure:
    values = [float(bool(note)) for note in notes.values()]
    return Measure.of(check, notes, values, high=0, notes=tuple(notes.values()))


def _problem(table: pa.Table, stem: str) -> str:
    """What is wrong with a file as a whole; empty if nothing is."""
    empty = [name for name in _COLUMNS if table.column(name).null_count]
    if empty:
        row = int(np.flatnonzero(table.column(empty[0]).is_null())[0])
        return f"{empty[0]} is null in row {row + 1}"
    others = [one for one in _policies(table) if file_stem(one) != stem]
    return f"holds trajectories of {others[0]!r}" if others else ""


def _policies(table: pa.Table) -> Iterable[str]:
    return sorted(pc.unique(table.column("policy")).to_pylist())


def _known(table: pa.Table, episodes: Columns) -> tuple[list[Recorded], list[str]]:
    """Trajectories whose episodes are among some, by policy, and the other episodes."""
    ids = pa.array(episodes.text("episode_id").tolist(), pa.string())
    there = pc.is_in(table.column("episode_id"), value_set=ids)
    unknown = pc.unique(table.column("episode_id").filter(pc.invert(there))).to_pylist()
    return list(_by_policy(table, there.to_numpy(), episodes, ids)), sorted(unknown)


def _by_policy(
    table: pa.Table, there: NDArray[np.bool_], episodes: Columns, ids: pa.Array
) -> Iterator[Recorded]:
    for policy in _policies(table):
        mine = there & pc.equal(table.column("policy"), policy).to_numpy()
        if mine.any():
            rows = RecordedRows.of(table.filter(pa.array(mine)), np.flatnonzero(mine) + 1)
            places = pc.index_in(pa.array(rows.episode_ids), value_set=ids)
            yield Recorded(policy, rows, Columns(episodes.table.take(places)))
