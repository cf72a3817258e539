"""A scene's triangles to the islands of its navmesh."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.navmesh.islands import Island, islands_from_cells
from affectsim_data.navmesh.rasterize import Grid, IntArray, rasterize, unit_normals
from affectsim_data.navmesh.settings import Settings
from affectsim_data.navmesh.walkable import Agent, Cells, walkable_cells
from affectsim_data.poses import FloatArray

__all__ = ["build_islands"]

# Smaller islands, such as table tops, are dropped; Recast's default.
MIN_ISLAND_AREA_M2 = 1.0


def build_islands(vertices: ArrayLike, faces: ArrayLike, settings: Settings) -> tuple[Island, ...]:
    """Islands of a mesh, largest first.

    Args:
        vertices: Metres, Y up, `(n, 3)`.
        faces: Triangles, counter-clockwise from outside, `(m, 3)`.
        settings: The agent and the grid.

    Raises:
        ValueError: A malformed mesh, no walkable surface, or storeys that overlap and are joined
            by a walkable way.
    """
    points, triangles = _checked_mesh(vertices, faces)
    cell_size, cell_height = settings.cell_size, settings.cell_height
    grid = Grid.around(points, cell_size=cell_size, cell_height=cell_height)
    agent = Agent(
        radius=_ceil(settings.agent_radius / cell_size),
        height=_ceil(settings.agent_height / cell_height),
        climb=-_ceil(-settings.max_climb / cell_height),
    )
    min_normal_y = math.cos(math.radians(settings.max_slope_deg))
    upward = unit_normals(points, triangles)[:, 1]
    if not np.any(upward > min_normal_y):
        raise ValueError(_no_floor(settings, upward))
    spans = rasterize(points, triangles, grid, max_climb=agent.climb, min_normal_y=min_normal_y)
    min_cells = _ceil(MIN_ISLAND_AREA_M2 / cell_size**2)
    cells = walkable_cells(spans, grid, agent, min_island_cells=min_cells)
    if not len(cells.x):
        raise ValueError(_no_floor(settings, upward))
    _refuse_overlap(cells, grid)
    return islands_from_cells(cells.x, cells.z, cells.y, cells.island, grid)


def _ceil(value: float) -> int:
    """Rounded up, unless a hair above a whole number because of how floats divide."""
    return math.ceil(value - 1e-6)


def _checked_mesh(vertices: ArrayLike, faces: ArrayLike) -> tuple[FloatArray, IntArray]:
    points = np.asarray(vertices, np.float64)
    triangles = np.asarray(faces)
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"vertices must be (n, 3), got {points.shape}")
    broken = np.flatnonzero(~np.all(np.isfinite(points), axis=1))
    if len(broken):
        raise ValueError(
            f"vertices must be finite: {len(broken)} of {len(points)} are not, the first is number "
            f"{broken[0]}, {points[broken[0]]}; drop the faces that use them"
        )
    if triangles.ndim != 2 or triangles.shape[1] != 3 or triangles.dtype.kind not in "iu":
        raise ValueError(
            f"faces must be whole numbers, (m, 3), got {triangles.dtype} {triangles.shape}"
        )
    if not len(triangles):
        raise ValueError("a mesh without triangles has no walkable surface")
    low, high = int(triangles.min()), int(triangles.max())
    if low < 0 or high >= len(points):
        raise ValueError(f"faces name vertices {low} to {high}, but there are {len(points)}")
    return points, triangles.astype(np.int64)


def _no_floor(settings: Settings, upward: FloatArray) -> str:
    least = math.cos(math.radians(settings.max_slope_deg))
    up, down = np.count_nonzero(upward > least), np.count_nonzero(upward < -least)
    message = (
        f"no walkable surface: looked for at least {MIN_ISLAND_AREA_M2:g} m2 of floor, no steeper "
        f"than {settings.max_slope_deg:g} degrees, with {settings.agent_height:g} m of free height "
        f"and {settings.agent_radius:g} m away from walls; {up} of {len(upward)} triangles "
        "face up flat enough (faces must be counter-clockwise from outside, Y up, metres)"
    )
    if down > up:
        message += f"; {down} face down: if these are the floor, reverse the corners of all faces"
    return message


def _refuse_overlap(cells: Cells, grid: Grid) -> None:
    key = (cells.island * grid.depth + cells.z) * grid.width + cells.x
    order = np.argsort(key, kind="stable")
    twice = order[1:][key[order][1:] == key[order][:-1]]
    if len(twice):
        x, _, z = grid.origin + grid.cell_size * np.array([cells.x[twice[0]], 0, cells.z[twice[0]]])
        raise ValueError(
            f"storeys that are joined by a walkable way overlap near x {x:.2f}, z {z:.2f}; "
            "split the mesh by height and build one navmesh per storey"
        )
