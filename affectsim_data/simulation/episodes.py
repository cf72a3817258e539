"""A whole episode: a policy is asked, and the robot acts, until it is over."""

from __future__ import annotations

import dataclasses
import time
from typing import Any

from affectsim_data.simulation.actions import ACTIONS
from affectsim_data.simulation.policies.protocol import Decision, Policy, PrivilegedPolicy
from affectsim_data.simulation.running import EpisodeRun, Outcome

__all__ = ["PolicyError", "RunResult", "run_episode"]


class PolicyError(RuntimeError):
    """A policy raised, took too long, or decided something that is not to be decided.

    Attributes:
        policy: Its name.
        episode_id: Where.
        step: Actions done before.
        reason: What happened.
    """

    def __init__(self, *, policy: str, episode_id: str, step: int, reason: str) -> None:
        super().__init__(f"policy {policy!r}, episode {episode_id!r}, step {step}: {reason}")
        self.policy, self.episode_id = policy, episode_id
        self.step, self.reason = step, reason

    def __reduce__(self) -> tuple[object, ...]:
        return (_policy_error, (self.policy, self.episode_id, self.step, self.reason))


def _policy_error(policy: str, episode_id: str, step: int, reason: str) -> PolicyError:
    return PolicyError(policy=policy, episode_id=episode_id, step=step, reason=reason)


@dataclasses.dataclass(frozen=True)
class RunResult:
    """What became of an episode."""

    rows: list[dict[str, Any]]
    """The trajectory, a row of the contract's table per action."""
    outcome: Outcome
    """How it ended; all but `collected` fall back to p_init."""
    policy_time_s: float = dataclasses.field(compare=False)
    """Spent in the policy; drawing is not counted."""


def run_episode(
    run: EpisodeRun, policy: Policy, *, seed: int, max_policy_time_s: float | None = None
) -> RunResult:
    """Has a policy act in an episode until it is over; it is asked on after the handoff.

    Whatever goes wrong, `run.rows` keeps what was done until then.

    Args:
        run: The episode, nothing done in it yet.
        policy: What moves the robot; a privileged one is told the truth first.
        seed: Given to the policy.
        max_policy_time_s: What the policy may take altogether; looked at between steps, so a
            policy that never comes back has to be ended from outside.

    Raises:
        ValueError: The episode has begun.
        PolicyError: The policy raised, returned nonsense, or took too long.
    """
    if run.num_steps:
        raise ValueError(f"{run.episode.episode_id}: has begun, {run.num_steps} actions are done")
    asked = _Asked(run, policy, max_policy_time_s)
    asked.begin(seed)
    while run.outcome is None:
        asked.step()
    return RunResult(run.rows, run.outcome, asked.time_s)


class _Asked:
    """A policy being asked, by the clock, and blamed by name."""

    def __init__(self, run: EpisodeRun, policy: Policy, max_time_s: float | None) -> None:
        self._run, self._policy, self._max_time_s = run, policy, max_time_s
        self.time_s = 0.0

    def begin(self, seed: int) -> None:
        """Resets the policy, and tells it what it is privileged to know."""
        started = time.perf_counter()
        try:
            self._policy.reset(self._run.camera, seed=seed)
            if isinstance(self._policy, PrivilegedPolicy):
                self._policy.reveal(self._run.episode, self._run.world, self._run.navmesh)
        except Exception as error:
            raise self._blame(f"{type(error).__name__}: {error}") from error
        self._took(started)

    def step(self) -> None:
        """One look, one decision, its actions."""
        observation = self._run.observe()
        started = time.perf_counter()
        try:
            decision = self._policy.act(observation)
        except Exception as error:
            raise self._blame(f"{type(error).__name__}: {error}") from error
        self._took(started)
        if problem := _problem(decision):
            raise self._blame(problem)
        planner_calls = decision.planner_calls
        for _ in range(decision.num_steps):
            self._run.act(
                decision.action, planner_calls=planner_calls, approaching=decision.approaching
            )
            planner_calls = 0
            if self._run.outcome is not None:
                break

    def _took(self, started: float) -> None:
        self.time_s += time.perf_counter() - started
        if self._max_time_s is not None and self.time_s > self._max_time_s:
            raise self._blame(f"took more than {self._max_time_s:g} s to decide")

    def _blame(self, reason: str) -> PolicyError:
        return PolicyError(
            policy=self._policy.name,
            episode_id=self._run.episode.episode_id,
            step=self._run.num_steps,
            reason=reason,
        )


def _problem(decision: object) -> str:
    """What is wrong with what a policy returned; empty if nothing is."""
    if not isinstance(decision, Decision):
        return f"act must return a Decision, got {decision!r}"
    action, calls, approaching, steps = dataclasses.astuple(decision)
    if action not in ACTIONS:
        return f"action must be one of {', '.join(ACTIONS)}, got {action!r}"
    if not isinstance(calls, int) or isinstance(calls, bool) or calls < 0:
        return f"planner_calls must be a whole number from 0, got {calls!r}"
    if not isinstance(approaching, bool):
        return f"approaching must be True or False, got {approaching!r}"
    if not isinstance(steps, int) or isinstance(steps, bool) or steps < 1:
        return f"num_steps must be a whole number from 1, got {steps!r}"
    return ""
