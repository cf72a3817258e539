"""Every policy of ours keeps the protocol, and every rule notices the policy that breaks it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from acting_runs import make_run

from affectsim_data.cameras import Camera
from affectsim_data.releases import Release
from affectsim_data.render import Renderer, process_renderer
from affectsim_data.simulation.actions import Budget
from affectsim_data.simulation.blind import BlindRenderer
from affectsim_data.simulation.conformance import PolicyConformance
from affectsim_data.simulation.episodes import PolicyError
from affectsim_data.simulation.policies import Decision, Policy
from affectsim_data.simulation.policies.guided import reference, straight_to_target
from affectsim_data.simulation.policies.limited_search import LimitedSearch
from affectsim_data.simulation.policies.standing import RandomPolicy, StayPolicy
from affectsim_data.simulation.running import EpisodeRun, Observation


class OnSmall(PolicyConformance):
    """Conformance on the two test episodes of the small release, without drawing."""

    @pytest.fixture(autouse=True)
    def _release(self, small: Release) -> None:
        self.small = small

    def make_renderer(self) -> Renderer:
        return BlindRenderer()

    def make_runs(self, policy: Policy) -> list[EpisodeRun]:
        budget = Budget(max_actions=30, max_planner_calls=20)
        camera = Camera(width=112, height=112, hfov=math.radians(60.0))
        renderer = self.make_renderer()
        return [
            make_run(
                self.small,
                policy.name,
                index=index,
                renderer=renderer,
                camera=camera,
                budget=budget,
            )
            for index in (0, 1)
        ]


class TestStay(OnSmall):
    def make_policy(self) -> Policy:
        return StayPolicy()


class TestRandom(OnSmall):
    def make_policy(self) -> Policy:
        return RandomPolicy(12)


class TestStraightToTarget(OnSmall):
    def make_policy(self) -> Policy:
        return straight_to_target()


class TestReference(OnSmall):
    def make_policy(self) -> Policy:
        return reference()


@pytest.mark.egl
class TestLimitedSearch(OnSmall):
    def make_renderer(self) -> Renderer:
        return process_renderer()

    def make_policy(self) -> Policy:
        return LimitedSearch()


@pytest.mark.egl
class TestOnMini(PolicyConformance):
    """As somebody else would inherit it: nothing but the policy is given."""

    def make_policy(self) -> Policy:
        return StayPolicy()


def test_a_policy_has_to_be_given() -> None:
    with pytest.raises(NotImplementedError, match="make_policy has to return a new object"):
        PolicyConformance().test_reset_forgets()


class Faulty:
    """A policy that breaks one rule at a time."""

    name = "faulty"

    def __init__(self, fault: str) -> None:
        self._fault = fault
        self._resets = 0
        self._rng = np.random.default_rng()
        if fault == "named":
            self.name = "two\nlines"
        if fault == "secret":
            self.reveal = lambda episode, world, navmesh: None

    def reset(self, camera: Camera, *, seed: int) -> None:
        self._resets += 1
        if self._fault != "left" or self._resets == 1:
            self._count = 0

    def act(self, observation: Observation) -> Decision:
        self._count = self._count + 1
        fault = self._fault
        if fault == "scribbles":
            observation.rgb[0, 0] = 255
        if fault == "flies":
            return Decision("fly")  # type: ignore[arg-type]  # the point
        if fault == "unseeded" and not observation.collecting and self._rng.random() < 0.5:
            return Decision("turn_left")
        if fault == "remembers" and self._resets > 2 and self._count == 1:
            return Decision("turn_right")
        if fault == "left" and self._count > 3:
            return Decision("turn_right" if not observation.collecting else "stop")
        again = fault == "again" and self._count < 4
        return Decision("hand_off" if not observation.collecting or again else "stop")


RULES = {
    "named": "name_is_text_on_one_line",
    "secret": "privileged_policies_say_so_in_their_name",
    "flies": "decisions_are_allowed_and_episodes_end",
    "again": "hands_off_at_most_once",
    "unseeded": "same_seed_same_trajectory",
    "remembers": "reset_forgets",
    "left": "reset_forgets_an_episode_that_was_left",
    "scribbles": "observations_are_left_as_they_are",
}


@pytest.mark.parametrize("fault", RULES)
def test_each_rule_notices_its_fault(small: Release, fault: str) -> None:
    tests = OnSmall()
    tests.small = small
    tests.make_policy = lambda: Faulty(fault)  # type: ignore[method-assign]  # one class, many faults
    with pytest.raises((AssertionError, PolicyError)):
        getattr(tests, f"test_{RULES[fault]}")()


def test_every_rule_has_a_fault_that_breaks_it() -> None:
    rules = {name for name in vars(PolicyConformance) if name.startswith("test_")}
    assert rules == {f"test_{rule}" for rule in RULES.values()}
