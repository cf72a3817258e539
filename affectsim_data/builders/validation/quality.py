"""How good the reference views of a release are, and whether metadata tell the emotion."""

from __future__ import annotations

import dataclasses

import numpy as np
import pyarrow as pa

from affectsim_data.builders.leakage import leakage_probe
from affectsim_data.builders.validation.findings import Measure
from affectsim_data.builders.validation.part import Part
from affectsim_data.builders.validation.shares import seen
from affectsim_data.poses import FloatArray, invert_pose, transform_points

__all__ = ["ReferenceQuality", "check_leakage", "check_quality", "reference_quality"]

VISIBLE_SHARE = 0.9
"""Least mean visible share at p_ref over a release."""
MIDDLE, MIDDLE_FRAMES = 0.8, 0.95
"""Part of the image, in width and height, and least share of frames with the body in it."""
_TAILS = (5.0, 95.0)
"""Percentiles of the body's surface points that must be in the middle: a hand may leave it."""
LEAKAGE = 0.03
"""Most that a classifier may be better than chance."""
FEWEST_TESTED = 500
"""Episodes outside train from which on a probe tells something: chance alone is 2 points off."""
_SIGMAS = 3.0
"""Chance alone lets the best of a few classifiers be this many standard errors too good."""


@dataclasses.dataclass(frozen=True, eq=False)
class ReferenceQuality:
    """Of some episodes."""

    share: FloatArray
    """Mean visible share at p_ref, `(n,)`."""
    in_middle: FloatArray
    """Share of the cycle's instants with the body in the middle of the image, `(n,)`."""


def reference_quality(part: Part) -> ReferenceQuality:
    """Visible shares and framing of the reference views."""
    poses = part.views["ref"]
    pixels, _ = part.camera.project(transform_points(invert_pose(poses), part.surface))
    size = np.array([part.camera.width, part.camera.height])
    margin = (1.0 - MIDDLE) / 2.0 * size
    # Points behind the camera are not a number and fail both comparisons.
    low, high = np.percentile(pixels, _TAILS, axis=2)
    in_middle = ((low >= margin) & (high <= size - margin)).all(axis=-1)
    return ReferenceQuality(seen(part, "ref").share, in_middle.mean(axis=1))


def check_quality(parts: list[ReferenceQuality]) -> list[Measure]:
    """Means over the release."""
    if not parts:
        return []
    share = np.concatenate([part.share for part in parts]).mean()
    middle = np.concatenate([part.in_middle for part in parts]).mean()
    return [
        Measure.of("reference_visible", ["p_ref"], [share], low=VISIBLE_SHARE),
        Measure.of("reference_middle", ["p_ref"], [middle], low=MIDDLE_FRAMES),
    ]


def check_leakage(episodes: pa.Table) -> list[Measure]:
    """Classifiers on what may not depend on the emotion; no measure of too few episodes."""
    splits = np.array(episodes.column("split").to_pylist())
    if np.count_nonzero(splits != "train") < FEWEST_TESTED:
        return []
    try:
        probes = leakage_probe(episodes)
    except ValueError:
        return []
    probes = {name: one for name, one in probes.items() if one.features == "placement"}
    limits = [max(LEAKAGE, _SIGMAS * one.standard_error) for one in probes.values()]
    values = [one.excess for one in probes.values()]
    return [Measure.of("leakage", probes, values, high=np.array(limits))]
