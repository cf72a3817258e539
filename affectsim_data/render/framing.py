"""What of a clip is where in the image: frusta, levels of detail, screen rectangles. NumPy only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from affectsim_data.avatars import AvatarMesh
from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray, invert_pose, transform_points
from affectsim_data.render.protocol import ClipSpec, PosedAvatar
from affectsim_data.skeletons import NUM_JOINTS

__all__ = [
    "BACKGROUND",
    "FAR_M",
    "NEAR_M",
    "body_corners",
    "choose_mesh",
    "joint_boxes",
    "screen_rectangles",
    "visible_boxes",
]

NEAR_M, FAR_M = 0.05, 60.0
"""Clip planes, metres. 24 bits of depth between them resolve 0.03 mm at 5 m and 2 mm at 40 m."""
BACKGROUND = (196, 206, 214)
"""sRGB where nothing was hit: what is seen through a window without a world behind it."""

TRIANGLES_PER_PIXEL = 0.65
BODY_ASPECT = 0.4
"""Share of the square over a body's height that the body covers, arms and all."""


def choose_mesh(person: PosedAvatar, spec: ClipSpec) -> AvatarMesh:
    """The level of detail for a whole clip: about two triangles for three covered pixels.

    Goes by the frame in which the person is seen largest, so that it never changes within a clip.
    """
    pelvis = person.avatar.skeleton.rest_positions[0]
    matrices = person.joint_matrices[:, 0]
    position = np.einsum("fij,j->fi", matrices[:, :3, :3], pelvis) + matrices[:, :3, 3]
    poses = spec.trajectory.T_world_camera
    way = position - poses[:, :3, 3]
    x, y, z = np.abs(np.einsum("fji,fj->fi", poses[:, :3, :3], way)).T
    stature = 1.8 * person.avatar.skeleton.hip_height
    half = np.tan([spec.camera.hfov / 2.0, spec.camera.vfov / 2.0])
    seen = (np.einsum("fi,fi->f", way, poses[:, :3, 2]) < stature) & (
        (x <= half[0] * z + stature) & (y <= half[1] * z + stature)
    )
    if not seen.any():
        return person.avatar.mesh(max_triangles=0)
    distance = max(float(np.linalg.norm(way[seen], axis=1).min()), 0.3)
    height_px = min(stature * spec.camera.intrinsics[0, 0] / distance, 2.0 * spec.camera.height)
    budget = TRIANGLES_PER_PIXEL * BODY_ASPECT * height_px**2
    return person.avatar.mesh(max_triangles=int(budget))


def joint_boxes(mesh: AvatarMesh) -> FloatArray:
    """Corners of the boxes around what each joint moves, in the rest pose, `(22, 8, 3)`.

    A skinned vertex is a mean of its places under its joints, so it lies in the convex hull of
    all moved corners. Joints that move nothing have `nan` corners.
    """
    corners = np.full((NUM_JOINTS, 8, 3), np.nan)
    for joint in range(NUM_JOINTS):
        moved = ((mesh.joint_indices == joint) & (mesh.joint_weights > 0)).any(axis=1)
        if moved.any():
            points = mesh.positions[moved]
            low, high = points.min(axis=0), points.max(axis=0)
            corners[joint] = [
                [(low, high)[i >> axis & 1][axis] for axis in range(3)] for i in range(8)
            ]
    return corners


def body_corners(boxes: FloatArray, joint_matrices: FloatArray) -> FloatArray:
    """World points whose convex hull holds the body at every frame, `(num_frames, n, 3)`."""
    used = ~np.isnan(boxes[:, 0, 0])
    moved = transform_points(joint_matrices[:, used], boxes[used])
    return moved.reshape(len(joint_matrices), -1, 3)


def screen_rectangles(
    points_world: FloatArray, camera: Camera, T_world_camera: FloatArray
) -> NDArray[np.int64]:
    """Pixel rectangles around points `(num_frames, n, 3)`: `(num_frames, 4)` as u0, v0, u1, v1.

    Half open, with a margin of two pixels, clipped to the image; empty ones are all zero. Where a
    point is nearer than the near plane the rectangle is the whole image.
    """
    points_camera = transform_points(invert_pose(T_world_camera), points_world)
    pixels, depth = camera.project(points_camera)
    size = np.array([camera.width, camera.height])
    near = np.asarray((depth <= NEAR_M).any(axis=1))
    behind = np.asarray((depth <= 0.0).all(axis=1))
    pixels = np.where(near[:, None, None], 0.0, pixels)
    low = np.clip(np.floor(pixels.min(axis=1)) - 2, 0, size)
    high = np.clip(np.ceil(pixels.max(axis=1)) + 2, 0, size)
    rectangles = np.concatenate([low, high], axis=1)
    rectangles[near] = (0, 0, camera.width, camera.height)
    empty = (rectangles[:, 2:] <= rectangles[:, :2]).any(axis=1) | behind
    rectangles[empty] = 0
    return rectangles.astype(np.int64)


def visible_boxes(
    low: FloatArray,
    high: FloatArray,
    clip_from_world: FloatArray,
    eye: FloatArray,
    windows: FloatArray | None = None,
) -> NDArray[np.int64]:
    """Indices of the boxes `(n, 3)` that may be in view of one camera, nearest first.

    Args:
        low: Low corners, metres.
        high: High corners.
        clip_from_world: Clip matrix.
        eye: Where the camera is.
        windows: What part of the image each box can be seen in: least x and y, greatest x and y in
            normalised device coordinates, `(n, 4)`; `None` is all of it.
    """
    centre, half = (low + high) / 2.0, (high - low) / 2.0
    x, y, z, w = clip_from_world
    planes = np.stack([w + x, w + y, w - x, w - y, w + z, w - z])
    reach = centre @ planes[:, :3].T + half @ np.abs(planes[:, :3]).T + planes[:, 3]
    inside = np.flatnonzero((reach >= 0.0).all(axis=1))
    if windows is not None:
        inside = inside[_in_windows(centre[inside], half[inside], clip_from_world, windows[inside])]
    outside = np.maximum(np.maximum(low[inside] - eye, eye - high[inside]), 0.0)
    distance = np.einsum("ij,ij->i", outside, outside)
    return inside[np.argsort(distance, kind="stable")]


def _in_windows(
    centre: FloatArray, half: FloatArray, clip_from_world: FloatArray, windows: FloatArray
) -> NDArray[np.bool_]:
    """Which boxes may be seen in a window each: the four sides of each frustum are planes."""
    xy, w = clip_from_world[[0, 1, 0, 1]], clip_from_world[3]
    sign = np.array([1.0, 1.0, -1.0, -1.0])
    # x >= least w, y >= least w, x <= greatest w, y <= greatest w.
    planes = (xy - windows[..., None] * w) * sign[:, None]
    reach = np.einsum("npk,nk->np", planes[..., :3], centre) + planes[..., 3]
    reach += np.einsum("npk,nk->np", np.abs(planes[..., :3]), half)
    whole: NDArray[np.bool_] = (reach >= 0.0).all(axis=1)
    return whole & (windows[:, 0] < windows[:, 2])
