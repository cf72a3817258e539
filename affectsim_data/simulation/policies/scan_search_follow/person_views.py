"""Views from random robot poses with what is true of them: what the person network learns from."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations.still import head_camera_pose
from affectsim_data.poses import FloatArray
from affectsim_data.releases import Release
from affectsim_data.render import ClipSpec, PosedAvatar, process_renderer
from affectsim_data.schemas import Split
from affectsim_data.simulation.policies.scan_search_follow.person_network import CELLS, INPUT_SIZE
from affectsim_data.skeletons import JOINT_NAMES
from affectsim_data.visibility import scene_caster

__all__ = ["PersonViews", "body_facing", "draw_views"]

_NEAR_M, _FAR_M = 1.0, 8.0
"""Distances from a person at which views are drawn, as far as the home goes."""
_AIMED = 0.75
"""Share of the views turned towards a person; the others look anywhere."""


@dataclasses.dataclass(frozen=True)
class PersonViews:
    """Views and their truth, all of one camera at one height."""

    rgb: NDArray[np.uint8]
    """`(n, 112, 112, 3)`."""
    depth: NDArray[np.float16]
    """Metres, `inf` where nothing was hit, `(n, 112, 112)`."""
    share: NDArray[np.float16]
    """Part of each cell that is a person, `(n, 28, 28)`."""
    facing: NDArray[np.float16]
    """Angle of `PersonHeat.facing` of the person in the cell, `nan` where there is none,
    `(n, 28, 28)`."""
    camera: Camera
    camera_height_m: float

    def __len__(self) -> int:
        return len(self.rgb)


def draw_views(
    release: Release,
    split: Split,
    *,
    num_views: int,
    views_per_episode: int,
    rng: np.random.Generator,
    progress: bool = False,
) -> PersonViews:
    """Draws views of random episodes of a split, in homes that the split by scene gives to it too.

    Args:
        release: Of which.
        split: Of performers and of homes; those of the other splits are not touched.
        num_views: How many, at least; whole episodes are drawn.
        views_per_episode: Of each episode, at different instants of the motion.
        rng: Draws episodes, poses and instants.
        progress: Show a bar.
    """
    table = release.episode_table(split, ["scene_id", "scene_split"]).to_pydict()
    there = np.flatnonzero(np.array(table["scene_split"]) == split)
    if not len(there):
        raise ValueError(f"{release.uri}: no episode of split {split!r} is in a home of that split")
    wanted = math.ceil(num_views / views_per_episode)
    drawn = rng.choice(there, min(wanted, len(there)), replace=False).tolist()
    # By scene, so that each is loaded once.
    chosen = sorted(drawn, key=lambda index: (table["scene_id"][index], index))
    parts = []
    bar = tqdm(chosen, desc="views", unit="episode", disable=not progress)
    for index in bar:
        episode = release.episode(split, index)
        world, navmesh = release.world(episode), release.navmesh(episode.scene_id)
        parts.append(_views_of(episode, world, navmesh, views_per_episode, rng))
    camera, height = world.camera, world.robot.camera_height_m
    rgb, depth, share, facing = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
    return PersonViews(rgb, depth, share, facing, camera, height)


def body_facing(joints: FloatArray) -> FloatArray:
    """Yaw of bodies from their joints `(..., 22, 3)`: 0 looks along -Z, counter-clockwise, `(...)`.

    The mean direction across hips and shoulders, turned by a quarter.
    """
    column = JOINT_NAMES.index
    left, right = (
        [column(f"{side}_{part}") for part in ("hip", "shoulder")] for side in ("left", "right")
    )
    across = (joints[..., left, :] - joints[..., right, :]).mean(axis=-2)
    # Who looks along -Z has the left side at -X.
    return np.asarray(np.arctan2(across[..., 2], -across[..., 0]))


def _views_of(
    episode: Episode, world: World, navmesh: NavMesh, count: int, rng: np.random.Generator
) -> tuple[NDArray[np.generic], ...]:
    """Colour, depth, share and facing of views of one episode, as in `PersonViews`."""
    instants = rng.uniform(0.0, episode.duration_s, count)
    joints = np.stack([one.joint_frames(instants)[..., :3, 3] for one in world.people])
    positions, yaws = _robot_poses(joints, world, navmesh, rng)
    spec = ClipSpec(
        world.scene,
        tuple(PosedAvatar(one.avatar, one.joint_matrices(instants)) for one in world.people),
        world.camera,
        CameraTrajectory(head_camera_pose(positions, yaws, world.robot)),
    )
    images = process_renderer().render(spec, instances=True)
    assert images.instances is not None
    to_camera = np.arctan2(
        joints[:, :, 0, 0] - positions[None, :, 0], joints[:, :, 0, 2] - positions[None, :, 2]
    )
    turned = body_facing(joints) - to_camera  # (people, count)
    parts = [
        _truth(images.instances[view], np.remainder(turned[:, view] + math.pi, 2 * math.pi))
        for view in range(count)
    ]
    size = (INPUT_SIZE, INPUT_SIZE)
    return (
        np.stack([cv2.resize(one, size, interpolation=cv2.INTER_AREA) for one in images.rgb]),
        np.stack(
            [cv2.resize(one, size, interpolation=cv2.INTER_NEAREST) for one in images.depth]
        ).astype(np.float16),
        np.stack([share for share, _ in parts]),
        np.stack([facing for _, facing in parts]),
    )


def _truth(
    instances: NDArray[np.uint8], turned: FloatArray
) -> tuple[NDArray[np.float16], NDArray[np.float16]]:
    """Person share and facing of cells, from ids `(height, width)` and angles `(num_people,)`."""
    of_each = np.stack(
        [
            cv2.resize(
                (instances == k + 1).astype(np.float32),
                (CELLS, CELLS),
                interpolation=cv2.INTER_AREA,
            )
            for k in range(len(turned))
        ]
    )
    share = of_each.sum(axis=0)
    facing = np.where(share > 0.0, turned[of_each.argmax(axis=0)] - math.pi, np.nan)
    return share.astype(np.float16), facing.astype(np.float16)


def _robot_poses(
    joints: FloatArray, world: World, navmesh: NavMesh, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray]:
    """Positions `(count, 3)` and yaws `(count,)`, most in sight of a person and turned to them."""
    caster = scene_caster(world.scene)
    half = world.camera.hfov / 2.0
    positions, yaws = [], []
    for view in range(joints.shape[1]):
        pelvis = joints[rng.integers(len(joints)), view, 0]
        for position in _candidates(pelvis, navmesh, rng):
            away = pelvis - (position + np.array([0.0, world.robot.camera_height_m, 0.0]))
            reach = float(np.linalg.norm(away))
            if caster.distance(pelvis - away, away / reach) > reach - 0.3:
                break  # nothing but the body itself is in the way
        yaw = math.atan2(-away[0], -away[2]) + rng.uniform(-0.95 * half, 0.95 * half)
        positions.append(position)
        yaws.append(yaw if rng.random() < _AIMED else rng.uniform(-math.pi, math.pi))
    return np.array(positions), np.array(yaws)


def _candidates(
    pelvis: FloatArray, navmesh: NavMesh, rng: np.random.Generator
) -> Iterator[FloatArray]:
    """Points of the floor around a person, uniform in distance rather than in area."""
    for _ in range(6):
        radius = rng.uniform(_NEAR_M, _FAR_M)
        points = navmesh.random_points(12, rng, disc=(pelvis * [1.0, 0.0, 1.0], radius))
        yield points[np.argmax(np.hypot(*(points - pelvis)[:, [0, 2]].T))]
