"""What each policy does: standing, going at random, searching by a rule, being told the way."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
import pytest
from acting_runs import CAMERA, make_run

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release
from affectsim_data.simulation.episodes import run_episode
from affectsim_data.simulation.policies import limited_search
from affectsim_data.simulation.policies.driving import bearing
from affectsim_data.simulation.policies.guided import GuidedPolicy, reference, straight_to_target
from affectsim_data.simulation.policies.limited_search import LimitedSearch, free_ahead
from affectsim_data.simulation.policies.standing import RandomPolicy, StayPolicy
from affectsim_data.simulation.policies.truth import Truth, nearest_view, reference_view
from affectsim_data.simulation.running import Observation


def test_who_stays_never_moves_and_collects_at_once(small: Release) -> None:
    run = make_run(small, "stay")
    rows = run_episode(run, StayPolicy(), seed=0).rows
    episode = run.episode
    for row in rows:
        place = tuple(row[f"position_{axis}_m"] for axis in "xyz")
        assert place == episode.start_position
        assert row["yaw_deg"] == math.degrees(episode.start_yaw)
        assert row["phase"] == "collect"
    assert [row["action"] for row in rows].count("hand_off") == 1
    assert rows[0]["action"] == "hand_off"


def test_random_hands_off_after_its_steps_and_depends_on_the_seed(small: Release) -> None:
    policy = RandomPolicy(12)
    first, again, other = (
        run_episode(make_run(small, policy.name), policy, seed=seed).rows for seed in (3, 3, 4)
    )
    assert first == again
    assert first != other
    assert [row["action"] for row in first].index("hand_off") == 12
    assert {row["action"] for row in first[:12]} <= {"move_forward", "turn_left", "turn_right"}


def looking(depth: FloatArray, **changes: Any) -> Observation:
    """An observation that shows a depth."""
    height, width = depth.shape
    observation = Observation(
        rgb=np.zeros((height, width, 3), np.uint8),
        depth=depth.astype(np.float32),
        position=np.zeros(3),
        yaw=0.0,
        camera_height_m=1.2,
        time_s=0.0,
        actions_left=480,
        planner_calls_left=80,
        clipped=False,
        collecting=False,
        camera=Camera(width=width, height=height, hfov=math.radians(60.0)),
    )
    return dataclasses.replace(observation, **changes)


def test_the_way_ahead_is_as_long_as_the_nearest_thing_in_it() -> None:
    assert free_ahead(looking(np.full((65, 65), np.inf))) == math.inf
    assert free_ahead(looking(np.full((64, 64), 2.0))) == 2.0
    beside = np.full((64, 64), np.inf)
    beside[:, :20] = 2.0  # from 0.43 m to the left of the middle on: 2 * tan(30) * 24 / 64
    assert free_ahead(looking(beside)) == math.inf
    beside[:, :24] = 2.0  # from 0.29 m on
    assert free_ahead(looking(beside)) == 2.0
    lamp = np.full((64, 64), np.inf)
    lamp[:16] = 1.5  # from 1.2 + 1.5 * tan(30) / 2 = 1.63 m above the floor
    assert free_ahead(looking(lamp)) == math.inf


def test_the_floor_is_not_in_the_way() -> None:
    rows = (np.arange(64) + 0.5 - 32.0) / 32.0 * math.tan(math.radians(30.0))
    with np.errstate(divide="ignore"):
        floor = np.where(rows > 0, 1.2 / rows, np.inf)
    assert free_ahead(looking(np.tile(floor[:, None], (1, 64)))) == math.inf


class Nobody:
    """A finder that sees nobody."""

    def update(self, observation: Observation) -> tuple[()]:
        return ()


@pytest.fixture
def searching(monkeypatch: pytest.MonkeyPatch) -> LimitedSearch:
    """The limited search in a home where nobody is."""
    monkeypatch.setattr(limited_search, "PersonFinder", Nobody)
    policy = LimitedSearch()
    policy.reset(CAMERA, seed=0)
    return policy


def test_limited_search_stops_at_a_wall_looks_and_turns_by_105_degrees(
    searching: LimitedSearch,
) -> None:
    wall, way = looking(np.full((64, 64), 0.8)), looking(np.full((64, 64), 9.0))
    seen = [searching.act(one) for one in [way, *[wall] * 9, way]]
    looks, turns = ["turn_left", "turn_right", "turn_left"], ["turn_left"] * 6
    assert [one.action for one in seen] == ["move_forward", *looks, *turns, "move_forward"]
    assert [one.planner_calls for one in seen] == [0, 1, *[0] * 9]


def test_limited_search_stops_after_three_metres(searching: LimitedSearch) -> None:
    way = looking(np.full((64, 64), 9.0))
    actions = [searching.act(way).action for _ in range(13)]
    assert actions == [*["move_forward"] * 12, "turn_left"]


def test_limited_search_goes_on_where_everything_is_near(searching: LimitedSearch) -> None:
    wall = looking(np.full((64, 64), 0.8))
    actions = [searching.act(wall).action for _ in range(27)]
    assert actions[3:] == [*["turn_left"] * 23, "move_forward"]


@pytest.mark.parametrize("make", [straight_to_target, reference])
@pytest.mark.parametrize("index", [0, 1])
def test_guided_policies_end_near_the_target_and_face_it(
    small: Release, make: Any, index: int
) -> None:
    policy = make()
    run = make_run(small, policy.name, index=index)
    result = run_episode(run, policy, seed=0)
    assert result.outcome == "collected"
    assert sum(row["clipped"] for row in result.rows) == 0
    (handoff,) = (row for row in result.rows if row["action"] == "hand_off")
    place = np.array([handoff["position_x_m"], handoff["position_z_m"]])
    target = run.people(handoff["time_s"])[0, [0, 2]]
    assert 0.9 <= math.dist(place, target) <= 3.2
    off = bearing(place, target) - math.radians(handoff["yaw_deg"])
    assert abs(math.remainder(off, 2.0 * math.pi)) <= math.radians(12.0)


def test_the_truth_knows_the_robots_place(small: Release) -> None:
    policy = RandomPolicy(25)
    run = make_run(small, policy.name, index=1)
    truth = Truth(run.episode, run.world, run.navmesh)
    policy.reset(CAMERA, seed=5)
    for _ in range(25):
        place, yaw = truth.place(run.observe())
        np.testing.assert_allclose(place, run.state.position, atol=1e-12)
        assert math.remainder(yaw - run.state.yaw, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)
        np.testing.assert_allclose(truth.people(run.time_s), run.people(run.time_s))
        run.act(policy.act(run.observe()).action)
    assert run.state.position != run.episode.start_position


def test_views_are_where_one_can_stand(small: Release) -> None:
    run = make_run(small, "privileged:test")
    truth = Truth(run.episode, run.world, run.navmesh)
    middle = truth.whereabouts[0].mean(axis=0)[[0, 2]]
    near = nearest_view(truth, 0.0)
    assert near is not None
    assert math.dist(near[[0, 2]], middle) == pytest.approx(1.75)
    under = reference_view(truth, 0.0)
    assert under is not None
    camera = run.episode.reference.knots[0, [0, 2]]
    assert math.dist(under[[0, 2]], camera) <= 1.5 + 1e-9
    for place in (near, under):
        assert run.navmesh.is_navigable(place)


def test_a_guided_policy_that_knows_no_view_gives_up(small: Release) -> None:
    policy = GuidedPolicy("privileged:nowhere", lambda truth, instant_s: None)
    result = run_episode(make_run(small, policy.name), policy, seed=0)
    assert (result.outcome, len(result.rows)) == ("stopped", 1)


def test_a_guided_policy_has_to_be_told(small: Release) -> None:
    policy = straight_to_target()
    policy.reset(CAMERA, seed=0)
    with pytest.raises(ValueError, match="call reveal after reset"):
        policy.act(make_run(small, policy.name).observe())
