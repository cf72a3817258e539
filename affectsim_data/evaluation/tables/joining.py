"""Predictions and trajectories joined with the episodes of a release."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray

from affectsim_data.evaluation.scored import Acquisitions, ScoredTable
from affectsim_data.evaluation.tables.episodes import UNKNOWN, ScoredEpisodes, scored_episodes
from affectsim_data.evaluation.tables.frames import (
    check_fallback_frames,
    frame_notes,
    same_frames,
)
from affectsim_data.evaluation.tables.grid import Grid, answer_codes, lay_out
from affectsim_data.evaluation.tables.policies import acquisitions_of
from affectsim_data.evaluation.tables.predictions import Predictions
from affectsim_data.evaluation.tables.problems import Places, Problems, quoted
from affectsim_data.evaluation.tables.trajectories import Trajectories
from affectsim_data.releases import Release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.splits import SplitBy

__all__ = ["score_predictions"]

_EXAMPLES = 3


def score_predictions(
    predictions: Predictions,
    release: Release,
    *,
    split: str,
    trajectories: Trajectories | None = None,
    allow_missing: bool = False,
    policy: str | None = None,
    models: Sequence[str] | None = None,
    split_by: SplitBy = "group",
    filter: Filter | None = None,
) -> ScoredTable:
    """Every model's answer about every episode of a split, beside the truth.

    Args:
        predictions: What models answered.
        release: Whose episodes they are.
        split: `train`, `validation` or `test`.
        trajectories: What the policy behind a_obs did. Where it acquired nothing, a_obs is the
            paired p_init clip: rows that are missing for it are taken from p_init.
        allow_missing: Counts episodes without a prediction as wrong, and those without a
            trajectory as a robot that stood still, instead of refusing the tables.
        policy: Whose trajectories; needed if there are several.
        models: Those to score; all if not given.
        split_by: What no two splits share, as in `Release.split_table`.
        filter: Which episodes of the split are scored; rows of the others are passed over. All if
            not given. `affectsim_data.releases.filters` says what it looks like.

    Raises:
        TableProblems: Rows do not fit the release, or are missing; lists all of them.
        ValueError: There is no such split, policy, model or episode, or the release is a partial
            copy.
    """
    episodes = scored_episodes(release, split, split_by, filter)
    if models is not None:
        predictions = _of_models(predictions, models)
    problems = Problems("tables")
    places = _known_places(predictions, episodes, problems)
    acquired, notes = None, [*predictions.notes, *episodes.notes]
    if trajectories is not None:
        acquired, more = acquisitions_of(
            trajectories, episodes, policy=policy, allow_missing=allow_missing, problems=problems
        )
        notes += [*trajectories.notes, *more]
    elif policy is not None:
        raise ValueError(f"policy {policy!r} is named, but no trajectories are given")
    answers, more = answer_codes(predictions.table)
    grid = lay_out(predictions, answers, places, len(episodes.episode_ids))
    notes += more
    check_fallback_frames(grid, acquired, predictions.places, problems)
    same = same_frames(grid, acquired)
    notes += frame_notes(grid, same, acquired)
    grid, more = _fall_back(grid, acquired)
    notes += more
    notes += _missing(grid, episodes, allow_missing=allow_missing, problems=problems)
    problems.raise_if_any()
    return _scored_table(grid, episodes, same, acquired, notes)


def _scored_table(
    grid: Grid,
    episodes: ScoredEpisodes,
    same: NDArray[np.bool_],
    acquired: Acquisitions | None,
    notes: Sequence[str],
) -> ScoredTable:
    manifest = episodes.release.manifest
    return ScoredTable(
        release=f"{manifest.name}@{episodes.release.content_sha256[:12]}",
        split=episodes.title,
        episode_ids=np.array(episodes.episode_ids.to_pylist(), np.str_),
        truth=episodes.truth,
        factors=episodes.factors,
        performances=episodes.performances,
        performers=episodes.performers,
        models=grid.models,
        conditions=grid.conditions,
        answers=grid.answers,
        was_run=grid.was_run,
        latency_ms=grid.latency_ms,
        same_frames=same,
        d_star_m=episodes.d_star_m,
        ring_empty=episodes.ring_empty,
        acquisitions=acquired,
        notes=tuple(notes),
    )


def _of_models(predictions: Predictions, models: Sequence[str]) -> Predictions:
    """The rows of some models."""
    unknown = [model for model in models if model not in predictions.models]
    if unknown or not models:
        listed = ", ".join(map(quoted, predictions.models))
        asked = ", ".join(map(quoted, unknown)) or "none"
        raise ValueError(f"models: got {asked}; the predictions are of {listed}")
    wanted = pc.is_in(predictions.table.column("model"), value_set=pa.array(models, pa.string()))
    entries = np.flatnonzero(wanted.to_numpy())
    places = predictions.places
    chosen = Places(
        files=places.files,
        starts=np.searchsorted(entries, places.starts),
        rows=places.rows[entries],
        find_lines=places.find_lines,
    )
    table = predictions.table.take(pa.array(entries))
    return dataclasses.replace(predictions, table=table, places=chosen)


def _known_places(
    predictions: Predictions, episodes: ScoredEpisodes, problems: Problems
) -> NDArray[np.int64]:
    """Places of the rows' episodes; adds those that are of no episode of the split."""
    column = predictions.table.column("episode_id")
    places = episodes.places(column)
    unknown = np.flatnonzero(places == UNKNOWN)
    if len(unknown):
        reasons = episodes.why_not(pc.unique(column.take(pa.array(unknown))))

        def describe(entry: int) -> str:
            episode_id = column[entry].as_py()
            return f"{quoted(episode_id)} {reasons[episode_id]}"

        problems.add_entries("episode_id of another place", unknown, predictions.places, describe)
    return places


def _fall_back(grid: Grid, acquired: Acquisitions | None) -> tuple[Grid, list[str]]:
    """The grid with p_init for a_obs where nothing was acquired and no row says what came."""
    initial, active = grid.place("p_init"), grid.place("a_obs")
    if acquired is None or initial is None or active is None:
        return grid, []
    wanted = grid.was_run[:, active, None] & ~grid.is_there[:, active] & ~acquired.acquired
    filled = wanted & grid.is_there[:, initial]
    if not filled.any():
        return grid, []
    answers, entries = grid.answers.copy(), grid.entries.copy()
    answers[:, active][filled] = grid.answers[:, initial][filled]
    entries[:, active][filled] = grid.entries[:, initial][filled]
    count = filled.shape[1]
    note = (
        f"{filled.sum():,} of {grid.was_run[:, active].sum() * count:,} answers under a_obs are "
        f"those under p_init: {acquired.policy!r} acquired nothing in "
        f"{(~acquired.acquired).sum():,} of {count:,} episodes, and a_obs falls back there"
    )
    return dataclasses.replace(grid, answers=answers, entries=entries), [note]


def _missing(
    grid: Grid, episodes: ScoredEpisodes, *, allow_missing: bool, problems: Problems
) -> list[str]:
    """Episodes without a prediction, as problems, or as notes if they may be missing."""
    lacking = grid.was_run[:, :, None] & ~grid.is_there
    notes = []
    for model, condition in np.argwhere(lacking.any(axis=2)):
        absent = np.flatnonzero(lacking[model, condition])
        text = (
            f"model {quoted(grid.models[model])}, condition {quoted(grid.conditions[condition])}: "
            f"{len(absent):,} of {lacking.shape[2]:,} episodes are missing"
        )
        if allow_missing:
            notes.append(f"{text} and count as wrong")
            continue
        ids = ", ".join(repr(episodes.episode_ids[int(one)].as_py()) for one in absent[:_EXAMPLES])
        more = ", ..." if len(absent) > _EXAMPLES else ""
        problems.add(
            "missing predictions (allow_missing counts them wrong)", f"{text}: {ids}{more}"
        )
    return notes
