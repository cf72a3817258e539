"""Camera trajectories as closed knots: what episodes store of a reference view."""

from __future__ import annotations

import numpy as np

from affectsim_data.poses import FloatArray, compose_pose, standard_quaternion

__all__ = ["interpolate_knots", "make_knots"]


def make_knots(eyes: FloatArray, targets: FloatArray) -> FloatArray:
    """Knots `(k, 7)`, position and quaternion, of level cameras at `(k, 3)` that look at `(k, 3)`.

    Rounded to float32, as episodes store them, so that what is checked is what is stored.
    """
    x, y, z = np.moveaxis(targets - eyes, -1, 0)
    # A camera at yaw 0 and pitch 0 looks along -Z.
    yaw, pitch = np.arctan2(-x, -z) / 2.0, np.arctan2(y, np.hypot(x, z)) / 2.0
    turn, tilt = (np.cos(yaw), np.sin(yaw)), (np.cos(pitch), np.sin(pitch))
    quaternion = [turn[0] * tilt[0], turn[0] * tilt[1], turn[1] * tilt[0], -turn[1] * tilt[1]]
    knots = np.column_stack([eyes, standard_quaternion(np.stack(quaternion, axis=-1))])
    return knots.astype(np.float32).astype(np.float64)


def interpolate_knots(knots: FloatArray, cycles: FloatArray) -> FloatArray:
    """Poses `(n, 4, 4)` along closed knots `(k, 7)`, position and quaternion, at `(n,)` cycles.

    Cubic (Catmull and Rom 1974) in all seven numbers, so that the camera's velocity has no steps;
    a camera that is still at four knots is still between the middle two.
    """
    count = len(knots)
    place = np.mod(cycles, 1.0) * count
    first = np.floor(place)
    share = place - first
    around = knots[(first.astype(np.intp)[:, None] + np.arange(-1, 3)) % count]
    # Of a quaternion's two signs, the one nearer to the knot before.
    other_side = np.einsum("nkj,nj->nk", around[..., 3:], around[:, 1, 3:]) < 0.0
    around[..., 3:][other_side] *= -1.0
    weights = np.array(
        [
            *(((2.0 - share) * share - 1.0) * share, (3.0 * share - 5.0) * share**2 + 2.0),
            *(((4.0 - 3.0 * share) * share + 1.0) * share, (share - 1.0) * share**2),
        ]
    )
    mixed = np.einsum("kn,nkj->nj", weights / 2.0, around)
    mixed[:, 3:] /= np.linalg.norm(mixed[:, 3:], axis=1, keepdims=True)
    return compose_pose(mixed[:, 3:], mixed[:, :3])
