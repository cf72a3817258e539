"""The light on people, once in NumPy; the shader `BODY` computes the same from these constants."""

from __future__ import annotations

import numpy as np

from affectsim_data.poses import UP, FloatArray

__all__ = ["AMBIENT_HIGH", "AMBIENT_LOW", "GAMMA", "KEY", "KEY_STRENGTH", "KEY_WRAP", "OUTLINE"]

AMBIENT_LOW, AMBIENT_HIGH = 0.36, 0.64
"""Linear light on a surface that faces down, and up."""
KEY = np.array([0.35, 0.80, 0.49]) / np.linalg.norm([0.35, 0.80, 0.49])
"""Where the key light comes from, in the world: every camera sees the same light."""
KEY_STRENGTH, KEY_WRAP = 0.52, 0.35
"""Its light where it falls straight on, and how far it reaches around."""
OUTLINE = 0.78
"""What is left of the light where a surface is seen edge on: the form reads from any side."""
GAMMA = 2.2


def light_on(normals: FloatArray, from_eye: FloatArray) -> FloatArray:
    """Factors `(n,)` on sRGB colours for unit normals `(n, 3)` seen along `from_eye` `(n, 3)`."""
    sky = AMBIENT_LOW + (AMBIENT_HIGH - AMBIENT_LOW) * (0.5 + 0.5 * normals @ UP)
    key = KEY_STRENGTH * np.maximum(0.0, (normals @ KEY + KEY_WRAP) / (1.0 + KEY_WRAP))
    ray = from_eye / np.linalg.norm(from_eye, axis=1, keepdims=True)
    facing = OUTLINE + (1.0 - OUTLINE) * np.abs(np.einsum("ij,ij->i", normals, ray))
    factor: FloatArray = ((sky + key) * facing) ** (1.0 / GAMMA)
    return factor
