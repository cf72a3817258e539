"""Scenes and bodies in device memory."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import AvatarMesh
from affectsim_data.poses import FloatArray
from affectsim_data.render.framing import joint_boxes, visible_boxes
from affectsim_data.render.solids import closed_solids
from affectsim_data.scenes import Scene, Surface

__all__ = ["BodyBuffers", "SceneBuffers", "split_faces"]

CHUNK_TRIANGLES = 768
"""Small enough that most of a furnished flat is culled, large enough that calls do not count."""

SOLID_MARGIN_M = 0.25
"""How far from a solid the eye must be for its back to be left out: the near plane cuts nothing."""

_serials = itertools.count()

_SCENE_VERTEX = np.dtype([("position", "<f4", 3), ("color", "u1", 4), ("uv", "<f4", 2)])
_BODY_VERTEX = np.dtype(
    [
        ("position", "<f4", 3),
        ("normal", "<f4", 3),
        ("color", "u1", 4),
        ("joints", "u1", 4),
        ("weights", "u1", 4),
    ]
)


def split_faces(centroids: FloatArray, max_faces: int) -> Iterator[NDArray[np.int64]]:
    """Indices of triangles by place, at most `max_faces` each: halved along the longest side."""
    stack = [np.arange(len(centroids))]
    while stack:
        chosen = stack.pop()
        if len(chosen) <= max_faces:
            yield np.sort(chosen)
            continue
        points = centroids[chosen]
        axis = int(np.argmax(np.ptp(points, axis=0)))
        order = chosen[np.argsort(points[:, axis], kind="stable")]
        half = len(order) // 2
        stack += [order[half:], order[:half]]


class SceneBuffers:
    """A static scene, cut into chunks that are culled and drawn nearest first."""

    def __init__(self, context: Any, scene: Scene, plain: Any, textured: Any) -> None:
        """Uploads a scene.

        Args:
            context: `moderngl.Context`.
            scene: What to upload.
            plain: Program for surfaces without a texture.
            textured: Program for surfaces with one.
        """
        self._textures = [_upload_texture(context, surface) for surface in scene.surfaces]
        vertices, faces, chunks = _chunk_surfaces(scene)
        self._ranges = [(chunk.surface, chunk.first, chunk.count) for chunk in chunks]
        self._low, self._high = (np.array([chunk.box[i] for chunk in chunks]) for i in (0, 1))
        self._solid_low, self._solid_high = (
            np.array([chunk.solid_box[i] for chunk in chunks]) for i in (0, 1)
        )
        self._vertices = context.buffer(vertices.tobytes())
        self._faces = context.buffer(faces.tobytes())
        self._context = context
        self.serial = next(_serials)
        """Tells this upload from every other one of this process."""
        color_only = [(self._vertices, "3f4 4f1 8x", "position", "color")]
        with_uv = [(self._vertices, "3f4 4f1 2f4", "position", "color", "uv")]
        self._plain = context.vertex_array(plain, color_only, index_buffer=self._faces)
        self._textured = context.vertex_array(textured, with_uv, index_buffer=self._faces)
        self._programs = (plain["clip_from_world"], textured["clip_from_world"])
        texels = sum(texture.width * texture.height for texture in self._textures if texture)
        # A mipmap chain is a third more; a texel takes four bytes on every driver seen.
        self.num_bytes = vertices.nbytes + faces.nbytes + texels * 16 // 3

    def draw(self, clip_from_world: FloatArray, eye: FloatArray) -> None:
        """Draws what one camera may see into the bound framebuffer."""
        matrix = clip_from_world.T.astype("<f4").tobytes()
        for uniform in self._programs:
            uniform.write(matrix)
        outside = (eye < self._solid_low - SOLID_MARGIN_M) | (
            eye > self._solid_high + SOLID_MARGIN_M
        )
        cull: list[bool] = np.any(outside, axis=1).tolist()
        bound, culling = None, False
        for chunk in visible_boxes(self._low, self._high, clip_from_world, eye).tolist():
            surface, first, count = self._ranges[chunk]
            if cull[chunk] != culling:
                culling = cull[chunk]
                (self._context.enable if culling else self._context.disable)(
                    self._context.CULL_FACE
                )
            texture = self._textures[surface]
            if texture is None:
                self._plain.render(vertices=count, first=first)
                continue
            if surface != bound:
                texture.use(0)
                bound = surface
            self._textured.render(vertices=count, first=first)
        self._context.disable(self._context.CULL_FACE)

    def release(self) -> None:
        """Frees the device memory."""
        for item in (self._plain, self._textured, self._vertices, self._faces, *self._textures):
            if item is not None:
                item.release()


def _upload_texture(context: Any, surface: Surface) -> Any:
    """A mipmapped, repeating texture, or `None` if the surface has none."""
    if surface.texture is None:
        return None
    height, width, _ = surface.texture.shape
    texture = context.texture((width, height), 3, np.ascontiguousarray(surface.texture).tobytes())
    texture.build_mipmaps()
    # The nearest mipmap, bilinear: supersampling smooths the steps, and it halves the cost.
    texture.filter = (context.LINEAR_MIPMAP_NEAREST, context.LINEAR)
    return texture


@dataclasses.dataclass(frozen=True)
class _Chunk:
    """A run of triangles of one surface."""

    surface: int
    first: int
    count: int
    """Indices, three a triangle."""
    box: FloatArray
    """Low and high corner, `(2, 3)`."""
    solid_box: FloatArray
    """Around the closed solids it is part of; endless where it is part of none."""


def _chunk_surfaces(scene: Scene) -> tuple[NDArray[Any], NDArray[np.uint32], list[_Chunk]]:
    """Vertices, indices and chunks; a chunk is all of closed solids or has nothing of them.

    Every chunk has its own run of vertices, so that drawing it reads memory in order.
    """
    vertices, faces, chunks = [], [], []
    num_vertices = num_indices = 0
    for index, surface in enumerate(scene.surfaces):
        for chosen, solid_box in _parts(surface):
            used, local = np.unique(surface.faces[chosen], return_inverse=True)
            run = np.zeros(len(used), _SCENE_VERTEX)
            run["position"], run["color"] = surface.positions[used], surface.colors[used]
            if surface.uvs is not None:
                run["uv"] = surface.uvs[used]
            vertices.append(run)
            faces.append((local.reshape(-1) + num_vertices).astype("<u4"))
            box = np.array([run["position"].min(axis=0), run["position"].max(axis=0)], np.float64)
            chunks.append(_Chunk(index, num_indices, len(faces[-1]), box, solid_box))
            num_vertices += len(run)
            num_indices += len(faces[-1])
    return np.concatenate(vertices), np.concatenate(faces), chunks


def _parts(surface: Surface) -> Iterator[tuple[NDArray[np.int64], FloatArray]]:
    """Faces of each chunk of a surface, and the box of the solids they belong to."""
    if not len(surface.faces):
        return
    positions = surface.positions.astype(np.float64)
    centroids = positions[surface.faces].mean(axis=1)
    closed, boxes = closed_solids(positions, surface.faces.astype(np.int64))
    for wanted in (True, False):
        group = np.flatnonzero(closed == wanted)
        for chosen in split_faces(centroids[group], CHUNK_TRIANGLES):
            if not len(chosen):
                continue
            box = np.array([[-np.inf] * 3, [np.inf] * 3])
            if wanted:
                around = boxes[group[chosen]]
                box = np.array([around[:, 0].min(axis=0), around[:, 1].max(axis=0)])
            yield group[chosen], box


class BodyBuffers:
    """One level of detail of a body, skinned while it is drawn."""

    def __init__(self, context: Any, mesh: AvatarMesh, program: Any) -> None:
        """Uploads `mesh` for `program`; `context` is a `moderngl.Context`."""
        vertices = np.zeros(len(mesh.positions), _BODY_VERTEX)
        vertices["position"], vertices["normal"] = mesh.positions, mesh.normals
        vertices["color"], vertices["joints"] = mesh.colors, mesh.joint_indices
        vertices["weights"] = mesh.joint_weights
        faces = mesh.faces.astype("<u4")
        self.boxes = joint_boxes(mesh)
        """Boxes around what each joint moves, `(22, 8, 3)`."""
        self._vertices = context.buffer(vertices.tobytes())
        self._faces = context.buffer(faces.tobytes())
        layout = "3f4 3f4 4f1 4u1 4f1"
        names = ("position", "normal", "color", "joints", "weights")
        self._array = context.vertex_array(
            program, [(self._vertices, layout, *names)], index_buffer=self._faces
        )
        self.num_bytes = vertices.nbytes + faces.nbytes

    def draw(self) -> None:
        """Draws the body under the pose bound to uniform block 0."""
        self._array.render()

    def release(self) -> None:
        """Frees the device memory."""
        for item in (self._array, self._vertices, self._faces):
            item.release()
