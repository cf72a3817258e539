"""Who hides what: ray casting against scenes and people, and the visible share of a body."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person, World
from affectsim_data.poses import FloatArray, invert_pose, transform_points
from affectsim_data.scenes import Scene

__all__ = [
    "BodySamples",
    "MovingCaster",
    "RayCaster",
    "VisibleShare",
    "body_samples",
    "cycle_instants",
    "people_samples",
    "scene_caster",
    "visible_share",
]

CYCLE_INSTANTS = 12
"""Instants of a motion cycle at which shares are measured."""

SURFACE_POINTS = 96
"""Body-surface points a share is counted over; DESIGN asks for at least 64."""
_PARTNER_TRIANGLES = 2_500
"""Level of detail of the other participant as an obstacle."""
_SURFACE_GAP_M = 0.005
"""Rays stop this short of their target, so that a surface does not hide itself."""


class RayCaster:
    """Answers rays against one triangle mesh, in batches; Embree where there is a wheel for it."""

    def __init__(self, vertices: ArrayLike, faces: ArrayLike) -> None:
        self._vertices = np.ascontiguousarray(vertices, np.float32)
        self._faces = np.ascontiguousarray(faces, np.int32)
        self._embree: Any = None
        self._trimesh: Any = None
        try:
            from embreex import rtcore_scene
            from embreex.mesh_construction import TriangleMesh
        except ImportError:
            import trimesh

            self._trimesh = trimesh.Trimesh(
                self._vertices, self._faces, process=False, use_embree=False
            )
        else:
            self._embree = rtcore_scene.EmbreeScene()
            TriangleMesh(scene=self._embree, vertices=self._vertices, indices=self._faces)

    def __reduce__(self) -> tuple[Any, ...]:
        """Embree scenes do not travel between processes; the mesh does."""
        return (RayCaster, (self._vertices, self._faces))

    def distance(
        self, origins: ArrayLike, directions: ArrayLike, *, limit: float = np.inf
    ) -> FloatArray:
        """Way to the first hit along unit directions `(..., 3)`, metres `(...)`; `inf` for none."""
        o, d = np.asarray(origins, np.float32), np.asarray(directions, np.float32)
        shape = np.broadcast_shapes(o.shape, d.shape)
        o, d = (_rays(np.broadcast_to(x, shape)) for x in (o, d))
        if self._embree is not None:
            far = np.float32(min(limit, 1e6))
            # Embree writes into the array of limits it is given and returns that very array.
            reach = np.full(len(o), far, np.float32)
            hits = self._embree.run(o, d, dists=reach, query="DISTANCE").astype(np.float64)
            hits[hits >= far] = np.inf
        else:
            hits = np.full(len(o), np.inf)
            places, rays, _ = self._trimesh.ray.intersects_location(o, d, multiple_hits=False)
            hits[rays] = np.linalg.norm(places - o[rays], axis=1)
            hits[hits > limit] = np.inf
        return np.asarray(hits, np.float64).reshape(shape[:-1])

    def hidden(self, eyes: ArrayLike, targets: ArrayLike) -> NDArray[np.bool_]:
        """Whether anything stands between eyes and targets, `(..., 3)` each, bool `(...)`."""
        eye, target = np.asarray(eyes, np.float32), np.asarray(targets, np.float32)
        way = target - eye
        length = np.sqrt(np.einsum("...i,...i->...", way, way))
        way /= np.maximum(length, np.float32(1e-9))[..., None]
        reach = np.maximum(length - np.float32(_SURFACE_GAP_M), np.float32(0.0))
        origins = np.broadcast_to(eye, way.shape)
        if self._embree is None:
            blocked: NDArray[np.bool_] = self.distance(origins, way) < reach
            return blocked
        found = self._embree.run(_rays(origins), _rays(way), dists=reach.ravel(), query="OCCLUDED")
        return np.asarray(found >= 0).reshape(length.shape)


@functools.lru_cache(maxsize=4)
def scene_caster(scene: Scene) -> RayCaster:
    """Rays against a scene; the casters of the last few scenes are kept."""
    return RayCaster(*scene.mesh())


def _rays(vectors: NDArray[Any]) -> NDArray[np.float32]:
    return np.ascontiguousarray(vectors.reshape(-1, 3), np.float32)


def cycle_instants(duration_s: float) -> FloatArray:
    """Instants spread over a cycle at which shares are measured, seconds, `(12,)`."""
    instants: FloatArray = np.arange(CYCLE_INSTANTS) * duration_s / CYCLE_INSTANTS
    return instants


class MovingCaster:
    """Rays against a body at some instants: a copy for each, far apart, so one batch asks all."""

    _APART_M = 256.0
    """Farther than rays go; float32 still tells 0.2 mm apart over 12 copies."""

    def __init__(self, vertices: FloatArray, faces: NDArray[Any]) -> None:
        """Of a mesh that moves.

        Args:
            vertices: At each instant, `(num_frames, num_vertices, 3)`.
            faces: Triangles, `(num_triangles, 3)`.
        """
        count, num_vertices, _ = vertices.shape
        self._shift = np.zeros((count, 3))
        self._shift[:, 0] = self._APART_M * np.arange(count)
        first = num_vertices * np.arange(count)[:, None, None]
        self._caster = RayCaster(
            (vertices + self._shift[:, None]).reshape(-1, 3), (first + faces).reshape(-1, 3)
        )

    def hidden(self, eyes: ArrayLike, targets: ArrayLike) -> NDArray[np.bool_]:
        """Whether the body stands between eyes and targets, each `(..., 3)` and
        broadcast to `(num_frames, ..., 3)`; bool `(num_frames, ...)`."""
        eye, target = np.broadcast_arrays(
            np.asarray(eyes, np.float64), np.asarray(targets, np.float64)
        )
        shift = self._shift.reshape(-1, *(1,) * (eye.ndim - 2), 3)
        return self._caster.hidden(eye + shift, target + shift)


@dataclasses.dataclass(frozen=True, eq=False)
class BodySamples:
    """Points on the target's body at some instants, and what else may hide them then."""

    points: FloatArray
    """On the target's surface, in the world, `(num_frames, num_points, 3)`."""
    partner: MovingCaster | None = None
    """The other participant at each of those instants."""
    T_partner_world: FloatArray | None = None
    """Takes eyes and points into the frame `partner` is in, `(4, 4)`; `None` is the identity."""

    def placed(self, T_world_performance: ArrayLike) -> BodySamples:
        """The same body elsewhere: points moved, the partner's rays shared.

        Args:
            T_world_performance: Where the frame that the samples are in goes, `(4, 4)`.
        """
        back = invert_pose(T_world_performance)
        if self.T_partner_world is not None:
            back = self.T_partner_world @ back
        points = transform_points(T_world_performance, self.points)
        return BodySamples(points, self.partner, back)

    def hidden_by_partner(
        self, eyes: ArrayLike, points: ArrayLike | None = None
    ) -> NDArray[np.bool_]:
        """Points the other participant hides from eyes; nothing if there is no partner.

        Args:
            eyes: `(num_frames or 1, k, 3)`.
            points: Other ones than the body's, `(num_frames or 1, k or 1, num_points, 3)`.

        Returns:
            Bool, `(num_frames, k, num_points)`.
        """
        eye = np.asarray(eyes, np.float64)
        target = self.points[:, None] if points is None else np.asarray(points, np.float64)
        shape = (
            len(self.points),
            *np.broadcast_shapes(eye[:, :, None, 0].shape, target.shape[:-1])[1:],
        )
        if self.partner is None:
            return np.zeros(shape, bool)
        if self.T_partner_world is not None:
            eye = transform_points(self.T_partner_world, eye)
            target = transform_points(self.T_partner_world, target)
        return self.partner.hidden(eye[:, :, None], target).reshape(shape)


def body_samples(
    world: World, time_s: ArrayLike, *, num_points: int = SURFACE_POINTS
) -> BodySamples:
    """Surface points of the target at motion instants `(num_frames,)`.

    The points are the same for every episode of a body: drawn by area with a fixed seed.
    """
    return people_samples(world.people, time_s, num_points=num_points)


def people_samples(
    people: Sequence[Person], time_s: ArrayLike, *, num_points: int = SURFACE_POINTS
) -> BodySamples:
    """`body_samples` of a target and, if there is one, its partner, wherever they are."""
    instants = np.asarray(time_s, np.float64)
    points = _surface_points(people[0], instants, num_points)
    if len(people) == 1:
        return BodySamples(points)
    mesh = people[1].avatar.mesh(max_triangles=_PARTNER_TRIANGLES)
    return BodySamples(
        points, MovingCaster(mesh.skin(people[1].joint_matrices(instants)), mesh.faces)
    )


def _surface_points(person: Person, time_s: FloatArray, num_points: int) -> FloatArray:
    samples = person.avatar.surface_samples(num_points, rng=np.random.default_rng(0))
    return samples.skin(person.joint_matrices(time_s))


@dataclasses.dataclass(frozen=True)
class VisibleShare:
    """Shares of body-surface points, in [0, 1], each `(num_frames, k)`."""

    in_image: FloatArray
    """Fall inside the image, hidden or not."""
    unhidden: FloatArray
    """Nothing stands before them, inside the image or not."""
    visible: FloatArray
    """Both."""


def visible_share(
    samples: BodySamples, T_world_camera: ArrayLike, camera: Camera, caster: RayCaster
) -> VisibleShare:
    """How much of the target each of `k` cameras sees at each instant.

    A point counts as seen if it falls in the image and neither the scene nor the other participant
    is in the way; the body's own far side counts as seen, as DESIGN section 4 defines it.

    Args:
        samples: The body at `num_frames` instants.
        T_world_camera: Poses `(num_frames or 1, k, 4, 4)`.
        camera: Intrinsics of all of them.
        caster: The scene.
    """
    poses = np.asarray(T_world_camera, np.float64)
    poses = np.broadcast_to(poses, (len(samples.points), *poses.shape[1:]))
    eyes = poses[..., :3, 3]
    inside = camera.sees(samples.points[:, None], poses)
    hidden = caster.hidden(eyes[:, :, None], samples.points[:, None])
    hidden |= samples.hidden_by_partner(eyes)
    return VisibleShare(
        in_image=inside.mean(axis=-1),
        unhidden=(~hidden).mean(axis=-1),
        visible=(inside & ~hidden).mean(axis=-1),
    )
