"""Relaxed hands: the splayed fingers of the base mesh brought together and slightly curled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from affectsim_data.builders.bodies.surfaces import IntArray, normalized
from affectsim_data.poses import FloatArray

__all__ = ["relax_hands"]

_BENDS_DEG = {2: (16.0, 26.0, 14.0), 3: (22.0, 31.0, 16.0), 4: (27.0, 35.0, 18.0)}
"""Flexion of index, middle and ring finger at knuckle, middle and end joint: the resting cascade,
more towards the little finger."""
_LITTLE_DEG = (30.0, 37.0, 18.0)
_THUMB_DEG = (10.0, 12.0, 14.0)
_GATHERED = 0.8
"""Share of the spread between the fingers that is taken away."""
_THUMB_IN_DEG = 16.0
"""How far the thumb turns towards the index finger."""


def relax_hands(
    positions: FloatArray,
    bones: Mapping[str, FloatArray],
    labels: Sequence[str],
    indices: IntArray,
    weights: FloatArray,
) -> FloatArray:
    """The vertices `(num_vertices, 3)` with both hands relaxed; wrists and palms stay.

    Args:
        positions: Vertices in Anny's rest pose, metres, `(num_vertices, 3)`.
        bones: Heads of Anny's bones there, metres, `(3,)` by label.
        labels: Anny's bones in the order of `indices`.
        indices: The bones that move a vertex, `(num_vertices, k)`.
        weights: Their shares, `(num_vertices, k)`.
    """
    matrices = np.tile(np.eye(4), (len(labels), 1, 1))
    for side, suffix in ((1.0, ".L"), (-1.0, ".R")):
        for bone, matrix in _finger_matrices(bones, side, suffix).items():
            matrices[labels.index(bone)] = matrix
    blended = np.einsum("vk,vkab->vab", weights, matrices[indices])
    blended /= weights.sum(axis=1)[:, None, None]
    turned = np.einsum("vab,vb->va", blended[:, :3, :3], positions)
    moved: FloatArray = turned + blended[:, :3, 3]
    return moved


def _finger_matrices(
    bones: Mapping[str, FloatArray], side: float, suffix: str
) -> dict[str, FloatArray]:
    """Matrices `(4, 4)` of the finger bones of one hand by label; `side` is 1 on the left."""
    knuckle = {finger: bones[f"finger{finger}-1{suffix}"] for finger in range(1, 6)}
    along = normalized(knuckle[3] - bones[f"wrist{suffix}"])
    palm = side * normalized(np.cross(along, knuckle[2] - knuckle[5]))
    bends = {1: _THUMB_DEG, **_BENDS_DEG, 5: _LITTLE_DEG}
    ways = {
        finger: normalized(bones[f"finger{finger}-2{suffix}"] - place)
        for finger, place in knuckle.items()
    }
    found: dict[str, FloatArray] = {}
    for finger, way in ways.items():
        goal, share = (ways[3], _GATHERED)
        if finger == 1:
            goal, share = along, np.radians(_THUMB_IN_DEG) / _angle(way, along, palm)
        turn = Rotation.from_rotvec(palm * _signed_angle(way, goal, palm) * share)
        axis = normalized(np.cross(way, palm))
        heads = [bones[f"finger{finger}-{part}{suffix}"] for part in (1, 2, 3)]
        place = heads[0]
        for part, bend in enumerate(bends[finger]):
            turn = turn * Rotation.from_rotvec(axis * np.radians(bend))
            matrix = np.eye(4)
            matrix[:3, :3] = turn.as_matrix()
            matrix[:3, 3] = place - matrix[:3, :3] @ heads[part]
            found[f"finger{finger}-{part + 1}{suffix}"] = matrix
            if part < 2:
                place = place + matrix[:3, :3] @ (heads[part + 1] - heads[part])
    return found


def _signed_angle(first: FloatArray, second: FloatArray, axis: FloatArray) -> float:
    """The turn about `axis` that takes `first` into the half plane of `second`, radians."""
    start, end = (normalized(vector - axis * (vector @ axis)) for vector in (first, second))
    return float(np.arctan2(np.cross(start, end) @ axis, start @ end))


def _angle(first: FloatArray, second: FloatArray, axis: FloatArray) -> float:
    return max(abs(_signed_angle(first, second, axis)), 1e-6)
