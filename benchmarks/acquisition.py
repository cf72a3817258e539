"""How well a policy acquires views: the paper's diagnostics, and how much better the views are.

Every row is a family or a challenge. *Handoff* is the share of episodes with a stable handoff;
*shows* the share whose clip then truly shows the target: more than 0.3 of its surface, by ray
casting; *false* the share with a handoff whose clip does not. Ways are means in metres. The last
columns are the share of the gap from P-Init to P-Ref that A-Obs recovers in the visible share of
the body, in the cosine between where the target faces and where the camera is, and in the height of
the target in the image: means over instants of the clip, then over episodes, with the P-Init clip
where nothing was handed off, as DESIGN section 4 has it.

python -m benchmarks.acquisition RELEASE [--policy scan_search_follow] [--episodes 60]
python -m benchmarks.acquisition RELEASE --trajectories runs.parquet

As a part of `python -m benchmarks` it compares policies in a few episodes of `mini`.
"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.parts import Rows, serve_part

if TYPE_CHECKING:
    import pyarrow as pa

    from affectsim_data.episodes import Episode, World
    from affectsim_data.observations import Condition
    from affectsim_data.poses import FloatArray
    from affectsim_data.releases import Release

_INSTANTS = 24
"""Of the two cycles of a clip."""
_SHOWN = 0.3
"""Mean visible share of the target from which a clip shows it."""
_MEASURES = ("visible share", "facing", "height (px)")
_CONDITIONS = ("p_init", "a_obs", "p_ref")
_RELEASE = "AFFECTSIM_BENCHMARK_RELEASE"
"""Environment variable: the release of the part, `mini` if not set."""
_EPISODES = 9
"""Of the part, a random sample."""
_POLICIES = ("random:60", "limited_search", "scan_search_follow", "privileged:reference")
"""Of the part."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("release")
    parser.add_argument("--policy", default="scan_search_follow")
    parser.add_argument("--split", default="test")
    parser.add_argument("--episodes", type=int, help="a random sample of so many; else all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--trajectories", type=Path, help="measure recorded runs, run nothing")
    options = parser.parse_args()
    from affectsim_data.releases import open_release

    release = open_release(options.release)
    if options.trajectories is None:
        chosen = _sample(release, options.split, options.episodes, options.seed)
        table, policy_ms = _run(release, options.split, chosen, options.policy)
        print(f"{policy_ms:.1f} ms a step in the policy")
    else:
        table = _read(options.trajectories, options.policy)
        chosen = _recorded(release, options.split, table)
    print_rows(measure(release, options.split, chosen, table, options.policy))


def acquisition() -> Rows:
    """What policies acquire in the same few episodes, and what they take for a step."""
    from affectsim_data.releases import open_release

    release = open_release(os.environ.get(_RELEASE, "mini"))
    chosen = _sample(release, "test", _EPISODES, 0)
    rows = []
    for name in _POLICIES:
        table, policy_ms = _run(release, "test", chosen, name)
        # By the name that the rows have: that of a policy may say less than what opens it.
        measured = measure(release, "test", chosen, table, str(table.column("policy")[0]))
        rows.append({"policy": name, **_numbers(measured), "policy_ms_per_step": policy_ms})
    return rows


def _numbers(part: list[Measured]) -> dict[str, Any]:
    """What a row of the part says of some episodes."""
    views = np.mean([one.views for one in part], axis=0)
    return {
        "episodes": len(part),
        "handoff_%": 100.0 * float(np.mean([one.handed_off for one in part])),
        "shows_%": 100.0 * float(np.mean([one.shows for one in part])),
        "way_m": float(np.mean([one.way_m for one in part])),
        **{
            f"{name.removesuffix(' (px)')}_recovered": _gap(*row).rpartition(", ")[2]
            for name, row in zip(_MEASURES, views, strict=True)
        },
    }


def _sample(release: Release, split: str, count: int | None, seed: int) -> list[int]:
    places = np.random.default_rng(seed).permutation(release.num_episodes(split))
    # In the order of the release, so that each scene is loaded once.
    return sorted(places[:count].tolist())


def _run(
    release: Release, split: str, chosen: Iterable[int], policy_name: str
) -> tuple[pa.Table, float]:
    """Rows of all trajectories, and milliseconds a step that the policy took."""
    import pyarrow as pa

    from affectsim_data.render import process_renderer
    from affectsim_data.schemas import SCHEMAS
    from affectsim_data.simulation import EpisodeRun
    from affectsim_data.simulation.episodes import run_episode
    from affectsim_data.simulation.policies.opening import open_policy

    policy, rows, seconds = open_policy(policy_name), [], 0.0
    for place in chosen:
        episode = release.episode(split, place)
        navmesh, world = release.navmesh(episode.scene_id), release.world(episode)
        run = EpisodeRun(episode, world, navmesh, process_renderer(), policy=policy.name)
        result = run_episode(run, policy, seed=0)
        seconds += result.policy_time_s
        rows += result.rows
    table = pa.Table.from_pylist(rows, schema=SCHEMAS["trajectories"])
    return table, 1e3 * seconds / max(len(rows), 1)


def _read(path: Path, policy: str) -> pa.Table:
    import pyarrow.compute as pc
    import pyarrow.parquet as pq

    table = pq.read_table(path)
    return table.filter(pc.equal(table.column("policy"), policy))


def _recorded(release: Release, split: str, table: pa.Table) -> list[int]:
    there = set(table.column("episode_id").to_pylist())
    ids = release.episode_table(split, ["episode_id"]).column("episode_id").to_pylist()
    return [place for place, episode_id in enumerate(ids) if episode_id in there]


@dataclasses.dataclass(frozen=True)
class Measured:
    """One episode."""

    kind: tuple[str, str]
    """Family, and challenge or action."""
    handed_off: bool
    way_m: float
    way_before_m: float
    exhausted: bool
    moves: int
    clipped: int
    views: FloatArray
    """`_MEASURES` under `_CONDITIONS`, `(3, 3)`."""

    @property
    def shows(self) -> bool:
        """Whether a clip was collected that shows the target."""
        return self.handed_off and bool(self.views[0, 1] > _SHOWN)


def measure(
    release: Release, split: str, chosen: Iterable[int], table: pa.Table, policy: str
) -> list[Measured]:
    """What the trajectories of episodes are worth."""
    from affectsim_data.evaluation.acquisition import acquisitions
    from affectsim_data.observations import PInit, PRef
    from affectsim_data.observations.active import AObs
    from affectsim_data.observations.recordings import RecordedRuns

    episodes = [release.episode(split, place) for place in chosen]
    ids = np.array([one.episode_id for one in episodes])
    starts = np.array([one.start_position for one in episodes])
    done = acquisitions(table, ids, starts, policy=policy)
    runs = RecordedRuns.from_table(table, file="trajectories", policy=policy)
    conditions: list[Condition] = [PInit(), AObs(runs), PRef()]
    return [
        Measured(
            kind=(episode.family, episode.challenge or episode.action),
            handed_off=bool(done.handed_off[place]),
            way_m=float(done.path_length_m[place]),
            way_before_m=float(done.path_before_handoff_m[place]),
            exhausted=bool(done.budget_exhausted[place]),
            moves=int(done.num_translations[place]),
            clipped=int(done.num_clipped[place]),
            views=np.stack(_views(episode, release.world(episode), conditions), axis=1),
        )
        for place, episode in enumerate(episodes)
    ]


def _views(episode: Episode, world: World, conditions: list[Condition]) -> list[FloatArray]:
    """`_MEASURES` of an episode under conditions, `(3,)` each."""
    from affectsim_data.observations.bodies import body_path
    from affectsim_data.poses import invert_pose, transform_points
    from affectsim_data.visibility import body_samples, scene_caster, visible_share

    time_s = episode.phase_s + np.arange(_INSTANTS) * 2.0 * episode.duration_s / _INSTANTS
    samples, caster = body_samples(world, time_s), scene_caster(world.scene)
    center, heading = body_path(world.target).at(time_s)
    found = []
    for condition in conditions:
        poses = condition.trajectory(episode, world, time_s).T_world_camera
        visible = visible_share(samples, poses[:, None], world.camera, caster).visible
        away = poses[:, :3, 3] - center
        facing = np.cos(heading - np.arctan2(away[:, 0], away[:, 2]))
        points = transform_points(invert_pose(poses), samples.points)
        pixels, depth = world.camera.project(points)
        heights = [_height_px(*pair, world) for pair in zip(pixels, depth, strict=True)]
        found.append(np.array([visible.mean(), facing.mean(), np.mean(heights)]))
    return found


def _height_px(pixels: FloatArray, depth: FloatArray, world: World) -> float:
    """Height of what is in the image of a body, hidden or not, pixels."""
    with np.errstate(invalid="ignore"):
        inside = (depth > 0.0) & (pixels[:, 0] >= 0.0) & (pixels[:, 0] < world.camera.width)
    rows = np.clip(pixels[inside, 1], 0.0, world.camera.height)
    return float(np.ptp(rows)) if len(rows) else 0.0


def print_rows(measured: list[Measured]) -> None:
    """Prints a table in Markdown: all, every family, every challenge or action."""
    kinds = sorted({one.kind for one in measured})
    families = sorted({family for family, _ in kinds})
    print(
        "| episodes | n | handoff | shows | false | way | before | exhausted | clipped | ", end=""
    )
    print(" | ".join(f"{name}: init, active, ref, recovered" for name in _MEASURES), "|")
    print("|---" * (9 + len(_MEASURES)) + "|")
    print(_row("all", measured))
    for family in families:
        print(_row(family, [one for one in measured if one.kind[0] == family]))
    for kind in kinds:
        print(_row(" / ".join(kind), [one for one in measured if one.kind == kind]))


def _row(name: str, part: list[Measured]) -> str:
    def share(values: Iterable[Any]) -> str:
        return f"{100.0 * float(np.mean(list(values))):.1f} %"

    views = np.mean([one.views for one in part], axis=0)
    moves = sum(one.moves for one in part)
    cells = [
        *(name, str(len(part)), share(one.handed_off for one in part)),
        *(share(one.shows for one in part), share(one.handed_off > one.shows for one in part)),
        f"{np.mean([one.way_m for one in part]):.1f}",
        f"{np.mean([one.way_before_m for one in part]):.1f}",
        share(one.exhausted for one in part),
        f"{100.0 * sum(one.clipped for one in part) / max(moves, 1):.1f} %",
        *(_gap(*row) for row in views),
    ]
    return f"| {' | '.join(cells)} |"


def _gap(initial: float, active: float, reference: float) -> str:
    gap = reference - initial
    recovered = f"{100.0 * (active - initial) / gap:.0f} %" if abs(gap) > 1e-3 else "-"
    return f"{initial:.2f}, {active:.2f}, {reference:.2f}, {recovered}"


PARTS = {"acquisition": acquisition}

if __name__ == "__main__":
    if sys.argv[1:2] == list(PARTS):
        serve_part(PARTS)
    else:
        main()
