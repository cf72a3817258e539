"""Whether what looks like a person lives: the same view is another one a moment later."""

from __future__ import annotations

import dataclasses
import math

import cv2
import numpy as np
from numpy.typing import NDArray

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.actions import TURN
from affectsim_data.simulation.running import Observation

__all__ = ["LifeSigns"]

_SAME_SPOT_M, _SAME_YAW = 1e-3, 1e-3
_COLOR = 24
"""Difference of a colour, of 255, that is more than noise."""
_SHARE = 0.01
"""Of the pixels of a person, so many change at least."""
_LEAST_PIXELS = 8
_HALF_WIDTH = math.radians(14.0)
"""Pixels that far beside a person count as theirs: an arm at a distance of 2 m."""


@dataclasses.dataclass(frozen=True, eq=False)
class _View:
    yaw: float
    rgb: NDArray[np.uint8]


class LifeSigns:
    """Compares looks from the very same pose with each other; only people change between them.

    A robot that sways to and fro comes back to each of its poses every half a second. Unlike the
    search for movement while it turns, this needs no warping and sees a hand that knocks.
    """

    def __init__(self) -> None:
        self._spot: FloatArray = np.full(2, np.inf)
        self._views: dict[int, _View] = {}
        self._changed: NDArray[np.bool_] | None = None

    def take_in(self, observation: Observation) -> None:
        """One look."""
        here = observation.position[[0, 2]]
        if np.abs(here - self._spot).max() > _SAME_SPOT_M:
            self._views.clear()
            self._spot = here.copy()
        key = round(observation.yaw / TURN)
        before = self._views.get(key)
        self._views[key] = _View(observation.yaw, observation.rgb)
        self._changed = None
        if before is not None and abs(before.yaw - observation.yaw) < _SAME_YAW:
            difference = cv2.absdiff(observation.rgb, before.rgb)
            self._changed = cv2.inRange(difference, (0, 0, 0), (_COLOR, _COLOR, _COLOR)) == 0

    def seen_in(
        self, pixels: NDArray[np.bool_] | None, bearing: float, observation: Observation
    ) -> bool:
        """Whether somebody moved since the robot last looked from this pose.

        Args:
            pixels: Those that belong to people, `(height, width)`.
            bearing: Of the one who is asked about, radians to the left.
            observation: The look that was taken in last.
        """
        if self._changed is None or pixels is None:
            return False
        camera = observation.camera
        across = (np.arange(camera.width) + 0.5) / camera.width * 2.0 - 1.0
        columns = -np.arctan(across * math.tan(camera.hfov / 2.0))
        theirs = pixels & (np.abs(columns - bearing) < _HALF_WIDTH)
        changed = int(np.count_nonzero(theirs & self._changed))
        return changed >= max(_LEAST_PIXELS, _SHARE * int(np.count_nonzero(theirs)))
