"""Validates a release: its tables at once, its episodes scene by scene on several processes."""

from __future__ import annotations

import functools
import os
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pyarrow as pa

from affectsim_data.builders.processes import run_parallel
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.validation.bodies import check_bodies
from affectsim_data.builders.validation.cameras import check_cameras
from affectsim_data.builders.validation.catalogue import CHECKS
from affectsim_data.builders.validation.challenges import check_challenges
from affectsim_data.builders.validation.clips import check_clips
from affectsim_data.builders.validation.counts import check_counts
from affectsim_data.builders.validation.files import check_files
from affectsim_data.builders.validation.findings import Measure, gather
from affectsim_data.builders.validation.navigation import check_navigation
from affectsim_data.builders.validation.part import Part, read_part
from affectsim_data.builders.validation.partitions import check_partitions
from affectsim_data.builders.validation.quality import (
    ReferenceQuality,
    check_leakage,
    check_quality,
    reference_quality,
)
from affectsim_data.builders.validation.references import check_references
from affectsim_data.builders.validation.report import ValidationReport
from affectsim_data.builders.validation.supports import check_supports
from affectsim_data.builders.validation.tables import Columns, Tables, read_tables
from affectsim_data.builders.validation.tracks import Bodies
from affectsim_data.builders.validation.trajectories import check_trajectories
from affectsim_data.errors import IntegrityError
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.stores import open_store
from affectsim_data.schemas import ASSET_TABLES

__all__ = ["SAMPLE", "check_part", "check_tables", "recipe_inside", "validate_release"]

SAMPLE = 300
"""Episodes of which d* is measured again, if not said otherwise."""
_SAMPLE_SEED = 20260826
_AT_ONCE = 512
"""Episodes of a scene that are looked at together: some 100 MB of rays."""
_UNREADABLE = (KeyError, ValueError, OSError, IntegrityError)


def validate_release(
    source: str | Path = "mini", *, sample: int | None = SAMPLE, jobs: int | None = None
) -> ValidationReport:
    """Makes every check on a release.

    Args:
        source: `mini`, a folder, or `hf://datasets/ORG/NAME@REVISION`.
        sample: Episodes of which d* is measured again; all if `None`.
        jobs: Processes; one per core if not given.

    Raises:
        FileNotFoundError: No release there, or files of it are missing.
        ValueError: A malformed address or manifest, or `sample` below 0.
    """
    if sample is not None and sample < 0:
        raise ValueError(f"sample must be a number of episodes from 0, or all, got {sample}")
    store = open_store(open_release(source).uri)
    # A scene at a time: those before it are never asked for again.
    release = Release(store, scenes_kept=1)
    measures = check_files(store)
    recipe, problem = recipe_inside(release)
    try:
        tables = read_tables(release, store, recipe, problem)
    except _UNREADABLE as error:
        skipped = f"its tables cannot be read, so nothing else was checked: {error}"
        return _report(release.uri, 0, measures, skipped)
    measures += [*check_tables(tables), *check_trajectories(release, tables)]
    found, quality = _check_scenes(release, tables, recipe, sample, jobs or os.cpu_count() or 1)
    measures += [*found, *check_quality(quality), *check_leakage(tables.episodes.table)]
    return _report(release.uri, len(tables.episodes), measures)


def _report(
    uri: str, count: int, measures: Sequence[Measure], skipped: str = ""
) -> ValidationReport:
    outcomes = tuple(
        gather(check, [measure for measure in measures if measure.check == name])
        for name, check in CHECKS.items()
    )
    return ValidationReport(uri, count, outcomes, skipped)


def recipe_inside(release: Release) -> tuple[Recipe | None, str]:
    """The recipe a manifest holds, or why it cannot be read."""
    text = release.manifest.recipe_toml
    if not text:
        return None, "the manifest holds no recipe"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{release.manifest.recipe}.toml"
        path.write_text(text, encoding="utf-8")
        try:
            return read_recipe(path), ""
        except (ValueError, OSError) as error:
            return None, str(error).replace(str(path), "the manifest's recipe_toml")


def check_tables(tables: Tables) -> list[Measure]:
    """Every check that needs no asset but the tables."""
    return [
        *check_references(tables),
        *check_counts(tables),
        *check_partitions(tables),
        *check_clips(tables),
    ]


def _check_scenes(
    release: Release, tables: Tables, recipe: Recipe | None, sample: int | None, jobs: int
) -> tuple[list[Measure], list[ReferenceQuality]]:
    """The geometric checks, scene by scene."""
    task = functools.partial(_check_scene, release=release, bodies=Bodies(release), recipe=recipe)
    measures: list[Measure] = []
    quality: list[ReferenceQuality] = []
    work = _work(tables, _sampled(tables, sample))
    for found, views in run_parallel(task, work, jobs, "scenes", release.manifest.name):
        measures += found
        quality += views
    measures += _unused(release, tables)
    readable = [measure for measure in measures if measure.check == "assets_readable"]
    others = [measure for measure in measures if measure.check != "assets_readable"]
    return [_once(readable), *others], quality


_Work = tuple[pa.Table, frozenset[str]]


def _work(tables: Tables, sampled: frozenset[str]) -> list[_Work]:
    """Episodes by scene, not too many at once, and which of them are in the sample."""
    scenes = tables.episodes.text("scene_id").astype(str)
    known = set(tables.assets["scenes"].text("scene_id"))
    work: list[_Work] = []
    for scene_id in sorted(known & set(scenes)):
        rows = np.flatnonzero(scenes == scene_id)
        for low in range(0, len(rows), _AT_ONCE):
            chosen = rows[low : low + _AT_ONCE]
            ids = frozenset(tables.episode_ids[chosen]) & sampled
            work.append((tables.episodes.table.take(pa.array(chosen)), ids))
    return work


def _sampled(tables: Tables, sample: int | None) -> frozenset[str]:
    ids = tables.episode_ids
    if sample is None or sample >= len(ids):
        return frozenset(ids)
    rng = np.random.default_rng(_SAMPLE_SEED)
    return frozenset(ids[rng.permutation(len(ids))[:sample]])


def _check_scene(
    work: _Work, *, release: Release, bodies: Bodies, recipe: Recipe | None
) -> tuple[list[Measure], list[ReferenceQuality]]:
    table, sampled = work
    part, measures = read_part(release, bodies, Columns(table), recipe, sampled)
    if part is None:
        return measures, []
    return measures + check_part(part), [reference_quality(part)]


def check_part(part: Part) -> list[Measure]:
    """Every geometric check of some episodes of a scene."""
    return [
        *check_navigation(part),
        *check_bodies(part),
        *check_supports(part),
        *check_challenges(part),
        *check_cameras(part),
    ]


def _unused(release: Release, tables: Tables) -> list[Measure]:
    """Whether assets that no episode names can be read."""
    episodes = tables.episodes
    columns = {
        "motions": ("motion_id", "partner_motion_id"),
        "scenes": ("scene_id",),
        "avatars": ("avatar_id", "partner_avatar_id"),
    }
    readers = {"motions": release.motion, "scenes": release.scene, "avatars": release.avatar}
    notes: dict[str, str] = {}
    for table in ASSET_TABLES:
        used = {one for name in columns[table] for one in episodes.text(name)}
        key = tables.assets[table].table.column_names[0]
        for asset_id in tables.assets[table].text(key):
            if asset_id not in used:
                notes[asset_id] = _problem(readers[table], asset_id)
    return [
        Measure.of(
            "assets_readable", notes, _flags(notes.values()), high=0, notes=tuple(notes.values())
        )
    ]


def _problem(read: object, asset_id: str) -> str:
    assert callable(read)
    try:
        read(asset_id)
    except _UNREADABLE as error:
        return str(error)
    return ""


def _flags(notes: Iterable[str]) -> list[float]:
    return [float(bool(note)) for note in notes]


def _once(measures: Sequence[Measure]) -> Measure:
    """Assets that several scenes ask for, each once."""
    notes: dict[str, str] = {}
    for measure in measures:
        notes |= dict(zip(measure.items, measure.notes, strict=True))
    values = tuple(notes.values())
    return Measure.of("assets_readable", notes, _flags(values), high=0, notes=values)
