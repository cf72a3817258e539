"""Candidate reference views of a performance, and what of their scores no scene can change."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.observations.orbit import relative_camera
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.observations.steadying import SteadyPath
from affectsim_data.observations.tracks import BodyTrack
from affectsim_data.poses import FloatArray

__all__ = ["MIDDLE", "PEOPLE_CLEARANCE_M", "Candidates", "make_candidates"]

MIDDLE = 0.8
"""Share of the image, in width and in height, that a well framed body lies within."""
PEOPLE_CLEARANCE_M = 0.45
"""Kept between a camera and anybody's joints."""
_FILL_TOLERANCE = 0.25


@dataclasses.dataclass(frozen=True, eq=False)
class Candidates:
    """Relative camera poses of one performance, in the performance frame.

    There are `k`, in the order of the search's azimuths, then distances, then heights, over the
    `t` cycle instants.
    """

    azimuth: FloatArray
    """To the facing, radians, `(k,)`."""
    distance_m: FloatArray
    """Horizontal, to the body centre, `(k,)`."""
    height_m: FloatArray
    """Above the floor, `(k,)`."""
    center: FloatArray
    """What they look at, `(t, 3)`."""
    eyes: FloatArray
    """Where they are, `(t, k, 3)`."""
    in_image_bits: NDArray[np.uint8]
    """Which body points fall in the image, packed, `(t, k, num_points / 8)`."""
    in_image: FloatArray
    """Share of them, `(t, k)`."""
    beside_partner: NDArray[np.bool_]
    """Whether the other participant is not where the camera is, `(t, k)`."""
    framing: FloatArray
    """Share of the body in the middle of the image, less if it does not fill it, `(t, k)`."""
    parts: dict[str, FloatArray]
    """Parts of the score that depend on the body alone, in [0, 1], `(k,)` each."""

    def inside(self, chosen: NDArray[np.intp], num_points: int) -> NDArray[np.bool_]:
        """Which body points are in the image of some candidates, `(t, len(chosen), num_points)`."""
        bits = np.unpackbits(self.in_image_bits[:, chosen], axis=-1, count=num_points)
        return bits.view(np.bool_)


def make_candidates(
    track: BodyTrack, steady: SteadyPath, camera: Camera, search: ReferenceSearch
) -> Candidates:
    """All candidates of a search about a performance in its own frame."""
    grid = itertools.product(search.azimuths_deg, search.distances_m, search.heights_m)
    azimuth_deg, distance_m, height_m = np.array(list(grid)).T
    azimuth = np.radians(azimuth_deg)
    center, heading = track.at_instants(steady.center), track.at_instants(steady.heading)
    poses = relative_camera(
        center[:, None], heading[:, None], azimuth=azimuth, distance_m=distance_m, eye_y=height_m
    )
    eyes = poses[..., :3, 3]
    across, up = _image_places(poses, track.samples.points, camera)
    inside = np.maximum(np.abs(across), np.abs(up)) < 1.0
    middle = np.maximum(np.abs(across), np.abs(up)) < MIDDLE
    filled = np.ptp(np.clip(up, -2.0, 2.0), axis=-1) / 2.0
    fill = np.exp(-(((filled - search.body_share) / _FILL_TOLERANCE) ** 2))
    off = (heading - track.at_instants(track.path.heading))[:, None] + azimuth
    far = (distance_m - search.preferred_distance_m) / 0.8
    return Candidates(
        azimuth=azimuth,
        distance_m=distance_m,
        height_m=height_m,
        center=center,
        eyes=eyes,
        in_image_bits=np.packbits(inside, axis=-1),
        in_image=inside.mean(axis=-1),
        beside_partner=_beside(eyes, track),
        framing=middle.mean(axis=-1) * fill,
        parts={
            "alignment": ((1.0 + np.cos(off)) / 2.0).mean(axis=0),
            "distance_fit": np.exp(-(far**2)),
        },
    )


def _image_places(
    poses: FloatArray, points: FloatArray, camera: Camera
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Places of points `(t, n, 3)` in the images of cameras `(t, k, 4, 4)`, `(t, k, n)` each.

    Half the image is 1, to the right and up; points behind the camera are far outside. Float32:
    there are many, and a thousandth of a pixel does not matter.
    """
    count, num_cameras = poses.shape[:2]
    axes = np.swapaxes(poses[..., :3, :3], -1, -2)
    shift = np.einsum("tkij,tkj->tki", axes, poses[..., :3, 3]).astype(np.float32)
    # One product for all cameras of an instant.
    rows = axes.reshape(count, -1, 3).astype(np.float32)
    places = rows @ np.swapaxes(points, -1, -2).astype(np.float32)
    x, y, z = np.moveaxis(places.reshape(count, num_cameras, 3, -1) - shift[..., None], 2, 0)
    depth = np.maximum(-z, np.float32(1e-3))
    half_width, half_height = np.tan(camera.hfov / 2.0), np.tan(camera.vfov / 2.0)
    return x / (depth * np.float32(half_width)), y / (depth * np.float32(half_height))


def _beside(eyes: FloatArray, track: BodyTrack) -> NDArray[np.bool_]:
    """Whether eyes `(t, k, 3)` keep away from the partner, bool `(t, k)`."""
    if track.partner_joints is None:
        return np.ones(eyes.shape[:2], bool)
    joints = track.at_instants(track.partner_joints)
    away = np.linalg.norm(eyes[:, :, None] - joints[:, None], axis=-1).min(axis=-1)
    clear: NDArray[np.bool_] = away >= PEOPLE_CLEARANCE_M
    return clear
