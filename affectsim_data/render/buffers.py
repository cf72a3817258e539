"""Scenes and bodies in device memory."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import AvatarMesh
from affectsim_data.poses import FloatArray
from affectsim_data.render.framing import joint_boxes, visible_boxes
from affectsim_data.render.portals import Portals
from affectsim_data.scenes import Chunks, Scene, Surface
from affectsim_data.scenes.chunks import chunk_surfaces

__all__ = ["BodyBuffers", "SceneBuffers"]

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
        surfaces, chunks = scene.surfaces, scene.chunks
        if chunks is None:
            surfaces, chunks = chunk_surfaces(surfaces, scene.rooms)
        self._textures = [_upload_texture(context, surface) for surface in surfaces]
        vertices, faces, self._ranges = _merged(surfaces, chunks)
        self.portals = Portals(scene)
        """Which rooms can be seen from where."""
        self._room = chunks.room
        self._low, self._high = chunks.low, chunks.high
        self._solid_low, self._solid_high = chunks.solid_low, chunks.solid_high
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

    def draw(
        self, clip_from_world: FloatArray, eye: FloatArray, windows: FloatArray | None
    ) -> None:
        """Draws what one camera may see into the bound framebuffer.

        Args:
            clip_from_world: Clip matrix.
            eye: Where the camera is.
            windows: Where in the image each room can be seen, see `Portals.windows`.
        """
        matrix = clip_from_world.T.astype("<f4").tobytes()
        for uniform in self._programs:
            uniform.write(matrix)
        outside = (eye < self._solid_low - SOLID_MARGIN_M) | (
            eye > self._solid_high + SOLID_MARGIN_M
        )
        cull: list[bool] = np.any(outside, axis=1).tolist()
        bound, culling = None, False
        boxes = None if windows is None else windows[self._room]
        for chunk in visible_boxes(self._low, self._high, clip_from_world, eye, boxes).tolist():
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


def _merged(
    surfaces: Sequence[Surface], chunks: Chunks
) -> tuple[NDArray[Any], NDArray[np.uint32], list[tuple[int, int, int]]]:
    """All vertices, all indices, and per chunk its surface, first index and number of indices."""
    vertices, faces = [], []
    face_starts, num_vertices, num_faces = [], 0, 0
    for surface in surfaces:
        run = np.zeros(len(surface.positions), _SCENE_VERTEX)
        run["position"], run["color"] = surface.positions, surface.colors
        if surface.uvs is not None:
            run["uv"] = surface.uvs
        vertices.append(run)
        faces.append(surface.faces + np.uint32(num_vertices))
        face_starts.append(num_faces)
        num_vertices += len(run)
        num_faces += len(surface.faces)
    first = 3 * (np.array(face_starts)[chunks.surface] + chunks.first)
    columns = (chunks.surface.tolist(), first.tolist(), (3 * chunks.count).tolist())
    return np.concatenate(vertices), np.concatenate(faces), list(zip(*columns, strict=True))


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
