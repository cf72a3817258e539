"""Directions over the hemisphere of a normal."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.lighting.rays import Array32

__all__ = ["ball_directions", "cosine_directions", "tangents"]


def cosine_directions(count: int) -> Array32:
    """Cosine-weighted unit directions about +Z, `(count, 3)`, the same at every call; the first
    few of them are spread over the hemisphere too."""
    # Fibonacci points on the disc, lifted to the hemisphere (Malley's method).
    index = np.argsort((np.arange(count) * 0.618034) % 1.0, kind="stable") + 0.5
    radius, angle = np.sqrt(index / count), index * np.pi * (3.0 - np.sqrt(5.0))
    columns = [radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - radius**2)]
    return np.stack(columns, axis=1).astype(np.float32)


def tangents(normals: Array32) -> tuple[Array32, Array32]:
    """Two unit vectors across each normal, `(n, 3)` each (Duff et al. 2017)."""
    x, y, z = normals.T
    sign = np.where(z >= 0.0, np.float32(1.0), np.float32(-1.0))
    a = np.float32(-1.0) / (sign + z)
    b = x * y * a
    tangent = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=1)
    return tangent, np.stack([b, sign + y * y * a, -y], axis=1)


def ball_directions(count: int) -> Array32:
    """Unit directions spread evenly over the sphere, `(count, 3)`."""
    index = np.arange(count) + 0.5
    y, angle = 1.0 - 2.0 * index / count, index * np.pi * (3.0 - np.sqrt(5.0))
    radius = np.sqrt(1.0 - y**2)
    columns = [radius * np.cos(angle), y, radius * np.sin(angle)]
    return np.stack(columns, axis=1).astype(np.float32)
