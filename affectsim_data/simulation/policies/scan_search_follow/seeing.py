"""Finds people in what the robot sees: RGB-D alone, no labels, no masks.

Two witnesses: a small network that knows what a person looks like, and change. Nothing but people
moves in a home, so what came into a ray since the robot last looked along it from the same spot
is a person or hides one.
"""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.changing import ChangeMemory
from affectsim_data.simulation.policies.scan_search_follow.person_network import (
    CELLS,
    PersonHeat,
    PersonNetwork,
    find_people,
    load_person_network,
)
from affectsim_data.simulation.running import Observation

__all__ = ["PersonFinder", "Sighting"]

BoolArray = NDArray[np.bool_]

_SIZE = 112
"""Side of the images that are measured, pixels."""
_HOT = 0.4
"""Evidence above which a cell belongs to a person."""
_MOVED_WEIGHT = 0.5
"""Evidence of a cell in which everything changed, if the network sees nobody there."""
_DEPTH_BIN_M = 0.2
_BODY_DEPTH_M = 0.45
"""A body reaches this far before and behind the depth most of it is at."""
_MIN_PIXELS = 12
_FIRST, _SECOND = (0.35, 0.0), (0.2, 0.7)
"""Of touching cells, the part of their pixels that the first body must hold, and one behind it, and
their mean evidence: what is around a body is in the cells of its border, which are not sure."""
_SURFACE_TO_AXIS_M = 0.12
"""From the surface that is seen to the axis of the body."""
_TALLEST_M, _LOWEST_TOP_M = 2.2, 0.45
_WIDEST_M, _NARROWEST_M = 1.3, 0.1
_PERSON_M = 0.35
"""Two people are at least so far apart."""
_SPLIT_WIDTH_M = 0.9
"""Wider than one body mostly is: two people side by side if there is a gap between them."""

_SURE_FACING = 0.35
"""Length of the mean facing below which the body could face any way."""


@dataclasses.dataclass(frozen=True)
class Sighting:
    """A person, probably, in one look."""

    place_xz: FloatArray
    """Axis of the body on the plan, in the robot's starting frame, metres, `(2,)`."""
    height_m: float
    """Highest point that is seen, above the floor."""
    width_m: float
    """Across the line of sight, of what is seen."""
    distance_m: float
    """From the camera, on the plan."""
    bearing: float
    """From where the robot looks, radians, counter-clockwise from above."""
    confidence: float
    """In [0, 1]."""
    moved: bool
    """Whether something there changed while the robot watched from one spot."""
    facing_yaw: float | None
    """Where the body faces, as `Observation.yaw`; `None` if it cannot be told."""
    cut: bool
    """Whether the border of the image cuts the person off, at a side or the top."""


class PersonFinder:
    """Finds people look by look; remembers the last looks from the spot it stands on."""

    def __init__(self, network: PersonNetwork | None = None) -> None:
        """Starts with nothing seen.

        Args:
            network: The one the package ships if not given.
        """
        self._network = load_person_network() if network is None else network
        self._changes = ChangeMemory()
        self._pixels: BoolArray | None = None

    @property
    def person_pixels(self) -> BoolArray | None:
        """Pixels of the last look that belong to people: the map leaves them out."""
        return self._pixels

    def update(self, observation: Observation, *, compared: bool = True) -> tuple[Sighting, ...]:
        """The people in a look, the surest first.

        Args:
            observation: The look.
            compared: Whether it is compared with earlier ones, and kept for later ones.
        """
        small = _small(observation)
        heat = find_people(
            self._network, small.rgb, small.depth, small.camera, small.camera_height_m
        )
        changed = self._changes.changed(small) if compared else None
        moved = np.zeros((CELLS, CELLS), np.float32) if changed is None else _in_cells(changed)
        unseen = (1.0 - heat.share) * (1.0 - np.float32(_MOVED_WEIGHT) * moved)
        evidence = np.asarray(1.0 - unseen, np.float32)
        points = _Points.of(small)
        found, pixels = [], np.zeros((_SIZE, _SIZE), bool)
        for body in _bodies(evidence, points):
            sighting = _sighting(body, evidence, moved, heat, points, observation)
            if sighting is not None:
                found.append(sighting)
                pixels |= body
        shape = observation.depth.shape
        grown = cv2.dilate(pixels.astype(np.uint8), np.ones((5, 5), np.uint8))
        self._pixels = cv2.resize(grown, (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST) > 0
        return _apart(sorted(found, key=lambda one: -one.confidence))


def _small(observation: Observation) -> Observation:
    """The same with images `(112, 112)`, which every witness wants, and the camera as it is."""
    size = (_SIZE, _SIZE)
    rgb = cv2.resize(observation.rgb, size, interpolation=cv2.INTER_AREA)
    depth = cv2.resize(observation.depth, size, interpolation=cv2.INTER_NEAREST)
    return dataclasses.replace(
        observation, rgb=np.asarray(rgb, np.uint8), depth=np.asarray(depth, np.float32)
    )


def _apart(sightings: list[Sighting]) -> tuple[Sighting, ...]:
    """Without the less sure of those that stand where only one person can."""
    kept: list[Sighting] = []
    for one in sightings:
        if all(math.dist(one.place_xz, other.place_xz) > _PERSON_M for other in kept):
            kept.append(one)
    return tuple(kept)


@dataclasses.dataclass(frozen=True)
class _Points:
    """Where the pixels of the measured image are, in the camera's own upright frame."""

    right: NDArray[np.float32]
    """Metres, `(112, 112)`, as the others."""
    height: NDArray[np.float32]
    """Above the floor."""
    depth: NDArray[np.float32]
    """`inf` where nothing was hit."""

    @classmethod
    def of(cls, observation: Observation) -> _Points:
        """Those of an observation that is `_small`."""
        depth = observation.depth
        across, down = _slopes(observation.camera)
        near = np.minimum(depth, 30.0)
        height = np.float32(observation.camera_height_m) - down[:, None] * near
        return cls(across * near, height, np.asarray(depth, np.float32))


def _in_cells(mask: BoolArray) -> NDArray[np.float32]:
    """Share of each cell that a mask of pixels holds, `(28, 28)`."""
    share = cv2.resize(mask.astype(np.float32), (CELLS, CELLS), interpolation=cv2.INTER_AREA)
    return np.asarray(share, np.float32)


def _slopes(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    along = ((np.arange(_SIZE) + 0.5) / _SIZE * 2.0 - 1.0).astype(np.float32)
    return along * math.tan(camera.hfov / 2.0), along * math.tan(camera.vfov / 2.0)


def _bodies(evidence: NDArray[np.float32], points: _Points) -> list[BoolArray]:
    """Pixels of each body, `(112, 112)`: hot cells that touch, parted by depth and by gaps."""
    count, labels = cv2.connectedComponents((evidence > _HOT).astype(np.uint8), connectivity=8)
    found = []
    for number in range(1, count):
        cells = np.where(labels == number, evidence, 0.0).astype(np.float32)
        hot = cv2.resize(cells, (_SIZE, _SIZE), interpolation=cv2.INTER_LINEAR)
        pixels = np.asarray(hot > 0.75 * _HOT)
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
    return _median(depth[np.abs(depth - middle) < 1.5 * _DEPTH_BIN_M])


def _median(values: NDArray[np.float32]) -> float:
    """As `np.median`, at a fraction of its cost; `nan` for none."""
    if not len(values):
        return math.nan
    below, above = (len(values) - 1) // 2, len(values) // 2
    parted = np.partition(values, (below, above))
    return float((parted[below] + parted[above]) * np.float32(0.5))


def _span(values: NDArray[np.float32]) -> tuple[np.float64, np.float64]:
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


def _parted(body: BoolArray, points: _Points) -> list[BoolArray]:
    """One body, or two where it is too wide for one and there is a gap or a waist between them."""
    right = points.right[body]
    low, high = _span(right)
    if high - low < _SPLIT_WIDTH_M:
        return [body]
    counts, edges = np.histogram(right, bins=12, range=(low, high))
    middle = 3 + int(counts[3:9].argmin())
    if counts[middle] > 0.4 * min(counts[:middle].max(), counts[middle + 1 :].max()):
        return [body]
    gap = 0.5 * (edges[middle] + edges[middle + 1])
    parts = [body & (points.right < gap), body & (points.right >= gap)]
    return [part for part in parts if part.sum() >= _MIN_PIXELS] or [body]


def _sighting(
    body: BoolArray,
    evidence: NDArray[np.float32],
    moved: NDArray[np.float32],
    heat: PersonHeat,
    points: _Points,
    observation: Observation,
) -> Sighting | None:
    """What a body is like; `None` if it is too high, flat, wide or thin for a person."""
    cells = _in_cells(body)
    right, height = points.right[body], points.height[body]
    top = float(np.percentile(height, 98))
    low, high = _span(right)
    width = float(high - low)
    if not (_LOWEST_TOP_M <= top <= _TALLEST_M and _NARROWEST_M <= width <= _WIDEST_M):
        return None
    depth, across = _median(points.depth[body]), _median(right)
    reach = math.hypot(depth, across)
    scale = 1.0 + _SURFACE_TO_AXIS_M / reach
    place = _on_plan(observation, scale * across, scale * depth)
    hot = cells * (evidence > _HOT)
    weight = max(float(hot.sum()), 1e-6)
    rows, columns = np.nonzero(body)
    return Sighting(
        place_xz=place,
        height_m=top,
        width_m=width,
        distance_m=scale * reach,
        bearing=-math.atan2(across, depth),
        confidence=_confidence(hot, evidence),
        moved=bool((hot * moved).sum() / weight > 0.08),
        facing_yaw=_facing_yaw(hot, heat, observation, place),
        cut=bool(columns.min() <= 1 or columns.max() >= _SIZE - 2 or rows.min() <= 1),
    )


def _confidence(hot: NDArray[np.float32], evidence: NDArray[np.float32]) -> float:
    """Mean evidence of the surer half of a body's cells."""
    values = np.sort(evidence[hot > 0.3]) if (hot > 0.3).any() else np.sort(evidence[hot > 0.0])
    return float(values[len(values) // 2 :].mean()) if len(values) else 0.0


def _facing_yaw(
    hot: NDArray[np.float32], heat: PersonHeat, observation: Observation, place: FloatArray
) -> float | None:
    weight = hot * heat.share
    total = float(weight.sum())
    if total < 1e-3:
        return None
    cosine, sine = (float((weight * part).sum()) / total for part in heat.facing)
    if math.hypot(cosine, sine) < _SURE_FACING:
        return None
    to_camera = place - observation.position[[0, 2]]
    return math.remainder(
        math.atan2(to_camera[0], to_camera[1]) + math.atan2(sine, cosine), 2 * math.pi
    )


def _on_plan(observation: Observation, right: float, ahead: float) -> FloatArray:
    """A point so far to the right and ahead of the robot, in its starting frame, `(2,)`."""
    cosine, sine = math.cos(observation.yaw), math.sin(observation.yaw)
    x, _, z = observation.position
    return np.array([x + cosine * right - sine * ahead, z - sine * right - cosine * ahead])
