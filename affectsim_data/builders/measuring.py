"""Many placements measured at once: visible shares of bodies at candidate anchors and starts."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.avatars import Avatar
from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person, Robot, World
from affectsim_data.motions import Motion
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    invert_pose,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.scenes import Scene
from affectsim_data.visibility import RayCaster, body_samples

__all__ = ["Performance", "Shares", "cycle_instants", "measure_shares", "partner_place"]

_INSTANTS = 12
PAIR_DISTANCE_M = 1.25
"""Between the anchors of two people of canonical size who interact."""


def cycle_instants(duration_s: float) -> FloatArray:
    """Instants spread over a cycle at which shares are measured, seconds, `(12,)`."""
    instants: FloatArray = np.arange(_INSTANTS) * duration_s / _INSTANTS
    return instants


def partner_place(scale: float = 1.0) -> FloatArray:
    """A partner's performance frame in the target's: in front of it and facing it, `(4, 4)`.

    The same in every interaction; how near the partner really comes is in its motion.

    Args:
        scale: Mean `motion_scale` of both bodies: larger people stand farther apart.
    """
    return compose_pose(yaw_quaternion(np.pi), np.array([0.0, 0.0, scale * PAIR_DISTANCE_M]))


@dataclasses.dataclass(frozen=True)
class Performance:
    """A motion in a body, and its partner's if there is one, about the target's anchor."""

    motion: Motion
    avatar: Avatar
    partner: tuple[Motion, Avatar] | None = None

    def people(self, T_world_performance: FloatArray) -> tuple[Person, ...]:
        """Target, then partner, at a place in the world `(4, 4)`."""
        target = Person(self.motion, self.avatar, T_world_performance)
        if self.partner is None:
            return (target,)
        scale = 0.5 * (self.avatar.motion_scale + self.partner[1].motion_scale)
        return (target, Person(*self.partner, T_world_performance @ partner_place(scale)))

    def footprint(self, *, num_instants: int = 24) -> FloatArray:
        """Where pelvises are over the cycle, in the target's frame, on the floor, `(n, 3)`."""
        instants = np.arange(num_instants) * self.motion.duration_s / num_instants
        ways = []
        for person in self.people(np.eye(4)):
            way = person.joint_frames(instants)[:, 0, :3, 3]
            way[:, 1] = 0.0
            ways.append(way)
        return np.concatenate(ways)


@dataclasses.dataclass(frozen=True)
class Shares:
    """Visible shares over the cycle, `(num_candidates,)` each, the worst of all performances."""

    visible_low: FloatArray
    """Least, over the performances, of the cycle's mean visible share."""
    visible_high: FloatArray
    """Greatest of them."""
    in_image_low: FloatArray
    """Least share inside the image, hidden or not."""


def measure_shares(
    performances: list[Performance],
    T_world_performance: FloatArray,
    T_world_camera: FloatArray,
    *,
    scene: Scene,
    camera: Camera,
    robot: Robot,
    caster: RayCaster,
) -> Shares:
    """Shares of `k` candidate placements for every performance, in one batch of rays each.

    Args:
        performances: The same performer and action under different emotions.
        T_world_performance: Places, `(k, 4, 4)`.
        T_world_camera: Cameras at the starts, `(k, 4, 4)`.
        scene: For the world.
        camera: Intrinsics.
        robot: For the world.
        caster: Rays against the scene.
    """
    visible, in_image = [], []
    eyes = T_world_camera[:, :3, 3]
    for performance in performances:
        world = World(scene, performance.people(np.eye(4)), camera, robot)
        samples = body_samples(world, cycle_instants(performance.motion.duration_s))
        points = transform_points(T_world_performance[:, None], samples.points)
        inside = camera.sees(points, T_world_camera[:, None])
        hidden = caster.hidden(eyes[:, None, None], points)
        local_eyes = transform_points(invert_pose(T_world_performance), eyes[:, None])[:, 0]
        local_eyes = np.broadcast_to(local_eyes, (_INSTANTS, *local_eyes.shape))
        hidden |= np.swapaxes(samples.hidden_by_partner(local_eyes), 0, 1)
        visible.append((inside & ~hidden).mean(axis=(1, 2)))
        in_image.append(inside.mean(axis=(1, 2)))
    return Shares(
        visible_low=np.min(visible, axis=0),
        visible_high=np.max(visible, axis=0),
        in_image_low=np.min(in_image, axis=0),
    )
