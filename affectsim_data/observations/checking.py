"""Whether a trajectory may be a reference view: what it does at its knots and between them."""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.observations.candidates import MIDDLE, PEOPLE_CLEARANCE_M
from affectsim_data.observations.following import greatest_haste
from affectsim_data.observations.knots import interpolate_knots
from affectsim_data.observations.search import ReferenceSearch
from affectsim_data.observations.steadying import SteadyPath
from affectsim_data.observations.tracks import BodyTrack
from affectsim_data.poses import FloatArray, invert_pose, transform_points
from affectsim_data.skeletons import JOINT_NAMES
from affectsim_data.visibility import RayCaster, visible_share

__all__ = ["Checks", "check_knots"]

_SIGHTS = [JOINT_NAMES.index(name) for name in ("spine3", "head")]
_FRAMED = 0.9
"""Least share of instants at which the body is well framed."""
_SLACK_M = 0.02
"""What lies between two of the rays that look for surfaces near a camera."""
_FLOOR_BELOW_M = 2.5
"""No camera is higher above its floor."""


@dataclasses.dataclass(frozen=True)
class Checks:
    """What a stored trajectory does, at its knots and five times between each two."""

    outside: float
    """Share of frames from which the body's axis cannot be seen, or that have no floor below."""
    clear: float
    """Share of frames that keep the least clearance to surfaces, and 0.45 m to anybody's joints."""
    in_sight: float
    """Share of frames in which chest or head is in sight."""
    visible: float
    """Mean visible share over the cycle."""
    visible_low: float
    """The least."""
    framed: float
    """Share of instants at which the body lies in the middle of the image, between its outer
    twentieths."""
    speed_m_s: float
    """Greatest."""
    acceleration_m_s2: float
    """Greatest."""
    turn_rad_s: float
    """Greatest."""

    def hold(self, search: ReferenceSearch) -> bool:
        """Whether the trajectory keeps every limit."""
        return (
            self.safe
            and self.in_sight == 1.0
            and self.framed >= _FRAMED
            and self.visible_low >= search.least_share
            and self.gentle(search)
        )

    @property
    def safe(self) -> bool:
        """Whether it keeps inside the home and clear of surfaces and people."""
        return self.outside == 0.0 and self.clear == 1.0

    def gentle(self, search: ReferenceSearch) -> bool:
        """Whether it keeps the limits of motion."""
        return (
            self.speed_m_s <= search.speed_m_s
            and self.acceleration_m_s2 <= search.acceleration_m_s2
            and self.turn_rad_s <= math.radians(search.turn_deg_s)
        )

    def quality(self, search: ReferenceSearch) -> float:
        """What the best of trajectories that do not hold is chosen by; safety comes first."""
        safety = 100.0 * (self.outside == 0.0) + 10.0 * (self.clear == 1.0) + self.clear
        view = self.visible + self.visible_low + self.in_sight + 2.0 * self.framed
        return safety + view + self.gentle(search)


def check_knots(
    knots: FloatArray,
    track: BodyTrack,
    steady: SteadyPath,
    *,
    camera: Camera,
    caster: RayCaster,
    search: ReferenceSearch,
) -> Checks:
    """Measures a trajectory.

    Args:
        knots: As stored, `(k, 7)`.
        track: The target and its partner, in the world.
        steady: What the trajectory follows, in the world.
        camera: Intrinsics.
        caster: Rays against the scene.
        search: Limits.
    """
    count = len(steady.center)
    poses = interpolate_knots(knots, np.arange(count) / count)
    eyes = poses[:, :3, 3]
    instants = track.at_instants(poses)
    share = visible_share(track.samples, instants[:, None], camera, caster).visible[:, 0]
    rate = count / track.duration_s
    speed, acceleration = greatest_haste(eyes, rate)
    axis = steady.center.copy()
    axis[:, 1] = eyes[:, 1]
    sights = ~caster.hidden(eyes[:, None], track.joints[:, _SIGHTS])
    return Checks(
        outside=float((caster.hidden(eyes, axis) | ~_over_floor(eyes, caster)).mean()),
        clear=float(_clear(eyes, track, caster, search.least_clearance_m).mean()),
        in_sight=float(sights.any(axis=1).mean()),
        visible=float(share.mean()),
        visible_low=float(share.min()),
        framed=float(_framed(instants, track.samples.points, camera).mean()),
        speed_m_s=speed,
        acceleration_m_s2=acceleration,
        turn_rad_s=_turning(poses[:, :3, :3]) * rate,
    )


def _over_floor(eyes: FloatArray, caster: RayCaster) -> NDArray[np.bool_]:
    down = np.array([0.0, -1.0, 0.0])
    return ~np.isinf(caster.distance(eyes, down, limit=_FLOOR_BELOW_M))


def _clear(
    eyes: FloatArray, track: BodyTrack, caster: RayCaster, least_m: float
) -> NDArray[np.bool_]:
    """Whether cameras `(n, 3)` keep away from surfaces and from people, bool `(n,)`."""
    free = caster.distance(eyes[:, None], _all_round(), limit=least_m + _SLACK_M)
    clear = np.asarray(np.isinf(free).all(axis=1))
    for joints in (track.joints, track.partner_joints):
        if joints is not None:
            clear &= _nearest(joints, eyes) >= PEOPLE_CLEARANCE_M
    return clear


def _nearest(joints: FloatArray, eyes: FloatArray) -> FloatArray:
    """Distance of eyes `(n, 3)` to the nearest of joints `(n, num_joints, 3)`, `(n,)`."""
    ways = joints - eyes[:, None]
    nearest: FloatArray = np.sqrt(np.einsum("nji,nji->nj", ways, ways).min(axis=1))
    return nearest


@functools.cache
def _all_round(count: int = 64) -> FloatArray:
    """Unit vectors evenly over the sphere, on a golden spiral, `(count, 3)`."""
    y = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (3.0 - math.sqrt(5.0)) * np.arange(count)
    radius = np.sqrt(1.0 - y**2)
    return np.stack([radius * np.cos(turn), y, radius * np.sin(turn)], axis=1)


def _framed(poses: FloatArray, points: FloatArray, camera: Camera) -> NDArray[np.bool_]:
    """Whether bodies `(t, n, 3)` lie in the middle of images, 5th to 95th percentile, `(t,)`."""
    pixels, _ = camera.project(transform_points(invert_pose(poses), points))
    size = np.array([camera.width, camera.height])
    places = np.sort(np.nan_to_num(pixels, nan=-np.inf), axis=1) / size
    cut = round(0.05 * (points.shape[1] - 1))
    low, high = places[:, cut], places[:, -1 - cut]
    margin = (1.0 - MIDDLE) / 2.0
    framed: NDArray[np.bool_] = ((low >= margin) & (high <= 1.0 - margin)).all(axis=1)
    return framed


def _turning(rotations: FloatArray) -> float:
    """Greatest angle between one of cyclic rotations `(n, 3, 3)` and the next, radians."""
    change = rotations - np.roll(rotations, -1, axis=0)
    # The Frobenius norm of a difference of rotations is 2 sqrt(2) sin(angle / 2).
    chord = np.sqrt(np.einsum("nij,nij->n", change, change)).max() / (2.0 * math.sqrt(2.0))
    return 2.0 * math.asin(min(float(chord), 1.0))
