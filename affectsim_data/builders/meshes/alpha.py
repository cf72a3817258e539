"""What becomes of cut-outs and glass: the renderer draws opaque triangles only."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.meshes.asset import Notes
from affectsim_data.builders.meshes.images import Pixels
from affectsim_data.builders.meshes.looks import Look
from affectsim_data.poses import FloatArray

__all__ = ["cleared"]

_CLEAR = 0.05
"""Opacity below which glass is left out."""
_PALE = np.array([0.82, 0.87, 0.88])
"""Glass shows the room behind it; drawn opaque, it takes this pale tint for that share."""
_SAMPLES = np.array(
    [[i, j, 6 - i - j] for i in range(7) for j in range(7 - i)], np.float64
) / 6.0  # fmt: skip
"""Barycentric places at which a triangle's cut-out is looked at."""
_MOST_SAMPLED = 200_000
"""Triangles sampled at once, to bound memory."""


def cleared(
    look: Look,
    faces: NDArray[np.int64],
    colors: FloatArray,
    uvs: FloatArray | None,
    *,
    notes: Notes,
) -> tuple[NDArray[np.int64], FloatArray, Pixels | None]:
    """Triangles, opaque vertex colours `(num_vertices, 4)` and RGB texture of what is drawn.

    Cut-outs lose the triangles that show nothing, and the holes in the others are filled with the
    texture's own mean colour. Glass becomes opaque and pale, or is left out if all but clear.
    """
    texture = look.texture
    opaque = np.concatenate([colors[:, :3], np.ones((len(colors), 1))], axis=1)
    alpha = texture[..., 3] if texture is not None and texture.shape[-1] == 4 else None
    picture = None if texture is None else np.ascontiguousarray(texture[..., :3])
    if look.alpha_mode == "OPAQUE":
        return faces, opaque, picture
    if look.alpha_mode == "MASK":
        if alpha is not None and uvs is not None and picture is not None:
            there = alpha >= look.alpha_cutoff * 255.0
            kept = _shown(faces, uvs, there)
            notes["masked triangles that show nothing dropped"] += int((~kept).sum())
            notes["parts with cut-outs drawn whole"] += int(not there.all())
            return faces[kept], opaque, _filled(picture, there)
        return faces[(colors[faces, 3] >= look.alpha_cutoff).any(axis=1)], opaque, picture
    return _glass(faces, colors, picture, alpha, notes)


def _glass(
    faces: NDArray[np.int64],
    colors: FloatArray,
    picture: Pixels | None,
    alpha: NDArray[np.uint8] | None,
    notes: Notes,
) -> tuple[NDArray[np.int64], FloatArray, Pixels | None]:
    opacity = colors[:, 3:]
    shares = opacity[faces].mean(axis=(1, 2)) * (1.0 if alpha is None else alpha.mean() / 255.0)
    kept = shares >= _CLEAR
    notes["clear triangles dropped"] += int((~kept).sum())
    if not kept.any():
        return faces[kept], colors, None
    if alpha is not None and picture is not None:
        share = alpha[..., None] / 255.0
        mixed = picture * share + 255.0 * _PALE * (1.0 - share)
        picture = np.round(mixed).astype(np.uint8)
    if float(shares[kept].min()) < 0.99:
        notes["see-through parts drawn opaque"] += 1
    tinted = colors[:, :3] * opacity + _PALE * (1.0 - opacity)
    return faces[kept], np.concatenate([tinted, np.ones_like(opacity)], axis=1), picture


def _shown(
    faces: NDArray[np.int64], uvs: FloatArray, there: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Whether any of a triangle's sampled texels is there, `(num_faces,)`."""
    height, width = there.shape
    shown = np.zeros(len(faces), bool)
    for start in range(0, len(faces), _MOST_SAMPLED):
        corners = uvs[faces[start : start + _MOST_SAMPLED]]
        places = np.einsum("sk,fkc->fsc", _SAMPLES, corners)
        places -= np.floor(places)
        columns = np.minimum((places[..., 0] * width).astype(np.int64), width - 1)
        rows = np.minimum((places[..., 1] * height).astype(np.int64), height - 1)
        shown[start : start + _MOST_SAMPLED] = there[rows, columns].any(axis=1)
    return shown


def _filled(picture: Pixels, there: NDArray[Any]) -> Pixels:
    """The picture with its holes in the mean colour of what is there."""
    if there.all() or not there.any():
        return picture
    filled = picture.copy()
    filled[~there] = np.round(picture[there].mean(axis=0)).astype(np.uint8)
    return filled
