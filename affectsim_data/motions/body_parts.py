"""Parts of the body, and the statistics descriptors give of them."""

from __future__ import annotations

import numpy as np

from affectsim_data.motions.posture import joint
from affectsim_data.poses import FloatArray
from affectsim_data.skeletons import NUM_JOINTS

__all__ = ["PARTS", "part_statistics", "statistics"]

PARTS: dict[str, tuple[int, ...]] = {
    "body": tuple(range(NUM_JOINTS)),
    "pelvis": (joint("pelvis"),),
    "head": (joint("head"),),
    "hands": (joint("left_wrist"), joint("right_wrist")),
    "feet": (joint("left_foot"), joint("right_foot")),
    "left_hand": (joint("left_wrist"),),
    "right_hand": (joint("right_wrist"),),
    "left_foot": (joint("left_foot"),),
    "right_foot": (joint("right_foot"),),
}
"""Joints of a part of the body. A part's mean and deviation are those of its joints, averaged; its
maximum is the largest of any joint."""
_ALL = ("mean", "max", "mad")


def statistics(
    name: str, unit: str, values: FloatArray, which: tuple[str, ...] = _ALL
) -> dict[str, float]:
    """Statistics over the frames of `(num_frames,)` or `(num_frames, n)`, averaged over n."""
    mean, high, spread = _mean_max_mad(values.reshape(len(values), -1))
    found = {"mean": mean.mean(), "max": high.max(), "mad": spread.mean()}
    return {"_".join(filter(None, (name, one, unit))): float(found[one]) for one in which}


def part_statistics(
    feature: str, unit: str, values: FloatArray, which: tuple[str, ...] = _ALL
) -> dict[str, float]:
    """The same for every part, of values of joints `(num_frames, 22)`."""
    mean, high, spread = _mean_max_mad(values)
    found: dict[str, float] = {}
    for part, joints in PARTS.items():
        numbers = {"mean": mean[joints,].mean(), "max": high[joints,].max()}
        numbers["mad"] = spread[joints,].mean()
        found |= {f"{part}_{feature}_{one}_{unit}": float(numbers[one]) for one in which}
    return found


def _mean_max_mad(values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Mean, maximum and median absolute deviation of each column."""
    spread = np.median(np.abs(values - np.median(values, axis=0)), axis=0)
    return values.mean(axis=0), values.max(axis=0), spread
