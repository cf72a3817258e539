"""Procedural performances: the built-in people, who act emotions without any recorded data.

Style follows measured kinematics (`styles`), movement is built from periodic curves (`curves`) and
inverse kinematics (`rig`), so cycles close exactly. They are meant to be told apart by eye and to
exercise every part of the pipeline; they are no substitute for recorded people.
"""

from __future__ import annotations

import dataclasses
from typing import Literal, get_args

import numpy as np

from affectsim_data.builders.performances.dyads import dyad_tracks
from affectsim_data.builders.performances.knocking import knock_track
from affectsim_data.builders.performances.rig import BodyTrack, solve_body
from affectsim_data.builders.performances.scenarios import (
    NUM_SCENARIOS,
    SCENARIOS,
    scenario_track,
)
from affectsim_data.builders.performances.scenarios.neutral import SCRIPTS as EVERYDAY_SCENARIOS
from affectsim_data.builders.performances.scenarios.staging import stage_script
from affectsim_data.builders.performances.seated import seated_track
from affectsim_data.builders.performances.sitting import sit_down_track
from affectsim_data.builders.performances.styles import (
    Expression,
    Performer,
    performer,
    take_intensity,
)
from affectsim_data.builders.performances.walking import FPS, walk_track
from affectsim_data.motions.motion import Emotion, Motion
from affectsim_data.poses import FloatArray

__all__ = [
    "PERFORMANCE_ACTIONS",
    "Dyad",
    "PerformanceAction",
    "Performer",
    "perform",
    "perform_dyad",
]

PerformanceAction = Literal["simple_walk", "sit_down", "being_seated", "knock_door", "scenario"]
PERFORMANCE_ACTIONS: tuple[PerformanceAction, ...] = get_args(PerformanceAction)

_SOURCE = "procedural performance"
_LICENCE = "CC0-1.0"
_SHORT = {
    "simple_walk": "walk",
    "sit_down": "sitdown",
    "being_seated": "seated",
    "knock_door": "knock",
    "scenario": "scenario",
}
_TRACKS = {
    "simple_walk": walk_track,
    "sit_down": sit_down_track,
    "being_seated": seated_track,
    "knock_door": knock_track,
}


@dataclasses.dataclass(frozen=True)
class Dyad:
    """Two people who act one interaction together, aligned in time and space."""

    target: Motion
    """Whose emotion counts."""
    partner: Motion
    """The other; labelled with what this one feels, as long as the target's."""
    T_target_partner: FloatArray
    """The partner's performance frame in the target's, `(4, 4)`."""


def perform(
    action: PerformanceAction,
    emotion: Emotion,
    performer_id: str,
    *,
    take: int = 0,
    rng: np.random.Generator,
    collection: str = "mini",
    reserved_takes: float = 1.0,
) -> Motion:
    """One cycle of an action in an emotion by a performer, 30 fps, without a seam.

    A walk goes round an oval beside its start, to the side of the preferred hand or, for odd
    takes, the other. Who sits has the
    pelvis over the origin and the seat, 0.45 m high, below; who sits down does so 0.40 m behind
    it. Who knocks has the door 0.65 m ahead. A scenario is a performance of five to ten seconds on
    the spot, a different one for every take.

    Args:
        action: What is done.
        emotion: What is felt; how strongly it shows is the performer's trait and this take's luck.
        performer_id: Who performs; traits are drawn from the id alone.
        take: Which repetition; part of the motion id, and of a scenario's choice.
        rng: Noise of this take.
        collection: First part of the motion id.
        reserved_takes: Factor on how often people keep a feeling to themselves; 0 for never.

    Raises:
        ValueError: Not one of `PERFORMANCE_ACTIONS`, a negative take, or a scenario's take beyond
            `NUM_SCENARIOS`.
    """
    if action not in _SHORT:
        raise ValueError(f"action must be one of {', '.join(PERFORMANCE_ACTIONS)}, got {action!r}")
    _check_take(take)
    who = performer(performer_id).feeling(emotion).today(rng)
    expression = Expression.drawn(take_intensity(who, rng, reserved_takes=reserved_takes), rng)
    name: str = action
    if action == "scenario":
        name, track = _scenario(emotion, take, who, expression, rng)
    else:
        track = _TRACKS[action](emotion, who, take=take, expression=expression, rng=rng)
    motion_id = f"{collection}/{_SHORT[action]}_{emotion}_{performer_id}{_take_suffix(take)}"
    return _motion(
        track, motion_id, performer_id, emotion, action, group_id=motion_id, name=name, take=take
    )


def perform_dyad(
    emotion: Emotion,
    performer_ids: tuple[str, str],
    *,
    take: int = 0,
    rng: np.random.Generator,
    collection: str = "mini",
    reserved_takes: float = 1.0,
) -> Dyad:
    """An interaction of two people; the first is the target and feels the emotion.

    Args:
        emotion: What the target feels.
        performer_ids: Target and partner, two people.
        take: Which of the emotion's interactions; part of the ids.
        rng: Noise of this take.
        collection: First part of the motion ids.
        reserved_takes: Factor on how often people keep a feeling to themselves; 0 for never.

    Raises:
        ValueError: Both are the same person, or there is no such take.
    """
    first, second = performer_ids
    if first == second:
        raise ValueError(f"an interaction needs two performers, got {first!r} twice")
    _check_take(take)
    who, other = performer(first).feeling(emotion).today(rng), performer(second).today(rng)
    intensity = take_intensity(who, rng, reserved_takes=reserved_takes)
    tracks = dyad_tracks(emotion, take, who, other, intensity=intensity, rng=rng)
    group_id = f"{collection}/interaction_{emotion}_{first}_{second}{_take_suffix(take)}"
    target, partner = (
        _motion(
            track,
            f"{group_id}_{who_id}",
            who_id,
            feels,
            "interaction",
            group_id=group_id,
            name=tracks.name,
            take=take,
        )
        for track, who_id, feels in (
            (tracks.target, first, emotion),
            (tracks.partner, second, tracks.partner_emotion),
        )
    )
    T_target_track, T_partner_track = _start_pose(tracks.target), _start_pose(tracks.partner)
    T_target_partner = np.linalg.inv(T_target_track) @ tracks.T_target_partner @ T_partner_track
    return Dyad(target, partner, T_target_partner)


def _scenario(
    emotion: Emotion, take: int, who: Performer, expression: Expression, rng: np.random.Generator
) -> tuple[str, BodyTrack]:
    """Name and track of a scenario; who is restrained does an everyday one, in the same manner."""
    intensity = expression.posture
    if not expression.restrained or take >= NUM_SCENARIOS:
        return scenario_track(emotion, take, who, intensity=intensity, rng=rng)
    name = SCENARIOS["neutral"][take]
    script = EVERYDAY_SCENARIOS[name]
    return name, stage_script(script, emotion, who, intensity=intensity, rng=rng)


def _check_take(take: int) -> None:
    if take < 0:
        raise ValueError(f"take must be 0 or more, got {take}")


def _take_suffix(take: int) -> str:
    return f"_{take}" if take else ""


def _start_pose(track: BodyTrack) -> FloatArray:
    """The performance frame in the frame of a track: on the floor under the first pelvis."""
    pose = np.eye(4)
    pose[[0, 2], 3] = track.pelvis_position[0, [0, 2]]
    return pose


def _motion(
    track: BodyTrack,
    motion_id: str,
    performer_id: str,
    emotion: Emotion,
    action: str,
    *,
    group_id: str,
    name: str = "",
    take: int = 0,
) -> Motion:
    root, rotations = solve_body(track)
    return Motion(
        motion_id=motion_id,
        performer_id=performer_id,
        group_id=group_id,
        emotion=emotion,
        action=action,
        fps=FPS,
        root_translation=root - root[0] * [1.0, 0.0, 1.0],
        joint_rotations=rotations,
        performance=name or action,
        take=take,
        source=_SOURCE,
        licence=_LICENCE,
    )
