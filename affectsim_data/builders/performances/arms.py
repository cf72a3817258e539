"""Where hands go: places in the air and on one's own body, and the way from one to the next."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Literal

import numpy as np

from affectsim_data.builders.performances.curves import follow, keyframes
from affectsim_data.builders.performances.rig import (
    SIDES,
    SIGN,
    BodyTrack,
    Contact,
    body_frames,
    clear_of_trunk,
)
from affectsim_data.builders.performances.styles import Side
from affectsim_data.poses import FloatArray, quaternion_conjugate, quaternion_rotate, yaw_quaternion
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["Anchor", "ArmKey", "Place", "Vector", "hold_clear", "move_arm", "reach_for"]

Vector = tuple[float, float, float]
Anchor = Literal["shoulder", "chest", "belly", "head", "thigh", "seat", "floor"]
_JOINTS = {"chest": "spine3", "belly": "spine1", "head": "head", "seat": "pelvis"}
_BELLY_M = 0.145
"""From the axis of the trunk to a wrist before it."""
_EASY_REACH_M = (0.48, 0.06)
"""Up to here wrists go where they should; the rest is the most that stretching adds."""
_ELBOW_ASIDE, _ELBOW_NATURE = 0.4, 1.2
_THIGH_M = 0.105
"""From the axis of a thigh to a wrist whose hand lies on it."""


@dataclasses.dataclass(frozen=True)
class Place:
    """Where a wrist can be, for the arm of either side."""

    anchor: Anchor
    """`shoulder` and `seat` (the pelvis) keep level and turn about the vertical only; `chest`,
    `belly` and `head` tip with their part; `thigh` is the own one; `floor` is where the
    performance starts and does not move."""
    offset: Vector
    """Out, up and forward from the anchor, metres; on a thigh, up is off it, forward along it."""
    pole: Vector = (0.5, -0.5, -1.0)
    """Which way the elbow sticks out: out, up, forward."""
    palm_deg: float = 0.0
    """Turn of the hand, thumb outward."""
    bend_deg: float = 0.0
    """Hand bent at the wrist towards the palm."""


ArmKey = tuple[float, Place]
"""A phase of the cycle, and where the wrist is then."""


def move_arm(
    track: BodyTrack, side: Side, keys: Sequence[ArmKey], *, phase: FloatArray, hz: float
) -> None:
    """Takes a wrist from place to place through a cycle; the body must be in the track already.

    Args:
        track: Changed in place: contact, elbow, palm and bend of the arm.
        side: Which arm.
        keys: Phases in rising order.
        phase: Of each frame, rising from 0 to below 1, `(n,)`.
        hz: How promptly the arm follows.
    """
    one_hot = np.eye(len(keys))
    mixed = keyframes(phase, [(at, one_hot[index]) for index, (at, _) in enumerate(keys)])
    share = follow(mixed, hz=hz)
    frames = body_frames(track)
    places = [_world(track, side, place, frames) for _, place in keys]
    target = np.einsum("nk,kni->ni", share, np.stack(places))
    track.wrists[side] = np.zeros_like(target)
    target = _within_reach(_clear(target, frames), side, frames)
    track.contacts[side] = Contact(target, np.ones(len(phase)))
    poles = share @ np.array([place.pole for _, place in keys])
    track.elbows[side] = _supple(track, side, poles, frames)
    track.palms[side] = share @ np.deg2rad([place.palm_deg for _, place in keys])
    track.wrist_bends[side] = share @ np.deg2rad([place.bend_deg for _, place in keys])


def hold_clear(track: BodyTrack, side: Side) -> None:
    """Holds a wrist where `BodyTrack.wrists` has it, but out of trunk and thighs."""
    frames = body_frames(track)
    world, positions = frames
    level = _level(world[:, JOINT_NAMES.index("spine3")])
    offset = quaternion_rotate(level, track.wrists[side] * [SIGN[side], 1.0, 1.0])
    target = positions[:, JOINT_NAMES.index(f"{side}_shoulder")] + offset
    track.contacts[side] = Contact(_clear(target, frames), np.ones(len(target)))


def reach_for(track: BodyTrack, side: Side, place: Place, share: FloatArray) -> None:
    """Draws a wrist to one place, as far as `share` `(n,)` says, away from where it was held."""
    frames = body_frames(track)
    part = share[:, None]
    before = track.contacts[side].position
    position = before + part * (_world(track, side, place, frames) - before)
    track.contacts[side] = Contact(_clear(position, frames), np.ones_like(share))
    track.elbows[side] = (1.0 - part) * track.elbows[side] + part * np.array(place.pole)
    palm = np.deg2rad(place.palm_deg)
    track.palms[side] = (1.0 - share) * track.palms[side] + share * palm
    bend = track.wrist_bends.get(side, np.zeros_like(share))
    track.wrist_bends[side] = (1.0 - share) * bend + share * np.deg2rad(place.bend_deg)


def _within_reach(
    target: FloatArray, side: Side, frames: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Targets drawn in so far that the arm never snaps straight, `(n, 3)`."""
    shoulder = frames[1][:, JOINT_NAMES.index(f"{side}_shoulder")]
    away = target - shoulder
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    easy, spare = _EASY_REACH_M
    soft = easy + spare * np.tanh((distance - easy) / spare)
    near: FloatArray = shoulder + away * np.where(distance > easy, soft / distance, 1.0)
    return near


def _supple(
    track: BodyTrack, side: Side, poles: FloatArray, frames: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """Elbow directions that never meet the arm's own, where an elbow would flip over, `(n, 3)`.

    To what was asked for they add where an elbow is by itself: behind an arm that hangs, below one
    that points, before one that is raised, and always a little outward.
    """
    world, positions = frames
    reach = track.contacts[side].position - positions[:, JOINT_NAMES.index(f"{side}_shoulder")]
    level = quaternion_conjugate(_level(world[:, JOINT_NAMES.index("spine3")]))
    along = quaternion_rotate(level, reach) / np.linalg.norm(reach, axis=1, keepdims=True)
    aside = np.full(len(along), _ELBOW_ASIDE)
    natural = np.stack([aside, -along[:, 2], along[:, 1]], axis=1)
    asked = poles / np.linalg.norm(poles, axis=1, keepdims=True)
    supple: FloatArray = asked + _ELBOW_NATURE * natural
    return supple


def _world(
    track: BodyTrack, side: Side, place: Place, frames: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """The place in the world, `(n, 3)`."""
    world, positions = frames
    out, up, forward = place.offset
    out *= SIGN[side]
    if place.anchor == "floor":
        return np.tile([out, up, forward], (len(world), 1))
    if place.anchor == "thigh":
        joint = JOINT_NAMES.index(f"{side}_hip")
        offset = quaternion_rotate(world[:, joint], [out, -forward, up])
    elif place.anchor == "shoulder":
        joint = JOINT_NAMES.index(f"{side}_shoulder")
        offset = quaternion_rotate(
            _level(world[:, JOINT_NAMES.index("spine3")]), [out, up, forward]
        )
    else:
        joint = JOINT_NAMES.index(_JOINTS[place.anchor])
        turn = world[:, joint] if place.anchor != "seat" else _level(world[:, joint])
        offset = quaternion_rotate(turn, [out, up, forward])
    placed: FloatArray = positions[:, joint] + offset
    return placed


def _level(rotation: FloatArray) -> FloatArray:
    """The turn about the vertical of a rotation, `(n, 4)`."""
    forward = quaternion_rotate(rotation, [0.0, 0.0, 1.0])
    return yaw_quaternion(np.arctan2(forward[:, 0], forward[:, 2]))


def _clear(target: FloatArray, frames: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Wrist targets moved out of trunk and thighs."""
    world, positions = frames
    target = clear_of_trunk(target, world[:, JOINT_NAMES.index("spine3")], positions)
    for start, end, radius in (
        ("pelvis", "spine3", _BELLY_M),
        *((f"{side}_hip", f"{side}_knee", _THIGH_M) for side in SIDES),
    ):
        first, last = (positions[:, JOINT_NAMES.index(name)] for name in (start, end))
        bone = last - first
        along = ((target - first) * bone).sum(axis=1) / (bone**2).sum(axis=1)
        nearest = first + np.clip(along, 0.0, 1.0)[:, None] * bone
        away = target - nearest
        distance = np.linalg.norm(away, axis=1)
        push = np.maximum(radius / np.maximum(distance, 1e-3), 1.0)
        target = nearest + push[:, None] * away
    return target
