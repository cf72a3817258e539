from __future__ import annotations

import math
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from wide_release import COUNTS, NUM_SCENES, wide_scenes, write_wide_release

from affectsim_data import AffectSimDataset
from affectsim_data.episodes import Episode
from affectsim_data.releases import Release, open_release
from affectsim_data.schemas import SPLITS


@pytest.fixture(scope="module")
def wide(tmp_path_factory: pytest.TempPathFactory) -> Release:
    out = tmp_path_factory.mktemp("wide") / "release"
    write_wide_release(out)
    return open_release(out)


def _some_episodes(release: Release, step: int) -> list[Episode]:
    return [
        release.episode(split, row) for split in SPLITS for row in range(0, COUNTS[split], step)
    ]


def test_every_split_has_its_episodes_scene_by_scene(wide: Release) -> None:
    for split, count in COUNTS.items():
        index = wide.episode_index(split)
        assert index.column("episode_id").to_pylist() == [
            f"wide/{split}-{place:05d}" for place in range(count)
        ]
        scenes = index.column("scene_id").to_pylist()
        assert scenes == sorted(scenes)
        assert len(set(scenes)) == NUM_SCENES


def test_splits_share_no_performer_and_all_emotions_occur(wide: Release) -> None:
    performers: list[str] = []
    for split in SPLITS:
        index = wide.episode_index(split)
        assert set(index.column("emotion").to_pylist()) == {
            *("angry", "fearful", "happy", "neutral", "sad")
        }
        columns = (index.column(name) for name in ("performer_id", "partner_performer_id"))
        performers += {name for column in columns for name in column.to_pylist() if name}
    assert max(Counter(performers).values()) == 1


def test_no_two_rooms_are_alike() -> None:
    assert len({scene.mesh_sha256() for scene in wide_scenes().values()}) == NUM_SCENES


def test_labels_are_those_of_the_motions(wide: Release) -> None:
    for episode in _some_episodes(wide, 97):
        motion = wide.motion(episode.target.motion_id)
        assert (episode.emotion, episode.action) == (motion.emotion, motion.action)
        assert episode.duration_s == motion.duration_s


def test_distances_are_those_of_the_navmesh(wide: Release) -> None:
    for episode in _some_episodes(wide, 397):
        navmesh = wide.navmesh(episode.scene_id)
        assert navmesh.is_navigable(episode.start_position)
        lengths = {
            r: navmesh.ring_distance(episode.start_position, episode.target.anchor, r)
            for r in (1, 3)
        }
        assert lengths[1] == pytest.approx(episode.d_star[1], abs=0.01)
        assert math.isnan(lengths[3])
        assert episode.d_star[3] == episode.d_star[5] == "empty"


def test_distance_and_bearing_columns_follow_from_the_places(wide: Release) -> None:
    table = wide.episode_table("validation").to_pylist()
    for row in table[::29]:
        episode = Episode.from_row(row)
        x, _, z = np.subtract(episode.start_position, episode.target.anchor)
        assert row["initial_distance_m"] == pytest.approx(episode.initial_distance_m)
        bearing = math.remainder(math.atan2(x, z) - episode.target.facing, math.tau)
        assert math.remainder(bearing - episode.initial_bearing, math.tau) == pytest.approx(0.0)


def test_partners_stand_face_to_face_with_the_target_between_them_and_the_robot(
    wide: Release,
) -> None:
    dyads = [episode for episode in _some_episodes(wide, 11) if episode.partner is not None]
    assert 0.05 < len(dyads) / len(_some_episodes(wide, 11)) < 0.15
    for episode in dyads:
        assert episode.partner is not None
        assert (episode.family, episode.challenge) == ("dyadic", None)
        looks = np.array([math.sin(episode.partner.facing), math.cos(episode.partner.facing)])
        start = np.array(episode.start_position)[[0, 2]]
        partner = np.array(episode.partner.anchor)[[0, 2]]
        np.testing.assert_allclose(looks, start / np.linalg.norm(start), atol=1e-9)
        np.testing.assert_allclose(partner, -0.9 * looks, atol=1e-9)


def test_the_same_bytes_every_time_and_narrower_on_request(tmp_path: Path) -> None:
    for name in ("first", "second"):
        write_wide_release(tmp_path / name, num_scenes=3, counts={"train": 40, "test": 5})
    first, second = (open_release(tmp_path / name).manifest for name in ("first", "second"))
    assert first.to_json() == second.to_json()
    assert [first.num_rows("episodes", split) for split in SPLITS] == [40, 0, 5]
    assert first.num_rows("scenes") == 3


@pytest.mark.egl
def test_the_robot_sees_the_target_from_every_start(wide: Release) -> None:
    dataset = AffectSimDataset(wide, split="train", condition="p_init", instances=True)
    for row in range(0, len(dataset), 500):
        assert (dataset[row]["instances"] == 1).float().mean() > 0.03
