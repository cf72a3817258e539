"""Light for imported scenes, whose colours are plain albedo: generic lamps, shade in corners."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from affectsim_data.builders.lighting.baking import LightMesh, relit
from affectsim_data.builders.lighting.bounces import bounced, cast_hemispheres
from affectsim_data.builders.lighting.colors import exposed
from affectsim_data.builders.lighting.hemisphere import ball_directions
from affectsim_data.builders.lighting.points import LightPoints, light_points
from affectsim_data.builders.lighting.rays import Array32, LightRays
from affectsim_data.builders.lighting.sources import Lamp, direct_light
from affectsim_data.builders.lighting.subdividing import longest_edge, subdivided
from affectsim_data.scenes import Room, Surface

__all__ = ["light_surfaces"]

_EDGE_M = 0.5
_LAMP_SPACING_M = 3.0
_MOST_LAMPS = 24
_BELOW_CEILING_M = 0.45
_LAMP_HEIGHT_M = 2.35
"""Above the lowest floor, where no ceiling is known."""
_LEAST_OPEN_M = 0.35
"""Lamps with less around them are inside of something and go down or out."""
_AMBIENT = 0.2
"""Light on faces beside what is computed, of a face a metre below a lamp."""
_BEYOND = np.array([[0.42, 0.43, 0.45], [0.24, 0.235, 0.23]], np.float32)
"""Radiance of where no geometry is, above and below level."""
_RAYS_IN_ALL = 3_500_000
_FEWEST_RAYS, _MOST_RAYS = 6, 32
_MOST_POINTS = 500_000
"""Beyond these, vertices near each other share their light."""


def light_surfaces(
    surfaces: Sequence[Surface], *, rooms: Sequence[Room] = (),
    lamps: Sequence[Lamp] | None = None,
) -> tuple[Surface, ...]:  # fmt: skip
    """The surfaces with generic indoor light multiplied into their colours.

    Lamps hang from the ceilings of the rooms, light comes from above where there is none, faces
    shade and light each other. Both sides of a face are lit as the one that looks at a lamp.
    Edges longer than 0.5 m are cut first, as long as that does not double the triangles. Time is
    bounded: larger scenes get fewer rays. Equal input gives equal bytes.

    Args:
        surfaces: Colours are albedo; normals may be missing (0) and are made then.
        rooms: Where lamps hang; without any, the bounds of the surfaces are one room.
        lamps: Lamps of its own, if it has any.
    """
    limit = longest_edge(surfaces, _EDGE_M)
    fine = [_with_normals(subdivided(surface, limit)) for surface in surfaces]
    if not any(len(surface.faces) for surface in fine):
        return tuple(fine)
    mesh = LightMesh.of(fine)
    rays = LightRays(mesh.positions, mesh.faces)
    if lamps is None:
        lamps = _ceiling_lamps(mesh, rooms, rays)
    light, area = _light(mesh, lamps, rays)
    return relit(fine, mesh, exposed(light, area))


def _light(mesh: LightMesh, lamps: Sequence[Lamp], rays: LightRays) -> tuple[Array32, Array32]:
    """Light of vertices, `(n, 3)`, and their areas, `(n,)`."""
    points = light_points(mesh.positions, mesh.normals, mesh.faces, most=_MOST_POINTS)
    every = np.arange(len(points.positions))
    small = np.zeros(len(every), bool)
    front = direct_light(
        points.starts(every), points.normals, small, windows=(), lamps=lamps, rays=rays
    )
    dark = np.flatnonzero(front[:, 1] <= 0.0)
    points, back = _turned_to_lamps(points, dark, lamps, rays)
    direct = front
    direct[dark] = back
    count = int(np.clip(_RAYS_IN_ALL // len(every), _FEWEST_RAYS, _MOST_RAYS))
    gathering = cast_hemispheres(
        points, np.full(len(every), count), rays, np.zeros((len(mesh.faces), 3), np.float32),
        two_sided=True,
    )  # fmt: skip
    light = bounced(
        gathering, points, direct, mesh.face_albedo, mesh.faces,
        ambient=_AMBIENT, beyond=_BEYOND, bounces=2,
    )  # fmt: skip
    return light[points.of_vertex], points.area[points.of_vertex]


def _turned_to_lamps(
    points: LightPoints, dark: NDArray[np.intp], lamps: Sequence[Lamp], rays: LightRays
) -> tuple[LightPoints, Array32]:
    """Points on sheets that no lamp shines on from the front look out of the back, if one shines
    there: the light of the dark ones, `(num_dark, 3)`."""
    normals = points.normals.copy()
    normals[dark] *= -1.0
    turned = dataclasses.replace(points, normals=normals)
    back = direct_light(
        turned.starts(dark), normals[dark], np.zeros(len(dark), bool),
        windows=(), lamps=lamps, rays=rays,
    )  # fmt: skip
    neither = dark[back[:, 1] <= 0.0]
    normals[neither] *= -1.0
    return turned, back


def _ceiling_lamps(mesh: LightMesh, rooms: Sequence[Room], rays: LightRays) -> list[Lamp]:
    """A grid of lamps under the ceiling of each room, none inside of things."""
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    if rooms:
        areas = [(shapely.Polygon(room.polygon), room.floor_y, room.ceiling_y) for room in rooms]
    else:
        outline = shapely.box(float(low[0]), float(low[2]), float(high[0]), float(high[2]))
        areas = [(outline, float(low[1]), float(high[1]))]
    whole = sum(polygon.area for polygon, _, _ in areas)
    spacing = max(_LAMP_SPACING_M, math.sqrt(whole / _MOST_LAMPS))
    lamps = []
    for polygon, floor, ceiling in areas:
        top = min(ceiling - _BELOW_CEILING_M, floor + _LAMP_HEIGHT_M)
        for x, z in _spread(polygon, spacing):
            for height in (top, floor + 0.8 * (top - floor), floor + 0.6 * (top - floor)):
                place = np.array([x, height, z])
                if _open_m(place, rays) > _LEAST_OPEN_M:
                    lamps.append(Lamp(place))
                    break
    return lamps


def _spread(polygon: shapely.Polygon, spacing: float) -> list[tuple[float, float]]:
    """Points inside a polygon, about `spacing` metres apart; at least one."""
    x0, z0, x1, z1 = polygon.bounds
    columns, rows = (max(round((b - a) / spacing), 1) for a, b in ((x0, x1), (z0, z1)))
    x = x0 + (np.arange(columns) + 0.5) * (x1 - x0) / columns
    z = z0 + (np.arange(rows) + 0.5) * (z1 - z0) / rows
    grid = [(float(a), float(b)) for a in x for b in z if polygon.contains(shapely.Point(a, b))]
    inside = polygon.representative_point()
    return grid or [(float(inside.x), float(inside.y))]


def _open_m(place: NDArray[np.float64], rays: LightRays) -> float:
    """Median distance to what is around a place, metres."""
    directions = ball_directions(48)
    starts = np.broadcast_to(place.astype(np.float32), directions.shape).copy()
    return float(np.median(rays.first_hits(starts, directions)[1]))


def _with_normals(surface: Surface) -> Surface:
    """The surface with unit normals; where there is none, that of the triangles around."""
    length = np.sqrt(np.einsum("ij,ij->i", surface.normals, surface.normals))
    if np.abs(length - 1.0).max(initial=0.0) < 1e-3:
        return surface
    a, b, c = (surface.positions[surface.faces[:, k]] for k in range(3))
    cross = np.repeat(np.cross(b - a, c - a), 3, axis=0)
    corners, count = surface.faces.reshape(-1).astype(np.int64), len(surface.positions)
    made = np.stack(
        [np.bincount(corners, cross[:, k], minlength=count) for k in range(3)], axis=1
    )  # fmt: skip
    normals = np.where((length > 1e-3)[:, None], surface.normals, made)
    size = np.linalg.norm(normals, axis=1, keepdims=True)
    unit = np.where(size > 1e-12, normals / np.maximum(size, 1e-12), (0.0, 1.0, 0.0))
    return dataclasses.replace(surface, normals=unit.astype(np.float32))
