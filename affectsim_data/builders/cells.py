"""How many episodes of each cell there are, and what the missing ones failed at."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.slots import CellKey, Slot, planned_counts
from affectsim_data.schemas import Challenge, Family, Split

__all__ = ["Shortfall", "cell_rows", "shortfalls"]

_NAMES = ("split", "family", "challenge", "action", "emotion")


@dataclasses.dataclass(frozen=True)
class Shortfall:
    """Episodes of a cell that are missing from a release; never filled by loosening a threshold."""

    split: Split
    family: Family
    challenge: Challenge | None
    action: str
    emotion: str
    planned: int
    composed: int
    binding_constraint: str
    """What most of their slots failed at."""


def cell_rows(
    slots: Sequence[Slot], emotion_of: Mapping[str, str], unplaced: Sequence[Unplaced]
) -> list[dict[str, Any]]:
    """Rows of the cells table, sorted.

    Args:
        slots: What was planned.
        emotion_of: Emotion of a motion.
        unplaced: Slots that no scene can hold.
    """
    reasons = {one.key: one.constraint for one in unplaced}
    lacking = [slot for slot in slots if slot.key in reasons]
    planned, missing = (planned_counts(some, emotion_of) for some in (slots, lacking))
    constraints: dict[CellKey, Counter[str]] = {}
    for slot in lacking:
        for cell in planned_counts([slot], emotion_of):
            constraints.setdefault(cell, Counter())[reasons[slot.key]] += 1
    rows = []
    for cell in sorted(planned, key=lambda one: tuple(map(str, one))):
        row: dict[str, Any] = dict(zip(_NAMES, cell, strict=True))
        row["planned"] = planned[cell]
        row["composed"] = planned[cell] - missing.get(cell, 0)
        most = constraints[cell].most_common(1) if cell in missing else [(None, 0)]
        row["binding_constraint"] = most[0][0]
        rows.append(row)
    return rows


def shortfalls(rows: Sequence[Mapping[str, Any]]) -> tuple[Shortfall, ...]:
    """The cells that lack episodes."""
    return tuple(Shortfall(**row) for row in rows if row["composed"] < row["planned"])
