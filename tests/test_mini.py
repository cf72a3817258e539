"""The built-in release `mini`: what DESIGN promises of it holds for what is built."""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from affectsim_data import AffectSimDataset, Clip
from affectsim_data.builders.building import build_release
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.episodes import Episode
from affectsim_data.motions import EMOTIONS
from affectsim_data.observations import head_camera_pose
from affectsim_data.releases import Release, open_release
from affectsim_data.render import RendererName
from affectsim_data.schemas import CHALLENGES, FAMILIES, SPLITS
from affectsim_data.visibility import body_samples, scene_caster, visible_share


@pytest.fixture(scope="module")
def mini() -> Release:
    return open_release("mini")


@pytest.fixture(scope="module")
def episodes(mini: Release) -> list[Episode]:
    return [
        mini.episode(split, index)
        for split in SPLITS
        for index in range(mini.manifest.num_rows("episodes", split))
    ]


def test_it_has_the_promised_size(mini: Release, episodes: list[Episode]) -> None:
    assert len(mini.asset_ids("scenes")) >= 3
    assert len(mini.asset_ids("avatars")) >= 2
    assert len(episodes) >= 160
    singles = Counter(
        (motion.action, motion.emotion)
        for motion in map(mini.motion, mini.asset_ids("motions"))
        if motion.action != "interaction"
    )
    assert sum(singles.values()) >= 100
    assert set(singles.values()) == {4}
    actions = {action for action, _ in singles}
    assert actions == {"simple_walk", "being_seated", "sit_down", "knock_door", "scenario"}
    assert {episode.family for episode in episodes} == set(FAMILIES)
    assert {episode.challenge for episode in episodes} == {*CHALLENGES, None}
    for split in SPLITS:
        emotions = Counter(episode.emotion for episode in episodes if episode.split == split)
        assert set(emotions) == set(EMOTIONS)
        assert len(set(emotions.values())) == 1


def test_what_needs_a_seat_or_a_door_has_one(mini: Release, episodes: list[Episode]) -> None:
    needs = {"being_seated": "seat", "sit_down": "seat", "knock_door": "door"}
    for episode in episodes:
        kind, _, number = (episode.support or "").partition(" ")
        assert kind == needs.get(episode.action, "")
        if kind:
            scene = mini.scene(episode.scene_id)
            seats = [seat.position for seat in scene.seats]
            doors = [door.knock_point for door in scene.doors]
            place = (seats if kind == "seat" else doors)[int(number)]
            away = np.subtract(place, episode.target.anchor)[[0, 2]]
            assert np.linalg.norm(away) < 1.0


def test_ids_are_unique_and_references_resolve(mini: Release, episodes: list[Episode]) -> None:
    assert len({episode.episode_id for episode in episodes}) == len(episodes)
    for episode in episodes:
        world = mini.world(episode)
        assert world.target.motion.emotion == episode.emotion
        assert world.target.motion.action == episode.action
        assert world.target.motion.duration_s == pytest.approx(episode.duration_s)
        assert (len(world.people) == 2) == (episode.family == "dyadic")


def test_no_group_is_shared_by_splits(episodes: list[Episode]) -> None:
    splits = defaultdict(set)
    for episode in episodes:
        splits[episode.group_id].add(episode.split)
    assert all(len(found) == 1 for found in splits.values())


def test_challenges_hold_as_measured(episodes: list[Episode]) -> None:
    limits = read_recipe("mini").thresholds
    for episode in episodes:
        visible, distance = episode.visible_share_init, episode.initial_distance_m
        if episode.challenge == "far_visible":
            assert distance >= limits.far_distance_m
            assert visible >= limits.visible
        elif episode.challenge == "rear_view":
            assert abs(math.degrees(episode.initial_bearing)) >= limits.rear_bearing_deg
            assert limits.near_m <= distance <= limits.far_m
            assert visible >= limits.visible
        elif episode.challenge == "partial_occlusion":
            assert limits.occluded_low <= visible <= limits.occluded_high
            assert limits.near_m <= distance <= limits.far_m
        elif episode.challenge == "obstacle_detour":
            geodesic = episode.d_star[1]
            assert isinstance(geodesic, float)
            assert geodesic >= limits.detour_ratio * (distance - 1.1)
        else:
            assert visible >= limits.grounded_visible


def test_stored_shares_are_what_the_cameras_see(mini: Release, episodes: list[Episode]) -> None:
    for episode in episodes[::17]:
        world = mini.world(episode)
        samples = body_samples(world, np.arange(12) * episode.duration_s / 12)
        pose = head_camera_pose(
            np.array(episode.start_position), np.array(episode.start_yaw), world.robot
        )
        share = visible_share(samples, pose[None, None], world.camera, scene_caster(world.scene))
        assert share.visible.mean() == pytest.approx(episode.visible_share_init, abs=0.01)


def test_distances_are_those_of_the_stored_navmesh(mini: Release, episodes: list[Episode]) -> None:
    for episode in episodes[::13]:
        navmesh = mini.navmesh(episode.scene_id)
        assert navmesh.is_navigable(np.array(episode.start_position))
        for ring, stored in episode.d_star.items():
            again = navmesh.ring_distance(
                np.array(episode.start_position), np.array(episode.target.anchor), float(ring)
            )
            if stored == "empty":
                assert math.isnan(again)
            elif stored == "unreachable":
                assert math.isinf(again)
            else:
                assert again == pytest.approx(stored, abs=1e-6)


def test_reference_sees_more_than_the_start(episodes: list[Episode]) -> None:
    initial = np.array([episode.visible_share_init for episode in episodes])
    reference = np.array([episode.visible_share_ref for episode in episodes])
    assert reference.mean() > 0.9
    assert reference.mean() - initial.mean() > 0.15


def test_reference_cameras_stay_inside_and_move_smoothly(
    mini: Release, episodes: list[Episode]
) -> None:
    for episode in episodes[::5]:
        scene = mini.scene(episode.scene_id)
        corners = np.array([corner for room in scene.rooms for corner in room.polygon])
        knots = episode.reference.knots[:, :3]
        assert (knots[:, [0, 2]] >= corners.min(axis=0)).all()
        assert (knots[:, [0, 2]] <= corners.max(axis=0)).all()
        steps = np.linalg.norm(np.diff(knots, axis=0, append=knots[:1]), axis=1)
        seconds = episode.duration_s / len(knots)
        assert steps.max() / seconds < 6.0


@pytest.mark.egl
@pytest.mark.parametrize("condition", ["p_init", "p_ref", "p_mon"])
def test_both_renderers_agree_on_real_samples(mini: Release, condition: str) -> None:
    """Depth within 5 mm on 99.5 % of common pixels, silhouettes with an IoU of at least 0.985."""
    clip = Clip(num_frames=2, width=224, height=224)
    fast, slow = (
        AffectSimDataset(
            mini, split="test", condition=condition, clip=clip, instances=True, renderer=name
        )
        for name in get_args(RendererName)
    )
    for index in range(0, len(fast), 9):
        samples = fast[index], slow[index]
        depth, reference = (sample["depth"].numpy() for sample in samples)
        common = np.isfinite(depth) & np.isfinite(reference)
        assert common.mean() > 0.99
        assert (np.abs(depth - reference)[common] <= 0.005).mean() >= 0.995
        person, again = (sample["instances"].numpy() == 1 for sample in samples)
        union = (person | again).sum()
        # A handful of pixels is all edge; whole bodies and parts of them must agree.
        if union > 400:
            assert (person & again).sum() / union >= 0.985


@pytest.mark.slow
def test_building_again_gives_the_same_bytes(mini: Release, tmp_path: Path) -> None:
    build_release("mini", tmp_path / "again", jobs=1)
    first = Path(mini.uri)
    names = sorted(path.relative_to(first) for path in first.rglob("*") if path.is_file())
    built = [name for name in names if name.name != "README.md"]
    assert len(built) > 5
    for name in built:
        assert (tmp_path / "again" / name).read_bytes() == (first / name).read_bytes(), name
