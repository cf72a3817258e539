"""Hair as a shell grown around the skull: short, full, long, or tied into a bun."""

from __future__ import annotations

import dataclasses

import numpy as np

from affectsim_data.builders.bodies.faces import eye_centers
from affectsim_data.builders.bodies.figures import Figure
from affectsim_data.builders.bodies.surfaces import IntArray, Surface, merge
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["Style", "hair"]

# Azimuth from the forehead to the nape in degrees, and the elevation seen from the middle of the
# skull at which hair ends: forehead, temple, before the ear, above it, behind it, nape.
_AZIMUTHS = (0.0, 28.0, 52.0, 66.0, 80.0, 88.0, 104.0, 122.0, 145.0, 180.0)
_HAIRLINE = (38.0, 37.0, 31.0, 14.0, -6.0, 4.0, 4.0, -22.0, -36.0, -42.0)


@dataclasses.dataclass(frozen=True)
class Style:
    """How hair is worn."""

    volume_m: float
    """Thickness on top, metres."""
    side_m: float
    """Thickness at the sides, metres."""
    length_m: float
    """How far it hangs below the eyes at the sides and the back; 0 if it ends at the hairline."""
    bun: bool
    """Whether it is tied into a bun at the back."""
    bald: bool = False
    """Whether the crown is bare."""


def _skull_radii(skull: Surface, center: FloatArray, rays: FloatArray) -> FloatArray:
    """Distance from the centre to the skin along unit `rays` `(n, 3)`; `nan` where none is hit."""
    corners = skull.positions[skull.faces] - center
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    distances = np.full(len(rays), np.nan)
    q = np.cross(-corners[:, 0], edge1)
    reach = np.einsum("fi,fi->f", edge2, q)
    for index, ray in enumerate(rays):
        p = np.cross(ray, edge2)
        det = np.einsum("fi,fi->f", edge1, p)
        safe = np.where(np.abs(det) < 1e-14, np.inf, det)
        u = np.einsum("fi,fi->f", -corners[:, 0], p) / safe
        v = q @ ray / safe
        hits = (reach / safe)[
            (u >= -1e-9) & (v >= -1e-9) & (u + v <= 1 + 1e-9) & (reach / safe > 0)
        ]
        if len(hits):
            distances[index] = hits.min()
    return distances


def _skull_table(figure: Figure, center: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Azimuths `(a,)` and elevations `(e,)` in degrees, and skull radii there `(a, e)`."""
    head = figure.surface("body")
    near = head.positions[:, 1] > figure.joints["neck"][1] - 0.02
    keep = near[head.faces].all(axis=1) & (head.scalars["ears"][head.faces].max(axis=1) < 0.5)
    skull = head.with_faces(head.faces[keep])
    azimuths, elevations = np.linspace(0.0, 180.0, 31), np.linspace(-60.0, 90.0, 31)
    a, e = np.meshgrid(np.radians(azimuths), np.radians(elevations), indexing="ij")
    rays = np.stack([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)], axis=-1)
    radii = _skull_radii(skull, center, rays.reshape(-1, 3)).reshape(a.shape)
    for row in radii.T:  # Fill the ears' holes from the sides.
        known = ~np.isnan(row)
        row[~known] = np.interp(azimuths[~known], azimuths[known], row[known])
    return azimuths, elevations, radii


def _interpolate(
    table: tuple[FloatArray, FloatArray, FloatArray], azimuth: FloatArray, elevation: FloatArray
) -> FloatArray:
    """Bilinear value of a table at angles in degrees."""
    rows, columns, values = table
    i = np.interp(azimuth, rows, np.arange(len(rows)))
    j = np.interp(elevation, columns, np.arange(len(columns)))
    i0, j0 = np.minimum(i.astype(int), len(rows) - 2), np.minimum(j.astype(int), len(columns) - 2)
    s, t = i - i0, j - j0
    low = values[i0, j0] * (1 - t) + values[i0, j0 + 1] * t
    high = values[i0 + 1, j0] * (1 - t) + values[i0 + 1, j0 + 1] * t
    mixed: FloatArray = low * (1 - s) + high * s
    return mixed


def _grid_faces(num_rows: int, num_columns: int) -> IntArray:
    """Triangles of a grid closed around its columns, first row at the top, seen from outside."""
    row, column = np.meshgrid(np.arange(num_rows - 1), np.arange(num_columns), indexing="ij")
    right = (column + 1) % num_columns
    a, b = row * num_columns + column, row * num_columns + right
    c, d = a + num_columns, b + num_columns
    quads = np.stack([a, c, d, b], axis=-1).reshape(-1, 4)
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]).astype(np.int64)


def _weights(figure: Figure, points: FloatArray) -> FloatArray:
    """All on the head; what hangs below it follows the neck and the chest more and more."""
    head, neck = figure.joints["head"][1], figure.joints["neck"][1]
    weights = np.zeros((len(points), len(JOINT_NAMES)))
    down = np.interp(points[:, 1], [neck - 0.08, head - 0.03], [1.0, 0.0])
    weights[:, JOINT_NAMES.index("head")] = 1.0 - 0.75 * down
    weights[:, JOINT_NAMES.index("neck")] = 0.5 * down
    weights[:, JOINT_NAMES.index("spine3")] = 0.25 * down
    return weights


def _bun(figure: Figure, center: FloatArray, size: int) -> Surface:
    rows, columns = max(size // 4, 5), max(size // 2, 8)
    e, a = np.meshgrid(
        np.linspace(np.pi / 2, -np.pi / 2, rows),
        np.linspace(0.0, 2.0 * np.pi, columns, endpoint=False),
        indexing="ij",
    )
    ball = np.stack([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)], axis=-1)
    ripple = 1.0 + 0.035 * np.sin(5.0 * a + 4.0 * e)
    points = ball.reshape(-1, 3) * [0.043, 0.038, 0.036] * ripple.reshape(-1, 1)
    points = points + center + [0.0, 0.062, -0.104]
    shade = 0.5 + 0.5 * np.sin(7.0 * a + 5.0 * e).ravel()
    scalars = {"shade": shade, "bare": np.zeros_like(shade)}
    return Surface(points, _grid_faces(rows, columns), _weights(figure, points), scalars)


def hair(figure: Figure, style: Style, *, size: int) -> Surface:
    """The hair with scalars in [0, 1]: `shade` tells strands apart, `bare` is skin, not hair.

    Args:
        figure: The body it grows on.
        style: How it is worn.
        size: Number of columns around the head.
    """
    eyes = np.mean(list(eye_centers(figure).values()), axis=0)
    center = np.array([0.0, eyes[1] + 0.012, figure.joints["head"][2] + 0.008])
    turn = np.linspace(-180.0, 180.0, size, endpoint=False)
    table = _skull_table(figure, center)
    side = np.abs(turn)
    end = np.interp(side, _AZIMUTHS, _HAIRLINE)
    end += 1.6 * np.sin(np.radians(turn * 7.0)) * np.interp(side, [0, 40, 60], [1.0, 1.0, 0.0])
    hangs = np.interp(side, [62.0, 74.0], [0.0, 1.0]) * (style.length_m > 0.0)
    end = end * (1.0 - hangs) - 8.0 * hangs
    rows = max(size // 3, 6)
    share = np.linspace(0.0, 1.0, rows)[:, None]
    elevation = 90.0 - (90.0 - end) * share
    across = np.broadcast_to(side, elevation.shape)
    radius = _interpolate(table, across, elevation)
    top = np.interp(elevation, [0.0, 70.0], [0.0, 1.0])
    thick = style.side_m * (1.0 - top) + style.volume_m * top
    # Short hair thins out towards its line; hair that hangs stays thick and covers the ears.
    thick *= np.maximum(np.sqrt(1.0 - 0.92 * share**3), hangs)
    thick += hangs * 0.012 * np.interp(elevation, [-8.0, 30.0], [1.0, 0.0])
    front = np.interp(side, [40.0, 70.0], [0.0, 1.0])
    crown = np.interp(elevation, [14.0, 24.0], [0.0, 1.0])
    bare = np.maximum(crown, (1.0 - front)) * style.bald
    thick = thick * (1.0 - bare) + 0.0015 * bare
    strand = np.sin(np.radians(turn * 17.0)) + np.sin(np.radians(turn * 29.0 + 40.0))
    fade = np.interp(elevation, [40.0, 88.0], [1.0, 0.0])
    thick += 0.0011 * strand * fade * (1.0 - bare)
    # A coarse polygon cuts corners: widen it until its sides clear the skull.
    wide = 1.0 / np.cos(np.pi / size)
    paths = _around(center, turn, elevation, (radius + thick) * wide)
    bares = [bare]
    shades = [np.broadcast_to(0.5 + 0.25 * strand, elevation.shape) * fade + 0.5 * (1.0 - fade)]
    layers = [paths]
    if style.length_m > 0.0:
        layers.append(_hanging(paths[-1], eyes[1], hangs, style.length_m, strand, rows // 2))
        shades.append(np.broadcast_to(shades[0][-1], (rows // 2, size)))
        bares.append(np.zeros((rows // 2, size)))
    tip = layers[-1][-1]
    inward = np.stack([np.sin(np.radians(turn)), np.zeros(size), np.cos(np.radians(turn))], axis=1)
    under = tip - inward * (0.006 + 0.010 * hangs)[:, None]
    layers.append(under[None])
    root = _around(center, turn, end[None], _interpolate(table, side[None], end[None]) - 0.004)
    layers.append(root)
    shades += [np.zeros((1, size)), np.zeros((1, size))]
    bares += [bare[-1:], bare[-1:]]
    points = np.concatenate(layers).reshape(-1, 3)
    shade = np.concatenate(shades).reshape(-1)
    count = sum(len(layer) for layer in layers)
    scalars = {"shade": shade, "bare": np.concatenate(bares).reshape(-1)}
    faces = _grid_faces(count, size)
    faces = faces[scalars["bare"][faces].min(axis=1) < 1.0]
    cap = Surface(points, faces, _weights(figure, points), scalars).with_faces(faces)
    return merge([cap, _bun(figure, center, size)]) if style.bun else cap


def _around(
    center: FloatArray, turn: FloatArray, elevation: FloatArray, radius: FloatArray
) -> FloatArray:
    """Points `(rows, columns, 3)` at angles in degrees and distances from the centre."""
    a, e = np.radians(np.broadcast_to(turn, elevation.shape)), np.radians(elevation)
    unit = np.stack([np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e)], axis=-1)
    placed: FloatArray = center + unit * radius[..., None]
    return placed


def _hanging(
    edge: FloatArray,
    eye_height: float,
    hangs: FloatArray,
    length_m: float,
    strand: FloatArray,
    rows: int,
) -> FloatArray:
    """Rows of points below the ring `edge` `(columns, 3)`, straight down and slightly inwards."""
    share = np.linspace(0.0, 1.0, rows + 1)[1:, None]
    bottom = np.minimum(eye_height - length_m + 0.004 * strand, edge[:, 1])
    drop = (edge[:, 1] - bottom) * hangs
    points = np.repeat(edge[None], rows, axis=0)
    points[..., 1] -= drop * share
    # Fuller at the jaw, drawn in again at the tips and away from the face.
    belly = 1.0 + 0.06 * np.sin(np.pi * share) * hangs - 0.10 * share**2 * hangs
    points[..., 0] *= belly
    points[..., 2] -= 0.012 * share * hangs
    return points
