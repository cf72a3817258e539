"""The bodies in one look: pixels that are a person's, parted by depth and by gaps."""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.simulation.running import Observation

__all__ = ["HOT", "IMAGE_SIZE", "ImagePoints", "bodies_in", "median", "span"]

BoolArray = NDArray[np.bool_]

IMAGE_SIZE = 112
"""Side of the images that are measured, pixels."""
HOT = 0.4
"""Evidence above which a cell belongs to a person."""
_DEPTH_BIN_M = 0.2
_BODY_DEPTH_M = 0.45
"""A body reaches this far before and behind the depth most of it is at."""
_MIN_PIXELS = 12
_FIRST, _SECOND = (0.35, 0.0), (0.2, 0.7)
"""Of touching cells, the part of their pixels that the first body must hold, and one behind it, and
their mean evidence: what is around a body is in the cells of its border, which are not sure."""
_SPLIT_WIDTH_M = 0.9
"""Wider than one body mostly is: two people side by side if there is a gap between them."""


@dataclasses.dataclass(frozen=True)
class ImagePoints:
    """Where the pixels of the measured image are, in the camera's own upright frame."""

    right: NDArray[np.float32]
    """Metres, `(112, 112)`, as the others."""
    height: NDArray[np.float32]
    """Above the floor."""
    depth: NDArray[np.float32]
    """`inf` where nothing was hit."""

    @classmethod
    def of(cls, observation: Observation) -> ImagePoints:
        """Those of an observation with images `(112, 112)`."""
        depth = observation.depth
        across, down = _slopes(observation.camera)
        near = np.minimum(depth, 30.0)
        height = np.float32(observation.camera_height_m) - down[:, None] * near
        return cls(across * near, height, np.asarray(depth, np.float32))


def _slopes(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    along = ((np.arange(IMAGE_SIZE) + 0.5) / IMAGE_SIZE * 2.0 - 1.0).astype(np.float32)
    return along * math.tan(camera.hfov / 2.0), along * math.tan(camera.vfov / 2.0)


def bodies_in(evidence: NDArray[np.float32], points: ImagePoints) -> list[BoolArray]:
    """Pixels of each body, `(112, 112)`: hot cells that touch, parted by depth and by gaps.

    Args:
        evidence: Of a person in each cell, in [0, 1], `(28, 28)`.
        points: Where the pixels are.
    """
    count, labels = cv2.connectedComponents((evidence > HOT).astype(np.uint8), connectivity=8)
    found = []
    for number in range(1, count):
        cells = np.where(labels == number, evidence, 0.0).astype(np.float32)
        hot = cv2.resize(cells, (IMAGE_SIZE, IMAGE_SIZE), interpolation=cv2.INTER_LINEAR)
        pixels = np.asarray(hot > 0.75 * HOT)
        left = pixels & np.isfinite(points.depth) & (points.height > 0.1)
        for least_share, least_evidence in (_FIRST, _SECOND):
            body = left & (np.abs(points.depth - _main_depth(points.depth[left])) < _BODY_DEPTH_M)
            share = body.sum() / max(int(pixels.sum()), 1)
            if body.sum() < _MIN_PIXELS or share < least_share:
                break
            if hot[body].mean() < least_evidence:
                break
            found.extend(_parted(body, points))
            left &= ~body
    return found


def _main_depth(depth: NDArray[np.float32]) -> float:
    """The depth most pixels are near to; `nan` for none."""
    if not len(depth):
        return math.nan
    bins = np.bincount((depth / _DEPTH_BIN_M).astype(np.intp))
    near = np.convolve(bins, [1, 2, 1], mode="same")
    middle = (near.argmax() + 0.5) * _DEPTH_BIN_M
    return median(depth[np.abs(depth - middle) < 1.5 * _DEPTH_BIN_M])


def median(values: NDArray[np.float32]) -> float:
    """As `np.median`, at a fraction of its cost; `nan` for none."""
    if not len(values):
        return math.nan
    below, above = (len(values) - 1) // 2, len(values) // 2
    parted = np.partition(values, (below, above))
    return float((parted[below] + parted[above]) * np.float32(0.5))


def span(values: NDArray[np.float32]) -> tuple[np.float64, np.float64]:
    """As `np.percentile` at 3 and 97, at a fraction of its cost."""
    ordered = np.sort(values)
    low, high = (_between(ordered, np.float64(share)) for share in (0.03, 0.97))
    return low, high


def _between(ordered: NDArray[np.float32], share: np.float64) -> np.float64:
    at = (len(ordered) - 1) * share
    before = int(at)
    part, low = at - before, ordered[before]
    high = ordered[min(before + 1, len(ordered) - 1)]
    # From the nearer side, so that both ends are met.
    away = high - low
    return np.float64(low + away * part if part < 0.5 else high - away * (1.0 - part))


def _parted(body: BoolArray, points: ImagePoints) -> list[BoolArray]:
    """One body, or two where it is too wide for one and there is a gap or a waist between them."""
    right = points.right[body]
    low, high = span(right)
    if high - low < _SPLIT_WIDTH_M:
        return [body]
    counts, edges = np.histogram(right, bins=12, range=(low, high))
    middle = 3 + int(counts[3:9].argmin())
    if counts[middle] > 0.4 * min(counts[:middle].max(), counts[middle + 1 :].max()):
        return [body]
    gap = 0.5 * (edges[middle] + edges[middle + 1])
    parts = [body & (points.right < gap), body & (points.right >= gap)]
    return [part for part in parts if part.sum() >= _MIN_PIXELS] or [body]
