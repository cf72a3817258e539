"""You learn: write a policy of your own in 30 lines, have it act, and read what it did.

The same class acts in a whole split, in parallel and resumable, with
affectsim acquire mini --policy module:14_own_policy:GoesWhereItMoves --out own.parquet
run with this folder on PYTHONPATH.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np
import pyarrow as pa

from affectsim_data import open_release
from affectsim_data.cameras import Camera
from affectsim_data.evaluation.acquisition import acquisitions
from affectsim_data.render import process_renderer
from affectsim_data.schemas import SCHEMAS
from affectsim_data.simulation import EpisodeRun, Observation
from affectsim_data.simulation.episodes import run_episode
from affectsim_data.simulation.policies import Decision


class GoesWhereItMoves:
    """Looks round for where the picture changes, goes there, and hands off before what it meets."""

    name = "goes_where_it_moves"  # stands in the table: the policy and its configuration

    def reset(self, camera: Camera, *, seed: int) -> None:
        self._course = self._go()
        next(self._course)  # up to the first observation

    def act(self, observation: Observation) -> Decision:
        return self._course.send(observation)

    def _go(self) -> Generator[Decision, Observation, None]:
        seen = yield Decision("stop")  # given to nobody
        changes = []
        for _ in range(12):  # headings 30 degrees apart
            before = seen.rgb.astype(int)
            yield Decision("turn_left")  # there is no waiting: away, and back to the same view
            seen = yield Decision("turn_right")
            changes.append(np.abs(seen.rgb - before).mean())
            yield Decision("turn_left")
            seen = yield Decision("turn_left")
        for _ in range(2 * int(np.argmax(changes))):
            seen = yield Decision("turn_left", approaching=True)
        while not seen.clipped and np.median(seen.depth[40:80, 40:72]) > 2.2:
            seen = yield Decision("move_forward", approaching=True)
        yield Decision("hand_off")
        while True:  # the clip is collected: `stop` waits
            yield Decision("stop")


def main() -> None:
    release, policy = open_release("mini"), GoesWhereItMoves()
    episodes = [release.episode("test", index) for index in range(3)]
    rows = []
    for episode in episodes:
        world, navmesh = release.world(episode), release.navmesh(episode.scene_id)
        camera = world.camera.resized(width=112, height=112)
        run = EpisodeRun(
            episode, world, navmesh, process_renderer(), policy=policy.name, camera=camera
        )
        rows += run_episode(run, policy, seed=0).rows
    table = pa.Table.from_pylist(rows, SCHEMAS["trajectories"])
    ids = np.array([episode.episode_id for episode in episodes])
    starts = [episode.start_position for episode in episodes]
    done = acquisitions(table, ids, starts, policy=policy.name)
    print(f"handed off in {done.handed_off.sum()} of {len(ids)} episodes")
    print(f"mean way {done.path_length_m.mean():.1f} m, {done.num_steps.mean():.0f} actions")
    print(f"cut short: {done.num_clipped.sum()} of {done.num_translations.sum()} moves")


if __name__ == "__main__":
    main()
