"""Follows one person through the sightings of many looks."""

from __future__ import annotations

import collections
import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from affectsim_data.poses import FloatArray
from affectsim_data.simulation.policies.scan_search_follow.seeing import Sighting
from affectsim_data.simulation.running import Observation

__all__ = ["WALKING_M_PER_S", "PersonTrack", "turned_from"]

_LOOKS, _NEEDED = 4, 3
"""Stable: seen in so many of the last looks, all near to each other."""
_STABLE_M = 0.5
_GATE_M = 0.8
"""A sighting this near to where the person was last is theirs."""
_WALK_M_PER_S = 1.5
"""By how much the gate grows for every second the person was not seen."""
_SURE = 0.5
"""A track begins with a sighting this sure; a weaker one may go on with it."""
_MEMORY_S = 3.0
"""Looks that speed and facing are estimated over."""
_LOST_S = 8.0
"""After so long unseen any person will do."""
_FALSE_LOOKS = 3
"""So often not seen, though in plain view, and it was nobody."""
_SWITCH_GAIN = 0.25
_ASIDE = 0.3
"""What a radian off where the robot was turned at first counts against a sighting."""
WALKING_M_PER_S = 0.35
"""Faster than this a person walks, and faces where they go."""


@dataclasses.dataclass(frozen=True)
class _Look:
    time_s: float
    place_xz: FloatArray
    facing_yaw: float | None
    confidence: float


class PersonTrack:
    """Where one person is: of several the surest and nearest, ahead of where the robot started.

    Once begun, a track stays with its person.
    """

    def __init__(self) -> None:
        self._looks: collections.deque[_Look] = collections.deque()
        self._recent: collections.deque[FloatArray | None] = collections.deque(maxlen=_LOOKS)
        self._missed = 0
        self._was_stable = False

    @property
    def place_xz(self) -> FloatArray | None:
        """Where the person was when last seen, in the robot's starting frame, metres, `(2,)`."""
        return self._looks[-1].place_xz if self._looks else None

    @property
    def last_seen_s(self) -> float | None:
        """When the person was seen last, `None` if never."""
        return self._looks[-1].time_s if self._looks else None

    @property
    def confidence(self) -> float:
        """Mean confidence of the last looks that saw the person, 0 for none, in [0, 1]."""
        last = [look.confidence for look in self._looks][-_LOOKS:]
        return sum(last) / len(last) if last else 0.0

    @property
    def is_stable(self) -> bool:
        """Whether three of the last four looks saw the person within half a metre."""
        places = [place for place in self._recent if place is not None]
        if len(places) < _NEEDED:
            return False
        middle = np.median(places, axis=0)
        near = np.hypot(*(np.array(places) - middle).T) <= _STABLE_M
        return int(near.sum()) >= _NEEDED

    @property
    def speed(self) -> float:
        """Metres per second over the last seconds, 0 if it cannot be told."""
        return float(np.hypot(*self._velocity()))

    @property
    def facing_yaw(self) -> float | None:
        """Where the person faces, as `Observation.yaw`, `None` if it cannot be told.

        From what their body looks like in the last look that tells it; else, when they walk, from
        where they go.
        """
        if not self._looks:
            return None
        if self._looks[-1].facing_yaw is not None:
            return self._looks[-1].facing_yaw
        velocity = self._velocity()
        if np.hypot(*velocity) >= WALKING_M_PER_S:
            return math.atan2(-velocity[0], -velocity[1])
        known = [look.facing_yaw for look in self._looks if look.facing_yaw is not None]
        return known[-1] if known else None

    def update(self, sightings: Sequence[Sighting], observation: Observation) -> None:
        """Takes in one look."""
        now = observation.time_s
        chosen = self._chosen(sightings, now)
        self._recent.append(None if chosen is None else chosen.place_xz)
        if chosen is None:
            self._count_miss(observation)
            return
        self._missed = 0
        self._looks.append(_Look(now, chosen.place_xz, chosen.facing_yaw, chosen.confidence))
        while self._looks[0].time_s < now - _MEMORY_S:
            self._looks.popleft()
        self._was_stable |= self.is_stable

    def _chosen(self, sightings: Sequence[Sighting], now: float) -> Sighting | None:
        last = self._looks[-1] if self._looks else None
        surest = max((one.confidence for one in sightings), default=0.0)
        # A track that went over to a thing gives way to somebody surer beside it.
        least = surest - _SWITCH_GAIN if self.confidence < surest - _SWITCH_GAIN else 0.0
        if last is not None and now - last.time_s <= _LOST_S:
            gate = _GATE_M + _WALK_M_PER_S * (now - last.time_s)
            near = [
                (math.dist(one.place_xz, last.place_xz), -one.confidence, place)
                for place, one in enumerate(sightings)
                if math.dist(one.place_xz, last.place_xz) <= gate and one.confidence >= least
            ]
            if near:
                return sightings[min(near)[2]]
        sure = [
            (-_worth(one), place) for place, one in enumerate(sightings) if one.confidence >= _SURE
        ]
        if not sure:
            return None
        best = sightings[min(sure)[1]]
        # Another person takes over only from one who is gone, or was hardly one.
        if last is not None and now - last.time_s <= _LOST_S:
            weak = self.confidence < best.confidence - _SWITCH_GAIN
            if not weak and len(self._looks) >= _NEEDED:
                return None
            self._looks.clear()
            self._recent.clear()
            self._was_stable = False
        return best

    def _count_miss(self, observation: Observation) -> None:
        """Forgets somebody who should be seen and is not: a chair that looked like a person."""
        if not self._looks or self._was_stable:
            return
        away = self._looks[-1].place_xz - observation.position[[0, 2]]
        ahead = math.atan2(-away[0], -away[1])
        off = abs(math.remainder(ahead - observation.yaw, 2 * math.pi))
        if off < 0.35 * observation.camera.hfov and 0.8 < float(np.hypot(*away)) < 6.0:
            self._missed += 1
        if self._missed >= _FALSE_LOOKS:
            self._looks.clear()
            self._missed = 0

    def _velocity(self) -> FloatArray:
        """Of the place, metres per second, `(2,)`: a straight line through the last looks."""
        last = [look for look in self._looks if look.time_s > self._looks[-1].time_s - 1.3]
        if len(last) < _NEEDED:
            return np.zeros(2)
        times = np.array([look.time_s for look in last])
        places = np.array([look.place_xz for look in last])
        times -= times.mean()
        return np.asarray(times @ (places - places.mean(axis=0)) / (times @ times))


def _worth(sighting: Sighting) -> float:
    """What speaks for a sighting among several: sure, seen to move, near, ahead of the start."""
    ahead = -_ASIDE * turned_from(sighting.place_xz)
    return sighting.confidence + 0.2 * sighting.moved - 0.03 * sighting.distance_m + ahead


def turned_from(place_xz: FloatArray) -> float:
    """Radians between a place `(2,)` and where the robot was turned at first, seen from there."""
    return abs(math.atan2(-place_xz[0], -place_xz[1]))
