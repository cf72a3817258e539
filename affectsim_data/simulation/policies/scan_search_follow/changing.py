"""Which pixels show something that moved, while the robot stands on one spot and turns."""

from __future__ import annotations

import collections
import dataclasses
import math

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


@dataclasses.dataclass(frozen=True)
class _Look:
    yaw: float
    low: NDArray[np.float32]
    """Smallest depth and colours around each pixel, `(112, 112, 4)`."""
    high: NDArray[np.float32]
    """The greatest."""


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
        image = _stacked(observation)
        old = [
            look
            for look in self._looks
            if abs(math.remainder(observation.yaw - look.yaw, 2 * math.pi)) <= _OVERLAP
        ][-_COMPARED:]
        masks = [_came(image, look, observation) for look in old]
        kernel = np.ones((3, 3), np.uint8)
        low, high = (grow(image, kernel) for grow in (cv2.erode, cv2.dilate))
        self._looks.append(
            _Look(observation.yaw, np.asarray(low, np.float32), np.asarray(high, np.float32))
        )
        return np.logical_or.reduce(masks) if masks else None


def _stacked(observation: Observation) -> NDArray[np.float32]:
    """Range over the floor plane and colours, `(112, 112, 4)`."""
    size = (CHANGE_SIZE, CHANGE_SIZE)
    depth = cv2.resize(observation.depth, size, interpolation=cv2.INTER_NEAREST)
    rgb = cv2.resize(observation.rgb, size, interpolation=cv2.INTER_AREA)
    across, _ = _rays(observation.camera)
    # Along the ray, so that turning does not change it.
    reach = np.minimum(depth, 30.0) * np.sqrt(1.0 + across**2)
    return np.concatenate([reach[..., None], rgb], axis=2, dtype=np.float32)


def _came(image: NDArray[np.float32], look: _Look, observation: Observation) -> NDArray[np.bool_]:
    """Pixels of the image that hold something an earlier look did not."""
    across, down = _rays(observation.camera)
    turned = observation.yaw - look.yaw
    ahead = across * math.sin(turned) + math.cos(turned)
    half_x = math.tan(observation.camera.hfov / 2.0)
    half_y = math.tan(observation.camera.vfov / 2.0)
    scale = CHANGE_SIZE / 2.0
    x = (across * math.cos(turned) - math.sin(turned)) / ahead
    u = np.broadcast_to((x / half_x + 1.0) * scale - 0.5, (CHANGE_SIZE, CHANGE_SIZE))
    v = (down[:, None] / ahead / half_y + 1.0) * scale - 0.5
    u, v = np.ascontiguousarray(u, np.float32), np.ascontiguousarray(v, np.float32)
    inside = (u > 0.5) & (u < CHANGE_SIZE - 1.5) & (v > 0.5) & (v < CHANGE_SIZE - 1.5)
    low = cv2.remap(look.low, u, v, cv2.INTER_NEAREST)
    high = cv2.remap(look.high, u, v, cv2.INTER_NEAREST)
    reach = image[..., 0]
    nearer = reach < low[..., 0] * (1.0 - _NEARER) - _NEARER_M
    farther = reach > high[..., 0] * (1.0 + _NEARER) + _NEARER_M
    below, above = low[..., 1:] - image[..., 1:], image[..., 1:] - high[..., 1:]
    recolored = (np.maximum(below, above) > _COLOR).any(axis=2)
    return np.asarray(inside & (nearer | (recolored & ~farther)))


def _rays(camera: Camera) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Metres to the right and down per metre of depth, of the columns and rows, `(112,)` each."""
    along = ((np.arange(CHANGE_SIZE) + 0.5) / CHANGE_SIZE * 2.0 - 1.0).astype(np.float32)
    return along * math.tan(camera.hfov / 2.0), along * math.tan(camera.vfov / 2.0)
