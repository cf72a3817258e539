"""One episode in motion: the robot acts, the person goes on, and what happened is written down."""

from __future__ import annotations

import dataclasses
import math
import operator
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations.active import clip_start_s
from affectsim_data.observations.still import head_camera_pose
from affectsim_data.poses import FloatArray
from affectsim_data.render import ClipSpec, PosedAvatar, Renderer
from affectsim_data.schemas import Phase
from affectsim_data.simulation.actions import ACTION_RATE_HZ, ACTIONS, Action, Budget
from affectsim_data.simulation.moving import RobotState, after, wrapped_angle

__all__ = ["EpisodeRun", "Observation", "Outcome", "Phase"]

_MOST_CALLS = 10**6
"""Of a planner in one step, so that the table can hold the sum over an episode."""
Outcome = Literal["collected", "stopped", "actions_exhausted", "planner_calls_exhausted"]
"""How an episode ended; all but the first fall back to p_init."""


@dataclasses.dataclass(frozen=True)
class Observation:
    """All a policy may know; nothing in it says where the person is or what they feel."""

    rgb: NDArray[np.uint8]
    """`(height, width, 3)`, sRGB."""
    depth: NDArray[np.float32]
    """`(height, width)`, metres along the view axis, `inf` where nothing was hit."""
    position: FloatArray
    """Of the robot in its own starting frame, +X right and -Z ahead, metres, `(3,)`."""
    yaw: float
    """Turned since the start, radians, counter-clockwise from above, in (-pi, pi]."""
    camera_height_m: float
    time_s: float
    """Since the start of the episode."""
    actions_left: int
    planner_calls_left: int
    clipped: bool
    """Whether the last move was cut short."""
    collecting: bool
    """Whether the handoff is done."""
    camera: Camera
    """Of the images."""


class EpisodeRun:
    """An episode being acted in.

    The clip is recorded over two whole cycles of the motion, from the first instant after the
    handoff at which the motion is where the clips of all other conditions begin. So it differs
    from theirs in the camera alone.
    """

    def __init__(
        self,
        episode: Episode,
        world: World,
        navmesh: NavMesh,
        renderer: Renderer,
        *,
        policy: str,
        camera: Camera | None = None,
        budget: Budget | None = None,
    ) -> None:
        """Puts the robot where the episode starts; nothing is drawn yet.

        Args:
            episode: Which one.
            world: What its identifiers stand for.
            navmesh: Of its scene.
            renderer: Draws what the robot sees.
            policy: Name the rows carry.
            camera: Of the images; that of the release if not given.
            budget: What the search may cost; the paper's if not given.

        Raises:
            ValueError: The episode starts off the navmesh.
        """
        if not navmesh.is_navigable(episode.start_position):
            raise ValueError(
                f"{episode.episode_id}: the robot starts at {episode.start_position}, off the "
                f"navmesh of {episode.scene_id}; `affectsim validate` tells what else is wrong"
            )
        self.episode, self.world = episode, world
        self.budget = Budget() if budget is None else budget
        self.camera = world.camera if camera is None else camera
        self._navmesh, self._renderer, self._policy = navmesh, renderer, policy
        self._state = RobotState(episode.start_position, episode.start_yaw)
        self._planner_calls = 0
        self._handoff_step: int | None = None
        self._rows: list[dict[str, Any]] = []
        self._outcome: Outcome | None = None
        self._posed: tuple[float, tuple[FloatArray, ...]] | None = None

    @property
    def state(self) -> RobotState:
        """Where the robot is; privileged."""
        return self._state

    @property
    def navmesh(self) -> NavMesh:
        """Where it can go; privileged."""
        return self._navmesh

    @property
    def num_steps(self) -> int:
        """Actions so far."""
        return len(self._rows)

    @property
    def time_s(self) -> float:
        """Since the start."""
        return self.num_steps / ACTION_RATE_HZ

    @property
    def outcome(self) -> Outcome | None:
        """How the episode ended, `None` while it goes on."""
        return self._outcome

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The trajectory so far, a row of the contract's table per action."""
        return list(self._rows)

    @property
    def clip_start_s(self) -> float | None:
        """When the clip begins, `None` before the handoff."""
        if self._handoff_step is None:
            return None
        return clip_start_s(self._handoff_step / ACTION_RATE_HZ, self.episode.duration_s)

    @property
    def _clip_end_s(self) -> float:
        start = self.clip_start_s
        return math.inf if start is None else start + 2.0 * self.episode.duration_s

    def people(self, time_s: float) -> FloatArray:
        """Pelvis of each participant, `(n, 3)`; privileged."""
        pelvises = []
        for person, joints in zip(self.world.people, self._joints(time_s), strict=True):
            rest = person.avatar.skeleton.rest_positions[0]
            pelvises.append(joints[0, 0, :3, :3] @ rest + joints[0, 0, :3, 3])
        return np.stack(pelvises)

    def _joints(self, time_s: float) -> tuple[FloatArray, ...]:
        """`joint_matrices` of each participant; kept, because a step asks twice."""
        if self._posed is None or self._posed[0] != time_s:
            instant = np.array([self.episode.phase_s + time_s])
            joints = tuple(person.joint_matrices(instant) for person in self.world.people)
            self._posed = (time_s, joints)
        return self._posed[1]

    def observe(self) -> Observation:
        """What the robot sees and knows now."""
        spec = self._spec()
        images = self._renderer.render(spec)
        start = np.array(self.episode.start_position)
        turn = self.episode.start_yaw
        away = np.array(self._state.position) - start
        back = np.array(
            [[math.cos(turn), 0.0, -math.sin(turn)], [0, 1, 0], [math.sin(turn), 0, math.cos(turn)]]
        )
        search_steps = self.num_steps if self._handoff_step is None else self._handoff_step
        return Observation(
            rgb=images.rgb[0],
            depth=images.depth[0],
            position=back @ away,
            yaw=wrapped_angle(self._state.yaw - turn),
            camera_height_m=self.world.robot.camera_height_m,
            time_s=self.time_s,
            actions_left=max(self.budget.max_actions - search_steps, 0),
            planner_calls_left=max(self.budget.max_planner_calls - self._planner_calls, 0),
            clipped=self._state.clipped,
            collecting=self._handoff_step is not None,
            camera=self.camera,
        )

    def act(self, action: Action, *, planner_calls: int = 0, approaching: bool = False) -> None:
        """Does one action.

        Args:
            action: Which one. `hand_off` begins the collection and takes a step of its own;
                repeated, it waits. `stop` before the handoff gives up, after it waits.
            planner_calls: Calls the policy made of its planner to choose it. Before the handoff,
                calls beyond the budget end the episode: what they led to is not done, and `stop`
                is written down.
            approaching: Whether the policy goes to a view of a person it has found.

        Raises:
            ValueError: Not an action, not a count, or the episode is over.
        """
        if self._outcome is not None:
            raise ValueError(f"{self.episode.episode_id}: is over ({self._outcome})")
        if not isinstance(action, str) or action not in ACTIONS:
            raise ValueError(f"action must be one of {', '.join(ACTIONS)}, got {action!r}")
        planner_calls = _count(planner_calls)
        calls_left = self.budget.max_planner_calls - self._planner_calls
        if self._handoff_step is None and planner_calls > calls_left:
            action = "stop"
        ended_s = (self.num_steps + 1) / ACTION_RATE_HZ
        self._state = after(self._state, action, self._navmesh, self.people(ended_s))
        self._planner_calls += planner_calls
        collecting = self._handoff_step is not None or action == "hand_off"
        phase: Phase = "collect" if collecting else "approach" if approaching else "search"
        self._write(action, phase)
        if self._handoff_step is None and action == "hand_off":
            self._handoff_step = self.num_steps
        self._outcome = self._ended(action)

    def _write(self, action: Action, phase: Phase) -> None:
        x, y, z = self._state.position
        self._rows.append(
            {
                "episode_id": self.episode.episode_id,
                "policy": self._policy,
                "step": self.num_steps,
                "time_s": (self.num_steps + 1) / ACTION_RATE_HZ,
                "action": action,
                "position_x_m": x,
                "position_y_m": y,
                "position_z_m": z,
                "yaw_deg": math.degrees(self._state.yaw),
                "clipped": self._state.clipped,
                "phase": phase,
                "planner_calls": self._planner_calls,
            }
        )

    def _ended(self, action: Action) -> Outcome | None:
        if self._handoff_step is not None:
            return "collected" if self.time_s >= self._clip_end_s - 1e-9 else None
        if self._planner_calls >= self.budget.max_planner_calls:
            return "planner_calls_exhausted"
        if self.num_steps >= self.budget.max_actions:
            return "actions_exhausted"
        return "stopped" if action == "stop" else None

    def _spec(self) -> ClipSpec:
        people = tuple(
            PosedAvatar(person.avatar, joints)
            for person, joints in zip(self.world.people, self._joints(self.time_s), strict=True)
        )
        pose = head_camera_pose(
            np.array(self._state.position), np.array(self._state.yaw), self.world.robot
        )
        return ClipSpec(
            self.world.scene, people, self.camera, CameraTrajectory.still(pose, num_frames=1)
        )


def _count(planner_calls: int) -> int:
    try:
        count = operator.index(planner_calls)
    except TypeError:
        count = -1
    if not 0 <= count <= _MOST_CALLS:
        raise ValueError(
            f"planner_calls must be a whole number in [0, {_MOST_CALLS}], got {planner_calls!r}"
        )
    return count
