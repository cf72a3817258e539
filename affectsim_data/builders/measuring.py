"""What placing a performance asks for, measured in its own frame, and shares of placed ones."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
from collections import OrderedDict

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import Avatar, SurfaceSamples
from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person
from affectsim_data.motions import Motion
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    invert_pose,
    transform_points,
    yaw_quaternion,
)
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS
from affectsim_data.visibility import (
    SURFACE_POINTS,
    BodySamples,
    RayCaster,
    cycle_instants,
    people_samples,
)

__all__ = [
    "Measures",
    "Performance",
    "Shares",
    "cycle_instants",
    "measure_performance",
    "measure_shares",
    "on_floor",
    "partner_place",
    "share_inside",
]

PAIR_DISTANCE_M = 1.25
"""Between the anchors of two people of canonical size who interact."""
PELVIS_OVER_SEAT_M = 0.10
"""The pelvis joint of the canonical body above the seat it sits on."""
_SKIN_M = 0.03
"""Bodies may be this deep in things: cushions give, and so do clothes."""
_FLOOR_GIVES_M, _ABOVE_FLOOR_M = 0.06, 0.005
"""How much deeper they may be in the floor, and where such points are put instead."""
_LOWEST_M = 0.03
"""A pelvis within this of its lowest height is down."""
_HANDS = [JOINT_NAMES.index(name) for name in ("left_wrist", "right_wrist")]
_HAND_TRIANGLES, _HAND_INSTANTS = 2_500, 12
_SEAT = [JOINT_NAMES.index(name) for name in ("pelvis", "left_hip", "right_hip")]
_FOOTPRINT_INSTANTS = 24
_CACHED = 2048
"""Performances whose measures are kept: some 100 kB each."""


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

    def footprint(self, *, num_instants: int = _FOOTPRINT_INSTANTS) -> FloatArray:
        """Where pelvises are over the cycle, in the target's frame, on the floor, `(n, 3)`."""
        instants = np.arange(num_instants) * self.motion.duration_s / num_instants
        ways = []
        for person in self.people(np.eye(4)):
            way = person.joint_frames(instants)[:, 0, :3, 3]
            way[:, 1] = 0.0
            ways.append(way)
        return np.concatenate(ways)


@dataclasses.dataclass(frozen=True, eq=False)
class Measures:
    """What placing asks of a performance, in its own frame; the same wherever it is placed."""

    samples: BodySamples
    """The target at the cycle instants, and the partner that may hide it."""
    footprint: FloatArray
    """Where pelvises are over the cycle, on the floor, `(n, 3)`."""
    inner: FloatArray
    """Where rays inside the bodies begin: joints, `(num_rays, 3)`."""
    outer: FloatArray
    """Where they end: a little below the skin, or at the next joint, `(num_rays, 3)`."""
    sits: NDArray[np.bool_]
    """Which of them end in seat and thighs, that a sitter presses into a cushion, `(num_rays,)`."""
    headings: FloatArray
    """Yaw the target's pelvis faces, smoothed, radians, evenly over the cycle, `(n,)`."""
    low_pelvis: FloatArray
    """Mean place of the target's pelvis while it is lowest, `(3,)`."""
    low_heading: float
    """Yaw it faces then, radians."""
    hand: FloatArray
    """The target's hand where it is farthest ahead of the mean heading, `(3,)`."""

    @functools.cached_property
    def mean_heading(self) -> float:
        """Circular mean of the headings, radians."""
        return _mean_angle(self.headings)

    @functools.cached_property
    def middle(self) -> FloatArray:
        """Mean place of the target's pelvis, on the floor, `(3,)`."""
        middle: FloatArray = self.footprint[:_FOOTPRINT_INSTANTS].mean(axis=0)
        return middle


_measured: OrderedDict[bytes, Measures] = OrderedDict()


def measure_performance(performance: Performance) -> Measures:
    """Measures of a performance; those of the last few hundred are kept."""
    key = _fingerprint(performance)
    measures = _measured.get(key)
    if measures is None:
        measures = _measured[key] = _measure(performance)
        if len(_measured) > _CACHED:
            _measured.popitem(last=False)
    _measured.move_to_end(key)
    return measures


def _fingerprint(performance: Performance) -> bytes:
    """By content, because every process and scene may hold copies of its own."""
    digest = hashlib.blake2b(digest_size=16)
    for person in performance.people(np.eye(4)):
        digest.update(f"{person.motion.motion_id}\n{person.motion.fps}\n".encode())
        digest.update(f"{person.avatar.avatar_id}\n".encode())
        digest.update(person.avatar.skeleton.joint_offsets.tobytes())
        digest.update(np.ascontiguousarray(person.motion.root_translation).tobytes())
        digest.update(np.ascontiguousarray(person.motion.joint_rotations).tobytes())
    return digest.digest()


def _measure(performance: Performance) -> Measures:
    people = performance.people(np.eye(4))
    instants = cycle_instants(performance.motion.duration_s)
    rays = [_rays_inside(person, instants) for person in people]
    headings = body_path(people[0]).heading
    frames = np.arange(performance.motion.num_frames) / performance.motion.fps
    poses = people[0].joint_frames(frames)
    joints = poses[..., :3, 3]
    height = joints[:, 0, 1]
    low = height <= height.min() + _LOWEST_M
    return Measures(
        samples=people_samples(people, instants),
        footprint=performance.footprint(),
        inner=np.concatenate([inner for inner, _, _ in rays]),
        outer=np.concatenate([outer for _, outer, _ in rays]),
        sits=np.concatenate([sits for _, _, sits in rays]),
        headings=headings,
        low_pelvis=joints[low, 0].mean(axis=0),
        low_heading=_mean_angle(np.arctan2(*poses[low, 0, ::2, 2].T)),
        hand=_farthest_hand(people[0], joints, frames, _mean_angle(headings)),
    )


def _rays_inside(
    person: Person, time_s: FloatArray
) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
    """Rays from joints to the skin they move and to the next joints, `(num_rays, 3)` each, and
    which of them end in seat and thighs, `(num_rays,)`."""
    surface = person.avatar.surface_samples(SURFACE_POINTS, rng=np.random.default_rng(0))
    heaviest = surface.joint_weights.argmax(axis=1)
    joint = surface.joint_indices[np.arange(SURFACE_POINTS), heaviest]
    joints = person.joint_frames(time_s)[..., :3, 3]
    skin = surface.skin(person.joint_matrices(time_s)) - joints[:, joint]
    length = np.linalg.norm(skin, axis=-1, keepdims=True)
    skin *= np.maximum(length - _SKIN_M, 0.0) / np.maximum(length, 1e-9)
    inner = on_floor(np.concatenate([joints[:, joint], joints[:, JOINT_PARENTS[1:]]], axis=1))
    outer = on_floor(np.concatenate([joints[:, joint] + skin, joints[:, 1:]], axis=1))
    sits = np.concatenate([np.isin(joint, _SEAT), np.zeros(joints.shape[1] - 1, bool)])
    return inner.reshape(-1, 3), outer.reshape(-1, 3), np.tile(sits, len(joints))


def on_floor(points: FloatArray) -> FloatArray:
    """Points `(..., 3)` in the performance frame, those a little under its floor put onto it.

    Who kneels or collapses presses on the floor; how deep, the screening of motions judges.
    """
    height = points[..., 1]
    pressed = (height > -_FLOOR_GIVES_M) & (height < _ABOVE_FLOOR_M)
    lifted = points.copy()
    lifted[..., 1] = np.where(pressed, _ABOVE_FLOOR_M, height)
    return lifted


def _mean_angle(angles: FloatArray) -> float:
    """Circular mean, radians."""
    return float(np.angle(np.exp(1j * angles).mean()))


def _farthest_hand(
    person: Person, joints: FloatArray, time_s: FloatArray, heading: float
) -> FloatArray:
    """The point of either hand that is farthest along a heading over the cycle, `(3,)`.

    Looked for where wrists are farthest, at up to `_HAND_INSTANTS` instants; the wrist itself where
    a body has no hands.
    """
    ahead = np.array([np.sin(heading), 0.0, np.cos(heading)])
    wrists = joints[:, _HANDS]
    latest = np.argsort(-(wrists @ ahead).max(axis=1), kind="stable")[:_HAND_INSTANTS]
    mesh = person.avatar.mesh(max_triangles=_HAND_TRIANGLES)
    heaviest = mesh.joint_indices[np.arange(len(mesh.positions)), mesh.joint_weights.argmax(axis=1)]
    chosen = np.isin(heaviest, _HANDS)
    hands = SurfaceSamples(
        mesh.positions[chosen].astype(np.float64),
        mesh.joint_indices[chosen],
        mesh.joint_weights[chosen] / 255.0,
    )
    skin = hands.skin(person.joint_matrices(time_s[latest])).reshape(-1, 3)
    points = np.concatenate([skin, wrists[latest].reshape(-1, 3)])
    farthest: FloatArray = points[int(np.argmax(points @ ahead))]
    return farthest


@dataclasses.dataclass(frozen=True)
class Shares:
    """What a performance shows to candidate cameras over the cycle, `(num_candidates,)` each."""

    visible: FloatArray
    """Mean visible share."""
    in_image: FloatArray
    """Mean share inside the image, hidden or not."""


def measure_shares(
    measures: Measures,
    T_world_performance: FloatArray,
    T_world_camera: FloatArray,
    *,
    camera: Camera,
    caster: RayCaster,
    few: bool = False,
) -> Shares:
    """Shares of `k` candidate placements, in one batch of rays.

    Args:
        measures: Of the performance.
        T_world_performance: Places, `(k, 4, 4)`.
        T_world_camera: Cameras at the starts, `(k, 4, 4)`.
        camera: Intrinsics.
        caster: Rays against the scene.
        few: Whether a tenth of the rays will do, and no partner: shares to about a tenth.
    """
    eyes = T_world_camera[:, :3, 3]
    body = measures.samples.points[::4, ::3] if few else measures.samples.points
    points = transform_points(T_world_performance[:, None], body)
    inside = camera.sees(points, T_world_camera[:, None])
    hidden = caster.hidden(eyes[:, None, None], points)
    if measures.samples.partner is not None and not few:
        local_eyes = transform_points(invert_pose(T_world_performance), eyes[:, None])[:, 0]
        hidden |= np.swapaxes(measures.samples.hidden_by_partner(local_eyes[None]), 0, 1)
    return Shares((inside & ~hidden).mean(axis=(1, 2)), inside.mean(axis=(1, 2)))


def share_inside(
    measures: Measures, T_world_performance: FloatArray, caster: RayCaster
) -> tuple[FloatArray, FloatArray]:
    """Shares of rays inside the bodies that meet the scene, 0 for bodies free of things.

    Args:
        measures: Of the performance.
        T_world_performance: Places, `(k, 4, 4)`.
        caster: Rays against the scene.

    Returns:
        Of all rays, those that end in seat and thighs and the other ones, `(k,)` each.
    """
    inner = transform_points(T_world_performance, measures.inner)
    outer = transform_points(T_world_performance, measures.outer)
    met = caster.hidden(inner, outer)
    count = met.shape[1]
    sitting = met[:, measures.sits].sum(axis=1) / count
    return sitting, met[:, ~measures.sits].sum(axis=1) / count
