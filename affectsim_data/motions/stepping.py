"""Feet on their way from one place to another in steps: lifted, swung, put down flat, planted."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from affectsim_data.motions.easing import fading, rotation_vector, smooth_step, spun
from affectsim_data.motions.planting import (
    HIPS,
    LEG_M,
    TOE_OFFSET,
    TOE_REST_M,
    eased,
    edge_window,
    move_feet,
)
from affectsim_data.motions.reaching import yaw_of
from affectsim_data.poses import (
    FloatArray,
    axis_angle_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    quaternion_rotate,
    quaternion_slerp,
    yaw_quaternion,
)
from affectsim_data.skeletons import BODY

__all__ = ["FootEnd", "StepPlan", "heading", "step_feet"]

_DOUBLE_SUPPORT = 0.12
"""Share of a step in which both feet stand."""
_SWING_S = 0.25
"""How long the speed of a foot that is in the air takes to die away."""
_HALF_WIDTH_M, _TOE_OUT = 0.11, 0.12
_EASY_REACH, _HEEL_MOST = 0.985, np.deg2rad(60.0)
"""Share of a leg's length beyond which the heel of a planted foot leaves the floor, and how far."""
_ANKLE_MOST = np.deg2rad(50.0)
"""How far the foot of a straight leg is stretched at most by raising its heel."""
_PEEL_S = 0.25
"""How long the heel rises before a foot leaves the floor as the next pass has it."""
_PASSING_M, _PASSING_S = 0.19, 0.15
"""How far beside the standing foot a foot swings past, and how long it takes to get there."""
_LIFT_M, _HEEL_LIFT = 0.05, np.deg2rad(25.0)
_RISE = 0.45
"""Share of a step in which a foot gets to its height: before it gets far, it is off the floor."""
_Falls = list[tuple[FloatArray, float]]
"""Ball `(3,)` and yaw of each step's landing."""


@dataclasses.dataclass
class _Key:
    """Where one foot is at one instant of the turn."""

    time_s: float
    toe: FloatArray
    """Ball of the foot, metres, `(3,)`."""
    rotation: FloatArray
    """Of the foot in the world, `(4,)`."""
    swings: bool
    """Whether it is in the air from here to the next key."""
    velocity: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(3))
    """Of the ball, m/s."""
    spin: FloatArray = dataclasses.field(default_factory=lambda: np.zeros(3))
    """Of the foot, rotation vector in the world, rad/s."""


@dataclasses.dataclass(frozen=True)
class FootEnd:
    """Both feet at the end or the beginning of a pass; left first."""

    toes: FloatArray
    """Their balls, metres, `(2, 3)`."""
    rotations: FloatArray
    """Of the feet in the world, `(2, 4)`."""
    velocities: FloatArray
    """Of the balls, m/s, `(2, 3)`."""
    spins: FloatArray
    """Rotation vectors in the world, rad/s, `(2, 3)`."""
    planted: tuple[bool, bool]
    """Whether they stand."""
    forward: FloatArray
    """How far ahead of the pelvis each foot is, metres, `(2,)`."""

    def key(self, foot: int, time_s: float, *, swings: bool) -> _Key:
        """This end as the first or last key of a foot."""
        toe, rotation = self.toes[foot], self.rotations[foot]
        return _Key(time_s, toe, rotation, swings, self.velocities[foot], self.spins[foot])


@dataclasses.dataclass(frozen=True)
class StepPlan:
    """Which foot steps when."""

    order: list[int]
    """Foot of each step, 0 left, 1 right, one after the other."""
    edges: FloatArray
    """When steps begin and end, seconds since the end of the pass, `(num_steps + 1,)`."""
    peeling: float = 0.0
    """1 if the next pass meets the foot of the last step as it leaves the floor, 0 if later."""

    def of(self, foot: int) -> list[int]:
        """Numbers of the steps of a foot."""
        return [step for step, stepping in enumerate(self.order) if stepping == foot]

    def begin(self, step: int) -> float:
        """When the foot of a step leaves the floor: after a moment on both feet."""
        start, end = self.edges[step : step + 2]
        return float(start + _DOUBLE_SUPPORT * (end - start)) if step else 0.0


def step_feet(
    base: tuple[FloatArray, FloatArray], last: FootEnd, after: FootEnd, plan: StepPlan, fps: float
) -> tuple[FloatArray, FloatArray]:
    """A body on its way with its feet put down one after the other.

    Args:
        base: Root translations and joint rotations between two passes, feet not yet in place.
        last: Feet in the frame before.
        after: Feet in the frame that follows.
        plan: Who steps when.
        fps: Frames per second.
    """
    falls = _footfalls(base, last, after, plan, fps)
    count = len(base[0])
    toes, feet = np.zeros((count, 2, 3)), np.zeros((count, 2, 4))
    planted = np.zeros((count, 2), bool)
    time_s = np.arange(1, count + 1) / fps
    for foot in (0, 1):
        ways = _keys(foot, last, after, plan, falls)
        for start, end in itertools.pairwise(ways):
            inside = (time_s >= start.time_s) & (time_s < end.time_s + 1e-9)
            planted[inside, foot] = not start.swings
            toes[inside, foot], feet[inside, foot] = _foot_way(start, end, time_s[inside])
    toes += _detours(base, toes - 0.5 * quaternion_rotate(feet, TOE_OFFSET), planted, fps)
    feet = _heels_up(base, toes, feet, planted, fps)
    ankles = toes - quaternion_rotate(feet, TOE_OFFSET)
    return move_feet(*base, ankles, feet, planted, fps=fps, fade=True)


def heading(rotations: FloatArray) -> FloatArray:
    """Yaw of the direction rotations `(..., 4)` look along, radians, `(...)`."""
    forward = quaternion_rotate(rotations, [0.0, 0.0, 1.0])
    yaw: FloatArray = np.arctan2(forward[..., 0], forward[..., 2])
    return yaw


def _keys(foot: int, last: FootEnd, after: FootEnd, plan: StepPlan, falls: _Falls) -> list[_Key]:
    """Instants of one foot, from the end of the pass to the beginning of the next."""
    whole_s = float(plan.edges[-1])
    mine = plan.of(foot)
    begins = [plan.begin(step) for step in mine]
    if not last.planted[foot]:
        begins[0] = 0.0
    keys = [last.key(foot, 0.0, swings=begins[0] == 0.0)]
    yaw = float(yaw_of(last.rotations[foot]))
    for step, begin in zip(mine, begins, strict=True):
        if begin > 0.0:
            rotation = yaw_quaternion(yaw)
            if step == len(plan.order) - 1 and plan.peeling:
                rolls_s = max(keys[-1].time_s, begin - _PEEL_S)
                keys.append(_Key(rolls_s, keys[-1].toe, rotation, False))
                rotation = quaternion_slerp(rotation, after.rotations[foot], plan.peeling)
            keys.append(_Key(begin, keys[-1].toe, rotation, True))
        end = float(plan.edges[step + 1])
        if step == mine[-1] and (not after.planted[foot] or end >= whole_s):
            break  # it is in the air, or comes down, as the next pass begins
        toe, yaw = falls[step]
        keys.append(_Key(end, toe, yaw_quaternion(yaw), False))
    keys.append(after.key(foot, whole_s, swings=False))
    return keys


def _footfalls(
    base: tuple[FloatArray, FloatArray], last: FootEnd, after: FootEnd, plan: StepPlan, fps: float
) -> _Falls:
    """Where the ball of the foot goes in each step, and which way it points."""
    falls: _Falls = []
    places = list(last.toes)
    for step, foot in enumerate(plan.order):
        later = [other for other in plan.of(foot) if other > step]
        if later:
            instant_s = 0.5 * (float(plan.edges[step + 1]) + plan.begin(later[0]))
            toe, yaw = _footfall(base, foot, instant_s, places[1 - foot], fps)
            if later[0] == len(plan.order) - 1:
                toe = _peeled_from(toe, after, plan)
            falls.append((toe, yaw))
        else:
            falls.append((after.toes[foot], float(yaw_of(after.rotations[foot]))))
        places[foot] = falls[-1][0]
    return falls


def _footfall(
    base: tuple[FloatArray, FloatArray], foot: int, time_s: float, other: FloatArray, fps: float
) -> tuple[FloatArray, float]:
    """Under the body at an instant, and beside the other foot `(3,)`."""
    root, local = base
    frame = int(np.clip(round(time_s * fps) - 1, 0, len(root) - 1))
    yaw = float(heading(local[frame, 0]))
    side = quaternion_rotate(yaw_quaternion(yaw), [1.0 if foot == 0 else -1.0, 0.0, 0.0])
    ankle = root[frame] + _HALF_WIDTH_M * side
    yaw += _TOE_OUT if foot == 0 else -_TOE_OUT
    toe = ankle + quaternion_rotate(yaw_quaternion(yaw), TOE_OFFSET)
    toe = toe + max(_PASSING_M - float((toe - other) @ side), 0.0) * side
    toe[1] = TOE_REST_M
    return toe, yaw


def _peeled_from(toe: FloatArray, after: FootEnd, plan: StepPlan) -> FloatArray:
    """A landing `(3,)` moved to where its foot leaves the floor again as the next pass begins."""
    foot, last = plan.order[-1], len(plan.order) - 1
    swung_s = float(plan.edges[-1]) - plan.begin(last)
    left = after.toes[foot] - 0.5 * swung_s * after.velocities[foot]
    moved: FloatArray = toe + plan.peeling * (left - toe) * [1.0, 0.0, 1.0]
    return moved


def _foot_way(start: _Key, end: _Key, time_s: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Ball `(n, 3)` and rotation `(n, 4)` of a foot between two keys."""
    whole_s = max(end.time_s - start.time_s, 1e-6)
    passed_s, left_s = time_s - start.time_s, end.time_s - time_s
    share = smooth_step(np.clip(passed_s / whole_s, 0.0, 1.0))
    leaving = start.toe + fading(passed_s, _SWING_S)[:, None] * start.velocity
    coming = end.toe - fading(left_s, _SWING_S)[:, None] * end.velocity
    toe = leaving + share[:, None] * (coming - leaving)
    lifted = quaternion_multiply(spun(start.spin, fading(passed_s, _SWING_S)), start.rotation)
    landing = quaternion_multiply(spun(-end.spin, fading(left_s, _SWING_S)), end.rotation)
    rotation = _turned_over(lifted, landing, share)
    if start.swings:
        near = np.clip(np.minimum(passed_s, left_s) / (_RISE * whole_s), 0.0, 1.0)
        rises = smooth_step(near)
        # What is left of a swing, or begun of it, is too short to lift the foot first.
        high = TOE_REST_M + _LIFT_M * min(whole_s / _SWING_S, 1.0) ** 2
        toe[:, 1] += np.maximum(high - toe[:, 1], 0.0) * rises
        whole = start.velocity @ start.velocity == 0.0 and end.velocity @ end.velocity == 0.0
        heel = _HEEL_LIFT * rises * 2.0 * (1.0 - share) * whole
        pitch = axis_angle_quaternion([1.0, 0.0, 0.0], heel)
        rotation = quaternion_multiply(rotation, pitch)
    return toe, rotation


def _turned_over(start: FloatArray, end: FloatArray, share: FloatArray) -> FloatArray:
    """Rotations `(n, 4)` part of the way between two, yaw and tilt each on their own.

    The shortest way from a foot on the floor to one whose heel is high behind leads over the side.
    """
    yaws = np.stack([yaw_of(start), yaw_of(end)])
    tilts = quaternion_multiply(yaw_quaternion(-yaws), np.stack([start, end]))
    turn = np.mod(yaws[1] - yaws[0] + np.pi, 2.0 * np.pi) - np.pi
    yaw = yaw_quaternion(yaws[0] + share * turn)
    return quaternion_multiply(yaw, quaternion_slerp(tilts[0], tilts[1], share))


def _detours(
    base: tuple[FloatArray, FloatArray],
    middles: FloatArray,
    planted: NDArray[np.bool_],
    fps: float,
) -> FloatArray:
    """What swinging feet are moved outward by, to pass beside the standing foot, `(n, 2, 3)`."""
    level = yaw_quaternion(heading(base[1][:, 0]))
    left, ahead = (quaternion_rotate(level, axis) for axis in ([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]))
    apart = middles[:, 0] - middles[:, 1]
    passing = smooth_step(np.clip((0.45 - np.abs(np.sum(apart * ahead, axis=1))) / 0.2, 0.0, 1.0))
    lack = passing * np.maximum(_PASSING_M - np.sum(apart * left, axis=1), 0.0)
    detours = np.zeros(middles.shape)
    for foot, out in ((0, 1.0), (1, -1.0)):
        edges = distance_transform_edt(np.pad(~planted[:, foot], 1))[1:-1] / (_PASSING_S * fps)
        window = smooth_step(np.clip(edges, 0.0, 1.0))
        way = eased(lack * ~planted[:, foot], fps) * window
        detours[:, foot] = out * way[:, None] * left
    return detours


def _heels_up(
    base: tuple[FloatArray, FloatArray],
    toes: FloatArray,
    feet: FloatArray,
    planted: NDArray[np.bool_],
    fps: float,
) -> FloatArray:
    """Feet `(n, 2, 4)` rolled over their balls where the body has gone too far for a flat foot."""
    hips = BODY.forward_kinematics(*base)[0][:, HIPS]
    pitches = _HEEL_MOST * np.linspace(0.0, 1.0, 16)
    raised = axis_angle_quaternion([1.0, 0.0, 0.0], pitches)
    tried = quaternion_multiply(feet[:, :, None], raised)
    legs = hips[:, :, None] - toes[:, :, None] + quaternion_rotate(tried, TOE_OFFSET)
    lack = np.linalg.norm(legs, axis=-1) - _EASY_REACH * LEG_M
    # A foot before the body is not brought nearer by its heel, and an ankle bends only so far.
    level = yaw_quaternion(yaw_of(feet))
    ahead = quaternion_rotate(level, [0.0, 0.0, 1.0])[:, :, None]
    tilt = rotation_vector(quaternion_multiply(quaternion_conjugate(level), feet))[..., :1]
    stretched = tilt + pitches - np.arctan2(np.sum(legs * ahead, axis=-1), legs[..., 1])
    most = np.where((stretched < _ANKLE_MOST) | (pitches == 0.0), np.maximum(lack, 0.0), np.inf)
    enough = np.argmin(most, axis=-1)
    steps = np.stack([enough, np.maximum(enough - 1, 0)], axis=-1)
    left, over = np.moveaxis(np.take_along_axis(lack, steps, axis=-1), -1, 0)
    share = np.clip(over / np.maximum(over - left, 1e-9), 0.0, 1.0)
    need = np.maximum(enough - 1.0 + share, 0.0) * pitches[1] * planted
    tilt = tilt[..., 0]
    whole = np.where(need > 0.0, np.maximum(tilt + need, 0.0), 0.0)
    raised_by = np.stack([eased(whole[:, foot], fps) for foot in (0, 1)], axis=1) - tilt
    pitch = np.where(whole.any(axis=0), np.maximum(raised_by, 0.0), 0.0)
    pitch *= edge_window(len(pitch), fps)[:, None]
    return quaternion_multiply(feet, axis_angle_quaternion([1.0, 0.0, 0.0], pitch))
