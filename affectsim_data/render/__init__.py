"""Rendering: the only place that opens EGL. Importing it opens nothing and loads no OpenGL."""

from __future__ import annotations

from affectsim_data.render.backgrounds import MAX_BYTES
from affectsim_data.render.protocol import (
    ClipSpec,
    PosedAvatar,
    RenderedClip,
    Renderer,
    RendererName,
)

__all__ = [
    "ClipSpec",
    "PosedAvatar",
    "RenderedClip",
    "Renderer",
    "RendererName",
    "open_renderer",
    "process_renderer",
]

DEFAULT_CACHE_BYTES = 512 * 2**20
"""Some thirty furnished flats."""

_process_renderers: dict[tuple[RendererName, int | None], Renderer] = {}


def open_renderer(
    name: RendererName = "egl",
    *,
    device: int | None = None,
    cache_bytes: int = DEFAULT_CACHE_BYTES,
    background_bytes: int = MAX_BYTES,
) -> Renderer:
    """A renderer of its own; its OpenGL context opens with the first clip.

    Args:
        name: `egl`, or `pyrender`, the slow reference.
        device: EGL device index; `None` for `AFFECTSIM_EGL_DEVICE`, else one of several GPUs by
            `LOCAL_RANK`, else the first that opens.
        cache_bytes: Bound on what scenes and bodies take on the device; `egl` only.
        background_bytes: Bound on what is kept of scenes without people from still cameras; `egl`
            only.

    Raises:
        ValueError: No such renderer.
    """
    if name == "egl":
        from affectsim_data.render.rasterizer import EglRenderer

        return EglRenderer(device, cache_bytes=cache_bytes, max_background_bytes=background_bytes)
    if name == "pyrender":
        from affectsim_data.render.reference import PyrenderRenderer

        return PyrenderRenderer(device)
    raise ValueError(f"renderer must be 'egl' or 'pyrender', got {name!r}")


def process_renderer(name: RendererName = "egl", device: int | None = None) -> Renderer:
    """The one renderer of this kind in this process; opened by its first clip.

    Data sets share it, so that a scene is uploaded once. It belongs to the thread that draws first.
    """
    key = (name, device)
    if key not in _process_renderers:
        _process_renderers[key] = open_renderer(name, device=device)
    return _process_renderers[key]
