"""Where the person stands and where the robot starts: candidates by the hundred, then measured.

A placement is made for one performer and action under *all* emotions at once and kept only if it
holds for every one of them, so that nothing but the motion depends on the emotion.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.affordances import fits, rooms_of
from affectsim_data.builders.measuring import Performance, Shares, measure_shares
from affectsim_data.builders.monitors import Monitor, plan_monitor
from affectsim_data.builders.recipes import Recipe, Thresholds
from affectsim_data.builders.slots import Slot, slot_seed
from affectsim_data.navmesh import NavMesh
from affectsim_data.observations import head_camera_pose
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import FloatArray, compose_pose, transform_points, yaw_quaternion
from affectsim_data.releases.rows import navmesh_sha256
from affectsim_data.scenes import Scene
from affectsim_data.schemas import Challenge
from affectsim_data.visibility import RayCaster, scene_caster

__all__ = ["Placement", "Stage", "Unplaced", "find_placements"]

SEAT_HEIGHT_M = 0.45
"""Of the seat that seated motions of the canonical body are made for."""
_ANCHORS, _STARTS, _MEASURED, _DETOURS = 96, 96, 32, 24
_PERSON_CLEARANCE_M = 0.12
"""Free floor around a pelvis beyond the robot radius that the navmesh already keeps."""
_LEG_HEIGHT_M = 0.4
_START_JITTER_DEG = 8.0
_ROUNDS = 4


@dataclasses.dataclass(frozen=True)
class Stage:
    """A scene made ready for composing: its rays, navmesh and monitors."""

    scene: Scene
    navmesh: NavMesh
    caster: RayCaster
    monitors: dict[str, Monitor]
    """By room."""
    navmesh_sha256: str
    """Hash of the navmesh's bytes."""

    @classmethod
    def prepare(cls, scene: Scene, navmesh: NavMesh, recipe: Recipe) -> Stage:
        """Rays and monitors of a scene."""
        caster = scene_caster(scene)
        monitors = {room.room_id: plan_monitor(room, recipe.camera, caster) for room in scene.rooms}
        return cls(scene, navmesh, caster, monitors, navmesh_sha256(navmesh))

    @classmethod
    def stored(cls, scene_id: str, glb: bytes, navmesh: bytes, recipe: Recipe) -> Stage:
        """The same of a scene as a release stores it."""
        scene = Scene.from_glb(glb, name=scene_id)
        return cls.prepare(scene, NavMesh.from_bytes(navmesh, name=scene_id), recipe)


@dataclasses.dataclass(frozen=True)
class Placement:
    """p_h and x0 in a scene."""

    anchor: FloatArray
    """`(3,)`, metres."""
    facing: float
    """Radians."""
    start: FloatArray
    """`(3,)`, metres."""
    start_yaw: float
    """Radians."""
    room_id: str
    """The performer's room."""
    support: str | None = None
    """Seat or door the action is aligned with, as `Episode.support`."""


@dataclasses.dataclass(frozen=True)
class Unplaced:
    """A slot without a placement in a scene."""

    key: str
    """Of the slot."""
    constraint: str
    """The constraint at which the last candidates were lost."""
    survivors: Mapping[str, int]
    """Candidates left after each constraint, in order."""


def find_placements(
    stage: Stage, slots: Sequence[Slot], performances: Mapping[str, Performance], recipe: Recipe
) -> list[Placement | Unplaced]:
    """For each slot a placement that holds for all its motions, or why there is none."""
    found: list[Placement | Unplaced] = []
    for slot in slots:
        members = [performances[motion_id] for motion_id in slot.motion_ids]
        rng = np.random.default_rng(slot_seed(recipe.seed, slot))
        placement = find_placement(stage, slot, members, recipe, rng=rng)
        found.append(placement or Unplaced(slot.key, "candidates", {}))
    return found


def find_placement(
    stage: Stage,
    slot: Slot,
    performances: list[Performance],
    recipe: Recipe,
    *,
    rng: np.random.Generator,
) -> Placement | None:
    """A placement that holds for every performance, or `None` if no candidate does."""
    challenge = slot.challenge
    for _ in range(_ROUNDS):
        anchors, facings = _anchors(stage, slot, performances, rng)
        if not len(anchors):
            continue
        candidates = _pair_up(stage, challenge, anchors, facings, performances, recipe, rng)
        for index in _holding(stage, challenge, candidates, performances, recipe):
            placement = candidates.placement(int(index), stage)
            if placement is not None:
                return placement
    return None


@dataclasses.dataclass(frozen=True)
class _Candidates:
    """Pairs of anchor and start, `(k, ...)` each."""

    anchor: FloatArray
    facing: FloatArray
    start: FloatArray
    start_yaw: FloatArray

    def placement(self, index: int, stage: Stage) -> Placement | None:
        room = int(rooms_of(stage.scene, self.anchor[index]))
        if room < 0:
            return None
        return Placement(
            anchor=self.anchor[index],
            facing=float(self.facing[index]),
            start=self.start[index],
            start_yaw=float(self.start_yaw[index]),
            room_id=stage.scene.rooms[room].room_id,
        )


def _anchors(
    stage: Stage,
    slot: Slot,
    performances: list[Performance],
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """Places `(n, 3)` and facings `(n,)` where every performance has the room it needs."""
    if slot.placement == "seat":
        seats = stage.scene.seats
        order = rng.permutation(len(seats))
        positions = np.array([seats[i].position for i in order], np.float64).reshape(-1, 3)
        # All members share the performer's body, so the first one speaks for all.
        positions[:, 1] -= SEAT_HEIGHT_M * performances[0].avatar.motion_scale
        return positions, np.radians([seats[i].yaw_deg for i in order])
    anchors = stage.navmesh.random_points(_ANCHORS, rng, island=0)
    facings = rng.uniform(-math.pi, math.pi, len(anchors))
    poses = compose_pose(yaw_quaternion(facings), anchors)
    free = np.ones(len(anchors), bool)
    radius_m = stage.navmesh.settings.agent_radius + _PERSON_CLEARANCE_M
    for performance in performances:
        feet = transform_points(poses, performance.footprint())
        fitting = fits(stage.navmesh, feet.reshape(-1, 3), radius_m=radius_m)
        free &= fitting.reshape(len(feet), -1).all(axis=1)
    return anchors[free], facings[free]


def _pair_up(
    stage: Stage,
    challenge: Challenge | None,
    anchors: FloatArray,
    facings: FloatArray,
    performances: list[Performance],
    recipe: Recipe,
    rng: np.random.Generator,
) -> _Candidates:
    """Anchors with starts whose distance, side and room suit the challenge, in random order."""
    starts = stage.navmesh.random_points(_STARTS, rng, island=0)
    first, second = (grid.ravel() for grid in np.indices((len(anchors), len(starts))))
    way = starts[second] - anchors[first]
    distance = np.linalg.norm(way, axis=1)
    off = np.abs(_wrapped(np.arctan2(way[:, 0], way[:, 2]) - facings[first]))
    suits = _suits(challenge, distance, np.degrees(off), recipe.thresholds)
    if challenge is None:
        rooms = rooms_of(stage.scene, anchors)[first], rooms_of(stage.scene, starts)
        suits &= rooms[0] == rooms[1][second]
    if challenge == "obstacle_detour":
        lift = np.array([0.0, _LEG_HEIGHT_M, 0.0])
        blocked = stage.caster.hidden(starts[second] + lift, anchors[first] + lift)
        suits &= blocked
    chosen = rng.permutation(np.flatnonzero(suits))[:_MEASURED]
    way, first, second = way[chosen], first[chosen], second[chosen]
    # A robot at yaw 0 looks along -Z; it looks at the person, give or take.
    jitter = np.radians(rng.uniform(-_START_JITTER_DEG, _START_JITTER_DEG, len(chosen)))
    start_yaw = _wrapped(np.arctan2(way[:, 0], way[:, 2]) + jitter)
    return _Candidates(anchors[first], facings[first], starts[second], start_yaw)


def _suits(
    challenge: Challenge | None, distance: FloatArray, off_deg: FloatArray, limits: Thresholds
) -> np.ndarray:
    near = (distance >= limits.near_m) & (distance <= limits.far_m)
    if challenge == "far_visible":
        return distance >= limits.far_distance_m
    if challenge == "rear_view":
        return near & (off_deg >= limits.rear_bearing_deg)
    if challenge == "obstacle_detour":
        return distance >= limits.near_m + 0.5
    return near


def _holding(
    stage: Stage,
    challenge: Challenge | None,
    candidates: _Candidates,
    performances: list[Performance],
    recipe: Recipe,
) -> np.ndarray:
    """Indices of candidates for which the challenge holds with every performance."""
    if not len(candidates.anchor):
        return np.zeros(0, np.intp)
    limits = recipe.thresholds
    if challenge == "obstacle_detour":
        return _detours(stage, candidates, limits)
    shares = measure_shares(
        performances,
        compose_pose(yaw_quaternion(candidates.facing), candidates.anchor),
        head_camera_pose(candidates.start, candidates.start_yaw, recipe.robot),
        scene=stage.scene,
        camera=recipe.camera,
        robot=recipe.robot,
        caster=stage.caster,
    )
    holds = _visibility_holds(challenge, shares, limits)
    if challenge == "rear_view":
        for performance in performances:
            holds &= _stays_turned_away(performance, candidates, limits)
    return np.flatnonzero(holds)


def _visibility_holds(
    challenge: Challenge | None, shares: Shares, limits: Thresholds
) -> np.ndarray:
    if challenge == "partial_occlusion":
        return (
            (shares.visible_low >= limits.occluded_low)
            & (shares.visible_high <= limits.occluded_high)
            & (shares.in_image_low >= limits.in_image)
        )
    least = limits.grounded_visible if challenge is None else limits.visible
    return shares.visible_low >= least


def _stays_turned_away(
    performance: Performance, candidates: _Candidates, limits: Thresholds
) -> np.ndarray:
    """Whether the mean bearing over the cycle still is a rear view."""
    path = body_path(performance.people(np.eye(4))[0])
    mean_heading = float(np.angle(np.exp(1j * path.heading).mean()))
    way = candidates.start - candidates.anchor
    bearing = np.arctan2(way[:, 0], way[:, 2]) - candidates.facing - mean_heading
    return np.abs(_wrapped(bearing)) >= math.radians(limits.rear_bearing_deg)


def _detours(stage: Stage, candidates: _Candidates, limits: Thresholds) -> np.ndarray:
    """Candidates whose way to the 1 m ring is blocked and long enough a detour."""
    found = []
    for index in range(min(len(candidates.anchor), _DETOURS)):
        start, anchor = candidates.start[index], candidates.anchor[index]
        geodesic = stage.navmesh.ring_distance(start, anchor, 1.0)
        straight = float(np.linalg.norm(start - anchor)) - 1.1
        if math.isfinite(geodesic) and geodesic >= limits.detour_ratio * straight > 0.0:
            found.append(index)
    return np.array(found, np.intp)


def _wrapped(angle: FloatArray) -> FloatArray:
    wrapped: FloatArray = np.angle(np.exp(1j * angle))
    return wrapped
