"""Pinhole cameras and their trajectories.

A camera frame is +X right, +Y up and looks along -Z, as in glTF. Pixels are `(u, v)` from the top
left corner of the image, pixel centres at +0.5. Depth is the distance along the view axis.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from affectsim_data.poses import FloatArray, invert_pose, transform_points

__all__ = ["Camera", "CameraTrajectory", "to_opencv"]

MAX_IMAGE_SIZE = 8192
"""Pixels along one side; a bound on what a bad argument can allocate."""


@dataclasses.dataclass(frozen=True)
class Camera:
    """A pinhole camera with square pixels and a centred principal point."""

    width: int
    """Image width in pixels."""
    height: int
    """Image height in pixels."""
    hfov: float
    """Full horizontal field of view, radians."""

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            size = getattr(self, name)
            if not isinstance(size, int) or not 1 <= size <= MAX_IMAGE_SIZE:
                raise ValueError(
                    f"camera {name} must be 1 to {MAX_IMAGE_SIZE} pixels, got {size!r}"
                )
        if not 0.0 < self.hfov < math.pi:
            raise ValueError(
                f"camera hfov must be between 0 and 180 degrees, got {math.degrees(self.hfov):g}"
            )

    @property
    def intrinsics(self) -> FloatArray:
        """Pinhole matrix K in pixels, `(3, 3)`, for a camera that looks along +Z (OpenCV).

        Examples:
            >>> Camera(width=200, height=100, hfov=math.pi / 2).intrinsics.round(6).tolist()
            [[100.0, 0.0, 100.0], [0.0, 100.0, 50.0], [0.0, 0.0, 1.0]]
        """
        focal = self.width / (2.0 * math.tan(self.hfov / 2.0))
        return np.array(
            [[focal, 0.0, self.width / 2.0], [0.0, focal, self.height / 2.0], [0.0, 0.0, 1.0]]
        )

    @property
    def vfov(self) -> float:
        """Full vertical field of view, radians."""
        return 2.0 * math.atan(math.tan(self.hfov / 2.0) * self.height / self.width)

    def resized(self, *, width: int, height: int) -> Camera:
        """The same horizontal field of view on another image size."""
        return dataclasses.replace(self, width=width, height=height)

    def projection_matrix(self, *, near: float, far: float) -> FloatArray:
        """OpenGL projection `(4, 4)`: view frustum to the cube [-1, 1] with near at -1."""
        x = 1.0 / math.tan(self.hfov / 2.0)
        y = x * self.width / self.height
        a, b = (far + near) / (near - far), 2.0 * far * near / (near - far)
        return np.array([[x, 0, 0, 0], [0, y, 0, 0], [0, 0, a, b], [0, 0, -1.0, 0]], np.float64)

    def project(self, points_camera: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Pixel coordinates `(..., 2)` and depth `(...)` of points in the camera frame, `(..., 3)`.

        Points at or behind the image plane have depth <= 0 and `nan` pixel coordinates.
        """
        p = np.asarray(points_camera, np.float64)
        depth = -p[..., 2]
        K = self.intrinsics
        with np.errstate(divide="ignore", invalid="ignore"):
            u = K[0, 0] * p[..., 0] / depth + K[0, 2]
            v = -K[1, 1] * p[..., 1] / depth + K[1, 2]
        pixels = np.stack([u, v], axis=-1)
        pixels[depth <= 0.0] = np.nan
        return pixels, depth

    def sees(self, points_world: ArrayLike, T_world_camera: ArrayLike) -> np.ndarray:
        """Which points `(..., n, 3)` are in the image of cameras `(..., 4, 4)`, bool `(..., n)`.

        Says nothing about occlusion.
        """
        points_camera = transform_points(invert_pose(T_world_camera), points_world)
        pixels, depth = self.project(points_camera)
        with np.errstate(invalid="ignore"):
            inside = np.all((pixels >= 0.0) & (pixels < (self.width, self.height)), axis=-1)
        return np.asarray(inside & (depth > 0.0))

    def to_json(self) -> dict[str, float | int]:
        """Fields for the manifest; the field of view in degrees."""
        return {
            "width": self.width,
            "height": self.height,
            "hfov_deg": round(math.degrees(self.hfov), 6),
        }

    @classmethod
    def from_json(cls, fields: Mapping[str, float | int]) -> Camera:
        """Reads what `to_json` wrote, or the `[camera]` table of a recipe."""
        hfov = math.radians(float(fields["hfov_deg"]))
        # Not `int(...)`: half a pixel is an error, not a smaller image.
        width, height = fields["width"], fields["height"]
        return cls(width=width, height=height, hfov=hfov)  # type: ignore[arg-type]  # checked there


@dataclasses.dataclass(frozen=True)
class CameraTrajectory:
    """Where the camera is at every frame of a clip."""

    T_world_camera: FloatArray
    """Camera poses, `(num_frames, 4, 4)`."""

    def __post_init__(self) -> None:
        shape = self.T_world_camera.shape
        if len(shape) != 3 or shape[1:] != (4, 4) or shape[0] < 1:
            raise ValueError(f"T_world_camera must be (num_frames, 4, 4), got {shape}")
        if not np.isfinite(self.T_world_camera).all():
            raise ValueError("T_world_camera must be finite")

    def __len__(self) -> int:
        return len(self.T_world_camera)

    @property
    def is_still(self) -> bool:
        """Whether every frame has the very same pose."""
        return bool((self.T_world_camera == self.T_world_camera[0]).all())

    @classmethod
    def still(cls, T_world_camera: ArrayLike, *, num_frames: int) -> CameraTrajectory:
        """One pose `(4, 4)` held for `num_frames` frames."""
        return cls(np.repeat(np.asarray(T_world_camera, np.float64)[None], num_frames, axis=0))


def to_opencv(T_world_camera: ArrayLike) -> FloatArray:
    """The same poses `(..., 4, 4)` for a camera frame +X right, +Y down, looking along +Z."""
    return np.asarray(T_world_camera, np.float64) @ np.diag([1.0, -1.0, -1.0, 1.0])
