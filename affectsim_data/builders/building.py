"""Builds a release from a recipe: assets, episodes, shards, manifest."""

from __future__ import annotations

import dataclasses
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from tqdm import tqdm

import affectsim_data
from affectsim_data.avatars import Avatar
from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.casting import Cast
from affectsim_data.builders.cells import Shortfall, cell_rows, shortfalls
from affectsim_data.builders.checkpoints import Checkpoints, staging_folder
from affectsim_data.builders.corpus_scan import raise_problems
from affectsim_data.builders.fingerprints import build_fingerprint
from affectsim_data.builders.fitting import fitted, with_unmet
from affectsim_data.builders.inventory import check_inventory
from affectsim_data.builders.measuring import Performance
from affectsim_data.builders.metering import Meter, StageCost
from affectsim_data.builders.placement import Unplaced
from affectsim_data.builders.processes import PRELOADED
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.scene_sources import FailedScene
from affectsim_data.builders.slots import Slot, make_slots
from affectsim_data.builders.sources import SourceGiven
from affectsim_data.builders.stages import (
    SceneShelf,
    StageRunner,
    StoredScene,
    compose_slots,
    make_performances,
    make_scenes,
)
from affectsim_data.builders.units import Rows
from affectsim_data.engines import EngineName, open_engine
from affectsim_data.motions import Motion
from affectsim_data.releases import Manifest, ReleaseWriter
from affectsim_data.releases.rows import avatar_row, motion_row
from affectsim_data.schemas import SPLITS

__all__ = ["BuildReport", "Shortfall", "build_release"]


@dataclasses.dataclass(frozen=True)
class BuildReport:
    """What was built, and what could not be."""

    manifest: Manifest
    shortfalls: tuple[Shortfall, ...]
    """Cells with fewer episodes than the recipe asks for."""
    cast: Cast
    """Who performs, and what screening said of the motions."""
    scenes: tuple[StoredScene, ...]
    """The scenes, with what became of what they were made from."""
    failed_scenes: tuple[FailedScene, ...]
    """Scenes that could not be used."""
    costs: tuple[StageCost, ...]
    """Units, time and memory of each stage."""


def build_release(
    recipe: str | Path,
    out: Path,
    *,
    source: SourceGiven = None,
    jobs: int | None = None,
    overwrite: bool = False,
    screen_report: Path | None = None,
    skip_broken: bool = False,
    shell: bool = False,
    engine: EngineName = "local",
    ray_address: str | None = None,
    dress: Callable[[Path], None] = lambda _: None,
) -> BuildReport:
    """Builds a release; the same recipe gives the same bytes, wherever and in how many pieces.

    What is done is kept in `.NAME.partial` beside `out`. A build that was killed or interrupted
    goes on from there when it is started again.

    Args:
        recipe: Name of a file in `builders/`, or a path.
        out: Folder of the release; appears when it is whole.
        source: Corpus, scenes or furniture of a recipe that reads some: a folder, or folders by
            name.
        jobs: Units in work at once; one per core if not given.
        overwrite: Whether `out` may hold a release already.
        screen_report: Parquet file to write with a row per motion and check; written also when the
            build fails later.
        skip_broken: Whether to leave out motions and scenes that cannot be read.
        shell: Whether imported scenes without a stage get a floor and walls.
        engine: `local` for processes of this machine, `ray` for a Ray cluster.
        ray_address: Of the cluster; none starts one on this machine.
        dress: Called with the folder of the finished release before it is moved into place.

    Raises:
        FileNotFoundError: No such recipe or source.
        FileExistsError: Something is at `out`.
        BlockingIOError: Another build writes to `out`.
        ValueError: The recipe, the corpus or an asset is broken.
    """
    plan = read_recipe(recipe)
    if shell:
        plan = plan.with_shell()
    plan, lacking = check_inventory(plan, source, skip_broken=skip_broken)
    writer = ReleaseWriter(out, overwrite=overwrite, staging=staging_folder(out) / "release")
    checkpoints = Checkpoints(out, build_fingerprint(plan, source), say=_say)
    with (
        open_engine(engine, jobs=jobs, address=ray_address, preload=PRELOADED) as workers,
        checkpoints,
        Meter() as meter,
    ):
        build = _Build(
            plan, StageRunner(workers, checkpoints, meter, plan.name), checkpoints, skip_broken
        )
        avatars = load_avatars(plan)
        with meter.stage("motions"):
            cast = make_performances(plan, avatars, source, build.run)
        if screen_report is not None:
            cast.screening.write_report(screen_report)
        build.check_cast(cast)
        asked = plan
        if skip_broken and plan.compositions:
            plan, shrunk = fitted(plan, cast.performances)
            lacking = (*lacking, *shrunk)
        for line in lacking:
            _say(line)
        slots = make_slots(plan, cast.performances)
        performances = _used(cast.performances, slots)
        with meter.stage("scenes"):
            shelf = make_scenes(plan, source, build.run)
        build.check_scenes(shelf)
        with meter.stage("episodes"):
            episodes, unplaced = build.compose(slots, shelf, performances)
            meter.count(episodes.num_rows)
        emotion_of = {one.motion.motion_id: one.motion.emotion for one in performances}
        cells = with_unmet(cell_rows(slots, emotion_of, unplaced), asked, plan)
        with meter.stage("tables"), writer:
            _write_tables(writer, episodes, cells, performances, shelf, avatars)
            licences = {one.licence for one in _motions(performances)}
            licences |= {one.licence for one in shelf.scenes} | {one.licence for one in avatars}
            manifest = _finish(writer, plan, licences - {""}, dress)
            meter.count(len(manifest.files))
    return BuildReport(
        manifest, shortfalls(cells), cast, shelf.scenes, shelf.failed, tuple(meter.costs)
    )


def _say(line: str) -> None:
    tqdm.write(line, file=sys.stderr)


@dataclasses.dataclass(frozen=True)
class _Build:
    """One build on its way."""

    recipe: Recipe
    run: StageRunner
    checkpoints: Checkpoints
    skip_broken: bool

    def check_cast(self, cast: Cast) -> None:
        """Raises if files could not be read and may not be skipped, or if no motion is left."""
        if cast.failures and not self.skip_broken:
            hint = "mend or remove them, or add --skip-broken to build without them"
            self._refuse([failure.reason for failure in cast.failures], hint)
        if self.recipe.compositions and not cast.performances:
            reasons = [
                f"{motion.motion_id}: {finding.reason}"
                for motion in cast.rejected
                for finding in cast.screening.failed(motion.motion_id)[:1]
            ]
            name = f"{self.recipe.name}: no motion passed the screening"
            raise_problems(name, reasons or ["none read"])

    def check_scenes(self, shelf: SceneShelf) -> None:
        """Raises if scenes cannot be used and may not be skipped, or if none is left."""
        if not shelf.failed or (self.skip_broken and shelf.scenes):
            return
        hint = "mend them, exclude them in the recipe, or add --skip-broken to build without them"
        if self.recipe.scenes.kind == "habitat" and not self.recipe.scenes.shell:
            hint += "; --shell builds floor and walls where a stage is missing"
        self._refuse([f"{one.scene_id}: {one.reason}" for one in shelf.failed], hint)

    def _refuse(self, problems: list[str], hint: str) -> None:
        """Raises; what could be read is kept for a run that leaves out the rest."""
        self.checkpoints.keep = not self.skip_broken
        raise_problems(self.recipe.name, problems, hint=hint)

    def compose(
        self, slots: Sequence[Slot], shelf: SceneShelf, performances: Sequence[Performance]
    ) -> tuple[pa.Table, list[Unplaced]]:
        """Rows of the episodes, none if the recipe asks for none; and slots without a place."""
        recipe = self.recipe
        if not recipe.compositions:
            return Rows.of("episodes", []).arrow, []
        episodes, unplaced = compose_slots(slots, shelf, performances, recipe, self.run)
        if not episodes.num_rows:
            raise ValueError(f"{recipe.path}: no episode could be composed; see the thresholds")
        return _numbered(episodes, recipe), unplaced


def _used(performances: Sequence[Performance], slots: Sequence[Slot]) -> list[Performance]:
    """The performances of some slots.

    Raises:
        ValueError: Motion ids repeat.
    """
    used = {motion_id for slot in slots for motion_id in slot.motion_ids}
    chosen = [one for one in performances if one.motion.motion_id in used]
    counts = Counter(motion.motion_id for motion in _motions(chosen))
    if repeated := sorted(key for key, count in counts.items() if count > 1):
        raise ValueError(f"motion ids repeat: {', '.join(repeated[:10])}")
    return chosen


def _numbered(episodes: pa.Table, recipe: Recipe) -> pa.Table:
    """Orders and names the episodes of each split: scene by scene, shuffled within a scene.

    Scene by scene, so that reading a split in order, or a part of it, needs few scenes at a time;
    shuffled, so that no name tells an emotion.
    """
    rng = np.random.default_rng([recipe.seed, 3])
    split_of, scene_of = (episodes.column(name).to_numpy() for name in ("split", "scene_id"))
    rows, names = [], []
    for split in SPLITS:
        members = np.flatnonzero(split_of == split)
        shuffled = members[rng.permutation(len(members))]
        rows.append(shuffled[np.argsort(scene_of[shuffled], kind="stable")])
        names += [f"{recipe.name}/{split}-{place:05d}" for place in range(len(members))]
    ordered = episodes.take(np.concatenate(rows))
    place = ordered.schema.get_field_index("episode_id")
    return ordered.set_column(place, ordered.schema.field(place), pa.array(names, pa.string()))


def _motions(performances: Sequence[Performance]) -> list[Motion]:
    motions = []
    for performance in performances:
        motions.append(performance.motion)
        if performance.partner is not None:
            motions.append(performance.partner[0])
    return motions


def _write_tables(
    writer: ReleaseWriter,
    episodes: pa.Table,
    cells: Sequence[dict[str, Any]],
    performances: Sequence[Performance],
    shelf: SceneShelf,
    avatars: Sequence[Avatar],
) -> None:
    for split in SPLITS:
        writer.add_table("cells", [row for row in cells if row["split"] == split], stem=split)
        writer.add_table("episodes", episodes.filter(pc.field("split") == split), stem=split)
    motions = _motions(performances)
    rows = (Rows.of("motions", [motion_row(motion)]).arrow for motion in motions)
    writer.add_assets("motions", rows, count=len(motions))
    writer.add_assets("scenes", shelf.rows(), count=len(shelf.scenes))
    writer.add_table("avatars", [avatar_row(avatar) for avatar in avatars])


def _finish(
    writer: ReleaseWriter, recipe: Recipe, licences: set[str], dress: Callable[[Path], None]
) -> Manifest:
    return writer.finish(
        name=recipe.name,
        recipe=recipe.name,
        seed=recipe.seed,
        code_version=affectsim_data.__version__,
        camera=recipe.camera,
        robot=recipe.robot,
        licences=sorted(licences),
        redistribution=recipe.redistribution,
        sources=recipe.sources,
        recipe_toml=recipe.path.read_text(encoding="utf-8"),
        dress=dress,
    )
