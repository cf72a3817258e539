"""What a robot saw in the states of a recorded run, drawn again."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera, CameraTrajectory
from affectsim_data.episodes import World
from affectsim_data.inspection.trajectory_runs import RecordedRun
from affectsim_data.loaders import resolve_condition
from affectsim_data.poses import FloatArray
from affectsim_data.render import ClipSpec, PosedAvatar, RenderedClip, Renderer

__all__ = ["condition_frame", "frames_at", "looks_at"]


def looks_at(
    run: RecordedRun, world: World, renderer: Renderer, states: Sequence[int], *, camera: Camera
) -> RenderedClip:
    """RGB and depth of some states, the very images the policy had if the camera is the same."""
    chosen = list(states)
    instants = run.episode.phase_s + run.times_s[chosen]
    return _drawn(world, renderer, instants, run.T_world_camera(world.robot)[chosen], camera)


def frames_at(
    run: RecordedRun, world: World, renderer: Renderer, states: Sequence[int], *, size: int
) -> NDArray[np.uint8]:
    """What the robot saw in some states, `(num_states, size, size, 3)`."""
    camera = world.camera.resized(width=size, height=size)
    return looks_at(run, world, renderer, states, camera=camera).rgb


def condition_frame(
    run: RecordedRun, world: World, renderer: Renderer, condition: str, state: int, *, size: int
) -> NDArray[np.uint8]:
    """What another condition shows at the instant of a state, `(size, size, 3)`.

    Args:
        run: Which episode.
        world: What its identifiers stand for.
        renderer: Draws it.
        condition: Its name: `p_init`, `p_ref`.
        state: Of the run.
        size: Pixels.
    """
    instants = np.array([run.episode.phase_s + run.times_s[state]])
    poses = resolve_condition(condition).trajectory(run.episode, world, instants).T_world_camera
    camera = world.camera.resized(width=size, height=size)
    frame: NDArray[np.uint8] = _drawn(world, renderer, instants, poses, camera).rgb[0]
    return frame


def _drawn(
    world: World, renderer: Renderer, instants: FloatArray, poses: FloatArray, camera: Camera
) -> RenderedClip:
    people = tuple(
        PosedAvatar(person.avatar, person.joint_matrices(instants)) for person in world.people
    )
    return renderer.render(ClipSpec(world.scene, people, camera, CameraTrajectory(poses)))
