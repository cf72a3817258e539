"""Feet that stand still: finds when a foot is planted, and keeps it there on another body.

A body of other proportions swings its planted feet about by millimetres to centimetres. A planted
foot is locked at the ball, where it stays longest; between stances the correction blends over, so
that the swing keeps its shape. Hip and knee give way (`inverse_kinematics`), feet keep their turn,
and the pelvis sinks only where a leg would be too short.
"""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, label, maximum_filter1d

from affectsim_data.motions.easing import smooth_step
from affectsim_data.motions.reaching import hinged, reach_further, turn_between, unit, yaw_of
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    standard_quaternion,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = [
    "ANKLES",
    "HIPS",
    "LEG_M",
    "TOES",
    "TOE_OFFSET",
    "TOE_REST_M",
    "Stance",
    "eased",
    "edge_window",
    "find_stances",
    "foot_shifts",
    "move_feet",
    "plant_feet",
    "stance_slides",
]


def _columns(part: str) -> list[int]:
    return [JOINT_NAMES.index(f"{side}_{part}") for side in ("left", "right")]


HIPS, _KNEES, ANKLES, TOES = (_columns(part) for part in ("hip", "knee", "ankle", "foot"))
TOE_OFFSET: FloatArray = BODY.joint_offsets[TOES[0]]
"""Ball of the foot from its ankle, metres, `(3,)`; the same on both sides."""
TOE_REST_M = float(BODY.rest_positions[TOES[0], 1])
"""Height of the ball of a foot that stands on the floor."""
_THIGH_M, _SHANK_M = (float(-BODY.joint_offsets[joints[0], 1]) for joints in (_KNEES, ANKLES))
LEG_M = _THIGH_M + _SHANK_M
_REACH_M = 0.999 * LEG_M

# Of the ball of the foot: where both first limits hold a stance is certain, and it lasts as long
# as the second ones hold. Walking mocap stands below 0.1 m/s and swings at 1 to 5 m/s.
_SPEED_M_S = (0.12, 0.20)
_HEIGHT_M = (0.04, 0.06)
_SETTLED_M = (0.004, 0.007)
"""Above its usual height in a stance: a ball lower than the first is down, above the second up."""
_SMOOTH_S = 0.02
_SHORTEST_S, _GAP_S = 0.1, 0.07
_MOST_TRAVEL_M = 0.04
"""A foot that gets further than this in one stance is dragged or pivots: it is not locked."""
_MOST_SHIFT_M = 0.06
"""Nor is one that would have to be moved further."""
_UNEVEN_M = 0.005
"""A foot this far off the floor stays: to correct it would bend a straight knee by ten degrees."""
_HEEL_SINES = (0.15, 0.5)
"""Of the slope by which a foot is steeper than when flat: heel down, and heel up for certain."""
_SINK_S = 0.1


@dataclasses.dataclass(frozen=True)
class Stance:
    """One foot planted from one frame to another."""

    foot: int
    """0 left, 1 right."""
    start: int
    """First frame."""
    stop: int
    """Frame after the last."""


def find_stances(toes: FloatArray, fps: float) -> list[Stance]:
    """When each foot is planted, by speed and height of its ball, with hysteresis; in time order.

    Args:
        toes: Balls of the left and the right foot, metres on a person of the canonical body's
            size, +Y up, `(num_frames, 2, 3)`; only heights relative to the lowest stance matter.
        fps: Frames per second.
    """
    smooth = gaussian_filter1d(toes, _SMOOTH_S * fps, axis=0, mode="nearest")
    speed = np.linalg.norm(np.gradient(smooth, axis=0), axis=-1) * fps
    slow = speed < _SPEED_M_S[1]
    if not slow.any():
        return []
    height = smooth[..., 1] - np.percentile(smooth[..., 1][slow], 10.0)
    sure = (speed < _SPEED_M_S[0]) & (height < _HEIGHT_M[0])
    stances = []
    for foot in (0, 1):
        near = slow[:, foot] & (height[:, foot] < _HEIGHT_M[1])
        for start, stop in _runs(_bridged(near, toes[:, foot], fps), sure[:, foot]):
            if _travel(toes[start:stop, foot]) < _MOST_TRAVEL_M:
                stances.append(Stance(foot, start, stop))
                continue
            still = sure[start:stop, foot]
            stances += [
                Stance(foot, start + first, start + last)
                for first, last in _runs(still, still)
                if _travel(toes[start + first : start + last, foot]) < _MOST_TRAVEL_M
            ]
    shortest = _SHORTEST_S * fps
    settled = [part for stance in stances for part in _settled(stance, sure, smooth)]
    found = [stance for stance in settled if stance.stop - stance.start >= shortest]
    return sorted(found, key=lambda stance: (stance.start, stance.foot))


def stance_slides(toes: FloatArray, stances: Sequence[Stance]) -> FloatArray:
    """How far apart on the floor a foot's ball gets while it is planted, metres, `(num_stances,)`.

    Args:
        toes: Balls of both feet, metres, `(num_frames, 2, 3)`.
        stances: When they are planted.
    """
    return np.array([_travel(toes[s.start : s.stop, s.foot]) for s in stances])


def plant_feet(
    root_translation: FloatArray,
    joint_rotations: FloatArray,
    stances: Sequence[Stance],
    *,
    fps: float,
) -> tuple[FloatArray, FloatArray]:
    """The motion with its feet on the floor, and still, in their stances.

    Above the pelvis nothing turns. Stances that would move a foot by more than 6 cm are left as
    they are, and so is a motion without stances.

    Args:
        root_translation: Of the canonical body on the floor, metres, `(num_frames, 3)`.
        joint_rotations: `(num_frames, 22, 4)`.
        stances: Of the source.
        fps: Frames per second.
    """
    positions, world = BODY.forward_kinematics(root_translation, joint_rotations)
    shifts = foot_shifts(positions[:, TOES], stances)
    if not shifts.any():
        return root_translation, joint_rotations
    ankles, feet = _roll(positions, world[:, ANKLES], shifts)
    planted = np.zeros((len(positions), 2), bool)
    for stance in stances:
        planted[stance.start : stance.stop, stance.foot] = True
    return move_feet(*(root_translation, joint_rotations, ankles, feet), planted, fps=fps)


def foot_shifts(toes: FloatArray, stances: Sequence[Stance]) -> FloatArray:
    """How far each foot is to be moved to stand still in its stances, metres, `(num_frames, 2, 3)`.

    Args:
        toes: Balls of both feet, metres, floor at 0, `(num_frames, 2, 3)`.
        stances: When they are planted.
    """
    count = len(toes)
    shifts = np.zeros((count, 2, 3))
    for foot in (0, 1):
        kept: list[tuple[int, int, FloatArray]] = []
        for stance in stances:
            if stance.foot != foot:
                continue
            where = toes[stance.start : stance.stop, foot]
            anchor = np.median(where, axis=0)
            anchor[1] = TOE_REST_M + np.clip(anchor[1] - TOE_REST_M, -_UNEVEN_M, _UNEVEN_M)
            if np.abs(anchor - where).max() < _MOST_SHIFT_M:
                kept.append((stance.start, stance.stop, anchor - where))
        _fill(shifts[:, foot], kept)
    return shifts


def move_feet(
    root_translation: FloatArray,
    joint_rotations: FloatArray,
    ankles: FloatArray,
    feet: FloatArray,
    planted: NDArray[np.bool_],
    *,
    fps: float,
    fade: bool = False,
) -> tuple[FloatArray, FloatArray]:
    """The motion with its ankles where they should be; knees keep to the side they bend to.

    Args:
        root_translation: Metres, `(num_frames, 3)`.
        joint_rotations: `(num_frames, 22, 4)`.
        ankles: Left and right, metres, `(num_frames, 2, 3)`.
        feet: World rotations of the feet, `(num_frames, 2, 4)`.
        planted: Feet for which the pelvis sinks if a leg is too short; others fall short,
            `(num_frames, 2)`.
        fps: Frames per second.
        fade: The legs have far to go, but at both ends they and the pelvis are to be left alone,
            because other frames follow there.
    """
    positions, world = BODY.forward_kinematics(root_translation, joint_rotations)
    need = planted * _lack(positions[:, HIPS], ankles, positions[:, ANKLES])
    sink = eased(need.max(axis=1), fps)
    forward = np.zeros((len(sink), 2, 3))
    if fade:
        window = edge_window(len(sink), fps)
        sink = sink * window
        # Of a foot that points down only its yaw says where ahead is.
        level = yaw_quaternion(yaw_of(np.concatenate([world[:, [0, 0]], feet], axis=1)))
        ahead = quaternion_rotate(level, [0.0, 0.0, 1.0])
        ahead = ahead[:, :2] + ahead[:, 2:]
        forward = window[:, None, None] * ahead
    same = (ankles == positions[:, ANKLES]).all(axis=(1, 2))
    moved = ~(same & (feet == world[:, ANKLES]).all(axis=(1, 2)) & (sink == 0.0))
    root, local = root_translation.copy(), joint_rotations.copy()
    root[:, 1] -= sink
    positions, world = positions[moved], world[moved]
    hips, knees = positions[:, HIPS], positions[:, _KNEES]
    target = ankles[moved] - hips + sink[moved, None, None] * np.array([0.0, 1.0, 0.0])
    thighs, shanks = reach_further(
        (hips, knees, positions[:, ANKLES]),
        target,
        quaternion_rotate(world[:, HIPS], [0.0, 0.0, 1.0]),
        (_THIGH_M, _SHANK_M),
        forward=forward[moved],
    )
    thigh = quaternion_multiply(thighs, world[:, HIPS])
    shank = quaternion_multiply(shanks, world[:, _KNEES])
    if fade:
        thigh = hinged(thigh, shank, window[moved])
    above = np.stack([np.repeat(world[:, :1], 2, axis=1), thigh, shank])
    legs = quaternion_multiply(quaternion_conjugate(above), np.stack([thigh, shank, feet[moved]]))
    for joints, rotations in zip((HIPS, _KNEES, ANKLES), standard_quaternion(legs), strict=True):
        local[np.flatnonzero(moved)[:, None], joints] = rotations
    return root, local


def _roll(
    positions: FloatArray, feet: FloatArray, shifts: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Ankles `(n, 2, 3)` and rotations of feet `(n, 2, 4)` with the balls of the feet shifted.

    A foot with its heel down goes as it is. With its heel up it turns about its ball, to leave the
    ankle where it is: feet are longer or shorter than the source's, and legs should not mind.
    """
    ankles, toes = positions[:, ANKLES], positions[:, TOES] + shifts
    length = float(np.linalg.norm(TOE_OFFSET))
    rest_sine = -TOE_OFFSET[1] / length
    steep = (ankles[..., 1] - positions[:, TOES, 1]) / length - rest_sine
    low, high = _HEEL_SINES
    share = np.clip((steep - low) / (high - low), 0.0, 1.0)
    share = np.where(shifts.any(axis=-1), smooth_step(share), 0.0)[..., None]
    old = positions[:, TOES] - ankles
    new = length * unit(toes - ankles - (1.0 - share) * shifts)
    turned = share > 0.0
    rolled = standard_quaternion(quaternion_multiply(turn_between(unit(old), unit(new)), feet))
    ankles = np.where(turned, toes - new, ankles + shifts)
    return ankles, np.where(turned, rolled, feet)


def _lack(hips: FloatArray, ankles: FloatArray, before: FloatArray) -> FloatArray:
    """How far hips must go down for legs to reach, metres, `(num_frames, 2)`."""
    way = hips - ankles
    # A leg that was straighter than that already may stay so: it is not pulled at.
    reach = np.maximum(_REACH_M, np.linalg.norm(hips - before, axis=-1))
    flat = np.minimum(np.linalg.norm(way[..., [0, 2]], axis=-1), reach)
    need = np.maximum(way[..., 1] - np.sqrt(reach**2 - flat**2), 0.0)
    return np.where(need < 1e-6, 0.0, need)


def eased(need: FloatArray, fps: float) -> FloatArray:
    """A smooth curve that is hardly anywhere below `need`, `(num_frames,)`."""
    if not need.any():
        return need
    reaching = maximum_filter1d(need, 2 * round(_SINK_S * fps) + 1, mode="nearest")
    spread = 0.5 * _SINK_S * fps
    smooth: FloatArray = gaussian_filter1d(reaching, spread, mode="nearest", truncate=2.0)
    return smooth


def edge_window(num_frames: int, fps: float) -> FloatArray:
    """1 but for a fifth of a second at both ends, where it falls to nearly 0, `(num_frames,)`."""
    inner = np.minimum(np.arange(1, num_frames + 1), np.arange(num_frames, 0, -1))
    return smooth_step(np.minimum(inner / (2.0 * _SINK_S * fps), 1.0))


def _fill(shifts: FloatArray, kept: Sequence[tuple[int, int, FloatArray]]) -> None:
    """Writes the shifts of one foot `(num_frames, 3)`: those of its stances, blended between."""
    if not kept:
        return
    for start, stop, shift in kept:
        shifts[start:stop] = shift
    for (_, stop, before), (start, _, after) in itertools.pairwise(kept):
        _blend(shifts, np.arange(stop, start), before[-1], after[0])
    (first, _, opening), (_, last, closing) = kept[0], kept[-1]
    shifts[:first], shifts[last:] = opening[0], closing[-1]


def _blend(
    shifts: FloatArray, frames: NDArray[np.intp], before: FloatArray, after: FloatArray
) -> None:
    share = smooth_step(np.arange(1, len(frames) + 1)[:, None] / (len(frames) + 1.0))
    shifts[frames] = before + share * (after - before)


def _settled(stance: Stance, sure: NDArray[np.bool_], toes: FloatArray) -> list[Stance]:
    """The parts of a stance in which the ball of the foot is down, without its landing and peeling.

    Between parts the weight is on the heel, or the foot makes a small step.
    """
    height = toes[stance.start : stance.stop, stance.foot, 1]
    height = height - np.median(height)
    steady = sure[stance.start : stance.stop, stance.foot] & (height < _SETTLED_M[0])
    parts = []
    for start, stop in _runs(height < _SETTLED_M[1], steady):
        down = start + np.flatnonzero(steady[start:stop])
        first, last = int(down[0]), int(down[-1])
        parts.append(Stance(stance.foot, stance.start + first, stance.start + last + 1))
    return parts


def _bridged(near: NDArray[np.bool_], toe: FloatArray, fps: float) -> NDArray[np.bool_]:
    """`near` with gaps closed that are too short for a step and in which the foot stays."""
    bridged = near.copy()
    for start, stop in _runs(~near, ~near):
        inside = start > 0 and stop < len(near)
        if inside and stop - start <= _GAP_S * fps and _travel(toe[start - 1 : stop + 1]) < 0.01:
            bridged[start:stop] = True
    return bridged


def _runs(mask: NDArray[np.bool_], seeds: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Half-open runs of `mask` that hold at least one of `seeds`, both `(num_frames,)`."""
    labels, found = label(mask)
    seeded = np.bincount(labels[seeds & mask], minlength=found + 1) > 0
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    runs = edges.reshape(-1, 2).tolist()
    return [(start, stop) for number, (start, stop) in enumerate(runs, 1) if seeded[number]]


def _travel(places: FloatArray) -> float:
    """Diagonal of the box on the floor that holds points `(n, 3)`, metres."""
    return float(np.hypot(*np.ptp(places[:, [0, 2]], axis=0)))
