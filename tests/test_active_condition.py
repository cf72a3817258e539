"""Condition a_obs: recorded trajectories as camera paths, fallbacks, and which table is shown."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import torch
from small_release import make_episode, small_motions, small_navmeshes, small_scenes, world_of
from small_release import small_avatars as avatars
from torch.utils.data import DataLoader

from affectsim_data.episodes import Episode, World, clip_time_s
from affectsim_data.loaders import AffectSimDataset, Clip, EpisodeBatches
from affectsim_data.observations import AObs, PInit, RecordedRuns
from affectsim_data.observations.active import clip_start_s
from affectsim_data.poses import quaternion_rotate, yaw_quaternion
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.recorded import add_trajectories, recorded_policies
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation.actions import ACTIONS, Action
from affectsim_data.simulation.blind import BlindRenderer
from affectsim_data.simulation.running import EpisodeRun

TINY = Clip(num_frames=4, width=32, height=32)
Row = dict[str, Any]


def world() -> World:
    """Of `make_episode()`: two seconds of swaying in the empty room."""
    body = avatars()["plain"]
    return world_of(
        small_scenes()["empty_room"],
        [(small_motions()["sway_happy"], body, (0.0, 0.0, 0.0), 0.0)],
    )


def rows_of(
    episode: Episode,
    poses: Iterable[tuple[str, float, float, float]],
    *,
    policy: str = "walker",
) -> list[Row]:
    """Rows of a trajectory from actions, with x, z and yaw in degrees after each."""
    return [
        {
            "episode_id": episode.episode_id,
            "policy": policy,
            "step": step,
            "time_s": 0.25 * (step + 1),
            "action": action,
            "position_x_m": x,
            "position_y_m": 0.0,
            "position_z_m": z,
            "yaw_deg": yaw_deg,
            "clipped": False,
            "phase": "search",
            "planner_calls": 0,
        }
        for step, (action, x, z, yaw_deg) in enumerate(poses)
    ]


def staying(episode: Episode, *, num_steps: int | None = None, policy: str = "walker") -> list[Row]:
    """Hands off at once and stays, until the clip is whole if not said otherwise."""
    x, _, z = episode.start_position
    count = round(12.0 * episode.duration_s) if num_steps is None else num_steps
    pose = (x, z, math.degrees(episode.start_yaw))
    return rows_of(episode, [("hand_off", *pose), *[("stop", *pose)] * (count - 1)], policy=policy)


def table(rows: list[Row]) -> pa.Table:
    return pa.Table.from_pylist(rows, schema=SCHEMAS["trajectories"])


def put(path: Path, *runs: list[Row]) -> Path:
    pq.write_table(table([row for rows in runs for row in rows]), path)
    return path


def recorded(rows: list[Row], **options: Any) -> RecordedRuns:
    return RecordedRuns.from_table(table(rows), file="walks.parquet", **options)


def both(release: Release) -> list[Episode]:
    return [release.episode("test", place) for place in range(2)]


def fallbacks(dataset: AffectSimDataset) -> list[bool]:
    """What every sample says of itself."""
    return [dataset[place]["fallback"] for place in range(len(dataset))]


def test_poses_lie_straight_and_evenly_between_actions() -> None:
    # Starts at (0, -2.5), handed off at 2.5 s; cycles are 2 s long, so the clip begins at 4 s.
    episode = make_episode(start_yaw=math.radians(170.0), phase_s=0.5)
    poses = [("stop", 0.0, -2.5, 170.0)] * 9 + [("hand_off", 0.0, -2.5, 170.0)]
    poses += [("stop", 0.0, -2.5, 170.0)] * 6
    poses += [("move_forward", 0.25, -2.5, 170.0), ("turn_left", 0.25, -2.5, -175.0)]
    poses += [("stop", 0.25, -2.5, -175.0)] * 14
    condition = AObs(recorded(rows_of(episode, poses)))
    assert not condition.falls_back(episode)
    # Motion instants count from the phase; the clip's own from 4 s of the run.
    time_s = episode.phase_s + np.array([0.0, 0.1, 0.25, 0.35, 0.5, 3.9])
    found = condition.trajectory(episode, world(), time_s).T_world_camera
    np.testing.assert_allclose(found[:, 0, 3], [0.0, 0.1, 0.25, 0.25, 0.25, 0.25], atol=1e-12)
    np.testing.assert_allclose(found[:, 1:, 3], [[1.2, -2.5, 1.0]] * 6, atol=1e-12)
    # From 170 through 176 (two fifths of the turn) to 185 degrees, the short way round.
    for pose, yaw_deg in zip(found, [170.0, 170.0, 170.0, 176.0, 185.0, 185.0], strict=True):
        turn = yaw_quaternion(math.radians(yaw_deg))
        ahead = quaternion_rotate(turn, [0.0, 0.0, -1.0])
        np.testing.assert_allclose(pose[:3, :3] @ [0.0, 0.0, -1.0], ahead, atol=1e-9)


@pytest.mark.parametrize(("waits", "last_s"), [(0, 6.0), (7, 6.0), (8, 8.0)])
def test_clips_begin_where_those_of_a_run_do(waits: int, last_s: float) -> None:
    episode = make_episode()
    blind: Any = BlindRenderer()
    run = EpisodeRun(episode, world(), small_navmeshes()["empty_room"], blind, policy="walker")
    wait: Action = "turn_left"
    for _ in range(waits):
        run.act(wait)
    run.act("hand_off")
    assert run.clip_start_s == clip_start_s(0.25 * (waits + 1), episode.duration_s)
    while run.outcome is None:
        run.act("stop")
    assert run.time_s == last_s
    assert not AObs(recorded(run.rows)).falls_back(episode)
    assert AObs(recorded(run.rows[:-1])).falls_back(episode)
    assert AObs(recorded(run.rows[:waits] or staying(episode, num_steps=1))).falls_back(episode)


def test_without_a_whole_clip_the_view_is_the_very_one_of_p_init() -> None:
    episode, seen = make_episode(start_yaw=2.0), world()
    time_s = clip_time_s(episode)
    expected = PInit().trajectory(episode, seen, time_s).T_world_camera
    never = rows_of(episode, [("turn_left", 0.0, -2.5, 130.0)] * 40)
    for rows in (never, staying(episode, num_steps=23), staying(episode)):
        found = AObs(recorded(rows)).trajectory(episode, seen, time_s).T_world_camera
        np.testing.assert_array_equal(found, expected)


def test_trajectories_of_another_place_are_refused() -> None:
    episode = make_episode()
    condition = AObs(recorded(staying(dataclasses.replace(episode, start_position=(3.0, 0, 1.5)))))
    with pytest.raises(ValueError, match=r"'small/0' begins 5\.00 m from where the robot starts"):
        condition.falls_back(episode)
    with pytest.raises(ValueError, match=r"no trajectory of 'walker' in episode 'small/9'"):
        condition.falls_back(make_episode(episode_id="small/9"))


def changed(place: int, **changes: Any) -> list[Row]:
    rows = staying(make_episode(), num_steps=4)
    rows[place] |= changes
    return rows


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ([], r"walks\.parquet: holds no trajectory"),
        (changed(2, time_s=math.nan), r"walks\.parquet, row 3: time_s must be finite"),
        (changed(1, action="jump"), r"row 2: action must be one of move_forward, turn_left"),
        (changed(3, step=4), r"row 4: episode 'small/0': expected step 3, got step 4"),
        (changed(3, step=2), r"row 4: episode 'small/0': expected step 3, got step 2"),
        (changed(0, time_s=0.0), r"row 1: time_s must grow with every step, from more than 0"),
        (changed(2, policy="runner"), r"trajectories of 2 policies, 'runner', 'walker'; say which"),
    ],
)
def test_tables_that_do_not_hold_together_are_refused(rows: list[Row], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        recorded(rows)


def test_every_action_of_a_robot_is_known() -> None:
    rows = rows_of(make_episode(), [(action, 0.0, -2.5, 180.0) for action in ACTIONS])
    assert len(recorded(rows).after_handoff("small/0")) == 2  # hand_off and stop, the last two


def test_files_that_are_no_trajectory_tables_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no such trajectory table; `affectsim acquire`"):
        RecordedRuns.from_parquet(tmp_path / "none.parquet")
    (tmp_path / "text.parquet").write_text("hello")
    with pytest.raises(ValueError, match=r"text\.parquet: cannot be read as Parquet"):
        RecordedRuns.from_parquet(tmp_path / "text.parquet")
    pq.write_table(pa.table({"episode_id": ["a"]}), tmp_path / "other.parquet")
    with pytest.raises(ValueError, match="trajectories columns are missing: policy, step"):
        RecordedRuns.from_parquet(tmp_path / "other.parquet")


def test_the_order_of_rows_and_other_policies_do_not_matter() -> None:
    first, second = make_episode(), make_episode(episode_id="small/1")
    rows = staying(first) + staying(second, num_steps=3)
    shuffled = [rows[place] for place in np.random.default_rng(0).permutation(len(rows))]
    shuffled += staying(first, policy="other")
    one, same = recorded(rows), recorded(shuffled, policy="walker")
    assert one.sha256 == same.sha256
    assert len(one.after_handoff("small/0")) == 24
    assert one.sha256 != recorded(staying(first) + staying(second, num_steps=4)).sha256
    with pytest.raises(ValueError, match="no trajectory of policy 'nobody'; there are those of"):
        recorded(rows, policy="nobody")


@pytest.mark.egl
def test_who_stays_sees_the_pixels_of_p_init_and_fallbacks_are_flagged(
    small: Release, tmp_path: Path
) -> None:
    first, second = both(small)
    path = put(tmp_path / "stay.parquet", staying(first), staying(second, num_steps=5))
    active = AffectSimDataset(small, condition="a_obs", trajectories=path, clip=TINY)
    initial = AffectSimDataset(small, condition="p_init", clip=TINY)
    for place in range(2):
        found, expected = active[place], initial[place]
        assert torch.equal(found["video"], expected["video"])
        assert torch.equal(found["depth"], expected["depth"])
        assert torch.equal(found["frame_indices"], expected["frame_indices"])
    assert fallbacks(active) == [False, True]
    batch = next(iter(DataLoader(active + initial, batch_size=4)))
    assert batch["fallback"].tolist() == [False, True, False, False]
    assert batch["condition"] == ["a_obs", "a_obs", "p_init", "p_init"]


def test_tokens_are_of_the_trajectories_too(small: Release, tmp_path: Path) -> None:
    episodes = both(small)

    def fingerprint(*runs: list[Row]) -> str:
        path = put(tmp_path / "walks.parquet", *runs)
        dataset = AffectSimDataset(
            small, condition="a_obs", trajectories=path, clip=TINY, images=False
        )
        assert EpisodeBatches(dataset).state_dict()["fingerprint"] == dataset.fingerprint
        return dataset.fingerprint

    whole = [staying(one) for one in episodes]
    short = [whole[0], staying(episodes[1], num_steps=9)]
    found = [fingerprint(*runs) for runs in (whole, short, whole[::-1])]
    assert found[0] != found[1]
    assert found[0] == found[2]
    assert AffectSimDataset(small, condition="p_init").fingerprint not in found


def test_every_episode_needs_a_trajectory(small: Release, tmp_path: Path) -> None:
    first, _ = both(small)
    path = put(tmp_path / "one.parquet", staying(first))
    message = r"one\.parquet: 1 of 2 episodes of split 'test' have no trajectory .*'small/5'"
    with pytest.raises(ValueError, match=message):
        AffectSimDataset(small, condition="a_obs", trajectories=path)
    chosen = AffectSimDataset(
        small, condition="a_obs", trajectories=path, episodes=[first.episode_id], images=False
    )
    assert chosen[0]["fallback"] is False
    with pytest.raises(ValueError, match="trajectories and policy go with condition 'a_obs'"):
        AffectSimDataset(small, condition="p_init", trajectories=path)


def test_releases_carry_trajectories(release_copy: Path, tmp_path: Path) -> None:
    def dataset(**options: Any) -> AffectSimDataset:
        return AffectSimDataset(release_copy, condition="a_obs", images=False, **options)

    with pytest.raises(ValueError, match="carries no trajectories; make some with `affectsim acq"):
        dataset()
    episodes = both(open_release(release_copy))
    path = put(tmp_path / "walks.parquet", *(staying(one, policy="random:60") for one in episodes))
    assert add_trajectories(release_copy, path) == ["trajectories/random_60-test.parquet"]
    assert recorded_policies(open_release(release_copy).manifest) == ["random_60"]
    assert fallbacks(dataset()) == [False, False]
    by_scene = dataset(split_by="scene", split="train", episodes=[episodes[1].episode_id])
    assert by_scene[0]["fallback"] is False
    with pytest.raises(ValueError, match=r"no trajectories of 'random:60' in train, but of"):
        dataset(split="train", policy="random:60")
    put(path, *(staying(one, num_steps=2) for one in episodes))
    assert add_trajectories(release_copy, path) == ["trajectories/walker-test.parquet"]
    with pytest.raises(ValueError, match="of 2 policies, 'random_60', 'walker'; say which"):
        dataset()
    assert fallbacks(dataset(policy="walker")) == [True, True]
    assert fallbacks(dataset(policy="random:60")) == [False, False]


def test_trajectories_of_other_episodes_are_not_added(release_copy: Path, tmp_path: Path) -> None:
    before = (release_copy / "MANIFEST.json").read_bytes()
    there, _ = both(open_release(release_copy))
    strange = make_episode(episode_id="elsewhere")
    path = put(tmp_path / "walks.parquet", staying(there), staying(strange))
    with pytest.raises(ValueError, match=r"walks\.parquet: 24 rows are of episodes that are not"):
        add_trajectories(release_copy, path)
    assert (release_copy / "MANIFEST.json").read_bytes() == before
    assert not (release_copy / "trajectories").exists()
