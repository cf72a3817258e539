"""Policies opened by name, and whole episodes in which they act, or fail and are blamed."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from acting_runs import make_run

from affectsim_data.cameras import Camera
from affectsim_data.releases import Release
from affectsim_data.simulation.episodes import PolicyError, run_episode
from affectsim_data.simulation.policies import Decision
from affectsim_data.simulation.policies.opening import open_policy, policy_names
from affectsim_data.simulation.policies.standing import StayPolicy
from affectsim_data.simulation.running import Observation


def test_policies_open_by_name() -> None:
    for spec in policy_names():
        if spec == spec.lower():
            assert open_policy(spec).name == spec
    assert open_policy("random:7").name == "random:7"
    assert open_policy("random:40").name == "random"
    own = "module:affectsim_data.simulation.policies.standing:StayPolicy"
    assert open_policy(own).name == "stay"


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (
            "nobody",
            "policy must be one of stay, random, .*module:PACKAGE.MODULE:NAME, got 'nobody'",
        ),
        ("my.module:Mine", "got 'my.module:Mine'; for a class of yours: module:my.module:Mine"),
        ("random:-1", "random: takes a number of steps, a whole number from 0, got '-1'"),
        ("module:math", "must be module:PACKAGE.MODULE:NAME, got 'math'"),
        ("module:no_such_module:X", "there is no module 'no_such_module'; is the folder"),
        ("module:math:Nothing", "math has no 'Nothing'"),
        ("module:math:pi", "math:pi is no policy, it lacks name, reset, act"),
    ],
)
def test_what_is_no_policy_is_said(spec: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        open_policy(spec)


class Scripted:
    """Does what it was told to, then waits."""

    name = "scripted"

    def __init__(self, *decisions: Any) -> None:
        self._decisions = decisions

    def reset(self, camera: Camera, *, seed: int) -> None:
        self._left = list(self._decisions)

    def act(self, observation: Observation) -> Decision:
        decision: Decision = self._left.pop(0) if self._left else Decision("stop")
        if isinstance(decision, Exception):
            raise decision
        return decision


def test_an_episode_is_acted_to_its_end(small: Release) -> None:
    policy = Scripted(Decision("turn_left", planner_calls=2), Decision("hand_off"))
    run = make_run(small, policy.name)
    result = run_episode(run, policy, seed=0)
    assert result.outcome == "collected"
    assert result.rows == run.rows
    assert [row["action"] for row in result.rows[:3]] == ["turn_left", "hand_off", "stop"]
    assert [row["phase"] for row in result.rows[:3]] == ["search", "collect", "collect"]
    assert result.rows[-1]["planner_calls"] == 2
    assert result.policy_time_s > 0.0
    with pytest.raises(ValueError, match=r"has begun, \d+ actions are done"):
        run_episode(run, policy, seed=0)


def test_an_action_is_done_as_often_as_decided(small: Release) -> None:
    policy = Scripted(
        Decision("turn_left", planner_calls=2, num_steps=3),
        Decision("hand_off"),
        Decision("stop", num_steps=10_000),
    )
    rows = run_episode(make_run(small, policy.name), policy, seed=0).rows
    assert [row["action"] for row in rows[:5]] == ["turn_left"] * 3 + ["hand_off", "stop"]
    assert [row["planner_calls"] for row in rows[:4]] == [2, 2, 2, 2]
    single = Scripted(
        Decision("turn_left", planner_calls=2),
        *(Decision("turn_left"), Decision("turn_left"), Decision("hand_off")),
    )
    assert rows == run_episode(make_run(small, policy.name), single, seed=0).rows


def test_who_gives_up_has_stopped(small: Release) -> None:
    result = run_episode(make_run(small, "scripted"), Scripted(), seed=0)
    assert (result.outcome, len(result.rows)) == ("stopped", 1)


@pytest.mark.parametrize(
    ("nonsense", "reason"),
    [
        (KeyError("lost"), "KeyError: 'lost'"),
        ("move_forward", "act must return a Decision, got 'move_forward'"),
        (None, "act must return a Decision, got None"),
        (Decision("fly"), "action must be one of move_forward, .*, stop, got 'fly'"),  # type: ignore[arg-type]  # the point
        (Decision("stop", planner_calls=-1), "planner_calls must be a whole number from 0, got -1"),
        (Decision("stop", planner_calls=0.5), "a whole number from 0, got 0.5"),  # type: ignore[arg-type]  # the point
        (Decision("stop", num_steps=0), "num_steps must be a whole number from 1, got 0"),
        (Decision("stop", num_steps=True), "num_steps must be a whole number from 1, got True"),
        (Decision("stop", approaching=1), "approaching must be True or False, got 1"),  # type: ignore[arg-type]  # the point
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_whoever_is_to_blame_is_named(small: Release, nonsense: Any, reason: str) -> None:
    run = make_run(small, "scripted")
    expected = f"policy 'scripted', episode 'small/4', step 1: .*{reason}"
    with pytest.raises(PolicyError, match=expected) as raised:
        run_episode(run, Scripted(Decision("turn_left"), nonsense), seed=0)
    assert (raised.value.policy, raised.value.episode_id, raised.value.step) == (
        "scripted",
        "small/4",
        1,
    )
    assert len(run.rows) == 1
    again = pickle.loads(pickle.dumps(raised.value))  # as it comes back from another process
    assert (str(again), again.reason) == (str(raised.value), raised.value.reason)


def test_a_slow_policy_is_ended(small: Release) -> None:
    with pytest.raises(PolicyError, match="step 0: took more than 0 s to decide"):
        run_episode(make_run(small, "stay"), StayPolicy(), seed=0, max_policy_time_s=0.0)
