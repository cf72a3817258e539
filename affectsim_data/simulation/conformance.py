"""What every policy has to keep, as tests to inherit:

    class TestMine(PolicyConformance):
        def make_policy(self) -> Policy:
            return MyPolicy()

Under pytest, or any runner that calls methods `test_*` of classes `Test*`, this draws two short
episodes of `mini`; `make_runs` takes others.
"""

from __future__ import annotations

import copy
import dataclasses
from typing import Any

import numpy as np

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases import open_release
from affectsim_data.render import process_renderer
from affectsim_data.simulation.actions import ACTIONS, Budget
from affectsim_data.simulation.episodes import PolicyError, run_episode
from affectsim_data.simulation.policies.protocol import Decision, Policy, PrivilegedPolicy
from affectsim_data.simulation.running import EpisodeRun, Observation

__all__ = ["PRIVILEGED_PREFIX", "PolicyConformance"]

PRIVILEGED_PREFIX = "privileged:"
"""What the name of a policy begins with that is told what no robot knows, and of no other."""
_BUDGET = Budget(max_actions=40, max_planner_calls=20)
_SIZE = 112
"""Side of the images, pixels: enough to look at, and soon drawn."""


class PolicyConformance:
    """Tests that a policy does what `Policy` says; inherit and say which in `make_policy`."""

    def make_policy(self) -> Policy:
        """A new object of the policy.

        Raises:
            NotImplementedError: The class that inherits does not say which policy.
        """
        raise NotImplementedError("make_policy has to return a new object of the policy")

    def make_runs(self, policy: Policy) -> list[EpisodeRun]:
        """Two episodes that nothing was done in yet, always the same two."""
        release = open_release("mini")
        runs = []
        for index in (0, 1):
            episode = release.episode("test", index)
            runs.append(
                EpisodeRun(
                    episode,
                    release.world(episode),
                    release.navmesh(episode.scene_id),
                    process_renderer(),
                    policy=policy.name,
                    camera=release.manifest.camera.resized(width=_SIZE, height=_SIZE),
                    budget=_BUDGET,
                )
            )
        return runs

    def test_name_is_text_on_one_line(self) -> None:
        name = self.make_policy().name
        assert isinstance(name, str), f"name must be text, got {name!r}"
        plain = name.isprintable() and name == name.strip() != ""
        assert plain, f"name must be printable, without spaces around it, got {name!r}"

    def test_privileged_policies_say_so_in_their_name(self) -> None:
        policy = self.make_policy()
        told = isinstance(policy, PrivilegedPolicy)
        said = policy.name.startswith(PRIVILEGED_PREFIX)
        assert told == said, (
            f"{policy.name!r} {'has' if told else 'lacks'} a method reveal; "
            f"with one a name begins with {PRIVILEGED_PREFIX!r}, and no other does"
        )

    def test_decisions_are_allowed_and_episodes_end(self) -> None:
        policy = self.make_policy()
        for run in self.make_runs(policy):
            run_episode(run, policy, seed=0)  # raises PolicyError for what is not allowed
            assert run.outcome is not None, "the episode must end"
            assert all(row["action"] in ACTIONS for row in run.rows), "only actions are written"

    def test_hands_off_at_most_once(self) -> None:
        policy = self.make_policy()
        for run in self.make_runs(policy):
            actions = [row["action"] for row in run_episode(run, policy, seed=0).rows]
            count = actions.count("hand_off")
            assert count <= 1, f"handed off {count} times; to wait after the handoff, 'stop'"

    def test_same_seed_same_trajectory(self) -> None:
        assert self._trajectories(self.make_policy()) == self._trajectories(self.make_policy()), (
            "two new objects, the same seed and episodes, and they did not do the same"
        )

    def test_reset_forgets(self) -> None:
        used = self.make_policy()
        self._trajectories(used, seed=1)
        assert self._trajectories(used) == self._trajectories(self.make_policy()), (
            "a policy that acted in other episodes before does not do what a new one does"
        )

    def test_reset_forgets_an_episode_that_was_left(self) -> None:
        used = self.make_policy()
        run = self.make_runs(used)[-1]
        try:
            run_episode(run, _watched(used, leaves_after=5), seed=1)
        except PolicyError as error:
            if not isinstance(error.__cause__, _LeftError):
                raise
        assert self._trajectories(used) == self._trajectories(self.make_policy()), (
            "a policy whose last episode was left in the middle does not do what a new one does"
        )

    def test_observations_are_left_as_they_are(self) -> None:
        policy = self.make_policy()
        watched = _watched(policy)
        for run in self.make_runs(policy):
            run_episode(run, watched, seed=0)
        assert not watched.changed, (
            f"act changed what it was given: {', '.join(sorted(watched.changed))}"
        )

    def _trajectories(self, policy: Policy, *, seed: int = 0) -> list[list[dict[str, Any]]]:
        return [run_episode(run, policy, seed=seed).rows for run in self.make_runs(policy)]


class _LeftError(Exception):
    """An episode is left in the middle."""


@dataclasses.dataclass
class _Watched:
    """A policy under watch: what it changes of its observations, and when to leave it."""

    policy: Policy
    leaves_after: int | None
    changed: set[str] = dataclasses.field(default_factory=set)
    num_asked: int = 0

    @property
    def name(self) -> str:
        return self.policy.name

    def reset(self, camera: Camera, *, seed: int) -> None:
        self.policy.reset(camera, seed=seed)

    def act(self, observation: Observation) -> Decision:
        if self.num_asked == self.leaves_after:
            raise _LeftError
        self.num_asked += 1
        before = copy.deepcopy(observation)
        decision = self.policy.act(observation)
        self.changed |= {
            field.name
            for field in dataclasses.fields(Observation)
            if not np.array_equal(getattr(before, field.name), getattr(observation, field.name))
        }
        return decision


class _WatchedPrivileged(_Watched):
    """The same for one that is told the truth."""

    def reveal(self, episode: Episode, world: World, navmesh: NavMesh) -> None:
        assert isinstance(self.policy, PrivilegedPolicy)
        self.policy.reveal(episode, world, navmesh)


def _watched(policy: Policy, *, leaves_after: int | None = None) -> _Watched:
    kind = _WatchedPrivileged if isinstance(policy, PrivilegedPolicy) else _Watched
    return kind(policy, leaves_after)
