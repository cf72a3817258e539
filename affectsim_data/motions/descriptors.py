"""Kinematic descriptors of any motion: how fast, how jerky, how wide, how bent.

The features and statistics of EMOKINE (Christensen et al. 2024, doi:10.3758/s13428-024-02433-0)
under its names, and a few of our own. docs/descriptors.md has every name, unit and formula.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from affectsim_data.motions.body_parts import PARTS, part_statistics, statistics
from affectsim_data.motions.derivatives import differentiate
from affectsim_data.motions.gait import WalkKinematics, check_clip, walk_kinematics
from affectsim_data.motions.motion import Motion
from affectsim_data.motions.posture import (
    SEGMENT_MASSES,
    elbow_flexion,
    facing,
    hand_span,
    joint,
    knee_flexion,
    neck_pitch,
    segment_centers,
    trunk_pitch,
)
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY

if TYPE_CHECKING:
    import pyarrow as pa

__all__ = [
    "MAIN_DESCRIPTORS",
    "PARTS",
    "WalkKinematics",
    "descriptor_table",
    "kinematic_descriptors",
    "walk_kinematics",
]

MAIN_DESCRIPTORS: tuple[str, ...] = (
    "body_speed_mean_m_s",
    "hands_speed_mean_m_s",
    "hands_acceleration_mean_m_s2",
    "hands_jerk_mean_m_s3",
    "limb_contraction_mean_m",
    "hand_span_mean",
    "elbow_flexion_mean_deg",
    "trunk_pitch_mean_deg",
    "neck_pitch_mean_deg",
    "bounce_m",
)
"""What tables and plots show first."""
_MOVEMENTS = (
    ("speed", "m_s"),
    ("acceleration", "m_s2"),
    ("jerk", "m_s3"),
    ("angular_speed", "rad_s"),
    ("angular_acceleration", "rad_s2"),
)
_STILL_M_S = 1e-6
_HULL_HZ = 3.0
"""Hulls in space are taken this often: enough for a mean, and they cost more than the rest."""
_LIMB_ENDS = tuple(
    joint(f"{side}_{end}") for side in ("left", "right") for end in ("wrist", "foot")
)


def kinematic_descriptors(motion: Motion, *, cyclic: bool = True) -> dict[str, float]:
    """Descriptors of a motion by name; a name ends in its unit, shares have none.

    None depends on where the performer stands or which way it looks. Names are
    `PART_FEATURE_STATISTIC_UNIT` for `PARTS`, `FEATURE_STATISTIC_UNIT` for the whole body;
    statistics are `mean`, `max` and `mad`, the median absolute deviation from the median.

    Args:
        motion: Any action.
        cyclic: Whether the motion is a closed cycle; False for a clip as it was captured.

    Raises:
        ValueError: Fewer than 8 frames; said to be cyclic, but its end is far from its beginning.
    """
    check_clip(motion, cyclic=cyclic)
    frames = BODY.joint_frames(motion.root_translation, motion.joint_rotations)
    positions, axes = frames[..., :3, 3], frames[..., :3, :3]
    forward = facing(positions)
    found = {
        **_movement(positions, axes, motion.fps, cyclic=cyclic),
        **_mass(positions, motion.fps, cyclic=cyclic),
        **_shape(positions, axes, forward),
        **_space(positions, forward, motion.fps),
        **_posture(positions, forward),
    }
    left, right = found["left_hand_speed_mean_m_s"], found["right_hand_speed_mean_m_s"]
    moving = left + right > _STILL_M_S
    found["hand_asymmetry"] = abs(left - right) / (left + right) if moving else 0.0
    return found


def descriptor_table(motions: Iterable[Motion], *, cyclic: bool = True) -> pa.Table:
    """Descriptors of motions, one row each, after the columns that say whose they are.

    Those are `motion_id`, `emotion`, `action`, `performance`, `performer_id` and `duration_s`.

    Raises:
        ValueError: There is no motion, or one has no descriptors; the message names it.
    """
    import pyarrow as pa  # slow to load, and descriptors of one motion do without

    rows = [
        {
            "motion_id": motion.motion_id,
            "emotion": motion.emotion,
            "action": motion.action,
            "performance": motion.performance,
            "performer_id": motion.performer_id,
            "duration_s": motion.duration_s,
            **kinematic_descriptors(motion, cyclic=cyclic),
        }
        for motion in motions
    ]
    if not rows:
        raise ValueError("descriptor_table needs at least one motion, got none")
    return pa.Table.from_pylist(rows)


def _movement(
    positions: FloatArray, axes: FloatArray, fps: float, *, cyclic: bool
) -> dict[str, float]:
    """Speeds and what derives from them, per part."""
    velocity, acceleration, jerk = differentiate(positions, fps, (1, 2, 3), cyclic=cyclic)
    turning, swaying = differentiate(axes, fps, (1, 2), cyclic=cyclic)
    # Columns of a rotation matrix move as w x column; half the sum of column x motion is w.
    series = np.stack(
        [
            _length(velocity),
            _length(acceleration),
            _length(jerk),
            _length(0.5 * np.cross(axes, turning, axis=-2).sum(axis=-1)),
            _length(0.5 * np.cross(axes, swaying, axis=-2).sum(axis=-1)),
        ]
    )
    duration_s = len(positions) / fps
    found: dict[str, float] = {}
    for (feature, unit), values in zip(_MOVEMENTS, series, strict=True):
        found |= part_statistics(feature, unit, values)
    # Hogan and Sternad (2009): the integral of squared jerk, by duration^3 / mean speed^2.
    speed = series[0].mean(axis=0)
    still = speed < _STILL_M_S
    squared = (series[2] ** 2).mean(axis=0) * duration_s**4
    smoothness = np.where(still, 0.0, squared / np.where(still, 1.0, speed) ** 2)
    for part, joints in PARTS.items():
        found[f"{part}_path_length_m"] = float(speed[joints,].mean()) * duration_s
        found[f"{part}_dimensionless_jerk"] = float(smoothness[joints,].mean())
    return found


def _mass(positions: FloatArray, fps: float, *, cyclic: bool) -> dict[str, float]:
    """Quantity of motion, and how far parts are from the centre of mass."""
    segments = segment_centers(positions)
    center = np.einsum("s,fsk->fk", SEGMENT_MASSES, segments)
    (velocity,) = differentiate(segments, fps, (1,), cyclic=cyclic)
    quantity = _length(velocity) @ SEGMENT_MASSES
    found = statistics("quantity_of_motion", "m_s", quantity)
    found["quantity_of_motion_integral_m"] = float(quantity.mean()) * len(positions) / fps
    away = _length(positions - center[:, None])
    return found | part_statistics("com_distance", "m", away, ("mean", "mad"))


def _shape(positions: FloatArray, axes: FloatArray, forward: FloatArray) -> dict[str, float]:
    """Contraction of the limbs, angles of the head, and how many ways the body moves."""
    ends = positions[:, _LIMB_ENDS] - positions[:, joint("head")][:, None]
    neck, back = axes[:, joint("neck"), :, 1], axes[:, joint("spine3"), :, 1]
    vertical = np.arctan2(np.linalg.norm(neck[:, [0, 2]], axis=1), neck[:, 1])
    relative = np.arctan2(_length(np.cross(neck, back)), np.sum(neck * back, axis=1))
    side = np.cross([0.0, 1.0, 0.0], forward)
    body = np.stack([side, np.broadcast_to([0.0, 1.0, 0.0], forward.shape), forward], axis=1)
    local = np.einsum("fik,fjk->fji", body, positions - positions[:, :1]).reshape(len(body), -1)
    local -= local.mean(axis=0)
    # Of the eigenvalues of the covariance: (sum)^2 / sum of squares, by traces instead.
    covariance = np.einsum("fi,fj->ij", local, local)  # too small for the threads of `@`
    total, squared = float(np.trace(covariance)), float(np.sum(covariance**2))
    return {
        **statistics("limb_contraction", "m", _length(ends).mean(axis=1), ("mean", "mad")),
        **statistics("head_angle_vertical", "deg", np.rad2deg(vertical), ("mean", "mad")),
        **statistics("head_angle_back", "deg", np.rad2deg(relative), ("mean", "mad")),
        "dimensionality": total**2 / squared if total > _STILL_M_S**2 else 0.0,
    }


def _space(positions: FloatArray, forward: FloatArray, fps: float) -> dict[str, float]:
    """Convex hulls of the joints, seen from above and in space, and the box around them."""
    from scipy.spatial import ConvexHull  # a third of a second that gait does without

    side = np.cross([0.0, 1.0, 0.0], forward)
    across = np.einsum("fjk,fk->fj", positions, side)
    ahead = np.einsum("fjk,fk->fj", positions, forward)
    found = statistics("convex_hull_2d", "m2", _hull_areas(across, ahead), ("mean", "mad"))
    start = positions[..., [0, 2]] @ np.stack([side[0], forward[0]])[:, [0, 2]].T
    everything = _hull_areas(start[..., 0].reshape(1, -1), start[..., 1].reshape(1, -1))
    found["convex_hull_2d_global_m2"] = float(everything[0])
    count = max(round(len(positions) / fps * _HULL_HZ), 2)
    # Qhull takes one set of points at a time, so this loop cannot be an array.
    bodies = positions[np.arange(count) * len(positions) // count]
    volumes = np.array([ConvexHull(body).volume for body in bodies])
    found |= statistics("convex_hull_3d", "m3", volumes, ("mean", "mad"))
    found["convex_hull_3d_global_m3"] = float(ConvexHull(bodies.reshape(-1, 3)).volume)
    box = np.ptp(across, axis=1) * np.ptp(ahead, axis=1) * np.ptp(positions[..., 1], axis=1)
    return found | statistics("bounding_box", "m3", box, ("mean", "max"))


def _hull_areas(x: FloatArray, y: FloatArray) -> FloatArray:
    """Areas of the convex hulls of rows of points `(n, m)`, to a part in a thousand.

    The corners are the points farthest out in directions 3 degrees apart: what lies between two
    directions and still sticks out does so by less.
    """
    angle = np.deg2rad(np.arange(0.0, 360.0, 3.0))
    out = x[..., None] * np.cos(angle) + y[..., None] * np.sin(angle)
    corners = np.argmax(out, axis=1)
    x, y = (np.take_along_axis(values, corners, axis=1) for values in (x, y))
    area: FloatArray = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    return area


def _posture(positions: FloatArray, forward: FloatArray) -> dict[str, float]:
    """Our own: what gait studies and teachers of acting look at."""
    pelvis, hands = positions[:, 0], positions[:, PARTS["hands"]]
    angles = {
        "elbow_flexion": elbow_flexion(positions),
        "knee_flexion": knee_flexion(positions),
        "trunk_pitch": trunk_pitch(positions, forward),
        "neck_pitch": neck_pitch(positions, forward),
    }
    found: dict[str, float] = {}
    for name, angle in angles.items():
        found |= statistics(name, "deg", np.rad2deg(angle), ("mean", "mad"))
    found |= statistics("hand_span", "", hand_span(positions), ("mean", "mad"))
    found |= statistics("hand_height", "m", hands[..., 1], ("mean", "max"))
    low, high = np.percentile(pelvis[:, 1], [5.0, 95.0])
    return found | {
        "pelvis_height_mean_m": float(pelvis[:, 1].mean()),
        "bounce_m": float(high - low),
    }


def _length(vectors: FloatArray) -> FloatArray:
    length: FloatArray = np.sqrt(np.einsum("...k,...k->...", vectors, vectors))
    return length
