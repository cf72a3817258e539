"""What a process does in which a policy acts: it tells what it is about, and what came of it."""

from __future__ import annotations

import dataclasses
import hashlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from typing import Any, Literal, TypeAlias, TypeVar

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.releases import Release
from affectsim_data.releases.splits import EpisodeTable, SplitBy
from affectsim_data.render import Renderer, open_renderer
from affectsim_data.simulation.episodes import PolicyError, run_episode
from affectsim_data.simulation.policies import Decision, Policy, PrivilegedPolicy
from affectsim_data.simulation.policies.opening import open_policy
from affectsim_data.simulation.running import EpisodeRun, Observation, Outcome

__all__ = [
    "Answered",
    "Asking",
    "Broken",
    "Ended",
    "Failed",
    "Job",
    "Message",
    "Note",
    "act_on_request",
]

_Found = TypeVar("_Found")
_BACKGROUND_BYTES = 320 * 2**20
"""Some 170 views of 224 x 224: robots that begin at the same place see much of the same."""
_LONGEST_REASON = 2000
"""Characters."""


@dataclasses.dataclass(frozen=True)
class Job:
    """Which policy acts in which episodes, the same in every process."""

    release: Release
    split: str
    split_by: SplitBy
    policy: str
    """As `open_policy` takes it."""
    name: str
    """What the policy calls itself."""
    seed: int
    """Of the run; every episode has its own, made of it."""
    max_policy_time_s: float
    """What the policy may take in an episode."""

    @property
    def episodes(self) -> EpisodeTable:
        """The split."""
        return self.release.split_table(self.split, self.split_by)

    def episode_seed(self, episode_id: str) -> int:
        """Seed of an episode, in [0, 2**63): no other episode and no process has a part in it."""
        digest = hashlib.sha256(f"{self.seed}\n{episode_id}".encode()).digest()
        return int.from_bytes(digest[:8], "big") >> 1


@dataclasses.dataclass(frozen=True)
class Asking:
    """The policy is asked now."""

    rows: list[dict[str, Any]]
    """Of the trajectory, since the last such note."""
    until_s: float
    """When its time is up, by `time.monotonic`, which is the same in all processes."""


class Answered:
    """The policy has come back."""


@dataclasses.dataclass(frozen=True)
class Ended:
    """An episode is over."""

    rows: list[dict[str, Any]]
    outcome: Outcome


@dataclasses.dataclass(frozen=True)
class Failed:
    """A policy failed in an episode."""

    rows: list[dict[str, Any]]
    reason: str


@dataclasses.dataclass(frozen=True)
class Broken:
    """Something else failed, so that no episode can be acted in."""

    error: Exception


Message: TypeAlias = Literal["ready"] | Ended | Failed | Broken
Note: TypeAlias = Asking | Answered


def act_on_request(job: Job, connection: Connection, notes: Connection) -> None:
    """Acts in the episodes asked for, by their places in the split, until the asker is gone.

    Args:
        job: Which policy acts, and where.
        connection: To the asker: places come in, messages go out.
        notes: Takes two notes a step. They have a line of their own, so that nobody need wake up
            for each of them.
    """
    # Ctrl-C reaches the whole group; the parent alone answers it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None:
        threading.Thread(target=_leave_with, args=(parent.sentinel,), daemon=True).start()
    try:
        policy = open_policy(job.policy)
        renderer = open_renderer(background_bytes=_BACKGROUND_BYTES)
        connection.send("ready")
        while True:
            message = _act(job, policy, renderer, connection.recv(), notes)
            connection.send(message)
            if isinstance(message, Failed):
                policy = open_policy(job.policy)  # whatever state the old one is in
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return
    except Exception as error:
        _send_error(connection, error)


def _leave_with(sentinel: int) -> None:
    wait([sentinel])
    os._exit(1)


def _send_error(connection: Connection, error: Exception) -> None:
    try:
        connection.send(Broken(error))
    except Exception:  # what an error holds need not pickle
        connection.send(Broken(RuntimeError(f"{type(error).__name__}: {error}")))


def _act(
    job: Job, policy: Policy, renderer: Renderer, place: int, notes: Connection
) -> Ended | Failed:
    """A whole episode."""
    episode = job.episodes.episode(place)
    run = EpisodeRun(
        episode,
        job.release.world(episode),
        job.release.navmesh(episode.scene_id),
        renderer,
        policy=job.name,
    )
    kind = _WatchedPrivileged if isinstance(policy, PrivilegedPolicy) else _Watched
    try:
        result = run_episode(
            run,
            kind(policy, run, notes, limit_s=job.max_policy_time_s),
            seed=job.episode_seed(episode.episode_id),
            max_policy_time_s=job.max_policy_time_s,
        )
    except PolicyError as error:
        return Failed(run.rows, error.reason[:_LONGEST_REASON])
    return Ended(result.rows, result.outcome)


class _Watched:
    """A policy that says when it is asked and when it has come back."""

    def __init__(
        self, policy: Policy, run: EpisodeRun, notes: Connection, *, limit_s: float
    ) -> None:
        self._policy, self._run, self._notes = policy, run, notes
        self._left_s, self._told = limit_s, 0

    @property
    def name(self) -> str:
        """Of the policy."""
        return self._policy.name

    def reset(self, camera: Camera, *, seed: int) -> None:
        """As the policy's."""
        self._timed(lambda: self._policy.reset(camera, seed=seed))

    def act(self, observation: Observation) -> Decision:
        """As the policy's."""
        decision: Any = self._timed(lambda: self._policy.act(observation))
        # Only what is known can be shown safely: a stranger may fail when it is printed.
        if not isinstance(decision, Decision):
            raise TypeError(f"act must return a Decision, got a {type(decision).__name__}")
        if not isinstance(decision.action, str):
            raise TypeError(f"action must be text, got a {type(decision.action).__name__}")
        return decision

    def _timed(self, call: Callable[[], _Found]) -> _Found:
        rows = self._run.rows[self._told :]
        self._told += len(rows)
        self._notes.send(Asking(rows, time.monotonic() + max(self._left_s, 0.0)))
        started = time.perf_counter()
        try:
            return call()
        finally:
            self._left_s -= time.perf_counter() - started
            self._notes.send(Answered())


class _WatchedPrivileged(_Watched):
    """The same of a privileged policy."""

    def reveal(self, episode: Episode, world: World, navmesh: NavMesh) -> None:
        """As the policy's."""
        policy: Any = self._policy
        self._timed(lambda: policy.reveal(episode, world, navmesh))
