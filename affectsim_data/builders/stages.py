"""The stages of a build: units worked by an engine, each stored as soon as it is done."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, TypeVar

import pyarrow as pa
from tqdm import tqdm

from affectsim_data.avatars import Avatar
from affectsim_data.builders.casting import Cast, finish_cast, make_motions, plan_cast
from affectsim_data.builders.checkpoints import Checkpoints, Unit, result_type, unit_key
from affectsim_data.builders.composer import SceneWork, compose_scene
from affectsim_data.builders.imports import ImportReport
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.metering import Meter
from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.repertoire import Repertoire
from affectsim_data.builders.scene_sources import (
    FailedScene,
    SceneSource,
    build_scene,
    scene_sources,
)
from affectsim_data.builders.scheduling import Batch, place_slots, scene_splits
from affectsim_data.builders.screening import load_thresholds
from affectsim_data.builders.slots import Slot
from affectsim_data.builders.sources import SourceGiven
from affectsim_data.builders.units import Rows
from affectsim_data.engines.protocol import Engine
from affectsim_data.releases.rows import scene_row
from affectsim_data.scenes.baking import BakeReport

__all__ = [
    "SceneShelf",
    "StageRunner",
    "StoredScene",
    "compose_slots",
    "make_performances",
    "make_scenes",
]

_In = TypeVar("_In")
_Out = TypeVar("_Out")


class StageRunner:
    """Runs the units of a build's stages: those that are stored are not done again.

    All results are read back from where they are stored, so that a build that goes on sees the
    same numbers as one that was never interrupted.
    """

    def __init__(self, engine: Engine, checkpoints: Checkpoints, meter: Meter, name: str) -> None:
        """`name` is what is built, for progress bars."""
        self._engine = engine
        self._checkpoints = checkpoints
        self._meter = meter
        self._name = name

    def units(
        self,
        task: Callable[[_In], Any],
        keys: Sequence[str],
        item: Callable[[int], _In],
        *,
        stage: str,
        label: str = "",
        order: Sequence[int] | None = None,
    ) -> list[Unit]:
        """The units of a stage, all of them done.

        Args:
            task: Makes a unit's result.
            keys: What each unit is made of.
            item: What the task is called with for the unit at a place; asked for when needed.
            stage: Where the units are stored.
            label: For the progress bar, the stage if empty.
            order: In which they are begun.
        """
        units = self._checkpoints.units(stage, keys, result_type(task))
        missing = [place for place in order or range(len(units)) if not units[place].is_done]
        there = len(units) - len(missing)
        self._meter.add(len(missing), there)
        if missing:
            items = (item(place) for place in missing)
            bar = tqdm(
                self._engine.run(task, items),
                desc=f"{self._name}: {label or stage}",
                total=len(units),
                initial=there,
            )
            for turn, result in bar:
                units[missing[turn]].write(result)
        return units


@dataclasses.dataclass(frozen=True)
class StoredScene:
    """A scene as releases store it, and what became of what it was made from."""

    scene_id: str
    licence: str
    num_bytes: int
    """Of the scene's row."""
    baked: BakeReport
    imported: ImportReport | None
    """None for generated homes."""
    row: Rows
    """Of the scenes table."""


class SceneShelf:
    """The scenes of a build, read when they are asked for."""

    def __init__(self, units: Sequence[Unit]) -> None:
        results = [(unit, _without_row(unit.read())) for unit in units]
        self._units = {one.scene_id: unit for unit, one in results if isinstance(one, StoredScene)}
        self.scenes = tuple(one for _, one in results if isinstance(one, StoredScene))
        """What is known of them, without their rows."""
        self.failed = tuple(one for _, one in results if isinstance(one, FailedScene))
        """Those that cannot be used."""

    def row(self, scene_id: str) -> pa.Table:
        """The row of the scenes table."""
        stored: StoredScene = self._units[scene_id].read()
        return stored.row.arrow

    def rows(self) -> Iterator[pa.Table]:
        """All rows, one by one."""
        return (self.row(one.scene_id) for one in self.scenes)


def make_performances(
    recipe: Recipe, avatars: Sequence[Avatar], source: SourceGiven, run: StageRunner
) -> Cast:
    """All performances of a recipe, screened."""
    plan = plan_cast(recipe, source)
    thresholds = load_thresholds(recipe.document.get("screening"))
    task = functools.partial(make_motions, recipe=recipe, thresholds=thresholds)
    keys = [unit_key(job) for job in plan.jobs]
    units = run.units(task, keys, plan.jobs.__getitem__, stage="motions")
    results = [unit.read() for unit in units]
    return finish_cast(recipe, results, avatars, left_out=plan.left_out)


def make_scenes(recipe: Recipe, source: SourceGiven, run: StageRunner) -> SceneShelf:
    """All scenes of a recipe that can be used, with their navmeshes."""
    items = scene_sources(recipe, source)
    task = functools.partial(_stored_scene, recipe=recipe, folder=source)
    keys = [unit_key(item) for item in items]
    return SceneShelf(run.units(task, keys, items.__getitem__, stage="scenes"))


def _stored_scene(
    item: SceneSource, *, recipe: Recipe, folder: SourceGiven
) -> StoredScene | FailedScene:
    built = build_scene(item, recipe, folder)
    if isinstance(built, FailedScene):
        return built
    row = Rows.of("scenes", [scene_row(built.scene, built.navmesh)])
    return StoredScene(
        built.scene.scene_id,
        built.scene.licence,
        row.arrow.nbytes,
        built.baked,
        built.imported,
        row,
    )


def _without_row(result: StoredScene | FailedScene) -> StoredScene | FailedScene:
    if isinstance(result, FailedScene):
        return result
    return dataclasses.replace(result, row=Rows.of("scenes", []))


@dataclasses.dataclass(frozen=True)
class ComposedBatch:
    """What became of slots in a scene."""

    episodes: Rows
    """Named by their slot and emotion; numbered when all scenes are done."""
    unplaced: tuple[Unplaced, ...]


def compose_slots(
    slots: Sequence[Slot],
    shelf: SceneShelf,
    performances: Sequence[Performance],
    recipe: Recipe,
    run: StageRunner,
) -> tuple[pa.Table, list[Unplaced]]:
    """Rows of the episodes table for all slots that find a place, and those that do not."""
    repertoire = Repertoire(performances)
    task = functools.partial(_compose, performances=repertoire, recipe=recipe)
    scene_ids = [one.scene_id for one in shelf.scenes]
    splits = scene_splits(scene_ids, recipe.seed)
    tables: list[pa.Table] = []
    rounds = iter(range(1, 1 + len(slots) * len(scene_ids)))

    def item(batch: Batch) -> SceneWork:
        (row,) = shelf.row(batch.scene_id).select(["glb", "navmesh"]).to_pylist()
        scene_id = batch.scene_id
        return SceneWork(scene_id, splits[scene_id], row["glb"], row["navmesh"], batch.slots)

    def run_round(batches: Sequence[Batch]) -> Iterator[Sequence[Unplaced]]:
        keys = [unit_key(batch, splits[batch.scene_id]) for batch in batches]
        # The largest first: none is left to be waited for at the end.
        order = sorted(range(len(batches)), key=lambda place: -len(batches[place].slots))
        turn = next(rounds)
        label = "episodes" if turn == 1 else f"episodes, round {turn}"
        for unit in run.units(
            task, keys, lambda i: item(batches[i]), stage="episodes", label=label, order=order
        ):
            result: ComposedBatch = unit.read()
            tables.append(result.episodes.arrow)
            yield result.unplaced

    unplaced = place_slots(slots, scene_ids, seed=recipe.seed, run=run_round)
    return pa.concat_tables(tables).combine_chunks(), unplaced


def _compose(
    work: SceneWork, *, performances: Mapping[str, Performance], recipe: Recipe
) -> ComposedBatch:
    result = compose_scene(work, performances, recipe)
    rows = Rows.of("episodes", [episode.to_row() for episode in result.episodes])
    return ComposedBatch(rows, result.unplaced)
