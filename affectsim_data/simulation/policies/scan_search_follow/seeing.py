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

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.bodies import (
    HOT,
    IMAGE_SIZE,
    ImagePoints,
    bodies_in,
    median,
    span,
)
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

_MOVED_WEIGHT = 0.5
"""Evidence of a cell in which everything changed, if the network sees nobody there."""
_SURFACE_TO_AXIS_M = 0.12
"""From the surface that is seen to the axis of the body."""
_TALLEST_M, _LOWEST_TOP_M = 2.2, 0.45
_WIDEST_M, _NARROWEST_M = 1.3, 0.1
_PERSON_M = 0.35
"""Two people are at least so far apart."""

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
        points = ImagePoints.of(small)
        found, pixels = [], np.zeros((IMAGE_SIZE, IMAGE_SIZE), bool)
        for body in bodies_in(evidence, points):
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
    size = (IMAGE_SIZE, IMAGE_SIZE)
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


def _in_cells(mask: BoolArray) -> NDArray[np.float32]:
    """Share of each cell that a mask of pixels holds, `(28, 28)`."""
    share = cv2.resize(mask.astype(np.float32), (CELLS, CELLS), interpolation=cv2.INTER_AREA)
    return np.asarray(share, np.float32)


def _sighting(
    body: BoolArray,
    evidence: NDArray[np.float32],
    moved: NDArray[np.float32],
    heat: PersonHeat,
    points: ImagePoints,
    observation: Observation,
) -> Sighting | None:
    """What a body is like; `None` if it is too high, flat, wide or thin for a person."""
    cells = _in_cells(body)
    right, height = points.right[body], points.height[body]
    top = float(np.percentile(height, 98))
    low, high = span(right)
    width = float(high - low)
    if not (_LOWEST_TOP_M <= top <= _TALLEST_M and _NARROWEST_M <= width <= _WIDEST_M):
        return None
    depth, across = median(points.depth[body]), median(right)
    reach = math.hypot(depth, across)
    scale = 1.0 + _SURFACE_TO_AXIS_M / reach
    place = _on_plan(observation, scale * across, scale * depth)
    hot = cells * (evidence > HOT)
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
        cut=bool(columns.min() <= 1 or columns.max() >= IMAGE_SIZE - 2 or rows.min() <= 1),
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
