"""What is known of a person over the last seconds: where they were and which way they faced."""

from __future__ import annotations

import collections
import dataclasses
import math

import numpy as np

from affectsim_data.poses import FloatArray

__all__ = ["PersonCourse"]

_NEAR_M = 2.5
_UNKNOWN_LOOKS = 3.0
_FACING_MEMORY_S = 7.0
_WALKS_M = 0.4
"""Who goes farther than this from the middle walks."""
_APART_M = 0.25
_MEMORY_S = 10.0
"""About as long as the longest motion cycle: after it, older looks say nothing new."""
_LOOKS_OF_WAY, _LONGEST_MEMORY_S = 24, 25.0
"""Of somebody who walks about at least so many are kept, for longer."""


@dataclasses.dataclass(frozen=True, eq=False)
class _Look:
    time_s: float
    place_xz: FloatArray
    weight: float
    """Of the facing."""
    facing: complex
    height_m: float | None


class PersonCourse:
    """Places, facings and heights of one person, look by look.

    A motion repeats, so its past is its future.

    Places are `(2,)`, x and z, and yaws 0 along -Z and counter-clockwise, all in the robot's
    starting frame.
    """

    def __init__(self) -> None:
        self._looks: collections.deque[_Look] = collections.deque()

    def __len__(self) -> int:
        return len(self._looks)

    def add(
        self,
        time_s: float,
        place_xz: FloatArray,
        facing_yaw: float | None,
        distance_m: float,
        height_m: float | None = None,
    ) -> None:
        """Remembers one look; those older than some seconds are forgotten.

        Args:
            time_s: Of the look, rising from call to call.
            place_xz: Where the person stood, `(2,)`.
            facing_yaw: Which way they faced, `None` if that could not be told.
            distance_m: From where; a face is told from a back by a few pixels, so near looks
                count more.
            height_m: Of their highest point above the floor, `None` if that was not seen.
        """
        weight = 0.0 if facing_yaw is None else min(_NEAR_M / max(distance_m, 0.1), 1.0) ** 4
        yaw = facing_yaw or 0.0
        facing = complex(math.cos(yaw), math.sin(yaw))
        place = np.asarray(place_xz, np.float64)
        self._looks.append(_Look(time_s, place, weight, facing, height_m))
        # Who walks about goes on along the same way, whether it is looked at or not.
        least = _LOOKS_OF_WAY if self.walks else 1
        while self._looks[0].time_s < time_s - _MEMORY_S and (
            len(self) > least or self._looks[0].time_s < time_s - _LONGEST_MEMORY_S
        ):
            self._looks.popleft()

    @property
    def _places(self) -> FloatArray:
        """`(n, 2)`."""
        return np.array([look.place_xz for look in self._looks])

    @property
    def height_m(self) -> float | None:
        """Mean height of the person's highest point: of who sits less than of who stands."""
        heights = [look.height_m for look in self._looks if look.height_m is not None]
        return sum(heights) / len(heights) if heights else None

    @property
    def center_xz(self) -> FloatArray:
        """Middle of the places, `(2,)`: of their bounds, so that standing long does not weigh."""
        places = self._places
        middle: FloatArray = (places.min(axis=0) + places.max(axis=0)) / 2.0
        return middle

    @property
    def reach_m(self) -> float:
        """How far from the middle the person goes."""
        return float(np.hypot(*(self._places - self.center_xz).T).max())

    @property
    def walks(self) -> bool:
        """Whether the person goes about."""
        return len(self) > 0 and self.reach_m > _WALKS_M

    @property
    def trodden_xz(self) -> FloatArray:
        """Places along the way of somebody who walks, `(n, 2)`; none of who stays about."""
        if not self.walks:
            return np.zeros((0, 2))
        cells = np.unique(np.round(self._places / _APART_M), axis=0)
        return np.asarray(cells * _APART_M)

    @property
    def facing(self) -> complex:
        """Mean of the facings as unit vectors, `cos + i sin` of the yaw; shorter the less sure or
        the more the person turns, 0 if nothing is known."""
        # Few looks are weak evidence: the mean is drawn towards nothing as if by some unknown ones.
        since_s = self._looks[-1].time_s - _FACING_MEMORY_S if self._looks else 0.0
        looks = [look for look in self._looks if look.time_s >= since_s]
        total = _UNKNOWN_LOOKS + sum(look.weight for look in looks)
        return sum((look.weight * look.facing for look in looks), 0j) / total
