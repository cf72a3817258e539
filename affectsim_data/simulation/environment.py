"""`AffectSimEnv`: episodes to act in, as Gymnasium has it. Needs the extra `sim`."""

from __future__ import annotations

import operator
import weakref
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Episode
from affectsim_data.errors import require_extra
from affectsim_data.releases import Release, open_release
from affectsim_data.releases.filters import Filter
from affectsim_data.releases.selection import select_rows
from affectsim_data.releases.splits import SplitBy
from affectsim_data.render import RendererName, process_renderer
from affectsim_data.render.processes import Owner, Suspendable
from affectsim_data.simulation.actions import ACTION_RATE_HZ, ACTIONS, Budget
from affectsim_data.simulation.privileged import privileged_facts
from affectsim_data.simulation.running import EpisodeRun, Observation

require_extra("gymnasium", extra="sim")

import gymnasium  # noqa: E402 - after the check, whose error names the extra
from gymnasium import spaces  # noqa: E402

from affectsim_data.simulation.observed import as_arrays, observation_space  # noqa: E402

__all__ = ["AffectSimEnv"]

_POLICY = "gymnasium"
"""What the rows of a run in the environment carry in the column `policy`."""

_open_environments: weakref.WeakSet[AffectSimEnv] = weakref.WeakSet()


class AffectSimEnv(gymnasium.Env[dict[str, Any], np.int64]):
    """A robot in an episode, from where P-Init stands still; see docs/simulation.md.

    Actions are numbers of `ACTIONS`. The reward is 0: what was acquired is judged by a recognizer,
    afterwards. `terminated` once the clip is collected or the robot stopped before handing off,
    `truncated` once the budget is spent. `info` is empty unless asked for.

    Examples:
        >>> import gymnasium, affectsim_data.simulation
        >>> env = gymnasium.make("AffectSim/ActiveObservation-v0", split="test")  # doctest: +SKIP
        >>> observation, _ = env.reset(seed=0)  # doctest: +SKIP
        >>> observation["rgb"].shape  # doctest: +SKIP
        (224, 224, 3)
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": int(ACTION_RATE_HZ)}  # noqa: RUF012

    def __init__(
        self,
        release: str | Path | Release = "mini",
        *,
        split: str = "test",
        split_by: SplitBy = "group",
        filter: Filter | None = None,
        episodes: Iterable[str] | None = None,
        size: int | None = None,
        budget: Budget | None = None,
        shuffle: bool = True,
        rank: int = 0,
        world_size: int = 1,
        privileged_info: bool = False,
        render_mode: str | None = None,
        renderer: RendererName = "egl",
        device: int | None = None,
    ) -> None:
        """Opens the release; nothing is drawn and no GL context is made before the first reset.

        Args:
            release: `mini` (built on first use), a folder, `hf://datasets/ORG/NAME@REVISION`, or
                a release already open.
            split: `train`, `validation` or `test`.
            split_by: What no two splits share: `group`, `scene` or `both`.
            filter: Only episodes whose columns match, as `AffectSimDataset` takes them.
            episodes: Only the episodes with these identifiers.
            size: Side of the square image in pixels; the release's image if not given.
            budget: What a search may cost; the paper's if not given.
            shuffle: Whether every pass over the episodes is in a new order drawn from the seed of
                `reset`, or in the order they stand in.
            rank: Which share of the episodes is this environment's, from 0; a share does not
                depend on the seed, so no two ranks ever act in the same episode.
            world_size: How many shares there are.
            privileged_info: Whether `info` tells what no robot knows; for debugging.
            render_mode: `rgb_array`, for `render`, or none.
            renderer: `egl`, or `pyrender`, the slow reference.
            device: EGL device; the one `open_renderer` would take if not given.

        Raises:
            FileNotFoundError: No such release, or not all of it.
            ValueError: A malformed argument, or no episode left.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode must be 'rgb_array' or None, got {render_mode!r}")
        self.render_mode = render_mode
        self._release = release if isinstance(release, Release) else open_release(release)
        self._table = self._release.split_table(split, split_by)
        rows = select_rows(
            self._release, split, split_by=split_by, filter=filter, episodes=episodes
        )
        self._rows = _share(rows, rank, world_size)
        self._camera = _square(self._release.manifest.camera, size)
        self._budget = Budget() if budget is None else budget
        self._shuffle, self._privileged_info = shuffle, privileged_info
        self._renderer: tuple[RendererName, int | None] = (renderer, device)
        self._order: list[int] = []
        self._owner: Owner | None = None
        self._run: EpisodeRun | None = None
        self._latest: Observation | None = None
        self._planner_calls = 0
        self.observation_space = observation_space(self._camera, self._budget)
        self.action_space = spaces.Discrete(len(ACTIONS))

    @property
    def run(self) -> EpisodeRun:
        """The episode at hand, with the rows of its trajectory; privileged.

        Raises:
            gymnasium.error.ResetNeeded: There is none before the first reset.
        """
        if self._run is None:
            raise gymnasium.error.ResetNeeded("there is no episode yet; call reset() first")
        return self._run

    @property
    def num_episodes(self) -> int:
        """Episodes of this environment's share."""
        return len(self._rows)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begins the next episode: its first observation, and `info`.

        Args:
            seed: Begins a new pass over the episodes, in the order it stands for.
            options: `{"episode_id": ...}` for that episode of this environment's share; the pass
                is not touched.

        Raises:
            ValueError: Another option, or no such episode.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._order = []
        episode = self._next_episode() if not options else self._chosen_episode(options)
        self._run = EpisodeRun(
            episode,
            self._release.world(episode),
            self._release.navmesh(episode.scene_id),
            process_renderer(*self._renderer),
            policy=_POLICY,
            camera=self._camera,
            budget=self._budget,
        )
        self._owner, self._planner_calls = Owner(), 0
        _open_environments.add(self)
        return self._observe(), self._info()

    def step(
        self, action: int | np.int64
    ) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Does one action: observation, reward 0, terminated, truncated, `info`.

        Raises:
            ValueError: Not the number of an action, or the episode is over.
        """
        if not self.action_space.contains(action):
            listed = ", ".join(f"{number} {name}" for number, name in enumerate(ACTIONS))
            raise ValueError(f"action must be one of {listed}; got {action!r}")
        run = self.run
        run.act(ACTIONS[int(action)], planner_calls=self._planner_calls)
        self._planner_calls = 0
        terminated = run.outcome in ("collected", "stopped")
        truncated = run.outcome is not None and not terminated
        return self._observe(), 0.0, terminated, truncated, self._info()

    def charge(self, planner_calls: int = 1) -> None:
        """Has calls of a planner count against the budget with the next step.

        Raises:
            ValueError: Less than none, or not a whole number.
        """
        if operator.index(planner_calls) < 0:
            raise ValueError(f"planner_calls must be at least 0, got {planner_calls}")
        self._planner_calls += operator.index(planner_calls)

    def render(self) -> NDArray[np.uint8] | None:
        """What the robot sees, `(height, width, 3)`; `None` without a `render_mode`."""
        if self.render_mode is None:
            return None
        if self._latest is None:
            raise gymnasium.error.ResetNeeded("there is nothing to see yet; call reset() first")
        return self._latest.rgb.copy()

    def close(self) -> None:
        """Ends the episode. The last environment of a process has its renderer's memory freed."""
        self._run = self._latest = None
        _open_environments.discard(self)
        used = {environment._renderer for environment in _open_environments}
        if self._owner is None or not self._owner.is_here or self._renderer in used:
            return
        renderer = process_renderer(*self._renderer)
        # Not closed for good: data sets of this process may draw with it later.
        if isinstance(renderer, Suspendable):
            renderer.suspend()
        self._owner = None

    def _next_episode(self) -> Episode:
        if not self._order:
            order = np.arange(len(self._rows))
            if self._shuffle:
                # Not `permutation`: NumPy promises raw words to stay, but not what is made of them.
                words = self.np_random.bit_generator.random_raw(len(order))
                order = np.argsort(words, kind="stable")
            self._order = order[::-1].tolist()
        return self._table.episode(int(self._rows[self._order.pop()]))

    def _chosen_episode(self, options: dict[str, Any]) -> Episode:
        if set(options) != {"episode_id"}:
            raise ValueError(f"options may hold 'episode_id' alone, got {sorted(options)}")
        wanted = options["episode_id"]
        known = self._table.index.column("episode_id")
        place = known.index(wanted).as_py() if isinstance(wanted, str) else -1
        if place not in self._rows:
            raise ValueError(
                f"options: episode {wanted!r} is not among the {len(self._rows)} of this "
                f"environment, such as {known[int(self._rows[0])].as_py()!r}"
            )
        return self._table.episode(place)

    def _observe(self) -> dict[str, Any]:
        self._latest = self.run.observe()
        return as_arrays(self._latest)

    def _info(self) -> dict[str, Any]:
        return privileged_facts(self.run) if self._privileged_info else {}


def _share(rows: NDArray[np.int64], rank: int, world_size: int) -> NDArray[np.int64]:
    """Every `world_size`-th place from `rank` on."""
    if not 0 <= rank < world_size:
        raise ValueError(
            f"rank must be in [0, world_size), got rank={rank!r}, world_size={world_size!r}"
        )
    share = rows[rank::world_size]
    if not len(share):
        raise ValueError(
            f"{len(rows)} episodes leave none for rank {rank} of {world_size}; take fewer ranks"
        )
    return share


def _square(camera: Camera, size: int | None) -> Camera:
    return camera if size is None else camera.resized(width=size, height=size)
