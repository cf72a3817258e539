"""Room to stand: free discs around points, alone or along a whole motion."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from affectsim_data.navmesh import NavMesh
from affectsim_data.poses import FloatArray, compose_pose, transform_points, yaw_quaternion

__all__ = ["clearance", "fits", "footprint_fits"]


def clearance(navmesh: NavMesh, points: ArrayLike) -> FloatArray:
    """Radius of the free disc on the floor around each point `(n, 3)`, metres, `(n,)`.

    What the agent's middle has to the edge of the mesh, and the agent's radius. The grid keeps up
    to one cell more away from things, so the true disc may be that much larger. 0 off the mesh,
    where less than the agent's radius is free.
    """
    where = np.asarray(points, np.float64).reshape(-1, 3)
    free = np.zeros(len(where))
    on_mesh = navmesh.navigable(where)
    if np.any(on_mesh):
        radius = navmesh.settings.agent_radius
        free[on_mesh] = navmesh.distance_to_wall(where[on_mesh]) + radius
    return free


def fits(navmesh: NavMesh, points: ArrayLike, *, radius_m: float) -> NDArray[np.bool_]:
    """Whether a person or robot of a radius can stand at points `(n, 3)`, `(n,)`.

    Raises:
        ValueError: The radius is below the agent's, which a navmesh cannot tell.
    """
    least = navmesh.settings.agent_radius
    if not (math.isfinite(radius_m) and radius_m >= least):
        raise ValueError(
            f"radius_m must be at least {least:g}, the agent radius of the navmesh, got {radius_m}"
        )
    free: NDArray[np.bool_] = clearance(navmesh, points) >= radius_m
    return free


def footprint_fits(
    navmesh: NavMesh,
    footprint: ArrayLike,
    anchors: ArrayLike,
    facings: ArrayLike,
    *,
    radius_m: float,
) -> NDArray[np.bool_]:
    """Whether all of a motion has room where it is placed, `(n,)`.

    Args:
        navmesh: Of the scene.
        footprint: Floor points a motion passes, in its own frame, `(k, 3)`.
        anchors: Where its origin is placed, `(n, 3)`.
        facings: Radians counter-clockwise from above, 0 looks along +Z, `(n,)`.
        radius_m: Radius of the free disc around each of its points.
    """
    poses = compose_pose(yaw_quaternion(facings), np.asarray(anchors, np.float64))
    swept = transform_points(poses, np.asarray(footprint, np.float64))
    free = fits(navmesh, swept.reshape(-1, 3), radius_m=radius_m)
    return np.asarray(np.all(free.reshape(swept.shape[:-1]), axis=-1))
