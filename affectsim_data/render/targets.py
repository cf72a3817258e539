"""Framebuffers of one image size: supersampled tiles to draw on, and the strip read back."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.render.framing import BACKGROUND, FAR_M, NEAR_M

__all__ = [
    "Rectangle",
    "Targets",
    "release_framebuffer",
    "resolve_constants",
    "sample_scale",
]

MAX_STRIP_BYTES = 48 * 2**20
MAX_TILE_BYTES, MAX_TILES = 40 * 2**20, 16
"""Bounds on all tiles together; there is at least one."""
_BYTES_PER_PIXEL = 8
_READ, _DRAW = 0x8CA8, 0x8CA9
_COLOR_AND_DEPTH, _NEAREST = 0x4100, 0x2600

Rectangle = tuple[int, int, int, int]
"""Pixels u0, v0, u1, v1, half open."""


def _num_samples(size: tuple[int, int]) -> tuple[int, int]:
    """Samples across and down: every half pixel, both borders included."""
    return 2 * size[0] + 1, 2 * size[1] + 1


def sample_scale(camera: Camera) -> FloatArray:
    """Factors on clip x and y that bring sample 2 i + 1 to the centre of pixel i, `(2,)`."""
    size = np.array([camera.width, camera.height], np.float64)
    return 2.0 * size / (2.0 * size + 1.0)


class Targets:
    """What clips of one image size are drawn on.

    Antialiasing is supersampling at every half pixel, the same for every condition: a still camera
    that looked smoother than a moving one would be a cue. On a CPU, where bodies are of tiny
    triangles, it costs less than half of 4x multisampling, it smooths textures and shading as well
    as edges, and depth and ids are taken at the very centre of a pixel, where a ray would go.

    Every frame is drawn at the same place, a tile, and resolved from there to its place in a
    vertical strip. (Drawn at its place in an atlas, a frame would be snapped to the sub-pixel
    grid by numbers of another magnitude, and its pixels would depend on its neighbours.)

    There are several tiles, because to read a tile is to wait until it is drawn: frames are drawn
    a group at a time, one on each tile, before the first of them is resolved. A software device
    then works on the vertices of one frame while its threads fill the pixels of those before.
    """

    def __init__(self, context: Any, load: Any, resolve: Any, camera: Camera) -> None:
        """Allocates the tiles.

        Args:
            context: `moderngl.Context`.
            load: Name of an OpenGL function to its address.
            resolve: Program that resolves samples.
            camera: Image size.
        """
        self.size = (camera.width, camera.height)
        self._max_height = int(context.info["GL_MAX_TEXTURE_SIZE"])
        if max(_num_samples(self.size)) > self._max_height:
            raise ValueError(
                f"an image of {camera.width} x {camera.height} is too large for this device, which "
                f"draws up to {(self._max_height - 1) // 2} pixels a side"
            )
        self._context = context
        samples = math.prod(_num_samples(self.size))
        num_tiles = min(MAX_TILES, MAX_TILE_BYTES // (_BYTES_PER_PIXEL * samples))
        self._tiles = [_tile(context, self.size) for _ in range(max(num_tiles, 1))]
        self._resolve = resolve
        self._triangle = context.vertex_array(resolve, [])
        self._strip: Any = None
        unsigned, integer = ctypes.c_uint, ctypes.c_int
        self._bind = ctypes.CFUNCTYPE(None, unsigned, unsigned)(load("glBindFramebuffer"))
        self._blit = ctypes.CFUNCTYPE(None, *[integer] * 8, unsigned, unsigned)(
            load("glBlitFramebuffer")
        )

    def frames_per_strip(self, width: int, height: int) -> int:
        """How many frames of this size are read back at once."""
        by_memory = MAX_STRIP_BYTES // (width * height * _BYTES_PER_PIXEL)
        return max(1, min(by_memory, self._max_height // height))

    def groups(self, frames: Sequence[int]) -> Iterator[list[tuple[Any, int]]]:
        """Frames in groups, each frame with a tile of its own."""
        for start in range(0, len(frames), len(self._tiles)):
            yield list(zip(self._tiles, frames[start:], strict=False))

    def begin(self, tile: Any) -> None:
        """Binds a tile and clears it: background colour, instance 0, nothing hit."""
        tile.use()
        red, green, blue = (value / 255.0 for value in BACKGROUND)
        tile.clear(red, green, blue, 0.0, depth=1.0)

    def new_tile(self) -> Any:
        """A framebuffer for one frame's samples; freed by `release_framebuffer`."""
        return _tile(self._context, self.size)

    def restore(self, background: Any, tile: Any, rectangle: Rectangle) -> None:
        """Copies a rectangle of a background, sample by sample, to a tile."""
        self._bind(_READ, background.glo)
        self._bind(_DRAW, tile.glo)
        u0, v0, u1, v1 = rectangle
        corners = (2 * u0, 2 * v0, 2 * u1 + 1, 2 * v1 + 1)
        self._blit(*corners, *corners, _COLOR_AND_DEPTH, _NEAREST)

    def resolve(self, tile: Any, rectangle: Rectangle, *, row: int) -> None:
        """Resolves a rectangle of a tile into the strip, from `row` on."""
        u0, v0, u1, v1 = rectangle
        self._strip.use()
        self._strip.viewport = (0, row, u1 - u0, v1 - v0)
        tile.color_attachments[0].use(0)
        tile.depth_attachment.use(1)
        self._resolve["offset"].value = (u0, v0 - row)
        self._context.disable(self._context.DEPTH_TEST)
        self._triangle.render(self._context.TRIANGLES, vertices=3)
        self._context.enable(self._context.DEPTH_TEST)

    def open_strip(self, width: int, height: int) -> None:
        """Makes sure the strip has at least this size."""
        if self._strip is not None:
            if self._strip.width >= width and self._strip.height >= height:
                return
            width, height = max(width, self._strip.width), max(height, self._strip.height)
            if width * height * _BYTES_PER_PIXEL > 2 * MAX_STRIP_BYTES:
                raise AssertionError("strips are bounded by frames_per_strip")
            release_framebuffer(self._strip)
        color = self._context.texture((width, height), 4)
        depth = self._context.texture((width, height), 1, dtype="f4")
        self._strip = self._context.framebuffer([color, depth])

    def read(
        self, rgb: NDArray[np.uint8], depth: NDArray[np.float32], ids: NDArray[np.uint8] | None
    ) -> None:
        """Reads the strip's first rows into arrays `(num_frames, height, width, ...)`."""
        num_frames, height, width = depth.shape
        viewport = (0, 0, width, num_frames * height)
        strip = self._strip
        strip.read_into(depth, viewport, components=1, attachment=1, dtype="f4")
        strip.read_into(rgb, viewport, components=3)
        if ids is not None:
            # Twice, because a driver takes three channels out of four faster than NumPy does.
            rgba = np.empty((num_frames, height, width, 4), np.uint8)
            strip.read_into(rgba, viewport, components=4)
            ids[...] = rgba[..., 3]

    def release(self) -> None:
        """Frees the device memory."""
        self._triangle.release()
        for framebuffer in (*self._tiles, self._strip):
            if framebuffer is not None:
                release_framebuffer(framebuffer)


def _tile(context: Any, size: tuple[int, int]) -> Any:
    samples = _num_samples(size)
    # Fetched sample by sample, never filtered or compared.
    depth = context.depth_texture(samples)
    depth.compare_func, depth.filter = "", (context.NEAREST, context.NEAREST)
    return context.framebuffer([context.texture(samples, 4)], depth)


def release_framebuffer(framebuffer: Any) -> None:
    """Frees a framebuffer and its attachments."""
    attachments = [*framebuffer.color_attachments, framebuffer.depth_attachment]
    framebuffer.release()
    for attachment in attachments:
        if attachment is not None:
            attachment.release()


def resolve_constants(program: Any) -> None:
    """Sets what never changes in the resolving program."""
    program["color_samples"], program["depth_samples"] = 0, 1
    program["near_far"] = (NEAR_M, FAR_M)
