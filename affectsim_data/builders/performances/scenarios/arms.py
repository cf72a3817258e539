"""Paths of arms through poses on moving landmarks."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from affectsim_data.builders.performances.rig import SIGN
from affectsim_data.builders.performances.scenarios.vocabulary import (
    HANGING,
    Anchor,
    ArmKey,
    ArmPose,
)
from affectsim_data.builders.performances.styles import Performer, Side
from affectsim_data.poses import FloatArray, quaternion_conjugate, quaternion_rotate

__all__ = ["ArmPath", "Landmark", "arm_path", "key_weights"]

_HAND_LAG_S = 0.06
"""Hands turn a little after the arm has begun to move."""
_KEY_SCATTER_M = 0.012
"""How far a free gesture misses its place from take to take."""
_FOREARM_M = 0.25
_EASY_M, _FARTHEST_M = 0.50, 0.545
"""Wrists come this near, and not nearer, to the 0.55 m of a straight arm."""
_FOLDED_M = 0.21
"""Least distance of a wrist from its shoulder."""
_SKULL_M = np.array([0.0, 0.07, 0.02])
"""Middle of the skull from the head joint."""
_HEAD_ROOM_M = 0.155
"""Least distance of a wrist from there."""


@dataclasses.dataclass(frozen=True)
class Landmark:
    """A moving frame: positions `(n, 3)` and rotations `(n, 4)` in the world."""

    position: FloatArray
    rotation: FloatArray


@dataclasses.dataclass(frozen=True)
class ArmPath:
    """Curves of one arm as `BodyTrack` wants them; angles in radians."""

    wrist: FloatArray
    """`(n, 3)`."""
    elbow: FloatArray
    """`(n, 3)`."""
    palm: FloatArray
    """`(n,)`."""
    bend: FloatArray
    """`(n,)`."""


def key_weights(
    time_s: FloatArray, keys_s: FloatArray, places: FloatArray, period_s: float
) -> FloatArray:
    """Shares of the keys of a cycle at each instant, `(n, num_keys)`; every row sums to 1.

    Cubic Hermite curves that are linear in the keys, so the keys may move meanwhile. A key is
    passed at speed where the path goes on in the same direction, and is a stop where the path
    turns back or rests (`places` say which).

    Args:
        time_s: Instants, `(n,)`, within the cycle.
        keys_s: Times of the keys, ascending, `(num_keys,)`.
        places: Where the keys are, for the directions alone, `(num_keys, 3)`.
        period_s: Length of the cycle.
    """
    count = len(keys_s)
    if count == 1:
        return np.ones((len(time_s), 1))
    following = np.roll(np.arange(count), -1)
    gap = np.mod(keys_s[following] - keys_s, period_s)
    way = (places[following] - places) / gap[:, None]
    speed = np.linalg.norm(way, axis=1)
    before, speed_before = np.roll(way, 1, axis=0), np.roll(speed, 1)
    product = np.maximum((way * before).sum(axis=1), 0.0)
    flow = product / np.maximum(speed * speed_before, 1e-9)
    flow *= np.minimum(speed, speed_before) / np.maximum(speed + speed_before, 1e-9)
    slopes = np.zeros((count, count))
    own = np.arange(count)
    gap_before = np.roll(gap, 1)
    np.add.at(slopes, (own, np.roll(own, 1)), -flow / gap_before)
    np.add.at(slopes, (own, own), flow / gap_before - flow / gap)
    np.add.at(slopes, (own, following), flow / gap)
    at = (np.searchsorted(keys_s, np.mod(time_s, period_s), side="right") - 1) % count
    share = np.mod(time_s - keys_s[at], period_s) / gap[at]
    square, cube = share**2, share**3
    weights = np.zeros((len(time_s), count))
    rows = np.arange(len(time_s))
    weights[rows, at] += 2.0 * cube - 3.0 * square + 1.0
    weights[rows, following[at]] += 3.0 * square - 2.0 * cube
    leaving, arriving = cube - 2.0 * square + share, cube - square
    weights += (gap[at] * leaving)[:, None] * slopes[at]
    weights += (gap[at] * arriving)[:, None] * slopes[following[at]]
    return weights


def arm_path(
    keys: Sequence[ArmKey],
    time_s: FloatArray,
    period_s: float,
    side: Side,
    landmarks: Mapping[Anchor, Landmark],
    who: Performer,
    *,
    size: float,
    rng: np.random.Generator,
) -> ArmPath:
    """The way of an arm through its poses.

    Args:
        keys: Times and poses of one cycle, in any order.
        time_s: Instants, `(n,)`.
        period_s: Length of the cycle.
        side: Which arm.
        landmarks: Anchors of this arm; `shoulder` is its own, level.
        who: The performer, for habits.
        size: Factor on gestures in the air.
        rng: Scatter of this take.
    """
    ordered = sorted(keys, key=lambda key: key[0])
    times = np.array([time for time, _ in ordered])
    mirror = np.array([SIGN[side], 1.0, 1.0])
    shoulder = landmarks["shoulder"]
    places = np.zeros((len(time_s), len(ordered), 3))
    for index, (_, pose) in enumerate(ordered):
        if pose.anchor == "shoulder":
            places[:, index] = _free_place(pose, who, size, rng)
            continue
        mark = landmarks[pose.anchor]
        world = mark.position + quaternion_rotate(mark.rotation, np.array(pose.wrist) * mirror)
        level = quaternion_conjugate(shoulder.rotation)
        places[:, index] = quaternion_rotate(level, world - shoulder.position) * mirror
    weights = key_weights(time_s, times, places.mean(axis=0), period_s)
    late = key_weights(np.mod(time_s - _HAND_LAG_S, period_s), times, places.mean(axis=0), period_s)
    elbows = np.array([_elbow(pose, who) for _, pose in ordered])
    turns = np.deg2rad([(pose.palm_deg, pose.bend_deg) for _, pose in ordered])
    hands = late @ turns
    wrist = _within_reach(np.einsum("nk,nkc->nc", weights, places))
    wrist = _round_the_shoulder(wrist)
    wrist = _round_the_head(wrist * mirror, shoulder, landmarks["head"]) * mirror
    return ArmPath(wrist, weights @ elbows, hands[:, 0], hands[:, 1])


def _within_reach(wrist: FloatArray) -> FloatArray:
    """Wrists as far as an arm goes that never locks its elbow, nor snaps into it."""
    distance = np.maximum(np.linalg.norm(wrist, axis=1, keepdims=True), 1e-6)
    excess = np.maximum(distance - _EASY_M, 0.0) / (_FARTHEST_M - _EASY_M)
    reached = np.minimum(distance, _EASY_M) + (_FARTHEST_M - _EASY_M) * np.tanh(excess)
    within: FloatArray = wrist * reached / distance
    return within


def _round_the_shoulder(wrist: FloatArray) -> FloatArray:
    """Wrists on their way past the shoulder go round its front: an elbow folds only so far."""
    room = _FOLDED_M**2 - wrist[:, 0] ** 2 - wrist[:, 1] ** 2
    least = np.sqrt(np.maximum(room, 0.0))
    before = np.clip(wrist[:, 2] / 0.1, 0.0, 1.0)
    past = wrist.copy()
    past[:, 2] += before * np.maximum(least - wrist[:, 2], 0.0)
    return past


def _round_the_head(wrist: FloatArray, shoulder: Landmark, head: Landmark) -> FloatArray:
    """Wrists, from the shoulder in level axes, moved out of the head."""
    place = shoulder.position + quaternion_rotate(shoulder.rotation, wrist)
    center = head.position + quaternion_rotate(head.rotation, _SKULL_M)
    away = place - center
    distance = np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-6)
    away *= np.maximum(_HEAD_ROOM_M / distance, 1.0)
    level = quaternion_conjugate(shoulder.rotation)
    return quaternion_rotate(level, center + away - shoulder.position)


def _free_place(pose: ArmPose, who: Performer, size: float, rng: np.random.Generator) -> FloatArray:
    """A place in the air from the shoulder, larger, higher or lower with the performer, `(3,)`."""
    scatter = rng.normal(0.0, _KEY_SCATTER_M, 3)
    rest = np.array(HANGING.wrist)
    away = np.array(pose.wrist) - rest
    lifted = float(np.clip(np.linalg.norm(away) / 0.15, 0.0, 1.0))
    bend = np.deg2rad(np.maximum(who.elbow_flexion_deg, 0.0)) * (1.0 - lifted)
    habit = np.array([who.hands_out_m, who.raise_m * lifted, 0.0])
    habit[1:] += _FOREARM_M * np.array([1.0 - np.cos(bend), np.sin(bend)])
    place: FloatArray = rest + size * away + habit + scatter * (0.3 + 0.7 * lifted)
    return place


def _elbow(pose: ArmPose, who: Performer) -> FloatArray:
    if pose.elbow is not None:
        return np.array(pose.elbow)
    return np.array([0.25 + 0.5 * who.elbow_out, -0.5, -1.0])
