"""The Gymnasium environment: its contract, what it tells, its order, and what it leaves behind."""

from __future__ import annotations

import math
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from small_release import small_rows, write_release

from affectsim_data.releases import Release, open_release
from affectsim_data.render import process_renderer
from affectsim_data.simulation import (
    ACTIONS,
    ENVIRONMENT_ID,
    AffectSimEnv,
    Budget,
    register_environment,
)
from affectsim_data.simulation.environment import _open_environments

KEYS = {"rgb", "depth", "pose", "camera_height_m"} | {
    *("time_s", "budget_left", "clipped", "collecting")
}
FORWARD, LEFT, RIGHT, HAND_OFF, STOP = range(5)


@pytest.fixture(autouse=True)
def everything_closed() -> Iterator[None]:
    yield
    for env in list(_open_environments):
        env.close()


def make(release: Any, **options: Any) -> AffectSimEnv:
    return AffectSimEnv(release, **{"size": 32, **options})


def bytes_of(observation: dict[str, Any]) -> dict[str, bytes]:
    return {name: np.asarray(value).tobytes() for name, value in observation.items()}


def played(env: AffectSimEnv, actions: list[int], **reset: Any) -> list[dict[str, bytes]]:
    seen = [bytes_of(env.reset(**reset)[0])]
    return seen + [bytes_of(env.step(action)[0]) for action in actions]


@pytest.mark.egl
def test_gymnasium_finds_no_fault(small_release_path: Path) -> None:
    env = gymnasium.make(
        ENVIRONMENT_ID, release=small_release_path, size=16, render_mode="rgb_array"
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_env(env.unwrapped)
    remarks = [str(one.message) for one in caught]
    # Depth is `inf` where nothing was hit; gymnasium would have it bounded.
    assert len(remarks) == 1, remarks
    assert "observation space maximum value is infinity" in remarks[0]
    unbounded = [
        name
        for name, space in env.observation_space.items()  # type: ignore[attr-defined]  # a Dict
        if isinstance(space, gymnasium.spaces.Box) and np.isinf(space.high).any()
    ]
    assert unbounded == ["depth"]


@pytest.mark.egl
def test_observations_hold_what_a_robot_knows_and_nothing_else(small: Release) -> None:
    env = make(small, split="test")
    observation, info = env.reset(seed=0, options={"episode_id": "small/4"})
    for action in (None, FORWARD, LEFT, HAND_OFF, FORWARD):
        if action is not None:
            observation, reward, terminated, truncated, info = env.step(action)
            assert (reward, terminated, truncated) == (0.0, False, False)
        assert info == {}
        assert set(observation) == KEYS
        assert env.observation_space.contains(observation)
    # 0.25 m ahead, 15 degrees to the left, and 0.25 m ahead from there.
    ahead, left = 0.25 * (1.0 + math.cos(math.pi / 12)), 0.25 * math.sin(math.pi / 12)
    np.testing.assert_allclose(observation["pose"], (-left, ahead, math.pi / 12), atol=1e-5)
    assert observation["time_s"].tolist() == [1.0]
    assert observation["camera_height_m"] == np.float32(1.2)
    assert observation["budget_left"].tolist() == [477, 80]
    assert (observation["clipped"], observation["collecting"]) == (0, 1)
    # No image but those two, and no number that is not accounted for above.
    sizes = {name: np.size(value) for name, value in observation.items()}
    assert (sizes.pop("rgb"), sizes.pop("depth")) == (32 * 32 * 3, 32 * 32)
    assert sum(sizes.values()) == 3 + 1 + 1 + 2 + 1 + 1


@pytest.mark.egl
def test_observations_do_not_depend_on_the_label(small_release_path: Path, tmp_path: Path) -> None:
    # The same performance under another emotion, motion, performer and episode name.
    rows = small_rows()
    for row in rows["episodes"]:
        if row["episode_id"] == "small/4":
            row |= {"episode_id": "small/x", "emotion": "angry", "motion_id": "sway_angry"}
    write_release(tmp_path / "other", rows=rows)
    actions = [LEFT, FORWARD, FORWARD, HAND_OFF, RIGHT]
    seen = [
        played(make(release), actions, options={"episode_id": name})
        for release, name in ((small_release_path, "small/4"), (tmp_path / "other", "small/x"))
    ]
    assert seen[0] == seen[1]


@pytest.mark.egl
def test_privileged_facts_come_on_request(small: Release) -> None:
    env = make(small, privileged_info=True)
    _, info = env.reset(options={"episode_id": "small/4"})
    # The robot is at (0, 0, -2.5) and looks along +Z at a person at the origin.
    assert (info["episode_id"], info["emotion"], info["outcome"]) == ("small/4", "happy", "")
    np.testing.assert_allclose(info["position_m"], (0.0, 0.0, -2.5), atol=1e-6)
    assert info["target_distance_m"] == pytest.approx(2.5, abs=0.05)
    assert info["target_bearing"] == pytest.approx(0.0, abs=0.05)
    assert info["visible_share"] > 0.9
    for _ in range(6):
        info = env.step(RIGHT)[4]
    assert math.degrees(info["target_bearing"]) == pytest.approx(90.0, abs=3.0)
    assert info["visible_share"] == 0.0
    assert env.step(STOP)[4]["outcome"] == "stopped"


@pytest.mark.egl
def test_episodes_end_as_their_outcome_says(small: Release) -> None:
    env = make(small, size=16, budget=Budget(max_actions=2, max_planner_calls=5))
    env.reset(seed=0)
    assert env.step(STOP)[2:4] == (True, False)
    with pytest.raises(ValueError, match=r"is over \(stopped\)"):
        env.step(LEFT)
    env.reset()
    ends = [env.step(LEFT)[2:4] for _ in range(2)]
    assert ends == [(False, False), (False, True)]
    env.reset()
    env.charge(2)
    assert env.step(LEFT)[0]["budget_left"].tolist() == [1, 3]
    env.charge(3)
    assert env.step(LEFT)[2:4] == (False, True)
    assert env.run.outcome == "planner_calls_exhausted"
    env.reset(options={"episode_id": "small/4"})
    done = env.step(HAND_OFF)[2:4]
    for _ in range(23):
        assert done == (False, False)
        done = env.step(LEFT)[2:4]
    assert done == (True, False)
    assert env.run.rows[0]["policy"] == "gymnasium"


@pytest.mark.egl
def test_the_same_seed_gives_the_same_bytes(small: Release) -> None:
    actions = [FORWARD, LEFT, LEFT, FORWARD, RIGHT]
    one, other = make(small), make(small)
    assert played(one, actions, seed=5) == played(other, actions, seed=5)
    assert played(one, actions) == played(other, actions)


def order(env: AffectSimEnv, count: int, seed: int | None) -> list[str]:
    names = []
    for number in range(count):
        env.reset(seed=seed if number == 0 else None)
        names.append(env.run.episode.episode_id)
    return names


@pytest.mark.egl
def test_every_pass_holds_every_episode_once_and_follows_from_the_seed(tmp_path: Path) -> None:
    rows = small_rows()
    for row in rows["episodes"]:
        row["split"] = "test"
    write_release(tmp_path / "wide", rows=rows, splits=["test"])
    env = make(tmp_path / "wide", size=8)
    everyone = [row["episode_id"] for row in rows["episodes"]]
    seen = order(env, 12, seed=3)
    assert sorted(seen[:6]) == sorted(seen[6:]) == everyone
    assert seen[:6] != seen[6:]
    assert order(env, 12, seed=3) == seen
    assert order(env, 6, seed=4) != seen[:6]
    # Another episode in between leaves the order alone.
    env.reset(seed=3)
    env.reset(options={"episode_id": "small/2"})
    assert order(env, 1, seed=None) == seen[1:2]
    assert order(make(tmp_path / "wide", size=8, shuffle=False), 7, seed=9) == [
        *everyone,
        "small/0",
    ]
    shares = [
        order(make(tmp_path / "wide", size=8, rank=rank, world_size=4), count, seed=rank)
        for rank, count in enumerate((2, 2, 1, 1))
    ]
    assert sorted(name for share in shares for name in share) == everyone


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"rank": 2, "world_size": 2}, r"rank must be in \[0, world_size\), got rank=2"),
        ({"rank": 2, "world_size": 3}, "2 episodes leave none for rank 2 of 3"),
        ({"split": "tests"}, "split"),
        ({"render_mode": "human"}, "render_mode must be 'rgb_array' or None, got 'human'"),
        ({"size": 0}, "camera width must be 1 to 8192 pixels, got 0"),
        ({"filter": [("emotion", "==", "angry")]}, "no episode of"),
    ],
)
def test_malformed_arguments_are_named(
    small: Release, options: dict[str, Any], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        make(small, **options)


@pytest.mark.egl
def test_requests_out_of_place_are_named(small: Release) -> None:
    env = make(small, size=8, render_mode="rgb_array")
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) first"):
        env.step(LEFT)
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) first"):
        env.render()
    with pytest.raises(ValueError, match="episode 'small/0' is not among the 2 of this env"):
        env.reset(options={"episode_id": "small/0"})
    with pytest.raises(ValueError, match=r"options may hold 'episode_id' alone, got \['scene'\]"):
        env.reset(options={"scene": "crate_room"})
    observation, _ = env.reset(seed=0)
    for action in (5, -1, 1.0, "stop"):
        with pytest.raises(ValueError, match="action must be one of 0 move_forward, 1 turn_left"):
            env.step(action)  # type: ignore[arg-type]  # that is the test
    with pytest.raises(ValueError, match="planner_calls must be at least 0, got -1"):
        env.charge(-1)
    picture = env.render()
    assert picture is not None
    np.testing.assert_array_equal(picture, observation["rgb"])
    assert make(small, size=8).render() is None


@pytest.mark.egl
def test_the_last_one_closed_frees_the_device(small: Release) -> None:
    one, other = make(small, size=8), make(small, size=8)
    renderer: Any = process_renderer()
    before = bytes_of(one.reset(seed=1)[0])
    other.reset(seed=1)
    one.close()
    assert renderer.is_open
    other.close()
    other.close()
    assert not renderer.is_open
    # An environment may be used again.
    assert bytes_of(one.reset(seed=1)[0]) == before


@pytest.mark.egl
def test_environments_work_side_by_side(small_release_path: Path) -> None:
    options: dict[str, Any] = {"release": small_release_path, "size": 16}
    actions = np.array([FORWARD, LEFT])
    seen = []
    spawned: dict[str, Any] = {"vector_kwargs": {"context": "spawn"}}
    for mode, more in (("sync", {}), ("async", spawned)):
        envs = gymnasium.make_vec(
            ENVIRONMENT_ID, num_envs=2, vectorization_mode=mode, **options, **more
        )
        frames = [envs.reset(seed=2)[0], *(envs.step(actions)[0] for _ in range(3))]
        seen.append([bytes_of(frame) for frame in frames])
        assert frames[0]["rgb"].shape == (2, 16, 16, 3)
        envs.close()
    assert seen[0] == seen[1]


def test_registering_twice_is_quiet() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        register_environment()
    assert ENVIRONMENT_ID in gymnasium.registry
    assert gymnasium.spaces.Discrete(len(ACTIONS)).n == 5


def test_without_gymnasium_all_but_the_environment_is_there() -> None:
    program = (
        "import sys\n"
        "sys.modules['gymnasium'] = None\n"
        "from affectsim_data.simulation import EpisodeRun\n"
        "try:\n"
        "    from affectsim_data.simulation import AffectSimEnv\n"
        "except ImportError as error:\n"
        "    print(type(error).__name__, error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=True
    )
    assert "MissingExtraError" in done.stdout
    assert "pip install 'affectsim-data[sim]'" in done.stdout


@pytest.mark.egl
def test_many_episodes_in_a_row_leave_nothing_behind(small_release_path: Path) -> None:
    env = make(open_release(small_release_path), size=16)
    renderer: Any = process_renderer()

    def episodes(count: int) -> tuple[int, int]:
        for number in range(count):
            env.reset(seed=number)
            for action in (LEFT, FORWARD):
                env.step(action)
        return renderer.cached_bytes, len(_open_environments)

    assert episodes(4) == episodes(20)
    assert len(env._order) <= env.num_episodes
