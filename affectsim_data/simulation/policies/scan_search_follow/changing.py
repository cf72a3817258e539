"""Which pixels show something that moved, while the robot stands on one spot and turns."""

from __future__ import annotations

import collections
import dataclasses
import functools
import math
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.cameras import Camera
from affectsim_data.poses import FloatArray
from affectsim_data.simulation.running import Observation

__all__ = ["CHANGE_SIZE", "ChangeMemory"]

CHANGE_SIZE = 112
"""Side of the square mask of changes, pixels."""
_KEPT_LOOKS = 30
"""Looks remembered at one spot: a whole turn and a little more."""
_COMPARED = 4
"""Of these, at most so many are compared with a new one: the latest that overlap enough."""
_OVERLAP = math.radians(31.0)
_SPOT_M = 0.01
_NEARER, _NEARER_M = 0.02, 0.06
"""Depth that is smaller than before by this share and this much is something that came."""
_COLOR = 28
"""Difference of a colour, of 255, that is a change of what is there and not of its light."""
_NO_MAP = np.empty(0, np.int16)
"""Whole pixels need no second map."""
_Number = TypeVar("_Number", np.float32, np.uint8)


@dataclasses.dataclass(frozen=True)
class _Image:
    """A look, small."""

    reach: NDArray[np.float32]
    """Range over the floor plane, metres, `(112, 112)`."""
    rgb: NDArray[np.uint8]
    """`(112, 112, 3)`."""


@dataclasses.dataclass(frozen=True)
class _Look:
    """What may be seen later from the same spot without being a change."""

    yaw: float
    nearest: NDArray[np.float32]
    """Range below which something came, `(112, 112)`."""
    farthest: NDArray[np.float32]
    """Range above which something went."""
    darkest: NDArray[np.uint8]
    """Colours from which on nothing changed, `(112, 112, 3)`."""
    brightest: NDArray[np.uint8]
    """Colours up to which nothing changed."""

    @classmethod
    def of(cls, image: _Image, yaw: float) -> _Look:
        kernel = np.ones((3, 3), np.uint8)
        low, high = cv2.erode(image.reach, kernel), cv2.dilate(image.reach, kernel)
        allowed = np.full(image.rgb.shape, _COLOR, np.uint8)
        return cls(
            yaw,
            np.asarray(low * (1.0 - _NEARER) - _NEARER_M, np.float32),
            np.asarray(high * (1.0 + _NEARER) + _NEARER_M, np.float32),
            # Both stop at the ends of the range, which no colour is beyond.
            np.asarray(cv2.subtract(cv2.erode(image.rgb, kernel), allowed), np.uint8),
            np.asarray(cv2.add(cv2.dilate(image.rgb, kernel), allowed), np.uint8),
        )


class ChangeMemory:
    """Compares looks from one spot with each other, warped by how far the robot turned.

    The camera turns about its own centre, so what stands still stays on its ray: no map is needed.
    A pixel counts as changed where it lies outside all that was around it before, which forgives
    edges their pixel; what only came into sight behind a person that left does not count.
    """

    def __init__(self) -> None:
        self._looks: collections.deque[_Look] = collections.deque(maxlen=_KEPT_LOOKS)
        self._spot: FloatArray = np.full(2, np.inf)

    def changed(self, observation: Observation) -> NDArray[np.bool_] | None:
        """Pixels that something moved into, `(112, 112)`; `None` if there is nothing to compare.

        The look is kept for later ones.
        """
        here = observation.position[[0, 2]]
        if np.abs(here - self._spot).max() > _SPOT_M:
            self._looks.clear()
            self._spot = here.copy()
        image = _small(observation)
        old = [
            look
            for look in self._looks
            if abs(math.remainder(observation.yaw - look.yaw, 2 * math.pi)) <= _OVERLAP
        ][-_COMPARED:]
        masks = [_came(image, look, observation) for look in old]
        self._looks.append(_Look.of(image, observation.yaw))
        return np.logical_or.reduce(masks) if masks else None


def _small(observation: Observation) -> _Image:
    size = (CHANGE_SIZE, CHANGE_SIZE)
    depth = cv2.resize(observation.depth, size, interpolation=cv2.INTER_NEAREST)
    rgb = cv2.resize(observation.rgb, size, interpolation=cv2.INTER_AREA)
    across, _ = _rays(observation.camera)
    # Along the ray, so that turning does not change it.
    reach = np.minimum(depth, 30.0) * np.sqrt(1.0 + across**2)
    return _Image(np.asarray(reach, np.float32), np.asarray(rgb, np.uint8))


def _came(image: _Image, look: _Look, observation: Observation) -> NDArray[np.bool_]:
    """Pixels of the image that hold something an earlier look did not."""
    places, inside = _warp(observation.camera, observation.yaw - look.yaw)

    def before(values: NDArray[_Number]) -> NDArray[_Number]:
        return np.asarray(cv2.remap(values, places, _NO_MAP, cv2.INTER_NEAREST), values.dtype)

    same_color = cv2.inRange(image.rgb, before(look.darkest), before(look.brightest))
    came = (image.reach < before(look.nearest)) | (same_color == 0)
    came &= image.reach <= before(look.farthest)
    came &= inside
    return np.asarray(came)


@functools.lru_cache(maxsize=64)
def _warp(camera: Camera, turned: float) -> tuple[NDArray[np.int16], NDArray[np.bool_]]:
    """Where pixels were before the robot turned, `(112, 112, 2)`, and which were in the image."""
    across, down = _rays(camera)
    ahead = across * math.sin(turned) + math.cos(turned)
    half_x = math.tan(camera.hfov / 2.0)
    half_y = math.tan(camera.vfov / 2.0)
    scale = CHANGE_SIZE / 2.0
    x = (across * math.cos(turned) - math.sin(turned)) / ahead
    u = np.broadcast_to((x / half_x + 1.0) * scale - 0.5, (CHANGE_SIZE, CHANGE_SIZE))
    v = (down[:, None] / ahead / half_y + 1.0) * scale - 0.5
    u, v = np.ascontiguousarray(u, np.float32), np.ascontiguousarray(v, np.float32)
    inside = (u > 0.5) & (u < CHANGE_SIZE - 1.5) & (v > 0.5) & (v < CHANGE_SIZE - 1.5)
    places, _ = cv2.convertMaps(u, v, cv2.CV_16SC2, nninterpolation=True)
    return np.asarray(places, np.int16), np.asarray(inside)


@functools.lru_cache(maxsize=8)
def _rays(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Metres to the right and down per metre of depth, of the columns and rows, `(112,)` each."""
    along = ((np.arange(CHANGE_SIZE) + 0.5) / CHANGE_SIZE * 2.0 - 1.0).astype(np.float32)
    return along * math.tan(camera.hfov / 2.0), along * math.tan(camera.vfov / 2.0)
