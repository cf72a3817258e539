"""Checks of how a motion goes on: jumps of the root, the seam, jerk beside others of its class."""

from __future__ import annotations

import collections
import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from affectsim_data.builders.screening.findings import Measure, Posed, pose
from affectsim_data.builders.screening.limits import DroppedFrames, Jerk
from affectsim_data.builders.screening.skeleton_checks import dropped_frames
from affectsim_data.motions.looping import seam_step
from affectsim_data.motions.motion import Emotion, Motion
from affectsim_data.poses import FloatArray

__all__ = ["Jerkiness", "jerk_outliers", "jerkiness", "root_jump", "seam", "seam_turn"]

_ROBUST = 1.4826
"""Standard deviation of a normal distribution by its median absolute deviation."""
_STILL_M_S3 = 0.1
"""Added to jerk before its logarithm, so that who stands still is no outlier."""


@dataclasses.dataclass(frozen=True)
class Jerkiness:
    """How jerky a motion is: what class checks compare."""

    motion_id: str
    action: str
    emotion: Emotion
    mean: float
    """Mean over joints and frames, m/s^3."""
    peak: float
    """99th percentile over the frames of the fastest joint, m/s^3."""
    peak_frame: int
    """Where the jerk is largest."""


def root_jump(posed: Posed, limits: DroppedFrames) -> Measure:
    """Largest jump of the root between neighbouring frames, metres."""
    found = dropped_frames(posed.positions[:, :1], posed.fps, ("pelvis",), limits)
    return dataclasses.replace(found, detail=f"the body jumps by {found.value:.2f} m")


def seam(motion: Motion) -> Measure:
    """How much more the step into the next cycle moves a joint than the steps beside it, metres."""
    excess, _ = seam_step(motion)
    detail = f"from the last frame into the first a joint moves {excess:.3f} m too far"
    return Measure(excess, motion.num_frames - 1, "", detail)


def seam_turn(motion: Motion) -> Measure:
    """How much more the step into the next cycle turns a joint than the steps beside it, deg."""
    excess = math.degrees(seam_step(motion)[1])
    detail = f"from the last frame into the first a joint turns {excess:.1f} degrees too far"
    return Measure(excess, motion.num_frames - 1, "", detail)


def jerkiness(motion: Motion) -> Jerkiness:
    """Mean and peak jerk of the joints of a motion."""
    positions = pose(motion).positions
    if len(positions) < 5:
        return Jerkiness(motion.motion_id, motion.action, motion.emotion, 0.0, 0.0, 0)
    jerk = np.linalg.norm(np.diff(positions, n=3, axis=0), axis=-1) * motion.fps**3
    fastest = jerk.max(axis=1)
    return Jerkiness(
        motion.motion_id,
        motion.action,
        motion.emotion,
        mean=float(jerk.mean()),
        peak=float(np.percentile(fastest, 99.0)),
        peak_frame=int(fastest.argmax()) + 1,
    )


def jerk_outliers(all_motions: Sequence[Jerkiness], limits: Jerk) -> dict[str, Measure]:
    """Robust z-score of the logarithm of a motion's jerk beside its class, by motion id.

    The class is the motions of its action and emotion if there are `class_size` of them, else all
    motions, and if there are not as many either, nothing is an outlier. Only too much counts: who
    hardly moves is no broken recording.
    """
    classes: dict[tuple[str, str], list[int]] = collections.defaultdict(list)
    for number, motion in enumerate(all_motions):
        classes[motion.action, motion.emotion].append(number)
    logs = np.log(np.array([[m.mean, m.peak] for m in all_motions]).reshape(-1, 2) + _STILL_M_S3)
    everybody = list(range(len(all_motions)))
    measures: dict[str, Measure] = {}
    for members in classes.values():
        peers = members if len(members) >= limits.class_size else everybody
        if len(peers) < limits.class_size:
            scores = np.zeros((len(members), 2))
        else:
            scores = _robust_scores(logs[members], logs[peers], limits.min_spread)
        for number, score in zip(members, scores, strict=True):
            measures[all_motions[number].motion_id] = _outlier(all_motions[number], score)
    return measures


def _robust_scores(values: FloatArray, peers: FloatArray, min_spread: float) -> FloatArray:
    middle = np.median(peers, axis=0)
    spread = _ROBUST * np.median(np.abs(peers - middle), axis=0)
    scores: FloatArray = (values - middle) / np.maximum(spread, min_spread)
    return scores


def _outlier(motion: Jerkiness, score: FloatArray) -> Measure:
    kind = int(score.argmax())
    word, jerk = ("mean", motion.mean) if kind == 0 else ("peak", motion.peak)
    detail = f"its {word} jerk is {jerk:.0f} m/s^3, far above others of its class"
    return Measure(max(float(score[kind]), 0.0), motion.peak_frame, "", detail)
