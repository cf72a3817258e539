"""Whether splits share nothing they may not, and placements are alike in all but the emotion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from affectsim_data.builders.leakage import PLACEMENT_COLUMNS
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Tables
from affectsim_data.schemas import SCHEMAS

__all__ = ["check_partitions"]

_NUMBERS = tuple(f.name for f in SCHEMAS["episodes"] if not pa.types.is_string(f.type))


def check_partitions(tables: Tables) -> list[Measure]:
    """Splits by group, source and scene; placements by their columns and emotions."""
    return [_groups(tables), _sources(tables), _scenes(tables), *_placements(tables)]


def _spread(
    check: str, names: Iterable[str], splits: Iterable[str], mask: Iterable[bool] | None = None
) -> Measure:
    """In how many splits each name occurs."""
    pairs = set(zip(names, splits, strict=True))
    counts = Counter(name for name, _ in pairs if name is not None)
    order = sorted(counts)
    notes = [
        ", ".join(sorted(split for one, split in pairs if one == name)) if counts[name] > 1 else ""
        for name in order
    ]
    return Measure.of(check, order, [counts[name] for name in order], high=1, notes=notes)


def _groups(tables: Tables) -> Measure:
    names = (
        f"{family}: {group}"
        for family, group in zip(
            tables.episodes.text("family"), tables.episodes.text("group_id"), strict=True
        )
    )
    return _spread("groups_apart", names, tables.episodes.text("split"))


def _sources(tables: Tables) -> Measure:
    """What the family's rule forbids, read off the motions and not the stored group.

    Action-grounded episodes share no performer, observation-controlled ones no source
    performance, dyads no sequence, whichever of the two is the target.
    """
    episodes = tables.episodes
    groups = tables.assets["motions"].text("group_id")
    names: list[str] = []
    splits: list[str] = []
    families, performers = episodes.text("family"), episodes.text("performer_id")
    for key in ("motion_id", "partner_motion_id"):
        rows = tables.rows_of("motions", episodes.text(key))
        for place in np.flatnonzero(rows >= 0):
            grounded = families[place] == "action_grounded"
            name = performers[place] if grounded else groups[rows[place]]
            names.append(f"{families[place]}: {name}")
            splits.append(episodes.text("split")[place])
    return _spread("sources_apart", names, splits)


def _scenes(tables: Tables) -> Measure:
    episodes = tables.episodes
    return _spread("scenes_apart", episodes.text("scene_id"), episodes.text("scene_split"))


def _placements(tables: Tables) -> list[Measure]:
    """Of every placement: columns in which its episodes differ, and its most frequent emotion."""
    episodes = tables.episodes
    names, place = np.unique(episodes.text("placement_id").astype(str), return_inverse=True)
    _, first = np.unique(place, return_index=True)
    differs: dict[str, NDArray[np.bool_]] = {}
    for name in PLACEMENT_COLUMNS:
        if name in _NUMBERS:
            numbers = episodes.number(name)
            same = np.isclose(numbers, numbers[first][place], rtol=0.0, atol=0.0, equal_nan=True)
            differs[name] = ~same
        else:
            differs[name] = episodes.text(name) != episodes.text(name)[first][place]
    wrong = np.stack(
        [np.bincount(place, mask, len(names)) > 0 for mask in differs.values()], axis=1
    )
    labels = np.array(list(differs))
    notes = [", ".join(labels[row]) if row.any() else "" for row in wrong]
    alike = Measure.of("placements_alike", names, wrong.sum(axis=1), high=0, notes=notes)
    _, emotion = np.unique(episodes.text("emotion").astype(str), return_inverse=True)
    table = np.zeros((len(names), emotion.max(initial=0) + 1))
    np.add.at(table, (place, emotion), 1.0)
    return [alike, Measure.of("placement_emotions", names, table.max(axis=1), high=1)]
