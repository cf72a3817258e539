"""A wide release made in code: 57 small rooms, 60 motions, two bodies, 4,000 episodes, in seconds.

Small assets, many rows: for tests of order, resuming, ranks, selection and fetching. Every episode
can be drawn. Everything here is our own and may be used freely (CC0).
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from small_release import (
    Point,
    box_room,
    circle_motion,
    limb_avatar,
    make_episode,
    sway_motion,
    write_release,
)

from affectsim_data.motions import EMOTIONS, Motion
from affectsim_data.navmesh import NavMesh
from affectsim_data.scenes import Scene
from affectsim_data.schemas import CHALLENGES, SPLITS, Split

__all__ = ["COUNTS", "NUM_SCENES", "PERFORMERS", "wide_rows", "write_wide_release"]

NUM_SCENES = 57
COUNTS: dict[Split, int] = {"train": 3000, "validation": 600, "test": 400}
"""Episodes by split."""
PERFORMERS: dict[Split, tuple[str, ...]] = {
    "train": ("a0", "a1", "a2", "a3", "a4", "a5", "a6", "a7"),
    "validation": ("b0", "b1"),
    "test": ("c0", "c1"),
}
"""Who performs, by split; no two splits share one."""
_HALF_M = 2.2
"""Half a room: the 3 m ring around its middle holds no place for the robot."""
_START_M = (1.15, 1.45)
"""Distances of starts; the floor is free that far around the middle."""
_DYADIC_SHARE = 0.1
_PARTNER_M = 0.9
"""From the target to its partner, who stands beyond it, seen from the start."""


def wide_scenes(num_scenes: int = NUM_SCENES) -> dict[str, Scene]:
    """Rooms with a crate in up to four corners, each of another height: no two are alike."""
    scenes = {}
    for number in range(num_scenes):
        height = 0.3 + 0.02 * number
        crates: list[tuple[Point, Point]] = []
        for corner in range(1 + number % 4):
            x, z = (1.0 if corner & 1 else -1.0), (1.0 if corner & 2 else -1.0)
            xs, zs = sorted((1.5 * x, 2.0 * x)), sorted((1.5 * z, 2.0 * z))
            crates.append(((xs[0], 0.0, zs[0]), (xs[1], height, zs[1])))
        scene = box_room(f"room_{number:03d}", half=_HALF_M, boxes=crates)
        scenes[scene.scene_id] = scene
    return scenes


def wide_motions() -> dict[str, Motion]:
    """A performance per performer and emotion; every other performer walks a circle."""
    motions = {}
    for names in PERFORMERS.values():
        for number, performer_id in enumerate(names):
            make = circle_motion if number % 2 else sway_motion
            for emotion in EMOTIONS:
                motion_id = f"{performer_id}_{emotion}"
                motions[motion_id] = make(motion_id, emotion, performer_id=performer_id)
    return motions


def wide_rows(
    *, num_scenes: int = NUM_SCENES, counts: Mapping[Split, int] = COUNTS, seed: int = 5
) -> dict[str, list[dict[str, Any]]]:
    """The rows of all tables, by table; the episodes of a split scene by scene, as builders do.

    Args:
        num_scenes: Rooms.
        counts: Episodes by split; a split not named has none.
        seed: Of everything random.
    """
    # Not at the top: rows need the release layer, rooms do not.
    from affectsim_data.releases.rows import avatar_row, motion_row, scene_row

    scenes, motions = wide_scenes(num_scenes), wide_motions()
    navmeshes = {
        name: NavMesh.from_mesh(*scene.mesh(), cell_size=0.1, mesh_sha256=scene.mesh_sha256())
        for name, scene in scenes.items()
    }
    hashes = [hashlib.sha256(mesh.to_bytes()).hexdigest() for mesh in navmeshes.values()]
    episodes: list[dict[str, Any]] = []
    for number, split in enumerate(SPLITS):
        rng = np.random.default_rng([seed, number])
        own = [m for m in motions.values() if m.performer_id in PERFORMERS[split]]
        episodes += _episode_rows(split, counts.get(split, 0), own, list(scenes), hashes, rng)
    return {
        "episodes": episodes,
        "motions": [motion_row(motion) for motion in motions.values()],
        "scenes": [scene_row(scene, navmeshes[name]) for name, scene in scenes.items()],
        "avatars": [
            avatar_row(avatar) for avatar in (limb_avatar("plain"), limb_avatar("tall", scale=1.1))
        ],
    }


def _episode_rows(
    split: Split,
    count: int,
    motions: list[Motion],
    scene_ids: list[str],
    navmesh_hashes: list[str],
    rng: np.random.Generator,
) -> list[dict[str, Any]]:
    template = make_episode().to_row()
    scenes = np.sort(rng.integers(len(scene_ids), size=count))
    facings, bearings = rng.uniform(-math.pi, math.pi, (2, count))
    distances = rng.uniform(*_START_M, count)
    starts = _starts(facings + bearings, distances)
    takes, partners = rng.integers(len(motions), size=(2, count))
    phases, tall, dyadic = rng.random(count), rng.random(count) < 0.5, rng.random(count)
    challenges = rng.integers(len(CHALLENGES), size=count)
    rows = []
    for i in range(count):
        motion = motions[takes[i]]
        row = {
            **template,
            **{name: getattr(motion, name) for name in ("group_id", "action", "emotion")},
            **{name: getattr(motion, name) for name in ("motion_id", "performer_id", "duration_s")},
            "episode_id": f"wide/{split}-{i:05d}",
            "split": split,
            "scene_split": {7: "validation", 3: "test"}.get(scenes[i] % 10, "train"),
            "challenge": CHALLENGES[challenges[i]],
            "scene_id": scene_ids[scenes[i]],
            "navmesh_sha256": navmesh_hashes[scenes[i]],
            "avatar_id": "tall" if tall[i] else "plain",
            "facing_deg": math.degrees(facings[i]),
            "phase_s": phases[i] * motion.duration_s,
            **starts[i],
            "initial_distance_m": distances[i],
            "initial_bearing_deg": math.degrees(bearings[i]),
            # Nothing stands in the straight way to the ring, which is 0.2 m wide.
            "d_star_1m": distances[i] - 1.1,
            **dict.fromkeys(("d_star_3m", "d_star_5m", "d_star_1m_null")),
            **{f"d_star_{r}m_null": "empty" for r in (3, 5)},
        }
        if dyadic[i] < _DYADIC_SHARE:
            row |= _partner_columns(motions[partners[i]], row)
        rows.append(row)
    return rows


def _starts(azimuths: NDArray[np.float64], distances: NDArray[np.float64]) -> list[dict[str, Any]]:
    """Columns of starts around the middle of a room, looking at it."""
    x, z = distances * np.sin(azimuths), distances * np.cos(azimuths)
    yaws = np.degrees(np.arctan2(x, z))
    return [
        {"start_x_m": one[0], "start_y_m": 0.0, "start_z_m": one[1], "start_yaw_deg": one[2]}
        for one in np.stack([x, z, yaws], axis=1).tolist()
    ]


def _partner_columns(motion: Motion, row: Mapping[str, Any]) -> dict[str, Any]:
    """What makes an episode a dyad: a second person who faces the first."""
    share = -_PARTNER_M / row["initial_distance_m"]
    return {
        "family": "dyadic",
        "challenge": None,
        "partner_motion_id": motion.motion_id,
        "partner_performer_id": motion.performer_id,
        "partner_avatar_id": "plain",
        **{f"partner_anchor_{axis}_m": share * row[f"start_{axis}_m"] for axis in "xyz"},
        "partner_facing_deg": row["start_yaw_deg"],
    }


def write_wide_release(
    out: Path, *, num_scenes: int = NUM_SCENES, counts: Mapping[Split, int] = COUNTS
) -> None:
    """Writes the wide release, or a narrower one, into a folder."""
    splits = [split for split in SPLITS if counts.get(split)]
    write_release(out, rows=wide_rows(num_scenes=num_scenes, counts=counts), splits=splits)


if __name__ == "__main__":
    import sys

    write_wide_release(Path(sys.argv[1]))
