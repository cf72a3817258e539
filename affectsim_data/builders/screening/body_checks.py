"""Check of a body against itself: hands in the trunk, legs through each other."""

from __future__ import annotations

import numpy as np

from affectsim_data.builders.screening.findings import Measure, Posed, sustained
from affectsim_data.builders.screening.limits import SelfPenetration
from affectsim_data.poses import FloatArray, quaternion_rotate
from affectsim_data.skeletons import JOINT_NAMES

__all__ = ["self_penetration"]

_HAND_M, _HEAD_M = 0.08, 0.10
_RADII_M = {
    "trunk": 0.09,
    "chest": 0.09,
    "head": 0.07,
    "forearm": 0.035,
    "hand": 0.025,
    "thigh": 0.055,
    "shank": 0.04,
}
"""Of capsules that lie inside a slender body: what enters them is inside any body. A trunk is
twice as wide as deep; its capsules are as thick as it is deep."""
_OWN = ("forearm", "hand")
_Segments = dict[str, tuple[FloatArray, FloatArray]]


def self_penetration(posed: Posed, limits: SelfPenetration) -> Measure:
    """How deep a part of the body stays within another, metres."""
    segments = _segments(posed)
    pairs = _pairs()
    starts, ends = (
        np.stack([np.stack([segments[name][i] for name in pair]) for pair in pairs]) for i in (0, 1)
    )
    apart = _segment_distance(starts[:, 0], ends[:, 0], starts[:, 1], ends[:, 1])
    radii = np.array([sum(_radius(name) for name in pair) for pair in pairs])
    deep = sustained((radii[:, None] - apart).T, posed.num_frames_in(limits.sustained_s))
    frame, number = (int(i) for i in np.unravel_index(deep.argmax(), deep.shape))
    value = max(float(deep[frame, number]), 0.0)
    if value > limits.limit:
        frame = int(np.argmax(deep[:, number] > limits.limit))
    one, other = pairs[number]
    detail = f"the {one.replace('_', ' ')} is {value:.3f} m inside the {other.replace('_', ' ')}"
    return Measure(value, frame, _joint(one), detail)


def _segments(posed: Posed) -> _Segments:
    """Both ends of the axis of each capsule, each `(num_frames, 3)`."""

    def place(name: str) -> FloatArray:
        found: FloatArray = posed.positions[:, JOINT_NAMES.index(name)]
        return found

    def beyond(name: str, away: tuple[float, float, float]) -> FloatArray:
        return place(name) + quaternion_rotate(posed.rotations[:, JOINT_NAMES.index(name)], away)

    segments: _Segments = {
        "trunk": (place("pelvis"), place("spine3")),
        "chest": (place("spine3"), 0.5 * (place("spine3") + place("neck"))),
        "head": (place("head"), beyond("head", (0.0, _HEAD_M, 0.0))),
    }
    for side, sign in (("left", 1.0), ("right", -1.0)):
        hip, knee, ankle = (place(f"{side}_{part}") for part in ("hip", "knee", "ankle"))
        wrist = place(f"{side}_wrist")
        segments |= {
            f"{side}_forearm": (place(f"{side}_elbow"), wrist),
            f"{side}_hand": (wrist, beyond(f"{side}_wrist", (sign * _HAND_M, 0.0, 0.0))),
            # Thighs touch at the top in any body.
            f"{side}_thigh": (0.5 * (hip + knee), knee),
            f"{side}_shank": (knee, ankle),
        }
    return segments


def _pairs() -> list[tuple[str, str]]:
    """Which capsules may not enter each other."""
    pairs = []
    for side, other in (("left", "right"), ("right", "left")):
        for part in _OWN:
            own = f"{side}_{part}"
            pairs += [(own, target) for target in ("trunk", "chest", "head")]
            pairs += [(own, f"{leg}_thigh") for leg in ("left", "right")]
        pairs.append((f"{side}_shank", f"{other}_thigh"))
    pairs += [(f"left_{part}", f"right_{part}") for part in ("forearm", "thigh", "shank")]
    return pairs


def _radius(name: str) -> float:
    return _RADII_M[name.split("_")[-1]]


def _joint(name: str) -> str:
    """Canonical joint at the outer end of a capsule."""
    side, part = name.split("_")
    outer = {"forearm": "wrist", "hand": "wrist", "thigh": "knee", "shank": "ankle"}
    return f"{side}_{outer[part]}"


def _segment_distance(a: FloatArray, b: FloatArray, c: FloatArray, d: FloatArray) -> FloatArray:
    """Shortest distance between the segments a-b and c-d, each `(..., 3)`.

    The closest points of two lines, clamped to one segment, then to the other, and back (Ericson
    2005, *Real-Time Collision Detection*, 5.1.9).
    """
    u, v, w = b - a, d - c, a - c
    uu, vv = np.maximum((u * u).sum(-1), 1e-12), np.maximum((v * v).sum(-1), 1e-12)
    uv, uw, vw = (u * v).sum(-1), (u * w).sum(-1), (v * w).sum(-1)
    determinant = uu * vv - uv * uv
    parallel = determinant < 1e-9 * uu * vv
    along = np.where(parallel, 0.0, (uv * vw - uw * vv) / np.where(parallel, 1.0, determinant))
    other = ((uv * along.clip(0.0, 1.0) + vw) / vv).clip(0.0, 1.0)
    along = ((uv * other - uw) / uu).clip(0.0, 1.0)
    distance: FloatArray = np.linalg.norm(w + along[..., None] * u - other[..., None] * v, axis=-1)
    return distance
