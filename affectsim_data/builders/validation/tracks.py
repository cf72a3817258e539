"""Bodies over a cycle, in their own performance frame: computed once per motion and body."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import SurfaceSamples
from affectsim_data.episodes import Person
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import FloatArray, transform_points
from affectsim_data.releases import Release
from affectsim_data.skeletons import JOINT_NAMES, JOINT_PARENTS
from affectsim_data.visibility import (
    SURFACE_POINTS,
    BodySamples,
    cycle_instants,
    people_samples,
)

__all__ = ["Bodies", "Pair", "Track", "placed"]

_HANDS = tuple(JOINT_NAMES.index(f"{side}_wrist") for side in ("left", "right"))
_SEAT = tuple(JOINT_NAMES.index(name) for name in ("pelvis", "left_hip", "right_hip"))
_TRACKS_KEPT, _FEW_KEPT = 2048, 64
_MAX_TRIANGLES = 2_500
Pair = tuple[str, str, str, str, bytes]
"""Motion and body of target and partner, and the partner's place, as bytes of a `(4, 4)` array."""


@dataclasses.dataclass(frozen=True, eq=False)
class Track:
    """A body over one cycle, in the performance frame, metres."""

    surface: FloatArray
    """Points that shares are counted over, at the cycle's instants, `(12, k, 3)`."""
    roots: FloatArray
    """The joint that moves each of these points most, then, `(12, k, 3)`."""
    sits: NDArray[np.bool_]
    """Which of these points are of seat and thighs, `(k,)`."""
    bones: FloatArray
    """Both ends of every bone, then, `(12, 21, 2, 3)`."""
    center: FloatArray
    """Middle of the body, then, `(12, 3)`."""
    pelvis: FloatArray
    """Pelvis in every frame, `(num_frames, 3)`."""
    duration_s: float
    """Of the cycle."""
    heading: float
    """Mean yaw the pelvis faces, radians, 0 along +Z."""
    hip_height_m: float
    """Pelvis of the body standing."""
    motion_scale: float
    """Of the body, to the canonical one."""


class Bodies:
    """The tracks of a release, kept from scene to scene; a worker process begins with none."""

    def __init__(self, release: Release) -> None:
        self._release = release
        self.track = functools.lru_cache(maxsize=_TRACKS_KEPT)(self._track)
        """By motion and body."""
        self.hands = functools.lru_cache(maxsize=_FEW_KEPT)(self._hands)
        """Points of both hands in every frame, `(num_frames, k, 3)`, by motion and body."""
        self.pair = functools.lru_cache(maxsize=_FEW_KEPT)(self._pair)
        """The target's points then, and its partner as an obstacle."""

    def __reduce__(self) -> tuple[type[Bodies], tuple[Release]]:
        return (Bodies, (self._release,))

    def person(self, motion_id: str, avatar_id: str) -> Person:
        """A performer at the origin of the performance frame.

        Raises:
            KeyError: The release has no such motion or body.
            ValueError: It has, and it cannot be read.
        """
        release = self._release
        return Person(release.motion(motion_id), release.avatar(avatar_id), np.eye(4))

    def _track(self, motion_id: str, avatar_id: str) -> Track:
        person = self.person(motion_id, avatar_id)
        motion, avatar = person.motion, person.avatar
        times = cycle_instants(motion.duration_s)
        points = avatar.surface_samples(SURFACE_POINTS, rng=np.random.default_rng(0))
        moved_by = _heaviest(points.joint_indices, points.joint_weights)
        joints = person.joint_frames(times)[..., :3, 3]
        path = body_path(person)
        return Track(
            surface=people_samples((person,), times).points,
            roots=joints[:, moved_by],
            sits=np.isin(moved_by, _SEAT),
            bones=np.stack([joints[:, list(JOINT_PARENTS[1:])], joints[:, 1:]], axis=2),
            center=path.at(times)[0],
            pelvis=motion.root_translation * avatar.motion_scale,
            duration_s=motion.duration_s,
            heading=float(np.angle(np.exp(1j * path.heading).mean())),
            hip_height_m=avatar.skeleton.hip_height,
            motion_scale=avatar.motion_scale,
        )

    def _hands(self, motion_id: str, avatar_id: str) -> FloatArray:
        person = self.person(motion_id, avatar_id)
        times = np.arange(person.motion.num_frames) / person.motion.fps
        return _points_of(person, _HANDS).skin(person.joint_matrices(times))

    def _pair(self, pair: Pair) -> BodySamples:
        target, partner = self.person(*pair[:2]), self.person(*pair[2:4])
        place = np.frombuffer(pair[4]).reshape(4, 4)
        partner = dataclasses.replace(partner, T_world_performance=place)
        return people_samples((target, partner), cycle_instants(target.motion.duration_s))


def placed(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Points `(n, ..., 3)` of performance frames that are at poses `(n, 4, 4)`."""
    flat = points.reshape(len(points), -1, 3)
    return transform_points(poses, flat).reshape(points.shape)


def _points_of(person: Person, joints: tuple[int, ...]) -> SurfaceSamples:
    """Vertices of a body that some joints move most."""
    mesh = person.avatar.mesh(max_triangles=_MAX_TRIANGLES)
    chosen = np.isin(_heaviest(mesh.joint_indices, mesh.joint_weights), joints)
    return SurfaceSamples(
        mesh.positions[chosen].astype(np.float64),
        mesh.joint_indices[chosen],
        mesh.joint_weights[chosen] / 255.0,
    )


def _heaviest(indices: NDArray[np.uint8], weights: NDArray[Any]) -> NDArray[np.uint8]:
    """The joint with the greatest weight in each row, `(n,)`."""
    return np.take_along_axis(indices, weights.argmax(axis=1)[:, None], axis=1)[:, 0]
