"""What stands for objects without a mesh: boxes of the nominal size of their category."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from affectsim_data.builders.habitat.instances import Instance
from affectsim_data.builders.habitat.shapes import box_part
from affectsim_data.builders.meshes import MeshPart
from affectsim_data.poses import FloatArray, compose_pose, quaternion_rotate, yaw_quaternion

__all__ = ["NOMINAL_SIZES", "STAND_IN_COLOR", "facing_deg", "floor_height", "nominal_box"]

STAND_IN_COLOR = (178, 186, 194)
NOMINAL_SIZES: Mapping[str, tuple[float, float, float]] = {
    "armchair": (0.85, 0.9, 0.85),
    "beanbag": (0.9, 0.7, 0.9),
    "bed": (1.6, 0.6, 2.05),
    "bench": (1.2, 0.45, 0.4),
    "bike": (0.6, 1.05, 1.75),
    "bin": (0.3, 0.45, 0.3),
    "cabinet": (0.8, 0.9, 0.45),
    "chair": (0.48, 0.85, 0.52),
    "counter": (1.8, 0.9, 0.62),
    "desk": (1.4, 0.75, 0.7),
    "dresser": (1.0, 0.85, 0.5),
    "fridge": (0.65, 1.8, 0.67),
    "lamp": (0.4, 1.5, 0.4),
    "nightstand": (0.45, 0.5, 0.4),
    "plant": (0.45, 1.0, 0.45),
    "rug": (2.0, 0.01, 1.4),
    "shelf": (0.8, 1.8, 0.35),
    "sofa": (2.0, 0.85, 0.9),
    "stool": (0.38, 0.47, 0.38),
    "table": (1.4, 0.75, 0.85),
    "toilet": (0.38, 0.78, 0.68),
    "tv": (1.1, 0.65, 0.08),
    "tv_stand": (1.5, 0.5, 0.42),
    "wardrobe": (1.2, 2.0, 0.6),
    "washbasin": (0.55, 0.85, 0.45),
}
"""Width, height and depth, metres: middle of what furniture shops sell, no measure of any model."""
_NOT_STANDING = ("bin", "lamp", "plant", "tv")
"""Categories that are also put on furniture and walls."""
_FLOOR_REACH_M = 0.25
"""Furniture whose origin is further from the floor is something else of its category."""
_LEVEL = 0.5
"""Directions whose level part is shorter have no yaw."""
_CLUSTER_M = 0.06
_LEAST_SHARE = 0.1
"""The floor is the lowest height that at least this share of the objects, and two, stand on."""
_RUG_M = 0.05
"""What is thinner and near the floor is a rug or a mat."""
_ABOVE_FLOOR_M = 0.004
"""Least height of a rug's top above the floor, so that both can be told apart."""


def nominal_box(
    category: str, instance: Instance, scale: FloatArray, *, floor_y: float
) -> tuple[MeshPart, FloatArray] | None:
    """A box in the place of an object, and its pose; `None` if nothing says how large it is.

    Upright, whatever the instance's rotation: it stands on the asset's origin, which in HSSD is
    the middle of the bottom, or has the centre of mass in its middle.

    Args:
        category: Of the object.
        instance: Where it stands.
        scale: Of instance and template together, `(3,)`.
        floor_y: Height of the floor, metres.
    """
    if category not in NOMINAL_SIZES:
        return None
    off_floor = abs(float(instance.translation[1]) - floor_y)
    if category not in _NOT_STANDING and not instance.com_origin and off_floor > _FLOOR_REACH_M:
        return None
    sides = np.array(NOMINAL_SIZES[category]) * np.abs(scale)
    middle = np.array([0.0, 0.0 if instance.com_origin else sides[1] / 2.0, 0.0])
    turn = yaw_quaternion(np.deg2rad(facing_deg(instance.rotation)))
    return box_part(sides, color=STAND_IN_COLOR), compose_pose(turn, instance.translation + middle)


def facing_deg(rotation: FloatArray) -> float:
    """Yaw of the front, -Z, of something turned so; of its top, if it lies on its back or face."""
    front = quaternion_rotate(rotation, (0.0, 0.0, -1.0))
    if np.hypot(front[0], front[2]) < _LEVEL:
        front = quaternion_rotate(rotation, (0.0, 1.0, 0.0))
    return float(np.degrees(np.arctan2(front[0], front[2])))


def floor_height(bottoms: FloatArray, tops: FloatArray) -> float:
    """The lowest height that many of the objects stand on; rugs lie above it.

    Args:
        bottoms: Lowest point of each object, metres, `(n,)`; at least one.
        tops: Highest point of each, metres, `(n,)`.
    """
    heights = np.sort(bottoms)
    last = np.searchsorted(heights, heights + _CLUSTER_M, side="right")
    counts = last - np.arange(len(heights))
    needed = min(max(2, int(np.ceil(_LEAST_SHARE * len(heights)))), int(counts.max()))
    first = int(np.flatnonzero(counts >= needed)[0])
    floor_y = float(np.median(heights[first : last[first]]))
    # Rugs are often let into the floor by half their thickness.
    flat = (tops - bottoms < _RUG_M) & (tops - bottoms > 0.0) & (abs(tops - floor_y) < _CLUSTER_M)
    return min(floor_y, float(tops[flat].min()) - _ABOVE_FLOOR_M) if flat.any() else floor_y
