"""Checks against the floor: feet that slide while they stand, parts below it, bodies above it."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from affectsim_data.builders.screening.findings import Measure, Posed, sustained
from affectsim_data.builders.screening.limits import Floating, FootSlide, GroundPenetration
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY, JOINT_NAMES

__all__ = ["floating", "foot_slide", "ground_penetration"]

_LOWEST_PERCENTILE = 5.0
_NEAR_M = 0.01
"""Beyond `height_m`, toes of a foot that carries the body may be off their lowest level."""
_SEATED_SHARE = 0.75
"""Below this share of its standing height the pelvis may rest on a chair."""
_FLOOR = [0, 2]


@dataclasses.dataclass(frozen=True)
class _Foot:
    """A foot from frame to frame; all but `ankle` and `toes` for the steps between frames."""

    ankle: FloatArray
    """On the floor plane, `(num_frames, 2)`."""
    toes: FloatArray
    down: NDArray[np.bool_]
    """Ankle and toes are near their lowest level, `(num_frames - 1,)`."""
    stands: NDArray[np.bool_]
    """The toes are near it and still: it can carry the body while the other foot steps."""
    speed: FloatArray
    """Of the slower one of ankle and toes: a foot that pivots stands."""


def foot_slide(posed: Posed, limits: FootSlide) -> Measure:
    """Farthest a foot gets over the floor within one stance, metres.

    A stance is a stretch in which a foot is down: ankle and toes are both within `height_m` of
    this foot's own lowest level; it has an instant slower than `still_m_s` (hysteresis: it may
    then get faster, as a foot that is dragged does), and ends at `step_m_s` if the other foot
    carries the body, since that is a low step, else at `swing_m_s`. What slides is the point
    that moves less, ankle or toes: who pivots on one of them does not slide.
    """
    feet = {side: _foot(posed, side, limits) for side in ("left", "right")}
    worst = Measure(0.0)
    for side, other in (("left", "right"), ("right", "left")):
        foot = feet[side]
        fastest = np.where(feet[other].stands, limits.step_m_s, limits.swing_m_s)
        planted = foot.down & (foot.speed < fastest)
        for start, end in _stretches(planted):
            if foot.speed[start:end].min() >= limits.still_m_s:
                continue
            slid = min(_spread(foot.ankle[start : end + 1]), _spread(foot.toes[start : end + 1]))
            if slid > worst.value:
                detail = (
                    f"the {side} foot moves {slid:.3f} m over the floor between "
                    f"{start / posed.fps:.2f} s and {end / posed.fps:.2f} s, where it stands"
                )
                worst = Measure(slid, start, f"{side}_foot", detail)
    return worst


def ground_penetration(posed: Posed, limits: GroundPenetration) -> Measure:
    """How deep any joint is below the height it has on the floor, and stays there, metres."""
    deep = sustained(-_clearance(posed.positions), posed.num_frames_in(limits.sustained_s))
    frame, joint = (int(i) for i in np.unravel_index(deep.argmax(), deep.shape))
    value = max(float(deep[frame, joint]), 0.0)
    if value > limits.limit:
        frame = int(np.argmax(deep[:, joint] > limits.limit))
    detail = f"{JOINT_NAMES[joint]} is {value:.3f} m below the floor"
    return Measure(value, frame, JOINT_NAMES[joint], detail)


def floating(posed: Posed, limits: Floating) -> Measure:
    """Longest time a body that stands or walks is off the floor, or stands on its heels, seconds.

    A jump does not count: there the pelvis falls freely, or nearly so, as it does nowhere else.
    Toes in the air over an ankle that stands mean that the foot sinks into the floor elsewhere,
    which importers take for its level.
    """
    clearance = _clearance(posed.positions)
    height = posed.positions[:, 0, 1]
    off_floor = clearance.min(axis=1) > limits.height_m
    upright = height > _SEATED_SHARE * BODY.hip_height
    worst = Measure(0.0)
    for start, end in _stretches(off_floor & upright):
        duration = (end - start) / posed.fps
        if duration <= worst.value or _fall(height[start:end], posed.fps) > limits.fall_m_s2:
            continue
        detail = f"nothing is within {limits.height_m} m of the floor for {duration:.1f} s"
        worst = Measure(duration, start, "left_foot", detail)
    for side in ("left", "right"):
        ankle, toes = (JOINT_NAMES.index(f"{side}_{part}") for part in ("ankle", "foot"))
        speed = np.linalg.norm(np.diff(posed.positions[:, ankle], axis=0), axis=1) * posed.fps
        on_heel = (clearance[1:, ankle] < limits.height_m) & (clearance[1:, toes] > limits.height_m)
        for start, end in _stretches(on_heel & upright[1:] & (speed < limits.still_m_s)):
            duration = (end - start) / posed.fps
            if duration > worst.value:
                detail = f"the {side} toes are off the floor for {duration:.1f} s of standing"
                worst = Measure(duration, start, f"{side}_foot", detail)
    return worst


def _fall(height: FloatArray, fps: float) -> float:
    """Acceleration downwards of the parabola nearest to heights `(n,)` of frames, m/s^2."""
    if len(height) < 4:
        return 0.0
    bend = np.polyfit(np.arange(len(height)) / fps, height, 2)[0]
    return float(-2.0 * bend)


def _clearance(positions: FloatArray) -> FloatArray:
    """Height of the body around each joint over the floor, metres, `(num_frames, 22)`."""
    rest = np.full(len(JOINT_NAMES), 0.03)
    for name in ("left_ankle", "right_ankle", "left_foot", "right_foot"):
        rest[JOINT_NAMES.index(name)] = BODY.rest_positions[JOINT_NAMES.index(name), 1]
    clearance: FloatArray = positions[..., 1] - rest
    return clearance


def _foot(posed: Posed, side: str, limits: FootSlide) -> _Foot:
    ankle, toes = (
        posed.positions[:, JOINT_NAMES.index(f"{side}_{part}")] for part in ("ankle", "foot")
    )
    ankle_up, toes_up = (
        x[:, 1] - np.percentile(x[:, 1], _LOWEST_PERCENTILE) for x in (ankle, toes)
    )
    down = (ankle_up < limits.height_m) & (toes_up < limits.height_m)
    ankle, toes = ankle[:, _FLOOR], toes[:, _FLOOR]
    ankle_speed, toe_speed = (
        np.linalg.norm(np.diff(x, axis=0), axis=1) * posed.fps for x in (ankle, toes)
    )
    near = toes_up[1:] < limits.height_m + _NEAR_M
    return _Foot(
        ankle=ankle,
        toes=toes,
        down=down[1:] & down[:-1],
        stands=near & (toe_speed < 2.0 * limits.still_m_s),
        speed=np.minimum(ankle_speed, toe_speed),
    )


def _stretches(mask: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Half-open stretches of true values."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def _spread(path: FloatArray) -> float:
    """Farthest a path `(n, 2)` gets from where it begins or ends."""
    ends = path[[0, -1]]
    return float(np.linalg.norm(path[:, None] - ends, axis=-1).max())
