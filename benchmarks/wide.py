"""A release as wide as the paper's, to measure loading on: 57 homes and 27,647 episodes.

Homes, bodies and performances are those the builders make, and every episode can be drawn; people
and robots stand anywhere on the floor, and what only a composed release knows (distances along the
navmesh, visible shares, a planned reference view) is filled in. Built once, in about a minute.

python -m benchmarks.wide wide
"""

from __future__ import annotations

import hashlib
import itertools
import json
import math
import multiprocessing
import sys
import time
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import affectsim_data
from affectsim_data.builders.assets import load_avatars
from affectsim_data.builders.performances import PerformanceAction, perform, perform_dyad
from affectsim_data.builders.recipes import read_recipe
from affectsim_data.builders.scene_sources import (
    FailedScene,
    SceneSource,
    build_scene,
    scene_sources,
)
from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.poses import FloatArray
from affectsim_data.releases import MANIFEST_NAME, ReleaseWriter
from affectsim_data.releases.builtin import cache_folder
from affectsim_data.releases.rows import avatar_row, motion_row, scene_row
from affectsim_data.schemas import CHALLENGES, FAMILIES, SPLITS, Family, Split
from benchmarks.parts import Rows, serve_part

_ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(_ROOT / "tests"))

from small_release import make_episode  # noqa: E402 - found by the line above

__all__ = ["NUM_SCENES", "PAPER_COUNTS", "PARTS", "wide_release_path"]

NUM_SCENES = 57
PAPER_COUNTS: dict[Split, dict[Family, int]] = {
    "train": {"action_grounded": 11_999, "observation_controlled": 6_643, "dyadic": 1_020},
    "validation": {"action_grounded": 3_003, "observation_controlled": 831, "dyadic": 210},
    "test": {"action_grounded": 2_899, "observation_controlled": 832, "dyadic": 210},
}
"""Episodes of the full release."""
_PERFORMERS: dict[Split, tuple[str, ...]] = {
    "train": tuple(f"w{number}" for number in range(1, 9)),
    "validation": ("w9", "w10"),
    "test": ("w11", "w12"),
}
_MOTIONS: dict[Split, dict[Family, int]] = {
    "train": {"action_grounded": 282, "observation_controlled": 669, "dyadic": 34},
    "validation": {"action_grounded": 70, "observation_controlled": 84, "dyadic": 7},
    "test": {"action_grounded": 70, "observation_controlled": 84, "dyadic": 7},
}
"""Motions of the full release; of the action-grounded ones only the sum is known, 422."""
_ACTIONS: tuple[PerformanceAction, ...] = ("simple_walk", "sit_down", "being_seated", "knock_door")
_STARTS_PER_SCENE = 1024
_DISTANCES_M = (2.0, 5.0)
_PARTNER_M = 1.2
_SEED = 57
_JOBS = 2

_In = TypeVar("_In")
_Out = TypeVar("_Out")
Take = tuple[Motion, Motion | None]
"""What the target of an episode performs, and its partner if it has one."""
_Job = tuple[str, Any, PerformanceAction, int, str]
"""Performer, emotion, action, take and collection of a performance to be made."""


def wide_release_path() -> Path:
    """Folder of the release, in the user's cache; built now unless this very code built it."""
    folder = cache_folder() / "benchmarks" / f"wide-{_fingerprint()}"
    if not (folder / MANIFEST_NAME).is_file():
        folder.parent.mkdir(parents=True, exist_ok=True)
        start = time.perf_counter()
        _build(folder)
        facts = {"build_s": time.perf_counter() - start}
        folder.with_suffix(".json").write_text(json.dumps(facts))
    return folder


def _fingerprint() -> str:
    """Of the code the release is made by."""
    package = Path(affectsim_data.__file__).parent
    digest = hashlib.sha256(Path(__file__).read_bytes())
    for pattern in ("schemas.py", "releases/writing.py", "builders/homes/*", "builders/perf*/*"):
        for path in sorted(package.glob(pattern)):
            digest.update(path.read_bytes() if path.is_file() else b"")
    return digest.hexdigest()[:12]


def _build(out: Path) -> None:
    recipe = read_recipe("mini")
    avatars = load_avatars(recipe)
    with ReleaseWriter(out, overwrite=True) as writer:
        scenes = _parallel(_scene, scene_sources(read_recipe("homes"), None))
        takes = {split: _takes(split) for split in SPLITS}
        bodies = [avatar.avatar_id for avatar in avatars]
        for split in SPLITS:
            writer.add_table("episodes", _episodes(split, takes[split], scenes, bodies), stem=split)
        everyone = itertools.chain.from_iterable(
            take for split in SPLITS for family in FAMILIES for take in takes[split][family]
        )
        writer.add_table("motions", [motion_row(motion) for motion in everyone if motion])
        writer.add_table("scenes", [row for row, _ in scenes])
        writer.add_table("avatars", [avatar_row(avatar) for avatar in avatars])
        writer.finish(
            name="wide",
            recipe="benchmarks.wide",
            seed=_SEED,
            code_version=affectsim_data.__version__,
            camera=recipe.camera,
            robot=recipe.robot,
            licences=["CC0-1.0"],
        )


def _parallel(task: Callable[[_In], _Out], items: Sequence[_In]) -> list[_Out]:
    context = multiprocessing.get_context("forkserver")
    with ProcessPoolExecutor(_JOBS, context) as pool:
        return list(pool.map(task, items))


def _scene(source: SceneSource) -> tuple[dict[str, Any], FloatArray]:
    """The row of a home, and places in it: x, y, z of a person and x, y, z of a robot, `(n, 6)`."""
    built = build_scene(source, read_recipe("homes"), None)
    if isinstance(built, FailedScene):
        raise ValueError(f"{built.scene_id}: {built.reason}")
    scene, navmesh = built.scene, built.navmesh
    rng = np.random.default_rng([_SEED, 2, *scene.scene_id.encode()])
    people, robots = (navmesh.random_points(16 * _STARTS_PER_SCENE, rng) for _ in range(2))
    distance = np.linalg.norm(people - robots, axis=1)
    good = np.flatnonzero((distance >= _DISTANCES_M[0]) & (distance <= _DISTANCES_M[1]))
    places = np.concatenate([people, robots], axis=1)[good[:_STARTS_PER_SCENE]]
    return scene_row(scene, navmesh), places


def _takes(split: Split) -> dict[Family, list[Take]]:
    """Performances of a split: all performers, actions and emotions in turn."""
    names, counts = _PERFORMERS[split], _MOTIONS[split]
    cycle = itertools.cycle(itertools.product(_ACTIONS, EMOTIONS, names))
    grounded: list[_Job] = [
        (name, emotion, action, 0, f"wide/{split}_take{number}")
        for number, (action, emotion, name) in enumerate(
            itertools.islice(cycle, counts["action_grounded"])
        )
    ]
    gestures: list[_Job] = [
        (names[n % len(names)], EMOTIONS[n % 5], "scenario", n // 5 % 5, f"wide/{split}_take{n}")
        for n in range(counts["observation_controlled"])
    ]
    pairs = [
        ((names[n % len(names)], names[(n + 1) % len(names)]), EMOTIONS[n % 5], f"wide/{split}_{n}")
        for n in range(counts["dyadic"])
    ]
    return {
        "action_grounded": [(motion, None) for motion in _parallel(_perform, grounded)],
        "observation_controlled": [(motion, None) for motion in _parallel(_perform, gestures)],
        "dyadic": list(_parallel(_perform_pair, pairs)),
    }


def _perform(job: _Job) -> Motion:
    performer_id, emotion, action, take, collection = job
    rng = np.random.default_rng([_SEED, 3, *collection.encode(), *performer_id.encode()])
    motion = perform(action, emotion, performer_id, take=take, rng=rng, collection=collection)
    return motion.rounded()


def _perform_pair(job: tuple[tuple[str, str], Any, str]) -> tuple[Motion, Motion]:
    performer_ids, emotion, collection = job
    rng = np.random.default_rng([_SEED, 4, *collection.encode()])
    dyad = perform_dyad(emotion, performer_ids, rng=rng, collection=collection)
    return dyad.target.rounded(), dyad.partner.rounded()


def _episodes(
    split: Split,
    takes: dict[Family, list[Take]],
    scenes: Sequence[tuple[dict[str, Any], FloatArray]],
    bodies: Sequence[str],
) -> list[dict[str, Any]]:
    """The rows of a split, scene by scene and shuffled within a scene, as builders number them."""
    rng = np.random.default_rng([_SEED, 5, SPLITS.index(split)])
    counts = PAPER_COUNTS[split]
    families = rng.permutation(np.repeat(np.arange(len(counts)), list(counts.values())))
    homes = np.sort(rng.integers(len(scenes), size=len(families)))
    template = make_episode(recipe="benchmarks.wide", seed=_SEED).to_row()
    rows = []
    for number, (home, which) in enumerate(zip(homes, families, strict=True)):
        family = list(counts)[which]
        take = takes[family][int(rng.integers(len(takes[family])))]
        scene, places = scenes[home]
        row = {
            **template,
            "episode_id": f"wide/{split}-{number:05d}",
            "split": split,
            "family": family,
            "scene_id": scene["scene_id"],
            "navmesh_sha256": scene["navmesh_sha256"],
            "challenge": None,
        }
        if family == "observation_controlled":
            row["challenge"] = CHALLENGES[int(rng.integers(len(CHALLENGES)))]
        row |= _place_columns(places[int(rng.integers(len(places)))], float(rng.uniform(-180, 180)))
        rows.append(row | _take_columns(row, take, bodies, float(rng.random())))
    return rows


def _place_columns(place: FloatArray, facing_deg: float) -> dict[str, Any]:
    """Where a person and a robot stand; the robot looks at the person."""
    person, robot = place[:3].tolist(), place[3:].tolist()
    x, z = robot[0] - person[0], robot[2] - person[2]
    bearing = math.remainder(math.degrees(math.atan2(x, z)) - facing_deg, 360.0)
    return {
        **_point("anchor", person),
        **_point("start", robot),
        "facing_deg": facing_deg,
        "start_yaw_deg": math.degrees(math.atan2(x, z)),
        "initial_distance_m": math.dist(person, robot),
        "initial_bearing_deg": bearing,
    }


def _take_columns(
    row: dict[str, Any], take: Take, bodies: Sequence[str], phase: float
) -> dict[str, Any]:
    """Who performs what in an episode; a partner faces the target."""
    target, partner = take
    columns = {
        "motion_id": target.motion_id,
        "performer_id": target.performer_id,
        "avatar_id": _body(target, bodies),
        "group_id": target.group_id if row["family"] != "action_grounded" else target.performer_id,
        "action": target.action,
        "emotion": target.emotion,
        "duration_s": target.duration_s,
        "phase_s": phase * target.duration_s,
        "source": target.source,
    }
    if partner is None:
        return columns
    facing = math.radians(row["facing_deg"])
    beside = (_PARTNER_M * math.sin(facing), 0.0, _PARTNER_M * math.cos(facing))
    anchor = [row[f"anchor_{axis}_m"] + step for axis, step in zip("xyz", beside, strict=True)]
    return {
        **columns,
        "partner_motion_id": partner.motion_id,
        "partner_performer_id": partner.performer_id,
        "partner_avatar_id": _body(partner, bodies),
        **_point("partner_anchor", anchor),
        "partner_facing_deg": math.remainder(row["facing_deg"] + 180.0, 360.0),
    }


def _body(motion: Motion, bodies: Sequence[str]) -> str:
    """The body of a performer, whatever it performs."""
    return bodies[int(motion.performer_id[1:]) % len(bodies)]


def _point(name: str, place: Iterable[float]) -> dict[str, Any]:
    return {f"{name}_{axis}_m": value for axis, value in zip("xyz", place, strict=True)}


def wide() -> Rows:
    """Size of the release, and how long its build took."""
    from affectsim_data.releases import open_release

    folder = wide_release_path()
    release = open_release(folder)
    files = release.manifest.files
    triangles = [len(release.scene(key).mesh()[1]) for key in release.asset_ids("scenes")]
    sizes = {
        table: sum(files[name].bytes for name in release.manifest.table_files(table)) / 1e6
        for table in ("scenes", "motions", "avatars", "episodes", "index")
    }
    return [
        {
            "scenes": len(triangles),
            "triangles_per_scene": round(sum(triangles) / len(triangles)),
            "motions": release.manifest.num_rows("motions"),
            "avatars": release.manifest.num_rows("avatars"),
            "episodes": release.manifest.num_rows("episodes"),
            "files": len(files) + 1,
            "mb": sum(sizes.values()) + (folder / MANIFEST_NAME).stat().st_size / 1e6,
            **{f"{table}_mb": size for table, size in sizes.items()},
            "manifest_mb": (folder / MANIFEST_NAME).stat().st_size / 1e6,
            "build_s": json.loads(folder.with_suffix(".json").read_text())["build_s"],
        }
    ]


PARTS = {"wide": wide}

if __name__ == "__main__":
    serve_part(PARTS)
