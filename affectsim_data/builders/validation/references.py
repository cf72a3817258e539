"""Whether rows agree with each other: identifiers, references, and what is stored twice."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.tables import Tables
from affectsim_data.episodes import Episode
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Manifest
from affectsim_data.schemas import (
    ASSET_TABLES,
    CHALLENGES,
    FAMILIES,
    SCHEMA_VERSION,
    SPLITS,
    AssetTable,
)

__all__ = ["check_references"]

_REFERENCES: tuple[tuple[str, AssetTable], ...] = (
    ("scene_id", "scenes"),
    ("motion_id", "motions"),
    ("avatar_id", "avatars"),
    ("partner_motion_id", "motions"),
    ("partner_avatar_id", "avatars"),
)
_OF_MOTION = ("performer_id", "emotion", "action", "duration_s", "source")
_OF_PARTNER = (("partner_performer_id", "performer_id"),)
_OF_SCENE = ("navmesh_sha256", "agent_radius_m")
_WORDS: dict[str, tuple[str | None, ...]] = {
    "split": SPLITS,
    "scene_split": SPLITS,
    "family": FAMILIES,
    "emotion": EMOTIONS,
    "challenge": (*CHALLENGES, None),
}


def check_references(tables: Tables) -> list[Measure]:
    """Identifiers, references, agreement of copies, and words of every episode."""
    return [
        _rows_readable(tables),
        _ids_unique(tables),
        _index_agrees(tables),
        _references(tables),
        _motion_agrees(tables),
        _manifest_agrees(tables),
        _words(tables),
        _recipe(tables),
        _licences(tables),
    ]


def _counted(
    check: str, tables: Tables, wrong: dict[str, NDArray[np.bool_]], *, items: Iterable[str] = ()
) -> Measure:
    """How many columns of each episode are wrong, and which."""
    ids = tuple(items) or tuple(tables.episode_ids)
    table = np.stack(list(wrong.values()), axis=1)
    names = np.array(list(wrong))
    notes = [", ".join(names[row]) if row.any() else "" for row in table]
    return Measure.of(check, ids, table.sum(axis=1), high=0, notes=notes)


def _rows_readable(tables: Tables) -> Measure:
    notes = []
    for row in tables.episodes.table.to_pylist():
        try:
            Episode.from_row(row)
        except (ValueError, TypeError) as error:
            notes.append(str(error))
        else:
            notes.append("")
    values = [float(bool(note)) for note in notes]
    return Measure.of("rows_readable", tables.episode_ids, values, high=0, notes=notes)


def _ids_unique(tables: Tables) -> Measure:
    counts = Counter(tables.episode_ids)
    return Measure.of("ids_unique", counts, list(counts.values()), high=1)


def _index_agrees(tables: Tables) -> Measure:
    episodes, index = tables.episodes, tables.index
    if len(index) != len(episodes):
        return Measure.of("index_agrees", ["index"], [abs(len(index) - len(episodes))], high=0)
    names = [name for name in index.table.column_names if name != "target"]
    wrong = {name: episodes.text(name) != index.text(name) for name in names}
    wrong["target"] = episodes.number("target") != index.number("target")
    return _counted("index_agrees", tables, wrong)


def _references(tables: Tables) -> Measure:
    wrong = {}
    for name, table in _REFERENCES:
        ids = tables.episodes.text(name)
        given = np.array([one is not None for one in ids], bool)
        wrong[name] = given & (tables.rows_of(table, ids) < 0)
    families = tables.episodes.text("family")
    partner = np.array([one is not None for one in tables.episodes.text("partner_motion_id")], bool)
    wrong["a partner in dyads alone"] = partner != (families == "dyadic")
    return _counted("references", tables, wrong)


def _motion_agrees(tables: Tables) -> Measure:
    """What an episode inherits from its motions and its scene; unresolved ones are left out."""
    wrong: dict[str, NDArray[np.bool_]] = {}
    episodes = tables.episodes
    plain = tuple((name, name) for name in _OF_MOTION)
    links: tuple[tuple[str, AssetTable, tuple[tuple[str, str], ...]], ...] = (
        ("motion_id", "motions", plain),
        ("partner_motion_id", "motions", _OF_PARTNER),
        ("scene_id", "scenes", tuple((name, name) for name in _OF_SCENE)),
    )
    for key, table, columns in links:
        rows = tables.rows_of(table, episodes.text(key))
        for mine, theirs in columns:
            values = tables.assets[table].text(theirs)
            there = np.array([values[row] if row >= 0 else None for row in rows], object)
            wrong[mine] = (rows >= 0) & (episodes.text(mine) != there)
    wrong["group_id"] = _group_wrong(tables)
    return _counted("motion_agrees", tables, wrong)


def _group_wrong(tables: Tables) -> NDArray[np.bool_]:
    """Whether a group is neither the motion's nor, in action-grounded episodes, the performer."""
    episodes = tables.episodes
    rows = tables.rows_of("motions", episodes.text("motion_id"))
    groups = tables.assets["motions"].text("group_id")
    group = np.array([groups[row] if row >= 0 else None for row in rows], object)
    grounded = episodes.text("family") == "action_grounded"
    expected = np.where(grounded, episodes.text("performer_id"), group)
    return np.asarray((rows >= 0) & (episodes.text("group_id") != expected), bool)


def _manifest_agrees(tables: Tables) -> Measure:
    manifest: Manifest = tables.manifest
    expected: dict[str, object] = {
        "recipe": manifest.recipe,
        "seed": manifest.seed,
        "code_version": manifest.code_version,
        "schema_version": manifest.schema_version,
        "agent_radius_m": manifest.robot.radius_m,
    }
    wrong = {name: tables.episodes.text(name) != value for name, value in expected.items()}
    return _counted("manifest_agrees", tables, wrong)


def _words(tables: Tables) -> Measure:
    episodes = tables.episodes
    wrong = {
        name: ~np.isin(episodes.text(name).astype(str), [str(word) for word in words])
        for name, words in _WORDS.items()
    }
    given = np.array([one is not None for one in episodes.text("challenge")], bool)
    wrong["challenge without its family"] = given != (
        episodes.text("family") == "observation_controlled"
    )
    return _counted("words", tables, wrong)


def _recipe(tables: Tables) -> Measure:
    """Whether the recipe inside is the one the manifest names."""
    problems = [tables.recipe_problem]
    if tables.recipe is not None:
        for field in ("name", "seed"):
            mine = getattr(tables.manifest, "recipe" if field == "name" else field)
            if getattr(tables.recipe, field) != mine:
                problems.append(f"{field} is {getattr(tables.recipe, field)!r}, not {mine!r}")
    if tables.manifest.schema_version != SCHEMA_VERSION:
        problems.append(f"schema is {tables.manifest.schema_version}, not {SCHEMA_VERSION}")
    found = [problem for problem in problems if problem]
    return Measure.of("recipe", ["manifest"], [len(found)], high=0, notes=["; ".join(found)])


def _licences(tables: Tables) -> Measure:
    """Whether the manifest names the licence of every asset."""
    named = set(tables.manifest.licences) | {""}
    lacking = [sorted(set(tables.assets[one].text("licence")) - named) for one in ASSET_TABLES]
    notes = [", ".join(map(str, words)) for words in lacking]
    return Measure.of("licences", ASSET_TABLES, [len(one) for one in lacking], high=0, notes=notes)
