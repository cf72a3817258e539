"""Which slots are tried in which scene: in rounds, until each is placed or no scene is left."""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.slots import Slot, slot_seed
from affectsim_data.schemas import SPLITS, Split

__all__ = ["Batch", "place_slots", "scene_splits"]

_SCENE_SHARES: Mapping[Split, float] = {"validation": 0.1, "test": 0.1}
_LARGEST_BATCH = 128
"""Slots of a unit of work: more are parted, so that many workers can share a scene."""
_LEAST_BATCH = 12
"""Slots for which preparing a scene pays: with few slots left, a round uses few scenes."""
_LEAST_SCENES = 4
"""Scenes of a late round, if there are slots for them."""
_MOST_TRIES = 24
"""Scenes a slot is tried in: what fits into none of those that suit it best fits nowhere."""


@dataclasses.dataclass(frozen=True)
class Batch:
    """A unit of work: slots to be tried in one scene."""

    scene_id: str
    slots: tuple[Slot, ...]


Runner = Callable[[Sequence[Batch]], Iterable[Sequence[Unplaced]]]
"""Tries batches; for each, in order, the slots that found no place."""


def scene_splits(scene_ids: Sequence[str], seed: int) -> dict[str, Split]:
    """A split of scenes: a tenth each for validation and test, at least one where there are three.

    Args:
        scene_ids: Of the release.
        seed: Of the recipe.
    """
    order = [
        scene_ids[place] for place in np.random.default_rng([seed, 6]).permutation(len(scene_ids))
    ]
    splits: dict[str, Split] = {}
    for split in ("validation", "test"):
        count = max(1, round(_SCENE_SHARES[split] * len(scene_ids))) if len(scene_ids) > 2 else 0
        splits |= dict.fromkeys(order[:count], split)
        order = order[count:]
    splits |= dict.fromkeys(order, SPLITS[0])
    return splits


def place_slots(
    slots: Sequence[Slot], scene_ids: Sequence[str], *, seed: int, run: Runner
) -> list[Unplaced]:
    """Tries every slot in scene after scene, 24 at most, until one holds it.

    Each has an order of its own, random for the seed. From the second round on, scenes come first
    that held slots of the same placement and challenge, last those that held none of several; and
    while few slots are left, they meet in few scenes. What is tried where depends on the results
    of finished rounds only, not on who is ready first.

    Args:
        slots: To be placed.
        scene_ids: Where.
        seed: Of the recipe.
        run: Tries what is to be tried.

    Returns:
        The slots that found no place, with the reason of their last scene.
    """
    search = _Search(slots, scene_ids, seed)
    while batches := search.batches():
        for batch, unplaced in zip(batches, run(batches), strict=True):
            search.take_in(batch, unplaced)
    return [search.reasons[slot.key] for slot in slots if slot.key in search.reasons]


class _Search:
    """What was tried so far, and what is tried next."""

    def __init__(self, slots: Sequence[Slot], scene_ids: Sequence[str], seed: int) -> None:
        self.reasons: dict[str, Unplaced] = {}
        """Why a slot found no place in the last scene it was tried in."""
        self._scene_ids = scene_ids
        self._open = {slot.key: slot for slot in slots}
        self._left = {
            slot.key: list(
                np.random.default_rng([*slot_seed(seed, slot), 2]).permutation(len(scene_ids))
            )
            for slot in slots
        }
        self._tried: Counter[tuple[object, int]] = Counter()
        self._placed: Counter[tuple[object, int]] = Counter()
        self._is_first = True

    def batches(self) -> list[Batch]:
        """The next round; none if every slot is placed or was tried often enough."""
        least = max(0, len(self._scene_ids) - _MOST_TRIES)
        open_slots = [slot for slot in self._open.values() if len(self._left[slot.key]) > least]
        chosen: dict[int, list[Slot]] = {}
        scenes = self._scenes(open_slots)
        for slot in open_slots:
            ranked = [(self._rank(slot, scene), turn) for turn, scene in self._turns(slot, scenes)]
            if ranked:
                turn = min(ranked)[1]
                chosen.setdefault(self._left[slot.key].pop(turn), []).append(slot)
        self._is_first = False
        return [
            Batch(self._scene_ids[scene], tuple(chosen[scene][start : start + _LARGEST_BATCH]))
            for scene in sorted(chosen)
            for start in range(0, len(chosen[scene]), _LARGEST_BATCH)
        ]

    def _turns(self, slot: Slot, scenes: set[int]) -> list[tuple[int, int]]:
        return [(turn, one) for turn, one in enumerate(self._left[slot.key]) if one in scenes]

    def _scenes(self, slots: Sequence[Slot]) -> set[int]:
        """Scenes of the next round: all of them, or the few that suit most of the slots left."""
        count = max(_LEAST_SCENES, len(slots) // _LEAST_BATCH)
        if self._is_first or count >= len(self._scene_ids):
            return set(range(len(self._scene_ids)))
        votes: Counter[int] = Counter()
        for slot in slots:
            for scene in self._left[slot.key]:
                votes[scene] += 3 - self._rank(slot, scene)
        best = sorted(votes, key=lambda scene: (-votes[scene], scene))
        return set(best[:count])

    def _rank(self, slot: Slot, scene: int) -> int:
        """How much speaks against a scene: 0 if such slots were placed there, 2 if they failed."""
        key = _kind(slot), scene
        if self._placed[key]:
            return 0
        return 2 if self._tried[key] else 1

    def take_in(self, batch: Batch, unplaced: Sequence[Unplaced]) -> None:
        """Learns what became of a batch."""
        scene = self._scene_ids.index(batch.scene_id)
        failed = {one.key: one for one in unplaced}
        for slot in batch.slots:
            self._tried[_kind(slot), scene] += 1
            if slot.key in failed:
                self.reasons[slot.key] = failed[slot.key]
            else:
                self._placed[_kind(slot), scene] += 1
                self.reasons.pop(slot.key, None)
                self._open.pop(slot.key)


def _kind(slot: Slot) -> tuple[object, ...]:
    """What decides most where a slot finds room."""
    return slot.placement, slot.challenge
