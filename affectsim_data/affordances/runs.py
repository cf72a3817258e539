"""Runs: lines and arcs of a given length that can be walked without meeting anything."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import shapely
from numpy.typing import ArrayLike

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray

__all__ = ["Runs", "curved_runs", "straight_runs"]

# Arcs are followed in steps of at most this length: off by 0.4 mm at a radius of 3 m.
STEP_M = 0.1


@dataclasses.dataclass(frozen=True, eq=False)
class Runs:
    """Ways of equal length, the widest first; arrays over `n` runs."""

    start: FloatArray
    """On the floor, metres, `(n, 3)`."""
    heading: FloatArray
    """Which way one walks off, radians counter-clockwise from above, 0 along +Z, `(n,)`."""
    curvature: FloatArray
    """Change of heading per metre, positive to the left, `(n,)`; 0 for straight runs."""
    end: FloatArray
    """Where it ends, on the floor, `(n, 3)`."""
    free_width_m: FloatArray
    """Of the narrowest place on the way, wall to wall, as the agent's radius sees it, `(n,)`."""

    def __len__(self) -> int:
        return len(self.start)


def straight_runs(
    navmesh: NavMesh,
    length_m: float,
    *,
    rng: np.random.Generator,
    num_tries: int = 512,
    within: ArrayLike | None = None,
) -> Runs:
    """Straight runs among random starts and headings on the largest island.

    Args:
        navmesh: Of the scene.
        length_m: Of a run.
        rng: Draws starts and headings.
        num_tries: How many are drawn; those that are free come back.
        within: Corners `(x, z)` of a room that holds all of a run, `(k, 2)`; anywhere if not given.

    Raises:
        ValueError: A number is not above 0, or the room holds nothing of the island.
    """
    start, heading = _tries(navmesh, length_m, rng, num_tries, within)
    return _free_runs(navmesh, start, heading, np.zeros(num_tries), length_m, within)


def curved_runs(
    navmesh: NavMesh,
    length_m: float,
    turn_radius_m: float,
    *,
    rng: np.random.Generator,
    num_tries: int = 512,
    within: ArrayLike | None = None,
) -> Runs:
    """Runs along arcs of a radius, to the left and to the right, as `straight_runs`."""
    if not (math.isfinite(turn_radius_m) and turn_radius_m > 0.0):
        raise ValueError(f"turn_radius_m must be above 0, got {turn_radius_m}")
    start, heading = _tries(navmesh, length_m, rng, num_tries, within)
    curvature = rng.choice([-1.0, 1.0], num_tries) / turn_radius_m
    return _free_runs(navmesh, start, heading, curvature, length_m, within)


def _tries(
    navmesh: NavMesh,
    length_m: float,
    rng: np.random.Generator,
    num_tries: int,
    within: ArrayLike | None,
) -> tuple[FloatArray, FloatArray]:
    if not (math.isfinite(length_m) and length_m > 0.0 and num_tries > 0):
        raise ValueError(f"length_m and num_tries must be above 0, got {length_m} and {num_tries}")
    start = navmesh.random_points(num_tries, rng, island=0, within=within)
    return start, rng.uniform(-math.pi, math.pi, num_tries)


def _free_runs(
    navmesh: NavMesh,
    start: FloatArray,
    heading: FloatArray,
    curvature: FloatArray,
    length_m: float,
    within: ArrayLike | None,
) -> Runs:
    island, region = navmesh.islands[0], navmesh.polygons[0]
    if within is not None:
        region = shapely.intersection(region, shapely.Polygon(np.asarray(within, np.float64)))
        shapely.prepare(region)
    plan = _plan_lines(start[:, [0, 2]], heading, curvature, length_m)
    lines = shapely.linestrings(plan)
    free = np.flatnonzero(shapely.covers(region, lines))
    room = shapely.distance(lines[free], island.polygon.boundary)
    order = np.argsort(-room, kind="stable")
    chosen = free[order]
    return Runs(
        start=start[chosen],
        heading=heading[chosen],
        curvature=curvature[chosen],
        end=island.on_floor(plan[chosen, -1]),
        free_width_m=2.0 * (room[order] + navmesh.settings.agent_radius),
    )


def _plan_lines(
    start: FloatArray, heading: FloatArray, curvature: FloatArray, length_m: float
) -> FloatArray:
    """Points `(x, z)` along arcs, `(n, k, 2)`; straight ones have two."""
    bends = bool(np.any(curvature))
    pieces = max(1, math.ceil(length_m / STEP_M)) if bends else 1
    along = np.linspace(0.0, length_m, pieces + 1)
    # The chord of an arc: sinc stays exact where the curvature is 0.
    half = curvature[:, None] * along / 2.0
    chord = along * np.sinc(half / math.pi)
    way = heading[:, None] + half
    line: FloatArray = start[:, None] + chord[..., None] * np.stack([np.sin(way), np.cos(way)], -1)
    return line
