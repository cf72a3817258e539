"""Which slots are tried in which scene: in rounds, until each is placed or no scene is left."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from affectsim_data.builders.composer import SceneEpisodes, SceneWork, compose_scene
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.slots import Slot, slot_seed
from affectsim_data.episodes import Episode
from affectsim_data.schemas import SPLITS, Split

__all__ = ["compose_slots", "scene_splits"]

Runner = Callable[
    [Callable[[SceneWork], SceneEpisodes], Sequence[SceneWork]], Iterable[SceneEpisodes]
]
_SCENE_SHARES: Mapping[Split, float] = {"validation": 0.1, "test": 0.1}


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


def compose_slots(
    slots: Sequence[Slot],
    scenes: Mapping[str, tuple[bytes, bytes]],
    performances: Mapping[str, Performance],
    recipe: Recipe,
    run: Runner,
) -> tuple[list[Episode], list[Unplaced]]:
    """Places all slots, each in the first scene of an order of its own that can hold it.

    Args:
        slots: To be placed.
        scenes: GLB and navmesh of each, as the release stores them.
        performances: By the target's motion.
        recipe: Thresholds, camera, seed.
        run: Calls a task for every item, in order.

    Returns:
        The episodes, and the slots that no scene can hold with the reason of their last scene.
    """
    task = functools.partial(compose_scene, performances=performances, recipe=recipe)
    names = list(scenes)
    splits = scene_splits(names, recipe.seed)
    orders = {
        slot.key: np.random.default_rng([*slot_seed(recipe.seed, slot), 2]).permutation(len(names))
        for slot in slots
    }
    open_slots = list(slots)
    episodes: list[Episode] = []
    unplaced: list[Unplaced] = []
    for turn in range(len(names)):
        tried: dict[str, list[Slot]] = {}
        for slot in open_slots:
            tried.setdefault(names[orders[slot.key][turn]], []).append(slot)
        work = [
            SceneWork(name, splits[name], *scenes[name], tuple(tried[name]))
            for name in names
            if name in tried
        ]
        unplaced = []
        for result in run(task, work):
            episodes += result.episodes
            unplaced += result.unplaced
        failed = {one.key for one in unplaced}
        open_slots = [slot for slot in open_slots if slot.key in failed]
        if not open_slots:
            break
    return episodes, unplaced
