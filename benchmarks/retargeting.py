"""What it costs to take a clip over: retargeting, planted feet, 30 fps, a closed cycle; no parsing.

On one core, rates in seconds of motion per second of that core's time. The peer is the usual
script: a loop over frames with SciPy's `Rotation` for joints and positions, `Slerp` for the rate.
It plants no feet and closes no loop.

python -m benchmarks.retargeting
"""

from __future__ import annotations

import functools
import json
import sys
import time
from collections.abc import Callable

import numpy as np

from affectsim_data.motions.motion import Motion
from affectsim_data.motions.retargeting import SourcePose
from benchmarks.parts import Rows, run_part, serve_part

_SECONDS, _SIZE = 10.0, 1.08
_RATES = (30.0, 120.0)
_ROUNDS = 5


def retargeting() -> Rows:
    """Real-time factor of a 22-joint clip that goes and comes back, beside the peer's."""
    rows = []
    for fps in _RATES:
        source = _source(fps)
        ours = _best(functools.partial(_take_over, source))
        peer = _best(functools.partial(_peer, source), rounds=1)
        rows.append(
            {
                "source_fps": int(fps),
                "real_time_factor": _SECONDS / ours,
                "clip_ms": 1e3 * ours,
                "scipy_loop_factor": _SECONDS / peer,
                "ratio": peer / ours,
            }
        )
    return rows


def _source(fps: float) -> SourcePose:
    """A walk on a taller body, every joint frame turned away from the canonical one."""
    from affectsim_data.builders.performances import perform
    from affectsim_data.poses import quaternion_multiply, yaw_quaternion
    from affectsim_data.skeletons import BODY, JOINT_NAMES, JOINT_PARENTS, Skeleton

    walk = perform("simple_walk", "neutral", "p1", rng=np.random.default_rng(0))
    root, local = walk.sample(np.arange(round(_SECONDS * fps)) / fps)
    taller = Skeleton(JOINT_NAMES, JOINT_PARENTS, _SIZE * BODY.joint_offsets)
    positions, world = taller.forward_kinematics(_SIZE * root, local)
    up = np.array([0.0, 1.0, 0.0])
    frames = quaternion_multiply(world, yaw_quaternion(0.7))
    return SourcePose(JOINT_NAMES, positions, frames, taller.rest_positions, up, fps)


def _take_over(source: SourcePose) -> Motion:
    from affectsim_data.motions.looping import make_cyclic
    from affectsim_data.motions.retargeting import resample, retarget

    names = {name: name for name in source.joint_names}
    root, rotations = retarget(source, names)
    root, rotations = resample(root, rotations, fps=source.fps, target_fps=30.0)
    motion = Motion("bench", "p1", "bench", "neutral", "walk", 30.0, root, rotations)
    return make_cyclic(motion, max_travel_m=3.0)


def _peer(source: SourcePose) -> None:
    """Local rotations and positions frame by frame, then 30 fps joint by joint."""
    from scipy.spatial.transform import Rotation, Slerp

    from affectsim_data.skeletons import BODY, JOINT_PARENTS

    parents = list(JOINT_PARENTS[1:])
    offset = Rotation.from_euler("y", -0.7)
    local = np.empty_like(source.rotations)
    for frame, rotations in enumerate(source.rotations):
        world = Rotation.from_quat(rotations[:, [1, 2, 3, 0]]) * offset
        local[frame] = Rotation.concatenate([world[0], world[parents].inv() * world[1:]]).as_quat()
        positions = np.empty((len(local[frame]), 3))
        positions[0] = source.positions[frame, 0] / _SIZE
        for joint, parent in enumerate(JOINT_PARENTS[1:], start=1):
            positions[joint] = positions[parent] + world[parent].apply(BODY.joint_offsets[joint])
    time_s = np.arange(source.num_frames) / source.fps
    instants = np.arange(0.0, time_s[-1], 1.0 / 30.0)
    for joint in range(local.shape[1]):
        Slerp(time_s, Rotation.from_quat(local[:, joint]))(instants)


def _best(work: Callable[[], object], *, rounds: int = _ROUNDS) -> float:
    """Least seconds of this process's time on the core."""
    seconds = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        seconds.append(time.process_time() - start)
    return min(seconds)


PARTS = {"retargeting": retargeting}

if __name__ == "__main__":
    if len(sys.argv) > 1:
        serve_part(PARTS)
    else:
        print(json.dumps(run_part("benchmarks.retargeting", "retargeting", cores=1), indent=2))
