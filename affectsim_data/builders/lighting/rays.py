"""Rays for light: which face each one meets, in single precision and large batches."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Array32", "LightRays"]

Array32 = NDArray[np.float32]

_GAP_M = 0.01
"""Rays to a light stop this short of it: its own pane or bulb throws no shadow."""


class LightRays:
    """Answers rays against one mesh; Embree where there is a wheel for it, else trimesh."""

    def __init__(self, vertices: Array32, faces: NDArray[np.int32]) -> None:
        self._embree: Any = None
        self._trimesh: Any = None
        try:
            from embreex import rtcore_scene
            from embreex.mesh_construction import TriangleMesh
        except ImportError:
            import trimesh

            self._trimesh = trimesh.Trimesh(vertices, faces, process=False, use_embree=False)
        else:
            self._embree = rtcore_scene.EmbreeScene()
            TriangleMesh(scene=self._embree, vertices=vertices, indices=faces)

    def first_hits(
        self, origins: Array32, directions: Array32
    ) -> tuple[NDArray[np.int32], Array32]:
        """Face each ray meets first, -1 for none, and how far away that is, `inf` for none.

        Args:
            origins: Metres, `(n, 3)`.
            directions: Unit, `(n, 3)`.
        """
        if self._embree is not None:
            hits = self._embree.run(origins, directions, output=1)
            faces, distance = hits["primID"], hits["tfar"]
            distance[faces < 0] = np.inf
            return faces, distance
        faces = np.full(len(origins), -1, np.int32)
        distance = np.full(len(origins), np.inf, np.float32)
        places, rays, met = self._trimesh.ray.intersects_location(
            origins, directions, multiple_hits=False
        )
        faces[rays], distance[rays] = met, np.linalg.norm(places - origins[rays], axis=1)
        return faces, distance

    def hidden(self, origins: Array32, target: Array32) -> NDArray[np.bool_]:
        """Whether anything stands between each of the origins `(n, 3)` and the target `(3,)`."""
        way = target - origins
        length = np.sqrt(np.einsum("ij,ij->i", way, way))
        directions = np.ascontiguousarray(way / np.maximum(length, 1e-6)[:, None])
        reach = np.maximum(length - np.float32(_GAP_M), np.float32(0.0))
        if self._embree is not None:
            return np.asarray(
                self._embree.run(origins, directions, dists=reach, query="OCCLUDED") >= 0
            )
        blocked = np.zeros(len(origins), bool)
        places, rays, _ = self._trimesh.ray.intersects_location(
            origins, directions, multiple_hits=False
        )
        blocked[rays] = np.linalg.norm(places - origins[rays], axis=1) < reach[rays]
        return blocked
