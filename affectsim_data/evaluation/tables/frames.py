"""Clips that are the very clip of p_init: where observation could change nothing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.evaluation.scored import Acquisitions
from affectsim_data.evaluation.tables.grid import Grid
from affectsim_data.evaluation.tables.problems import Places, Problems

__all__ = ["check_fallback_frames", "frame_notes", "same_frames"]


def same_frames(grid: Grid, acquisitions: Acquisitions | None) -> NDArray[np.bool_]:
    """Whether clips are those of p_init by construction, `(num_conditions, num_episodes)`.

    So they are under p_init; under a_obs where the policy acquired nothing; and wherever a model
    told equal hashes for both, unless another told different ones.
    """
    equal, differ = _compared(grid)
    same: NDArray[np.bool_] = np.any(equal, axis=0) & ~np.any(differ, axis=0)
    initial, active = grid.place("p_init"), grid.place("a_obs")
    if initial is not None:
        same[initial] = True
    if active is not None and acquisitions is not None:
        same[active] |= ~acquisitions.acquired
    return same


def check_fallback_frames(
    grid: Grid, acquisitions: Acquisitions | None, places: Places, problems: Problems
) -> None:
    """Rows of a_obs whose frames are not those of p_init, though nothing was acquired."""
    active = grid.place("a_obs")
    if active is None or acquisitions is None:
        return
    _, differ = _compared(grid)
    strange = differ[:, active] & ~acquisitions.acquired
    problems.add_entries(
        "a_obs without an observation",
        np.sort(grid.entries[:, active][strange]),
        places,
        lambda _: (
            f"{acquisitions.policy!r} acquired nothing in this episode, so that a_obs is the clip "
            "of p_init; yet frames_sha256 differs from that of the p_init row"
        ),
    )


def frame_notes(
    grid: Grid, same: NDArray[np.bool_], acquisitions: Acquisitions | None
) -> list[str]:
    """What is odd about frames and the answers to them."""
    equal, differ = _compared(grid)
    initial = grid.place("p_init")
    notes = []
    for place, condition in enumerate(grid.conditions):
        if initial is None or place == initial:
            continue
        conflicts = int((equal[:, place].any(axis=0) & differ[:, place].any(axis=0)).sum())
        if conflicts:
            notes.append(
                f"models disagree on whether the frames of {condition} are those of p_init, in "
                f"{conflicts:,} episodes, by frames_sha256; these are taken for different"
            )
        both = grid.is_there[:, place] & grid.is_there[:, initial] & same[place]
        changed = both & (grid.answers[:, place] != grid.answers[:, initial])
        if changed.any():
            notes.append(
                f"{changed.sum():,} of {both.sum():,} answers under {condition} to the very frames "
                f"of p_init differ from those under p_init ({_by_model(grid, changed)}): either "
                "the recognizer answers by chance, or rows are mixed up"
            )
    active = grid.place("a_obs")
    if active is not None and acquisitions is not None:
        unchanged = int((same[active] & acquisitions.acquired).sum())
        if unchanged:
            notes.append(
                f"{unchanged:,} of {acquisitions.acquired.sum():,} clips collected after a handoff "
                "show the very frames of p_init"
            )
    return notes


def _compared(grid: Grid) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where a model told that frames equal those of p_init, and where that they differ."""
    initial = grid.place("p_init")
    if initial is None:
        none = np.zeros(grid.frames.shape, bool)
        return none, none
    reference = grid.frames[:, initial : initial + 1]
    told = (grid.frames >= 0) & (reference >= 0)
    return told & (grid.frames == reference), told & (grid.frames != reference)


def _by_model(grid: Grid, mask: NDArray[np.bool_]) -> str:
    counts = mask.sum(axis=1)
    shown = [f"{grid.models[place]!r} {counts[place]:,}" for place in np.flatnonzero(counts)]
    return ", ".join(shown[:3]) + (f" and {len(shown) - 3} more models" if len(shown) > 3 else "")
