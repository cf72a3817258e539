"""Procedural performances: the built-in people, who act emotions without any recorded data.

Style follows measured kinematics (`styles`), movement is built from periodic curves (`curves`) and
inverse kinematics (`rig`), so cycles close exactly. They are meant to be told apart by eye and to
exercise every part of the pipeline; they are no substitute for recorded people.
"""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from affectsim_data.builders.performances.rig import BodyTrack, solve_body
from affectsim_data.builders.performances.standing import (
    gesture_track,
    knock_track,
    listening_track,
    seated_track,
    sit_down_track,
)
from affectsim_data.builders.performances.styles import Performer, performer
from affectsim_data.builders.performances.walking import FPS, walk_track
from affectsim_data.motions.motion import Emotion, Motion

__all__ = ["PERFORMANCE_ACTIONS", "PerformanceAction", "Performer", "perform", "perform_pair"]

PerformanceAction = Literal["simple_walk", "sit_down", "being_seated", "knock_door", "free_gesture"]
PERFORMANCE_ACTIONS: tuple[PerformanceAction, ...] = get_args(PerformanceAction)

_SOURCE = "procedural performance"
_LICENCE = "CC0-1.0"
_SHORT = {
    "simple_walk": "walk",
    "sit_down": "sitdown",
    "being_seated": "seated",
    "knock_door": "knock",
    "free_gesture": "gesture",
}
_TRACKS = {
    "simple_walk": walk_track,
    "sit_down": sit_down_track,
    "being_seated": seated_track,
    "knock_door": knock_track,
    "free_gesture": gesture_track,
}


def perform(
    action: PerformanceAction,
    emotion: Emotion,
    performer_id: str,
    *,
    rng: np.random.Generator,
    collection: str = "mini",
) -> Motion:
    """One cycle of an action in an emotion by a performer, 30 fps, without a seam.

    A walk goes round an oval beside its start, to the side of the preferred hand. Who sits has the
    pelvis over the origin and the seat, 0.45 m high, below; who sits down does so 0.40 m behind
    it. Who knocks has the door 0.65 m ahead.

    Args:
        action: What is done.
        emotion: What is felt.
        performer_id: Who performs; traits are drawn from the id alone.
        rng: Noise of this take.
        collection: First part of the motion id.

    Raises:
        ValueError: Not one of `PERFORMANCE_ACTIONS`.
    """
    if action not in _TRACKS:
        raise ValueError(f"action must be one of {', '.join(PERFORMANCE_ACTIONS)}, got {action!r}")
    motion_id = f"{collection}/{_SHORT[action]}_{emotion}_{performer_id}"
    track = _TRACKS[action](emotion, performer(performer_id), rng=rng)
    return _motion(track, motion_id, performer_id, emotion, action, group_id=motion_id)


def perform_pair(
    emotion: Emotion,
    performer_ids: tuple[str, str],
    *,
    rng: np.random.Generator,
    collection: str = "mini",
) -> tuple[Motion, Motion]:
    """Two people in conversation: the first expresses the emotion, the second listens, neutral.

    Both have the same number of frames and the same group; to be placed facing each other, 1.1 to
    1.4 m apart.

    Raises:
        ValueError: Both are the same person.
    """
    first, second = performer_ids
    if first == second:
        raise ValueError(f"a conversation needs two performers, got {first!r} twice")
    group_id = f"{collection}/conversation_{emotion}_{first}_{second}"
    speaking = gesture_track(emotion, performer(first), rng=rng, size=0.9)
    frames = len(speaking.pelvis_position)
    listening = listening_track(frames, performer(second), rng=rng)
    return (
        _motion(speaking, f"{group_id}_{first}", first, emotion, "conversation", group_id=group_id),
        _motion(
            listening, f"{group_id}_{second}", second, "neutral", "conversation", group_id=group_id
        ),
    )


def _motion(
    track: BodyTrack,
    motion_id: str,
    performer_id: str,
    emotion: Emotion,
    action: str,
    *,
    group_id: str,
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
        source=_SOURCE,
        licence=_LICENCE,
    )
