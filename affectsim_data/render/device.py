"""What draws here, for `affectsim doctor` and for every published number."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.render.egl import EglContext, default_device, egl_devices
from affectsim_data.render.processes import survive_forks

__all__ = ["DeviceInfo", "describe_device", "draw_triangle"]

_VERTEX = """
#version 330
void main() {
    vec2 corner = vec2(gl_VertexID == 1 ? 0.9 : gl_VertexID == 2 ? 0.0 : -0.9,
                       gl_VertexID == 2 ? -0.9 : 0.9);
    gl_Position = vec4(corner, 0.0, 1.0);
}
"""
_FRAGMENT = """
#version 330
out vec4 pixel;
void main() { pixel = vec4(0.9, 0.5, 0.1, 1.0); }
"""


@dataclasses.dataclass(frozen=True)
class DeviceInfo:
    """The device that renders, as its driver describes it."""

    renderer: str
    """`GL_RENDERER`: the GPU, or `llvmpipe ...` for software."""
    vendor: str
    """`GL_VENDOR`."""
    version: str
    """`GL_VERSION`, with that of the driver."""
    egl_vendor: str
    """Who made the EGL driver."""
    egl_version: str
    """EGL version of the device."""
    device: int
    """Index of the device, the value of `AFFECTSIM_EGL_DEVICE`."""
    num_devices: int
    """How many devices EGL lists; not all need open."""
    max_texture_size: int
    """Pixels along one side of an image."""
    software: bool
    """Whether Mesa draws on the CPU: any machine will do, and forks are survived."""


def describe_device(device: int | None = None) -> DeviceInfo:
    """The device a renderer would open now; opens and closes a context of its own.

    Args:
        device: Index; `None` for `AFFECTSIM_EGL_DEVICE`, else one of several GPUs by `LOCAL_RANK`,
            else the first that opens.

    Raises:
        RendererUnavailableError: No device opens; the message says what to install.
    """
    egl, context = _open(device)
    try:
        info = context.info
        return DeviceInfo(
            renderer=str(info["GL_RENDERER"]),
            vendor=str(info["GL_VENDOR"]),
            version=str(info["GL_VERSION"]),
            egl_vendor=egl.vendor,
            egl_version=egl.version,
            device=egl.device.index,
            num_devices=len(egl_devices()),
            max_texture_size=int(info["GL_MAX_TEXTURE_SIZE"]),
            software=egl.device.software,
        )
    finally:
        context.release()
        egl.release()


def draw_triangle(device: int | None = None) -> NDArray[np.uint8]:
    """An orange triangle, point up, on dark blue, `(64, 64, 3)`: proof that drawing works.

    Raises:
        RendererUnavailableError: No device opens; the message says what to install.
    """
    egl, context = _open(device)
    try:
        target = context.framebuffer([context.texture((64, 64), 4)])
        program = context.program(vertex_shader=_VERTEX, fragment_shader=_FRAGMENT)
        target.use()
        target.clear(0.05, 0.08, 0.20, 1.0)
        context.vertex_array(program, []).render(context.TRIANGLES, vertices=3)
        pixels: NDArray[np.uint8] = np.frombuffer(target.read(), np.uint8).reshape(64, 64, 3)
        return pixels.copy()
    finally:
        context.release()
        egl.release()


def _open(device: int | None) -> tuple[EglContext, Any]:
    survive_forks()
    egl = EglContext(default_device() if device is None else device)
    return egl, egl.wrap()
