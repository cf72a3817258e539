"""What a pose looks like in numbers: directions, angles and distances, frame by frame.

All take joint positions of the canonical body, metres, +Y up, `(num_frames, 22, 3)`, and give one
number or vector a frame. Signed pitches are positive forwards.
"""

from __future__ import annotations

import functools

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import BODY, JOINT_NAMES, NUM_JOINTS

__all__ = [
    "SEGMENT_MASSES",
    "STATURE_M",
    "elbow_flexion",
    "facing",
    "hand_span",
    "joint",
    "knee_flexion",
    "neck_pitch",
    "pitch",
    "segment_centers",
    "trunk_pitch",
]

STATURE_M = 1.70
"""Of the canonical body: what shares of stature are shares of."""
_UP = np.array([0.0, 1.0, 0.0])
# Segment: (mass share of the body, from, to, centre of mass on the way). Winter (2009),
# *Biomechanics and Motor Control of Human Movement*, table 4.1; a hand is put at its wrist.
_SEGMENTS = {
    "foot": (0.0145, "ankle", "foot", 0.5),
    "shank": (0.0465, "knee", "ankle", 0.433),
    "thigh": (0.100, "hip", "knee", 0.433),
    "upper_arm": (0.028, "shoulder", "elbow", 0.436),
    "forearm": (0.016, "elbow", "wrist", 0.430),
    "hand": (0.006, "elbow", "wrist", 1.0),
}
_TRUNK_MASS, _HEAD_MASS = 0.497, 0.081
SEGMENT_MASSES: FloatArray = np.array(
    [mass for mass, *_ in _SEGMENTS.values() for _ in range(2)] + [_TRUNK_MASS, _HEAD_MASS]
)
"""Shares of body mass of what `segment_centers` gives, `(14,)`; they sum to 1."""


@functools.cache
def joint(name: str) -> int:
    """Place of a joint in the canonical order."""
    return JOINT_NAMES.index(name)


def facing(positions: FloatArray) -> FloatArray:
    """Horizontal unit direction that hips and shoulders look along, `(num_frames, 3)`."""
    left = positions[:, [joint("left_hip"), joint("left_shoulder")]]
    right = positions[:, [joint("right_hip"), joint("right_shoulder")]]
    across = (left - right).mean(axis=1)
    forward: FloatArray = np.cross(across, _UP)
    forward /= np.maximum(np.linalg.norm(forward, axis=1, keepdims=True), 1e-9)
    return forward


def pitch(vectors: FloatArray, forward: FloatArray) -> FloatArray:
    """Lean of vectors `(num_frames, 3)` towards horizontal directions, radians; 0 is upright."""
    ahead = np.sum(vectors * forward, axis=-1)
    angle: FloatArray = np.arctan2(ahead, vectors[..., 1])
    return angle


def trunk_pitch(positions: FloatArray, forward: FloatArray) -> FloatArray:
    """Lean of the line from pelvis to neck, radians, `(num_frames,)`."""
    return pitch(positions[:, joint("neck")] - positions[:, joint("pelvis")], forward)


def neck_pitch(positions: FloatArray, forward: FloatArray) -> FloatArray:
    """Lean of the line from neck to head past what it has at rest, radians, `(num_frames,)`.

    At rest the head joint of the canonical body lies 11.9 degrees ahead of its neck.
    """
    rest = BODY.joint_offsets[joint("head")]
    line = positions[:, joint("head")] - positions[:, joint("neck")]
    return pitch(line, forward) - float(np.arctan2(rest[2], rest[1]))


def elbow_flexion(positions: FloatArray) -> FloatArray:
    """Angle of left and right forearm to the upper arm, radians, `(num_frames, 2)`; 0: straight."""
    return _flexion(positions, "shoulder", "elbow", "wrist")


def knee_flexion(positions: FloatArray) -> FloatArray:
    """Angle of left and right shank to the thigh, radians, `(num_frames, 2)`; 0: straight."""
    return _flexion(positions, "hip", "knee", "ankle")


def hand_span(positions: FloatArray) -> FloatArray:
    """Distance between the wrists as a share of stature, `(num_frames,)`."""
    apart = positions[:, joint("left_wrist")] - positions[:, joint("right_wrist")]
    span: FloatArray = np.linalg.norm(apart, axis=1) / STATURE_M
    return span


def segment_centers(positions: FloatArray) -> FloatArray:
    """Centres of mass of the body's 14 segments, metres, `(num_frames, 14, 3)`."""
    centers: FloatArray = np.einsum("sj,fjk->fsk", _segment_weights(), positions)
    return centers


def _flexion(positions: FloatArray, start: str, middle: str, end: str) -> FloatArray:
    chain = [[joint(f"{s}_{part}") for part in (start, middle, end)] for s in ("left", "right")]
    bones = np.diff(positions[:, chain], axis=2)
    upper, lower = bones[:, :, 0], bones[:, :, 1]
    # atan2 keeps its precision where the limb is nearly straight; acos does not.
    across = np.linalg.norm(np.cross(upper, lower), axis=-1)
    angle: FloatArray = np.arctan2(across, np.sum(upper * lower, axis=-1))
    return angle


@functools.cache
def _segment_weights() -> FloatArray:
    """Shares of joints in the centres of segments, `(14, 22)`."""
    rows = [
        _mix({f"{side}_{start}": 1.0 - way, f"{side}_{end}": way})
        for _, start, end, way in _SEGMENTS.values()
        for side in ("left", "right")
    ]
    hips, shoulders = ("left_hip", "right_hip"), ("left_shoulder", "right_shoulder")
    rows.append(_mix(dict.fromkeys(hips + shoulders, 0.25)))
    rows.append(_mix({"head": 1.0}))
    return np.array(rows)


def _mix(shares: dict[str, float]) -> FloatArray:
    row = np.zeros(NUM_JOINTS)
    row[[joint(name) for name in shares]] = list(shares.values())
    return row
