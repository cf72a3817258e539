"""Whether there are as many episodes as the recipe asks for, and the cells table says."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Columns, Tables
from affectsim_data.schemas import SPLITS

__all__ = ["check_counts"]

MISSING_SHARE = 0.02
"""Of a cell of split, family, challenge and action that may be missing."""
_CELL = ("split", "family", "challenge", "action", "emotion")
_Key = tuple[str, ...]


def check_counts(tables: Tables) -> list[Measure]:
    """Episodes by cell and split against the cells table and the recipe inside the manifest.

    A copy that holds only a part of its release is not counted.
    """
    if tables.manifest.partial_of is not None:
        return []
    measures = [_agree(tables), _complete(tables), _shortfalls(tables), _split_counts(tables)]
    if tables.recipe is not None:
        measures.append(_planned(tables, tables.recipe))
    return measures


def _keys(columns: Columns, names: tuple[str, ...]) -> list[_Key]:
    return list(zip(*(columns.text(name).astype(str) for name in names), strict=True))


def _agree(tables: Tables) -> Measure:
    counted = Counter(_keys(tables.episodes, _CELL))
    said: Counter[_Key] = Counter()
    for key, count in zip(_keys(tables.cells, _CELL), tables.cells.number("composed"), strict=True):
        said[key] += int(count)
    keys = sorted(counted | said)
    values = [counted[key] - said[key] for key in keys]
    return Measure.of("cells_agree", map("/".join, keys), values, low=0, high=0)


def _by_key(cells: Columns, size: int) -> dict[_Key, NDArray[np.float64]]:
    """Planned and composed episodes by the first columns of a cell."""
    sums: dict[_Key, NDArray[np.float64]] = {}
    counts = np.stack([cells.number("planned"), cells.number("composed")], axis=1)
    for key, pair in zip(_keys(cells, _CELL[:size]), counts, strict=True):
        sums[key] = sums.get(key, np.zeros(2)) + pair
    return dict(sorted(sums.items()))


def _complete(tables: Tables) -> Measure:
    cells = {key: pair for key, pair in _by_key(tables.cells, 4).items() if pair[0] > 0}
    values = [1.0 - composed / planned for planned, composed in cells.values()]
    notes = [f"{composed:g} of {planned:g}" for planned, composed in cells.values()]
    names = map("/".join, cells)
    return Measure.of("cells_complete", names, values, high=MISSING_SHARE, notes=notes)


def _shortfalls(tables: Tables) -> Measure:
    cells = tables.cells
    lacking = cells.number("composed") < cells.number("planned")
    reasons = np.array([one is not None for one in cells.text("binding_constraint")], bool)
    names = map("/".join, _keys(cells, _CELL))
    return Measure.of("shortfalls", names, lacking != reasons, high=0)


def _split_counts(tables: Tables) -> Measure:
    """Episodes of each split: as many as the recipe says, or as were planned."""
    planned = Counter({key[0]: int(pair[0]) for key, pair in _by_key(tables.cells, 1).items()})
    entries = tables.recipe.compositions if tables.recipe is not None else ()
    if entries and all(entry.episodes is not None for entry in entries):
        planned = Counter()
        for entry in entries:
            planned.update(entry.episodes or {})
    there = Counter(tables.episodes.text("split"))
    wanted = np.array([planned[split] for split in SPLITS], np.float64)
    counted = [there[split] for split in SPLITS]
    return Measure.of("split_counts", SPLITS, counted, low=wanted, high=wanted)


def _planned(tables: Tables, recipe: Recipe) -> Measure:
    """Planned episodes of cells whose share the recipe gives: within 1, being whole numbers."""
    shares: dict[_Key, float] = {}
    slack: Counter[_Key] = Counter()
    for entry in recipe.compositions:
        for split, total in (entry.episodes or {}).items():
            for action, action_share in entry.actions.items():
                for challenge, challenge_share in entry.challenges.items():
                    key = (split, entry.family, str(challenge), action)
                    shares[key] = shares.get(key, 0.0) + total * action_share * challenge_share
                    slack[key] += 1
    found = _by_key(tables.cells, 4)
    values = [float(found.get(key, np.zeros(2))[0]) for key in shares]
    low = [math.ceil(share - slack[key]) for key, share in shares.items()]
    high = [math.floor(share + slack[key]) for key, share in shares.items()]
    return Measure.of("cells_planned", map("/".join, shares), values, low=low, high=high)
