"""Turns on foot: somebody who walked off turns round in real steps and walks back.

The feet that end one pass take four to seven steps to where the next pass has them, each lifted,
swung and put down flat, while pelvis and heading go over smoothly. Pose and speed of every joint
go on at both ends; legs reach for the feet by inverse kinematics.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from affectsim_data.motions.easing import (
    coasting,
    numbers_between,
    rotation_vector,
    rotations_between,
    smooth_step,
)
from affectsim_data.motions.planting import (
    ANKLES,
    TOE_REST_M,
    TOES,
    Stance,
    find_stances,
)
from affectsim_data.motions.stepping import FootEnd, StepPlan, heading, step_feet
from affectsim_data.poses import (
    FloatArray,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    standard_quaternion,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY

__all__ = ["turn_back", "walk_home"]

_STEP_S = (0.40, 0.50)
_USUAL_STEP_S = 0.45
_LEFT_LEAST, _BEHIND_LEAST = 0.5, 0.3
"""Least share of a step for a foot that the pass leaves in the air, because it must get elsewhere,
and for one that the next pass has in the air."""
_HARDLY_SWUNG = 0.25
"""A foot that the next pass has swung less than that makes no step of the turn."""
_STILL_M_S, _LOW_M = 0.3, 0.02
"""A foot slower than that and lower above a standing one carries the body at the end of a pass."""
_SHORT_STRIDE_M = 0.3
"""Least distance between ankles in a stride by which the progress of a swing is judged."""
_TURN_PER_STEP, _WAY_PER_STEP_M = np.deg2rad(50.0), 0.4
_COAST_S, _SETTLE_S = 0.6, 0.5
"""How long the speeds of the root and of the joints take to die away."""
_LANE_M = 0.25
"""How far beside the way out the way back is."""


@dataclasses.dataclass(frozen=True)
class _Walker:
    """What the turn must know of a pass."""

    last: FootEnd
    first: FootEnd
    facing: float
    """Heading at the end of the pass, radians."""
    turned: float
    """Heading at its beginning less that."""
    step_s: float
    reach_m: float
    """How far one ankle gets ahead of the other."""
    fps: float

    @classmethod
    def of(cls, root: FloatArray, local: FloatArray, fps: float) -> _Walker:
        """Of a pass of `(num_frames, 3)` and `(num_frames, 22, 4)`."""
        positions, world = BODY.forward_kinematics(root, local)
        stances = find_stances(positions[:, TOES], fps)
        last = _end(positions, world, stances, fps, frame=-1)
        first = _end(positions, world, stances, fps, frame=0)
        start, facing = heading(local[[0, -1], 0]).tolist()
        step_s, reach_m = _step_duration(stances, fps), _reach(positions, local)
        return cls(last, first, facing, start - facing, step_s, reach_m, fps)

    def swung(self, end: FootEnd) -> float:
        """How much of its swing the foot that is in the air has behind it; 1 if both stand."""
        if all(end.planted):
            return 1.0
        foot = _swinging(end, behind=False)
        passed = float(end.forward[foot] - end.forward[1 - foot]) / self.reach_m
        return float(np.clip(0.5 + 0.5 * passed, 0.0, 1.0))


def turn_back(
    root_translation: FloatArray, joint_rotations: FloatArray, *, fps: float
) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]:
    """The turn that follows a pass, and the pass on its way back.

    The way back is the pass turned by half a circle about +Y, begun 0.25 m beside where it ended,
    so that the same turn, turned likewise, leads from its end to the first pass again.

    Args:
        root_translation: Of the pass, metres, `(num_frames >= 3, 3)`.
        joint_rotations: Of the pass, `(num_frames, 22, 4)`.
        fps: Frames per second.

    Returns:
        Root translations and joint rotations of the turn, and of the way back.
    """
    walker = _Walker.of(root_translation, joint_rotations, fps)
    side, angle, order = _plan(walker, walker.turned + np.pi)
    place = _beside(root_translation, walker.facing, side, angle)
    half = yaw_quaternion(np.pi)
    turned = joint_rotations.copy()
    turned[:, 0] = quaternion_multiply(half, joint_rotations[:, 0])
    way_back = quaternion_rotate(half, root_translation - root_translation[0]) + place
    back = way_back, standard_quaternion(turned)
    after = _moved(walker.first, root_translation[0], place)
    return _walked((root_translation, joint_rotations), walker, back, after, angle, order), back


def walk_home(
    root_translation: FloatArray, joint_rotations: FloatArray, *, fps: float
) -> tuple[FloatArray, FloatArray]:
    """The steps that lead from the end of a pass to its own beginning, `turn_back`'s arguments."""
    walker = _Walker.of(root_translation, joint_rotations, fps)
    way = float(np.hypot(*(root_translation[0] - root_translation[-1])[[0, 2]]))
    _, angle, order = _plan(walker, walker.turned, way_m=way)
    whole = root_translation, joint_rotations
    return _walked(whole, walker, whole, walker.first, angle, order)


def _end(
    positions: FloatArray, world: FloatArray, stances: list[Stance], fps: float, *, frame: int
) -> FootEnd:
    toes, feet = positions[:, TOES], world[:, ANKLES]
    at, before, after = (-1, -2, -1) if frame else (0, 0, 1)
    edge = len(toes) - 1 if frame else 0
    planted = np.array(
        [any(s.foot == f and s.start - 1 <= edge < s.stop + 1 for s in stances) for f in (0, 1)]
    )
    velocities = (toes[after] - toes[before]) * fps
    still = np.linalg.norm(velocities, axis=-1) < _STILL_M_S
    planted = still & (toes[at, :, 1] < TOE_REST_M + _LOW_M) | planted
    step = quaternion_multiply(feet[after], quaternion_conjugate(feet[before]))
    forward = quaternion_rotate(yaw_quaternion(heading(world[at, 0])), [0.0, 0.0, 1.0])
    ahead = (positions[at, ANKLES] - positions[at, 0]) @ forward
    velocities = np.where(planted[:, None], 0.0, velocities)
    spins = rotation_vector(step) * fps
    return FootEnd(
        *(toes[at], feet[at], velocities, spins), (bool(planted[0]), bool(planted[1])), ahead
    )


def _moved(end: FootEnd, origin: FloatArray, place: FloatArray) -> FootEnd:
    """Feet of a pass turned by half a circle, whose root goes from `origin` to `place`."""
    half = yaw_quaternion(np.pi)
    return dataclasses.replace(
        end,
        toes=quaternion_rotate(half, end.toes - origin) + place,
        rotations=quaternion_multiply(half, end.rotations),
        velocities=quaternion_rotate(half, end.velocities),
        spins=quaternion_rotate(half, end.spins),
    )


def _plan(
    walker: _Walker, turn_left: float, *, way_m: float = 0.0
) -> tuple[float, float, list[int]]:
    """Side of the turn (1 left, -1 right), its angle, and which foot steps when.

    Args:
        walker: Who turns.
        turn_left: From the heading at the end to that of the next beginning, radians.
        way_m: How far away that is.
    """
    opener = _swinging(walker.last, behind=True)
    closer = _swinging(walker.first, behind=False)
    angle = math.remainder(turn_left, 2.0 * np.pi)
    side = 1.0 if angle > 0.0 else -1.0
    if abs(angle) > np.deg2rad(140.0):
        # Either way round is as short: the foot in the air opens the turn to its own side.
        side = 1.0 if opener == 0 else -1.0
        angle = side * (abs(angle) if angle * side > 0.0 else 2.0 * np.pi - abs(angle))
    count = max(2, math.ceil(abs(angle) / _TURN_PER_STEP), math.ceil(way_m / _WAY_PER_STEP_M))
    count += walker.swung(walker.first) < _HARDLY_SWUNG  # a step that turns nobody
    if (opener == closer) != (count % 2 == 1):
        count += 1
    return side, angle, [(opener + step) % 2 for step in range(count)]


def _swinging(end: FootEnd, *, behind: bool) -> int:
    """The foot that is in the air, or leaves the floor next (`behind`) or landed last."""
    if end.planted[0] != end.planted[1]:
        return int(end.planted[0])
    return int(np.argmin(end.forward) if behind else np.argmax(end.forward))


def _step_duration(stances: list[Stance], fps: float) -> float:
    """Time from one landing to the next in seconds, a little hurried, as people turn."""
    landings = np.diff([stance.start for stance in stances if stance.start > 0]) / fps
    steps = landings[(landings > 0.2) & (landings < 1.0)]
    usual = 0.9 * float(np.median(steps)) if len(steps) else _USUAL_STEP_S
    return float(np.clip(usual, *_STEP_S))


def _reach(positions: FloatArray, local: FloatArray) -> float:
    """How far one ankle gets ahead of the other in a pass, metres."""
    forward = quaternion_rotate(yaw_quaternion(heading(local[:, 0])), [0.0, 0.0, 1.0])
    apart = positions[:, ANKLES[0]] - positions[:, ANKLES[1]]
    ahead = np.abs(np.sum(apart * forward, axis=-1))
    return max(float(np.percentile(ahead, 95.0)), _SHORT_STRIDE_M)


def _beside(root: FloatArray, facing: float, side: float, angle: float) -> FloatArray:
    """Where the way back begins: beside where the pass ended, at the height of its beginning."""
    lane = side * _LANE_M * 0.5 * (1.0 - math.cos(angle))
    place: FloatArray = root[-1] + quaternion_rotate(yaw_quaternion(facing), [lane, 0.0, 0.0])
    place[1] = root[0, 1]
    return place


def _walked(
    before: tuple[FloatArray, FloatArray],
    walker: _Walker,
    following: tuple[FloatArray, FloatArray],
    after: FootEnd,
    angle: float,
    order: list[int],
) -> tuple[FloatArray, FloatArray]:
    """Root translations and joint rotations between two passes, in steps."""
    weights = np.ones(len(order))
    if not all(walker.last.planted):
        weights[0] = max(1.0 - walker.swung(walker.last), _LEFT_LEAST)
    swung = walker.swung(after)
    weights[-1] = max(swung, _BEHIND_LEAST)
    fps = walker.fps
    count = round(float(weights.sum()) * walker.step_s * fps)
    edges = np.concatenate([[0.0], np.cumsum(weights)]) * ((count + 1) / fps / weights.sum())
    base = _body(*before, *following, fps=fps, count=count, angle=angle)
    plan = StepPlan(order, edges, peeling=float(smooth_step(np.maximum(1.0 - 2.0 * swung, 0.0))))
    return step_feet(base, walker.last, after, plan, fps)


def _body(
    root: FloatArray,
    local: FloatArray,
    next_root: FloatArray,
    next_local: FloatArray,
    *,
    fps: float,
    count: int,
    angle: float,
) -> tuple[FloatArray, FloatArray]:
    """Root and joints of the turn, feet not yet in place."""
    time_s = np.arange(1, count + 1) / fps
    whole_s = (count + 1) / fps
    share, left_s = smooth_step(time_s / whole_s), whole_s - time_s
    leaving = root[-1] + coasting(time_s, _COAST_S)[:, None] * (root[-1] - root[-2]) * fps
    coming = (
        next_root[0] - coasting(left_s, _COAST_S)[:, None] * (next_root[1] - next_root[0]) * fps
    )
    between = leaving + share[:, None] * (coming - leaving)
    between[:, 1] = numbers_between(
        root[-2:, 1], next_root[:2, 1], time_s, left_s, fps=fps, settle_s=_SETTLE_S
    )
    yaw, next_yaw = (np.unwrap(heading(q)) for q in (local[-2:, 0], next_local[:2, 0]))
    goal = yaw[-1] + angle
    turn = numbers_between(
        yaw, next_yaw - next_yaw[0] + goal, time_s, left_s, fps=fps, settle_s=_SETTLE_S
    )
    ends = []
    for rotations, yaws in ((local[-2:], yaw), (next_local[:2], next_yaw)):
        upright = rotations.copy()
        upright[:, 0] = quaternion_multiply(yaw_quaternion(-yaws), rotations[:, 0])
        ends.append(upright)
    turned = rotations_between(ends[0], ends[1], time_s, left_s, fps=fps, settle_s=_SETTLE_S)
    turned[:, 0] = quaternion_multiply(yaw_quaternion(turn), turned[:, 0])
    return between, standard_quaternion(turned)
