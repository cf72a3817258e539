"""Scenes made of code for the tests of baking, and how a scene looks at a point."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray
from render_scenes import grid, scene_of

from affectsim_data.poses import FloatArray
from affectsim_data.scenes import Scene, Surface

__all__ = ["looks", "picture", "points_on", "tile", "wall_of_pictures"]


def picture(side: int, seed: int) -> NDArray[np.uint8]:
    """A smooth texture of many colours that repeats without a seam, `(side, side, 3)`."""
    rng = np.random.default_rng(seed)
    across = np.arange(side)[None, :, None] / side
    down = np.arange(side)[:, None, None] / side
    turns, phases = rng.integers(1, 3, 6), rng.uniform(0.0, 2.0 * np.pi, 6)
    waves = np.sin(2.0 * np.pi * turns[:3] * across + phases[:3])
    waves = waves * np.sin(2.0 * np.pi * turns[3:] * down + phases[3:])
    return np.asarray(np.rint(128.0 + 100.0 * waves), np.uint8)


def tile(
    name: str,
    at: Sequence[float],
    texture: NDArray[np.uint8] | None,
    *,
    uv: tuple[float, float, float, float] = (0.0, 0.0, 1.0, 1.0),
    size: float = 1.0,
    steps: int = 1,
) -> Surface:
    """A square in the wall z = `at[2]` that shows the texture from `uv` low to high."""
    one = grid(at, (size, 0.0, 0.0), (0.0, size, 0.0), steps, color=(255, 240, 225), name=name)
    places = (one.positions[:, :2] - np.array(at[:2])) / size
    low, high = np.array(uv[:2]), np.array(uv[2:])
    uvs = None if texture is None else (low + places * (high - low)).astype(np.float32)
    return dataclasses.replace(one, uvs=uvs, texture=texture)


def wall_of_pictures(count: int, *, side: int = 32, uv_scale: float = 1.0) -> Scene:
    """Squares side by side, each with a texture of its own."""
    columns = math.ceil(math.sqrt(count))
    tiles = [
        tile(
            f"picture {i}",
            (1.5 * (i % columns), 1.5 * (i // columns), 0.0),
            picture(side, i),
            uv=(0.0, 0.0, uv_scale, uv_scale),
        )
        for i in range(count)
    ]
    return scene_of(*tiles, scene_id="gallery")


def points_on(scene: Scene, count: int, seed: int = 0) -> FloatArray:
    """Points on random triangles of a scene, not on their edges, `(count, 3)`."""
    rng = np.random.default_rng(seed)
    vertices, faces = scene.mesh()
    weights = 0.9 * rng.dirichlet((1.0, 1.0, 1.0), count) + 0.1 / 3.0
    corners = vertices[faces[rng.integers(len(faces), size=count)]]
    return np.asarray(np.einsum("nk,nkc->nc", weights, corners))


def looks(scene: Scene, points: FloatArray) -> FloatArray:
    """Colour of a scene at points on it, texture bilinear and repeated, `(n, 3)`; nan if not on it.

    Worked out pixel by pixel with numbers alone: the oracle for what baking may not change.
    """
    found = np.full((len(points), 3), np.nan)
    for surface in scene.surfaces:
        corners = surface.positions[surface.faces].astype(np.float64)
        weights = _weights(points, corners)
        place = np.einsum("pfk,fkc->pfc", weights, corners)
        near = np.linalg.norm(place - points[:, None], axis=2) < 1e-3
        on = near & (weights > -1e-6).all(axis=2)
        rows = np.flatnonzero(on.any(axis=1))
        face = np.argmax(on[rows], axis=1)
        mix = weights[rows, face]
        own = surface.faces[face]
        color = np.einsum("nk,nkc->nc", mix, surface.colors[own][..., :3].astype(np.float64))
        if surface.texture is not None and surface.uvs is not None:
            uvs = np.einsum("nk,nkc->nc", mix, surface.uvs[own].astype(np.float64))
            color *= _bilinear(surface.texture, uvs) / 255.0
        found[rows] = color
    return found


def _weights(points: FloatArray, corners: FloatArray) -> FloatArray:
    """Barycentric weights of all points in all triangles, `(points, triangles, 3)`."""
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    uu, vv, uv = ((a * b).sum(axis=1) for a, b in ((u, u), (v, v), (u, v)))
    way = points[:, None] - corners[None, :, 0]
    wu, wv = (way * u).sum(axis=2), (way * v).sum(axis=2)
    second = np.stack([vv * wu - uv * wv, uu * wv - uv * wu], axis=2)
    second /= (uu * vv - uv * uv)[:, None]
    return np.concatenate([1.0 - second.sum(axis=2, keepdims=True), second], axis=2)


def _bilinear(texture: NDArray[np.uint8], uvs: FloatArray) -> FloatArray:
    height, width = texture.shape[:2]
    at = uvs * (width, height) - 0.5
    # `remap` does not repeat: a border of one texel all around does.
    around = cv2.copyMakeBorder(texture, 1, 1, 1, 1, cv2.BORDER_WRAP).astype(np.float64)
    x, y = np.floor(at[:, 0]).astype(int), np.floor(at[:, 1]).astype(int)
    right, down = (at - np.stack([x, y], axis=1)).T[:, :, None]
    x, y = x % width + 1, y % height + 1
    top = around[y, x] * (1.0 - right) + around[y, x + 1] * right
    bottom = around[y + 1, x] * (1.0 - right) + around[y + 1, x + 1] * right
    return np.asarray(top * (1.0 - down) + bottom * down)
