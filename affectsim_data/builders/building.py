"""Builds a release from a recipe: assets, episodes, shards, manifest."""

from __future__ import annotations

import dataclasses
import functools
import os
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import affectsim_data
from affectsim_data.avatars import Avatar
from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.casting import Cast, make_cast
from affectsim_data.builders.corpus_scan import raise_problems
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.processes import run_parallel
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.scene_sources import (
    BuiltScene,
    FailedScene,
    build_scene,
    scene_sources,
)
from affectsim_data.builders.scheduling import compose_slots
from affectsim_data.builders.slots import CellKey, Slot, make_slots, planned_counts
from affectsim_data.episodes import Episode
from affectsim_data.motions import Motion
from affectsim_data.releases import Manifest, ReleaseWriter
from affectsim_data.releases.rows import avatar_row, motion_row, scene_row
from affectsim_data.schemas import SPLITS, Challenge, Family, Split

__all__ = ["BuildReport", "Shortfall", "build_release"]


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


@dataclasses.dataclass(frozen=True)
class BuildReport:
    """What was built, and what could not be."""

    manifest: Manifest
    shortfalls: tuple[Shortfall, ...]
    """Cells with fewer episodes than the recipe asks for."""
    cast: Cast
    """Who performs, and what screening said of the motions."""
    scenes: tuple[BuiltScene, ...]
    """The scenes, with what became of what they were made from."""
    failed_scenes: tuple[FailedScene, ...]
    """Scenes that could not be used."""


def build_release(
    recipe: str | Path,
    out: Path,
    *,
    source: Path | None = None,
    jobs: int | None = None,
    overwrite: bool = False,
    screen_report: Path | None = None,
    skip_broken: bool = False,
    shell: bool = False,
) -> BuildReport:
    """Builds a release; the same recipe gives the same bytes on any number of processes.

    Args:
        recipe: Name of a file in `builders/`, or a path.
        out: Folder of the release; appears when it is whole.
        source: Corpus, scenes or furniture of a recipe that reads some.
        jobs: Processes; one per core if not given.
        overwrite: Whether `out` may hold a release already.
        screen_report: Parquet file to write with a row per motion and check; written also when the
            build fails later.
        skip_broken: Whether to leave out motions and scenes that cannot be read.
        shell: Whether imported scenes without a stage get a floor and walls.

    Raises:
        FileNotFoundError: No such recipe or source.
        FileExistsError: Something is at `out`.
        ValueError: The recipe, the corpus or an asset is broken.
    """
    plan = read_recipe(recipe)
    if shell:
        plan = plan.with_shell()
    workers = jobs or os.cpu_count() or 1
    with ReleaseWriter(out, overwrite=overwrite) as writer:
        avatars = load_avatars(plan)
        cast = make_cast(plan, avatars, source=source, jobs=workers)
        if screen_report is not None:
            cast.screening.write_report(screen_report)
        _check_cast(plan, cast, skip_broken=skip_broken)
        performances: Sequence[Performance] = cast.performances
        slots = make_slots(plan, performances)
        used = {motion_id for slot in slots for motion_id in slot.motion_ids}
        performances = [p for p in performances if p.motion.motion_id in used]
        scenes, failed = _build_scenes(plan, source, workers, skip_broken=skip_broken)
        episodes, cells = _compose(plan, slots, scenes, performances, workers)
        for split in SPLITS:
            members = [row for row in cells if row["split"] == split]
            writer.add_table("cells", members, stem=split)
        _write_tables(writer, episodes, performances, scenes, avatars)
        licences = {motion.licence for motion in _motions(performances)}
        licences |= {one.scene.licence for one in scenes} | {a.licence for a in avatars}
        manifest = writer.finish(
            name=plan.name,
            recipe=plan.name,
            seed=plan.seed,
            code_version=affectsim_data.__version__,
            camera=plan.camera,
            robot=plan.robot,
            licences=sorted(licences - {""}),
            redistribution=plan.redistribution,
            sources=plan.sources,
            recipe_toml=plan.path.read_text(encoding="utf-8"),
        )
    shortfalls = tuple(Shortfall(**row) for row in cells if row["composed"] < row["planned"])
    return BuildReport(manifest, shortfalls, cast, scenes, failed)


def _build_scenes(
    recipe: Recipe, source: Path | None, jobs: int, *, skip_broken: bool
) -> tuple[tuple[BuiltScene, ...], tuple[FailedScene, ...]]:
    """All scenes of a recipe; raises if some cannot be used and may not be skipped."""
    build = functools.partial(build_scene, recipe=recipe, folder=source)
    results = list(run_parallel(build, scene_sources(recipe, source), jobs, "scenes", recipe.name))
    built = tuple(result for result in results if isinstance(result, BuiltScene))
    failed = tuple(result for result in results if isinstance(result, FailedScene))
    if failed and (not skip_broken or not built):
        hint = "mend them, exclude them in the recipe, or add --skip-broken to build without them"
        if recipe.scenes.kind == "habitat" and not recipe.scenes.shell:
            hint += "; --shell builds floor and walls where a stage is missing"
        raise_problems(recipe.name, [f"{one.scene_id}: {one.reason}" for one in failed], hint=hint)
    return built, failed


def _compose(
    recipe: Recipe,
    slots: Sequence[Slot],
    scenes: Sequence[BuiltScene],
    performances: Sequence[Performance],
    jobs: int,
) -> tuple[list[Episode], list[dict[str, Any]]]:
    """The episodes of a recipe, none if it asks for none, and the rows of its cells."""
    if not recipe.compositions:
        return [], []
    rows = [scene_row(one.scene, one.navmesh) for one in scenes]
    stored = {row["scene_id"]: (row["glb"], row["navmesh"]) for row in rows}
    by_motion = {one.motion.motion_id: one for one in performances}
    run = functools.partial(run_parallel, jobs=jobs, what="episodes", name=recipe.name)
    episodes, unplaced = compose_slots(slots, stored, by_motion, recipe, run)
    if not episodes:
        raise ValueError(f"{recipe.path}: no episode could be composed; see the thresholds")
    return _number(episodes, recipe), _cells(slots, by_motion, unplaced)


def _cells(
    slots: Sequence[Slot], performances: Mapping[str, Performance], unplaced: Sequence[Unplaced]
) -> list[dict[str, Any]]:
    """Rows of the cells table."""
    emotion_of = {key: one.motion.emotion for key, one in performances.items()}
    planned = planned_counts(slots, emotion_of)
    reasons = {one.key: one.constraint for one in unplaced}
    lacking = [slot for slot in slots if slot.key in reasons]
    missing = planned_counts(lacking, emotion_of)
    constraints: dict[CellKey, Counter[str]] = {}
    for slot in lacking:
        for cell in planned_counts([slot], emotion_of):
            constraints.setdefault(cell, Counter())[reasons[slot.key]] += 1
    names = ("split", "family", "challenge", "action", "emotion")
    return [
        dict(zip(names, cell, strict=True))
        | {"planned": count, "composed": count - missing.get(cell, 0)}
        | {
            "binding_constraint": constraints[cell].most_common(1)[0][0]
            if cell in missing
            else None
        }
        for cell, count in sorted(planned.items(), key=lambda item: tuple(map(str, item[0])))
    ]


def _check_cast(recipe: Recipe, cast: Cast, *, skip_broken: bool) -> None:
    """Raises if files could not be read and may not be skipped, or if no motion is left."""
    if cast.failures and not skip_broken:
        problems = [failure.reason for failure in cast.failures]
        hint = "mend or remove them, or add --skip-broken to build without them"
        raise_problems(recipe.name, problems, hint=hint)
    if recipe.compositions and not cast.performances:
        reasons = [
            f"{motion.motion_id}: {finding.reason}"
            for motion in cast.rejected
            for finding in cast.screening.failed(motion.motion_id)[:1]
        ]
        raise_problems(f"{recipe.name}: no motion passed the screening", reasons or ["none read"])


def _number(episodes: list[Episode], recipe: Recipe) -> list[Episode]:
    """Orders and names the episodes of each split: scene by scene, shuffled within a scene.

    Scene by scene, so that reading a split in order, or a part of it, needs few scenes at a time;
    shuffled, so that no name tells an emotion.
    """
    rng = np.random.default_rng([recipe.seed, 3])
    numbered = []
    for split in SPLITS:
        members = [episode for episode in episodes if episode.split == split]
        shuffled = [members[index] for index in rng.permutation(len(members))]
        for place, episode in enumerate(sorted(shuffled, key=lambda one: one.scene_id)):
            episode_id = f"{recipe.name}/{split}-{place:05d}"
            numbered.append(dataclasses.replace(episode, episode_id=episode_id))
    return numbered


def _motions(performances: Sequence[Performance]) -> list[Motion]:
    motions = []
    for performance in performances:
        motions.append(performance.motion)
        if performance.partner is not None:
            motions.append(performance.partner[0])
    return motions


def _write_tables(
    writer: ReleaseWriter,
    episodes: Sequence[Episode],
    performances: Sequence[Performance],
    scenes: Sequence[BuiltScene],
    avatars: Sequence[Avatar],
) -> None:
    for split in SPLITS:
        rows = [episode.to_row() for episode in episodes if episode.split == split]
        writer.add_table("episodes", rows, stem=split)
    motions = _motions(performances)
    repeated = [key for key, n in Counter(motion.motion_id for motion in motions).items() if n > 1]
    if repeated:
        raise ValueError(f"motion ids repeat: {', '.join(sorted(repeated)[:10])}")
    writer.add_table("motions", [motion_row(motion) for motion in motions])
    writer.add_table("scenes", [scene_row(one.scene, one.navmesh) for one in scenes])
    writer.add_table("avatars", [avatar_row(avatar) for avatar in avatars])
