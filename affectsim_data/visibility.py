"""Who hides what: ray casting against scenes and people, and the visible share of a body."""

from __future__ import annotations

import dataclasses
import functools
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.cameras import Camera
from affectsim_data.episodes import Person, World
from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene

__all__ = [
    "BodySamples",
    "RayCaster",
    "VisibleShare",
    "body_samples",
    "scene_caster",
    "visible_share",
]

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
        shape = np.broadcast_shapes(np.shape(origins), np.shape(directions))
        o, d = (_rays(np.broadcast_to(np.asarray(x), shape)) for x in (origins, directions))
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
        eye, target = np.broadcast_arrays(
            np.asarray(eyes, np.float64), np.asarray(targets, np.float64)
        )
        way = target - eye
        length = np.linalg.norm(way, axis=-1)
        directions = way / np.maximum(length, 1e-9)[..., None]
        reach = np.maximum(length - _SURFACE_GAP_M, 0.0)
        if self._embree is None:
            blocked: NDArray[np.bool_] = self.distance(eye, directions) < reach
            return blocked
        found = self._embree.run(
            _rays(eye), _rays(directions), dists=_flat(reach), query="OCCLUDED"
        )
        return np.asarray(found >= 0).reshape(length.shape)


@functools.lru_cache(maxsize=4)
def scene_caster(scene: Scene) -> RayCaster:
    """Rays against a scene; the casters of the last few scenes are kept."""
    return RayCaster(*scene.mesh())


def _rays(vectors: NDArray[Any]) -> NDArray[np.float32]:
    return np.ascontiguousarray(vectors.reshape(-1, 3), np.float32)


def _flat(values: NDArray[Any]) -> NDArray[np.float32]:
    return np.ascontiguousarray(values.reshape(-1), np.float32)


@dataclasses.dataclass(frozen=True)
class BodySamples:
    """Points on the target's body at some instants, and what else may hide them then."""

    points: FloatArray
    """On the target's surface, in the world, `(num_frames, num_points, 3)`."""
    partner_casters: tuple[RayCaster, ...]
    """The other participant at each of those instants; empty if there is none."""

    def hidden_by_partner(self, eyes: FloatArray) -> NDArray[np.bool_]:
        """Points the other participant hides from `eyes`, `(num_frames, k, 3)`:
        bool `(num_frames, k, num_points)`."""
        shape = (len(self.points), eyes.shape[1], self.points.shape[1])
        if not self.partner_casters:
            return np.zeros(shape, bool)
        frames = zip(self.partner_casters, eyes, self.points, strict=True)
        return np.stack(
            [caster.hidden(eye[:, None], target[None]) for caster, eye, target in frames]
        )


def body_samples(
    world: World, time_s: ArrayLike, *, num_points: int = SURFACE_POINTS
) -> BodySamples:
    """Surface points of the target at motion instants `(num_frames,)`.

    The points are the same for every episode of a body: drawn by area with a fixed seed.
    """
    instants = np.asarray(time_s, np.float64)
    rng = np.random.default_rng(0)
    samples = world.target.avatar.surface_samples(num_points, rng=rng)
    points = samples.skin(world.target.joint_matrices(instants))
    casters = [caster for person in world.people[1:] for caster in _casters(person, instants)]
    return BodySamples(points=points, partner_casters=tuple(casters))


def _casters(person: Person, time_s: FloatArray) -> list[RayCaster]:
    mesh = person.avatar.mesh(max_triangles=_PARTNER_TRIANGLES)
    return [
        RayCaster(vertices, mesh.faces) for vertices in mesh.skin(person.joint_matrices(time_s))
    ]


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
