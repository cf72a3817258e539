"""P-Ref: the reference view, from privileged geometry and never from labels or predictions."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from affectsim_data.cameras import CameraTrajectory
from affectsim_data.episodes import Episode, ReferenceView, World
from affectsim_data.observations.bodies import BodyPath, body_path
from affectsim_data.observations.orbit import MARGIN_M, free_distance, relative_camera
from affectsim_data.poses import (
    FloatArray,
    compose_pose,
    invert_pose,
    matrix_quaternion,
    quaternion_slerp,
    transform_points,
)
from affectsim_data.visibility import BodySamples, RayCaster, body_samples, visible_share

__all__ = ["PRef", "ReferenceSearch", "interpolate_knots", "plan_reference"]

_KNOT_FPS = 5.0
_SCORED_INSTANTS = 10


@dataclasses.dataclass(frozen=True)
class PRef:
    """P-Ref: the trajectory stored with the episode, by `plan_reference`."""

    name: str = "p_ref"

    def trajectory(self, episode: Episode, world: World, time_s: FloatArray) -> CameraTrajectory:
        """Poses between the stored knots, cyclic."""
        knots = episode.reference.knots
        return CameraTrajectory(interpolate_knots(knots, time_s / episode.duration_s))


def interpolate_knots(knots: FloatArray, cycles: FloatArray) -> FloatArray:
    """Poses `(n, 4, 4)` along closed knots `(k, 7)` (position, quaternion) at `(n,)` cycles."""
    place = np.mod(cycles, 1.0) * len(knots)
    before = np.floor(place).astype(np.intp) % len(knots)
    after, share = (before + 1) % len(knots), place - np.floor(place)
    position = knots[before, :3] + share[:, None] * (knots[after, :3] - knots[before, :3])
    rotation = quaternion_slerp(knots[before, 3:], knots[after, 3:], share)
    return compose_pose(rotation, position)


@dataclasses.dataclass(frozen=True)
class ReferenceSearch:
    """Candidates and weights of the search for the reference view; a recipe may change them."""

    azimuths_deg: tuple[float, ...] = (
        *(0.0, 15.0, -15.0, 30.0, -30.0, 45.0, -45.0, 60.0, -60.0),
        *(90.0, -90.0, 120.0, -120.0, 150.0, -150.0, 180.0),
    )
    """Sides of the body, 0 in front. Ties go to the earlier one."""
    distances_m: tuple[float, ...] = (1.7, 2.0, 2.3, 2.7)
    """Horizontal distances to the body centre."""
    heights_m: tuple[float, ...] = (1.2, 1.5)
    """Camera heights above the performer's floor."""
    preferred_distance_m: float = 2.1
    """A standing body fills about 70 % of a 60 degree image from here."""
    body_share: float = 0.72
    """Share of the image height a body should fill."""
    clearance_m: float = 0.5
    """Free space around the camera that counts as full clearance."""
    weight_visibility: float = 0.35
    weight_alignment: float = 0.25
    weight_distance_fit: float = 0.10
    weight_framing: float = 0.20
    weight_clearance: float = 0.10


@dataclasses.dataclass(frozen=True)
class _Candidates:
    """Relative camera poses under test, `(k,)` each, over the scored instants."""

    azimuth: FloatArray
    distance_m: FloatArray
    height_m: FloatArray
    poses: FloatArray
    """`(num_instants, k, 4, 4)`."""
    reachable: FloatArray
    """1 where nothing stands between the body's axis and the camera, `(num_instants, k)`."""


def plan_reference(
    world: World, caster: RayCaster, *, search: ReferenceSearch | None = None
) -> tuple[ReferenceView, float]:
    """The best relative view of the target, kept as it moves, and its visible share.

    Every candidate of azimuth, distance and height is scored at instants spread over the cycle, all
    in one batch of rays; the score is a weighted sum of visible body share, alignment with the
    facing, distance, framing and clearance. The winner follows the smoothed body path, pulled in
    where a wall is nearer than the asked distance.
    """
    options = search or ReferenceSearch()
    path = body_path(world.target)
    instants = np.arange(_SCORED_INSTANTS) * path.duration_s / _SCORED_INSTANTS
    samples = body_samples(world, instants)
    floor_y = float(world.target.T_world_performance[1, 3])
    candidates = _candidates(options, *path.at(instants), floor_y, caster)
    parts = _score_parts(options, world, samples, candidates, caster)
    total = sum(getattr(options, f"weight_{name}") * part for name, part in parts.items())
    best = int(np.argmax(np.round(total, 9)))

    knots = _follow(path, caster, candidates, best, floor_y)
    view = ReferenceView(
        azimuth=float(candidates.azimuth[best]),
        distance_m=float(candidates.distance_m[best]),
        height_m=float(candidates.height_m[best]),
        score=float(total[best]),
        parts={name: float(part[best]) for name, part in parts.items()},
        knots=knots,
    )
    poses = interpolate_knots(knots, instants / path.duration_s)
    share = visible_share(samples, poses[:, None], world.camera, caster)
    return view, float(share.visible.mean())


def _candidates(
    options: ReferenceSearch,
    center: FloatArray,
    heading: FloatArray,
    floor_y: float,
    caster: RayCaster,
) -> _Candidates:
    grid = np.array(
        list(itertools.product(options.azimuths_deg, options.distances_m, options.heights_m))
    )
    azimuth, distance_m, height_m = np.radians(grid[:, 0]), grid[:, 1], grid[:, 2]
    poses = relative_camera(
        center[:, None],
        heading[:, None],
        azimuth=azimuth,
        distance_m=distance_m,
        eye_y=floor_y + height_m,
    )
    axis = np.broadcast_to(center[:, None], poses[..., :3, 3].shape).copy()
    axis[..., 1] = floor_y + height_m
    way = poses[..., :3, 3] - axis
    free = caster.distance(axis, way / np.linalg.norm(way, axis=-1, keepdims=True))
    reachable = (free > distance_m + MARGIN_M).astype(np.float64)
    return _Candidates(azimuth, distance_m, height_m, poses, reachable)


def _score_parts(
    options: ReferenceSearch,
    world: World,
    samples: BodySamples,
    candidates: _Candidates,
    caster: RayCaster,
) -> dict[str, FloatArray]:
    """The five parts, each in [0, 1] and averaged over the cycle, `(k,)`."""
    shares = visible_share(samples, candidates.poses, world.camera, caster)
    points_camera = transform_points(invert_pose(candidates.poses), samples.points[:, None])
    pixels, _ = world.camera.project(points_camera)
    filled = np.ptp(np.nan_to_num(pixels[..., 1]), axis=-1) / world.camera.height
    framing = shares.in_image * np.exp(-(((filled - options.body_share) / 0.25) ** 2))
    off = (candidates.distance_m - options.preferred_distance_m) / 0.8
    clearance = _clearance(options, candidates.poses[..., :3, 3], caster)
    return {
        "visibility": (shares.visible * candidates.reachable).mean(axis=0),
        "alignment": (1.0 + np.cos(candidates.azimuth)) / 2.0,
        "distance_fit": np.exp(-(off**2)),
        "framing": framing.mean(axis=0),
        "clearance": (clearance * candidates.reachable).mean(axis=0),
    }


_DIRECTIONS = np.array(
    [d for d in itertools.product((-1.0, 0.0, 1.0), repeat=3) if any(d)], np.float64
)
_DIRECTIONS /= np.linalg.norm(_DIRECTIONS, axis=1, keepdims=True)


def _clearance(options: ReferenceSearch, eyes: FloatArray, caster: RayCaster) -> FloatArray:
    """Distance to the nearest surface in 26 directions over the wanted one, capped, `(...)`."""
    free = caster.distance(eyes[..., None, :], _DIRECTIONS, limit=options.clearance_m)
    nearest: FloatArray = np.minimum(free.min(axis=-1), options.clearance_m) / options.clearance_m
    return nearest


def _follow(
    path: BodyPath, caster: RayCaster, candidates: _Candidates, best: int, floor_y: float
) -> FloatArray:
    """Knots `(n, 7)` of the winner over the whole cycle, kept out of walls."""
    count = max(4, round(path.duration_s * _KNOT_FPS))
    center, heading = path.at(np.arange(count) * path.duration_s / count)
    azimuth, height = candidates.azimuth[best], candidates.height_m[best]
    free = free_distance(center, heading + azimuth, eye_y=floor_y + height, caster=caster)
    distance = np.minimum(free, candidates.distance_m[best])
    # A camera that is pulled in starts before the wall and lets go after it.
    near = np.minimum(distance, np.minimum(np.roll(distance, 1), np.roll(distance, -1)))
    smooth = np.minimum(distance, (near + np.roll(near, 1) + np.roll(near, -1)) / 3.0)
    poses = relative_camera(
        center, heading, azimuth=azimuth, distance_m=smooth, eye_y=floor_y + height
    )
    return np.concatenate([poses[:, :3, 3], matrix_quaternion(poses[:, :3, :3])], axis=1)
