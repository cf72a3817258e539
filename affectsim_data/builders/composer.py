"""Composes episodes: slots of one performer and action under every emotion, placed and measured."""

from __future__ import annotations

import dataclasses
import math
import zlib
from collections.abc import Sequence

import numpy as np

import affectsim_data
from affectsim_data.builders.measuring import Performance, cycle_instants
from affectsim_data.builders.placement import Placement, Stage, find_placement
from affectsim_data.builders.recipes import Composition, Recipe
from affectsim_data.episodes import (
    RING_DISTANCES_M,
    Episode,
    Participant,
    Person,
    World,
)
from affectsim_data.observations import head_camera_pose, monitor_pose, plan_reference
from affectsim_data.observations.bodies import body_path
from affectsim_data.poses import FloatArray, compose_pose, yaw_quaternion
from affectsim_data.schemas import Challenge
from affectsim_data.visibility import body_samples, visible_share

__all__ = ["Shortfall", "Slot", "compose_slot", "make_slots"]


@dataclasses.dataclass(frozen=True)
class Slot:
    """One placement to be found, and the performances that will share it."""

    key: str
    """Stable name: seeds the slot's random numbers, names it in reports; emotion-free."""
    composition: Composition
    challenge: Challenge | None
    performances: tuple[Performance, ...]
    """The same performer, action and take under each emotion; all takes of a corpus whose takes do
    not show the same emotions."""


@dataclasses.dataclass(frozen=True)
class Shortfall:
    """A slot for which no placement was found; its episodes are missing from the release."""

    key: str
    num_episodes: int


def make_slots(recipe: Recipe, performances: Sequence[Performance]) -> list[Slot]:
    """The slots a recipe asks for, in a fixed order.

    Raises:
        ValueError: A composition finds no motion for one of its actions.
    """
    groups = _groups(performances)
    slots = []
    for composition in recipe.compositions:
        for action in composition.actions:
            members = {key: group for key, group in sorted(groups.items()) if key[0] == action}
            if not members:
                have = ", ".join(sorted({key[0] for key in groups}))
                raise ValueError(
                    f"{recipe.path}: [[compose]] wants action {action!r}, but there is no motion "
                    f"of it; there is: {have}"
                )
            slots += [
                Slot(
                    "/".join((*key, challenge or composition.family, str(repeat))),
                    composition,
                    challenge,
                    tuple(group),
                )
                for key, group in members.items()
                for challenge in composition.challenges
                for repeat in range(composition.repeats)
            ]
    return slots


def _groups(performances: Sequence[Performance]) -> dict[tuple[str, ...], list[Performance]]:
    """Performances that share placements, by action, performer and, where it can be, take.

    Takes are kept apart where each of them shows the same emotions: then every placement still
    serves all emotions alike.
    """
    groups: dict[tuple[str, str], list[Performance]] = {}
    for performance in performances:
        motion = performance.motion
        groups.setdefault((motion.action, motion.performer_id), []).append(performance)
    parted: dict[tuple[str, ...], list[Performance]] = {}
    for key, members in groups.items():
        takes: dict[int, list[Performance]] = {}
        for member in members:
            takes.setdefault(member.motion.take, []).append(member)
        shown = {tuple(sorted(one.motion.emotion for one in take)) for take in takes.values()}
        if len(shown) == 1:
            parted |= {(*key, f"take{number}"): take for number, take in takes.items()}
        else:
            parted[key] = members
    return parted


def compose_slot(slot: Slot, stages: Sequence[Stage], recipe: Recipe) -> list[Episode] | Shortfall:
    """Places a slot in one of the scenes and measures an episode for each of its motions.

    Scenes are tried in a random order; the outcome depends on the recipe's seed and the slot only.
    """
    rng = np.random.default_rng([recipe.seed, zlib.crc32(slot.key.encode())])
    for index in rng.permutation(len(stages)):
        stage = stages[index]
        placement = find_placement(
            stage, slot.composition, slot.challenge, list(slot.performances), recipe, rng=rng
        )
        if placement is not None:
            phases = rng.random(len(slot.performances))
            return [
                _episode(slot, performance, placement, float(phase), stage, recipe)
                for performance, phase in zip(slot.performances, phases, strict=True)
            ]
    return Shortfall(slot.key, len(slot.performances))


def _episode(
    slot: Slot,
    performance: Performance,
    placement: Placement,
    phase: float,
    stage: Stage,
    recipe: Recipe,
) -> Episode:
    motion = performance.motion
    T_world_performance = compose_pose(yaw_quaternion(placement.facing), placement.anchor)
    people = performance.people(T_world_performance)
    world = World(stage.scene, people, recipe.camera, recipe.robot)
    reference, share_ref = plan_reference(world, stage.caster)
    monitor = stage.monitors[placement.room_id]
    start_camera = head_camera_pose(placement.start, np.array(placement.start_yaw), recipe.robot)
    monitor_camera = monitor_pose(
        np.array(monitor.position), np.array(monitor.yaw), np.array(monitor.pitch)
    )
    share_init, share_mon = _shares(world, stage, np.stack([start_camera, monitor_camera]))
    participants = [_participant(person) for person in people]
    grounded = slot.composition.family == "action_grounded"
    return Episode(
        episode_id=slot.key,
        split=recipe.split(performer_id=motion.performer_id, action=motion.action),
        group_id=motion.performer_id if grounded else motion.group_id,
        family=slot.composition.family,
        challenge=slot.challenge,
        action=motion.action,
        emotion=motion.emotion,
        scene_id=stage.scene.scene_id,
        target=participants[0],
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
        d_star=_d_star(stage, placement),
        navmesh_sha256=stage.navmesh_sha256,
        agent_radius_m=recipe.robot.radius_m,
        initial_bearing=_bearing(people[0], placement),
        visible_share_init=share_init,
        visible_share_ref=share_ref,
        visible_share_mon=share_mon,
        source=motion.source,
        recipe=recipe.name,
        seed=recipe.seed,
        code_version=affectsim_data.__version__,
    )


def _shares(world: World, stage: Stage, cameras: FloatArray) -> tuple[float, ...]:
    duration = world.target.motion.duration_s
    samples = body_samples(world, cycle_instants(duration))
    shares = visible_share(samples, cameras[None], world.camera, stage.caster)
    return tuple(float(share) for share in shares.visible.mean(axis=0))


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


def _bearing(target: Person, placement: Placement) -> float:
    """Start seen from the target, off its mean facing, radians in (-pi, pi]."""
    heading = float(np.angle(np.exp(1j * body_path(target).heading).mean()))
    x, _, z = placement.start - placement.anchor
    return math.remainder(math.atan2(x, z) - heading, math.tau)


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
