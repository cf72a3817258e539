"""Steps per second of an episode being acted in, and memory over many episodes; one core.

A step is an action and the observation after it, RGB and depth at 224 x 224, in a furnished home
with one body. The peer draws the very same views as one clip: what a step costs more is the price
of having to wait for every action. Both are the least time of this process over some rounds, with
nothing kept from the round before.

python -m benchmarks.environment [environment | environment_memory]
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.cameras import CameraTrajectory
from affectsim_data.content import content_path
from affectsim_data.episodes import Episode, World
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations.still import head_camera_pose
from affectsim_data.render import ClipSpec, PosedAvatar
from affectsim_data.render.rasterizer import EglRenderer
from affectsim_data.simulation import Action, EpisodeRun
from benchmarks.parts import Rows, resident_mb, run_part, serve_part
from benchmarks.render import HOME
from benchmarks.render_home import beside, furnished_home, home_walk

# The motion and the episode made of code are those of the tests.
sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests"))

from small_release import circle_motion, make_episode, world_of

STEPS, ROUNDS = 120, 3
MEMORY_EPISODES, MEMORY_STEPS, MEMORY_ROWS = 100, 12, 5
_CACHE_BYTES = 2**29
_RELEASE = "AFFECTSIM_BENCHMARK_RELEASE"
"""Environment variable: the release of the memory part, `mini` if not set."""


def environment() -> Rows:
    """A robot that wanders about, one that looks at a person while turning, one that waits."""
    scene = furnished_home(HOME)
    navmesh = NavMesh.from_mesh(*scene.mesh())
    x, z = beside(scene, home_walk(scene, num_frames=64).T_world_camera[:, :3, 3])
    place = tuple(navmesh.snap([x, 0.0, z], max_offset=1.0).tolist())
    avatar_path = min(content_path("builders", "avatars").glob("*.glb"))
    avatar = Avatar.from_glb(avatar_path.read_bytes(), name=avatar_path.name)
    world = world_of(scene, [(circle_motion("circle_sad", "sad"), avatar, place, 0.0)])
    near = _near(navmesh, np.array(place))
    wandering = [_compared("wanders", world, navmesh, near)]
    return wandering + [_compared(robot, world, navmesh, near) for robot in ("turns", "waits")]


def _near(navmesh: NavMesh, place: Any) -> Episode:
    """An episode that starts two metres from the person or so, and looks at them."""
    around = navmesh.random_points(256, np.random.default_rng(0), island=0, disc=(place, 3.0))
    around = around[navmesh.has_straight_way(place, around)]
    start = around[np.argmin(np.abs(np.linalg.norm(around - place, axis=1) - 2.0))]
    yaw = math.atan2(*(start - place)[[0, 2]])
    return make_episode(start_position=tuple(start.tolist()), start_yaw=yaw, duration_s=60.0)


def _compared(robot: str, world: World, navmesh: NavMesh, episode: Episode) -> dict[str, Any]:
    steps_s, clip_s, act_s = math.inf, math.inf, math.inf
    in_view = 0.0
    for _ in range(ROUNDS):
        renderer = EglRenderer(cache_bytes=_CACHE_BYTES)
        run = EpisodeRun(episode, world, navmesh, renderer, policy="benchmark")
        run.observe()  # uploads the scene
        started, acting = time.process_time(), 0.0
        for number in range(STEPS):
            began = time.process_time()
            run.act(_action(robot, run, number))
            acting += time.process_time() - began
            run.observe()
        steps_s, act_s = min(steps_s, time.process_time() - started), min(act_s, acting)
        spec = _same_views(run)
        started = time.process_time()
        renderer.render(spec)
        clip_s = min(clip_s, time.process_time() - started)
        ids = renderer.render(spec, instances=True).instances
        assert ids is not None
        in_view = float((ids > 0).any(axis=(1, 2)).mean())
        renderer.close()
    return {
        "robot": robot,
        "triangles": world.scene.num_triangles,
        "person_in_view": in_view,
        "steps_per_s": STEPS / steps_s,
        "act_ms": 1e3 * act_s / STEPS,
        "clip_frames_per_s": STEPS / clip_s,
        "ratio": clip_s / steps_s,
    }


def _action(robot: str, run: EpisodeRun, number: int) -> Action:
    if robot == "turns":
        return "turn_left" if number // 2 % 2 else "turn_right"
    if robot == "waits":
        return "hand_off"
    return "turn_left" if run.rows and (run.state.clipped or number % 7 == 6) else "move_forward"


def _same_views(run: EpisodeRun) -> ClipSpec:
    """The views after every step as one clip."""
    rows, world = run.rows, run.world
    positions = np.array([[row[f"position_{axis}_m"] for axis in "xyz"] for row in rows])
    yaws = np.radians([row["yaw_deg"] for row in rows])
    instants = run.episode.phase_s + np.array([row["time_s"] for row in rows])
    people = tuple(PosedAvatar(p.avatar, p.joint_matrices(instants)) for p in world.people)
    trajectory = CameraTrajectory(head_camera_pose(positions, yaws, world.robot))
    return ClipSpec(world.scene, people, run.camera, trajectory)


def environment_memory() -> Rows:
    """Resident memory while many short episodes follow each other in one environment."""
    from affectsim_data.simulation import AffectSimEnv

    env, rows = AffectSimEnv(os.environ.get(_RELEASE, "mini")), []
    rng, started = np.random.default_rng(0), time.process_time()
    for number in range(1, MEMORY_EPISODES + 1):
        env.reset(seed=0 if number == 1 else None)
        for action in rng.integers(0, 3, MEMORY_STEPS).tolist():
            env.step(action)
        if number % (MEMORY_EPISODES // MEMORY_ROWS) == 0:
            seconds = time.process_time() - started
            rows.append({"episodes": number, "resident_mb": resident_mb(), "seconds": seconds})
    env.close()
    return rows


PARTS = {"environment": environment, "environment_memory": environment_memory}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        for part in PARTS:
            print(json.dumps(run_part("benchmarks.environment", part, cores=1), indent=2))
