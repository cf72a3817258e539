"""All checks of a motion, and those that need the others of its class."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence

from affectsim_data.builders.screening import (
    body_checks,
    floor_checks,
    joint_checks,
    skeleton_checks,
    tempo_checks,
)
from affectsim_data.builders.screening.findings import Finding, Measure, Posed, pose
from affectsim_data.builders.screening.limits import Thresholds
from affectsim_data.builders.screening.tempo_checks import Jerkiness
from affectsim_data.motions.joint_frames import SourcePose
from affectsim_data.motions.motion import Motion
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["CLASS_CHECKS", "UNITS", "screen_motion", "screen_outliers"]

UNITS: Mapping[str, str] = {
    "bone_drift": "share",
    "bone_asymmetry": "share",
    "repeated_frames": "s",
    "dropped_frames": "m",
    "joint_limits": "deg",
    "root_jump": "m",
    "limb_swap": "m",
    "foot_slide": "m",
    "ground_penetration": "m",
    "floating": "s",
    "self_penetration": "m",
    "seam": "m",
    "seam_turn": "deg",
    "frozen": "s",
    "jerk": "sigma",
}
"""Unit of value and limit, by check."""
CLASS_CHECKS = ("jerk",)
"""Checks that compare motions with others; `screen_outliers` makes them."""
_NO_SOURCE = "not checked: the motion has no source skeleton"


def screen_motion(
    motion: Motion,
    *,
    source: SourcePose | None,
    joints: Mapping[str, str] | None,
    thresholds: Thresholds,
) -> tuple[Finding, ...]:
    """What every check but those of `CLASS_CHECKS` says of a motion, one finding each.

    Args:
        motion: As it goes into a release, closed into a cycle.
        source: The recording it was made from. Without it, bones and sensors are not checked,
            and lost frames are looked for in the motion itself.
        joints: Source joint of a canonical joint; needed with `source`.
        thresholds: Limits.

    Raises:
        ValueError: `source` came without `joints`.
    """
    if source is not None and joints is None:
        raise ValueError(f"motion {motion.motion_id!r}: source needs joints, the joint map, too")
    posed = pose(motion)
    findings = []
    for check, measure in _measures(posed, source, joints or {}, thresholds).items():
        if check in thresholds.off:
            findings.append(_switched_off(check, thresholds))
        elif (found := measure()) is None:
            findings.append(_not_checked(check, thresholds, _NO_SOURCE))
        else:
            of_source = source is not None and check in _SOURCE_CHECKS
            fps = source.fps if source is not None and of_source else motion.fps
            findings.append(_finding(check, found, thresholds, fps))
    return tuple(findings)


def screen_outliers(
    motions: Sequence[Jerkiness], thresholds: Thresholds
) -> dict[str, tuple[Finding, ...]]:
    """What the checks of `CLASS_CHECKS` say of each motion, by motion id.

    Args:
        motions: `jerkiness` of all motions that stand beside each other, rejected ones included.
        thresholds: Limits.
    """
    if "jerk" in thresholds.off:
        return {m.motion_id: (_switched_off("jerk", thresholds),) for m in motions}
    measures = tempo_checks.jerk_outliers(motions, thresholds.jerk)
    return {
        motion_id: (_finding("jerk", measure, thresholds, math.nan),)
        for motion_id, measure in measures.items()
    }


_SOURCE_CHECKS = ("bone_drift", "bone_asymmetry", "repeated_frames", "dropped_frames", "frozen")


def _measures(
    posed: Posed, source: SourcePose | None, joints: Mapping[str, str], limits: Thresholds
) -> dict[str, Callable[[], Measure | None]]:
    """The checks of one motion, to be run; None where a check does not apply."""
    motion = posed.motion
    positions, fps, names = posed.positions, motion.fps, JOINT_NAMES
    if source is not None:
        names = tuple(name for name in JOINT_NAMES if name in joints)
        columns = [source.joint_names.index(joints[name]) for name in names]
        positions, fps = source.positions[:, columns], source.fps

    return {
        "bone_drift": lambda: skeleton_checks.bone_drift(source, joints) if source else None,
        "bone_asymmetry": lambda: (
            skeleton_checks.bone_asymmetry(source, joints) if source else None
        ),
        "repeated_frames": lambda: skeleton_checks.repeated_frames(
            positions, fps, limits.repeated_frames
        ),
        "dropped_frames": lambda: skeleton_checks.dropped_frames(
            positions, fps, names, limits.dropped_frames
        ),
        "joint_limits": lambda: joint_checks.joint_limits(posed, limits.joint_limits),
        "root_jump": lambda: tempo_checks.root_jump(posed, limits.root_jump),
        "limb_swap": lambda: joint_checks.limb_swap(posed),
        "foot_slide": lambda: _worse(
            posed, lambda of: floor_checks.foot_slide(of, limits.foot_slide)
        ),
        "ground_penetration": lambda: floor_checks.ground_penetration(
            posed, limits.ground_penetration
        ),
        "floating": lambda: floor_checks.floating(posed, limits.floating),
        "self_penetration": lambda: body_checks.self_penetration(posed, limits.self_penetration),
        "seam": lambda: tempo_checks.seam(motion),
        "seam_turn": lambda: tempo_checks.seam_turn(motion),
        "frozen": lambda: (
            joint_checks.frozen(
                joint_checks.hanging_joints(source, joints), positions, fps, limits.frozen
            )
            if source
            else None
        ),
    }


def _worse(posed: Posed, check: Callable[[Posed], Measure]) -> Measure:
    """The worse of a motion and of what it was before it was closed into a cycle.

    A seam may hide what the performance ends with; frames are those of the cycle all the same.
    """
    found = check(posed)
    motion = posed.motion
    if motion.uncut is None:
        return found
    before = check(pose(motion.original()))
    if before.value <= found.value:
        return found
    shifted = before.frame - motion.uncut.before + motion.uncut.start
    frame = min(max(shifted, 0), motion.num_frames - 1)
    return dataclasses.replace(before, frame=frame)


def _finding(check: str, found: Measure, thresholds: Thresholds, fps: float) -> Finding:
    limit = float(getattr(thresholds, check).limit)
    passed = not found.value > limit
    reason = f"{found.detail}; at most {limit:g} {UNITS[check]} passes" if found.detail else "clean"
    return Finding(
        check=check,
        value=found.value,
        limit=limit,
        unit=UNITS[check],
        passed=passed,
        frame=found.frame,
        time_s=found.frame / fps if found.frame >= 0 else math.nan,
        joint=found.joint,
        reason=reason,
    )


def _switched_off(check: str, thresholds: Thresholds) -> Finding:
    return _not_checked(check, thresholds, f"switched off: {thresholds.off[check]}")


def _not_checked(check: str, thresholds: Thresholds, reason: str) -> Finding:
    limit = float(getattr(thresholds, check).limit)
    return Finding(check, math.nan, limit, UNITS[check], True, -1, math.nan, "", reason)
