"""Seats and doors in a plain room: who sits and knocks there passes, and what is off is found."""

from __future__ import annotations

import dataclasses
import hashlib
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from broken_releases import Row, changed_part, failed
from small_release import box_room, make_episode, place, write_release

from affectsim_data.avatars import Avatar
from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.measuring import Performance, measure_performance
from affectsim_data.builders.performances import PerformanceAction, perform
from affectsim_data.builders.recipes import Recipe, read_recipe
from affectsim_data.builders.validation.part import Part, read_part
from affectsim_data.builders.validation.supports import check_supports
from affectsim_data.builders.validation.tables import Columns, read_tables
from affectsim_data.builders.validation.tracks import Bodies
from affectsim_data.motions import Motion
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.rows import avatar_row, motion_row, scene_row
from affectsim_data.releases.stores import open_store
from affectsim_data.scenes import Scene

ACTIONS: tuple[PerformanceAction, ...] = ("being_seated", "sit_down", "knock_door")
RECIPE = """
name = "room"
seed = 7
camera = {width = 224, height = 224, hfov_deg = 60.0}
scenes = {homes = "homes-mini"}
avatars = {ids = ["ada"]}
performances = {performers = ["p0"], actions = ["being_seated", "sit_down", "knock_door"]}
splits = {by = "performer", test = ["p0"]}
[[compose]]
family = "action_grounded"
actions = ["being_seated", "sit_down", "knock_door"]
"""


def _room() -> Scene:
    """Its seat at (2, 0.45, 0) looks along +X; its door is in the wall at z = -4."""
    return box_room("empty_room")


def _anchor(action: str, motion: Motion, avatar: Avatar) -> tuple[float, float, float, float]:
    """Where the performance goes, and its facing in radians."""
    scale = avatar.motion_scale
    low = motion.root_translation[np.argmin(motion.root_translation[:, 1])] * scale
    if action == "being_seated":
        # Turned to +X, the motion's own z points along x.
        return 2.0 - low[2], 0.45 + 0.10 * scale - low[1], low[0], math.pi / 2.0
    if action == "sit_down":
        return 2.0 - low[2], 0.0, low[0], math.pi / 2.0
    reach = measure_performance(Performance(motion, avatar)).hand[2]
    return 0.0, 0.0, -4.0 + reach, math.pi


@pytest.fixture(scope="module")
def recipe(tmp_path_factory: pytest.TempPathFactory) -> Recipe:
    """Says that who sits goes to seats and who knocks to doors."""
    path = tmp_path_factory.mktemp("recipe") / "room.toml"
    path.write_text(RECIPE, encoding="utf-8")
    return read_recipe(path)


@pytest.fixture(scope="module")
def release(recipe: Recipe, tmp_path_factory: pytest.TempPathFactory) -> Release:
    """One episode of each action in an empty room."""
    scene, avatar = _room(), load_avatars(recipe)[0]
    navmesh = NavMesh.from_mesh(*scene.mesh(), mesh_sha256=scene.mesh_sha256())
    motions = {
        action: perform(action, "neutral", "p0", rng=np.random.default_rng(3)).rounded()
        for action in ACTIONS
    }
    episodes = []
    for number, (action, motion) in enumerate(motions.items()):
        x, y, z, facing = _anchor(action, motion, avatar)
        episode = make_episode(
            episode_id=f"room/{number}",
            family="action_grounded",
            challenge=None,
            action=action,
            emotion="neutral",
            target=place(motion, avatar, (x, y, z), facing),
            support="door 0" if action == "knock_door" else "seat 0",
            duration_s=motion.duration_s,
            navmesh_sha256=hashlib.sha256(navmesh.to_bytes()).hexdigest(),
        )
        episodes.append(episode.to_row())
    rows = {
        "episodes": episodes,
        "motions": [motion_row(motion) for motion in motions.values()],
        "scenes": [scene_row(scene, navmesh)],
        "avatars": [avatar_row(avatar)],
    }
    out: Path = tmp_path_factory.mktemp("room") / "release"
    write_release(out, rows=rows, splits=("test",))
    return open_release(out)


@pytest.fixture(scope="module")
def part_of(release: Release, recipe: Recipe) -> Callable[[str], Part]:
    """The episode of an action."""
    tables = read_tables(release, open_store(release.uri), None, "")
    bodies = Bodies(release)

    def get(action: str) -> Part:
        chosen: Columns = tables.episodes.where(tables.episodes.text("action") == action)
        part, _ = read_part(release, bodies, chosen, recipe, frozenset())
        assert part is not None
        return part

    return get


def moved(**offsets: float) -> Callable[[Row], None]:
    """Adds to columns."""
    return lambda row: row.update({name: row[name] + value for name, value in offsets.items()})


@pytest.mark.parametrize("action", ACTIONS)
def test_built_in_motions_fit_seats_and_doors(part_of: Callable[[str], Part], action: str) -> None:
    measures = check_supports(part_of(action))
    assert not failed(measures)
    made = {measure.check for measure in measures if measure.items}
    assert (
        made
        == {
            "being_seated": {
                *("support_named", "seat_place", "seat_height", "seat_facing", "seat_floor"),
                "seat_feet",
            },
            "sit_down": {
                *("support_named", "seat_place", "seat_height", "seat_facing", "seat_floor"),
                *("seat_feet", "sit_standing", "sit_floor"),
            },
            "knock_door": {
                *("support_named", "door_closed", "door_facing", "door_hand", "door_contact"),
            },
        }[action]
    )


@pytest.mark.parametrize(
    ("action", "change", "expected"),
    [
        ("being_seated", moved(anchor_z_m=0.2), {"seat_place"}),
        ("being_seated", moved(anchor_y_m=0.2), {"seat_height", "seat_floor", "seat_feet"}),
        ("being_seated", moved(anchor_y_m=-0.2), {"seat_height", "seat_floor", "seat_feet"}),
        ("sit_down", moved(anchor_x_m=0.2), {"seat_place"}),
        ("sit_down", moved(facing_deg=25.0), {"seat_facing", "seat_place"}),
        ("knock_door", moved(anchor_z_m=0.2), {"door_hand"}),
        ("knock_door", moved(anchor_z_m=-0.2), {"door_hand"}),
        ("knock_door", moved(anchor_x_m=0.8), {"door_contact"}),
        ("knock_door", moved(facing_deg=25.0), {"door_facing"}),
        ("knock_door", lambda row: row.update(support="seat 0"), {"support_named"}),
    ],
)
def test_what_is_off_its_support_is_found(
    part_of: Callable[[str], Part],
    action: str,
    change: Callable[[Row], None],
    expected: set[str],
) -> None:
    changed = changed_part(part_of(action), change, restore=False)
    assert failed(check_supports(changed)) == expected


def test_doors_that_are_knocked_on_are_closed(part_of: Callable[[str], Part]) -> None:
    part = part_of("knock_door")
    ajar = dataclasses.replace(part.scene.doors[0], opening_deg=30.0)
    scene = dataclasses.replace(part.scene, doors=(ajar,))
    assert failed(check_supports(dataclasses.replace(part, scene=scene))) == {"door_closed"}


def test_who_sits_down_stands_at_first_on_free_floor(part_of: Callable[[str], Part]) -> None:
    part = part_of("sit_down")
    seated = part_of("being_seated").episodes.text("motion_id")[0]
    sitting = changed_part(part, lambda row: row.update(motion_id=seated), restore=False)
    assert "sit_standing" in failed(check_supports(sitting))
    crate = box_room("crates", boxes=[((1.5, 0.0, -2.0), (4.0, 0.7, 2.0))])
    filled = NavMesh.from_mesh(*crate.mesh())
    assert failed(check_supports(dataclasses.replace(part, navmesh=filled))) == {"sit_floor"}
