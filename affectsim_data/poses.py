"""Quaternions (`wxyz`) and rigid transforms, batched over leading axes. NumPy only.

A pose is written `T_target_source`: it takes points of `source` into `target`, so that
`p_world = T_world_camera @ p_camera`. World and people are +Y up, right-handed, metres.
People look along their own +Z (as SMPL bodies do), cameras and robots along their own -Z (as in
glTF); `yaw` always turns an object about +Y, counter-clockwise seen from above.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "FloatArray",
    "axis_angle_quaternion",
    "compose_pose",
    "invert_pose",
    "look_at",
    "matrix_quaternion",
    "quaternion_conjugate",
    "quaternion_matrix",
    "quaternion_multiply",
    "quaternion_rotate",
    "quaternion_slerp",
    "standard_quaternion",
    "transform_points",
    "yaw_quaternion",
]

FloatArray = NDArray[np.float64]

UP = np.array([0.0, 1.0, 0.0])


def _components(vectors: ArrayLike) -> FloatArray:
    """The last axis first, each component contiguous, `(k, ...)`.

    NumPy is several times faster on a few long rows than on many of three or four numbers.
    """
    array = np.asarray(vectors, np.float64)
    *shape, width = array.shape
    return array.reshape(-1, width).T.copy().reshape(width, *shape)


def _from_components(components: Sequence[FloatArray] | FloatArray) -> FloatArray:
    """The inverse of `_components`, of components of one shape."""
    width, shape = len(components), np.shape(components[0])
    rows = np.empty((width, *shape))
    for row, component in enumerate(components):
        rows[row] = component
    return rows.reshape(width, -1).T.copy().reshape(*shape, width)


def quaternion_multiply(left: ArrayLike, right: ArrayLike) -> FloatArray:
    """Product of quaternions, `(..., 4)`: rotates by `right` first, then by `left`."""
    aw, ax, ay, az = _components(left)
    bw, bx, by, bz = _components(right)
    return _from_components(
        [
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ]
    )


def quaternion_conjugate(rotation: ArrayLike) -> FloatArray:
    """Inverse of unit quaternions, `(..., 4)`."""
    conjugate: FloatArray = np.asarray(rotation, np.float64) * np.array([1.0, -1.0, -1.0, -1.0])
    return conjugate


def standard_quaternion(rotation: ArrayLike) -> FloatArray:
    """The same rotation as a unit quaternion with `w >= 0`, `(..., 4)`.

    Examples:
        >>> standard_quaternion([-2.0, 0.0, 0.0, 2.0]).round(6).tolist()
        [0.707107, -0.0, -0.0, -0.707107]
    """
    q = np.asarray(rotation, np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    standard: FloatArray = np.where(q[..., :1] < 0.0, -q, q)
    return standard


def quaternion_rotate(rotation: ArrayLike, vectors: ArrayLike) -> FloatArray:
    """Vectors `(..., 3)` turned by unit quaternions `(..., 4)`; leading axes broadcast."""
    # Written out: np.cross costs several times as much on the small batches of kinematics.
    w, x, y, z = _components(rotation)
    a, b, c = _components(vectors)
    s, t, u = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return _from_components(
        [
            a + w * s + (y * u - z * t),
            b + w * t + (z * s - x * u),
            c + w * u + (x * t - y * s),
        ]
    )


def axis_angle_quaternion(axis: ArrayLike, angle: ArrayLike) -> FloatArray:
    """Turn by `angle` (radians, `(...)`) about unit `axis` (`(..., 3)`), as `(..., 4)`."""
    half = np.asarray(angle, np.float64)[..., None] / 2.0
    imaginary = np.asarray(axis, np.float64) * np.sin(half)
    real = np.broadcast_to(np.cos(half), (*imaginary.shape[:-1], 1))
    return np.concatenate([real, imaginary], axis=-1)


def yaw_quaternion(yaw: ArrayLike) -> FloatArray:
    """Turn by `yaw` radians about +Y, `(..., 4)`.

    Examples:
        >>> quaternion_rotate(yaw_quaternion(np.pi / 2), [0.0, 0.0, 1.0]).round(6).tolist()
        [1.0, 0.0, 0.0]
    """
    half = np.asarray(yaw, np.float64) / 2.0
    rotation = np.zeros((*half.shape, 4))
    rotation[..., 0], rotation[..., 2] = np.cos(half), np.sin(half)
    return rotation


def quaternion_matrix(rotation: ArrayLike) -> FloatArray:
    """Rotation matrices `(..., 3, 3)` of unit quaternions `(..., 4)`."""
    cells = _matrix_cells(rotation)
    return _from_components(cells).reshape(*np.shape(cells[0]), 3, 3)


def _matrix_cells(rotation: ArrayLike) -> list[FloatArray]:
    """The nine cells of rotation matrices, row by row, `(...)` each."""
    q = _components(rotation)
    w, vector, doubled = q[0], q[1:], q[1:] + q[1:]
    xx, yy, zz = vector * doubled
    wx, wy, wz = w * doubled
    xy, yz = vector[:2] * doubled[1:]
    xz = vector[0] * doubled[2]
    return [
        *(1.0 - (yy + zz), xy - wz, xz + wy),
        *(xy + wz, 1.0 - (xx + zz), yz - wx),
        *(xz - wy, yz + wx, 1.0 - (xx + yy)),
    ]


def matrix_quaternion(matrix: ArrayLike) -> FloatArray:
    """Unit quaternions `(..., 4)`, `w >= 0`, of rotation matrices `(..., 3, 3)`.

    Uses the largest of the four components for a stable division (Shepperd 1978).
    """
    m = np.asarray(matrix, np.float64)
    trace = np.trace(m, axis1=-2, axis2=-1)
    m00, m11, m22 = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    squares = np.stack([trace, m00, m11, m22], axis=-1)
    # Row k is the quaternion times four times its component k.
    wx, wy, wz = (
        m[..., 2, 1] - m[..., 1, 2],
        m[..., 0, 2] - m[..., 2, 0],
        m[..., 1, 0] - m[..., 0, 1],
    )
    xy, xz, yz = (
        m[..., 0, 1] + m[..., 1, 0],
        m[..., 0, 2] + m[..., 2, 0],
        m[..., 1, 2] + m[..., 2, 1],
    )
    rows = np.stack(
        [
            np.stack([1.0 + trace, wx, wy, wz], axis=-1),
            np.stack([wx, 1.0 + m00 - m11 - m22, xy, xz], axis=-1),
            np.stack([wy, xy, 1.0 - m00 + m11 - m22, yz], axis=-1),
            np.stack([wz, xz, yz, 1.0 - m00 - m11 + m22], axis=-1),
        ],
        axis=-2,
    )
    best = np.argmax(squares, axis=-1)[..., None, None]
    return standard_quaternion(np.take_along_axis(rows, best, axis=-2)[..., 0, :])


def quaternion_slerp(start: ArrayLike, end: ArrayLike, share: ArrayLike) -> FloatArray:
    """The shorter way from `start` to `end`, `(..., 4)`, at `share` in [0, 1], `(...)`."""
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    t = np.asarray(share, np.float64)
    if not a.ndim == b.ndim == t.ndim + 1:
        shape = np.broadcast_shapes(a.shape, b.shape, (*t.shape, 1))
        a, b = np.broadcast_to(a, shape), np.broadcast_to(b, shape)
    a, b = _components(a), _components(b)
    cosine = np.add.reduce(a * b, axis=0)
    angle = np.arccos(np.minimum(np.abs(cosine), 1.0))
    sine = np.sin(angle)
    near = sine < 1e-6
    safe = np.where(near, 1.0, sine)
    weight_a = np.where(near, 1.0 - t, np.sin((1.0 - t) * angle) / safe)
    weight_b = np.where(near, t, np.sin(t * angle) / safe)
    # The end is taken by its other sign where that is nearer.
    mixed = weight_a * a + np.copysign(weight_b, cosine) * b
    mixed /= np.sqrt(np.add.reduce(mixed * mixed, axis=0))
    return _from_components(mixed)


def compose_pose(rotation: ArrayLike, translation: ArrayLike) -> FloatArray:
    """Transforms `(..., 4, 4)` of unit quaternions `(..., 4)` and translations `(..., 3)`."""
    turn, shift = _matrix_cells(rotation), _components(translation)
    shape = np.broadcast(turn[0], shift[0]).shape
    cells = np.zeros((16, *shape))
    for row in range(3):
        for column in range(3):
            cells[4 * row + column] = turn[3 * row + column]
        cells[4 * row + 3] = shift[row]
    cells[15] = 1.0
    return cells.reshape(16, -1).T.copy().reshape(*shape, 4, 4)


def invert_pose(pose: ArrayLike) -> FloatArray:
    """Inverse of rigid transforms `(..., 4, 4)`."""
    T = np.asarray(pose, np.float64)
    inverse = np.zeros_like(T)
    rotation = np.swapaxes(T[..., :3, :3], -1, -2)
    inverse[..., :3, :3] = rotation
    inverse[..., :3, 3] = -np.einsum("...ij,...j->...i", rotation, T[..., :3, 3])
    inverse[..., 3, 3] = 1.0
    return inverse


def transform_points(pose: ArrayLike, points: ArrayLike) -> FloatArray:
    """Points `(..., n, 3)` taken through transforms `(..., 4, 4)`."""
    T, p = np.asarray(pose, np.float64), np.asarray(points, np.float64)
    moved: FloatArray = p @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]
    return moved


def look_at(eye: ArrayLike, target: ArrayLike) -> FloatArray:
    """`T_world_camera`, `(..., 4, 4)`, of level cameras at `eye` that look at `target`, `(..., 3)`.

    Raises:
        ValueError: A target is at, straight above or straight below its eye.
    """
    e, t = np.asarray(eye, np.float64), np.asarray(target, np.float64)
    back = e - t
    right = np.cross(UP, back)
    length = np.linalg.norm(right, axis=-1, keepdims=True)
    if np.any(length < 1e-9):
        raise ValueError("look_at needs a target that is not straight above, below or at the eye")
    right = right / length
    back = back / np.linalg.norm(back, axis=-1, keepdims=True)
    pose = np.zeros((*back.shape[:-1], 4, 4))
    pose[..., :3, 0] = right
    pose[..., :3, 1] = np.cross(back, right)
    pose[..., :3, 2] = back
    pose[..., :3, 3] = e
    pose[..., 3, 3] = 1.0
    return pose
