"""No leakage: nothing but the motion may depend on the emotion.

What a placement shares is equal in all its emotions, exactly; the rest is random, so a classifier
stays near chance. The probe is first shown releases that do leak, and finds how.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest
from inventories import asked_for

from affectsim_data.builders.building import build_release
from affectsim_data.builders.leakage import PLACEMENT_COLUMNS, leakage_probe
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.builders.slots import make_slots
from affectsim_data.content import content_path
from affectsim_data.motions import EMOTIONS
from affectsim_data.releases import Release, open_release
from affectsim_data.schemas import SCHEMAS, SPLITS

Row = dict[str, Any]
FOLLOWING_THE_MOTION = {
    *("emotion", "motion_id", "partner_motion_id", "group_id", "source"),
    *("phase_s", "duration_s", "initial_bearing_deg"),
    *("visible_share_init", "visible_share_ref", "visible_share_mon"),
}
NAMES_AND_CONSTANTS = {
    *("episode_id", "placement_id", "navmesh_sha256", "agent_radius_m"),
    *("recipe", "seed", "code_version", "schema_version"),
}


def episodes_of(release: Release) -> pa.Table:
    return pa.concat_tables([release.episode_table(split) for split in SPLITS])


@functools.cache
def imagined(leak: Callable[[Row, np.random.Generator], None] | None = None) -> pa.Table:
    """Episodes of the slots of `full`, one in fourteen, placed by chance.

    Args:
        leak: Changes a row by its emotion, as a careless composer would.
    """
    recipe = read_recipe("full")
    there = asked_for(recipe)
    motions = {one.motion.motion_id: one.motion for one in there}
    people = sorted({motion.performer_id for motion in motions.values()})
    rng = np.random.default_rng(1)
    fields = {field.name: field for field in SCHEMAS["episodes"]}
    rows: list[Row] = []
    for slot in make_slots(recipe, there)[::14]:
        shared: Row = {
            name: float(rng.uniform(-5.0, 5.0)) if pa.types.is_floating(fields[name].type) else None
            for name in (*PLACEMENT_COLUMNS, *fields)
        }
        shared |= {"placement_id": slot.key, "split": slot.split, "family": slot.family}
        shared |= {"challenge": slot.challenge, "action": slot.action}
        shared["scene_id"] = f"home_{rng.integers(57)}"
        for name in slot.motion_ids:
            own: Row = {"emotion": motions[name].emotion, "duration_s": float(rng.uniform(2, 9))}
            own["phase_s"] = float(rng.random()) * own["duration_s"]
            own["reference_azimuth_deg"] = float(rng.uniform(-180.0, 180.0))
            own["performer_id"] = motions[name].performer_id
            own["avatar_id"] = f"avatar_{people.index(motions[name].performer_id) % 8}"
            own["episode_id"] = f"full/{slot.split}-{rng.integers(20_000):05d}"
            rows.append(shared | own)
            if leak is not None:
                leak(rows[-1], rng)
    schema = pa.schema([field.with_nullable(True) for field in fields.values()])
    return pa.Table.from_pylist(rows, schema)


def assert_placements_are_even(table: pa.Table) -> None:
    """Episodes of a placement differ in emotion, and in nothing that a placement shares."""
    anything = pc.CountOptions(mode="all")
    asked = [(name, "count_distinct", anything) for name in (*PLACEMENT_COLUMNS, "emotion")]
    asked.append(("episode_id", "count_distinct", anything))
    counts = table.group_by("placement_id").aggregate(asked)
    for name in PLACEMENT_COLUMNS:
        assert pc.max(counts[f"{name}_count_distinct"]).as_py() == 1, name
    assert counts["emotion_count_distinct"] == counts["episode_id_count_distinct"]


def test_every_column_is_known_to_follow_the_motion_or_the_place() -> None:
    """Who adds a column says here what it may depend on."""
    columns = {field.name for field in SCHEMAS["episodes"]}
    reference = {name for name in columns if name.startswith("reference_")}
    parts = [set(PLACEMENT_COLUMNS), FOLLOWING_THE_MOTION, reference, NAMES_AND_CONSTANTS]
    assert set.union(*parts) == columns
    assert sum(map(len, parts)) == len(columns)


def test_random_placements_of_matched_motions_tell_nothing() -> None:
    table = imagined()
    probes = leakage_probe(table)
    assert len(probes) == 4
    for name, probe in probes.items():
        assert probe.num_train + probe.num_tested == table.num_rows
        assert probe.chance == 0.2
        assert probe.standard_error == pytest.approx(np.sqrt(0.16 / probe.num_tested), rel=0.01)
        assert abs(probe.excess) <= 3.0 * probe.standard_error, name


def turned_away(row: Row, rng: np.random.Generator) -> None:
    if row["emotion"] == "sad":
        row["facing_deg"] = float(rng.normal(90.0, 20.0))


def cast_by_emotion(row: Row, rng: np.random.Generator) -> None:
    if row["emotion"] == "angry" and rng.random() < 0.5:
        row["avatar_id"] = "avatar_3"


def in_label_order(row: Row, rng: np.random.Generator) -> None:
    place = 4000 * EMOTIONS.index(row["emotion"]) + int(rng.integers(6000))
    row["episode_id"] = f"full/{row['split']}-{place:05d}"


def seen_from_a_side(row: Row, rng: np.random.Generator) -> None:
    if row["emotion"] == "fearful":
        row["reference_azimuth_deg"] = float(rng.normal(60.0, 15.0))


@pytest.mark.parametrize(
    ("leak", "views"),
    [
        (turned_away, "placement"),
        (cast_by_emotion, "placement"),
        (in_label_order, "placement"),
        (seen_from_a_side, "placement and reference"),
    ],
)
def test_planted_leaks_are_found(leak: Callable[..., None], views: str) -> None:
    probes = leakage_probe(imagined(leak))
    found = [probe for probe in probes.values() if probe.features == views]
    assert max(probe.excess for probe in found) > 0.03 + 3.0 * found[0].standard_error
    if views != "placement":
        blind = [probe for probe in probes.values() if probe.features == "placement"]
        assert max(probe.excess for probe in blind) < 0.03


def test_probe_needs_two_splits_and_two_emotions() -> None:
    table = imagined().slice(0, 40)
    with pytest.raises(ValueError, match=r"needs episodes of two emotions.*got 40 of 40 in train"):
        leakage_probe(table)


def assert_nothing_leaks(table: pa.Table) -> None:
    """Within 3 points of chance, or three standard errors where there are few episodes.

    The reference view is made for the motion; what it tells is reported by the probe, not bounded.
    """
    assert_placements_are_even(table)
    for name, probe in leakage_probe(table).items():
        if probe.features == "placement":
            assert abs(probe.excess) <= max(0.03, 3.0 * probe.standard_error), name


def test_built_in_release_tells_nothing() -> None:
    assert_nothing_leaks(episodes_of(open_release("mini")))


@pytest.mark.slow
@pytest.mark.timeout(600)
def test_small_release_tells_nothing(tmp_path: Path) -> None:
    """With as many unseen performers as `small`, in fewer homes and with less to train on."""
    recipe = content_path("builders", "small.toml").read_text(encoding="utf-8")
    for asked, fewer in (("homes-small", "homes-mini"), ("= 880", "= 440"), ("= 480", "= 240")):
        assert asked in recipe
        recipe = recipe.replace(asked, fewer)
    (tmp_path / "small.toml").write_text(recipe, encoding="utf-8")
    build_release(tmp_path / "small.toml", tmp_path / "small")
    assert_nothing_leaks(episodes_of(open_release(tmp_path / "small")))
