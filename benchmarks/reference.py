"""What planning a reference view costs, and how good the views are, on one core.

Every episode of the built-in release is planned anew where it is placed. *plan* is what a build
pays for each episode, *prepare* what it pays once for each performance. *rank* is the part of
*plan* that finds the best-scored candidate; its peer is the same search without bounds, which casts
the rays of all candidates as one batch. The column `ratio` is the peer's time over ours, both
measured in the same process.

python -m benchmarks.reference
"""

from __future__ import annotations

import dataclasses
import json
import sys
import time
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.parts import Rows, run_part, serve_part

if TYPE_CHECKING:
    from affectsim_data.episodes import Episode, World
    from affectsim_data.observations.tracks import BodyTrack

_ROUNDS = 3


def reference() -> Rows:
    """Milliseconds per episode and quality of the views, a row per action."""
    from affectsim_data.releases.opening import open_release

    release = open_release("mini")
    rows: dict[str, list[dict[str, float]]] = {}
    for split in ("train", "validation", "test"):
        for place in range(release.num_episodes(split)):
            episode = release.episode(split, place)
            rows.setdefault(episode.action, []).append(_costs(episode, release.world(episode)))
    return [
        {"action": action, "episodes": len(costs)} | _means(costs) for action, costs in rows.items()
    ]


def _means(costs: list[dict[str, float]]) -> dict[str, float]:
    means = {name: float(np.mean([one[name] for one in costs])) for name in costs[0]}
    return means | {"ratio": means["exhaustive_ms"] / means["rank_ms"]}


def _costs(episode: Episode, world: World) -> dict[str, float]:
    from affectsim_data.observations import ReferencePlanner, ReferenceSearch, body_track
    from affectsim_data.observations.checking import check_knots
    from affectsim_data.observations.ranking import Ranking
    from affectsim_data.observations.steadying import steady_path
    from affectsim_data.visibility import scene_caster

    caster, search, camera = scene_caster(world.scene), ReferenceSearch(), world.camera
    pose = world.target.T_world_performance
    samples = body_track(world.people).samples
    start = time.process_time()
    planner = ReferencePlanner(_at_home(world), camera, search)
    prepare_s = time.process_time() - start
    plan_s: list[float] = []
    rank_s: list[float] = []
    exhaustive_s: list[float] = []
    for _ in range(_ROUNDS):
        start = time.process_time()
        view, share = planner.plan(pose, caster)
        plan_s.append(time.process_time() - start)
        for measure, seconds in ((False, rank_s), (True, exhaustive_s)):
            start = time.process_time()
            ranking = Ranking(planner.going_round.candidates, samples, pose, caster, search)
            if measure:
                ranking.measure_all()
            next(iter(ranking))
            seconds.append(time.process_time() - start)
    placed = body_track(world.people)
    checks = check_knots(
        view.knots, placed, steady_path(placed.path), camera=camera, caster=caster, search=search
    )
    return {
        "prepare_ms": 1e3 * prepare_s,
        "plan_ms": 1e3 * min(plan_s),
        "rank_ms": 1e3 * min(rank_s),
        "exhaustive_ms": 1e3 * min(exhaustive_s),
        "visible": share,
        "framed": checks.framed,
        "speed_m_s": checks.speed_m_s,
    }


def _at_home(world: World) -> BodyTrack:
    """The track of a world's people in the target's performance frame."""
    from affectsim_data.observations import body_track

    back = np.linalg.inv(world.target.T_world_performance)
    return body_track(
        [
            dataclasses.replace(one, T_world_performance=back @ one.T_world_performance)
            for one in world.people
        ]
    )


PARTS = {"reference": reference}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.reference", "reference", cores=1), indent=2))
