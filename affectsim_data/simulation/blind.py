"""A renderer that draws nothing, for policies that look at nothing."""

from __future__ import annotations

import numpy as np

from affectsim_data.render import ClipSpec, RenderedClip, RendererName

__all__ = ["BlindRenderer"]


class BlindRenderer:
    """Black images in which nothing is near; needs no device and takes no time."""

    name: RendererName = "egl"
    """Of what it stands in for."""

    def render(self, spec: ClipSpec, *, instances: bool = False) -> RenderedClip:
        """Black, infinitely far, and nobody there."""
        shape = (len(spec.trajectory), spec.camera.height, spec.camera.width)
        return RenderedClip(
            rgb=np.zeros((*shape, 3), np.uint8),
            depth=np.full(shape, np.inf, np.float32),
            instances=np.zeros(shape, np.uint8) if instances else None,
        )

    def close(self) -> None:
        """Nothing to free."""
