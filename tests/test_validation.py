"""Validation: what is composed passes every check, and every check catches what it is for."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from broken_releases import (
    Row,
    changed_part,
    failed,
    rewrite_file,
    with_rows,
    with_table,
)
from small_release import write_release

from affectsim_data.affordances import same_room
from affectsim_data.builders.validation import CHECKS, Measure, validate_release
from affectsim_data.builders.validation.counts import check_counts
from affectsim_data.builders.validation.findings import gather
from affectsim_data.builders.validation.part import Part, read_part
from affectsim_data.builders.validation.quality import ReferenceQuality, check_quality
from affectsim_data.builders.validation.report import ValidationReport
from affectsim_data.builders.validation.tables import Tables, read_tables
from affectsim_data.builders.validation.tracks import Bodies
from affectsim_data.builders.validation.validating import check_part, check_tables, recipe_inside
from affectsim_data.poses import transform_points
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.stores import open_store
from affectsim_data.schemas import array_columns, read_array

Change = Callable[[Row], None]


@pytest.fixture(scope="module")
def release() -> Release:
    """The built-in release."""
    return open_release("mini")


@pytest.fixture(scope="module")
def tables(release: Release) -> Tables:
    """Its tables."""
    return read_tables(release, open_store(release.uri), *recipe_inside(release))


@pytest.fixture(scope="module")
def bodies(release: Release) -> Bodies:
    """Its bodies, shared by the tests."""
    return Bodies(release)


@pytest.fixture
def part_of(release: Release, tables: Tables, bodies: Bodies) -> Callable[..., Part]:
    """The first episode of which some columns say so."""

    def get(**wanted: str) -> Part:
        mask = np.ones(len(tables.episodes), bool)
        for name, value in wanted.items():
            mask &= tables.episodes.text(name) == value
        first = np.zeros(len(mask), bool)
        first[np.argmax(mask)] = mask.any()
        episodes, ids = tables.episodes.where(first), frozenset(tables.episode_ids)
        part, _ = read_part(release, bodies, episodes, tables.recipe, ids)
        assert part is not None
        return part

    return get


@pytest.fixture(scope="module")
def report() -> ValidationReport:
    """What validation says of the built-in release."""
    return validate_release("mini", sample=None, jobs=1)


def test_built_in_release_passes_every_check(report: ValidationReport) -> None:
    assert not report.failures
    assert report.holds
    assert [outcome.check.name for outcome in report.outcomes] == list(CHECKS)
    made = {outcome.check.name: outcome.checked for outcome in report.outcomes}
    assert made["share_ref"] == made["d_star"] == report.num_episodes > 100
    assert report.lines()[-1].startswith("valid: all ")


def first(**values: Any) -> Callable[[list[Row]], None]:
    """Changes columns of the first row."""

    def change(rows: list[Row]) -> None:
        rows[0].update(values)

    return change


def of_family(family: str, **values: Any) -> Callable[[list[Row]], None]:
    """Changes columns of the first row of a family."""

    def change(rows: list[Row]) -> None:
        next(row for row in rows if row["family"] == family).update(values)

    return change


def drop_first(rows: list[Row]) -> None:
    del rows[0]


def same_id(rows: list[Row]) -> None:
    rows[1]["episode_id"] = rows[0]["episode_id"]


def train_in_test(rows: list[Row]) -> None:
    """Puts all episodes of a placement of train into test; its performer stays in train, too."""
    moved = next(
        row["placement_id"]
        for row in rows
        if (row["split"], row["family"]) == ("train", "action_grounded")
    )
    for row in rows:
        if row["placement_id"] == moved:
            row["split"] = "test"


def other_scene_split(rows: list[Row]) -> None:
    for row in rows:
        if row["placement_id"] == rows[0]["placement_id"]:
            row["scene_split"] = "test" if row["scene_split"] == "train" else "train"


def own_groups(rows: list[Row]) -> None:
    """Hides behind new group names that a performer is in two splits."""
    train_in_test(rows)
    for row in rows:
        row["group_id"] = f"{row['split']} {row['group_id']}"


def repeated_emotion(rows: list[Row]) -> None:
    """Gives one placement's name to another one's episode of the same emotion."""
    twin = next(row for row in rows[1:] if row["emotion"] == rows[0]["emotion"])
    columns = [name for name in twin if name not in ("episode_id", "emotion", "motion_id")]
    twin.update({name: rows[0][name] for name in columns})
    twin["motion_id"] = rows[0]["motion_id"]


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda rows: None, set()),
        (first(phase_s=-0.1), {"rows_readable", "phase"}),
        (first(phase_s=1e6), {"rows_readable", "phase"}),
        (first(reference_trajectory=b""), {"rows_readable"}),
        (same_id, {"ids_unique"}),
        (first(scene_id="nowhere"), {"references", "placements_alike"}),
        (first(motion_id="nothing"), {"references"}),
        (of_family("dyadic", partner_avatar_id="nobody"), {"references", "placements_alike"}),
        (of_family("dyadic", partner_performer_id="x"), {"motion_agrees", "placements_alike"}),
        (first(navmesh_sha256="0" * 64), {"motion_agrees"}),
        (first(duration_s=400.0), {"motion_agrees", "clip_length"}),
        (first(source="elsewhere"), {"motion_agrees"}),
        (first(seed=1), {"manifest_agrees"}),
        (first(code_version="0"), {"manifest_agrees"}),
        (
            first(scene_split="night"),
            {"rows_readable", "words", "placements_alike", "scenes_apart"},
        ),
        (of_family("action_grounded", challenge="far_visible"), {"words", "placements_alike"}),
        (first(start_yaw_deg=7.0), {"placements_alike"}),
        (first(anchor_x_m=7.0), {"placements_alike"}),
        (other_scene_split, {"scenes_apart"}),
    ],
)
def test_a_wrong_row_fails_its_check(
    tables: Tables, change: Callable[[list[Row]], None], expected: set[str]
) -> None:
    # Counts are tested below: a row that changes its cell is one too few and one too many.
    counted = {"cells_agree"}
    assert failed(check_tables(with_rows(tables, change))) - counted == expected


def test_a_split_may_not_share_what_its_family_forbids(tables: Tables) -> None:
    found = failed(check_tables(with_rows(tables, train_in_test)))
    assert found == {"groups_apart", "sources_apart", "cells_agree", "split_counts"}
    found = failed(check_tables(with_rows(tables, own_groups)))
    assert found == {"sources_apart", "motion_agrees", "cells_agree", "split_counts"}


def test_a_placement_holds_every_emotion_once(tables: Tables) -> None:
    assert "placement_emotions" in failed(check_tables(with_rows(tables, repeated_emotion)))


def test_the_index_is_a_copy_of_the_rows(tables: Tables) -> None:
    other = with_table(tables, "index", first(emotion="sad", action="hum"))
    assert failed(check_tables(other)) == {"index_agrees"}
    shorter = with_table(tables, "index", drop_first)
    assert failed(check_tables(shorter)) == {"index_agrees"}


def test_the_manifest_names_recipe_and_licences(tables: Tables) -> None:
    manifest = dataclasses.replace(tables.manifest, licences=())
    assert failed(check_tables(dataclasses.replace(tables, manifest=manifest))) == {"licences"}
    lost = dataclasses.replace(tables, recipe=None, recipe_problem="the manifest holds no recipe")
    assert failed(check_tables(lost)) == {"recipe"}
    assert tables.recipe is not None
    other = dataclasses.replace(tables.recipe, seed=5)
    assert failed(check_tables(dataclasses.replace(tables, recipe=other))) == {"recipe"}


def lack(rows: list[Row]) -> None:
    rows[0].update(composed=rows[0]["composed"] - 1, binding_constraint="a seat")


def test_counts_are_those_of_cells_and_recipe(tables: Tables) -> None:
    assert not failed(check_counts(tables))
    dropped = with_rows(tables, drop_first)
    assert failed(check_counts(dropped)) == {"cells_agree", "split_counts"}
    short = with_table(tables, "cells", lack)
    assert failed(check_counts(short)) == {"cells_agree", "cells_complete"}
    silent = with_table(tables, "cells", first(binding_constraint="for no reason"))
    assert failed(check_counts(silent)) == {"shortfalls"}


def test_planned_counts_are_the_recipes_shares(tables: Tables) -> None:
    assert tables.recipe is not None
    asked = [
        dataclasses.replace(entry, episodes={"train": 10 * len(entry.actions)})
        for entry in tables.recipe.compositions
        if entry.family == "action_grounded"
    ]
    recipe = dataclasses.replace(tables.recipe, compositions=tuple(asked))
    measure = next(
        one
        for one in check_counts(dataclasses.replace(tables, recipe=recipe))
        if one.check == "cells_planned"
    )
    walk = measure.items.index("train/action_grounded/None/simple_walk")
    assert (measure.low[walk], measure.high[walk]) == (9.0, 11.0)


def moved(**offsets: float) -> Change:
    """Adds to columns."""
    return lambda row: row.update({name: row[name] + value for name, value in offsets.items()})


def knots(change: Callable[[Any], None]) -> Change:
    """Changes the knots of the reference view."""

    def changed(row: Row) -> None:
        array = read_array(row, "reference_trajectory", where="test").copy()
        change(array)
        row.update(array_columns("reference_trajectory", array))

    return changed


def start_beside_anchor(row: Row) -> None:
    row.update({f"start_{axis}_m": row[f"anchor_{axis}_m"] for axis in "xyz"})


def low_knots(array: Any) -> None:
    array[:, 1] = 0.01


def far_knots(array: Any) -> None:
    array[:, 0] += 100.0


def open_knots(array: Any) -> None:
    array[:, 0] += np.linspace(0.0, 1.0, len(array))


WALK = {"action": "simple_walk"}
SEATED = {"action": "being_seated"}
DYAD = {"family": "dyadic"}
FAR, REAR = {"challenge": "far_visible"}, {"challenge": "rear_view"}
OCCLUDED, DETOUR = {"challenge": "partial_occlusion"}, {"challenge": "obstacle_detour"}


@pytest.mark.parametrize(
    ("where", "change", "expected"),
    [
        (WALK, moved(start_y_m=0.05), {"start_navigable"}),
        (WALK, moved(d_star_1m=1e-3), {"d_star"}),
        (WALK, lambda row: row.update(d_star_3m=None, d_star_3m_null="unreachable"), {"d_star"}),
        (DYAD, moved(partner_anchor_x_m=0.01), {"pair_place"}),
        (SEATED, lambda row: row.update(support=None), {"support_named"}),
        (SEATED, lambda row: row.update(support="seat 99"), {"support_named"}),
        (SEATED, lambda row: row.update(support="door 0"), {"support_named"}),
        (FAR, lambda row: row.update(challenge="obstacle_detour"), {"challenge_detour"}),
        (FAR, moved(start_yaw_deg=75.0), {"challenge_visible"}),
        (REAR, moved(facing_deg=180.0), {"challenge_bearing"}),
        (REAR, lambda row: row.update(challenge="far_visible"), {"challenge_distance"}),
        (WALK, moved(initial_distance_m=1e-3), {"initial_distance"}),
        (WALK, moved(initial_bearing_deg=0.1), {"initial_bearing"}),
        (WALK, moved(visible_share_init=-0.02), {"share_init"}),
        (WALK, moved(visible_share_ref=-0.02), {"share_ref"}),
        (WALK, moved(visible_share_mon=0.02), {"share_mon"}),
        (WALK, moved(monitor_x_m=30.0), {"monitor_room", "cameras_in_rooms"}),
        (WALK, knots(far_knots), {"cameras_in_rooms"}),
        (WALK, knots(open_knots), {"reference_closes"}),
    ],
)
def test_a_wrong_episode_fails_its_check(
    part_of: Callable[..., Part], where: dict[str, str], change: Change, expected: set[str]
) -> None:
    part = part_of(**where)
    assert not failed(check_part(part))
    stored = ("initial_distance", "initial_bearing", "share_", "d_star")
    keep = not next(iter(expected)).startswith(stored)
    changed = changed_part(part, change, restore=keep)
    found = failed(check_part(changed))
    # A view that is moved may end up beside something, too; what was broken must be among it.
    touched = {"clear_ref", "cameras_not_inside"} if "knots" in change.__qualname__ else set()
    assert expected <= found <= expected | touched


def test_a_start_in_the_persons_way_is_found(part_of: Callable[..., Part]) -> None:
    found = failed(check_part(changed_part(part_of(**WALK), start_beside_anchor)))
    assert {"start_clear", "challenge_distance", "clear_people"} <= found


def test_people_in_each_other_are_found(part_of: Callable[..., Part]) -> None:
    part = part_of(**DYAD)
    (partner,) = part.partner_tracks.values()
    mine = transform_points(part.pose[0], part.tracks[0].pelvis[:1])[0]
    theirs = transform_points(part.partner_pose[0], partner.pelvis[:1])[0]
    x, _, z = mine - theirs
    together = changed_part(part, moved(partner_anchor_x_m=x, partner_anchor_z_m=z))
    assert {"pair_place", "pair_apart"} <= failed(check_part(together))


def test_cameras_in_things_are_found(part_of: Callable[..., Part]) -> None:
    part = part_of(**WALK)
    ceiling = part.scene.rooms[0].ceiling_y
    high = changed_part(part, lambda row: row.update(monitor_y_m=ceiling - 0.02))
    assert failed(check_part(high)) == {"clear_mon"}
    low = failed(check_part(changed_part(part, knots(low_knots))))
    assert "clear_ref" in low
    lifted = ceiling - part.robot.camera_height_m - 0.02
    up = failed(check_part(changed_part(part, lambda row: row.update(start_y_m=lifted))))
    assert {"clear_init", "start_navigable"} <= up
    chest = next(one for one in part.scene.objects if one.category in ("cabinet", "sofa", "bed"))
    x, y, z = chest.position

    def inside(array: Any) -> None:
        array[:, :3] = (x, y + 0.15, z)

    assert "cameras_not_inside" in failed(check_part(changed_part(part, knots(inside))))


def test_bodies_in_furniture_and_off_the_floor_are_found(part_of: Callable[..., Part]) -> None:
    part = part_of(**WALK)
    table = next(one for one in part.scene.objects if "table" in one.category)

    def at_table(row: Row) -> None:
        row.update(anchor_x_m=table.position[0], anchor_z_m=table.position[2])

    assert {"body_free", "way_clear"} <= failed(check_part(changed_part(part, at_table)))


def test_sitters_sunk_into_seats_are_found(part_of: Callable[..., Part]) -> None:
    sunk = changed_part(part_of(**SEATED), moved(anchor_y_m=-0.25))
    assert {"seat_free", "body_free"} <= failed(check_part(sunk))


def test_grounded_starts_are_in_the_room(part_of: Callable[..., Part]) -> None:
    part = part_of(**WALK)
    points = part.navmesh.random_points(200, np.random.default_rng(0), island=0)
    away = points[~same_room(part.scene, points, np.repeat(part.anchor, 200, axis=0))][0]

    def elsewhere(row: Row) -> None:
        row.update({f"start_{axis}_m": float(v) for axis, v in zip("xyz", away, strict=True)})

    assert "grounded_room" in failed(check_part(changed_part(part, elsewhere)))


def test_partial_occlusion_is_by_the_scene(part_of: Callable[..., Part]) -> None:
    found = failed(check_part(changed_part(part_of(**OCCLUDED), moved(start_yaw_deg=40.0))))
    assert "challenge_in_image" in found
    free = changed_part(part_of(**REAR), lambda row: row.update(challenge="partial_occlusion"))
    assert "challenge_visible" in failed(check_part(free))


def test_a_detour_needs_a_blocked_way(part_of: Callable[..., Part]) -> None:
    part = part_of(**DETOUR)
    seen = changed_part(part_of(**WALK), lambda row: row.update(challenge="obstacle_detour"))
    assert {"challenge_blocked", "challenge_detour"} <= failed(check_part(seen))
    assert not failed(check_part(part))


def test_quality_is_a_mean_over_the_release() -> None:
    good = ReferenceQuality(np.full(9, 0.99), np.full(9, 1.0))
    assert not failed(check_quality([good]))
    assert failed(check_quality([good, ReferenceQuality(np.zeros(2), np.ones(2))])) == {
        "reference_visible"
    }
    assert failed(check_quality([good, ReferenceQuality(np.ones(1), np.zeros(1))])) == {
        "reference_middle"
    }
    assert check_quality([]) == []


def test_outcomes_name_the_worst_item_and_what_to_do() -> None:
    one = Measure.of("seat_place", ["a", "b"], [0.05, 0.3], high=0.1)
    two = Measure.of("seat_place", ["c", "d"], [np.nan, 0.1], high=[0.1, 0.1], notes=("lost", ""))
    outcome = gather(CHECKS["seat_place"], [one, two])
    assert (outcome.checked, len(outcome.failures)) == (4, 2)
    assert outcome.worst_item == "c"
    assert outcome.failures[0].message.startswith(
        "Sitting pelvis to the seat, on the plan: expected at most 0.1 m, got 0.3; "
    )
    assert "(lost)" in outcome.failures[1].message
    band = Measure.of("seat_height", ["a"], [0.2], low=-0.1, high=0.1)
    assert gather(CHECKS["seat_height"], [band]).limit == "-0.1 to 0.1"
    assert gather(CHECKS["seat_height"], []).checked == 0


def test_report_has_a_row_per_check_and_failure(tmp_path: Path, report: ValidationReport) -> None:
    broken = gather(CHECKS["phase"], [Measure.of("phase", ["e"], [2.0], low=0.0, high=1.0)])
    other = dataclasses.replace(report, outcomes=(*report.outcomes[:3], broken))
    path = tmp_path / "deep" / "report.parquet"
    assert other.write(path) == 5
    rows = pq.read_table(path).to_pylist()
    assert [row["kind"] for row in rows] == ["check"] * 4 + ["failure"]
    assert (rows[-1]["check"], rows[-1]["item"], rows[-1]["value"]) == ("phase", "e", 2.0)
    assert not other.holds
    assert other.to_json()["failures"][0]["high"] == 1.0
    assert other.lines()[-1] == "not valid: 1 of 4 checks fail"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A small release that can be broken."""
    path = tmp_path / "small"
    write_release(path)
    return path


def problems(folder: Path) -> dict[str, list[str]]:
    """Items that fail, by check; the small release is none to pass them all."""
    found: dict[str, list[str]] = {}
    for failure in validate_release(folder, sample=0, jobs=1).failures:
        found.setdefault(failure.check, []).append(failure.item)
    return found


def test_a_broken_file_is_a_failure_and_no_traceback(folder: Path) -> None:
    assert "files" not in problems(folder)
    motion = "motions/motions-00000-of-00007.parquet"
    payload = bytearray((folder / motion).read_bytes())
    payload[len(payload) // 2] ^= 255
    (folder / motion).write_bytes(payload)
    report = validate_release(folder, sample=0, jobs=1)
    assert [one.item for one in report.failures] == [motion]
    assert "SHA-256" in report.failures[0].message
    assert not report.holds
    assert report.lines()[-1].startswith("not valid: its tables cannot be read")


def test_assets_that_cannot_be_read_are_named(folder: Path) -> None:
    rewrite_file(
        folder, "scenes/scenes-00000-of-00002.parquet", lambda row: row.update(glb=b"glTF")
    )
    found = problems(folder)
    assert found["assets_readable"] == ["empty_room"]
    rewrite_file(
        folder,
        "motions/motions-00001-of-00007.parquet",
        lambda row: row.update(root_translation=b"123"),
    )
    assert problems(folder)["assets_readable"] == ["sway_fearful on plain", "empty_room"]


def test_the_manifest_tells_rows_and_columns(folder: Path, tmp_path: Path) -> None:
    name = "avatars/avatars-00000-of-00002.parquet"
    rewrite_file(folder, name, lambda row: row.update(avatar_id="another"))
    assert problems(folder)["files"] == [name]
    shutil.rmtree(folder)
    with pytest.raises(FileNotFoundError, match="no release"):
        validate_release(folder)


def test_a_sample_is_a_number_from_0() -> None:
    with pytest.raises(ValueError, match="sample must be a number of episodes from 0"):
        validate_release("mini", sample=-1)


def test_every_check_is_documented() -> None:
    text = (Path(__file__).parents[1] / "docs" / "validation.md").read_text(encoding="utf-8")
    assert [name for name in CHECKS if f"`{name}`" not in text] == []
