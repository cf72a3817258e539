"""Composes the episodes of one scene: placements found, then measured under every emotion."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from weakref import WeakKeyDictionary

import numpy as np

import affectsim_data
from affectsim_data.builders.measuring import Measures, Performance, measure_performance
from affectsim_data.builders.monitors import Monitor
from affectsim_data.builders.placement import Placement, Stage, Unplaced, find_placements
from affectsim_data.builders.recipes import Recipe
from affectsim_data.builders.slots import Slot, slot_seed
from affectsim_data.episodes import (
    RING_DISTANCES_M,
    Episode,
    Participant,
    Person,
)
from affectsim_data.observations import head_camera_pose, monitor_pose
from affectsim_data.observations.reference import ReferencePlanner
from affectsim_data.observations.tracks import body_track
from affectsim_data.poses import FloatArray, compose_pose, yaw_quaternion
from affectsim_data.schemas import Split
from affectsim_data.visibility import visible_share

__all__ = ["SceneEpisodes", "SceneWork", "compose_scene"]


@dataclasses.dataclass(frozen=True)
class SceneWork:
    """Slots to be placed in one scene."""

    scene_id: str
    scene_split: Split
    glb: bytes
    """The scene as the release stores it."""
    navmesh: bytes
    """Its navmesh as the release stores it."""
    slots: tuple[Slot, ...]


@dataclasses.dataclass(frozen=True)
class SceneEpisodes:
    """What became of them."""

    scene_id: str
    episodes: tuple[Episode, ...]
    """Named by their slot and emotion; numbered when all scenes are done."""
    unplaced: tuple[Unplaced, ...]
    """Slots without a placement here, and why."""


def compose_scene(
    work: SceneWork, performances: Mapping[str, Performance], recipe: Recipe
) -> SceneEpisodes:
    """Places slots in a scene and measures an episode for each of their motions.

    The outcome depends on the recipe, the scene and each slot alone, not on what else is placed.

    Args:
        work: The scene and its slots.
        performances: By the target's motion.
        recipe: Thresholds, camera, seed.
    """
    stage = Stage.stored(work.scene_id, work.glb, work.navmesh, recipe)
    placements = find_placements(stage, work.slots, performances, recipe)
    episodes: list[Episode] = []
    unplaced: list[Unplaced] = []
    for slot, placement in zip(work.slots, placements, strict=True):
        if isinstance(placement, Unplaced):
            unplaced.append(placement)
            continue
        setting = _Setting.of(slot, placement, stage, recipe)
        phases = np.random.default_rng([*slot_seed(recipe.seed, slot), 1]).random(
            len(slot.motion_ids)
        )
        episodes += [
            _episode(setting, performances[one], float(phase), stage, recipe, work)
            for one, phase in zip(slot.motion_ids, phases, strict=True)
        ]
    return SceneEpisodes(work.scene_id, tuple(episodes), tuple(unplaced))


@dataclasses.dataclass(frozen=True)
class _Setting:
    """What all episodes of a slot share."""

    slot: Slot
    placement: Placement
    T_world_performance: FloatArray
    """`(4, 4)`."""
    T_world_camera: FloatArray
    """Head camera at the start, and monitor, `(2, 4, 4)`."""
    monitor: Monitor
    d_star: Mapping[int, float | str]

    @classmethod
    def of(cls, slot: Slot, placement: Placement, stage: Stage, recipe: Recipe) -> _Setting:
        monitor = stage.monitors[placement.room_id]
        place = compose_pose(yaw_quaternion(placement.facing), placement.anchor)
        start = head_camera_pose(placement.start, np.array(placement.start_yaw), recipe.robot)
        above = monitor_pose(
            np.array(monitor.position), np.array(monitor.yaw), np.array(monitor.pitch)
        )
        cameras = np.stack([start, above])
        return cls(slot, placement, place, cameras, monitor, _d_star(stage, placement))


def _episode(
    setting: _Setting,
    performance: Performance,
    phase: float,
    stage: Stage,
    recipe: Recipe,
    work: SceneWork,
) -> Episode:
    slot, placement, monitor = setting.slot, setting.placement, setting.monitor
    motion = performance.motion
    people = performance.people(setting.T_world_performance)
    measures = measure_performance(performance)
    planner = _planner_of(performance, measures, recipe)
    reference, share_ref = planner.plan(setting.T_world_performance, stage.caster)
    shares = visible_share(
        measures.samples.placed(setting.T_world_performance),
        setting.T_world_camera[None],
        recipe.camera,
        stage.caster,
    )
    share_init, share_mon = (float(share) for share in shares.visible.mean(axis=0))
    participants = [_participant(person) for person in people]
    grounded = slot.family == "action_grounded"
    return Episode(
        episode_id=f"{slot.key}/{motion.emotion}",
        split=slot.split,
        scene_split=work.scene_split,
        group_id=motion.performer_id if grounded else motion.group_id,
        placement_id=slot.key,
        family=slot.family,
        challenge=slot.challenge,
        action=motion.action,
        emotion=motion.emotion,
        scene_id=stage.scene.scene_id,
        target=participants[0],
        support=placement.support,
        partner=participants[1] if len(participants) > 1 else None,
        target_index=0,
        start_position=_tuple(placement.start),
        start_yaw=placement.start_yaw,
        phase_s=phase * motion.duration_s,
        duration_s=motion.duration_s,
        monitor_position=monitor.position,
        monitor_yaw=monitor.yaw,
        monitor_pitch=monitor.pitch,
        reference=reference,
        d_star=setting.d_star,
        navmesh_sha256=stage.navmesh_sha256,
        agent_radius_m=recipe.robot.radius_m,
        initial_bearing=_bearing(measures.mean_heading, placement),
        visible_share_init=share_init,
        visible_share_ref=share_ref,
        visible_share_mon=share_mon,
        source=motion.source,
        recipe=recipe.name,
        seed=recipe.seed,
        code_version=affectsim_data.__version__,
    )


_planners: WeakKeyDictionary[Measures, tuple[Recipe, ReferencePlanner]] = WeakKeyDictionary()
"""Of the performances whose measures are kept."""


def _planner_of(performance: Performance, measures: Measures, recipe: Recipe) -> ReferencePlanner:
    """What plans reference views of a performance, made when it is first placed."""
    known = _planners.get(measures)
    if known is None or known[0] is not recipe:
        track = body_track(performance.people(np.eye(4)), samples=measures.samples)
        known = recipe, ReferencePlanner(track, recipe.camera, recipe.reference)
        _planners[measures] = known
    return known[1]


def _d_star(stage: Stage, placement: Placement) -> dict[int, float | str]:
    distances: dict[int, float | str] = {}
    for ring in RING_DISTANCES_M:
        value = float(stage.navmesh.ring_distance(placement.start, placement.anchor, float(ring)))
        distances[ring] = value
        if math.isnan(value):
            distances[ring] = "empty"
        elif math.isinf(value):
            distances[ring] = "unreachable"
    return distances


def _bearing(mean_heading: float, placement: Placement) -> float:
    """Start seen from the target, off its mean facing, radians in (-pi, pi]."""
    x, _, z = placement.start - placement.anchor
    return math.remainder(math.atan2(x, z) - placement.facing - mean_heading, math.tau)


def _participant(person: Person) -> Participant:
    pose = person.T_world_performance
    motion = person.motion
    return Participant(
        motion_id=motion.motion_id,
        performer_id=motion.performer_id,
        avatar_id=person.avatar.avatar_id,
        anchor=_tuple(pose[:3, 3]),
        facing=math.atan2(pose[0, 2], pose[2, 2]),
    )


def _tuple(point: FloatArray) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in point)
    return (x, y, z)
